//! Whether the machine can be led along a program at all: asked before anything bends.

use rayon::prelude::*;

use super::{Part, ProgramJob};
use crate::{input::error::Result, study::along_path::BLOCK};

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
        let of_block = |start: usize| {
            let (mut led, mut out) = (Vec::with_capacity(BLOCK), Vec::new());
            for (k, (point, at)) in part.points[start..].iter().zip(case.led_block(start)).enumerate() {
                if let (true, Err(status)) = (point.cutting, &at.asked) {
                    out.push((part.first + start + k, status.reason(&self.machine)));
                }
                led.push(at);
                // What is out of reach takes longest.
                if out.len() == most {
                    break;
                }
            }
            (led, out)
        };
        let blocks = (0..part.points.len()).into_par_iter().step_by(BLOCK);
        let (led, out): (Vec<_>, Vec<_>) = blocks.map(of_block).unzip();
        let mut found = out.concat();
        if found.is_empty() {
            self.keep_led(part, led);
        }
        found.truncate(most);
        found
    }
}
