//! Canned cycles of drilling, tapping and boring: where their holes are, and the way through them.
//!
//! All of them go over the hole, rapidly to the plane R, with the feed to Z (pecking or not), and back: to where the series of
//! holes began (G98), or to R (G99). Pecks and dwells are at places on that way.

use nalgebra::Vector3;

use crate::toolpath::{
    Plane,
    gcode::{
        error::{Fault, Refusal, Unsupported},
        interpret::Interpreter,
        lex::Word,
        modal::{Distance, MotionCode},
        motion::{Geometry, Known, Motion, located},
        request::Request,
    },
    path::direction,
};

/// The way through one hole, mm in the workpiece frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Hole {
    pub start: Vector3<f64>,
    /// Over the hole, as high as the tool comes.
    pub over: Vector3<f64>,
    /// At the plane R.
    pub clear: Vector3<f64>,
    pub bottom: Vector3<f64>,
    pub back: Vector3<f64>,
    /// Whether a series of holes begins here.
    pub is_first: bool,
}

impl Hole {
    /// Parameters of the corners of the way.
    const OVER: f64 = 0.125;
    const CLEAR: f64 = 0.25;
    const BOTTOM: f64 = 0.75;

    /// Parameters of its points; the feed into the hole is split into all but three of `pieces`.
    pub fn parameters(pieces: usize) -> impl Iterator<Item = f64> {
        let feeds = pieces.saturating_sub(3).max(1);
        let feed = move |k: usize| Hole::CLEAR + (Hole::BOTTOM - Hole::CLEAR) * (k as f64 / feeds as f64);
        [Hole::OVER, Hole::CLEAR].into_iter().chain((1..=feeds).map(feed)).chain([1.0])
    }

    /// Whether the tool feeds at parameter `t`.
    pub fn feeds_at(t: f64) -> bool {
        t > Hole::CLEAR && t <= Hole::BOTTOM
    }

    /// Position and unit tangent at `t` from 0 to 1.
    pub fn at(&self, t: f64) -> (Vector3<f64>, Vector3<f64>) {
        let (from, to, s) = match t {
            _ if t <= Hole::OVER => (self.start, self.over, t / Hole::OVER),
            _ if t <= Hole::CLEAR => (self.over, self.clear, (t - Hole::OVER) / (Hole::CLEAR - Hole::OVER)),
            _ if t <= Hole::BOTTOM => (self.clear, self.bottom, (t - Hole::CLEAR) / (Hole::BOTTOM - Hole::CLEAR)),
            _ => (self.bottom, self.back, (t - Hole::BOTTOM) / (1.0 - Hole::BOTTOM)),
        };
        (if s < 1.0 { from.lerp(&to, s) } else { to }, direction(to - from))
    }

    /// Length of the way as far as `t`, mm.
    pub fn length_to(&self, t: f64) -> f64 {
        let corners =
            [(0.0, self.start), (Hole::OVER, self.over), (Hole::CLEAR, self.clear), (Hole::BOTTOM, self.bottom)];
        let ways = corners.iter().zip([Hole::OVER, Hole::CLEAR, Hole::BOTTOM, 1.0]);
        let way = |((from, begins), ends): (&(f64, Vector3<f64>), f64)| {
            if t <= *from { 0.0 } else { (self.at(t.min(ends)).0 - begins).norm() }
        };
        ways.map(way).sum()
    }
}

/// What a cycle leaves for the next holes, mm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Cycle {
    /// The numbers of R and Z.
    clear: Option<f64>,
    depth: Option<f64>,
    /// The height at which the series began.
    initial: Option<f64>,
}

/// The most repetitions of one line.
const MOST_REPEATS: u32 = 10_000;

