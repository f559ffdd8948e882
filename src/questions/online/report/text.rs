//! Sentences, first screen and small table of an online study.

use super::{Compared, about_percent, percent_of, quantities};
use crate::{
    files::{
        text_table::text_table,
        words::{counted, millimetres, millimetres_in_table, or_dash},
    },
    page::headline::{Headline, KeyNumber, State, Verdict},
    questions::{
        online::{Band, BreakEven, LoopGain},
        path::report::{MOVE_INSIDE, facts_text, outside_positions, path_cautions},
        spread_report::{self, SpreadCounts},
    },
    simulation::SOLVED,
};

/// Returns the cautions that a reader must know before the results, a line each.
pub(super) fn cautions(compared: &Compared<'_>) -> String {
    let uncertainty = compared.study.path.uncertainty.as_deref();
    let drawn = uncertainty.map_or_else(String::new, |own| {
        format!(
            "With {}: each seed cuts on a machine of its own, the same for both ways to correct; their model stays as it is.\n",
            spread_report::counted_inputs(own)
        )
    });
    unsafe_loop_text(compared)
        + &unsolved_text(compared)
        + &drawn
        + &spread_report::cautions(uncertainty, &SpreadCounts::default(), "trial", None)
        + &path_cautions(&compared.study.path)
}

/// Warns if the loop through the cutting force does not converge at the given cutting stiffness; else empty.
fn unsafe_loop_text(compared: &Compared<'_>) -> String {
    let (Some(stiffness), Some(loop_gain)) = (compared.study.cutting_stiffness, compared.results.loop_gain) else {
        return String::new();
    };
    match loop_gain.gain {
        Some(gain) if gain.is_infinite() => format!(
            "Not safe: at {stiffness} N/mm the cut itself is unstable where it draws the tool in, with or without correction.\n"
        ),
        Some(gain) if gain >= 1.0 => format!(
            "Not safe: at {stiffness} N/mm the gain of the loop is {gain:.2}, and the control loop diverges where the tool is drawn \
             in. The residual errors of the trials are not those of such a loop.\n"
        ),
        _ => String::new(),
    }
}

/// Says in how many trials a point was not solved; empty if in none.
fn unsolved_text(compared: &Compared<'_>) -> String {
    let trials = &compared.results.trials;
    match trials.iter().filter(|trial| quantities::status(trial) != SOLVED).count() {
        0 => String::new(),
        count => format!("In {count} of {} trials some points were not solved.\n", trials.len()),
    }
}

/// Returns the table of medians and 5 % to 95 % bands, a row for each force error, with the facts of the path.
pub(super) fn details(compared: &Compared<'_>) -> String {
    let mut table = text_table(["force error", "predicted", "5 % to 95 %", "measured", "5 % to 95 %"], 1);
    let shown = |value: f64| millimetres_in_table(value, 4);
    let median = |band: &Option<Band>| or_dash(*band, |band| shown(band.median_mm));
    let between =
        |band: &Option<Band>| or_dash(*band, |band| format!("{} to {}", shown(band.low_mm), shown(band.high_mm)));
    let rows = compared.study.force_errors.iter().zip(compared.offline.iter().zip(&compared.online));
    for (error, (offline, online)) in rows {
        table.add_row([percent_of(*error), median(offline), between(offline), median(online), between(online)]);
    }
    let uncorrected = or_dash(compared.results.plain.rms_mm, shown);
    format!(
        "Rms distance of the tool from its path, where it cuts, in the median over seeds, corrected by predicted and by measured \
         forces; {uncorrected} without correction.\n{table}\n{}",
        facts_text(&compared.study.path.facts)
    )
}

/// Returns the first screen: main sentence, cautions and key numbers.
pub(super) fn headline(compared: &Compared<'_>) -> Headline {
    let study = compared.study;
    let basis = format!(
        "{} at {}, a path of {}, {}",
        counted(study.seeds, "seed"),
        counted(study.force_errors.len(), "force error"),
        counted(study.path.stations.len(), "point"),
        study.path.uncertainty.as_ref().map_or("inputs taken as exact", |_| "a drawn machine each")
    );
    let of_medians = " This is said of medians over machines; in how many it is so stands below.";
    let medians = study.path.uncertainty.as_ref().map_or("", |_| of_medians);
    let positions = outside_positions(&study.path);
    let verdict = match compared.break_even {
        _ if positions.outside() > 0 => positions.state(&study.path.machine),
        Some(BreakEven::Always) => Verdict::new(State::Good, "Measuring the force pays"),
        Some(BreakEven::From(error)) => {
            Verdict::new(State::Partly, format!("Measuring pays above about {} force error", about_percent(error)))
        }
        Some(BreakEven::Never(_)) => Verdict::new(State::Bad, "Measuring the force does not pay"),
        None => Verdict::new(State::Bad, "Nothing could be compared"),
    };
    let next = match compared.break_even {
        _ if positions.outside() > 0 => MOVE_INSIDE,
        Some(BreakEven::Never(_)) => "write the compensated program with kinetostat compensate.",
        Some(BreakEven::Always) => "measure the force, and correct in the controller.",
        Some(BreakEven::From(_)) => "find how far off the prediction of the force is: cut once, and measure it.",
        None => "see in trials.csv why nothing could be compared.",
    };
    let barred = positions.sentence(&study.path.machine);
    Headline::new(barred.unwrap_or_else(|| first_sentence(compared)), basis)
        .judged(verdict, study.path.uncertainty.is_none())
        .marked("simulated")
        .next(next)
        .with_cautions(&(positions.verdict(&study.path.machine, "this path") + &main_sentence(compared) + medians))
        .with_cautions(&cautions(compared))
        .with_numbers(sure_key_number(compared))
        .with_numbers(break_even_key_number(compared))
        .with_numbers(residual_key_number(compared))
        .with_numbers(compared.results.loop_gain.as_ref().map(stiffness_key_number))
}

