//! The covariance of an identification as uncertain input: draws with its correlations, and files that are none.

use std::{collections::BTreeMap, fs};

use kinetostat::{
    Folder, Overrides, Study, Work,
    map::{self, WorkspaceMapStudy},
    process::uncertainty::{SpreadSource, UncertainParameter},
    questions::StudyKind,
    simulation::Source,
};

use crate::support::{
    command::printed,
    uncertain::{EXACT_MODEL, force},
};

/// The map of a point of `machine` with these entries of the study beside the covariance.
fn map_text(machine: &str, entries: &str) -> String {
    format!(
        "schema = 3\nquestion = \"?\"\nmachine = \"{machine}\"\n{}\n[uncertainty]\nmachine = \"exact\"\ncovariance = \"covariance.csv\"\n{entries}\n{EXACT_MODEL}[workspace_map]\n\
         grid = [1, 1, 1]\nslices_z_mm = [600.0]\nphi_step_deg = 90.0\n",
        force(800.0, 300.0, -200.0)
    )
}

fn read(covariance: &str, entries: &str) -> Result<Box<WorkspaceMapStudy>, String> {
    let folder = Folder::in_memory([("covariance.csv".into(), covariance.as_bytes().to_vec())]);
    match Study::from_toml(&map_text("kr270", entries), "study.toml", folder, &Overrides::default()) {
        Ok(Study { kind: StudyKind::WorkspaceMap(map, _), .. }) => Ok(map),
        Ok(_) => panic!("not a map"),
        Err(error) => Err(error.to_string()),
    }
}

const HEADER: &str = "parameter,other,distribution,value,covariance\n";

/// Rows of joint 2 and joint 3 of the built-in arm, with these variances and covariance of their logarithms.
fn two_joints(variances: [f64; 2], covariance: f64) -> String {
    let machine = kinetostat::Machine::named("kr270").unwrap();
    let row = |name: &str, other: &str, covariance: f64| {
        let value = machine.parameter(name).unwrap().value.unwrap();
        format!("{name},{other},lognormal,{value:?},{covariance:?}\n")
    };
    let [a, b] = ["arm.A2.stiffness", "arm.A3.stiffness"];
    HEADER.to_string() + &row(a, a, variances[0]) + &row(a, b, covariance) + &row(b, b, variances[1])
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let sum = |f: &dyn Fn(f64, f64) -> f64| a.iter().zip(b).map(|(a, b)| f(*a, *b)).sum::<f64>();
    sum(&|a, b| a * b) / (sum(&|a, _| a * a) * sum(&|_, b| b * b)).sqrt()
}

#[test]
fn draws_have_the_correlations_of_the_file() {
    for expected in [-0.8, 0.0, 0.5, 1.0] {
        let study = read(&two_joints([0.04, 0.09], expected * 0.06), "").unwrap();
        let uncertainty = study.uncertainty.as_ref().unwrap();
        assert_eq!(uncertainty.draws.correlated, [0, 1]);
        let [a, b] = &uncertainty.draws.normal[..] else { panic!("two parameters") };
        assert!((correlation(a, b) - expected).abs() < 5e-3, "{} instead of {expected}", correlation(a, b));
        for (own, std) in uncertainty.parameters.iter().zip([0.2, 0.3]) {
            let [low, high] = own.interval_95();
            assert!((f64::ln(high / low) / (2.0 * 1.959_963_984_540_054) - std).abs() < 1e-12, "{own:?}");
        }
    }
}

/// Joints that yield in turn spread the deflection less than joints that yield together, and count as one cause.
#[test]
fn what_is_correlated_spreads_together() {
    let spread = |covariance: f64| {
        let study = read(&two_joints([0.04, 0.04], covariance), "").unwrap();
        let points = map::run(&study, &Work::default()).unwrap().points;
        points[0].effect(Source::All).unwrap().spread.clone().unwrap()
    };
    let (against, alone, together) = (spread(-0.036), spread(0.0), spread(0.036));
    let ratio = |own: &kinetostat::simulation::spread::DeflectionSpread| own.p95_mm.unwrap() / own.median_mm.unwrap();
    assert!(ratio(&against) < ratio(&alone) && ratio(&alone) < ratio(&together), "{against:?} {alone:?} {together:?}");
    for own in [&against, &alone, &together] {
        assert_eq!(own.main_cause.as_deref(), Some("arm.A2.stiffness with arm.A3.stiffness"));
        assert!(
            (own.main_cause_share.unwrap() - 1.0).abs() < 1e-12 && own.check_difference.unwrap().abs() < 0.02,
            "{own:?}"
        );
    }
}