impl Interpreter {
    /// The holes that a line makes with a cycle in force.
    pub(super) fn drill(&mut self, line: usize, request: &Request) -> Result<Vec<Motion>, Refusal> {
        let MotionCode::Cycle(number) = self.modal.motion.unwrap_or(MotionCode::Rapid) else { return Ok(Vec::new()) };
        let axes = request.axes();
        let Some(first) = axes.into_iter().flatten().next().or_else(|| request.letter('R')) else {
            return Ok(Vec::new());
        };
        let blame = request.motion_word_itself().unwrap_or(first);
        // Of LinuxCNC and of lathes it is a cycle of threads.
        let is_thread = number == 76 && ['I', 'J', 'E', 'H'].iter().any(|letter| request.letter(*letter).is_some());
        if is_thread {
            return Err(blame.refuse(Fault::Unsupported(Unsupported::CannedCycle)));
        }
        if let Some((letter, at)) = self.turned_axis() {
            return Err(blame.refuse(Fault::TurnedCycle { letter, at }));
        }
        if self.modal.plane != Plane::Xy {
            return Err(blame.refuse(Fault::CyclePlane));
        }
        self.take_unit(line);
        let mm = self.modal.unit.mm();
        let origin = self.origin(blame)?;
        let mut cycle = self.cycle.unwrap_or_default();
        let is_first = cycle.initial.is_none();
        let number_of = |letter| request.letter(letter).map(|word: &Word| word.value * mm);
        cycle.clear = number_of('R').or(cycle.clear);
        cycle.depth = number_of('Z').or(cycle.depth);
        let repeats = repeats(request)?;
        if repeats == 0 {
            // Nothing is drilled, but R and Z stay for the lines that follow.
            self.cycle = Some(cycle);
            let here = self.position;
            return Ok(vec![self.hole(line, [here, here], Geometry::Unlocated, origin, blame)]);
        }
        let without = |letter| blame.refuse(Fault::CycleWithout { number, letter });
        let (clear, depth) = (cycle.clear.ok_or_else(|| without('R'))?, cycle.depth.ok_or_else(|| without('Z'))?);
        let steps = self.modal.distance == Distance::Incremental;
        if steps && self.modal.returns_to_clear && !is_first {
            return Err(blame.refuse(Fault::CycleSteps));
        }
        let mut motions = Vec::new();
        for _ in 0..if steps { repeats } else { 1 } {
            let start = self.position;
            let mut end = self.end([axes[0], axes[1], None], origin)?;
            cycle.initial = cycle.initial.or(start[2]);
            let clear = if steps { start[2].map(|from| from + clear) } else { Some(clear + origin.z) };
            let bottom = clear.map(|clear| depth + if steps { clear } else { origin.z });
            let back = match (self.modal.returns_to_clear, cycle.initial, clear) {
                (true, ..) => clear,
                (false, Some(initial), Some(clear)) => Some(initial.max(clear)),
                _ => None,
            };
            for height in [clear, bottom].into_iter().flatten() {
                if height.abs() > Fault::MAX_COORDINATE_MM {
                    return Err(blame.refuse(Fault::TooFar));
                }
            }
            end[2] = back;
            let heights = (located(start), clear, bottom, located(end));
            let geometry = match heights {
                (Some(start), Some(clear), Some(bottom), Some(back)) => {
                    let at = |z| Vector3::new(back.x, back.y, z);
                    let over = at(start.z.max(clear));
                    Geometry::Hole(Hole {
                        start,
                        over,
                        clear: at(clear),
                        bottom: at(bottom),
                        back,
                        is_first: is_first && motions.is_empty(),
                    })
                }
                _ => Geometry::Unlocated,
            };
            self.arrive(end);
            motions.push(self.hole(line, [start, end], geometry, origin, blame));
        }
        self.cycle = Some(cycle);
        Ok(motions)
    }

    fn hole(
        &self,
        line: usize,
        [start, end]: [Known; 2],
        geometry: Geometry,
        origin: Vector3<f64>,
        blame: &Word,
    ) -> Motion {
        let (modal, span) = (self.modal, blame.span.clone());
        let code = modal.motion.unwrap_or(MotionCode::Rapid);
        Motion {
            line,
            modal,
            code,
            origin,
            start,
            end,
            turning: self.turning(),
            centre: None,
            geometry,
            words: Vec::new(),
            span,
        }
    }
}

/// How often the line is done: L, or K that is no peck.
fn repeats(request: &Request) -> Result<u32, Refusal> {
    let is_peck = request.letter('I').is_some() || request.letter('J').is_some();
    let word = request.letter('L').or_else(|| request.letter('K').filter(|_| !is_peck));
    let Some(word) = word else { return Ok(1) };
    match word.whole()? {
        repeats @ 0..=MOST_REPEATS => Ok(repeats),
        _ => Err(word.refuse(Fault::TooManyRepeats { most: MOST_REPEATS })),
    }
}
