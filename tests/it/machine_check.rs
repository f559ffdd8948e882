//! What `check` finds of a machine: reach, droop, payload, where its compliance comes from, and numbers in another unit.

use kinetostat::{
    inspect::machine_check::{self, Findings, Payload, report::machine_text},
    machine::{Machine, catalogue},
};

use crate::support::engine::machine_from;

/// What `check` finds of a machine without bodies in files.
fn check(machine: &Machine) -> Findings {
    machine_check::check(machine).unwrap()
}

const G: f64 = 9.81;

fn near(what: &str, found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance * expected.abs().max(1.0), "{what}: {found} instead of {expected}");
}

/// Three slides with travel of ±200 mm, the last along z, that carry 20 kg; `keys`: more of the last.
fn gantry(keys: &str) -> Machine {
    machine_from(&gantry_text(keys))
}

/// The same with so much travel along x to either side of home, mm.
fn gantry_along_x(travel: f64) -> Machine {
    machine_from(&gantry_text("").replacen("[-200.0, 200.0]", &format!("[-{travel:?}, {travel:?}]"), 1))
}

fn gantry_text(keys: &str) -> String {
    format!(
        r#"
schema = 1
name = "gantry"
title = "three prismatic joints"
workspace = {{ min_mm = [-100.0, -50.0, 0.0], max_mm = [100.0, 50.0, 60.0] }}
home = {{ position_mm = [0.0, 0.0, 0.0] }}
[platform]
tool_tip_mm = [0.0, 0.0, 0.0]
controls = ["x", "y", "z"]
mass = {{ kg = 20.0 }}
[[chain]]
name = "arm"
elements = [
  {{ prismatic_drive = {{ name = "X", axis = "x", stiffness_N_per_mm = 4000.0, travel_mm = [-200.0, 200.0] }} }},
  {{ prismatic_drive = {{ name = "Y", axis = "y", stiffness_N_per_mm = 2000.0, travel_mm = [-200.0, 150.0] }} }},
  {{ prismatic_drive = {{ name = "Z", axis = "z", stiffness_N_per_mm = 1000.0, travel_mm = [-200.0, 200.0]{keys} }} }},
]
[[mount]]
name = "arm"
chain = "arm"
"#
    )
}

/// A beam on a revolute joint about y with this stiffness and limit.
fn beam_on_a_hinge(stiffness: f64, limit: f64) -> Machine {
    machine_from(&format!(
        r#"
schema = 1
name = "hinge"
title = "a beam on a revolute joint"
workspace = {{ min_mm = [500.0, 0.0, 0.0], max_mm = [500.0, 0.0, 0.0] }}
home = {{ position_mm = [500.0, 0.0, 0.0] }}
[platform]
tool_tip_mm = [0.0, 0.0, 0.0]
controls = ["z"]
[[chain]]
name = "arm"
elements = [
  {{ revolute_drive = {{ name = "A", axis = "y", stiffness_Nmm_per_rad = {stiffness:?}, torque_limit_Nmm = {limit:?}, travel_deg = [-60.0, 60.0] }} }},
  {{ fixed = {{ translation_mm = [500.0, 0.0, 0.0] }} }},
]
[[mount]]
name = "arm"
chain = "arm"
"#
    ))
}

fn payload(findings: &Findings) -> &Payload {
    findings.survey.as_ref().unwrap().payload.as_ref().expect("a payload")
}

#[test]
fn reach_is_the_travel_of_slides() {
    let findings = check(&gantry(""));
    let spans = findings.spans.map(|span| span.expect("controlled"));
    for (found, expected) in spans.as_flattened().iter().zip([-200.0, 200.0, -200.0, 150.0, -200.0, 200.0]) {
        near("span", *found, expected, 0.1);
    }
    // A machine that does not control x and y says nothing of them.
    let revolute = check(&beam_on_a_hinge(1e8, 1e5));
    assert!(revolute.spans[0].is_none() && revolute.spans[1].is_none());
}

#[test]
fn a_very_long_slide_is_followed_to_its_ends_in_few_steps() {
    let began = std::time::Instant::now();
    let [along, ..] = check(&gantry_along_x(1e8)).spans;
    for (found, expected) in along.unwrap().into_iter().zip([-1e8, 1e8]) {
        near("span", found, expected, 0.1);
    }
    // In steps of a length, minutes.
    assert!(began.elapsed().as_secs() < 30, "{:?}", began.elapsed());
}

