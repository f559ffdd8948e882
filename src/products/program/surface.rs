//! How sure the machined surface is where inputs are uncertain: the surface of nominal numbers, of which each place goes with the move that made it.
//!
//! Each draw is one machine and one force for the whole program. What is estimated so is held against draws in which the engine finds the way of the tool, and the
//! stock is cut again.

use std::collections::{BTreeMap, BTreeSet};

use kinetostat_removal::Patch;
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

use super::{ProgramAsWritten, ProgramJob};
use crate::{
    input::error::Result,
    process::{
        machined::{MachinedSurface, beyond_aimed},
        stock::StockRemoval,
        uncertainty::{Draws, P95, quantile},
    },
    simulation::{
        Machines,
        along_path::BLOCK,
        spread::DrawnMachines,
        spread_along::{Command, SpreadPart, SpreadPath},
    },
    work::{Event, Stage, Work},
};

/// Distribution of the machined surface over the draws, without compensation and as written.
#[derive(Debug)]
pub(super) struct SurfaceSpread {
    pub courses: [CourseSpread; 2],
}

/// Distribution of the surface that one course of the tool leaves.
#[derive(Debug)]
pub(super) struct CourseSpread {
    /// 95 % quantile of the distance of each patch from the programmed surface, to either side, mm; `None` where it is not known.
    pub p95_mm: Vec<Option<f64>>,
    /// Most material left and most missing anywhere, in each draw, mm.
    pub most_mm: [Vec<f64>; 2],
    /// Probability that a line takes more than the tolerance from the part anywhere, by the index of its move; the likeliest first. Empty without a tolerance.
    pub gouges: Vec<(usize, f64)>,
    /// Share of the draws in which all of the surface is within the tolerance, and in which nothing of it is missing by more.
    pub within: Option<[f64; 2]>,
    /// Draws that were cut again.
    pub recuts: Vec<Recut>,
}

/// A draw in which the stock was cut again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Recut {
    /// Most material left and most missing anywhere, mm, as estimated.
    pub estimated_mm: [f64; 2],
    /// The same, as cut; `None` where the machine has no equilibrium somewhere.
    pub cut_mm: Option<[f64; 2]>,
}

impl CourseSpread {
    /// Returns the most material left and the most missing anywhere that are not exceeded with 95 % probability, each by itself, mm.
    pub fn most_p95_mm(&self) -> [f64; 2] {
        self.most_mm.each_ref().map(|own| quantile(&mut own.clone(), P95))
    }
}

impl SurfaceSpread {
    /// Returns by how much more is left or missing in draws that were cut again than estimated, at most, mm, and whether that matters; `None` where one of them has no such surface.
    pub fn most_beyond(&self) -> Option<(f64, bool)> {
        let beyond = |own: &Recut| {
            let [left, missing] = own.cut_mm?;
            Some((left - own.estimated_mm[0]).max(missing - own.estimated_mm[1]))
        };
        let of = |own: &CourseSpread| {
            let most = own.recuts.iter().try_fold(0.0, |most: f64, own| Some(most.max(beyond(own)?)))?;
            let [left, missing] = own.most_p95_mm();
            Some((most, most > ALIKE * left.max(missing) + CLOSE_MM))
        };
        let [plain, written] = self.courses.each_ref().map(of);
        let ((a, a_matters), (b, b_matters)) = (plain?, written?);
        Some((a.max(b), a_matters || b_matters))
    }
}

/// Largest difference of an estimate that is not told first, as a share and in mm.
const ALIKE: f64 = 0.05;
const CLOSE_MM: f64 = 1e-3;

/// Shares of the draws at which the ones that are cut again are not exceeded by the largest distance.
const RECUTS: [f64; 4] = [0.5, 0.9, P95, 0.99];
/// Draws as bits.
const WORDS: usize = Draws::COUNT / 64;

/// What was found of the patches that some moves make.
struct Found {
    p95_mm: Vec<(usize, f64)>,
    most_mm: [Vec<f64>; 2],
    /// Draws in which something is off by more than its tolerance, and in which it is missing; `None` where nothing has one.
    beyond: Option<[Bits; 2]>,
    /// Draws in which a move takes more than the tolerance.
    gouged: BTreeMap<usize, Bits>,
}