/// Known twice as well, by four times the measurements: a quarter of each entry of the covariance, and the P95 is that of such a file.
#[test]
fn what_is_correlated_is_measured_together() {
    let read = |share: f64| read(&two_joints([0.04 * share, 0.09 * share], 0.05 * share), "").unwrap();
    let (study, then) = (read(1.0), read(0.25));
    let name = "arm.A2.stiffness with arm.A3.stiffness";
    let (measured, words) = study.uncertainty.as_ref().unwrap().measured(name).unwrap();
    assert!(words.starts_with("known twice as well"), "{words}");
    let expected = &then.uncertainty.as_ref().unwrap().draws;
    for (own, other) in measured.draws.coordinates.iter().flatten().zip(expected.coordinates.iter().flatten()) {
        assert!((own - other).abs() < 1e-12, "{own} {other}");
    }
    let p95 = |study: &WorkspaceMapStudy| {
        map::run(study, &Work::default()).unwrap().points[0]
            .effect(Source::All)
            .unwrap()
            .spread
            .clone()
            .unwrap()
            .p95_mm
            .unwrap()
    };
    let measured = WorkspaceMapStudy { uncertainty: Some(measured), ..(*study).clone() };
    assert!((p95(&measured) / p95(&then) - 1.0).abs() < 1e-9 && p95(&then) < 0.95 * p95(&study));
}

#[test]
fn an_entry_of_the_study_comes_first_and_cuts_what_it_names() {
    let entry = "[[uncertainty.parameter]]\nname = \"arm.A3.stiffness\"\nrelative_std = 0.1\n";
    let study = read(&two_joints([0.04, 0.09], 0.05), entry).unwrap();
    let uncertainty = study.uncertainty.as_ref().unwrap();
    let names: Vec<&str> = uncertainty.parameters.iter().map(UncertainParameter::name).collect();
    assert_eq!(names, ["arm.A3.stiffness", "arm.A2.stiffness"]);
    assert_eq!(
        (&uncertainty.draws.correlated[..], &uncertainty.dropped_correlations[..]),
        (&[1][..], &["arm.A3.stiffness".to_string()][..])
    );
    let points = map::run(&study, &Work::default()).unwrap().points;
    let mut summary = map::report::Summary::new(&study);
    points.iter().for_each(|point| summary.add(point));
    let said = map::report::text(&summary, &[]).cautions;
    assert!(
        said.contains("Not taken from the identification, but varied by themselves or not at all: arm.A3.stiffness."),
        "{said}"
    );
}

#[test]
fn what_is_no_covariance_of_the_machine_is_refused() {
    let good = two_joints([0.04, 0.09], 0.05);
    let lines: Vec<&str> = good.lines().collect();
    let without = |line: usize| {
        lines.iter().enumerate().filter(|(i, _)| *i != line).map(|(_, own)| format!("{own}\n")).collect::<String>()
    };
    let refused = |text: &str| read(text, "").map(|_| ()).unwrap_err();
    for (text, expected) in [
        (
            String::new(),
            "covariance.csv:1: is empty: expected the columns parameter, other, distribution, value, covariance",
        ),
        (good.replace(",covariance\n", ",variance\n"), "covariance.csv:1: covariance: missing column"),
        (without(2), "covariance.csv: lacks a row of arm.A2.stiffness and arm.A3.stiffness"),
        (without(3), "covariance.csv:3: other: arm.A3.stiffness has no row with itself"),
        (
            format!("{good}{}\n", lines[2]),
            "covariance.csv:5: other: arm.A2.stiffness and arm.A3.stiffness are given twice",
        ),
        (format!("{good}{}\n", lines[1]), "covariance.csv:5: parameter: arm.A2.stiffness is given twice"),
        (
            good.replacen("lognormal", "gamma", 1),
            "covariance.csv:2: distribution: expected lognormal or normal, got \"gamma\"",
        ),
        (good.replace(",0.05\n", ",many\n"), "covariance.csv:3: covariance: expected a number, got \"many\""),
        (good.replace(",0.05\n", ",NaN\n"), "covariance.csv:3: covariance: expected a number, got \"NaN\""),
        (
            two_joints([0.0, 0.09], 0.01),
            "covariance.csv: arm.A2.stiffness does not vary, and has a covariance with arm.A3.stiffness",
        ),
        (
            two_joints([-0.04, 0.09], 0.0),
            "covariance.csv: the variance of arm.A2.stiffness is -0.04: expected none below 0",
        ),
        (
            two_joints([0.04, 0.09], 0.07),
            "covariance.csv: is no covariance: its matrix of correlations has the eigenvalue -1.667e-1",
        ),
        (good.replace("arm.A3.stiffness", "arm.A9.stiffness"), "uncertainty.covariance: "),
        (
            good.replacen(",0.04\n", ",\n", 1).replace(lines[2], ""),
            "uncertainty.covariance: the measurements left arm.A2.stiffness open",
        ),
    ] {
        let said = refused(&text);
        assert!(said.contains(expected), "{expected}\n{said}\n{text}");
    }
    // Nothing identified, and everything named by entries: what is left is what the study says.
    let varies_nothing = "uncertainty: varies nothing";
    assert!(refused(HEADER).contains(varies_nothing), "{}", refused(HEADER));
    let open = good.replace(",0.04\n", ",\n").replace(",0.09\n", ",\n").replace(&format!("{}\n", lines[2]), "");
    assert!(refused(&open).contains("the measurements left arm.A2.stiffness open"), "{}", refused(&open));
    let all = "[[uncertainty.parameter]]\nname = \"arm.*.stiffness\"\nrelative_std = 0.1\n";
    for text in [&good, &open] {
        let study = read(text, all).unwrap();
        assert!(
            study.uncertainty.as_ref().is_some_and(|own| own.draws.correlated.is_empty() && own.parameters.len() == 6)
        );
    }
    let value = lines[1].split(',').nth(3).unwrap();
    let said = refused(&good.replacen(&format!(",{value},0.04"), ",1.0,0.04", 1));
    assert!(
        said.contains("arm.A2.stiffness is 1 where it was identified and")
            && said.contains("expected the machine file"),
        "{said}"
    );
}

