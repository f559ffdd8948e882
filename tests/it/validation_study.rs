//! Validation studies: quoted numbers beside ours.

use std::path::Path;

use kinetostat::{
    files::exchange::csv,
    input::error::Result,
    questions::{
        Overrides, Study, StudyKind,
        validation::{
            Quantity, Quoted, Relation, ValidationResults,
            circle_shape::{Shape, angle_deg, crossings},
            report::{differences, figures, page, quoted_table, short_number, variants_table},
            run,
        },
    },
    work::Work,
};
use nalgebra::Vector2;

const PAPER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/studies/06_paper");

fn study(toml: &str, folder: &Path, points: usize) -> Result<Study> {
    let overrides = Overrides { points: Some(points), ..Overrides::default() };
    Study::from_toml(toml, "study.toml", folder, &overrides)
}

fn results_of(toml: &str, folder: &Path, points: usize) -> Result<ValidationResults> {
    match study(toml, folder, points)?.kind {
        StudyKind::Validation(study, _) => Ok(run(&study, &Work::default()).unwrap()),
        other => panic!("not a validation study: {other:?}"),
    }
}

fn text() -> String {
    std::fs::read_to_string(format!("{PAPER}/study.toml")).unwrap()
}

fn paper(points: usize) -> ValidationResults {
    let toml = text();
    results_of(&toml, Path::new(PAPER), points).unwrap_or_else(|e| panic!("{e}"))
}

fn value(results: &ValidationResults, case: &str, quantity: Quantity, variant: &str) -> f64 {
    let study = &results.study;
    let variant = study.variants.iter().position(|v| v.name == variant).unwrap();
    let quoted = study.quoted.iter().position(|q| study.cases[q.case] == case && q.quantity == quantity).unwrap();
    *results.compared[quoted].ours[variant].as_ref().unwrap()
}

#[test]
fn every_quoted_number_agrees_or_has_a_reason() {
    let results = paper(37);
    for (quoted, compared) in results.study.quoted.iter().zip(&results.compared) {
        assert_eq!(compared.ours.len(), results.study.variants.len());
        assert!(compared.ours.iter().all(|ours| ours.as_ref().is_ok_and(|value| value.is_finite())), "{quoted:?}");
        assert!(compared.agrees || !quoted.reason.is_empty(), "{quoted:?} {compared:?}");
    }
    let agreeing = results.compared.iter().filter(|compared| compared.agrees).count();
    // With few points a largest value near the limit of agreement may fall on the other side.
    assert!((11..=12).contains(&agreeing) && results.compared.len() == 19, "{agreeing}");
    let StudyKind::Validation(_, shown) = study(&text(), Path::new(PAPER), 37).unwrap().kind else {
        panic!("validation")
    };
    let names: Vec<String> = figures(&results, &shown).into_iter().map(|(name, _)| name).collect();
    assert_eq!(names.len(), 11, "{names:?}");
}

#[test]
fn the_sign_of_the_superposition_error_follows_the_signs_of_the_errors() {
    let results = paper(37);
    let ratio = |variant| value(&results, "small circle at Q1", Quantity::SuperpositionRatio, variant);
    assert!(ratio("as printed") < 0.99 && ratio("errors reversed") > 1.01);
    let superposition_error = |variant| value(&results, "small circle at Q1", Quantity::SuperpositionError, variant);
    assert!((superposition_error("as printed") / superposition_error("errors reversed") - 1.0).abs() < 0.1);
}

#[test]
fn paths_1_and_3_cross_only_where_the_force_lies_along_the_path() {
    let results = paper(73);
    let crossings = |variant| value(&results, "small circle at Q1", Quantity::Crossings, variant);
    assert_eq!((crossings("as printed"), crossings("against the feed")), (0.0, 4.0));
}

