//! How sure the machined surface is where inputs are uncertain: the stock is cut again in draws, as the engine says that the tool goes in them.
//!
//! Each draw is one machine and one force for the whole program.

use std::collections::{BTreeMap, BTreeSet};

use kinetostat_removal::Patch;
use nalgebra::Vector3;
use rayon::prelude::*;

use super::{ProgramAsWritten, ProgramJob};
use crate::{
    input::error::Result,
    process::{
        machined::{Course, GOUGE_MM, Left, MachinedSurface},
        stock::StockRemoval,
        uncertainty::{Draws, P95, quantile},
    },
    simulation::{
        Failure,
        spread_along::{Command, SpreadPart, SpreadPath},
    },
    work::{Event, Stage, Work},
};

/// Distribution of the machined surface over draws, without compensation and as written: against the part where one is given, else against the programmed surface.
#[derive(Debug)]
pub(super) struct SurfaceSpread {
    /// Number of draws in which the stock was cut.
    pub draws: usize,
    pub courses: [CourseSpread; 2],
}

/// Distribution of the surface that one course of the tool leaves.
#[derive(Debug)]
pub(super) struct CourseSpread {
    /// Number of draws without equilibrium somewhere: they count as out of tolerance, and in no quantile. Why the first of them has none.
    pub failed: usize,
    pub first_failure: Option<String>,
    /// Quantiles of 5 % and 95 % of how far the surface is beyond each patch, mm; `None` where it is not known.
    pub ranges_mm: Vec<Option<[f64; 2]>>,
    /// Most material left and most missing anywhere that are not exceeded with 95 % probability, each by itself, mm; not a number where all draws failed.
    pub most_mm: [f64; 2],
    /// Most left or missing anywhere that is not exceeded with 95 % probability, mm, draws without an equilibrium exceeding all; `None` where these are too many.
    pub worst_mm: Option<f64>,
    /// Number of draws in which all of the surface is within its tolerance, and in which nothing of it is missing by more; `None` without one.
    pub within: Option<[usize; 2]>,
    /// Number of draws in which a line takes more than the tolerance too much, by the index of its move; the likeliest first.
    pub gouges: Vec<(usize, usize)>,
}

/// Most points at which draws are solved and patches that are looked at in all of them, if they are more than the fewest; of one scramble, halved.
const MAX_POINTS: usize = 2_000_000;
const MAX_PATCHES: usize = 10_000_000;
const FEWEST_DRAWS: usize = 32;
/// Probability with which nothing is below the lower of the quantiles of a place.
const P05: f64 = 1.0 - P95;

/// Tolerance of a patch, mm.
type ToleranceOf<'a> = dyn Fn(&Patch) -> Option<f64> + Sync + 'a;

/// The surface whose distribution is wanted.
struct Wanted<'a> {
    job: &'a ProgramJob,
    stock: &'a StockRemoval,
    surface: &'a MachinedSurface,
    /// Rotations of the tool with nominal inputs, W, by course.
    rotations: &'a [Vec<Vector3<f64>>; 2],
    tolerance_mm: &'a ToleranceOf<'a>,
    path: &'a SpreadPath<'a>,
    written: &'a ProgramAsWritten,
    work: &'a Work,
}

impl ProgramJob {
    /// Returns the distribution of the `surface` that the program leaves, as `written` and without compensation; `None` where inputs are taken as exact.
    ///
    /// # Errors
    /// Of `work`; a field of removal too large.
    pub(super) fn surface_spread(
        &self,
        surface: &MachinedSurface,
        rotations: &[Vec<Vector3<f64>>; 2],
        written: &ProgramAsWritten,
        tolerance_mm: &ToleranceOf<'_>,
        work: &Work,
    ) -> Result<Option<SurfaceSpread>> {
        let (Some(drawn), Some(stock)) = (self.drawn(&self.machines)?, &self.process.stock) else { return Ok(None) };
        let passes = &self.passes()[..];
        let path = SpreadPath { margin_mm: written.rounded_mm, passes, ..self.spread(&drawn) };
        let wanted = Wanted { job: self, stock, surface, rotations, tolerance_mm, path: &path, written, work };
        let mut draws = Draws::PER_SCRAMBLE;
        while draws > FEWEST_DRAWS
            && (draws * self.path.len() > MAX_POINTS || draws * surface.patches.len() > MAX_PATCHES)
        {
            draws /= 2;
        }
        work.tell(Event::Stage(Stage { of: "surfaces of draws", items: 2 * draws }));
        let courses = [wanted.course(Command::Plain, draws)?, wanted.course(Command::Compensated, draws)?];
        Ok(Some(SurfaceSpread { draws, courses }))
    }
}

