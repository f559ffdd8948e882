//! Sentences about a compensated program: its first screen, the effect of limits, its blocks, and its residual error.

use kinetostat_budget::Budget;

use super::{
    Report, feed, notes_text,
    tables::{WITHOUT_FORCE, error_before_column},
};
use crate::{
    answer::{ShareWithin, budget::OfVerdict, cautions, clearance, drive_columns::kind_word, force_text},
    compensation::{BoundedPath, LimitKind, Method, Price},
    files::{
        exchange::Table,
        words::{counted, millimetres, percent, probability},
    },
    machine::{Machine, Motion},
    page::{
        SmallTable,
        headline::{Extreme, Headline, InTable, KeyNumber, State, Verdict, worst_judged},
    },
    process::{Basis, KnownForce, VerdictForce, file::CorrectionLimits},
    products::program::{ForceCheck, ProgramJob, VerifiedProgram, WithoutForce, bounded::LimitExcess},
    questions::{
        path::report::facts_text,
        spread_report::{self, Along, share_of},
    },
    simulation::{ROUNDING_MM, Source, spread_along::PathSpread},
    toolpath::{
        ProgramFile,
        blocks::{Blocks, BlocksBeforeAfter, Percentiles},
        gcode::Dialect,
    },
};

/// Returns in sentences how limits change the path of `verified`, if it was corrected within them, or that limits were not regarded; empty without limits.
pub(super) fn limits_text(machine: &Machine, limits: &CorrectionLimits, verified: &VerifiedProgram) -> String {
    match &verified.bounded {
        Some(path) => {
            let forces = verified.forces.as_ref().map_or_else(String::new, |forces| forces_text(machine, path, forces));
            forces + &bounded_text(machine, path)
        }
        None if limits.is_limited() => {
            "The limits of the process were not assessed: --method bounded keeps them.\n".into()
        }
        None => String::new(),
    }
}

/// Returns how sure it is that limits of forces hold along the program as written, in a sentence.
fn forces_sentence(forces: &ForceCheck) -> String {
    let within = probability(forces.within as f64 / forces.draws as f64, forces.draws);
    let most = forces.tightened.iter().fold(0.0, |most: f64, own| most.max(*own));
    let tightened = match most > 0.0 {
        true => format!("; for that their limits were tightened by up to {} in the optimisation", percent(most)),
        false => String::new(),
    };
    format!("Drive forces stay within their limits all along it with {within} probability{tightened}.")
}

/// Returns how sure it is that limits hold along the program as written, in sentences, and that what follows is nominal.
fn forces_text(machine: &Machine, path: &BoundedPath, forces: &ForceCheck) -> String {
    let labels = machine.drive_labels();
    let LimitExcess { drive, point, value, limit, .. } = forces.p95;
    let unit = shown_limit_unit(machine, LimitKind::Force, drive);
    let failed = match forces.failed {
        0 => String::new(),
        failed => format!(" {failed} have no equilibrium somewhere and do not count."),
    };
    let mut text = format!(
        "Limits of drive forces hold all along the program as written in {} of {} draws that were not used to tighten them, each one machine and one \
         cutting force for the whole program.{failed} With 95 % probability the force nearest to its limit is up to {value:.1} {unit}, of {limit} {unit} \
         (drive {} at point {point}).\n",
        share_of(forces.within, forces.draws),
        forces.draws,
        labels[drive]
    );
    let tightened = labels.iter().zip(&forces.tightened).filter(|(_, share)| **share > 0.0);
    let tightened: Vec<String> =
        tightened.map(|(label, share)| format!("drive {label} by {}", percent(*share))).collect();
    if !tightened.is_empty() {
        text += &format!(
            "Tightened in the optimisation: the force limits of {}. With nominal numbers that leaves up to {} instead of {}.\n",
            tightened.join(", "),
            millimetres(path.summary.after.worst, 4),
            millimetres(forces.untightened_mm, 4)
        );
    }
    text + "Limits of corrections are limits of commands: they hold on any machine. With nominal numbers:\n"
}

/// Returns which limits bind and what they cost, in sentences.
pub fn bounded_text(machine: &Machine, path: &BoundedPath) -> String {
    let summary = &path.summary;
    let labels = machine.drive_labels();
    if summary.prices.is_empty() {
        return "No limit binds: the corrections without limits keep all of them.\n".into();
    }
    let mut text =
        format!("Limits bind ({}, {}):\n", summary.status.label(), counted(summary.iterations, "linearisation"));
    for price in &summary.prices {
        let error_mm = shown_price(machine, price);
        text += &format!(
            "  {} of drive {} at {}; the error would fall by {} per {} of relaxation\n",
            price.kind.label(),
            labels[price.drive],
            counted(price.points, "point"),
            millimetres(error_mm, 4),
            shown_limit_unit(machine, price.kind, price.drive),
        );
    }
    text + &forced_error_text(machine, path)
}