#[test]
fn an_assumed_origin_and_what_differs_between_processes_are_said() {
    let folder = tempfile::tempdir().unwrap();
    let placed = "schema = 1\n[placement]\norigin_mm = [0.0, 0.0, 20.0]\n";
    for (name, text) in [("bare.toml", "schema = 1\n"), ("placed.toml", placed)] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let toml = "schema = 3\nquestion = \"q\"\nmachine = \"orthoglide\"\n\
                [[validation.variant]]\nname = \"today\"\nprocess = \"bare.toml\"\n\
                [[validation.variant]]\nname = \"raised\"\nprocess = \"placed.toml\"\n\
                [[validation.case]]\nname = \"c\"\n\
                circle = { centre_mm = [50.0, 50.0, 120.0], diameter_mm = 20.0, points = 5 }\n";
    let results = results_of(toml, folder.path(), 5).unwrap();
    let said: String = results.study.facts().iter().map(|(label, words)| format!("{label}: {words}.\n")).collect();
    let assumed =
        "workpiece: origin at (0, 0, 0) mm of the base, assumed: the process gives no placement.origin_mm; path";
    assert!(said.contains(assumed), "{said}");
    assert!(said.contains("workpiece, raised: origin at (0, 0, 20) mm of the base; path"), "{said}");
    assert_eq!(said.matches("ounts as cutting").count(), 1, "{said}");
    let page = serde_json::to_string(&page(&results, &differences(&results))).unwrap();
    assert!(page.contains("assumed: the process gives no placement.origin_mm"), "{page}");
}

/// The README of the study says so.
#[test]
fn drive_forces_hardly_depend_on_the_stiffness() {
    let folder = tempfile::tempdir().unwrap();
    let catalogue = kinetostat::machine::catalogue::find("orthoglide").unwrap().toml;
    let stiffer = catalogue.replace("= 70000.0", "= 700000.0").replace("= 27000.0", "= 270000.0");
    assert_ne!(stiffer, catalogue);
    let process = std::fs::read_to_string(format!("{PAPER}/process.toml")).unwrap();
    std::fs::write(folder.path().join("process.toml"), process).unwrap();
    let study = |machine: &str| {
        let toml = format!(
            "schema = 3\nquestion = \"q\"\nmachine = \"{machine}\"\n[[validation.variant]]\nname = \"v\"\n\
             process = \"process.toml\"\n[[validation.case]]\nname = \"Q1\"\n\
             circle = {{ centre_point = \"Q1\", diameter_mm = 50.0, points = 37 }}\n\
             [[validation.quoted]]\nsource = \"s\"\ncase = \"Q1\"\nquantity = \"drive_force\"\nvalue = 300.0\n\
             [[validation.quoted]]\nsource = \"s\"\ncase = \"Q1\"\nquantity = \"deflection_by_cutting\"\nvalue = 0.8\n"
        );
        let results = results_of(&toml, folder.path(), 37).unwrap_or_else(|e| panic!("{e}"));
        [Quantity::DriveForce, Quantity::DeflectionByCutting].map(|quantity| value(&results, "Q1", quantity, "v"))
    };
    let [force, deflection] = study("orthoglide");
    std::fs::write(folder.path().join("stiffer.toml"), stiffer).unwrap();
    let [stiff_force, stiff_deflection] = study("stiffer.toml");
    assert!(stiff_deflection < 0.11 * deflection, "{stiff_deflection} {deflection}");
    assert!((stiff_force / force - 1.0).abs() < 0.04, "{stiff_force} {force}");
}

#[test]
fn a_case_out_of_reach_is_a_reason_in_the_table() {
    let toml = std::fs::read_to_string(format!("{PAPER}/study.toml")).unwrap();
    let far = toml
        .replace("centre_point = \"Q2\"", "centre_mm = [500.0, 0.0, 0.0]")
        .replace("case = \"Q0\"\nquantity = \"correction\"", "case = \"Q2\"\nquantity = \"correction\"");
    let results = results_of(&far, Path::new(PAPER), 13).unwrap();
    let table = String::from_utf8(csv(&quoted_table(&results)).unwrap()).unwrap();
    let row = table.lines().find(|line| line.contains(",Q2,correction,")).unwrap();
    assert!(row.contains(",0.6,,,no,") && row.contains("cannot close there; continuation from home stops"), "{row}");
    let variants = String::from_utf8(csv(&variants_table(&results)).unwrap()).unwrap();
    assert!(variants.lines().any(|line| line.starts_with("Q2,") && line.contains(",not_solved,")), "{variants}");
}

