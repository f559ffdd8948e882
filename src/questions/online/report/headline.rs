//! The first screen of an online study: from which force error on the sensor pays.

use super::{Compared, percent_of, text};
use crate::{
    files::words::{counted, if_any, millimetres},
    page::headline::{Headline, KeyNumber},
    questions::online::{BreakEven, LoopGain},
};

/// The answer at a glance.
pub(super) fn headline(compared: &Compared<'_>) -> Headline {
    let study = compared.study;
    let basis = format!(
        "{} at {}, a path of {}",
        counted(study.seeds, "seed"),
        counted(study.force_errors.len(), "force error"),
        counted(study.path.stations.len(), "point")
    );
    Headline::new(sentence(compared), basis)
        .with_cautions(&text::cautions(compared))
        .with_all(break_even(compared))
        .with_all(residual(compared))
        .with_all(compared.results.loop_gain.as_ref().map(loop_gain))
}

fn sentence(compared: &Compared<'_>) -> String {
    let name = compared.study.path.machine.short_title();
    match compared.break_even {
        Some(BreakEven::Always) => format!(
            "On this path of the {name} correcting by measured forces leaves less than correcting by predicted ones even if the \
             prediction is right."
        ),
        Some(BreakEven::From(error)) => format!(
            "On this path of the {name} it pays to measure the force and to correct in the controller once its prediction is \
             wrong by more than {}.",
            percent_of(error)
        ),
        Some(BreakEven::Never(error)) => format!(
            "On this path of the {name} correcting beforehand leaves less, even if the predicted force is wrong by {}: \
             measuring it does not pay.",
            percent_of(error)
        ),
        None => format!("Corrections of the {name} could be compared at none of the force errors."),
    }
}

fn break_even(compared: &Compared<'_>) -> Option<KeyNumber> {
    let BreakEven::From(error) = compared.break_even? else { return None };
    let number = percent_of(error);
    let what = "error of the predicted force from which on measuring it pays";
    Some(KeyNumber::new(&number, what, "one standard deviation over programs"))
}

/// What both leave at the largest force error.
fn residual(compared: &Compared<'_>) -> Option<KeyNumber> {
    let [offline, online] = compared.at_the_largest()?;
    let largest = percent_of(compared.study.force_errors.last().copied()?);
    let what = format!("rms distance left by measured forces if their prediction is wrong by {largest}, in the median");
    let plain = if_any(compared.results.plain.rms_mm, |rms| format!("; {} without correction", millimetres(rms, 4)));
    Some(KeyNumber::new(
        &millimetres(online, 4),
        what,
        format!("by predicted forces {}{plain}", millimetres(offline, 4)),
    ))
}

fn loop_gain(found: &LoopGain) -> KeyNumber {
    let shown = format!("{:.0} N/mm", found.largest_stiffness_N_per_mm);
    let against = match found.gain {
        Some(gain) if gain.is_finite() => format!("the loop has a gain of {gain:.2} at the stiffness that is given"),
        Some(_) => "at the stiffness that is given the cut itself does not settle".into(),
        None => "no cutting stiffness is given".into(),
    };
    KeyNumber::new(&shown, "cutting stiffness from which on the correction feeds on itself", against)
}