/// Returns which limits force a larger error at the worst point than there is without correction; empty if none do.
fn forced_error_text(machine: &Machine, path: &BoundedPath) -> String {
    let corrected = path.points.iter().enumerate().filter_map(|(k, point)| Some((k, point.corrected()?)));
    let worst = corrected.max_by(|(_, a), (_, b)| a.error.total_cmp(&b.error));
    let before = path.summary.before.worst;
    let Some((k, worst)) = worst.filter(|(_, worst)| worst.error > before * (1.0 + 1e-9)) else {
        return String::new();
    };
    let labels = machine.drive_labels();
    let limits = worst.binding.iter().map(|limit| format!("{} of drive {}", limit.kind.label(), labels[limit.drive]));
    let mut limits: Vec<String> = limits.collect();
    limits.dedup();
    let limits = if limits.is_empty() { "limits of points near it".into() } else { limits.join(", ") };
    format!(
        "At point {k} the limits force more error than there is without correction anywhere: {}, not {} ({limits}).\n",
        millimetres(worst.error, 4),
        millimetres(before, 4)
    )
}

/// Returns by how much the program as written exceeds limits, in sentences; empty if it does not.
pub fn exceeded_text(job: &ProgramJob, exceeded: &[LimitExcess]) -> String {
    let labels = job.machine.drive_labels();
    let nearer = match &job.file {
        ProgramFile::Gcode(_) | ProgramFile::Robot(_) if job.process.write_tolerance_mm > 0.0 => {
            "More decimals and a smaller write tolerance (decimals_mm, write_tolerance_mm in [gcode])"
        }
        _ => "More decimals (decimals_mm in [gcode])",
    };
    let main_sentence = |found: &LimitExcess| {
        let LimitExcess { kind, drive, point, value, limit } = *found;
        let (unit, beyond) = (shown_limit_unit(&job.machine, kind, drive), value - limit);
        format!(
            "As written, the {} of drive {} is {value:.6} {unit} at point {point}: {beyond:.1e} {unit} beyond its limit of {limit} {unit}. \
             {nearer} or a limit smaller by this much keep it.\n",
            kind.label(),
            labels[drive]
        )
    };
    exceeded.iter().map(main_sentence).collect()
}

/// Returns the residual error `residual_mm` along axes that the drives do not control; empty if they control all axes.
pub(super) fn residual_text(machine: &Machine, residual_mm: Option<f64>) -> String {
    let (Some(axes), Some(residual)) = (machine.uncontrolled_names(), residual_mm) else { return String::new() };
    let residual = millimetres(residual, 4);
    format!("The residual error is up to {residual}: the drives do not control {axes}.\n")
}

/// Returns how far writing has moved positions on the ways into and out of holes of cycles; empty without such holes.
fn holes_text(in_holes_mm: Option<f64>) -> String {
    in_holes_mm.map_or_else(String::new, |most| {
        let most = millimetres(most, 4);
        format!("Holes of cycles have the correction of their bottoms: on the ways in and out, the right correction differs by up to {most}.\n")
    })
}

/// Returns how closely the program was written to its points and how many blocks that takes; empty for polylines.
pub(super) fn written_text(job: &ProgramJob, blocks: Option<&BlocksBeforeAfter>) -> String {
    let Some(BlocksBeforeAfter { before, after }) = blocks else { return String::new() };
    let near = match job.process.write_tolerance_mm {
        0.0 => "to a unit of the last decimal".into(),
        tolerance => format!("to within {tolerance} mm"),
    };
    format!(
        "Written {near}: {} for {} before, {} for {}.\n",
        counted(after.moves, "move"),
        before.moves,
        counted(after.lines, "line"),
        before.lines
    )
}

/// Returns how closely the program was written to its points, and what its blocks demand of a control; empty for polylines.
pub fn blocks_text(job: &ProgramJob, blocks: Option<&BlocksBeforeAfter>) -> String {
    let mut text = written_text(job, blocks);
    let Some(BlocksBeforeAfter { before, after }) = blocks else { return text };
    let mut add_sentence = |what: &str, unit: &str, of: fn(&Blocks) -> Option<Percentiles>| {
        if let (Some(before), Some(after)) = (of(before), of(after)) {
            let words = |spread: Percentiles| {
                [spread.p50, spread.p95, spread.max].map(|value| format!("{}{unit}", rounded(value)))
            };
            let ([b50, b95, bmax], [a50, a95, amax]) = (words(before), words(after));
            text +=
                &format!("{what}: half up to {a50}, 95 % up to {a95}, at most {amax} (before {b50}, {b95}, {bmax}).\n");
        }
    };
    add_sentence("Blocks per second at the programmed feed", "", |blocks| blocks.per_second);
    add_sentence("Turns from move to move", "°", |blocks| blocks.turns_deg);
    text
}

