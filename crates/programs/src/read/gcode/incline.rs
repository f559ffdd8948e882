//! Inclined planes: where they begin and end, and which way the control turns the tool.

use nalgebra::{Matrix3, Vector3};

use crate::{
    model::gcode::{
        AngleChoice, Dialect, Distance, Fault, Foreign, GWord, Inclination, InclinedFault, Refusal, RotaryMotion,
        Setting, Word, axis_index,
    },
    read::gcode::{Interpreter, Request},
};
use kinetostat_spatial::Pose;

/// A tool that stands nearer to z of the plane stands along it, degrees: programs have few decimals.
const ALONG_DEG: f64 = 0.02;

impl Interpreter {
    /// Puts the inclined plane of `word` in force in line `line`: about the coordinates of the line, by its I, J and K. P, L and R are its normal,
    /// or else move the zero on in the plane.
    pub(crate) fn incline(
        &mut self,
        line: usize,
        request: &Request,
        word: &Word,
        inclination: Inclination,
    ) -> Result<(), Refusal> {
        let refuse = |fault| Err(word.refuse(Fault::Inclined(fault)));
        if self.rotary_axes.is_empty() {
            return refuse(InclinedFault::NoAxes);
        }
        let of_iso = self.dialect.is_iso();
        // P0 says that the angles are Euler's.
        let is_other =
            |letter: &char| request.find_word(*letter).is_some_and(|word| (word.letter, word.value) != ('P', 0.0));
        if of_iso && (self.modal.distance == Distance::Incremental || ['P', 'Q', 'R', 'L', 'D'].iter().any(is_other)) {
            return refuse(InclinedFault::Form { expected: "G68.2 X Y Z I J K in G90, with no other parameters" });
        }
        if self.modal.tip_control || of_iso && self.inclined.is_some() {
            return refuse(InclinedFault::Inside);
        }
        if self.dialect != Dialect::Heidenhain && (self.offsets.is_shifted() || self.offsets.has_local_shift()) {
            return refuse(InclinedFault::Shifted);
        }
        let before = self.inclined.take().map_or_else(Matrix3::identity, |plane| plane.rotation);
        let mut origin = self.origin(word)?;
        let coordinates = self.coordinates(request)?;
        if !coordinates.is_empty() {
            self.note_unit(line);
        }
        coordinates.into_iter().for_each(|(axis, value)| origin[axis] += value);
        let value = |letter: char| request.find_word(letter).map_or(0.0, |word| word.value);
        let normal = ['P', 'L', 'R'].map(value);
        let (before, given) = match inclination {
            Inclination::Axial => {
                let angles = self.given_angles(request, word)?;
                let Some(across) = self.rotary_axes.plane_across_tool(&angles) else {
                    let expected = "PLANE AXIAL by one axis at a right angle to the tool, the others at 0";
                    return refuse(InclinedFault::Form { expected });
                };
                (across, Some(angles))
            }
            _ => (before, None),
        };
        let rotation = inclination.rotation(['I', 'J', 'K'].map(value), normal, before);
        let moves_on = matches!(inclination, Inclination::AxisByAxis(_));
        let inside = Vector3::from(normal) * if moves_on { self.modal.unit.mm() } else { 0.0 };
        if inside.amax() > Fault::MAX_COORDINATE_MM {
            return Err(word.refuse(Fault::TooFar));
        }
        self.inclined = Some(Pose { rotation, translation: origin + rotation * inside });
        self.notes.names_rotary_axes = true;
        self.change_plane(line);
        self.found_angles = given;
        Ok(())
    }

    /// Returns the angles of A, B and C, degrees, of PLANE AXIAL: its I, J and K, or where the axes stand.
    fn given_angles(&self, request: &Request, word: &Word) -> Result<[f64; 3], Refusal> {
        let mut angles = self.turning().to;
        for (axis, (letter, given)) in [('A', 'I'), ('B', 'J'), ('C', 'K')].into_iter().enumerate() {
            match request.find_word(given) {
                Some(given) if self.rotary_axes.has_axis(letter) => angles[axis] = given.value,
                Some(_) => {
                    let expected = "PLANE AXIAL with axes that the machine has";
                    return Err(word.refuse(Fault::Inclined(InclinedFault::Form { expected })));
                }
                None if self.rotary_axes.has_axis(letter) && self.rotary_lost[axis] => {
                    return Err(word.refuse(Fault::RotaryLost { letter }));
                }
                None => {}
            }
        }
        Ok(angles)
    }

    /// Ends the inclined plane, if one is in force, in line `line`.
    pub(crate) fn end_plane(&mut self, line: usize) {
        if self.inclined.take().is_some() {
            self.change_plane(line);
        }
    }

    /// Forgets what was said in the coordinates of another plane.
    fn change_plane(&mut self, line: usize) {
        (self.pole, self.cycle, self.found_angles) = (None, None, None);
        self.forget_position(line, [true; 3]);
    }

