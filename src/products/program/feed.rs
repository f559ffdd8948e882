//! Chooses the feed of a G-code program: more where the limits of `[feed]` allow it, less where they need it. What each round writes is read again, cut out
//! of the stock and computed like any program, so that a limit is held by the program as written.

use std::collections::BTreeMap;

use super::{Part, ProgramJob};
use crate::{
    compensation::Method,
    input::error::{Error, Result},
    process::{
        Process,
        cutting::{BY_END, PathLoad},
        feed::{FeedLimits, FeedQuantity},
    },
    simulation::along_path::PathPointResult,
    toolpath::{
        ProgramFile, Toolpath,
        gcode::{Dialect, FedLine, FeedFault, FoldFailure, FoldFault},
    },
    work::Work,
};

/// Most programs that are written and computed.
const ROUNDS: usize = 8;
/// Share of a limit above which it is not kept: rounding.
const KEPT: f64 = 1.0 + 1e-6;
/// Least share by which a feed falls at which a limit is not kept.
const STEP: f64 = 1e-3;
/// A feed that stays may be slower than it might be by this share, so that few F words are needed.
const SLACK: f64 = 0.05;
/// A tool that falls steeper cuts with its tip, where it has hardly a speed; a sine.
const STEEP: f64 = 0.5;

/// A value and its place along the program, in words.
pub type Placed = (f64, String);

/// The feeds that were chosen for a program, and what they do.
#[derive(Debug, Clone)]
pub struct FoundFeeds {
    /// The limits.
    pub limits: FeedLimits,
    /// Time of all moves at feed rate, as programmed and as written, min: without acceleration and rapid moves.
    pub minutes: [f64; 2],
    /// Number of lines that cut and are fed faster, slower and as programmed, and of those that cut nothing, which stay.
    pub lines: [usize; 4],
    /// Number of F words that are changed or new.
    pub words: usize,
    /// Largest value of each limited quantity, its limit, and its place, as programmed and as written.
    pub largest: Vec<(FeedQuantity, f64, [Placed; 2])>,
    /// Number of lines whose feed each limit stops, in order of [`FeedQuantity::ALL`], then the largest change, and a force that no law knows, as of the end of a tool:
    /// no line of those is fed faster.
    pub stopped_by: [usize; 7],
    /// Limits that are not kept, though the feed is as slow as it may be: line, value and limit.
    pub exceeded: Vec<(String, FeedQuantity, f64, f64)>,
    /// Shares of the programmed feed as written, by move.
    pub ratios: Vec<f64>,
}

/// What a line that cuts uses of the limits.
#[derive(Debug, Clone, Copy, Default)]
struct Uses {
    /// Largest value of each quantity, and the point that has it.
    values: [(f64, usize); 5],
    /// Whether no law knows the force, as of the end of a tool; see [`BY_END`].
    by_end: bool,
}

/// What is known of a line: usage of its nearest limit at the last two ratios, and the ratio that is allowed then.
#[derive(Debug, Clone, Default)]
struct Sought {
    before: Option<(f64, f64)>,
    last: Option<(f64, f64)>,
    allowed: f64,
}

impl Sought {
    /// Takes the `usage` at a ratio, and finds the ratio at which the limit is reached: forces are nearly straight lines over the feed.
    fn learn(&mut self, ratio: f64, usage: f64, [low, high]: [f64; 2]) {
        if self.last.is_some_and(|own| (own.0 - ratio).abs() > 1e-4) {
            self.before = self.last;
        }
        self.last = Some((ratio, usage));
        let slope = self.before.map(|own| (usage - own.1) / (ratio - own.0));
        let wanted = match slope {
            Some(slope) if slope > 0.0 => ratio + (1.0 - usage) / slope,
            // The feed does not matter.
            Some(_) if usage > 1.0 => low,
            Some(_) => high,
            None => ratio / usage,
        };
        let most = if usage > KEPT { ratio * (1.0 - STEP) } else { high };
        self.allowed = wanted.min(most).clamp(low, high);
    }
}