/// Returns what the blocks demand of a control, before and as written, as a table for the page.
pub(super) fn blocks_table(blocks: &BlocksBeforeAfter) -> SmallTable {
    let row = |name: &str, blocks: &Blocks| {
        let mut row = vec![name.to_string(), blocks.lines.to_string(), blocks.moves.to_string()];
        for (spread, unit) in [(blocks.per_second, ""), (blocks.turns_deg, "°")] {
            let values = spread.map_or([None; 3], |spread| [spread.p50, spread.p95, spread.max].map(Some));
            row.extend(
                values.map(|value| value.map_or_else(|| "–".into(), |value| format!("{}{unit}", rounded(value)))),
            );
        }
        row
    };
    let header = ["", "lines", "moves", "blocks/s: half", "95 %", "most", "turns: half", "95 %", "most"];
    SmallTable {
        caption:
            "Blocks driven with the feed: how many a second at the programmed feed, and turns from one to the next"
                .into(),
        header: header.map(String::from).into(),
        rows: vec![row("before", &blocks.before), row("as written", &blocks.after)],
    }
}

/// Returns `value` as text with about three significant digits.
fn rounded(value: f64) -> String {
    let decimals = if value == 0.0 { 0.0 } else { (2.0 - libm::log10(value.abs()).floor()).clamp(0.0, 3.0) };
    let text = format!("{value:.*}", decimals as usize);
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_string(),
        false => text,
    }
}

/// Returns whether drive number `drive` is a prismatic or a revolute joint.
fn motion_at(machine: &Machine, drive: usize) -> Motion {
    machine.drives().nth(drive).map_or(Motion::Prismatic, |(_, drive)| drive.motion)
}

/// Returns the unit of a limit of a drive in tables.
pub(super) fn limit_unit(machine: &Machine, kind: LimitKind, drive: usize) -> &'static str {
    let motion = motion_at(machine, drive);
    if kind == LimitKind::Force { motion.force_unit() } else { motion.position_unit() }
}

/// Returns the unit of a limit of a drive as readers see it.
fn shown_limit_unit(machine: &Machine, kind: LimitKind, drive: usize) -> &'static str {
    let motion = motion_at(machine, drive);
    if kind == LimitKind::Force { motion.shown_force_unit() } else { motion.shown_position_unit() }
}

/// Returns by how much the error would fall, mm, per unit of the limit: mm, degree, N or N·mm.
pub(super) fn shown_price(machine: &Machine, price: &Price) -> f64 {
    if price.kind == LimitKind::Force { price.price } else { motion_at(machine, price.drive).from_shown(price.price) }
}