    /// Turns the tool along z of the inclined plane in line `line`, by the rule `choice` of `word`.
    pub(crate) fn align_tool(&mut self, line: usize, word: &Word, choice: AngleChoice) -> Result<(), Refusal> {
        let angles = self.angles_along_plane(choice).map_err(|fault| word.refuse(fault))?;
        self.notes.chosen_angles.push((line, angles));
        for letter in ['A', 'B', 'C'].into_iter().filter(|letter| self.rotary_axes.has_axis(*letter)) {
            let axis = axis_index(letter);
            self.rotary[axis] = Some(angles[axis]);
            self.rotary_lost[axis] = false;
        }
        self.forget_position(line, [true; 3]);
        Ok(())
    }

    /// Returns the angles of A, B and C, degrees, with which the tool stands along z of the inclined plane, by the rule `choice`.
    pub(crate) fn angles_along_plane(&self, choice: AngleChoice) -> Result<[f64; 3], Fault> {
        if self.rotary_axes.is_empty() {
            return Err(Fault::Inclined(InclinedFault::NoAxes));
        }
        let direction = match self.inclined {
            Some(plane) => plane.rotation.column(2).into_owned(),
            None if choice == AngleChoice::Zero => Vector3::z(),
            None => return Err(Fault::Inclined(InclinedFault::NoPlane)),
        };
        let mut followed = ['A', 'B', 'C'].into_iter().filter(|letter| self.rotary_axes.has_axis(*letter));
        let lost = followed.find(|letter| self.rotary_lost[axis_index(*letter)]);
        if let (Some(letter), AngleChoice::Least | AngleChoice::Shorter { .. }) = (lost, choice) {
            return Err(Fault::RotaryLost { letter });
        }
        let now = self.found_angles.filter(|_| choice == AngleChoice::Given).unwrap_or(self.turning().to);
        self.rotary_axes.chosen_angles(&direction, &now, choice).map_err(Fault::Inclined)
    }

    /// Returns the angle of `axis` (0 = A), degrees, that `word` in line `line` takes from what PLANE with STAY has found.
    pub(crate) fn found_angle(&mut self, line: usize, axis: usize, word: &Word) -> Result<f64, Refusal> {
        let angles = self.found_angles.ok_or_else(|| word.refuse(Fault::Foreign(Foreign::Parameter)))?;
        if self.notes.chosen_angles.last().is_none_or(|(last, _)| *last != line) {
            self.notes.chosen_angles.push((line, angles));
        }
        Ok(angles[axis])
    }

    /// Refuses coordinates and angles beside G53.1.
    pub(crate) fn check_alignment(&self, request: &Request) -> Result<(), Refusal> {
        let is_alone = request.setting().is_some() || request.axis_words().iter().all(Option::is_none);
        match request.alignment() {
            Some((word, _)) if !is_alone || request.rotary_words().iter().any(Option::is_some) => {
                Err(word.refuse(Fault::NotACoordinate { word: "G53.1" }))
            }
            _ => Ok(()),
        }
    }

    /// Refuses the word `g` in an inclined plane if it would move zeros or change what coordinates are.
    pub(crate) fn check_inside_plane(&self, word: &Word, g: GWord) -> Result<(), Refusal> {
        let is_followed = match g {
            GWord::TipControl | GWord::Preset => false,
            GWord::WorkOffset(offset) => offset == Some(self.offsets.active_offset()),
            GWord::Setting(setting) => {
                matches!(setting, Setting::Pole | Setting::Stored | Setting::Length | Setting::Incline(_))
            }
            _ => true,
        };
        match self.inclined.is_some() && !is_followed {
            true => Err(word.refuse(Fault::Inclined(InclinedFault::Inside))),
            false => Ok(()),
        }
    }

    /// Whether line `line` turns the tool in an inclined plane and does nothing else; `Err` if it has the word `coordinate` as well.
    pub(crate) fn turns_in_plane(
        &mut self,
        line: usize,
        turning: &RotaryMotion,
        coordinate: Option<&Word>,
    ) -> Result<bool, Refusal> {
        if self.inclined.is_none() || !turning.turns() {
            return Ok(false);
        }
        if let Some(word) = coordinate {
            return Err(word.refuse(Fault::Inclined(InclinedFault::Turns)));
        }
        self.forget_position(line, [true; 3]);
        Ok(true)
    }

    /// Refuses `word`, a motion in an inclined plane, if the tool does not stand along its z.
    pub(crate) fn check_along_plane(&self, turning: &RotaryMotion, word: &Word) -> Result<(), Refusal> {
        let Some(plane) = self.inclined else { return Ok(()) };
        let tool = self.rotary_axes.tool_axis(&turning.to);
        let z = plane.rotation.column(2);
        let degrees = libm::atan2(tool.cross(&z).norm(), tool.dot(&z)).to_degrees();
        match degrees <= ALONG_DEG {
            true => Ok(()),
            false => Err(word.refuse(Fault::Inclined(InclinedFault::NotAlong { degrees }))),
        }
    }
}
