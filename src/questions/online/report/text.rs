//! What an online study says, in sentences and a small table.

use super::{Compared, percent_of, quantities};
use crate::{
    files::{
        text_table::text_table,
        words::{if_any, millimetres_in_table},
    },
    questions::{
        online::Band,
        path::report::{cautions_of, facts_text},
    },
    simulation::SOLVED,
};

/// What must be known with the answer.
pub(super) fn cautions(compared: &Compared<'_>) -> String {
    unsafe_loop(compared) + &unsolved(compared) + &cautions_of(&compared.study.path)
}

fn unsafe_loop(compared: &Compared<'_>) -> String {
    let (Some(stiffness), Some(found)) = (compared.study.cutting_stiffness, compared.results.loop_gain) else {
        return String::new();
    };
    match found.gain {
        Some(gain) if gain.is_infinite() => format!(
            "Not safe: at {stiffness} N/mm the cut does not settle where the tool is drawn in, with or without correction.\n"
        ),
        Some(gain) if gain >= 1.0 => format!(
            "Not safe: at {stiffness} N/mm the gain of the loop is {gain:.2}, and the correction feeds on itself where the tool \
             is drawn in. What the trials leave is not what such a loop leaves.\n"
        ),
        _ => String::new(),
    }
}

fn unsolved(compared: &Compared<'_>) -> String {
    let trials = &compared.results.trials;
    let partly = trials.iter().filter(|trial| quantities::status(trial) != SOLVED);
    match partly.count() {
        0 => String::new(),
        count => format!("In {count} of {} trials the machine does not settle at every point.\n", trials.len()),
    }
}

/// All of it.
pub(super) fn details(compared: &Compared<'_>) -> String {
    let mut table = text_table(["force error", "predicted", "5 % to 95 %", "measured", "5 % to 95 %"], 1);
    let shown = |value: f64| millimetres_in_table(value, 4);
    let median = |band: &Option<Band>| if_any(*band, |band| shown(band.median_mm));
    let between =
        |band: &Option<Band>| if_any(*band, |band| format!("{} to {}", shown(band.low_mm), shown(band.high_mm)));
    let rows = compared.study.force_errors.iter().zip(compared.offline.iter().zip(&compared.online));
    for (error, (offline, online)) in rows {
        table.add_row([percent_of(*error), median(offline), between(offline), median(online), between(online)]);
    }
    let plain = if_any(compared.results.plain.rms_mm, shown);
    format!(
        "Rms distance of the tool from its path, where it cuts, in the median over seeds, corrected by predicted and by measured \
         forces; {plain} without correction.\n{table}\n{}",
        facts_text(&compared.study.path.facts)
    )
}