/// Returns the job of `program` with the feeds that `limits` allow.
///
/// # Errors
/// A program that is no G-code, or has a feed that cannot be changed; what is computed of a program; limits that are exceeded and should not be.
pub(super) fn with_feeds(
    limits: &FeedLimits,
    process: &Process,
    program: ProgramFile,
    name: &str,
    work: &Work,
) -> Result<ProgramJob> {
    let first = match &program {
        ProgramFile::Gcode(program) if program.notes().dialect != Dialect::Heidenhain => program.clone(),
        _ => {
            let problem = format!(
                "changes F words of G-code, and {name} is no such program: expected G-code in ISO code or Sinumerik's, or no such table"
            );
            return limits.check.fail(problem);
        }
    };
    let lines = first.fed_lines().map_err(|fault| cannot_change(fault, name))?;
    let mut line_of = vec![None; first.motion_count()];
    for (k, line) in lines.iter().enumerate() {
        line_of[line.motions.clone()].fill(Some(k));
    }
    // Behind a corner the force goes over from that of the line before: each line answers for its own.
    let own = Process { corner_mm: 0.0, ..process.clone() };
    let mut source = program.clone();
    let mut job = ProgramJob::as_programmed(own.clone(), program, name, work)?;
    if !job.untrackable_points(1, |_| {})?.is_empty() {
        // It is refused as a whole, and that says where.
        return ProgramJob::as_programmed(process.clone(), source, name, work);
    }
    let (minutes, programmed) = (feed_minutes(&job.path), uses(&job, limits, &line_of, work)?);
    let programmed_largest = largest(&job, limits, &programmed);
    let mut sought = vec![Sought::default(); lines.len()];
    let (mut numbers, mut words, mut now, mut good) = (vec![None; lines.len()], 0, programmed, None);
    for round in 0.. {
        work.check()?;
        let mut is_kept = true;
        for (((line, number), uses), sought) in lines.iter().zip(&numbers).zip(&now).zip(&mut sought) {
            let Some(uses) = uses else { continue };
            let (ratio, usage) = (line.ratio_of(number.as_ref()), nearest(limits, uses).1);
            sought.learn(ratio, usage, [limits.change[0], uses.most(limits)]);
            is_kept &= usage <= KEPT || line.is_bound || ratio <= limits.change[0] * (1.0 + STEP);
        }
        let next = plan(&lines, &sought, &now, limits.change);
        let ends = next == numbers || round == ROUNDS;
        if is_kept {
            good = Some((job, source, (now, sought.clone()), numbers, words));
        }
        if ends {
            break;
        }
        let (program, count) = first.with_feeds(&lines, &next).map_err(|fault| cannot_change(fault, name))?;
        source = ProgramFile::Gcode(Box::new(program));
        job = ProgramJob::as_programmed(own.clone(), source.clone(), name, work)?;
        now = uses(&job, limits, &line_of, work)?;
        (numbers, words) = (next, count);
    }
    let Some((job, source, (uses, sought), numbers, words)) = good else {
        let problem = format!("finds no feeds within {ROUNDS} programs at which all limits hold that can");
        return limits.check.fail(problem);
    };
    let after = largest(&job, limits, &uses);
    let largest = limits.given().zip(programmed_largest.into_iter().zip(after));
    let mut found = FoundFeeds {
        limits: limits.clone(),
        minutes: [minutes, feed_minutes(&job.path)],
        lines: [0; 4],
        words,
        largest: largest.map(|((quantity, most), (before, after))| (quantity, most, [before, after])).collect(),
        stopped_by: [0; 7],
        exceeded: exceeded(&job, limits, &uses),
        ratios: vec![1.0; line_of.len()],
    };
    found.count(&lines, &numbers, &sought, &uses);
    let mut job = ProgramJob::as_programmed(process.clone(), source, name, work)?;
    job.feed = Some(found);
    Ok(job)
}

/// Returns the limits that lines with these `uses` do not keep, as [`FoundFeeds::exceeded`] has them.
fn exceeded(job: &ProgramJob, limits: &FeedLimits, uses: &[Option<Uses>]) -> Vec<(String, FeedQuantity, f64, f64)> {
    let mut found = Vec::new();
    for uses in uses.iter().flatten() {
        let over = |(quantity, most): &(FeedQuantity, f64)| uses.values[*quantity as usize].0 > KEPT * most;
        for (quantity, most) in limits.given().filter(over) {
            let (value, point) = uses.values[quantity as usize];
            found.push((job.place_text(point), quantity, value, most));
        }
    }
    found
}