/// Returns main sentence, numbers and cautions of the first screen.
pub fn headline(report: &Report<'_>) -> Headline {
    let cutting = report.job.path.points().iter().filter(|point| point.cutting).count();
    let length = report.job.path.length_mm();
    let (points, inputs) =
        (counted(report.job.path.len(), "point"), spread_report::basis(report.job.uncertainty.as_deref()));
    let verdict_force = VerdictForce::of(&report.job.process, &report.job.path);
    let force = force_text("up to ", report.findings.force.largest);
    let force = match &verdict_force {
        Some(own) => format!("{force} ({} over a turn)", own.rests_on.label()),
        None => force,
    };
    let basis = format!("{points}, {cutting} of them cutting, {length:.1} mm of path, {force}, {inputs}");
    let verdict = report.findings.outside.verdict(&report.job.machine, report.name);
    let distribution = report.verified.spread.as_ref();
    let (sure, numbers): (_, Vec<KeyNumber>) = match distribution {
        Some(distribution) => {
            let along = along(report);
            let in_table = |off| InTable::new("points", [WITHOUT_FORCE], &[], Extreme::Largest, off);
            let gouge = along.without_force_number(in_table);
            let numbers = spread_report::along_numbers(&along, distribution).into_iter().chain(gouge).collect();
            (spread_report::along_verdict(&along, distribution), numbers)
        }
        None => {
            let numbers = distances(report).into_iter().rev().flatten().chain(largest_correction(report)).collect();
            (main_sentence(report), numbers)
        }
    };
    let uncertain = report.job.uncertainty.as_deref();
    let forces = report.verified.forces.as_ref().map_or_else(String::new, |own| format!(" {}", forces_sentence(own)));
    let of_tool = feed::verdict(report.job) + &verdict + &sure + &forces;
    let of_bodies = report.findings.clearance.as_ref();
    let way = |k| format!("on the way to {}", report.job.place_text(k));
    let hit = of_bodies.and_then(|own| Some(own.hit_text(way)? + "."));
    // What is cut is what will be measured; how the tool goes is behind it.
    let uncut = uncut_sentence(report);
    let short =
        uncut.or_else(|| report.findings.outside.sentence(&report.job.machine)).unwrap_or_else(|| match distribution {
            Some(distribution) => spread_report::along_sentence(&along(report), distribution),
            None => first_sentence(report),
        });
    let (sentence, of_tool, numbers) = match &report.findings.machined {
        Some(own) if own.sides[1].area > 0.0 => (
            own.first_sentence(),
            of_tool + "\n",
            own.numbers(report.job).into_iter().rev().chain(numbers.into_iter().next()).collect(),
        ),
        _ => (short, of_tool + "\n", numbers),
    };
    let state = state(report);
    let next = next_step(report, &state);
    let mut headline = Headline::new(sentence, basis)
        .next(next)
        .judged(state, uncertain.is_none())
        .marked("simulated")
        .with_cautions(&all_cautions(report, &of_tool))
        .with_numbers(numbers)
        .where_force_is(report.job.process.known_force(&report.job.path))
        .resting_on(&budget(report), &judged(report));
    headline.unsolved = report.verified.unsolved_as_written();
    // What hits something is not run, however well it would cut.
    match hit {
        Some(hit) => headline.barred(hit, self::state(report), clearance::MOVE_AWAY),
        None => headline,
    }
}

/// Returns what the verdict rests on.
pub(super) fn budget(report: &Report<'_>) -> Budget {
    let job = report.job;
    let known = job.process.known_force(&job.path);
    let force = (report.findings.force.largest > 0.0 || known != KnownForce::Everywhere).then_some(known);
    let (machine, errors) = (&job.machine, &job.process.errors[..]);
    let uncertainty = job.uncertainty.as_deref().filter(|_| report.verified.spread.is_some());
    let open_backlash_mm = report.findings.play.open_mm();
    let fastest_mm_per_s = job.path.largest_cutting_feed_mm_per_min().map(|own| own / 60.0);
    let basis = Basis { machine, errors, uncertainty, force, open_backlash_mm, fastest_mm_per_s, is_written: true };
    clearance::in_budget(basis.budget(&job.process.verdict), report.findings.clearance.as_ref())
}

/// Returns what the verdict rests on as a table.
pub fn budget_table(report: &Report<'_>) -> Table {
    of_verdict(report, &budget(report)).table()
}

/// Returns what the verdict rests on as it is drawn and told: of the distance or surface that takes most of its tolerance.
pub(super) fn of_verdict<'a>(report: &'a Report<'_>, budget: &'a Budget) -> OfVerdict<'a> {
    let all = judged(report);
    let worst = worst_judged(budget, &all);
    let compensated = report.verified.spread.as_ref().and_then(|own| own.compensated.as_ref());
    // They are of the path of the tool, not of a surface.
    let is_of_path = report.findings.machined.as_ref().is_none_or(|own| own.judged(report.job).is_empty());
    OfVerdict {
        budget,
        shares: compensated.and_then(|own| own.shares.as_ref()).filter(|_| is_of_path),
        judged_mm: worst.map(|own| own.0).or_else(|| all.iter().find_map(|own| own.0)),
        tolerance_mm: worst.map(|own| own.1),
    }
}

/// Returns the distances by which the written program is judged, mm, with their tolerances: of its path, and of the surfaces of its tools where stock is cut. They are
/// not exceeded with 95 % probability, or with nominal inputs the largest.
fn judged(report: &Report<'_>) -> Vec<(Option<f64>, Option<f64>)> {
    let of_path = match &report.verified.spread {
        Some(whole) => whole.compensated.as_ref().unwrap_or(&whole.plain).spread.p95_mm,
        None => report.verified.passes.last().and_then(|pass| pass.summary.max_mm),
    };
    let of_surface = report.findings.machined.as_ref().map_or_else(Vec::new, |own| own.judged(report.job));
    match of_surface.is_empty() {
        true => vec![(of_path, report.job.process.tolerance_mm)],
        false => of_surface,
    }
}

