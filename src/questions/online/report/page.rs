//! What the page of an online study shows.

use super::{Compared, percent_of, text};
use crate::{
    files::words::{counted, millimetres},
    page::{
        Better, Column, Description, Explorer, Fact, Group, GroupValue, MachineDescription, Quantity, Section, Shape,
        TableNote, error_facts,
    },
    questions::online::OnlineStudy,
};

/// Sections, setting, views and tables; first screen, figures and question are added by the run.
pub(super) fn page(compared: &Compared<'_>) -> Description {
    let study = compared.study;
    Description {
        setting: setting(study),
        terms: terms(),
        explorers: vec![over_error()],
        tables: vec![
            TableNote::new("bands.csv", "One row per force error and way to correct: rms distances over seeds."),
            TableNote::new("trials.csv", "One row per force error and seed: what both ways to correct leave."),
        ],
        sections: vec![
            Section::new("What does each correction leave?", "over the error of the predicted force")
                .text(&text::details(compared))
                .explorers([OVER_ERROR])
                .tables(["bands.csv", "trials.csv"]),
        ],
        ..Description::new("online", MachineDescription::new(&study.path.machine))
    }
}

const OVER_ERROR: &str = "What corrections leave over the force error";

fn terms() -> Vec<Fact> {
    vec![
        Fact::new(
            "force error",
            "standard deviation of the force in the cut about the predicted one, as a share of it",
        ),
        Fact::new(
            "cutting stiffness",
            "by how much the cutting force changes as the tool leaves its depth, N per mm; a loop whose gain is below 1 settles",
        ),
    ]
}

fn setting(study: &OnlineStudy) -> Vec<Fact> {
    let path = &study.path;
    let length = path.stations.last().map_or(0.0, |station| station.arc_length_mm);
    let sensor = &study.sensor;
    let filter = sensor.low_pass_Hz.map_or_else(|| "no low-pass".into(), |corner| format!("low-pass at {corner} Hz"));
    let mut facts = vec![
        Fact::new("machine", path.machine.title.clone()),
        Fact::new(
            "path",
            format!("{length:.1} mm at {} mm/min, {}", study.feed_mm_per_min, counted(path.stations.len(), "point")),
        ),
        Fact::new("controller", format!("a command every {} ms", shown(1000.0 * sensor.cycle_s))),
        Fact::new(
            "sensor",
            format!(
                "{} ms late, {filter}, noise of {} N, bias of {} N (standard deviations)",
                shown(1000.0 * sensor.delay_s),
                sensor.noise_N,
                sensor.bias_N
            ),
        ),
        Fact::new(
            "model",
            format!(
                "bends {} too {}, knows {} of the chain errors",
                percent_of(study.too_soft.abs()),
                if study.too_soft < 0.0 { "little" } else { "much" },
                percent_of(study.known_share)
            ),
        ),
    ];
    let limit = |label: &str, limit: Option<f64>| limit.map(|limit| Fact::new(label, millimetres(limit, 4)));
    facts.extend(limit("largest correction", study.limits.correction_mm));
    facts.extend(limit("largest change of the correction", study.limits.correction_change_mm));
    facts.extend(path.facts.iter().map(|(label, words)| Fact::new(*label, words.clone())));
    facts.extend(path.machine.held_words().map(|words| Fact::new("held", words)));
    facts.extend(error_facts(&path.machine, &path.errors));
    facts
}

fn by_force(name: &str) -> GroupValue {
    GroupValue { cells: vec![name.into()], label: format!("by the {name} force") }
}

/// A number without the rounding of its unit.
fn shown(value: f64) -> f64 {
    (value * 1e9).round() / 1e9
}

fn over_error() -> Explorer {
    Explorer {
        title: OVER_ERROR.into(),
        table: "bands.csv".into(),
        shape: Shape::Curve,
        coordinates: vec![Column::new("force_error_percent", "force error", "%")],
        group: Some(Group {
            columns: vec!["correction".into()],
            label: "correction".into(),
            values: ["predicted", "measured"].map(by_force).into(),
        }),
        quantities: vec![
            Quantity::new(["rms_median_mm"], "median of the rms distance", "mm", Better::Smaller),
            Quantity::new(["rms_low_mm"], "rms distance that 5 % of the seeds stay below", "mm", Better::Smaller),
            Quantity::new(["rms_high_mm"], "rms distance that 5 % of the seeds exceed", "mm", Better::Smaller),
        ],
        marks: Vec::new(),
    }
}
