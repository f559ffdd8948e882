//! Zeros of the coordinates: work offsets G54 …, G10 L2 and L20, and the shifts of G52 and G92.
//!
//! The first work offset that the program uses is the workpiece frame W, unless its zero is given; others are relative to it.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use crate::model::gcode::{Fault, GcodeOptions, PartialPosition, WorkOffset};

/// Zeros of all work offsets, mm, as far as they are known.
#[derive(Debug)]
pub(crate) struct Offsets {
    active: WorkOffset,
    /// Zeros in the workpiece frame W.
    zeros: BTreeMap<WorkOffset, PartialPosition>,
    /// Zeros in machine coordinates, as G10 L2 sets them.
    in_machine: BTreeMap<WorkOffset, PartialPosition>,
    /// Machine zero in W.
    machine: PartialPosition,
    /// Axes along which some work offset has a known zero in W.
    is_tied: [bool; 3],
    /// Axes along which a coordinate has been read.
    is_used: BTreeMap<WorkOffset, [bool; 3]>,
    /// Shift by G52, shift by G92, and that which G92.2 keeps for G92.3.
    local: Vector3<f64>,
    shift: Vector3<f64>,
    suspended: Vector3<f64>,
    /// Axes whose zero is known only by a G92 at an unknown position, and lost without it.
    by_shift_alone: [bool; 3],
}

impl Offsets {
    /// Starts with the zeros that the options give, and G54 in force.
    pub fn new(options: &GcodeOptions) -> Offsets {
        let mut zeros: BTreeMap<WorkOffset, PartialPosition> =
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
            is_used: BTreeMap::new(),
            local: Vector3::zeros(),
            shift: Vector3::zeros(),
            suspended: Vector3::zeros(),
            by_shift_alone: [false; 3],
        }
    }

    /// Puts `offset` in force.
    pub fn activate(&mut self, offset: WorkOffset) {
        self.active = offset;
    }

    /// The work offset in force.
    pub fn active_offset(&self) -> WorkOffset {
        self.active
    }

    /// Returns the zero of the coordinates in force, mm in W. `Err` if it is unknown.
    pub fn origin(&mut self) -> Result<Vector3<f64>, Fault> {
        let zero = self.zero(self.active)?;
        Ok(zero + self.local + self.shift)
    }

    /// Returns the zero of `offset`, mm in W; the first one asked for becomes W unless one is given. `Err` if it is unknown.
    fn zero(&mut self, offset: WorkOffset) -> Result<Vector3<f64>, Fault> {
        let mut zero = Vector3::zeros();
        for axis in 0..3 {
            zero[axis] = self.fix_zero(offset, axis).ok_or(Fault::NoWorkOffset { offset })?;
        }
        Ok(zero)
    }

    /// Returns the zero of `offset` along `axis`, mm in W, which is fixed from now on; `None` if it is unknown.
    fn fix_zero(&mut self, offset: WorkOffset, axis: usize) -> Option<f64> {
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
        self.is_used.entry(offset).or_default()[axis] = true;
        if let Some(in_machine) = in_machine {
            self.machine[axis].get_or_insert(zero - in_machine);
        }
        Some(zero)
    }

    /// Sets the zero of `offset` along `axis` to `value`, mm in machine coordinates (G10 L2).
    pub fn set_in_machine(&mut self, offset: WorkOffset, axis: usize, value: f64) {
        self.in_machine.entry(offset).or_default()[axis] = Some(value);
        let is_used = self.is_used.get(&offset).is_some_and(|is_used| is_used[axis]);
        let zero = &mut self.zeros.entry(offset).or_default()[axis];
        match (self.machine[axis], *zero) {
            (Some(machine), _) => *zero = Some(machine + value),
            // What is given for it stands for the zero that the program sets.
            (None, Some(zero)) if !is_used => self.machine[axis] = Some(zero - value),
            (None, _) => *zero = None,
        }
    }

    /// Sets the zero of `offset` along `axis` so that `position` (mm in W) has the coordinate `value` (G10 L20).
    pub fn set_by_position(&mut self, offset: WorkOffset, axis: usize, position: f64, value: f64) {
        let zero = position - value - self.local[axis] - self.shift[axis];
        self.zeros.entry(offset).or_default()[axis] = Some(zero);
        if let Some(machine) = self.machine[axis] {
            self.in_machine.entry(offset).or_default()[axis] = Some(zero - machine);
        }
        self.is_tied[axis] = true;
    }

    /// Sets the shift along `axis` so that `position` (mm in W) has the coordinate `value` (G92). `Err` if the zero is unknown.
    pub fn set_shift(&mut self, axis: usize, position: f64, value: f64) -> Result<(), Fault> {
        let zero = self.fix_zero(self.active, axis).ok_or(Fault::NoWorkOffset { offset: self.active })?;
        self.shift[axis] = position - zero - self.local[axis] - value;
        Ok(())
    }

    /// Returns the position along `axis`, mm in W, at which an unknown start has the coordinate `value`; `by_shift`: until G92 is off.
    pub fn assume_start(&mut self, axis: usize, value: f64, by_shift: bool) -> Result<f64, Fault> {
        let zero = self.fix_zero(self.active, axis).ok_or(Fault::NoWorkOffset { offset: self.active })?;
        self.by_shift_alone[axis] |= by_shift;
        Ok(zero + self.local[axis] + self.shift[axis] + value)
    }

    /// Sets the shift from the zero of the work offset along `axis` to `value`, mm (G52).
    pub fn set_local(&mut self, axis: usize, value: f64) {
        self.local[axis] = value;
    }

    /// Adds `value`, mm, to the G52 shift along `axis`.
    pub fn add_local(&mut self, axis: usize, value: f64) {
        self.local[axis] += value;
    }

    /// Cancels the shifts along `axes` (G92.1; with `keeps`, G92.2), that of G52 too: LinuxCNC has but one shift, Fanuc presets both.
    pub fn cancel_shift(&mut self, keeps: bool, axes: [bool; 3]) {
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

    /// Puts the shift that G92.2 kept back in force (G92.3).
    pub fn resume_shift(&mut self) {
        self.shift = self.suspended;
    }

    /// Whether a G92 shift is in force.
    pub fn is_shifted(&self) -> bool {
        self.shift != Vector3::zeros() || self.by_shift_alone.contains(&true)
    }

    /// Whether a G52 shift is in force.
    pub fn has_local_shift(&self) -> bool {
        self.local != Vector3::zeros()
    }
}
