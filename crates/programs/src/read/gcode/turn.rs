//! Rotary axes: angles of A, B and C after each line, and what they do to the tip.

use crate::{
    model::gcode::{Coordinates, Distance, Fault, GWord, MotionCode, Refusal, RotaryMotion, Setting, Word, axis_index},
    read::gcode::{Interpreter, Request},
};

impl Interpreter {
    /// Updates the angles of A, B and C by the words of line `line`. An axis that is not followed may be named but must stand still.
    pub(crate) fn update_rotary(&mut self, line: usize, request: &Request) -> Result<(), Refusal> {
        (self.rotary_before, self.rotary_lost_before) = (self.rotary, self.rotary_lost);
        for (axis, letter) in ['A', 'B', 'C'].into_iter().enumerate() {
            let Some(word) = request.find_word(letter) else { continue };
            let distance = word.distance.unwrap_or(self.modal.distance);
            self.notes.names_rotary_axes |= request.setting().is_none();
            if !self.rotary_axes.has_axis(letter) {
                self.check_still(request, letter, word, distance)?;
                continue;
            }
            if let Some((_, setting)) = request.setting() {
                self.check_rotary_zero(request, setting, letter, word)?;
                continue;
            }
            let value = match word.meaning {
                Some(_) => self.found_angle(line, axis, word)?,
                None => word.value,
            };
            // Words of the machine's coordinates are those of the drives, as all others are.
            let is_lost = request.leaves_frame()
                && (request.find_g(GWord::Machine).is_none() || distance == Distance::Incremental);
            if distance == Distance::Incremental && self.rotary_lost[axis] && !is_lost {
                return Err(word.refuse(Fault::RotaryLost { letter }));
            }
            self.rotary[axis] = match distance {
                _ if is_lost => None,
                Distance::Absolute => Some(value),
                Distance::Incremental => Some(self.rotary[axis].unwrap_or(0.0) + value),
            };
            self.rotary_lost[axis] = is_lost;
        }
        Ok(())
    }

    /// Refuses a line that moves the zero of the rotary axis `letter`, whose words are positions of the drive.
    fn check_rotary_zero(&self, request: &Request, setting: Setting, letter: char, word: &Word) -> Result<(), Refusal> {
        let sets_position = match setting {
            Setting::Origin => true,
            Setting::Data => request.find_word('L').is_some_and(|l| l.value == 20.0),
            _ => false,
        };
        let stays = match sets_position {
            true => self.rotary[axis_index(letter)] == Some(word.value),
            false => word.value == 0.0,
        };
        if stays { Ok(()) } else { Err(word.refuse(Fault::RotaryZero { letter })) }
    }

    /// Refuses a word that turns an axis which is not followed, or that may be a chamfer; keeps the angle of one that stands still.
    fn check_still(&mut self, request: &Request, letter: char, word: &Word, distance: Distance) -> Result<(), Refusal> {
        let axis = axis_index(letter);
        let before = self.rotary[axis];
        let turned = match distance {
            _ if request.setting().is_some() => before.is_some_and(|before| before != word.value),
            Distance::Absolute => before.is_some_and(|before| before != word.value),
            Distance::Incremental => word.value != 0.0 && request.find_g(GWord::Home).is_none(),
        };
        if turned {
            return Err(word.refuse(Fault::Rotary { letter, from: before.unwrap_or(0.0) }));
        }
        let feeds = matches!(self.modal.motion, Some(MotionCode::Line | MotionCode::Arc(_)));
        // A whole circle names its centre alone.
        let moves = request.axis_words().iter().any(Option::is_some)
            || ['I', 'J', 'K'].iter().any(|centre| request.find_word(*centre).is_some());
        let may_be_chamfer = self.dialect.is_iso() && letter != 'B';
        if may_be_chamfer && before.is_none() && word.value != 0.0 && feeds && moves {
            return Err(word.refuse(Fault::Chamfer { letter }));
        }
        if distance == Distance::Absolute {
            self.rotary[axis] = Some(word.value);
        }
        Ok(())
    }

    /// Returns the angles of the followed axes before and after the line, degrees; 0 for an axis that was not named.
    pub(crate) fn turning(&self) -> RotaryMotion {
        let followed = |angles: [Option<f64>; 3]| {
            let angle =
                |letter: char| angles[axis_index(letter)].filter(|_| self.rotary_axes.has_axis(letter)).unwrap_or(0.0);
            ['A', 'B', 'C'].map(angle)
        };
        let coordinates =
            self.inclined.map_or_else(|| self.rotary_axes.coordinates(self.modal.tip_control), Coordinates::Inclined);
        RotaryMotion { from: followed(self.rotary_before), to: followed(self.rotary), coordinates }
    }

    /// Returns the first followed axis that is not at 0 after the line, and its angle, degrees; `None` if all are at 0.
    pub(crate) fn nonzero_rotary_axis(&self) -> Option<(char, f64)> {
        let turning = self.turning();
        ['A', 'B', 'C'].into_iter().zip(turning.to).find(|(_, at)| *at != 0.0)
    }

    /// Makes X, Y and Z coordinates of the tip (`is_tip_position`) or of the machine from here on, and converts the position.
    pub(crate) fn set_tip_control(&mut self, is_tip_position: bool) {
        let before = self.turning();
        self.modal.tip_control = is_tip_position;
        if self.rotary_lost.contains(&true) {
            // Where the tip is depends on where they stand.
            self.position = [None; 3];
            return;
        }
        let change = [before.coordinates, self.turning().coordinates];
        self.position = self.rotary_axes.convert_position(self.position, &before.to, change);
    }

    /// Refuses a line along which the tip position is unknown; the error points to `word`.
    pub(crate) fn check_tip_known(&self, turning: &RotaryMotion, word: &Word) -> Result<(), Refusal> {
        let is_fed = self.modal.motion != Some(MotionCode::Rapid);
        let is_lost = |letter: &char| {
            let axis = axis_index(*letter);
            self.rotary_lost[axis] || is_fed && self.rotary_lost_before[axis]
        };
        if let Some(letter) = ['A', 'B', 'C'].into_iter().find(is_lost) {
            return Err(word.refuse(Fault::RotaryLost { letter }));
        }
        if turning.coordinates != Coordinates::Head {
            let unknown = ['A', 'B', 'C'].into_iter().filter(|letter| !self.rotary_axes.has_axis(*letter));
            let turned = unknown.filter_map(|letter| Some((letter, self.rotary[axis_index(letter)]?)));
            return match turned.into_iter().find(|(_, at)| *at != 0.0) {
                Some((letter, at)) => Err(word.refuse(Fault::UnknownRotary { letter, at })),
                None => Ok(()),
            };
        }
        let without =
            [turning.from, turning.to].iter().find_map(|angles| self.rotary_axes.first_unlocated_axis(angles));
        without.map_or(Ok(()), |letter| Err(word.refuse(Fault::NoPivot { letter })))
    }
}