#[test]
fn droop_is_weight_over_stiffness_everywhere() {
    let survey = check(&gantry("")).survey.unwrap();
    assert_eq!((survey.counts, survey.reached), ([5, 5, 5], 125));
    for droop in survey.droop.unwrap().range_mm {
        near("droop", droop, 20.0 * G / 1000.0, 1e-9);
    }
    let softest = survey.softest.unwrap();
    near("softest", softest.tool_stiffness_n_per_mm[0], 1000.0, 1e-6);
    let shares: f64 = softest.compliance_shares.iter().map(|(_, share)| share).sum();
    near("sum of shares", shares, 1.0, 1e-12);
    near("share of Z", softest.compliance_shares[2].1, 4.0 / 7.0, 1e-9);
    assert!(survey.payload.is_none(), "no drive has a limit");
}

#[test]
fn a_survey_of_what_takes_many_load_steps_ends_and_says_what_it_left_out() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/machines/many_load_steps.toml");
    let machine = Machine::from_toml(&std::fs::read_to_string(file).unwrap(), file).unwrap();
    let findings = check(&machine);
    let survey = findings.survey.as_ref().unwrap();
    assert!(survey.reached == 125 && (1..125).contains(&survey.left_out), "{survey:?}");
    let left_out = format!("droop and payload at {} of these places", survey.left_out);
    let text = machine_text(&machine, &findings);
    assert!(text.contains(&left_out) && !text.contains("payload   "), "{text}");
}

#[test]
fn payload_is_what_the_limit_leaves_beside_the_own_weight() {
    let findings = check(&gantry(", force_limit_N = 500.0"));
    let held = payload(&findings);
    near("payload", held.kilograms, 500.0 / G - 20.0, 1e-6);
    assert_eq!(held.drive, "arm_Z");
    // A limit on a drive that carries nothing is none.
    let sideways = gantry(", force_limit_N = 500.0").with_parameters(&[("gravity.x", G), ("gravity.z", 0.0)]).unwrap();
    assert!(check(&sideways).survey.unwrap().payload.is_none());
}

#[test]
fn payload_of_a_bent_arm_counts_how_far_it_bends() {
    let (stiffness, limit) = (4e5, 1e5);
    let findings = check(&beam_on_a_hinge(stiffness, limit));
    let lever = 500.0 * (limit / stiffness).cos();
    near("payload", payload(&findings).kilograms, limit / (G * lever), 1e-6);
}

#[test]
fn a_drive_too_weak_for_the_machine_itself_is_asked_about() {
    let findings = check(&gantry(", force_limit_N = 0.5"));
    assert_eq!(payload(&findings).kilograms, 0.0);
    let asked = "arm_Z: cannot hold the machine's own weight at (-100, -50, 0) mm within its limit; is the limit 1000 times too small (unit)?";
    assert!(findings.warnings.iter().any(|warning| warning == asked), "{:#?}", findings.warnings);
}

/// Warnings of a machine of the catalogue with one number changed by a factor.
fn asked_of(name: &str, parameter: &str, factor: f64) -> Vec<String> {
    let machine = Machine::named_or_file(name).unwrap();
    let value = machine.parameter(parameter).unwrap().value.unwrap();
    check(&machine.with_parameters(&[(parameter, value * factor)]).unwrap()).warnings
}

#[test]
fn numbers_a_thousand_times_off_are_asked_about() {
    let cases = [
        ("kr270", "arm.A2.stiffness", 1e-3, "arm.A2.stiffness = "),
        ("kr270", "arm.A5.stiffness", 1e3, "arm.A5.stiffness = "),
        ("hexapod", "material.steel.youngs_modulus", 1e-3, "material.steel.youngs_modulus = 210"),
        ("hybrid_3ups", "material.steel.youngs_modulus", 1e6, "material.steel.youngs_modulus = 210000000000"),
        ("fanuc_r2000ic", "platform.mass.kg", 1e3, "platform.mass.kg = 41450"),
        ("fanuc_r2000ic", "platform.mass.kg", 1e3, "weight moves the tool by "),
        ("fanuc_r2000ic", "gravity.z", 3.2808, "gravity_m_per_s2: the magnitude is 32.185 m/s²"),
    ];
    for (name, parameter, factor, begin) in cases {
        let warnings = asked_of(name, parameter, factor);
        assert!(warnings.iter().any(|warning| warning.starts_with(begin)), "{name} {parameter}: {warnings:#?}");
    }
}

/// The warnings about the file of a machine of the catalogue in which `from` is `to`.
fn asked_about(name: &str, from: &str, to: &str) -> Vec<String> {
    let text = catalogue::find(name).unwrap().toml;
    assert!(text.contains(from), "{name}: {from}");
    check(&machine_from(&text.replacen(from, to, 1))).warnings
}

