//! What a line with G0, G1, G2 or G3 in force does: where it leads, and on which way.

use nalgebra::Vector3;

use crate::toolpath::{
    model::{
        Plane, Way,
        gcode::{
            Arc, ArcFault, Centre, Dialect, Distance, Fault, FeedMode, GWord, Known, Modal, Motion, MotionCode,
            Refusal, Unsupported, Word, located,
        },
    },
    read::gcode::{Interpreter, Request},
};

impl Interpreter {
    /// The motion the line makes, if it has a coordinate, an angle of an axis that is followed or, for arcs, a centre. It may lead to where the
    /// tool is: the line is one for the control, which leads elsewhere once the lines before it are corrected.
    pub(crate) fn motion(&mut self, line: usize, request: &Request) -> Result<Option<Motion>, Refusal> {
        let axes = request.axes();
        let is_arc = matches!(self.modal.motion, Some(MotionCode::Arc(_)));
        if !is_arc || request.g(GWord::Dwell).is_some() {
            self.refuse_arc_words(request)?;
        }
        let coordinate = axes.iter().flatten().copied().next();
        let angle = || request.rotary().into_iter().flatten().find(|word| self.rotary_axes.has(word.letter));
        let Some(first) = coordinate.or_else(|| request.arc_words().next()).or_else(angle) else {
            return Ok(None);
        };
        if self.modal.motion.is_none() && coordinate.is_none() && !self.turning().turns() {
            return Ok(None);
        }
        if request.g(GWord::Dwell).is_some() {
            // X is how long; then nothing else may be on the line that would be a motion.
            let is_time = axes[1].is_none() && axes[2].is_none() && request.motion_word().is_none();
            return if is_time { Ok(None) } else { Err(first.refuse(Fault::NotACoordinate { word: "G4" })) };
        }
        if request.g(GWord::Smoothing).is_some() {
            return Err(first.refuse(Fault::Unsupported(Unsupported::Motion)));
        }
        // Its coordinates name axes, or set the origin of a lathe.
        if request.g(GWord::Passive("scaling")).or(request.g(GWord::Passive("mirroring"))).is_some() {
            return Err(first.refuse(Fault::NotACoordinate { word: "G50" }));
        }
        self.take_unit(line);
        let blame = request.motion_word_itself().unwrap_or(first);
        let code = self.modal.motion.ok_or_else(|| first.refuse(Fault::NoMotion))?;
        if self.modal.feed_mode == FeedMode::InverseTime && code != MotionCode::Rapid && request.letter('F').is_none() {
            return Err(blame.refuse(Fault::NoInverseTime));
        }
        let turning = self.turning();
        self.check_turning(&turning, first)?;
        let origin = self.origin(blame)?;
        let start = self.position;
        let end = self.end(axes, origin)?;
        let centre = match code {
            MotionCode::Arc(_) => Some(self.centre(request, origin, blame)?),
            MotionCode::Rapid | MotionCode::Line | MotionCode::Cycle(_) => None,
        };
        let geometry = self.geometry(code, start, end, centre, blame)?;
        self.arrive(end);
        let (modal, span) = (self.modal, blame.span.clone());
        Ok(Some(Motion { line, modal, code, origin, start, end, turning, centre, geometry, words: Vec::new(), span }))
    }

    /// Where the coordinates on the line lead to.
    pub(crate) fn end(&self, axes: [Option<&Word>; 3], origin: Vector3<f64>) -> Result<Known, Refusal> {
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

    /// The centre of an arc as its words give it.
    fn centre(&self, request: &Request, origin: Vector3<f64>, blame: &Word) -> Result<Centre, Refusal> {
        let [first, second, normal] = self.modal.plane.axes();
        let (plane, expected) = plane_names(self.modal.plane);
        let words = request.centres();
        // Some programs say K0 with every arc.
        if let Some(word) = words[normal].filter(|word| word.value != 0.0) {
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
        let centres = given.map(|word| word.map(|word| word.distance.unwrap_or(self.modal.centres)));
        if let [Some(first), Some(second)] = centres
            && first != second
        {
            return Err(blame.refuse(Fault::MixedCentre));
        }
        let centres = centres[0].or(centres[1]).unwrap_or(self.modal.centres);
        match (values, request.letter('R'), centres) {
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

    /// The way the motion takes. Straight moves may come from anywhere; of an arc from there, nothing is known.
    fn geometry(
        &self,
        code: MotionCode,
        start: Known,
        end: Known,
        centre: Option<Centre>,
        blame: &Word,
    ) -> Result<Way, Refusal> {
        match (located(start), located(end), code) {
            (None, Some(end), MotionCode::Rapid | MotionCode::Line) => Ok(Way::Arrival(end)),
            (Some(start), Some(end), _) => {
                route(code, self.modal, start, end, centre).map_err(|fault| blame.refuse(Fault::Arc(fault)))
            }
            _ => Ok(Way::Unlocated),
        }
    }

    /// I, J, K and R mean something on arcs, and some to G4, G10 and smoothing.
    fn refuse_arc_words(&self, request: &Request) -> Result<(), Refusal> {
        match request.g(GWord::Smoothing) {
            Some(_) => Ok(()),
            None => request.refuse_arc_words(),
        }
    }
}

/// The way from `start` to `end` that a controller takes: straight, or round the centre.
pub(crate) fn route(
    code: MotionCode,
    modal: Modal,
    start: Vector3<f64>,
    end: Vector3<f64>,
    centre: Option<Centre>,
) -> Result<Way, ArcFault> {
    match (code, centre) {
        (MotionCode::Arc(turn), Some(centre)) => Ok(Way::Arc(Arc::new(modal.plane, turn, start, end, centre)?)),
        _ => Ok(Way::Line(start, end)),
    }
}

/// The names of a plane and of its two centre words.
fn plane_names(plane: Plane) -> (&'static str, &'static str) {
    match plane {
        Plane::Xy => ("G17", "I and J"),
        Plane::Zx => ("G18", "I and K"),
        Plane::Yz => ("G19", "J and K"),
    }
}