/// A bit for each draw.
type Bits = [u64; WORDS];

/// Joins other bits to these.
fn unite(bits: &mut Bits, next: &Bits) {
    bits.iter_mut().zip(next).for_each(|(own, next)| *own |= next);
}

/// Share of the draws that have their bit.
fn share_of(bits: &Bits) -> f64 {
    f64::from(bits.iter().map(|own| own.count_ones()).sum::<u32>()) / Draws::COUNT as f64
}

impl Found {
    fn new() -> Self {
        let none = || vec![f64::NEG_INFINITY; Draws::COUNT];
        Self { p95_mm: Vec::new(), most_mm: [none(), none()], beyond: None, gouged: BTreeMap::new() }
    }

    /// Adds the patch `k` with its tolerance, which the move `segment` makes and which is off by these distances in the draws; on the skin of the stock only what is missing
    /// counts.
    fn add(
        &mut self,
        (k, is_skin, tolerance): (usize, bool, Option<f64>),
        segment: Option<usize>,
        off_mm: &[f64],
        sizes: &mut Vec<f64>,
    ) {
        let [left, missing] = &mut self.most_mm;
        for (draw, off) in off_mm.iter().enumerate() {
            left[draw] = if is_skin { left[draw] } else { left[draw].max(*off) };
            missing[draw] = missing[draw].max(-off);
        }
        sizes.clear();
        sizes.extend(off_mm.iter().map(|off| off.abs()));
        self.p95_mm.push((k, quantile(sizes, P95)));
        let Some(tolerance) = tolerance else { return };
        let (mut left, mut missing) = ([0; WORDS], [0; WORDS]);
        for (draw, off) in off_mm.iter().enumerate() {
            left[draw / 64] |= u64::from(!is_skin && *off > tolerance) << (draw % 64);
            missing[draw / 64] |= u64::from(*off < -tolerance) << (draw % 64);
        }
        let [out, gouged] = self.beyond.get_or_insert([[0; WORDS]; 2]);
        [&left, &missing].into_iter().for_each(|own| unite(out, own));
        unite(gouged, &missing);
        if let Some(segment) = segment.filter(|_| missing != [0; WORDS]) {
            unite(self.gouged.entry(segment).or_insert([0; WORDS]), &missing);
        }
    }

    fn join(mut self, next: Self) -> Self {
        self.p95_mm.extend(next.p95_mm);
        for (own, next) in self.most_mm.iter_mut().zip(next.most_mm) {
            own.iter_mut().zip(next).for_each(|(own, next)| *own = own.max(next));
        }
        if let Some(next) = next.beyond {
            let own = self.beyond.get_or_insert([[0; WORDS]; 2]);
            own.iter_mut().zip(&next).for_each(|(own, next)| unite(own, next));
        }
        for (segment, next) in next.gouged {
            unite(self.gouged.entry(segment).or_insert([0; WORDS]), &next);
        }
        self
    }
}

/// Tolerance of a patch, mm.
type ToleranceOf<'a> = dyn Fn(&Patch) -> Option<f64> + Sync + 'a;

/// The surface whose distribution is wanted.
struct Wanted<'a> {
    job: &'a ProgramJob,
    stock: &'a StockRemoval,
    surface: &'a MachinedSurface,
    tolerance_mm: &'a ToleranceOf<'a>,
    /// From axes of the patches to those of the base.
    turn: Matrix3<f64>,
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
        (written, tolerance_mm): (&ProgramAsWritten, &ToleranceOf<'_>),
        work: &Work,
    ) -> Result<Option<SurfaceSpread>> {
        let machines = Machines::new(&self.machine, &self.process.errors)?;
        let drawn = DrawnMachines::new(self.uncertainty.as_ref(), &machines, &self.process.errors)?;
        let (Some(drawn), Some(stock)) = (drawn, &self.process.stock) else { return Ok(None) };
        let counts = |_| true;
        let path = self.spread_path((&machines, &drawn), &counts, written);
        let turn = self.process.placement.place(&self.machine).workpiece().rotation * surface.axes.transpose();
        let wanted = Wanted { job: self, stock, surface, tolerance_mm, turn, path: &path, written, work };
        let courses = [(0, Command::Plain), (1, Command::Compensated)].map(|(course, command)| {
            let by_maker = wanted.patches_by_maker(course);
            work.tell(Event::Stage(Stage { of: "moves that make the surface", items: by_maker.len() }));
            wanted.course(course, command, &by_maker)
        });
        let [plain, written] = courses;
        Ok(Some(SurfaceSpread { courses: [plain?, written?] }))
    }
}