#[test]
fn lengths_masses_angles_and_stiffnesses_in_other_units_are_asked_about_with_key_and_line() {
    let line_of = |name: &str, part: &str| {
        1 + catalogue::find(name).unwrap().toml.lines().position(|line| line.contains(part)).unwrap()
    };
    let [travel, tip] = ["name = \"A1\"", "tool_tip_mm"].map(|part| line_of("kr270", part));
    let foot = line_of("orthoglide", "name = \"foot\"");
    for (name, from, to, asked) in [
        (
            "kr270",
            "travel_deg = [-170.0, 170.0]",
            "travel_deg = [-2.967, 2.967]",
            format!(
                "arm.A1.travel: -2.967° to 2.967° (chain[0].elements[1].revolute_drive.travel_deg, line {travel}): is it in radians?"
            ),
        ),
        (
            "kr270",
            "tool_tip_mm = [0.0, 0.0, 300.0]",
            "tool_tip_mm = [0.0, 0.0, 0.3]",
            format!("platform.tool_tip: 0.300 mm long (platform.tool_tip_mm, line {tip}): is it in metres?"),
        ),
        (
            "orthoglide",
            "length_mm = 165.0",
            "length_mm = 0.165",
            format!("leg.foot.length = 0.165 mm (chain[0].elements[2].beam.length_mm, line {foot}): is it in metres?"),
        ),
    ] {
        let warnings = asked_about(name, from, to);
        assert!(warnings.contains(&asked), "{asked}: {warnings:#?}");
    }
    let asked = |parameter: (&str, &str, f64), end: &str| {
        let warnings = asked_of(parameter.0, parameter.1, parameter.2);
        let is_asked = |warning: &String| {
            warning.starts_with(parameter.1) && warning.contains(", line ") && warning.ends_with(end)
        };
        assert!(warnings.iter().any(is_asked), "{parameter:?}: {warnings:#?}");
    };
    asked(("fanuc_r2000ic", "platform.mass.kg", 1e5), "is it in grams?");
    asked(("kr500", "arm.mass_1.kg", 1e4), "is it in grams?");
    asked(("orthoglide", "leg.rail.stiffness", 3e-4), "is it in N/µm (1 N/µm = 1000 N/mm)?");
    let metres = gantry_text("").replace("200.0", "0.2").replace("150.0", "0.15").replace("100.0", "0.1");
    let metres = metres.replace("50.0", "0.05").replace("60.0", "0.06");
    let warnings = check(&machine_from(&metres)).warnings;
    assert!(warnings.iter().any(|own| own.ends_with("no length is larger; are lengths in metres?")), "{warnings:#?}");
}

#[test]
fn no_unit_of_a_machine_as_meant_is_asked_about() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/machines");
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let files: Vec<_> = files.filter(|file| file.extension().is_some_and(|own| own == "toml")).collect();
    assert!(files.len() > 10);
    for file in files {
        let warnings = check(&Machine::from_file(&file).unwrap()).warnings;
        let asked = warnings.iter().find(|warning| warning.contains("is it in ") || warning.contains("in metres?"));
        assert!(asked.is_none(), "{}: {asked:?}", file.display());
    }
}

#[test]
fn check_says_where_phi_is_zero_and_in_which_lines_provenance_is() {
    let kr270 = catalogue::find("kr270").unwrap().toml;
    let said = |text: &str| {
        let machine = machine_from(text);
        machine_text(&machine, &check(&machine))
    };
    assert!(
        said(kr270)
            .contains("\n  tool angle         φ = 0 along (1, 0, 0) of the platform; (-1, 0, 0) of the base at home\n")
    );
    for sign in ["", "-"] {
        let along_x =
            said(&kr270.replace("tool_axis = [0.0, 0.0, 1.0]", &format!("tool_axis = [{sign}1.0, 0.0, 0.0]")));
        let zero = "φ = 0 along (0, 1, 0) of the platform, its y axis, as the tool is along its x axis; (0, 1, 0) of the base at home\n";
        assert!(along_x.contains(zero), "{along_x}");
    }
    let tables = kr270.lines().enumerate().filter(|(_, line)| *line == "[[provenance]]");
    let whats = kr270.lines().filter_map(|line| line.strip_prefix("what = \"")?.strip_suffix('"'));
    for ((line, _), what) in tables.zip(whats) {
        let expected = format!(" {what} (line {})\n", line + 1);
        assert!(said(kr270).contains(&expected), "{expected}{}", said(kr270));
    }
}
