//! What A, B and C of a line do.

use crate::toolpath::{
    model::gcode::{Distance, Fault, GWord, MotionCode, Refusal, Setting, Turning, Word, index},
    read::gcode::{Interpreter, Request},
};

impl Interpreter {
    /// Where A, B and C stand after the line. Those of which it is not known what they turn may be named, but must stand still.
    pub(crate) fn turn(&mut self, request: &Request) -> Result<(), Refusal> {
        (self.rotary_before, self.rotary_lost_before) = (self.rotary, self.rotary_lost);
        for (axis, letter) in ['A', 'B', 'C'].into_iter().enumerate() {
            let Some(word) = request.letter(letter) else { continue };
            let distance = word.distance.unwrap_or(self.modal.distance);
            self.notes.names_rotary |= request.setting().is_none();
            if !self.rotary_axes.has(letter) {
                self.stand_still(request, letter, word, distance)?;
                continue;
            }
            if let Some((_, setting)) = request.setting() {
                self.keep_zero(request, setting, letter, word)?;
                continue;
            }
            // Words of the machine's coordinates are those of the drives, as all others are.
            let is_lost =
                request.leaves() && (request.g(GWord::Machine).is_none() || distance == Distance::Incremental);
            if distance == Distance::Incremental && self.rotary_lost[axis] && !is_lost {
                return Err(word.refuse(Fault::RotaryLost { letter }));
            }
            self.rotary[axis] = match distance {
                _ if is_lost => None,
                Distance::Absolute => Some(word.value),
                Distance::Incremental => Some(self.rotary[axis].unwrap_or(0.0) + word.value),
            };
            self.rotary_lost[axis] = is_lost;
        }
        Ok(())
    }

    /// Refuses a line that sets where the zero of a rotary axis is, unless it stays: its words are those of the drive.
    fn keep_zero(&self, request: &Request, setting: Setting, letter: char, word: &Word) -> Result<(), Refusal> {
        let says_where_it_stands = match setting {
            Setting::Origin => true,
            Setting::Data => request.letter('L').is_some_and(|l| l.value == 20.0),
            _ => false,
        };
        let stays = match says_where_it_stands {
            true => self.rotary[index(letter)] == Some(word.value),
            false => word.value == 0.0,
        };
        if stays { Ok(()) } else { Err(word.refuse(Fault::RotaryZero { letter })) }
    }

    fn stand_still(&mut self, request: &Request, letter: char, word: &Word, distance: Distance) -> Result<(), Refusal> {
        let axis = index(letter);
        let stood = self.rotary[axis];
        let turned = match distance {
            _ if request.setting().is_some() => stood.is_some_and(|stood| stood != word.value),
            Distance::Absolute => stood.is_some_and(|stood| stood != word.value),
            Distance::Incremental => word.value != 0.0 && request.g(GWord::Home).is_none(),
        };
        if turned {
            return Err(word.refuse(Fault::Rotary { letter, from: stood.unwrap_or(0.0) }));
        }
        let feeds = matches!(self.modal.motion, Some(MotionCode::Line | MotionCode::Arc(_)));
        // A whole circle names its centre alone.
        let goes = request.axes().iter().any(Option::is_some)
            || ['I', 'J', 'K'].iter().any(|of| request.letter(*of).is_some());
        let may_be_chamfer = self.dialect.is_iso() && letter != 'B';
        if may_be_chamfer && stood.is_none() && word.value != 0.0 && feeds && goes {
            return Err(word.refuse(Fault::Chamfer { letter }));
        }
        if distance == Distance::Absolute {
            self.rotary[axis] = Some(word.value);
        }
        Ok(())
    }

    /// How they turn along the line; an axis of which nothing was said stands at 0.
    pub(crate) fn turning(&self) -> Turning {
        let followed = |stands: [Option<f64>; 3]| {
            let at = |letter: char| stands[index(letter)].filter(|_| self.rotary_axes.has(letter)).unwrap_or(0.0);
            ['A', 'B', 'C'].map(at)
        };
        let of_tip = self.modal.tip_control || self.rotary_axes.always_of_tip;
        Turning { from: followed(self.rotary_before), to: followed(self.rotary), of_tip }
    }

    /// The first of them that does not stand at 0, and where it stands.
    pub(crate) fn turned_axis(&self) -> Option<(char, f64)> {
        let turning = self.turning();
        ['A', 'B', 'C'].into_iter().zip(turning.to).find(|(_, at)| *at != 0.0)
    }

    /// From here on X, Y and Z are those of the tip, or no longer.
    pub(crate) fn control_tip(&mut self, of_tip: bool) {
        let was = self.turning();
        self.modal.tip_control = of_tip;
        if self.rotary_lost.contains(&true) {
            // Where the tip is depends on where they stand.
            self.position = [None; 3];
            return;
        }
        if self.turning().of_tip != was.of_tip {
            self.position = self.rotary_axes.switched(self.position, &was.to, of_tip);
        }
    }

    /// Whether it is known where the tip is along the line.
    pub(crate) fn check_turning(&self, turning: &Turning, word: &Word) -> Result<(), Refusal> {
        let is_fed = self.modal.motion != Some(MotionCode::Rapid);
        let is_lost = |letter: &char| {
            let axis = index(*letter);
            self.rotary_lost[axis] || is_fed && self.rotary_lost_before[axis]
        };
        if let Some(letter) = ['A', 'B', 'C'].into_iter().find(is_lost) {
            return Err(word.refuse(Fault::RotaryLost { letter }));
        }
        if turning.of_tip {
            let unknown = ['A', 'B', 'C'].into_iter().filter(|letter| !self.rotary_axes.has(*letter));
            let turned = unknown.filter_map(|letter| Some((letter, self.rotary[index(letter)]?)));
            return match turned.into_iter().find(|(_, at)| *at != 0.0) {
                Some((letter, at)) => Err(word.refuse(Fault::UnknownRotary { letter, at })),
                None => Ok(()),
            };
        }
        let without = [turning.from, turning.to].iter().find_map(|angles| self.rotary_axes.without_place(angles));
        without.map_or(Ok(()), |letter| Err(word.refuse(Fault::NoPivot { letter })))
    }
}
