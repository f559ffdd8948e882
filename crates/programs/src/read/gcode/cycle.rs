//! Canned cycles of drilling, tapping and boring: their holes and the way through them.
//!
//! All go over the hole, rapidly to plane R, at feed to Z with pecks and dwells, and back to the height where the series began (G98) or R (G99).

use nalgebra::Vector3;

use crate::{
    model::{
        Hole, MotionGeometry, Plane,
        gcode::{Distance, Fault, FeedMode, Motion, MotionCode, PartialPosition, Refusal, Unsupported, Word, located},
    },
    read::gcode::{Interpreter, Request},
};

/// Parameters of the cycle in force, mm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Cycle {
    /// Numbers of R and Z.
    clear: Option<f64>,
    depth: Option<f64>,
    /// Height at which the series of holes began.
    initial: Option<f64>,
}

/// Most repetitions of a line.
const MAX_REPEATS: u32 = 10_000;

impl Interpreter {
    /// Drills with the cycle in force: returns the motions of line `line` (from 1), one for each hole. `Err` for what cannot be drilled.
    pub(crate) fn drill(&mut self, line: usize, request: &Request) -> Result<Vec<Motion>, Refusal> {
        let MotionCode::Cycle(number) = self.modal.motion.unwrap_or(MotionCode::Rapid) else { return Ok(Vec::new()) };
        let axes = request.axis_words();
        let Some(first) = axes.into_iter().flatten().next().or_else(|| request.find_word('R')) else {
            return Ok(Vec::new());
        };
        let blame = request.motion_word_source().unwrap_or(first);
        self.check_cycle(number, request, blame)?;
        self.note_unit(line);
        let mm = self.modal.unit.mm();
        let origin = self.origin(blame)?;
        let mut cycle = self.cycle.unwrap_or_default();
        let is_first = cycle.initial.is_none();
        let number_of = |letter| request.find_word(letter).map(|word: &Word| word.value * mm);
        cycle.clear = number_of('R').or(cycle.clear);
        cycle.depth = number_of('Z').or(cycle.depth);
        let repeats = repeat_count(request)?;
        if repeats == 0 {
            // Nothing is drilled, but R and Z stay for the lines that follow.
            self.cycle = Some(cycle);
            let here = self.position;
            return Ok(vec![self.cycle_motion(line, [here, here], MotionGeometry::Unlocated, origin, blame)]);
        }
        let without = |letter| blame.refuse(Fault::CycleWithout { number, letter });
        let (clear, depth) = (cycle.clear.ok_or_else(|| without('R'))?, cycle.depth.ok_or_else(|| without('Z'))?);
        // What stands in brackets counts from the zero, and with it the height to which the tool comes back.
        let retract = number_of(Word::RETRACT).map(|retract| retract + origin.z);
        let steps = self.modal.distance == Distance::Incremental && retract.is_none();
        if steps && self.modal.returns_to_r_plane && !is_first {
            return Err(blame.refuse(Fault::CycleSteps));
        }
        let mut motions = Vec::new();
        for _ in 0..if steps { repeats } else { 1 } {
            let mut start = self.position;
            // Wherever it comes from, it goes from here to the cycle's own heights.
            start[2] = start[2].or(retract);
            let mut end = self.end_point([axes[0], axes[1], None], origin)?;
            cycle.initial = retract.or(cycle.initial).or(start[2]);
            let clear = if steps { start[2].map(|from| from + clear) } else { Some(clear + origin.z) };
            let bottom = clear.map(|clear| depth + if steps { clear } else { origin.z });
            let back = match (self.modal.returns_to_r_plane, cycle.initial, clear) {
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
                    MotionGeometry::Hole(Hole {
                        start,
                        over,
                        clear: at(clear),
                        bottom: at(bottom),
                        back,
                        is_first: is_first && motions.is_empty(),
                    })
                }
                _ => MotionGeometry::Unlocated,
            };
            self.set_position(end);
            motions.push(self.cycle_motion(line, [start, end], geometry, origin, blame));
        }
        self.cycle = Some(cycle);
        if retract.is_some() {
            let feed = request.find_word(Word::TAP_FEED).map(|word| word.value).filter(|feed| *feed > 0.0);
            for modal in motions.iter_mut().map(|motion| &mut motion.modal) {
                modal.feed_mode = FeedMode::PerMinute;
                modal.feed = feed.map(|feed| feed * mm);
            }
            (self.modal.motion, self.cycle) = (self.motion_before_cycle, None);
        }
        Ok(motions)
    }

    /// Refuses cycle `number` at the word `blame` where it makes threads, or the tool does not stand along Z of the plane.
    fn check_cycle(&self, number: u32, request: &Request, blame: &Word) -> Result<(), Refusal> {
        // Of LinuxCNC and of lathes it is a cycle of threads.
        let is_thread = number == 76 && ['I', 'J', 'E', 'H'].iter().any(|letter| request.find_word(*letter).is_some());
        if is_thread {
            return Err(blame.refuse(Fault::Unsupported(Unsupported::CannedCycle)));
        }
        let turning = self.turning();
        self.check_along_plane(&turning, blame)?;
        if let Some((letter, at)) = self.nonzero_rotary_axis().filter(|_| self.inclined.is_none() || turning.turns()) {
            return Err(blame.refuse(Fault::TurnedCycle { letter, at }));
        }
        if self.modal.plane != Plane::Xy {
            return Err(blame.refuse(Fault::CyclePlane));
        }
        Ok(())
    }

    /// Creates the motion of the cycle from `start` to `end`; `blame` is the word to which errors point.
    fn cycle_motion(
        &self,
        line: usize,
        [start, end]: [PartialPosition; 2],
        geometry: MotionGeometry,
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

/// Returns the number of repetitions of the line: L, or K unless it is a peck; 1 without them.
fn repeat_count(request: &Request) -> Result<u32, Refusal> {
    let is_peck = request.find_word('I').is_some() || request.find_word('J').is_some();
    let word = request.find_word('L').or_else(|| request.find_word('K').filter(|_| !is_peck));
    let Some(word) = word else { return Ok(1) };
    match word.whole_number()? {
        repeats @ 0..=MAX_REPEATS => Ok(repeats),
        _ => Err(word.refuse(Fault::TooManyRepeats { most: MAX_REPEATS })),
    }
}