/// Begins verdicts on programs that would do harm.
const NOT_TO_BE_RUN: &str = "Not to be run";

/// Returns the verdict on the written program, in a few words: what stands against running it first.
fn state(report: &Report<'_>) -> Verdict {
    let Report { job, verified, findings, .. } = report;
    if let Some(hit) = findings.clearance.as_ref().and_then(clearance::verdict) {
        return Verdict::new(State::Bad, format!("{NOT_TO_BE_RUN}: {}", hit.words));
    }
    if let Some(written) = verified.passes.last().map(|pass| &pass.summary)
        && written.solved < written.points
    {
        let lost = written.points - written.solved;
        return Verdict::new(State::Bad, format!("{NOT_TO_BE_RUN}: fails at {lost} points"));
    }
    if verified.worse_as_written().is_some() {
        return Verdict::new(State::Bad, format!("{NOT_TO_BE_RUN}: worse than its commands"));
    }
    if job.cuts_nowhere() {
        let corrected =
            if is_corrected(report) { "Corrected without a cutting force" } else { "Nothing was corrected" };
        return Verdict::new(State::Bad, format!("{corrected}: only {} cut", cutting_motions(job)));
    }
    if findings.machined.as_ref().is_some_and(|own| !own.gouge_text(job).is_empty()) {
        return Verdict::new(State::Bad, format!("{NOT_TO_BE_RUN}: cuts into the part"));
    }
    if verified.exceeded.as_ref().is_some_and(|found| !found.is_empty()) {
        return Verdict::new(State::Bad, "Exceeds a limit of the machine");
    }
    // Of an assumed box it is a doubt only, behind what is known to be wrong.
    if findings.outside.outside() > 0 {
        return findings.outside.state(&job.machine);
    }
    let of_tool = match (&verified.spread, job.process.tolerance_mm) {
        (Some(distribution), _) => spread_report::along_state(&along(report), distribution),
        (None, None) => Verdict::new(State::Open, "No tolerance given"),
        (None, Some(tolerance))
            if findings.after.get() == Some(1.0)
                && verified.without_force.most.is_some_and(|(_, off)| off > tolerance) =>
        {
            Verdict::new(State::Partly, spread_report::ONLY_UNDER_FORCE)
        }
        (None, tolerance) => Verdict::of_share(findings.after.get(), tolerance, "the path"),
    };
    match findings.machined.as_ref().and_then(|own| own.verdict(job)) {
        Some(of_surface) if of_surface.state >= of_tool.state => of_surface,
        _ => of_tool,
    }
}

/// Returns where the force is not known, in sentences; empty where it is.
fn unknown_force_text(job: &ProgramJob) -> String {
    job.process.unknown_force_text(&job.path, &|segment| job.file.line_name(segment))
}

/// Returns in words which motions of a program of this kind may cut.
fn cutting_motions(job: &ProgramJob) -> &'static str {
    match &job.file {
        ProgramFile::Polyline(_) => "points marked as cutting",
        ProgramFile::Gcode(program) if program.notes().dialect == Dialect::Heidenhain => "L, C and CR at feed",
        ProgramFile::Gcode(_) => "G1, G2, G3 and cycles",
        ProgramFile::Robot(program) => program.language().cutting_motions(),
    }
}

/// Returns whether the program as written leads the drives elsewhere than as programmed.
fn is_corrected(report: &Report<'_>) -> bool {
    report.findings.corrections.iter().flatten().any(|most| *most > EXACT_MM)
}

/// Returns the first sentence of a program that cuts nowhere; `None` if it cuts.
fn uncut_sentence(report: &Report<'_>) -> Option<String> {
    let job = report.job;
    let corrected = match is_corrected(report) {
        true => "it was corrected for what acts without a cutting force alone",
        false => "nothing was corrected",
    };
    job.cuts_nowhere().then(|| {
        format!(
            "No motion of {} counts as cutting, so {corrected}. What counts is {} ({}).",
            report.name,
            job.process.cutting_text(),
            cutting_motions(job)
        )
    })
}

