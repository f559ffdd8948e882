//! Whether the machine can be led along a program at all: asked before anything bends.

use rayon::prelude::*;

use super::ProgramJob;
use crate::{
    compensation::Demand,
    study::{
        along_path::{BLOCK, parts},
        led_along::LedAlong,
    },
};

impl ProgramJob {
    /// The first points at which the tool cuts and to which the rigid machine cannot be led: index and reason. Their number is at most
    /// `most`, and nothing is looked at far beyond them.
    pub fn out_of_reach(&self, most: usize) -> Vec<(usize, String)> {
        for part in parts(self.demands.len()) {
            let blocks = part.into_par_iter().step_by(BLOCK);
            let mut found: Vec<_> = blocks.flat_map_iter(|start| self.out_of_reach_from(start, most)).collect();
            if !found.is_empty() {
                found.truncate(most);
                return found;
            }
        }
        Vec::new()
    }

    /// As [`ProgramJob::out_of_reach`], of the block that begins at `start`.
    fn out_of_reach_from(&self, start: usize, most: usize) -> Vec<(usize, String)> {
        let mut led = LedAlong::after(&self.machine, &self.demands[start.saturating_sub(BLOCK)..start]);
        let reason = |(k, demand): (usize, &Demand)| {
            let (_, asked) = led.step(demand);
            let status = asked.err().filter(|_| self.path.points()[k].cutting)?;
            Some((k, status.reason(&self.machine)))
        };
        self.demands.iter().enumerate().skip(start).take(BLOCK).filter_map(reason).take(most).collect()
    }
}