impl Uses {
    /// Returns the largest ratio that may be tried.
    fn most(&self, limits: &FeedLimits) -> f64 {
        if self.by_end { 1.0 } else { limits.change[1] }
    }
}

impl FoundFeeds {
    /// Counts lines by what becomes of their feed, each once.
    fn count(&mut self, lines: &[FedLine], numbers: &[Option<String>], sought: &[Sought], uses: &[Option<Uses>]) {
        let mut places = BTreeMap::new();
        for (k, line) in lines.iter().enumerate() {
            let ratio = line.ratio_of(numbers[k].as_ref());
            self.ratios[line.motions.clone()].fill(ratio);
            let own = uses[k].as_ref().map(|uses| match sought[k].allowed < uses.most(&self.limits) {
                true => nearest(&self.limits, uses).0 as usize,
                false => 5 + usize::from(uses.by_end),
            });
            let kept: &mut (f64, Option<usize>) = places.entry(line.place).or_insert((ratio, own));
            kept.1 = kept.1.into_iter().chain(own).min();
        }
        for (ratio, stopped) in places.into_values() {
            self.lines[if stopped.is_none() { 3 } else { usize::from(ratio < 1.0) + 2 * usize::from(ratio == 1.0) }] +=
                1;
            stopped.into_iter().for_each(|own| self.stopped_by[own] += 1);
        }
    }
}

/// Returns the numbers after F on the `lines`, as few different ones in a row as lose little of what is allowed; `None` stays as programmed.
fn plan(lines: &[FedLine], sought: &[Sought], uses: &[Option<Uses>], change: [f64; 2]) -> Vec<Option<String>> {
    let mut of_place = BTreeMap::new();
    let mut least = |place: (usize, usize), ratio: f64| {
        let own = of_place.entry(place).or_insert(ratio);
        *own = own.min(ratio);
    };
    let cut = || lines.iter().zip(sought).zip(uses).filter(|((line, _), uses)| uses.is_some() && !line.is_bound);
    cut().for_each(|((line, sought), _)| least(line.place, sought.allowed));
    let allowed: Vec<Option<f64>> = lines.iter().map(|line| of_place.get(&line.place).copied()).collect();
    let mut start = 0;
    while start < lines.len() {
        let mut end = start + 1;
        if let Some(mut low) = allowed[start] {
            let mut high = low;
            while let Some(next) = allowed.get(end).copied().flatten().filter(|_| lines[end].has_feed_of(&lines[start]))
            {
                let both = (low.min(next), high.max(next));
                if both.0 < (1.0 - SLACK) * both.1 {
                    break;
                }
                ((low, high), end) = (both, end + 1);
            }
            let ratio = if low >= 1.0 && (1.0 - SLACK) * high <= 1.0 { 1.0 } else { low };
            for line in &lines[start..end] {
                let own = of_place.entry(line.place).or_insert(ratio);
                *own = own.min(ratio);
            }
        }
        start = end;
    }
    lines.iter().map(|line| line.scaled(*of_place.get(&line.place)?, change[0])).collect()
}

/// Returns the quantity that is nearest to its limit, and its value as a share of that.
fn nearest(limits: &FeedLimits, uses: &Uses) -> (FeedQuantity, f64) {
    let share = |(quantity, most): (FeedQuantity, f64)| (quantity, uses.values[quantity as usize].0 / most);
    limits.given().map(share).fold((FeedQuantity::Force, 0.0), |most, own| if own.1 > most.1 { own } else { most })
}

/// Returns the largest value of each limited quantity, and its place.
fn largest(job: &ProgramJob, limits: &FeedLimits, uses: &[Option<Uses>]) -> Vec<Placed> {
    let of = |(quantity, _): (FeedQuantity, f64)| {
        let all = uses.iter().flatten().map(|uses| uses.values[quantity as usize]);
        let (value, point) = all.fold((0.0, 0), |most, own| if own.0 > most.0 { own } else { most });
        (value, job.place_text(point))
    };
    limits.given().map(of).collect()
}