impl Wanted<'_> {
    /// Index of the tool that moves to the point `k`, as draws have it.
    fn tool_index(&self, k: usize) -> usize {
        let point = &self.job.path.points()[k];
        self.path.drawn.uncertainty.tool_index(point.tool.filter(|_| point.cutting))
    }

    fn course(&self, command: Command, draws: usize) -> Result<CourseSpread> {
        let patches = &self.surface.patches;
        let (mut all, mut most, mut failed) = (Vec::with_capacity(draws), [Vec::new(), Vec::new()], 0);
        // Draws in which something is out of tolerance, and in which it is missing.
        let (mut out, mut gouged, mut lines) = (0, 0, BTreeMap::<usize, usize>::new());
        let (mut first_failure, mut worst) = (None, Vec::with_capacity(draws));
        let has_tolerance = patches.iter().any(|patch| (self.tolerance_mm)(patch).is_some());
        for draw in 0..draws {
            self.work.check()?;
            let found = self.cut(draw, command)?;
            self.work.tell(Event::Computed(1));
            let (off, makers) = match found {
                Ok(found) => found,
                Err(failure) => {
                    (failed, out, gouged) = (failed + 1, out + 1, gouged + 1);
                    first_failure.get_or_insert(failure.reason);
                    worst.push(f64::INFINITY);
                    continue;
                }
            };
            let (mut extremes, mut is_out, mut own_lines) = ([0.0f64; 2], false, BTreeSet::new());
            let mut is_gouged = false;
            for ((patch, off), maker) in patches.iter().zip(&off).zip(&makers) {
                let Some(off) = off.filter(|own| patch.tag.is_some() || *own < -GOUGE_MM) else { continue };
                extremes = [extremes[0].max(off), extremes[1].max(-off)];
                let Some(tolerance) = (self.tolerance_mm)(patch) else { continue };
                is_out |= off.abs() > tolerance;
                if off < -tolerance {
                    is_gouged = true;
                    own_lines.extend(maker.map(|point| self.job.path.points()[point as usize].source.segment));
                }
            }
            worst.push(extremes[0].max(extremes[1]));
            most.iter_mut().zip(extremes).for_each(|(most, own)| most.push(own));
            (out, gouged) = (out + usize::from(is_out), gouged + usize::from(is_gouged));
            own_lines.into_iter().for_each(|line| *lines.entry(line).or_default() += 1);
            all.push(off.iter().map(|own| own.map_or(f32::NAN, |own| own as f32)).collect::<Vec<_>>());
        }
        let range = |k: usize| {
            let mut values: Vec<f64> = all.iter().map(|own| f64::from(own[k])).collect();
            let is_known = !values.is_empty() && values.iter().all(|own| own.is_finite());
            is_known.then(|| [P05, P95].map(|share| quantile(&mut values, share)))
        };
        let mut gouges: Vec<(usize, usize)> = lines.into_iter().collect();
        gouges.sort_by_key(|own| std::cmp::Reverse(own.1));
        Ok(CourseSpread {
            failed,
            first_failure,
            ranges_mm: (0..patches.len()).into_par_iter().map(range).collect(),
            most_mm: most.map(|mut own| quantile(&mut own, P95)),
            worst_mm: Some(quantile(&mut worst, P95)).filter(|own| own.is_finite()),
            within: has_tolerance.then(|| [out, gouged].map(|count| draws - count)),
            gouges,
        })
    }

    /// The surface that is left where the tool goes as in a draw, or why the machine has no equilibrium somewhere.
    fn cut(&self, draw: usize, command: Command) -> Result<std::result::Result<Left, Failure>> {
        let each = |take: &mut dyn FnMut(&SpreadPart<'_>) -> Result<()>| self.job.each_part(self.written, take);
        let errors = self
            .path
            .drawn
            .on_draw(draw, |machines| self.path.errors_along(&each, (draw, machines), command, self.work));
        let errors = match errors {
            Ok(errors) => errors?.into_iter().collect::<std::result::Result<Vec<_>, _>>(),
            Err(failure) => Err(failure),
        };
        let errors = match errors {
            Ok(errors) => errors,
            Err(failure) => return Ok(Err(failure)),
        };
        let turn = self.job.process.placement.place(&self.job.machine).workpiece().rotation;
        let course: Vec<Option<Vector3<f64>>> = errors.iter().map(|own| Some(turn.tr_mul(own))).collect();
        let draws = &self.path.drawn.uncertainty.draws;
        let factor = |k: usize| draws.factors(self.tool_index(k), draw).all;
        let rotations = &self.rotations[usize::from(command == Command::Compensated)];
        let course = Course { errors_mm: &course, rotations };
        let (deviations, makers) = self.stock.deviations(
            &self.job.path,
            &self.surface.axes,
            &self.surface.patches,
            course,
            &factor,
            &self.job.name,
        )?;
        let against = self.stock.against_part(self.surface, &deviations);
        Ok(Ok((against.unwrap_or(deviations), makers)))
    }
}
