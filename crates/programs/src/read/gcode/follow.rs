//! Motions of lines with G0, G1, G2 or G3 in force: where they lead, and along which way.

use nalgebra::Vector3;

use crate::{
    model::{
        MotionGeometry, Plane,
        gcode::{
            Arc, ArcFault, Centre, Dialect, Distance, Fault, FeedMode, Foreign, GWord, ModalState, Motion, MotionCode,
            PartialPosition, Refusal, Unsupported, Word, located,
        },
    },
    read::gcode::{Interpreter, Request},
};

impl Interpreter {
    /// Returns the motion of a line with a coordinate, an angle of a followed axis or, for arcs, a centre, and updates the position.
    pub(crate) fn motion(&mut self, line: usize, request: &Request) -> Result<Option<Motion>, Refusal> {
        let axes = request.axis_words();
        let is_arc = matches!(self.modal.motion, Some(MotionCode::Arc(_)));
        if !is_arc || request.find_g(GWord::Dwell).is_some() {
            self.refuse_arc_words(request)?;
        }
        let coordinate = axes.iter().flatten().copied().next();
        let angle = || request.rotary_words().into_iter().flatten().find(|word| self.rotary_axes.has_axis(word.letter));
        let is_smoothing = request.find_g(GWord::Smoothing).is_some();
        let of_arc = || request.arc_words().next().filter(|_| !is_smoothing);
        let Some(first) = coordinate.or_else(of_arc).or_else(angle) else { return Ok(None) };
        if self.modal.motion.is_none() && coordinate.is_none() && !self.turning().turns() {
            return Ok(None);
        }
        if request.find_g(GWord::Dwell).is_some() {
            // X is how long; then nothing else may be on the line that would be a motion.
            let is_time = axes[1].is_none() && axes[2].is_none() && request.motion_word().is_none();
            return if is_time { Ok(None) } else { Err(first.refuse(Fault::NotACoordinate { word: "G4" })) };
        }
        if is_smoothing {
            return Err(first.refuse(Fault::Unsupported(Unsupported::Motion)));
        }
        // Its coordinates name axes, or set the origin of a lathe.
        if request.find_g(GWord::Passive("scaling")).or(request.find_g(GWord::Passive("mirroring"))).is_some() {
            return Err(first.refuse(Fault::NotACoordinate { word: "G50" }));
        }
        self.note_unit(line);
        let blame = request.motion_word_source().unwrap_or(first);
        let code = self.modal.motion.ok_or_else(|| first.refuse(Fault::NoMotion))?;
        if self.modal.feed_mode == FeedMode::InverseTime
            && code != MotionCode::Rapid
            && request.find_word('F').is_none()
        {
            return Err(blame.refuse(Fault::NoInverseTime));
        }
        let turning = self.turning();
        self.check_tip_known(&turning, first)?;
        if self.turns_in_plane(line, &turning, coordinate)? {
            return Ok(None);
        }
        self.check_along_plane(&turning, first)?;
        let origin = self.origin(blame)?;
        self.check_steps(axes, origin)?;
        let start = self.position;
        let end = self.end_point(axes, origin)?;
        let centre = match code {
            MotionCode::Arc(_) => Some(self.centre(request, origin, blame)?),
            MotionCode::Rapid | MotionCode::Line | MotionCode::Cycle(_) => None,
        };
        let geometry = self.geometry(code, start, end, centre, blame)?;
        self.set_position(end);
        let (modal, span) = (self.modal, blame.span.clone());
        Ok(Some(Motion { line, modal, code, origin, start, end, turning, centre, geometry, words: Vec::new(), span }))
    }

    /// Refuses steps of Sinumerik's from a position before the zero changed to `origin`.
    fn check_steps(&mut self, axes: [Option<&Word>; 3], origin: Vector3<f64>) -> Result<(), Refusal> {
        for (axis, word) in axes.into_iter().enumerate() {
            let Some(word) = word.filter(|_| self.dialect == Dialect::Sinumerik) else { continue };
            let is_step = word.distance.unwrap_or(self.modal.distance) == Distance::Incremental;
            let before = self.zero_named[axis].replace(origin[axis]);
            if is_step && before.map_or(self.offsets.has_local_shift(), |before| before != origin[axis]) {
                return Err(word.refuse(Fault::Foreign(Foreign::StepToNewZero)));
            }
        }
        Ok(())
    }