/// Returns the first sentence.
fn first_sentence(compared: &Compared<'_>) -> String {
    match compared.break_even {
        Some(BreakEven::Always) => "Measured forces always leave the smaller error.".into(),
        Some(BreakEven::From(error)) => {
            format!("Measuring pays once the predicted force is about {} off.", about_percent(error))
        }
        Some(BreakEven::Never(error)) => {
            format!("Predicted forces leave less, even if they are {} off.", percent_of(error))
        }
        None => "Corrections could be compared at none of the force errors.".into(),
    }
}

/// Returns the main sentence: from which force error on measuring the force pays.
fn main_sentence(compared: &Compared<'_>) -> String {
    let name = &compared.study.path.machine.name;
    match compared.break_even {
        Some(BreakEven::Always) => format!(
            "On this path of {name} the residual error is smaller when measured forces correct than when predicted ones do, even if \
             the prediction is right."
        ),
        Some(BreakEven::From(error)) => format!(
            "On this path of {name} it pays to measure the force and to correct in the controller once its prediction is off by more \
             than about {}.",
            about_percent(error)
        ),
        Some(BreakEven::Never(error)) => format!(
            "On this path of {name} correcting beforehand has the smaller residual error, even if the predicted force is off by {}: \
             measuring the force does not pay.",
            percent_of(error)
        ),
        None => format!("Corrections of {name} could be compared at none of the force errors."),
    }
}

/// Returns the break-even force error as a key number; `None` if one way is always better.
fn break_even_key_number(compared: &Compared<'_>) -> Option<KeyNumber> {
    let BreakEven::From(error) = compared.break_even? else { return None };
    let what = "error of the predicted force from which on measuring pays, to one digit";
    Some(KeyNumber::new(&about_percent(error), what, "one standard deviation over programs"))
}

/// Returns with which probability measured forces leave less at the largest force error as a key number; `None` where inputs are taken as exact.
fn sure_key_number(compared: &Compared<'_>) -> Option<KeyNumber> {
    let study = compared.study;
    study.path.uncertainty.as_deref()?;
    let text = |share| spread_report::share_text(share, study.seeds);
    let largest = percent_of(study.force_errors.last().copied()?);
    let what = format!("probability that measured forces leave less, if their prediction is off by {largest}");
    let within = compared.within_tolerance().zip(study.path.tolerance_mm).map(|([offline, online], tolerance)| {
        format!(
            "within {tolerance} mm all along the path with {} probability, by predicted forces with {}",
            text(online),
            text(offline)
        )
    });
    Some(KeyNumber::new(&text(compared.measured_is_smaller()?), what, within.unwrap_or_default()))
}

/// Returns the residual of both ways at the largest force error as a key number; `None` where one of them has none.
fn residual_key_number(compared: &Compared<'_>) -> Option<KeyNumber> {
    let [offline, online] = compared.medians_at_largest()?;
    let largest = percent_of(compared.study.force_errors.last().copied()?);
    let what = format!("rms residual error by measured forces if their prediction is off by {largest}, in the median");
    let nominally = if compared.study.path.uncertainty.is_some() { " on the nominal machine" } else { "" };
    let plain = or_dash(compared.results.plain.rms_mm, |rms| {
        format!("; {} without correction{nominally}", millimetres(rms, 4))
    });
    Some(KeyNumber::new(
        &millimetres(online, 4),
        what,
        format!("by predicted forces {}{plain}", millimetres(offline, 4)),
    ))
}

/// Returns the largest stable cutting stiffness as a key number.
fn stiffness_key_number(loop_gain: &LoopGain) -> KeyNumber {
    let shown = format!("{:.0} N/mm", loop_gain.largest_stiffness_N_per_mm);
    let against = match loop_gain.gain {
        Some(gain) if gain.is_finite() => format!("the loop has a gain of {gain:.2} at the stiffness that is given"),
        Some(_) => "at the stiffness that is given the cut itself is unstable".into(),
        None => "the process gives no cutting stiffness to hold it against".into(),
    };
    KeyNumber::new(&shown, "cutting stiffness from which on the control loop diverges", against)
}
