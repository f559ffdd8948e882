//! Whether the machine can be led along a program at all: asked before anything bends.

use super::{Part, ProgramJob};
use crate::{
    input::error::Result,
    machine::Configuration,
    simulation::{
        along_path::{BLOCK, last_of_blocks, lead},
        led_along::LedPoint,
    },
};

impl ProgramJob {
    /// The first points at which the tool cuts and to which the rigid machine cannot be led: index and reason. Their number is at most
    /// `most`, and nothing is looked at far beyond them. `done` is called with the number of points looked at, after each part.
    ///
    /// # Errors
    /// As [`ProgramJob::parts`].
    pub fn out_of_reach(&self, most: usize, mut done: impl FnMut(usize)) -> Result<Vec<(usize, String)>> {
        let mut before = None;
        for part in self.parts() {
            let part = part?;
            let found = self.out_of_reach_in(&part, &mut before, most);
            done(part.points.len());
            if !found.is_empty() {
                return Ok(found);
            }
        }
        Ok(Vec::new())
    }

    fn out_of_reach_in(
        &self,
        part: &Part<'_>,
        before: &mut Option<Configuration>,
        most: usize,
    ) -> Vec<(usize, String)> {
        let is_out = |k: usize, at: &LedPoint| part.points[k].cutting && at.asked.is_err();
        let out = |start: usize, led: &[LedPoint]| (start..).zip(led).filter(|(k, at)| is_out(*k, at)).count();
        // What is out of reach takes longest.
        let led = lead(&self.machine, before.as_ref(), part.demands(), |start, led| {
            led.last().is_none_or(|at| at.asked.is_ok()) || out(start, led) < most
        });
        let mut found = Vec::new();
        for (start, led) in (0..).step_by(BLOCK).zip(&led) {
            for (k, at) in (start..).zip(led) {
                if let (true, Err(status)) = (is_out(k, at), &at.asked) {
                    found.push((part.first + k, status.reason(&self.machine)));
                }
            }
        }
        if found.is_empty() {
            *before = last_of_blocks(&led).cloned().or(before.take());
            self.keep_led(part, led);
        }
        found.truncate(most);
        found
    }
}
