//! Golden tables of the studies, reduced.

use std::path::Path;

use crate::support::golden::{agree, check};
use kinetostat::{
    files::exchange::{Table, csv},
    questions::{
        Overrides, Study, StudyKind,
        map::{self, report::table},
        placement::{PlacementStudy, compare, report, run},
        superposition::{self, report as superposition_report},
        validation::{self, report::quoted_table},
    },
    work::Work,
};

/// What the convergence tolerance of the equilibria leaves open when rounding differs between machines.
const MAP_TOLERANCE: f64 = 1e-7;
/// The same, for numbers that corrections within limits enter.
const PLACEMENT_TOLERANCE: f64 = 1e-6;
/// The same, for superposition errors, which are a hundredth of the displacements, and for their parts, down to a millionth.
const SUPERPOSITION_ERROR_TOLERANCE: f64 = 1e-5;
const PART_TOLERANCE: f64 = 1e-3;

fn text(table: &Table) -> String {
    String::from_utf8(csv(table).unwrap()).unwrap()
}

fn open(name: &str, overrides: &Overrides) -> StudyKind {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies").join(name);
    Study::open(&folder, overrides).unwrap_or_else(|e| panic!("{e}")).kind
}

#[test]
fn workspace_map_is_the_golden_one() {
    let overrides = Overrides { grid: Some([2, 2, 2]), ..Overrides::default() };
    let StudyKind::WorkspaceMap(map, _) = open("01_workspace_map", &overrides) else { panic!("a workspace map") };
    let table = table(&map, &map::run(&map, &Work::default()).unwrap().points);
    check("01_workspace_map", &text(&table), MAP_TOLERANCE);
}

fn placement_study(name: &str, overrides: &Overrides) -> PlacementStudy {
    match open(name, overrides) {
        StudyKind::Placement(study, ()) => *study,
        other => panic!("{name} is not a placement study: {other:?}"),
    }
}

/// The ranked table of the named places. Where a refinement ends on flat ground depends on rounding, so those are not
/// in it.
fn ranked(study: &PlacementStudy) -> String {
    text(&report::candidates_table(study, &compare(study)))
}

/// The sweep of a study, without refinement worth the name.
fn swept(study: &PlacementStudy) -> String {
    let mut study = study.clone();
    (study.search.starts, study.search.max_iterations) = (1, 1);
    text(&report::sweep_table(&run(&study, &Work::default()).unwrap()))
}

#[test]
fn placement_of_the_circle_is_the_golden_one() {
    let study = placement_study(
        "03_placement_circle",
        &Overrides { grid: Some([3, 3, 2]), points: Some(37), ..Overrides::default() },
    );
    check("03_placement_circle_candidates", &ranked(&study), PLACEMENT_TOLERANCE);
    check("03_placement_circle_sweep", &swept(&study), PLACEMENT_TOLERANCE);
}

#[test]
fn placement_of_the_pocket_is_the_golden_one() {
    let study = placement_study("04_placement_pocket", &Overrides { grid: Some([2, 2, 1]), ..Overrides::default() });
    check("04_placement_pocket_candidates", &ranked(&study), PLACEMENT_TOLERANCE);
    check("04_placement_pocket_sweep", &swept(&study), PLACEMENT_TOLERANCE);
}

#[test]
fn the_numbers_of_the_paper_are_the_golden_ones() {
    let overrides = Overrides { points: Some(37), ..Overrides::default() };
    let StudyKind::Validation(study, _) = open("06_paper", &overrides) else { panic!("a validation study") };
    let table = quoted_table(&validation::run(&study, &Work::default()).unwrap());
    check("06_paper_summary", &text(&table), MAP_TOLERANCE);
}

#[test]
fn superposition_is_the_golden_one() {
    let overrides = Overrides { grid: Some([2, 2, 2]), ..Overrides::default() };
    let StudyKind::Superposition(mut study, _) = open("05_superposition", &overrides) else { panic!("superposition") };
    // A quarter of the tool angles, as tables are long.
    study.load_case.phis = study.load_case.phis.into_iter().step_by(4).collect();
    let results = superposition::run(&study, &Work::default()).unwrap();
    for (name, tolerance, table) in [
        ("map", SUPERPOSITION_ERROR_TOLERANCE, superposition_report::map_table(&results.points)),
        ("safe_load", SUPERPOSITION_ERROR_TOLERANCE, superposition_report::safe_load_table(&study, &results.points)),
        (
            "largest_factors",
            SUPERPOSITION_ERROR_TOLERANCE,
            superposition_report::largest_factors_table(&results.locations),
        ),
        ("slopes", SUPERPOSITION_ERROR_TOLERANCE, superposition_report::slopes_table(&results.locations)),
        ("ablation", PART_TOLERANCE, superposition_report::ablation_table(&results.locations)),
    ] {
        check(&format!("05_superposition_{name}"), &text(&table), tolerance);
    }
}

#[test]
fn a_changed_number_or_word_is_found() {
    let agree = |a, b, scale| agree(a, b, scale, 1e-7);
    assert!(agree("1.00000005", "1", 1.0) && !agree("1.0000002", "1", 1.0));
    assert!(agree("1e-17", "0", 1.0) && !agree("1e-12", "0", 1.0));
    assert!(agree("solved", "solved", 0.0) && !agree("", "1", 1.0) && !agree("solved", "unstable", 0.0));
}
