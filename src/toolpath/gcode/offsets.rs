//! Where the zero of the coordinates is: work offsets G54 …, G10 L2 and L20, and what G52 and G92 add to all of them.
//!
//! A work offset is a place for the workpiece frame W. Only how they stand to one another matters: the one that the program
//! uses first is W, unless its zero is given.

use std::{collections::BTreeMap, fmt, str::FromStr};

use nalgebra::Vector3;

use crate::toolpath::gcode::{GcodeOptions, error::Fault, motion::Known};

/// A work offset.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct WorkOffset(Name);

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Name {
    /// G54 to G59, G59.1 to G59.3, from 1 to 9 as G10 counts them.
    Own(u8),
    /// G54.1 P1 and so on, G110 to G129 of Haas.
    Extended(u16),
    /// Sinumerik's G500, G505 to G599.
    Settable(u16),
    /// Those of Heidenhain's preset table.
    Preset(u32),
    /// G15 H1 and so on, of Okuma.
    Numbered(u16),
}

/// The most that G54.1 P goes to.
const MOST_EXTENDED: u16 = 300;

impl WorkOffset {
    /// G54.
    pub const G54: WorkOffset = WorkOffset(Name::Own(1));

    /// The one that G10 calls `number`: 1 for G54 to 9 for G59.3.
    #[must_use]
    pub fn numbered(number: u32) -> Option<WorkOffset> {
        u8::try_from(number).ok().filter(|number| (1..=9).contains(number)).map(|number| WorkOffset(Name::Own(number)))
    }

    /// The one of G54.1 P`number`.
    #[must_use]
    pub fn extended(number: u32) -> Option<WorkOffset> {
        let number = u16::try_from(number).ok().filter(|number| (1..=MOST_EXTENDED).contains(number));
        number.map(|number| WorkOffset(Name::Extended(number)))
    }

    /// Sinumerik's G`number`, if it is one of G500 and G505 to G599.
    pub(crate) fn settable(number: u32) -> Option<WorkOffset> {
        let number = u16::try_from(number).ok().filter(|number| matches!(number, 500 | 505..=599));
        number.map(|number| WorkOffset(Name::Settable(number)))
    }

    /// That in line `number` of Heidenhain's preset table.
    pub(crate) fn preset(number: u32) -> WorkOffset {
        WorkOffset(Name::Preset(number))
    }

    /// What of the program may say where it is, for messages.
    pub(crate) fn by_the_program(self) -> &'static str {
        match self.0 {
            Name::Own(_) | Name::Extended(_) | Name::Numbered(_) => ", or G10 L2 for both",
            Name::Settable(_) | Name::Preset(_) => "",
        }
    }

    /// The one of G15 H`number`.
    #[must_use]
    pub fn of_okuma(number: u32) -> Option<WorkOffset> {
        let number = u16::try_from(number).ok().filter(|number| (1..=MOST_EXTENDED).contains(number));
        number.map(|number| WorkOffset(Name::Numbered(number)))
    }

    /// Whether it is one of G54 to G59, which have keys of their own in process files.
    pub(crate) fn has_own_key(self) -> bool {
        matches!(self.0, Name::Own(1..=6))
    }

    /// That of a G word, given in tenths.
    pub(crate) fn of_tenths(tenths: u32) -> Option<WorkOffset> {
        match tenths {
            540 | 550 | 560 | 570 | 580 | 590 => WorkOffset::numbered((tenths - 530) / 10),
            591..=593 => WorkOffset::numbered(tenths - 584),
            1100..=1290 if tenths.is_multiple_of(10) => WorkOffset::extended((tenths - 1090) / 10),
            _ => None,
        }
    }
}

impl fmt::Display for WorkOffset {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Name::Own(number @ 1..=6) => write!(f, "G{}", 53 + number),
            Name::Own(number) => write!(f, "G59.{}", number - 6),
            Name::Extended(number) => write!(f, "G54.1 P{number}"),
            Name::Settable(number) => write!(f, "G{number}"),
            Name::Preset(number) => write!(f, "preset {number}"),
            Name::Numbered(number) => write!(f, "G15 H{number}"),
        }
    }
}

impl FromStr for WorkOffset {
    type Err = ();

    /// As it is displayed.
    fn from_str(name: &str) -> Result<WorkOffset, ()> {
        let number = |prefix: &str| name.strip_prefix(prefix).and_then(|number| number.parse().ok());
        let okuma = || number("G15 H").and_then(WorkOffset::of_okuma);
        let settable = || number("G").and_then(WorkOffset::settable);
        let others = || number("preset ").map(WorkOffset::preset).or_else(okuma).or_else(settable);
        let found = match number("G54.1 P").and_then(WorkOffset::extended).or_else(others) {
            Some(offset) => Some(offset),
            None => (1..=9).filter_map(WorkOffset::numbered).find(|offset| offset.to_string() == name),
        };
        found.ok_or(())
    }
}

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
