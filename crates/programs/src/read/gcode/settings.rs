//! Words whose coordinates are no motion: G10, G52, G92, G43.1, TRANS, Heidenhain's CC.

use nalgebra::Vector3;

use crate::{
    model::gcode::{
        Centre, Contradiction, Dialect, Distance, Fault, ModalState, Motion, PartialPosition, Refusal, RotaryMotion,
        Setting, Word, WorkOffset,
    },
    read::gcode::{Interpreter, Request, ZeroSetting},
};

const AXES: [&str; 3] = ["X", "Y", "Z"];

impl Interpreter {
    /// Applies `setting`, which `word` commands, to the zeros; returns the zero that the tool position sets (G92, G10 L20), if any.
    pub(crate) fn apply_setting(
        &mut self,
        request: &Request,
        word: &Word,
        setting: Setting,
    ) -> Result<Option<ZeroSetting>, Refusal> {
        let mixed = || Err(word.refuse(Fault::LocalAndShift));
        match setting {
            Setting::Stored => {}
            Setting::Length => {
                let moves =
                    request.axis_words().into_iter().flatten().next().filter(|_| self.dialect != Dialect::LinuxCnc);
                if moves.is_some() {
                    return Err(word.refuse(Fault::Contradicts(Contradiction::Length)));
                }
            }
            Setting::Data => return self.set_data(request, word),
            Setting::Local if self.offsets.is_shifted() => return mixed(),
            Setting::Local => {
                for (axis, value) in self.coordinates(request)? {
                    self.offsets.set_local(axis, value);
                }
            }
            Setting::Origin | Setting::OriginOn if self.offsets.has_local_shift() => return mixed(),
            Setting::Origin => return self.shift_zero(request, word).map(Some),
            Setting::OriginOff { keeps: true } if self.offsets.has_local_shift() => return mixed(),
            Setting::OriginOff { keeps } => {
                let given = request.axis_words().map(|axis| axis.is_some());
                // Fanuc names the axes, LinuxCNC has no words with it.
                let axes = if given == [false; 3] { [true; 3] } else { given };
                self.offsets.cancel_shift(keeps, axes);
            }
            Setting::OriginOn => self.offsets.resume_shift(),
            Setting::Translation { afresh } => self.translate_zero(request, afresh)?,
            // The centre of arcs is no zero, and planes are inclined elsewhere.
            Setting::Pole | Setting::Incline(_) => {}
        }
        Ok(None)
    }

    /// Returns the coordinates of the line in mm, each with its axis (0 = X); `Err` beyond the range of coordinates.
    pub(crate) fn coordinates(&self, request: &Request) -> Result<Vec<(usize, f64)>, Refusal> {
        let mm = self.modal.unit.mm();
        let given = request.axis_words().into_iter().enumerate().filter_map(|(axis, word)| Some((axis, word?)));
        given
            .map(|(axis, word)| match word.value * mm {
                value if value.abs() <= Fault::MAX_COORDINATE_MM => Ok((axis, value)),
                _ => Err(word.refuse(Fault::TooFar)),
            })
            .collect()
    }

    /// Moves the zero by the coordinates of the line or to them; axes left out keep their shift, or lose it if it is set `afresh`.
    fn translate_zero(&mut self, request: &Request, afresh: bool) -> Result<(), Refusal> {
        if let Some(word) =
            ['A', 'B', 'C'].into_iter().find_map(|letter| request.find_word(letter)).filter(|w| w.value != 0.0)
        {
            return Err(word.refuse(Fault::Rotary { letter: word.letter, from: 0.0 }));
        }
        for axis in (0..3).filter(|_| afresh) {
            self.offsets.set_local(axis, 0.0);
        }
        for (axis, value) in self.coordinates(request)? {
            let adds = request.axis_words()[axis].is_some_and(|word| word.distance == Some(Distance::Incremental));
            match adds {
                true => self.offsets.add_local(axis, value),
                false => self.offsets.set_local(axis, value),
            }
        }
        Ok(())
    }

    /// Moves the zero so that the tool position has the coordinates of the line (G92).
    fn shift_zero(&mut self, request: &Request, word: &Word) -> Result<ZeroSetting, Refusal> {
        let mut position = [None; 3];
        for (axis, value) in self.coordinates(request)? {
            position[axis] = self.position[axis];
            match self.position[axis] {
                Some(here) => self.offsets.set_shift(axis, here, value).map_err(|fault| word.refuse(fault))?,
                None => self.assume_start(axis, value, true, word)?,
            }
        }
        Ok(ZeroSetting { position, unit_mm: self.modal.unit.mm(), words: Vec::new() })
    }

