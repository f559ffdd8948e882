//! Canned cycles of drilling, tapping and boring: where their holes are, and the way through them.
//!
//! All of them go over the hole, rapidly to the plane R, with the feed to Z (pecking or not), and back: to where the series of
//! holes began (G98), or to R (G99). Pecks and dwells are at places on that way.

use nalgebra::Vector3;

use crate::toolpath::{
    model::{
        Hole, Plane, Way,
        gcode::{Distance, Fault, Known, Motion, MotionCode, Refusal, Unsupported, Word, located},
    },
    read::gcode::{Interpreter, Request},
};

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
    pub(crate) fn drill(&mut self, line: usize, request: &Request) -> Result<Vec<Motion>, Refusal> {
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
            return Ok(vec![self.hole(line, [here, here], Way::Unlocated, origin, blame)]);
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
                    Way::Hole(Hole {
                        start,
                        over,
                        clear: at(clear),
                        bottom: at(bottom),
                        back,
                        is_first: is_first && motions.is_empty(),
                    })
                }
                _ => Way::Unlocated,
            };
            self.arrive(end);
            motions.push(self.hole(line, [start, end], geometry, origin, blame));
        }
        self.cycle = Some(cycle);
        Ok(motions)
    }

    fn hole(&self, line: usize, [start, end]: [Known; 2], geometry: Way, origin: Vector3<f64>, blame: &Word) -> Motion {
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
