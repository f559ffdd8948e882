//! Path studies: the groove of study 02, reduced, and a straight line.

use std::path::{Path, PathBuf};

use kinetostat::study::{
    Overrides, Source, Study, StudyKind, Work,
    path_study::{PathResults, run},
};

fn studies() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/02_groove_50mm")
}

fn results(study: Study) -> PathResults {
    let StudyKind::Path(path) = &study.kind else { panic!("a path study") };
    run(path, &Work::default()).unwrap()
}

fn largest_displacement(results: &PathResults, source: Source) -> f64 {
    let sizes = (0..results.study.stations.len()).map(|k| results.whole.displacement(source, k).unwrap().norm());
    sizes.fold(0.0, f64::max)
}

#[test]
fn groove_of_study_02_has_the_numbers_its_readme_quotes() {
    let overrides = Overrides { points: Some(73), ..Overrides::default() };
    let results = results(Study::open(&studies(), &overrides).unwrap());
    for (source, expected) in [(Source::Cutting, 0.95), (Source::Assembly, 1.05), (Source::Both, 1.76)] {
        let found = largest_displacement(&results, source);
        assert!((found - expected).abs() < 0.01, "{source:?}: {found}");
    }
    let both = &results.whole.sources[Source::Both as usize].compensated;
    let correction = both.iter().flat_map(|answer| answer.delta_rho()).fold(0.0f64, |most, d| most.max(d.abs()));
    assert!((correction - 1.71).abs() < 0.01, "{correction}");
    assert!(
        results.study.stations.iter().all(|station| station.phi_deg.is_some_and(|phi| (0.0..360.0).contains(&phi)))
    );
    for method in &results.methods {
        let compensates = !["none", "linear", "mirror", "mirror_3"].contains(&method.method.label().as_str());
        assert_eq!(method.summary.failed, 0, "{:?}", method.method);
        assert_eq!(method.summary.max_mm < 1.5e-9, compensates, "{:?}: {:?}", method.method, method.summary);
    }
}

#[test]
fn a_line_is_cut_with_the_heading_less_a_quarter_turn() {
    let toml = r#"
schema = 1
question = "q"
machine = "orthoglide"

[path]
process = "process.toml"
line = { start_mm = [0.0, 0.0, 0.0], end_mm = [0.0, 20.0, 0.0] }
methods = ["mirror_2", "direct"]
"#;
    let study = Study::from_toml(toml, "study.toml", &studies(), &Overrides::default()).unwrap();
    let results = results(study);
    assert_eq!(results.study.stations.len(), 21, "a point every millimetre");
    // Heading +y: φ = 0, the radial force points to +x.
    assert!(results.study.stations.iter().all(|station| station.phi_deg == Some(0.0)));
    assert!(results.study.demands.iter().all(|demand| (demand.load.force.x - 215.0).abs() < 1e-9));
    let labels: Vec<String> = results.methods.iter().map(|method| method.method.label()).collect();
    assert_eq!(labels, ["mirror_2", "direct"]);
    assert!(results.methods[1].summary.max_mm < 1e-9);
}