/// What the identification of the template writes is what a map reads: the standard deviations of its table.
#[test]
fn an_identification_writes_what_a_map_reads() {
    let folder = tempfile::tempdir().unwrap();
    let [study, results] = ["mine", "results"].map(|name| folder.path().join(name).display().to_string());
    printed(&["new", "identification", &study]);
    printed(&["run", &study, "--out", &results, "--no-figures", "--quiet"]);
    let found = folder.path().join("results");
    let found = if found.join("covariance.csv").exists() { found } else { found.join("mine") };
    let machine = fs::read_dir(&found).unwrap().map(|file| file.unwrap().path());
    let machine = machine.into_iter().find(|file| file.file_name().is_some_and(|name| name == "machine.toml")).unwrap();
    let table: Vec<BTreeMap<String, String>> =
        csv::Reader::from_path(found.join("parameters.csv")).unwrap().deserialize().map(Result::unwrap).collect();
    let own = Folder::in_memory([
        ("covariance.csv".into(), fs::read(found.join("covariance.csv")).unwrap()),
        ("machine.toml".into(), fs::read(machine).unwrap()),
    ]);
    let box_z = "grid = [1, 1, 1]\n";
    let open = table.iter().filter(|row| row["status"] != "identified");
    let entries: String = open
        .map(|row| format!("[[uncertainty.parameter]]\nname = \"{}\"\nrelative_std = 0.3\n", row["parameter"]))
        .collect();
    let text = map_text("machine.toml", &entries).replace("grid = [1, 1, 1]\nslices_z_mm = [600.0]\n", box_z);
    let z = kinetostat::Machine::named("fanuc_r2000ic").unwrap().workspace.min.z;
    let text = text.replace(box_z, &format!("{box_z}slices_z_mm = [{z:?}]\n"));
    let study = Study::from_toml(&text, "study.toml", own.clone(), &Overrides::default()).unwrap();
    let StudyKind::WorkspaceMap(study, _) = study.kind else { panic!("not a map") };
    let uncertainty = study.uncertainty.as_ref().unwrap();
    let mut count = 0;
    for row in table.iter().filter(|row| row["status"] == "identified") {
        let parameter = uncertainty.parameters.iter().find(|own| own.name() == row["parameter"]).unwrap();
        let (value, std): (f64, f64) = (row["value"].parse().unwrap(), row["std"].parse().unwrap());
        // One standard deviation of the logarithm times the value, as the table has it.
        let found = (parameter.at(1.0).next().unwrap().1 / value).ln() * value;
        assert!((found / std - 1.0).abs() < 1e-9, "{row:?}: {found}");
        count += 1;
    }
    // What the parameters do not explain comes from the measurements, unless the study says it.
    assert_eq!(uncertainty.model.relative_std, 0.0);
    let study = Study::from_toml(&text.replace(EXACT_MODEL, ""), "study.toml", own, &Overrides::default()).unwrap();
    let StudyKind::WorkspaceMap(study, _) = study.kind else { panic!("not a map") };
    let (model, source) = (study.uncertainty.as_ref().unwrap().model, SpreadSource::Identified);
    let summary: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(found.join("summary.json")).unwrap()).unwrap();
    let share = summary["residual_share"].as_f64().unwrap();
    assert!((model.relative_std - share).abs() < 1e-12 && model.source == source, "{model:?}, {share}");
    assert!(count >= 3 && uncertainty.draws.correlated.len() == count, "{count}: {:?}", uncertainty.draws.correlated);
}

/// All pairs of 300 names are read at once, and of what does not fit ten are told.
#[test]
fn many_names_are_read_at_once_and_ten_are_told() {
    let pairs = (0..300).flat_map(|a| (a..300).map(move |b| (a, b)));
    let rows: String = pairs.map(|(a, b)| format!("p{a},p{b},normal,1,{}\n", u8::from(a == b))).collect();
    let begun = std::time::Instant::now();
    let error = read(&format!("{HEADER}{rows}"), "").unwrap_err();
    assert!(begun.elapsed().as_secs() < 10, "{:?}", begun.elapsed());
    assert!(error.starts_with("300 values do not fit") && error.ends_with("\n  and 290 more"), "{error}");
    assert_eq!(error.lines().count(), 12, "{error}");
}
