//! Words into motions: what each line does, given the lines before it.

use nalgebra::Vector3;

use crate::toolpath::gcode::{
    GcodeOptions,
    arc::{Arc, Centre},
    error::{ArcFault, Fault, Refusal, Unsupported},
    lex::Word,
    modal::{Distance, GWord, Modal, MotionCode, WORK_OFFSETS, plane_names},
    motion::{Geometry, Known, Motion, located},
    request::Request,
};

/// Follows a program line by line.
pub(crate) struct Interpreter<'a> {
    options: &'a GcodeOptions,
    modal: Modal,
    position: Known,
    /// The line that made the position unknown again, if one did.
    lost_in: Option<usize>,
    /// The line with M2 or M30.
    ended_in: Option<usize>,
    named: bool,
}

/// What a line does to the tool.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Effect {
    /// The motion word on the line.
    pub motion_word: Option<MotionCode>,
    /// The motion it makes.
    pub motion: Option<Motion>,
}

impl<'a> Interpreter<'a> {
    pub fn new(options: &'a GcodeOptions) -> Interpreter<'a> {
        Interpreter {
            options,
            modal: Modal::at_start(options.unit),
            position: options.start_mm.map_or([None; 3], |p| [Some(p.x), Some(p.y), Some(p.z)]),
            lost_in: None,
            ended_in: None,
            named: false,
        }
    }

    /// Follows the words of line `number` (from 1).
    pub fn line(&mut self, number: usize, words: Vec<Word>) -> Result<Effect, Refusal> {
        if let (Some(end), Some(word)) = (self.ended_in, words.first()) {
            return Err(word.refuse(Fault::AfterEnd { end }));
        }
        let request = Request::of(&words)?;
        self.program_number(&request)?;
        self.apply_modal(&request)?;
        let motion_word = request.motion_word();
        let motion = if request.g(GWord::Home).is_some() || request.g(GWord::Machine).is_some() {
            self.leave(number, &request)?;
            None
        } else {
            self.motion(number, &request)?
        };
        if request.ends_program {
            self.ended_in = Some(number);
        }
        let motion = motion.map(|motion| Motion { words, ..motion });
        Ok(Effect { motion_word, motion })
    }

    /// A program has one number; a second one begins a subprogram.
    fn program_number(&mut self, request: &Request) -> Result<(), Refusal> {
        if let Some(word) = request.letter('O') {
            word.whole()?;
            if std::mem::replace(&mut self.named, true) {
                return Err(word.refuse(Fault::Unsupported(Unsupported::Subprogram)));
            }
        }
        Ok(())
    }

    /// Everything that stays in force, in the order RS-274 controllers take it: units before feed.
    fn apply_modal(&mut self, request: &Request) -> Result<(), Refusal> {
        for &(word, g) in &request.g_words {
            match g {
                GWord::Motion(code) => self.modal.motion = Some(code),
                GWord::CancelMotion => self.modal.motion = None,
                GWord::Plane(plane) => self.modal.plane = plane,
                GWord::Unit(unit) => self.modal.unit = unit,
                GWord::Distance(distance) => self.modal.distance = distance,
                GWord::Centres(distance) => self.modal.centres = distance,
                GWord::WorkOffset(index) => {
                    self.modal.work_offset = index;
                    self.origin(word)?;
                }
                GWord::Dwell | GWord::Home | GWord::Machine | GWord::PathControl | GWord::Passive(_) => {}
            }
        }
        if let Some(word) = request.letter('F') {
            let expected = "a feed of 0 to 1e9 per minute";
            self.modal.feed_mm_per_min = Some(speed(word, expected)? * self.modal.unit.mm());
        }
        if let Some(word) = request.letter('S') {
            self.modal.spindle_rev_per_min = Some(speed(word, "a spindle speed of 0 to 1e9 rev/min")?);
        }
        Ok(())
    }

    /// Zero of the coordinates in force; `word` is blamed if it was not given.
    fn origin(&self, word: &Word) -> Result<Vector3<f64>, Refusal> {
        let index = self.modal.work_offset;
        self.options.work_offsets_mm[index]
            .ok_or_else(|| word.refuse(Fault::NoWorkOffset { word: WORK_OFFSETS[index] }))
    }

    /// A move to a place outside the workpiece frame (G28, G30, G53): it is copied as it is, and where it ends is
    /// not known.
    fn leave(&mut self, number: usize, request: &Request) -> Result<(), Refusal> {
        let axes = request.axes();
        request.refuse_arc_words()?;
        let home = request.g(GWord::Home).is_some();
        if let (false, Some(MotionCode::Arc(_)), Some(word)) = (home, self.modal.motion, request.g(GWord::Machine)) {
            return Err(word.refuse(Fault::Unsupported(Unsupported::MachineArc)));
        }
        let all = home && axes.iter().all(Option::is_none);
        for (axis, word) in axes.into_iter().enumerate() {
            if all || word.is_some() {
                self.position[axis] = None;
                self.lost_in = Some(number);
            }
        }
        Ok(())
    }

    /// The motion the line makes, if it has a coordinate or, for arcs, a centre.
    fn motion(&mut self, line: usize, request: &Request) -> Result<Option<Motion>, Refusal> {
        let axes = request.axes();
        let is_arc = matches!(self.modal.motion, Some(MotionCode::Arc(_)));
        if !is_arc {
            request.refuse_arc_words()?;
        }
        let coordinate = axes.iter().flatten().copied().next();
        let Some(first) = coordinate.or_else(|| request.arc_words().next()) else {
            return Ok(None);
        };
        if request.g(GWord::Dwell).is_some() {
            return Err(first.refuse(Fault::NotACoordinate { word: "G4" }));
        }
        let blame = request.g_words.iter().find(|(_, g)| matches!(g, GWord::Motion(_)));
        let blame = blame.map_or(first, |(word, _)| *word);
        let code = self.modal.motion.ok_or_else(|| first.refuse(Fault::NoMotion))?;
        let origin = self.origin(blame)?;
        let start = self.position;
        let end = self.end(axes, origin, blame)?;
        let centre = match code {
            MotionCode::Arc(_) => Some(self.centre(request, origin, blame)?),
            MotionCode::Rapid | MotionCode::Line => None,
        };
        let geometry = self.geometry(code, start, end, centre, blame)?;
        self.position = end;
        let (modal, span) = (self.modal, blame.span.clone());
        Ok(Some(Motion { line, modal, code, origin, start, end, centre, geometry, words: Vec::new(), span }))
    }

    /// Where the coordinates on the line lead to.
    fn end(&self, axes: [Option<&Word>; 3], origin: Vector3<f64>, blame: &Word) -> Result<Known, Refusal> {
        let mut end = self.position;
        for (axis, word) in axes.into_iter().enumerate() {
            let Some(word) = word else { continue };
            let value = word.value * self.modal.unit.mm();
            let to = match self.modal.distance {
                Distance::Absolute => value + origin[axis],
                Distance::Incremental => {
                    let from = self.position[axis].ok_or_else(|| blame.refuse(self.unknown_start()))?;
                    value + from
                }
            };
            if to.abs() > Fault::MAX_COORDINATE_MM {
                return Err(word.refuse(Fault::TooFar));
            }
            end[axis] = Some(to);
        }
        Ok(end)
    }

    /// The centre of an arc as its words give it.
    fn centre(&self, request: &Request, origin: Vector3<f64>, blame: &Word) -> Result<Centre, Refusal> {
        let [first, second, normal] = self.modal.plane.axes();
        let (plane, expected) = plane_names(self.modal.plane);
        let words = request.centres();
        if let Some(word) = words[normal] {
            return Err(word.refuse(Fault::CentreOutsidePlane { expected, plane }));
        }
        let unit = self.modal.unit.mm();
        let given = [words[first], words[second]];
        for word in given.into_iter().flatten().chain(request.letter('R')) {
            if word.value.abs() * unit > Fault::MAX_COORDINATE_MM {
                return Err(word.refuse(Fault::TooFar));
            }
        }
        let values = given.map(|word| word.map(|word| word.value * unit));
        match (values, request.letter('R'), self.modal.centres) {
            ([None, None], Some(word), _) => Ok(Centre::Radius(word.value * unit)),
            ([None, None], None, _) => Err(blame.refuse(Fault::NoCentre { expected, plane })),
            (_, Some(word), _) => Err(word.refuse(Fault::CentreAndRadius)),
            ([i, j], None, Distance::Incremental) => Ok(Centre::FromStart([i.unwrap_or(0.0), j.unwrap_or(0.0)])),
            ([Some(i), Some(j)], None, Distance::Absolute) => Ok(Centre::At([i + origin[first], j + origin[second]])),
            (_, None, Distance::Absolute) => Err(blame.refuse(Fault::HalfCentre { expected, plane })),
        }
    }

    /// The way the motion takes. Only a rapid move may start anywhere.
    fn geometry(
        &self,
        code: MotionCode,
        start: Known,
        end: Known,
        centre: Option<Centre>,
        blame: &Word,
    ) -> Result<Geometry, Refusal> {
        match (located(start), located(end), code) {
            (_, None, MotionCode::Rapid) => Ok(Geometry::Unlocated),
            (None, Some(end), MotionCode::Rapid) => Ok(Geometry::Arrival(end)),
            (Some(start), Some(end), _) => {
                route(code, self.modal, start, end, centre).map_err(|fault| blame.refuse(Fault::Arc(fault)))
            }
            _ => Err(blame.refuse(self.unknown_start())),
        }
    }

    fn unknown_start(&self) -> Fault {
        let unknown = ["X", "Y", "Z"].into_iter().zip(self.position);
        let axes: Vec<&str> = unknown.filter(|(_, p)| p.is_none()).map(|(axis, _)| axis).collect();
        let since = self.lost_in.map_or_else(String::new, |line| format!(" after line {line}"));
        Fault::UnknownStart { axes: axes.join(", "), since }
    }
}

/// The way from `start` to `end` that a controller takes: straight, or round the centre.
pub(crate) fn route(
    code: MotionCode,
    modal: Modal,
    start: Vector3<f64>,
    end: Vector3<f64>,
    centre: Option<Centre>,
) -> Result<Geometry, ArcFault> {
    match (code, centre) {
        (MotionCode::Arc(turn), Some(centre)) => Ok(Geometry::Arc(Arc::new(modal.plane, turn, start, end, centre)?)),
        _ => Ok(Geometry::Line(start, end)),
    }
}

fn speed(word: &Word, expected: &'static str) -> Result<f64, Refusal> {
    if (0.0..=1e9).contains(&word.value) { Ok(word.value) } else { Err(word.refuse(Fault::Speed { expected })) }
}