#[test]
fn a_path_that_nothing_moves_has_no_ratios() {
    let folder = tempfile::tempdir().unwrap();
    let process = "schema = 1\n[placement]\nreference = \"platform_point\"\norigin_mm = [0.0, 0.0, 0.0]\n\
                   [force.path_frame]\nradial_force_N = 0.0\ntangential_force_N = 0.0\naxial_force_N = 0.0\n\
                   law = \"rotated\"\n";
    std::fs::write(folder.path().join("process.toml"), process).unwrap();
    let mut toml = "schema = 3\nquestion = \"q\"\nmachine = \"orthoglide\"\n[[validation.variant]]\nname = \"v\"\n\
                    process = \"process.toml\"\n[[validation.case]]\nname = \"c\"\n\
                    circle = { centre_point = \"Q1\", diameter_mm = 50.0, points = 13 }\n"
        .to_string();
    for quantity in ["superposition_ratio", "superposition_error", "cosine_of_centre_shifts", "axes_angle", "crossings"]
    {
        toml +=
            &format!("[[validation.quoted]]\nsource = \"s\"\ncase = \"c\"\nquantity = \"{quantity}\"\nvalue = 1.0\n");
    }
    let results = results_of(&toml, folder.path(), 13).unwrap();
    for (quoted, compared) in results.study.quoted.iter().zip(&results.compared) {
        assert!(compared.ours[0].is_err() && !compared.agrees, "{quoted:?} {compared:?}");
    }
    let table = String::from_utf8(csv(&variants_table(&results)).unwrap()).unwrap();
    assert!(table.contains("not_solved,both sources move nothing,") && !table.contains("NaN"), "{table}");
}

#[test]
fn numbers_agree_as_they_are_meant() {
    let quoted = |value, relation| Quoted {
        source: String::new(),
        case: 0,
        quantity: Quantity::Correction,
        value,
        relation,
        agreement: 0.1,
        reason: String::new(),
    };
    let about = quoted(2.0, Relation::About);
    assert!(about.agrees(2.19) && about.agrees(1.81) && !about.agrees(2.21));
    assert!(quoted(0.0, Relation::About).agrees(0.09) && !quoted(0.0, Relation::About).agrees(0.11));
    assert!(quoted(2.0, Relation::AtLeast).agrees(5.0) && !quoted(2.0, Relation::AtLeast).agrees(1.99));
    assert!(quoted(2.0, Relation::AtMost).agrees(-5.0) && !quoted(2.0, Relation::AtMost).agrees(2.01));
}

fn ellipse(a: f64, b: f64, turn: f64, middle: [f64; 2]) -> Vec<Vector2<f64>> {
    let (sin, cos) = turn.sin_cos();
    let at = |k: usize| {
        let (s, c) = (std::f64::consts::TAU * k as f64 / 72.0).sin_cos();
        Vector2::new(cos * a * c - sin * b * s, sin * a * c + cos * b * s) + Vector2::from(middle)
    };
    (0..=72).map(at).collect()
}

#[test]
fn the_axes_of_an_ellipse_are_found() {
    let shape = Shape::of(&ellipse(3.0, 1.0, 0.4, [5.0, -2.0])).unwrap();
    assert!((shape.centre - Vector2::new(5.0, -2.0)).norm() < 1e-12);
    assert!(angle_deg(&shape.longest, &Vector2::new(0.4f64.cos(), 0.4f64.sin())) < 1e-9);
    assert!((angle_deg(&shape.longest, &shape.shortest) - 90.0).abs() < 1e-9);
    assert!(!shape.is_round && Shape::of(&ellipse(2.0, 2.0, 0.4, [5.0, -2.0])).unwrap().is_round);
    assert!(Shape::of(&[]).is_none());
}

#[test]
fn crossings_of_an_ellipse_and_a_circle() {
    let path = ellipse(3.0, 1.0, 0.4, [0.0, 0.0]);
    assert_eq!(crossings(&path, &Vector2::zeros(), 2.0), 4);
    assert_eq!(crossings(&path, &Vector2::zeros(), 4.0), 0);
}

#[test]
fn our_numbers_are_short() {
    assert_eq!(short_number(415.274_876, 300.0), "415");
    assert_eq!(short_number(0.438_205, 0.35), "0.438");
    assert_eq!(short_number(5e-17, 0.0), "0");
    assert_eq!(short_number(-0.999_999, -1.0), "-1.00");
    assert_eq!(short_number(21_500.0, 21_500.0), "21500");
}
