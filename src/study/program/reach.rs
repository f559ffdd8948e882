//! Whether the machine can be led along a program at all: asked before anything bends.

use rayon::prelude::*;

use super::{Part, ProgramJob, part::LedPart};
use crate::{
    input::error::Result,
    study::{
        along_path::{BLOCK, together},
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
        for part in self.parts() {
            let part = part?;
            let found = self.out_of_reach_in(&part, most);
            done(part.points.len());
            if !found.is_empty() {
                return Ok(found);
            }
        }
        Ok(Vec::new())
    }

    fn out_of_reach_in(&self, part: &Part<'_>, most: usize) -> Vec<(usize, String)> {
        let case = part.case([&self.machine, &self.real, &self.machine]);
        let is_out = |k: usize, at: &LedPoint| part.points[k].cutting && at.asked.is_err();
        let of_blocks = |starts: &[usize]| {
            let mut counts = vec![(0, 0); starts.len()];
            case.led_blocks(starts, |block, at| {
                let (seen, out) = &mut counts[block];
                *out += usize::from(is_out(starts[block] + *seen, at));
                *seen += 1;
                // What is out of reach takes longest.
                *out < most
            })
        };
        let starts: Vec<usize> = (0..part.points.len()).step_by(BLOCK).collect();
        let led: LedPart = starts.par_chunks(together(starts.len())).flat_map_iter(of_blocks).collect();
        let mut found = Vec::new();
        for (start, led) in starts.iter().zip(&led) {
            for (k, at) in (*start..).zip(led) {
                if let (true, Err(status)) = (is_out(k, at), &at.asked) {
                    found.push((part.first + k, status.reason(&self.machine)));
                }
            }
        }
        if found.is_empty() {
            self.keep_led(part, led);
        }
        found.truncate(most);
        found
    }
}