    /// Returns the position (mm in W) that the axis words X, Y, Z of the line lead to, with the zero at `origin`.
    pub(crate) fn end_point(&self, axes: [Option<&Word>; 3], origin: Vector3<f64>) -> Result<PartialPosition, Refusal> {
        let mut end = self.position;
        for (axis, word) in axes.into_iter().enumerate() {
            let Some(word) = word else { continue };
            let value = word.value * self.modal.unit.mm();
            let to = match word.distance.unwrap_or(self.modal.distance) {
                Distance::Absolute => Some(value + origin[axis]),
                Distance::Incremental => self.position[axis].map(|from| value + from),
            };
            if to.unwrap_or(value).abs() > Fault::MAX_COORDINATE_MM {
                return Err(word.refuse(Fault::TooFar));
            }
            end[axis] = to;
        }
        Ok(end)
    }

    /// Returns the centre or radius of an arc by the words of its line, mm; errors without a word of their own point to `blame`.
    fn centre(&self, request: &Request, origin: Vector3<f64>, blame: &Word) -> Result<Centre, Refusal> {
        let [first, second, normal] = self.modal.plane.axes();
        let (plane, expected) = plane_names(self.modal.plane);
        let words = request.centre_words();
        // Some programs say K0 with every arc.
        if let Some(word) = words[normal].filter(|word| word.value != 0.0) {
            return Err(word.refuse(Fault::CentreOutsidePlane { expected, plane }));
        }
        let unit = self.modal.unit.mm();
        let given = [words[first], words[second]];
        for word in given.into_iter().flatten().chain(request.find_word('R')) {
            if word.value.abs() * unit > Fault::MAX_COORDINATE_MM {
                return Err(word.refuse(Fault::TooFar));
            }
        }
        let values = given.map(|word| word.map(|word| word.value * unit));
        let centres = given.map(|word| word.map(|word| word.distance.unwrap_or(self.modal.centres)));
        if let [Some(first), Some(second)] = centres
            && first != second
        {
            return Err(blame.refuse(Fault::MixedCentre));
        }
        let centres = centres[0].or(centres[1]).unwrap_or(self.modal.centres);
        match (values, request.find_word('R'), centres) {
            ([None, None], Some(word), _) => Ok(Centre::Radius(word.value * unit)),
            ([None, None], None, _) if self.dialect == Dialect::Heidenhain => {
                self.pole.map(Centre::Pole).ok_or_else(|| blame.refuse(Fault::NoPole))
            }
            ([None, None], None, _) => Err(blame.refuse(Fault::NoCentre { expected, plane })),
            (_, Some(word), _) => Err(word.refuse(Fault::CentreAndRadius)),
            ([i, j], None, Distance::Incremental) => Ok(Centre::FromStart([i.unwrap_or(0.0), j.unwrap_or(0.0)])),
            ([Some(i), Some(j)], None, Distance::Absolute) => Ok(Centre::At([i + origin[first], j + origin[second]])),
            (_, None, Distance::Absolute) => Err(blame.refuse(Fault::HalfCentre { expected, plane })),
        }
    }

    /// Returns the geometry from `start` to `end`. A straight move may start at an unknown position; an arc from there is unknown too.
    fn geometry(
        &self,
        code: MotionCode,
        start: PartialPosition,
        end: PartialPosition,
        centre: Option<Centre>,
        blame: &Word,
    ) -> Result<MotionGeometry, Refusal> {
        match (located(start), located(end), code) {
            (None, Some(end), MotionCode::Rapid | MotionCode::Line) => Ok(MotionGeometry::Arrival(end)),
            (Some(start), Some(end), _) => {
                motion_geometry(code, self.modal, start, end, centre).map_err(|fault| blame.refuse(Fault::Arc(fault)))
            }
            _ => Ok(MotionGeometry::Unlocated),
        }
    }

    /// Refuses I, J, K and R unless smoothing takes them.
    fn refuse_arc_words(&self, request: &Request) -> Result<(), Refusal> {
        match request.find_g(GWord::Smoothing) {
            Some(_) => Ok(()),
            None => request.refuse_arc_words(),
        }
    }
}

/// Returns the geometry from `start` to `end` (mm in W): a straight line, or an arc about `centre`. `Err` if there is no such arc.
pub(crate) fn motion_geometry(
    code: MotionCode,
    modal: ModalState,
    start: Vector3<f64>,
    end: Vector3<f64>,
    centre: Option<Centre>,
) -> Result<MotionGeometry, ArcFault> {
    match (code, centre) {
        (MotionCode::Arc(turn), Some(centre)) => {
            Ok(MotionGeometry::Arc(Arc::new(modal.plane, turn, start, end, centre, modal.unit)?))
        }
        _ => Ok(MotionGeometry::Line(start, end)),
    }
}

/// Returns the G word of a plane, and its two centre words, for messages.
fn plane_names(plane: Plane) -> (&'static str, &'static str) {
    match plane {
        Plane::Xy => ("G17", "I and J"),
        Plane::Zx => ("G18", "I and K"),
        Plane::Yz => ("G19", "J and K"),
    }
}