/// Computes what each of the lines uses of the limits; `line_of` gives the line of each move.
fn uses(job: &ProgramJob, limits: &FeedLimits, line_of: &[Option<usize>], work: &Work) -> Result<Vec<Option<Uses>>> {
    let count = line_of.iter().flatten().max().map_or(0, |last| last + 1);
    let (mut uses, mut track) = (vec![None::<Uses>; count], job.tracker());
    let mut add = |part: &Part<'_>, results: &[PathPointResult]| {
        for (i, ((k, point), task)) in part.range().zip(part.points).zip(part.tasks()).enumerate() {
            let there = track.placed(task.external).with_platform_rotation(&task.pose.rotation);
            let Some((line, feed)) = line_of[point.source.segment].zip(point.feed_mm_per_min) else { continue };
            let law = job.process.load(point).map_err(|fault| Error::argument(&job.name, fault.to_string()))?;
            let load = law.on_tool(point.tangent, there.tool_axes());
            let torque = load.moment_Nmm.dot(&there.tool_axes().column(2)).abs() / 1e3;
            let fall = point.tangent.dot(&there.tool_axes().column(2));
            // On a way that is not known, as after a return to the reference position, nothing says how it comes to there.
            let is_unknown = |k: usize| point.arc_length_mm <= job.path.points()[k - 1].arc_length_mm;
            let by_end = k == 0
                || is_unknown(k)
                || fall > STEEP
                || match (job.path.engagements().get(k), law) {
                    (Some(engaged), _) => engaged.unknown.is_some(),
                    (None, PathLoad::Milling(_)) => fall > BY_END,
                    _ => false,
                };
            if load.force_N.norm() == 0.0 && torque == 0.0 && !by_end {
                continue;
            }
            let power = torque * point.spindle_rev_per_min.unwrap_or_default() * std::f64::consts::TAU / 60.0 / 1e3;
            let deflection = match results.get(i) {
                None => 0.0,
                Some(result) => PathPointResult::solved_error(result).map(|error| error.norm()).ok_or_else(|| {
                    let (place, why) = (job.place_text(k), result.status.reason(&job.machine));
                    Error::argument(
                        &job.name,
                        format!("{place}: the deflection that [feed] limits is not known: {why}"),
                    )
                })?,
            };
            let uses = uses[line].get_or_insert_default();
            uses.by_end |= by_end;
            for (most, own) in uses.values.iter_mut().zip([load.force_N.norm(), torque, power, deflection, feed]) {
                *most = if own > most.0 { (own, k) } else { *most };
            }
        }
        work.check()
    };
    if limits.most[FeedQuantity::Deflection as usize].is_some() {
        job.pass_by(Method::None, &|| {}, add)?;
    } else {
        job.parts().try_for_each(|part| add(&part?, &[]))?;
    }
    Ok(uses)
}

/// Returns the time of all moves at feed rate, min.
fn feed_minutes(path: &Toolpath) -> f64 {
    let mut before_mm = 0.0;
    let minutes = path.points().iter().filter_map(|point| {
        let way = point.arc_length_mm - std::mem::replace(&mut before_mm, point.arc_length_mm);
        point.feed_mm_per_min.filter(|feed| *feed > 0.0).map(|feed| way / feed)
    });
    minutes.sum()
}

/// Returns the error that feeds of the program called `name` cannot be changed.
fn cannot_change(fault: FeedFault, name: &str) -> Error {
    match fault {
        FeedFault::Program(fault) => fault.into(),
        FeedFault::Line { line, why } => {
            Error::argument(name, format!("line {line} {why}: expected it otherwise, or no [feed] in the process"))
        }
        FeedFault::Calls(failure) => Error::argument(name, without_own_feed(&failure)),
    }
}

/// Says why a line of a program with calls cannot have a feed of its own.
fn without_own_feed(failure: &FoldFailure) -> String {
    let file = failure.file.as_ref().map_or_else(String::new, |file| format!("{file} "));
    let why = match failure.how {
        FoldFault::FromRunToRun => "runs several times, each at another feed",
        FoldFault::Computed => "is computed, and so has no feed that can be written",
        FoldFault::OutOfPlace => "would run differently with another feed",
    };
    format!(
        "{file}line {} {why}: expected --expand, which writes the program out, or no [feed] in the process",
        failure.line
    )
}