/// Returns how sentences about the distribution along the program name it.
fn along<'a>(report: &'a Report<'_>) -> Along<'a> {
    let off = report.verified.without_force;
    // The pass before the last is of the commands themselves.
    let is_programmed =
        report.verified.passes.iter().rev().nth(1).is_some_and(|pass| pass.name == Method::None.label());
    Along {
        machine: &report.job.machine,
        path: report.name.into(),
        missing: "have no equilibrium",
        commands: if is_programmed { spread_report::AS_PROGRAMMED } else { "with the compensated program" },
        uncertainty: report.job.uncertainty.as_deref(),
        points: report.verified.passes.first().map_or(0, |pass| pass.summary.points),
        tolerance_mm: report.job.process.tolerance_mm,
        unjudged: match off {
            _ if report.job.path.points().iter().all(|point| !point.cutting) => Some(spread_report::NOTHING_CUT),
            WithoutForce { most: None, unknown: 0 } => Some(spread_report::NO_FORCE),
            _ if !report.findings.outside.verdict(&report.job.machine, report.name).is_empty() => {
                Some(spread_report::OUTSIDE)
            }
            _ => None,
        },
        without_force: off
            .most
            .filter(|(_, size)| *size > ROUNDING_MM)
            .map(|(k, size)| (size, report.job.place_text(k))),
    }
}

/// Returns how sure the errors are, in sentences; empty where inputs are taken as exact.
pub(super) fn spread_text(report: &Report<'_>) -> String {
    let Some(whole) = &report.verified.spread else { return String::new() };
    spread_report::along_sentences(&along(report), whole) + &report.findings.spread.sentences("point")
}

/// Returns what is told of the program besides its table of passes, in sentences: feeds, limits, errors and how sure they are, and blocks.
pub fn findings_text(report: &Report<'_>) -> String {
    let Report { job, verified, .. } = report;
    let mut spread = spread_text(report);
    if !spread.is_empty() {
        spread.insert_str(0, "The table is of nominal numbers.\n");
    }
    feed::feed_text(report)
        + &limits_text(&job.machine, &job.process.limits, verified)
        + &residual_text(&job.machine, verified.commanded_max_mm())
        + &holes_text(verified.written.in_holes_mm)
        + &spread
        + &blocks_text(job, verified.written.blocks.as_ref())
}

/// Returns the cautions of the first screen, a sentence per line, in the order in which they stand against the program: what is wrong with what was
/// written, what is cut, `of_tool` (how the tool goes), then how sure that is, and last what holds for any program on the machine.
fn all_cautions(report: &Report<'_>, of_tool: &str) -> String {
    let (job, verified) = (report.job, report.verified);
    let distribution = verified.spread.as_ref();
    let machined = report.findings.machined.as_ref();
    let next = spread_report::next_along(distribution);
    [
        verified.worse_as_written().unwrap_or_default(),
        machined.map_or_else(String::new, |own| own.gouge_text(job)),
        verified.exceeded.as_deref().map_or_else(String::new, |found| exceeded_text(job, found)),
        unknown_force_text(job),
        feed::caution(job),
        machined.map_or_else(String::new, |own| own.sentences(job)),
        of_tool.to_owned(),
        VerdictForce::of(&job.process, &job.path).map_or_else(String::new, |own| own.sentence()),
        spread_report::along_cautions(&along(report), distribution),
        deflected_cut_text(report, true),
        without_force_text(report),
        play_text(report),
        report
            .findings
            .clearance
            .as_ref()
            .map_or_else(String::new, |own| clearance::sentences(own, |k| job.place_text(k))),
        spread_report::cautions(job.uncertainty.as_deref(), &report.findings.spread, "point", next.as_deref()),
        other_cautions(report),
    ]
    .map(|text| text.trim_end().to_owned() + "\n")
    .concat()
}

/// Returns the cautions that come last, a sentence per line: of the machine, its errors, what is assumed and what was left as it is.
fn other_cautions(report: &Report<'_>) -> String {
    let machine = &report.job.machine;
    near_frequency_text(report.job)
        + &cautions::zeroing(machine)
        + &cautions::carrier(machine)
        + &cautions::large_errors(machine, &report.job.process.errors)
        + &report.findings.outside.text("point")
        + &facts_text(&report.job.process.assumed())
        + match report.job.is_full_pose() && report.job.uncertainty.is_some() {
            true => "The distributions are of distances alone: the orientation that full_pose holds is not judged.\n",
            false => "",
        }
        + &notes_text(report.job, &report.verified.written.calls)
}

/// Returns that a natural frequency is near that of the teeth where stock is cut, in a sentence; empty without.
fn near_frequency_text(job: &ProgramJob) -> String {
    let near = job.process.stock.as_ref().and_then(|stock| stock.tooth_passing(&job.path)?.1);
    near.unwrap_or_default()
}

/// The deflected cut is told on the first screen where it changes the largest error by this share.
const OTHER_CUT: f64 = 0.1;

