//! Where the zero of the coordinates is: work offsets G54 …, G10 L2 and L20, and what G52 and G92 add to all of them.
//!
//! A work offset is a place for the workpiece frame W. Only how they stand to one another matters: the one that the program
//! uses first is W, unless its zero is given.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use crate::toolpath::model::gcode::{Fault, GcodeOptions, Known, WorkOffset};

/// The zeros of all coordinates, mm, as far as they are known.
#[derive(Debug)]
pub(crate) struct Offsets {
    active: WorkOffset,
    /// Zeros in the workpiece frame.
    zeros: BTreeMap<WorkOffset, Known>,
    /// Zeros in machine coordinates, as G10 L2 gives them.
    in_machine: BTreeMap<WorkOffset, Known>,
    /// The zero of the machine in the workpiece frame.
    machine: Known,
    /// Axes along which a work offset is tied to the workpiece frame.
    is_tied: [bool; 3],
    /// Axes along which a coordinate was read with a zero.
    used: BTreeMap<WorkOffset, [bool; 3]>,
    local: Vector3<f64>,
    shift: Vector3<f64>,
    suspended: Vector3<f64>,
    /// Axes whose first origin came of G92 at an unknown place: without it, they have none.
    by_shift_alone: [bool; 3],
}

impl Offsets {
    pub fn new(options: &GcodeOptions) -> Offsets {
        let mut zeros: BTreeMap<WorkOffset, Known> =
            options.work_offsets_mm.iter().map(|(offset, zero)| (*offset, [0, 1, 2].map(|k| Some(zero[k])))).collect();
        let is_tied = !zeros.is_empty() || options.start_mm.is_some();
        if is_tied {
            zeros.entry(WorkOffset::G54).or_insert([Some(0.0); 3]);
        }
        Offsets {
            active: WorkOffset::G54,
            zeros,
            in_machine: BTreeMap::new(),
            machine: [None; 3],
            is_tied: [is_tied; 3],
            used: BTreeMap::new(),
            local: Vector3::zeros(),
            shift: Vector3::zeros(),
            suspended: Vector3::zeros(),
            by_shift_alone: [false; 3],
        }
    }

    pub fn activate(&mut self, offset: WorkOffset) {
        self.active = offset;
    }

    /// The one in force.
    pub fn active(&self) -> WorkOffset {
        self.active
    }

    /// Zero of the coordinates in force, mm in the workpiece frame.
    pub fn origin(&mut self) -> Result<Vector3<f64>, Fault> {
        let zero = self.zero(self.active)?;
        Ok(zero + self.local + self.shift)
    }

    /// Zero of `offset`; the first one asked for is that of the workpiece.
    fn zero(&mut self, offset: WorkOffset) -> Result<Vector3<f64>, Fault> {
        let mut zero = Vector3::zeros();
        for axis in 0..3 {
            zero[axis] = self.tie(offset, axis).ok_or(Fault::NoWorkOffset { offset })?;
        }
        Ok(zero)
    }

    fn tie(&mut self, offset: WorkOffset, axis: usize) -> Option<f64> {
        let in_machine = self.in_machine.get(&offset).and_then(|zero| zero[axis]);
        let zero = &mut self.zeros.entry(offset).or_default()[axis];
        if zero.is_none() {
            *zero = match (self.machine[axis], in_machine) {
                (Some(machine), Some(in_machine)) => Some(machine + in_machine),
                _ => (!self.is_tied[axis]).then_some(0.0),
            };
        }
        let zero = (*zero)?;
        self.is_tied[axis] = true;
        self.used.entry(offset).or_default()[axis] = true;
        if let Some(in_machine) = in_machine {
            self.machine[axis].get_or_insert(zero - in_machine);
        }
        Some(zero)
    }

    /// G10 L2: the zero of `offset` is at `value` of the machine.
    pub fn set_in_machine(&mut self, offset: WorkOffset, axis: usize, value: f64) {
        self.in_machine.entry(offset).or_default()[axis] = Some(value);
        let used = self.used.get(&offset).is_some_and(|used| used[axis]);
        let zero = &mut self.zeros.entry(offset).or_default()[axis];
        match (self.machine[axis], *zero) {
            (Some(machine), _) => *zero = Some(machine + value),
            // What is given for it stands for the zero that the program sets.
            (None, Some(zero)) if !used => self.machine[axis] = Some(zero - value),
            (None, _) => *zero = None,
        }
    }

    /// G10 L20: `place` (workpiece frame) has the coordinate `value` in `offset`.
    pub fn set_by_place(&mut self, offset: WorkOffset, axis: usize, place: f64, value: f64) {
        let zero = place - value - self.local[axis] - self.shift[axis];
        self.zeros.entry(offset).or_default()[axis] = Some(zero);
        if let Some(machine) = self.machine[axis] {
            self.in_machine.entry(offset).or_default()[axis] = Some(zero - machine);
        }
        self.is_tied[axis] = true;
    }

    /// G92: `place` (workpiece frame) has the coordinate `value`.
    pub fn shift_to(&mut self, axis: usize, place: f64, value: f64) -> Result<(), Fault> {
        let zero = self.tie(self.active, axis).ok_or(Fault::NoWorkOffset { offset: self.active })?;
        self.shift[axis] = place - zero - self.local[axis] - value;
        Ok(())
    }

    /// G92 where the place is not known and no coordinate was used before: it has the coordinate `value`. That place.
    /// `by_shift`: G92.1 makes it unknown again; G10 L20 lasts.
    pub fn begin_at(&mut self, axis: usize, value: f64, by_shift: bool) -> Result<f64, Fault> {
        let zero = self.tie(self.active, axis).ok_or(Fault::NoWorkOffset { offset: self.active })?;
        self.by_shift_alone[axis] |= by_shift;
        Ok(zero + self.local[axis] + self.shift[axis] + value)
    }

    /// G52: the zero moves to `value` from that of the work offset.
    pub fn set_local(&mut self, axis: usize, value: f64) {
        self.local[axis] = value;
    }

    /// The zero moves on by `value`.
    pub fn add_local(&mut self, axis: usize, value: f64) {
        self.local[axis] += value;
    }

    /// G92.1, G92.2. What G52 has moved goes back as well: to LinuxCNC it is the same shift, and Fanuc presets all of it.
    pub fn end_shift(&mut self, keeps: bool, axes: [bool; 3]) {
        for axis in (0..3).filter(|axis| axes[*axis]) {
            self.suspended[axis] = if keeps { self.shift[axis] } else { 0.0 };
            (self.shift[axis], self.local[axis]) = (0.0, 0.0);
            if std::mem::take(&mut self.by_shift_alone[axis]) {
                // Where the zero is without the shift was never known.
                self.zeros.values_mut().for_each(|zero| zero[axis] = None);
                self.machine[axis] = None;
            }
        }
    }

    /// G92.3.
    pub fn restore_shift(&mut self) {
        self.shift = self.suspended;
    }

    /// Whether G92 has moved the zero.
    pub fn is_shifted(&self) -> bool {
        self.shift != Vector3::zeros() || self.by_shift_alone.contains(&true)
    }

    /// Whether G52 has moved the zero.
    pub fn is_local(&self) -> bool {
        self.local != Vector3::zeros()
    }
}