impl Wanted<'_> {
    /// Indices of the patches that the moves to each point make on a course, by the index of the point.
    fn patches_by_maker(&self, course: usize) -> BTreeMap<usize, Vec<usize>> {
        let mut all: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        let made = self.surface.makers[course].iter().enumerate();
        made.filter_map(|(k, maker)| Some((k, maker.as_ref()?.point)))
            .for_each(|(k, maker)| all.entry(maker as usize).or_default().push(k));
        all
    }

    /// Index of the tool that moves to the point `k`, as draws have it.
    fn tool_index(&self, k: usize) -> usize {
        let point = &self.job.path.points()[k];
        self.path.drawn.uncertainty.tool_index(point.tool.filter(|_| point.cutting))
    }

    fn course(&self, course: usize, command: Command, by_maker: &BTreeMap<usize, Vec<usize>>) -> Result<CourseSpread> {
        let surface = self.surface;
        let mut found = Found::new();
        // What no draw changes: what programs before have made.
        for (k, (patch, deviation)) in surface.patches.iter().zip(&surface.deviations[course]).enumerate() {
            if let (None, Some(deviation)) = (surface.makers[course][k], deviation.filter(|own| *own != 0.0)) {
                let own = (k, patch.tag.is_none(), (self.tolerance_mm)(patch));
                found.add(own, None, &[deviation; Draws::COUNT], &mut Vec::new());
            }
        }
        self.job.each_part(self.written, &mut |part| {
            let points: Vec<usize> =
                (0..part.tasks.len()).filter(|k| by_maker.contains_key(&(part.first + k))).collect();
            let makers = points.par_chunks(BLOCK / 2);
            let blocks = makers.map(|makers| self.block(course, command, (part, makers), by_maker));
            for block in blocks.collect::<Result<Vec<_>>>()? {
                let all = std::mem::replace(&mut found, Found::new());
                found = all.join(block);
            }
            Ok(())
        })?;
        let mut p95_mm = vec![None; surface.patches.len()];
        found.p95_mm.iter().for_each(|(k, own)| p95_mm[*k] = Some(*own));
        let gouges = found.gouged.iter().map(|(segment, bits)| (*segment, share_of(bits)));
        let mut gouges: Vec<(usize, f64)> = gouges.collect();
        gouges.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let within = found.beyond.as_ref().map(|own| own.each_ref().map(|bits| 1.0 - share_of(bits)));
        let [left, missing] = &found.most_mm;
        let largest: Vec<f64> = left.iter().zip(missing).map(|(a, b)| a.max(*b)).collect();
        let mut order: Vec<usize> = (0..Draws::COUNT).collect();
        order.sort_by(|a, b| largest[*a].total_cmp(&largest[*b]));
        let recut = |share: f64| {
            let draw = order[((share * Draws::COUNT as f64) as usize).min(Draws::COUNT - 1)];
            let cut_mm = self.recut(draw, command)?;
            Ok(Recut { estimated_mm: found.most_mm.each_ref().map(|own| own[draw]), cut_mm })
        };
        let recuts = RECUTS.into_iter().map(recut).collect::<Result<Vec<_>>>()?;
        Ok(CourseSpread { p95_mm, most_mm: found.most_mm, gouges, within, recuts })
    }

    /// Finds what the moves to the points `makers` of `part` make, between the points before and these.
    fn block(
        &self,
        course: usize,
        command: Command,
        (part, makers): (&SpreadPart<'_>, &[usize]),
        by_maker: &BTreeMap<usize, Vec<usize>>,
    ) -> Result<Found> {
        let ends: BTreeSet<usize> = makers.iter().flat_map(|k| [k.saturating_sub(1), *k]).collect();
        let ends: Vec<usize> = ends.into_iter().collect();
        let surrogates = part.with_only(&self.job.machine, &ends, |part| {
            self.path.surrogates(part, (&(0..ends.len()), command), self.work)
        })?;
        let (draws, path, axes) = (&self.path.drawn.uncertainty.draws, &self.job.path, &self.surface.axes);
        let (mut found, mut off, mut sizes) = (Found::new(), vec![0.0; Draws::COUNT], Vec::new());
        let mut before: Option<(usize, Vec<[f64; 3]>)> = None;
        for (point, surrogate) in ends.iter().zip(surrogates) {
            let moved = surrogate.map(|own| own.displacements(draws));
            let begun = before.take().filter(|own| own.0 + 1 == *point);
            before = moved.map(|moved| (*point, moved));
            let (Some((_, moved)), Ok(_)) = (&before, makers.binary_search(point)) else { continue };
            let end = &path.points()[part.first + point];
            let line = begun.as_ref().map(|(_, begun)| {
                let from = &path.points()[part.first + point - 1];
                (axes * from.position_mm, axes * (end.position_mm - from.position_mm), begun)
            });
            for &k in &by_maker[&(part.first + point)] {
                let patch = &self.surface.patches[k];
                let (Some(deviation), Some(maker)) =
                    (self.surface.deviations[course][k], self.surface.makers[course][k])
                else {
                    continue;
                };
                let normal: Vector3<f64> = self.turn * maker.normal;
                // Where on the way the tool makes it.
                let share = line.map_or(1.0, |(from, way, _)| {
                    ((patch.position - from).dot(&way) / way.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0)
                });
                off.fill(deviation);
                let ways = [(Some(moved), share), (line.map(|own| own.2), 1.0 - share)];
                for (moved, share) in ways.into_iter().filter_map(|(moved, share)| Some((moved?, share))) {
                    let [x, y, z]: [f64; 3] = (share * normal).into();
                    off.iter_mut().zip(moved).for_each(|(off, own)| *off += x * own[0] + y * own[1] + z * own[2]);
                }
                if let Some(tag) = patch.tag {
                    let beyond = beyond_aimed(path, tag as usize, axes, patch);
                    let factors = draws.force_of(self.tool_index(tag as usize));
                    off.iter_mut().zip(factors).for_each(|(off, factor)| *off += (factor - 1.0) * beyond);
                }
                let own = (k, patch.tag.is_none(), (self.tolerance_mm)(patch));
                found.add(own, Some(end.source.segment), &off, &mut sizes);
            }
        }
        self.work.tell(Event::Computed(makers.len()));
        Ok(found)
    }

    /// Most material left and most missing where the tool goes as in a draw, mm.
    fn recut(&self, draw: usize, command: Command) -> Result<Option<[f64; 2]>> {
        let each = |take: &mut dyn FnMut(&SpreadPart<'_>) -> Result<()>| self.job.each_part(self.written, take);
        let errors = self
            .path
            .drawn
            .on_draw(draw, |machines| self.path.errors_along(&each, (draw, machines), command, self.work));
        let Ok(errors) = errors else { return Ok(None) };
        let to_workpiece = self.surface.axes.transpose() * self.turn.transpose();
        let course: Vec<Option<Vector3<f64>>> = errors?.iter().map(|own| own.map(|own| to_workpiece * own)).collect();
        if course.iter().any(Option::is_none) {
            return Ok(None);
        }
        let along = (&self.job.path, &self.surface.axes);
        let draws = &self.path.drawn.uncertainty.draws;
        let factor = |k: usize| draws.factors(self.tool_index(k), draw).all;
        let course = (&course[..], &factor as &(dyn Fn(usize) -> f64 + Sync));
        let (deviations, _) = self.stock.deviations(along, &self.surface.patches, course, &self.job.name)?;
        let mut most = [f64::NEG_INFINITY; 2];
        for (patch, deviation) in self.surface.patches.iter().zip(deviations) {
            let Some(deviation) = deviation else { continue };
            most[0] = if patch.tag.is_none() { most[0] } else { most[0].max(deviation) };
            most[1] = most[1].max(-deviation);
        }
        Ok(Some(most))
    }
}