/// Returns how the deflection of the tool without compensation changes its cut, in a sentence; empty without stock, and `on_first_screen` where that matters little.
pub(super) fn deflected_cut_text(report: &Report<'_>, on_first_screen: bool) -> String {
    let Some(found) = &report.verified.deflected_cut else { return String::new() };
    let [own, programmed, left] = [found.largest.1, found.programmed_mm, found.left_mm].map(|own| millimetres(own, 4));
    if !found.has_converged() {
        return format!(
            "How deflection changes the cut without compensation has not settled: after {} cuts of the stock, deflection and force disagree at {} of the points, by up to {left}. \
             Without compensation means here with the force of the programmed cut.\n",
            found.rounds,
            percent(1.0 - found.agreed)
        );
    }
    let change = found.largest.1 / found.programmed_mm - 1.0;
    if on_first_screen && change.abs() < OTHER_CUT {
        return String::new();
    }
    format!(
        "Without compensation the tool, deflected, cuts {} than programmed: with the force of that cut it is off by up to {own}, {}, not {programmed} ({} of the stock, \
         until deflection and force agree at {} of the points).\n",
        if change < 0.0 { "less" } else { "more" },
        report.job.place_text(found.largest.0),
        counted(found.rounds, "cut"),
        percent(found.agreed)
    )
}

/// Returns what the play of the drives does, in sentences; empty without play.
fn play_text(report: &Report<'_>) -> String {
    let taken_back = match report.verified.takes_play_back {
        true => "the program as written takes it back",
        false => "the program as written does not take it back, as its commands are not by a compensation method",
    };
    report.findings.play.sentences(taken_back, |k| report.job.place_text(k))
}

/// Returns where the written program leads the tool if the cutting force is absent, unless that is a key number; empty where none is expected, or
/// rounding is left.
fn without_force_text(report: &Report<'_>) -> String {
    let off = &report.verified.without_force;
    let is_number = report.verified.spread.is_some() && report.findings.machined.is_none();
    let most = off.most.filter(|(_, size)| *size > ROUNDING_MM && !is_number);
    let mut text = most.map_or_else(String::new, |(point, size)| {
        format!(
            "Where the cutting force is absent (in air, in a spring pass, with a broken tool), the program as written leads the tool off its path by \
             up to {}, {}.\n",
            millimetres(size, 3),
            report.job.place_text(point)
        )
    });
    if off.unknown > 0 {
        text += &format!("At {} it has no equilibrium without the force.\n", counted(off.unknown, "point"));
    }
    text
}

/// Returns the first sentence: how far the tool is off without compensation and as written.
fn first_sentence(report: &Report<'_>) -> String {
    let Some(worst) = &report.findings.worst else { return "Nothing could be computed.".into() };
    let residual = report.verified.passes.last().and_then(|pass| pass.summary.max_mm);
    let without = millimetres(worst.size_mm, 3);
    match residual {
        Some(own) => format!("Compensated, the tool is up to {} off; without, {without}.", millimetres(own, 4)),
        None => format!("The tool is up to {without} off without compensation."),
    }
}

/// Returns what to do next.
fn next_step(report: &Report<'_>, verdict: &Verdict) -> String {
    match verdict.state {
        _ if report.findings.outside.outside() > 0 && verdict.state == State::Bad => {
            "do not load the program: move the workpiece until all of its path is inside the workspace box, and compute again.".into()
        }
        State::Bad
            if verdict.words.starts_with(NOT_TO_BE_RUN)
                || report.verified.exceeded.as_ref().is_some_and(|own| !own.is_empty()) =>
        {
            "do not run the written program: the first sentence below says why.".into()
        }
        State::Bad if report.job.cuts_nowhere() => {
            format!(
                "make the motions that cut such that count, and compute again: the force was not regarded anywhere in {}.",
                report.name
            )
        }
        State::Bad => "find a place where less is needed, or allow larger corrections, and compute again.".into(),
        _ => {
            let off = report.findings.most_by_cutting_mm;
            let air = match off > ROUNDING_MM {
                true => format!(" (in air the tool is up to {} beside its path)", millimetres(off, 3)),
                false => String::new(),
            };
            format!("try the written program above the part{air}, loaded in place of {}.", report.name)
        }
    }
}

