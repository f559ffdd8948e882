//! Words whose coordinates are no motion: G10, G52, G92, G43.1, Heidenhain's CC.

use nalgebra::Vector3;

use crate::toolpath::{
    model::gcode::{
        Centre, Contradiction, Dialect, Distance, Fault, Known, Modal, Motion, Refusal, Setting, Word, WorkOffset,
    },
    read::gcode::{Interpreter, OriginAt, Request},
};

const AXES: [&str; 3] = ["X", "Y", "Z"];

impl Interpreter {
    /// Does what `setting`, which `word` asks for, does to the zeros of the coordinates.
    pub(crate) fn set(
        &mut self,
        request: &Request,
        word: &Word,
        setting: Setting,
    ) -> Result<Option<OriginAt>, Refusal> {
        let mixed = || Err(word.refuse(Fault::LocalAndShift));
        match setting {
            Setting::Stored => {}
            Setting::Length => {
                let moves = request.axes().into_iter().flatten().next().filter(|_| self.dialect != Dialect::LinuxCnc);
                if moves.is_some() {
                    return Err(word.refuse(Fault::Contradicts(Contradiction::Length)));
                }
            }
            Setting::Data => return self.data(request, word),
            Setting::Local if self.offsets.is_shifted() => return mixed(),
            Setting::Local => {
                for (axis, value) in self.coordinates(request)? {
                    self.offsets.set_local(axis, value);
                }
            }
            Setting::Origin | Setting::OriginOn if self.offsets.is_local() => return mixed(),
            Setting::Origin => return self.shift(request, word).map(Some),
            Setting::OriginOff { keeps: true } if self.offsets.is_local() => return mixed(),
            Setting::OriginOff { keeps } => {
                let given = request.axes().map(|axis| axis.is_some());
                // Fanuc names the axes, LinuxCNC has no words with it.
                let axes = if given == [false; 3] { [true; 3] } else { given };
                self.offsets.end_shift(keeps, axes);
            }
            Setting::OriginOn => self.offsets.restore_shift(),
            Setting::Translation { afresh } => self.translate(request, afresh)?,
            // The centre of arcs is no zero.
            Setting::Pole => {}
        }
        Ok(None)
    }

    /// The coordinates of the line, mm.
    fn coordinates(&self, request: &Request) -> Result<Vec<(usize, f64)>, Refusal> {
        let mm = self.modal.unit.mm();
        let given = request.axes().into_iter().enumerate().filter_map(|(axis, word)| Some((axis, word?)));
        given
            .map(|(axis, word)| match word.value * mm {
                value if value.abs() <= Fault::MAX_COORDINATE_MM => Ok((axis, value)),
                _ => Err(word.refuse(Fault::TooFar)),
            })
            .collect()
    }

    /// The zero moves by the coordinates, or to them; those left out stay, or are 0 if it is set `afresh`.
    fn translate(&mut self, request: &Request, afresh: bool) -> Result<(), Refusal> {
        if let Some(word) =
            ['A', 'B', 'C'].into_iter().find_map(|letter| request.letter(letter)).filter(|w| w.value != 0.0)
        {
            return Err(word.refuse(Fault::Rotary { letter: word.letter, from: 0.0 }));
        }
        for axis in (0..3).filter(|_| afresh) {
            self.offsets.set_local(axis, 0.0);
        }
        for (axis, value) in self.coordinates(request)? {
            let adds = request.axes()[axis].is_some_and(|word| word.distance == Some(Distance::Incremental));
            match adds {
                true => self.offsets.add_local(axis, value),
                false => self.offsets.set_local(axis, value),
            }
        }
        Ok(())
    }

    /// G92: where the tool is has these coordinates.
    fn shift(&mut self, request: &Request, word: &Word) -> Result<OriginAt, Refusal> {
        let mut place = [None; 3];
        for (axis, value) in self.coordinates(request)? {
            place[axis] = self.position[axis];
            match self.position[axis] {
                Some(here) => self.offsets.shift_to(axis, here, value).map_err(|fault| word.refuse(fault))?,
                None => self.begin(axis, value, true, word)?,
            }
        }
        Ok(OriginAt { place, unit_mm: self.modal.unit.mm(), words: Vec::new() })
    }

    /// The unknown place where the program begins has the coordinate `value`.
    fn begin(&mut self, axis: usize, value: f64, by_shift: bool, word: &Word) -> Result<(), Refusal> {
        if self.ever_known[axis] {
            return Err(word.refuse(Fault::OriginAtUnknown { axis: AXES[axis], since: self.since() }));
        }
        let place = self.offsets.begin_at(axis, value, by_shift).map_err(|fault| word.refuse(fault))?;
        self.position[axis] = Some(place);
        self.ever_known[axis] = true;
        Ok(())
    }

    /// G10: work offsets by L2 and L20; lengths and radii of tools do not move the tip.
    fn data(&mut self, request: &Request, word: &Word) -> Result<Option<OriginAt>, Refusal> {
        let refused = || word.refuse(Fault::Data);
        let coordinates = self.coordinates(request)?;
        let rotation = request.letter('R').is_some_and(|word| word.value != 0.0);
        let number = request.letter('P').map(Word::whole).transpose()?;
        match request.letter('L').map(Word::whole).transpose()? {
            Some(1 | 10..=13) => Ok(None),
            None if coordinates.is_empty() => Ok(None),
            Some(2) if !rotation && self.modal.distance == Distance::Absolute => {
                let offset = number.and_then(WorkOffset::numbered).ok_or_else(refused)?;
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
                    Some(0) => self.offsets.active(),
                    number => number.and_then(WorkOffset::numbered).ok_or_else(refused)?,
                };
                let mut place = [None; 3];
                for (axis, value) in coordinates {
                    place[axis] = self.position[axis];
                    match self.position[axis] {
                        Some(here) => self.offsets.set_by_place(offset, axis, here, value),
                        None if offset == self.offsets.active() => self.begin(axis, value, false, word)?,
                        None => return Err(refused()),
                    }
                }
                Ok(Some(OriginAt { place, unit_mm: self.modal.unit.mm(), words: Vec::new() }))
            }
            _ => Err(refused()),
        }
    }
}

/// A centre that a line sets.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pole {
    /// mm in the workpiece frame along the two axes of the plane, if it is known.
    pub(crate) place: Option<[f64; 2]>,
    /// Where the tool is on the line.
    pub(crate) start: Known,
    pub(crate) modal: Modal,
    pub(crate) origin: Vector3<f64>,
    /// The words of the line.
    pub words: Vec<Word>,
}

impl Pole {
    /// Whether `motion` is an arc about it.
    pub fn is_of(&self, motion: &Motion) -> bool {
        matches!((motion.centre, self.place), (Some(Centre::Pole(centre)), Some(place)) if centre == place)
    }
}

impl Interpreter {
    /// The centre that the line, which `word` begins, gives the arcs that follow; without coordinates it is where the tool is.
    pub(crate) fn set_pole(&mut self, request: &Request, word: &Word) -> Result<Pole, Refusal> {
        let [first, second, normal] = self.modal.plane.axes();
        let axes = request.axes();
        if axes[normal].is_some() || axes[first].is_some() != axes[second].is_some() {
            return Err(word.refuse(Fault::PoleAxes));
        }
        let origin = if axes[first].is_some() { self.origin(word)? } else { Vector3::zeros() };
        let at = self.end(axes, origin)?;
        let place = at[first].zip(at[second]).map(|(first, second)| [first, second]);
        self.pole = place;
        Ok(Pole { place, start: self.position, modal: self.modal, origin, words: Vec::new() })
    }
}