    /// Gives the unknown position at which the program starts the coordinate `value` (mm); `Err`, at `word`, if it was known before.
    fn assume_start(&mut self, axis: usize, value: f64, by_shift: bool, word: &Word) -> Result<(), Refusal> {
        if self.ever_known[axis] {
            return Err(word.refuse(Fault::OriginAtUnknown { axis: AXES[axis], since: self.lost_since() }));
        }
        let start = self.offsets.assume_start(axis, value, by_shift).map_err(|fault| word.refuse(fault))?;
        self.position[axis] = Some(start);
        self.ever_known[axis] = true;
        Ok(())
    }

    /// Sets work offsets by G10 L2 and L20; tool lengths and radii do not move the tip. Returns the zero that the tool position sets (L20).
    fn set_data(&mut self, request: &Request, word: &Word) -> Result<Option<ZeroSetting>, Refusal> {
        let refused = || word.refuse(Fault::Data);
        let coordinates = self.coordinates(request)?;
        let rotation = request.find_word('R').is_some_and(|word| word.value != 0.0);
        let number = request.find_word('P').map(Word::whole_number).transpose()?;
        match request.find_word('L').map(Word::whole_number).transpose()? {
            Some(1 | 10..=13) => Ok(None),
            None if coordinates.is_empty() => Ok(None),
            Some(2) if !rotation && self.modal.distance == Distance::Absolute => {
                let offset = number.and_then(WorkOffset::from_g10_number).ok_or_else(refused)?;
                for (axis, value) in coordinates {
                    self.offsets.set_in_machine(offset, axis, value);
                }
                Ok(None)
            }
            Some(20) if self.dialect == Dialect::Iso => Err(word.refuse(Fault::Contradicts(Contradiction::WorkOffset))),
            Some(20) if self.dialect != Dialect::LinuxCnc => {
                if rotation || self.modal.distance != Distance::Absolute {
                    return Err(refused());
                }
                let offset = number.and_then(WorkOffset::extended).ok_or_else(refused)?;
                coordinates.into_iter().for_each(|(axis, value)| self.offsets.set_in_machine(offset, axis, value));
                Ok(None)
            }
            Some(20) if !rotation => {
                let offset = match number {
                    Some(0) => self.offsets.active_offset(),
                    number => number.and_then(WorkOffset::from_g10_number).ok_or_else(refused)?,
                };
                let mut position = [None; 3];
                for (axis, value) in coordinates {
                    position[axis] = self.position[axis];
                    match self.position[axis] {
                        Some(here) => self.offsets.set_by_position(offset, axis, here, value),
                        None if offset == self.offsets.active_offset() => {
                            self.assume_start(axis, value, false, word)?
                        }
                        None => return Err(refused()),
                    }
                }
                Ok(Some(ZeroSetting { position, unit_mm: self.modal.unit.mm(), words: Vec::new() }))
            }
            _ => Err(refused()),
        }
    }
}

/// A centre of arcs that a line sets.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pole {
    /// Centre in W along the two axes of the plane, mm; `None` if unknown.
    pub(crate) centre: Option<[f64; 2]>,
    /// Tool position on the line, mm.
    pub(crate) start: PartialPosition,
    pub(crate) modal: ModalState,
    pub(crate) origin: Vector3<f64>,
    pub(crate) turning: RotaryMotion,
    /// Words of the line.
    pub words: Vec<Word>,
}

impl Pole {
    /// Whether `motion` is an arc about this centre.
    pub fn is_centre_of(&self, motion: &Motion) -> bool {
        matches!((motion.centre, self.centre), (Some(Centre::Pole(centre)), Some(pole)) if centre == pole)
    }
}

impl Interpreter {
    /// Sets and returns the centre of the arcs that follow (CC); without coordinates it is the tool position.
    pub(crate) fn set_pole(&mut self, request: &Request, word: &Word) -> Result<Pole, Refusal> {
        let [first, second, normal] = self.modal.plane.axes();
        let axes = request.axis_words();
        if axes[normal].is_some() || axes[first].is_some() != axes[second].is_some() {
            return Err(word.refuse(Fault::PoleAxes));
        }
        let origin = if axes[first].is_some() { self.origin(word)? } else { Vector3::zeros() };
        let at = self.end_point(axes, origin)?;
        let centre = at[first].zip(at[second]).map(|(first, second)| [first, second]);
        self.pole = centre;
        let turning = self.turning();
        Ok(Pole { centre, start: self.position, modal: self.modal, origin, turning, words: Vec::new() })
    }
}