/// Returns the main sentence: the largest error without compensation, its line, and the residual error as written.
fn main_sentence(report: &Report<'_>) -> String {
    let name = &report.job.machine.name;
    let Some(worst) = &report.findings.worst else {
        return format!("How far the tool of {name} leaves {} could be computed at none of its points.", report.name);
    };
    let along = report.job.path.points()[worst.point].arc_length_mm;
    let lines = report.findings.lines.worst_lines(report.job);
    let line = lines
        .first()
        .map_or_else(String::new, |worst| format!(", worst in {}, {along:.1} mm along the path", worst.place));
    let off = millimetres(worst.size_mm, 3);
    let residual = report.verified.passes.last().and_then(|pass| pass.summary.max_mm);
    let then = residual.map_or_else(String::new, |residual| {
        format!("; with the compensated program, by {} if all inputs are exact", millimetres(residual, 4))
    });
    let fed = if report.job.feed.is_some() { " at the feeds that [feed] allows" } else { "" };
    format!("Running {}{fed}, the tool of {name} is off by up to {off}{line}{then}.", report.name)
}

/// Returns the share of points within tolerance in words; empty without a tolerance.
fn tolerance_text(job: &ProgramJob, within: ShareWithin) -> String {
    within.text(job.process.tolerance_mm, "on … of the path").unwrap_or_default()
}

/// Returns the largest error without compensation and as written, as key numbers.
fn distances(report: &Report<'_>) -> [Option<KeyNumber>; 2] {
    let Report { job, verified, findings, .. } = report;
    let number = |length: f64, decimals: i32, what: &str, within: ShareWithin, column: String| {
        let found = InTable::new("points", [column], &[], Extreme::Largest, length);
        KeyNumber::new(&millimetres(length, decimals), what, tolerance_text(job, within))
            .held_to(job.process.tolerance_mm, length)
            .found(found)
    };
    let before = "largest distance from the path without compensation, where the tool cuts";
    let after =
        "largest distance with the compensated program as written, simulated with the inputs it was computed from";
    let worst = findings.worst.as_ref().map(|worst| worst.size_mm);
    let residual = verified.passes.last().and_then(|written| written.summary.max_mm);
    [
        worst.map(|worst| number(worst, 3, before, findings.before, error_before_column(Source::All))),
        residual.map(|residual| number(residual, 4, after, findings.after, "error_after_mm".into())),
    ]
}

/// Returns the largest correction as a key number, of prismatic joints where there are both kinds of drives, and whether limits bind; `None` where no
/// point is solved.
fn largest_correction(report: &Report<'_>) -> Option<KeyNumber> {
    let machine = &report.job.machine;
    let of = |kind: Motion| Some((kind, report.findings.corrections[kind as usize]?));
    let mut kinds = machine.drive_kinds().filter_map(of);
    let (kind, most) = kinds.next()?;
    let drives = if machine.has_mixed_drives() { kind_word(machine, kind) } else { "drive" };
    let mut against: Vec<String> =
        kinds.map(|(kind, most)| format!("{} {}", kind_word(machine, kind), kind.position_text(most))).collect();
    against.extend(report.verified.bounded.as_ref().map(|path| match path.summary.prices.len() {
        0 => "no limit binds".to_string(),
        count => format!("{} bind", counted(count, "limit")),
    }));
    Some(KeyNumber::new(&kind.position_text(most), format!("largest {drives} correction"), against.join("; ")))
}

/// Residual error that counts as zero where nothing is rounded, mm.
const EXACT_MM: f64 = 1e-6;
/// How many times its rounding a written program may add to the residual error of its commands.
const ROUNDINGS: f64 = 10.0;

impl VerifiedProgram {
    /// Returns a caution if the residual error as written exceeds that of the commands by more than rounding explains, else `None`.
    pub fn worse_as_written(&self) -> Option<String> {
        let (commanded, written) = (self.commanded_max_mm()?, self.passes.last()?.summary.max_mm?);
        let rounded_mm = self.written.rounded_mm;
        let [leaves, commands, moved] = [written, commanded, rounded_mm].map(|length| millimetres(length, 4));
        (written > commanded + ROUNDINGS * rounded_mm + EXACT_MM).then(|| {
            format!(
                "Do not run the written program: its residual error is {leaves}, that of its commands {commands}, and writing them moved \
                 none by more than {moved}.\n"
            )
        })
    }

    /// Returns whether compensation more probably makes the largest distance larger than not; never with exact inputs.
    pub fn is_probably_worse(&self) -> bool {
        self.spread.as_ref().is_some_and(PathSpread::is_probably_worse)
    }

    /// Returns how many points of the written program have no equilibrium or cannot be reached, in a sentence; `None` if there are none.
    pub fn unsolved_as_written(&self) -> Option<String> {
        let summary = &self.passes.last()?.summary;
        let lost = summary.points - summary.solved;
        let all = summary.points;
        (lost > 0).then(|| {
            format!("{lost} of {all} not solved: the written program fails there; the table of points says why.")
        })
    }
}
