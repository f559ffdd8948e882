//! What a written program does, beside no compensation, whose sources are told apart, and other methods.

use nalgebra::Vector3;

use super::{Part, Pass, ProgramCommands, ProgramJob, Written};
use crate::{
    compensation::Method,
    input::error::Result,
    study::{
        BySource, Machines, Source,
        along_path::{Commands, PathAnswer, PathSums, run_where_led},
    },
};

/// Passes over a program.
#[derive(Debug, Clone)]
pub struct Proof {
    /// Without compensation.
    pub none: Pass,
    /// By the other methods, in their order.
    pub others: Vec<Pass>,
    /// As written.
    pub as_written: Pass,
}

/// Points of a program that follow one another, and what the tool does there.
#[derive(Debug)]
pub struct ProvedPart<'a> {
    /// The points.
    pub part: &'a Part<'a>,
    /// Displacements from the path without compensation under each source, base axes, mm; `None` where the machine does not settle.
    pub before: &'a BySource<Vec<Option<Vector3<f64>>>>,
    /// The program as written.
    pub written: &'a [PathAnswer],
}

impl ProgramJob {
    /// Passes over the program that [`ProgramJob::prove`] makes beside those of other methods.
    pub fn proof_passes(&self) -> usize {
        Source::of(&self.machine).len() + 1
    }

    /// What the program does as `written` under `name`, without compensation, and by `others`. All of this is computed part by part,
    /// as the machine is led along a part but once; `take` gets them in order. `done` is called after each point of each pass.
    ///
    /// # Errors
    /// Of `take`, or a machine that does not rest under its weight.
    pub fn prove(
        &self,
        (name, written): (String, &Written),
        others: &[Method],
        done: &(dyn Fn() + Sync),
        mut take: impl FnMut(&ProvedPart<'_>) -> Result<()>,
    ) -> Result<Proof> {
        let machines = Machines::new(&self.machine, &self.process.errors)?;
        let (mut none, mut other_sums, mut as_written) =
            (PathSums::default(), vec![PathSums::default(); others.len()], PathSums::default());
        let mut written_led = self.led();
        for part in self.parts() {
            let part = part?;
            let case = part.case([&self.machine, &self.real, &self.machine]);
            let led = self.led_along(&part, &case);
            let before = BySource::of(&self.machine, |source| {
                let asked = part.asked(|demand| source.demand(demand));
                let case = asked.case([machines.commanding(source), machines.answering(source), machines.resting()]);
                let answers = run_where_led(&case, &Commands::Method(Method::None), &led, done);
                if source == Source::All {
                    self.sum_up(&mut none, part.first, &answers);
                }
                answers.iter().map(PathAnswer::settled_error).collect()
            });
            for (method, sums) in others.iter().zip(&mut other_sums) {
                let answers = run_where_led(&case, &Commands::Method(*method), &led, done);
                self.sum_up(sums, part.first, &answers);
            }
            let commands = ProgramCommands::Sent(&written.sent);
            let answers = self
                .answers(&part, &mut written_led, &commands, &|commands| run_where_led(&case, commands, &led, done));
            self.sum_up(&mut as_written, part.first, &answers);
            take(&ProvedPart { part: &part, before: &before, written: &answers })?;
        }
        let pass = |name: String, sums: &PathSums| Pass { name, summary: sums.summary() };
        Ok(Proof {
            none: pass(Method::None.label(), &none),
            others: others.iter().zip(&other_sums).map(|(method, sums)| pass(method.label(), sums)).collect(),
            as_written: pass(name, &as_written),
        })
    }
}
