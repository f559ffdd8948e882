//! Correction tables and real-time code where inputs are uncertain: what they leave on other machines, against closed forms and brute force.

use kinetostat::{
    Folder, Machine,
    compensation::{Session, Target, TaskPoint, simulate_drives},
    input::Inputs,
    process::{
        Process,
        uncertainty::{Draws, P95, Uncertainty, normal_quantile, quantile},
    },
    products::{
        correction::{
            CorrectionQuestion, Corrector, answer,
            report::{CorrectionExport, export},
        },
        field::FieldSpread,
        realtime::{Domain, Question, generate},
    },
    simulation::{Machines, settings},
    spatial::{Pose, Wrench},
    work::Work,
};
use nalgebra::Vector3;
use serde_json::Value;

use crate::support::{
    command::told,
    results::assert_same,
    uncertain::{Drawn, EXACT_MODEL, LEVER, TOLERANCES, draws, exact_machine},
};

const FORCE: &str = "[force.path_frame]\nradial_force_N = 215.0\ntangential_force_N = -10.0\naxial_force_N = -25.0\n";

fn varied(pattern: &str, std: f64) -> String {
    format!("[[uncertainty.parameter]]\nname = \"{pattern}\"\nrelative_std = {std}\n")
}

fn process(machine: &Machine, tables: &str) -> Process {
    Process::from_toml(
        &format!("schema = 1\n{}", exact_machine(tables)),
        "process.toml",
        Folder::in_memory([]),
        machine,
    )
    .unwrap()
}

/// A table that is exact with nominal numbers leaves the compliance times the force less the nominal one, each lognormal: all in closed form.
#[test]
fn a_table_of_a_lever_leaves_what_its_closed_form_says() {
    let machine = Machine::from_toml(LEVER, "lever.toml").unwrap();
    let tables = format!(
        "[force.path_frame]\nradial_force_N = 100.0\ntangential_force_N = 0.0\naxial_force_N = 0.0\n{}[uncertainty.process]\nforce_relative_std = 0.4\n{EXACT_MODEL}",
        varied("guide.slide.stiffness", 0.5)
    );
    let tolerance = 0.005;
    let asked = CorrectionQuestion::new(&process(&machine, &tables), None, None, tolerance, None).unwrap();
    let uncertainty = asked.uncertainty.as_ref().unwrap();
    let found = answer(&asked, &Work::default()).unwrap();
    assert!(found.with_table.error_mm < 1e-7, "{:?}", found.with_table);
    // The force is not only along x: what the prismatic joint does not feel is no larger.
    let most = found.without.error_mm;
    assert!((most - asked.largest_force_N * 1e-4).abs() < 1e-6, "{most}");
    let of_force = libm::log(uncertainty.force.sharp.unwrap().value(1.0, 1.0));
    let of_stiffness = libm::log(uncertainty.parameters[0].at(1.0).next().unwrap().1 / 1e4);
    let sigma = libm::hypot(of_force, of_stiffness);
    // Share of the draws in which force over stiffness is at most so many times the nominal one.
    let below = |ratio: f64| {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if sigma * normal_quantile(middle) < libm::log(ratio) { low = middle } else { high = middle }
        }
        low
    };
    let left = |size: f64| below(1.0 + size / most) - if size < most { below(1.0 - size / most) } else { 0.0 };
    let spread = found.spread.unwrap();
    let [plain, with_table] = [0, 1].map(|way| &spread.ways[way]);
    for (name, share, expected) in [
        ("P95 without", below(plain.largest.p95_mm.unwrap() / most), P95),
        ("median without", below(plain.largest.median_mm.unwrap() / most), 0.5),
        ("P95", left(with_table.largest.p95_mm.unwrap()), P95),
        ("median", left(with_table.largest.median_mm.unwrap()), 0.5),
        ("within", with_table.largest.within_tolerance.unwrap(), left(tolerance)),
        ("worse", with_table.worse, below(1.0 / 2.005)),
        ("better", with_table.better, 1.0 - below(1.005 / 2.005)),
    ] {
        // Sobol points are closer than independent ones.
        assert!((share - expected).abs() < 0.02, "{name}: {share}, not {expected}");
    }
    assert!(with_table.worse > 0.05 && with_table.worse < 0.3, "{}", with_table.worse);
    assert_eq!((with_table.largest.failed_draws, with_table.largest.solved_draws), (0, 256));
}

/// Sizes of the largest distances without correction and with it, in draws of another seed, solved one by one.
struct BruteForce([Vec<f64>; 2]);

impl BruteForce {
    /// Solves each of `cases`: task, configuration and drives of each way.
    fn new(
        machines: &Machines,
        uncertainty: &Uncertainty,
        errors: &[kinetostat::machine::ChainError],
        cases: &[(TaskPoint, kinetostat::machine::Configuration, [Vec<f64>; 2])],
        count: usize,
    ) -> Self {
        let mut all = [Vec::new(), Vec::new()];
        for Drawn { unloaded, actual, factor } in draws(uncertainty, errors, count) {
            let mut session = Session::new(&machines.nominal, &actual, settings()).with_unloaded_machine(&unloaded);
            let mut largest = [0.0f64; 2];
            for (task, at, drives) in cases {
                let task = TaskPoint { load: task.load.scale(factor), ..*task };
                for way in 0..2 {
                    session.set_rigid(at);
                    let found = simulate_drives(&mut session, &task, &drives[way]);
                    assert!(found.status.is_success(), "{:?}", found.status);
                    largest[way] = largest[way].max(found.position_error.norm());
                }
            }
            (0..2).for_each(|way| all[way].push(largest[way]));
        }
        Self(all)
    }

    /// Checks what was found against it; `short` is the share by which a few positions and directions may find less.
    fn check(&self, name: &str, spread: &FieldSpread, short: f64) {
        let count = self.0[0].len() as f64;
        for (way, sizes) in self.0.iter().enumerate() {
            let found = &spread.ways[way].largest;
            for (value, share) in [(found.p95_mm.unwrap(), P95), (found.median_mm.unwrap(), 0.5)] {
                let error = 3.0 * (share * (1.0 - share) * (1.0 / count + 1.0 / Draws::PER_SCRAMBLE as f64)).sqrt();
                let [low, high] =
                    [share - error, (share + error).min(0.999)].map(|share| quantile(&mut sizes.clone(), share));
                println!(
                    "{name} way {way} {share}: {value}, {} ({low} to {high})",
                    quantile(&mut sizes.clone(), share)
                );
                assert!((low * (1.0 - short)..=high).contains(&value), "{name} {way}: {value}, not {low} to {high}");
            }
        }
        let pairs = || self.0[0].iter().zip(&self.0[1]);
        let better = pairs().filter(|(plain, left)| **plain > 1.005 * **left).count() as f64 / count;
        assert!((spread.ways[1].better - better).abs() < 0.06, "{name}: {better}, {:?}", spread.ways[1]);
    }
}

/// Legs that pull against one another, and an arm with weight: at the corners and under forces in 26 directions.
#[test]
fn tables_agree_with_brute_force() {
    for (name, pattern, half_mm, count) in
        [("orthoglide", "leg.*.stiffness", 40.0, 256), ("fanuc_r2000ic", "arm.*.stiffness", 20.0, 256)]
    {
        let machine = Machine::named(name).unwrap();
        let centre = machine.home.pose.translation;
        let corners = [-half_mm, half_mm].map(|side| centre + Vector3::repeat(side));
        let tables = format!("{FORCE}{}{TOLERANCES}{EXACT_MODEL}", varied(pattern, 0.3));
        let process = process(&machine, &tables);
        let asked = CorrectionQuestion::new(&process, Some(corners), None, 1.0, Some([2; 3])).unwrap();
        let found = answer(&asked, &Work::default()).unwrap();
        let sides =
            || (0..27).map(|index| Vector3::new(index % 3, index / 3 % 3, index / 9).map(|own| own as f64 - 1.0));
        let mut cases = Vec::new();
        for side in sides().filter(|side| side.iter().all(|own| *own != 0.0)) {
            let position = centre + half_mm * side;
            let pose = Pose { rotation: asked.orientation, translation: position };
            let at = machine.inverse_kinematics(&pose).unwrap();
            for force in sides().filter_map(|side| Some(side.try_normalize(0.0)? * asked.largest_force_N)) {
                let moment = (at.pose.rotation * machine.tool_tip).cross(&force);
                let (load, target) = (Wrench { force, moment }, asked.target);
                let task = TaskPoint::new(at.pose, load, target);
                let correction = Corrector::Table(&found.table).correction(&at, position, force);
                let corrected = at.drives.iter().zip(&correction).map(|(nominal, own)| nominal + own).collect();
                cases.push((task, at.clone(), [at.drives.clone(), corrected]));
            }
        }
        let machines = Machines::new(&asked.machine, &asked.errors).unwrap();
        let uncertainty = asked.uncertainty.as_ref().unwrap();
        let expected = BruteForce::new(&machines, uncertainty, &asked.errors, &cases, count);
        let spread = found.spread.unwrap();
        expected.check(name, &spread, 0.03);
        assert!(spread.ways[1].largest.p95_mm.unwrap() > 5.0 * found.with_table.error_mm, "{name}");
        assert_eq!(spread.points.len(), 29, "{name}");
    }
}

/// The code at the corners of its box, under all corners of the forces.
#[test]
fn code_agrees_with_brute_force() {
    let nominal = Machine::named("orthoglide").unwrap();
    let errors = nominal.assembly_errors(&[1.0, -1.0, 1.0]);
    let tables = format!("{FORCE}{}{TOLERANCES}{EXACT_MODEL}", varied("leg.*.stiffness", 0.3));
    let uncertainty = process(&nominal, &tables).uncertainty.unwrap().of(&nominal, &errors).unwrap();
    let machines = Machines::new(&nominal, &errors).unwrap();
    let domain = Domain::new(Domain::workspace(&nominal), 250.0, 0.0).unwrap();
    let question = Question {
        machines: machines.clone(),
        errors: errors.clone(),
        domain,
        steps: 2,
        places: 64,
        uncertainty: Some(uncertainty.clone()),
        tolerance_mm: Some(0.5),
    };
    let made = generate(question).unwrap();
    let tip = nominal.home.pose.rotation * nominal.tool_tip;
    let signs = || (0..8).map(|corner: usize| [0, 1, 2].map(|axis| corner >> axis & 1 == 1));
    let mut cases = Vec::new();
    for corner in signs() {
        let position = [0, 1, 2].map(|axis| if corner[axis] { domain.high[axis] } else { domain.low[axis] });
        let pose = Pose { rotation: nominal.home.pose.rotation, translation: Vector3::from(position) - tip };
        let at = nominal.inverse_kinematics(&pose).unwrap();
        for sign in signs() {
            let force = Vector3::from(sign.map(|own| if own { 250.0 } else { -250.0 }));
            let load = Wrench { force, moment: tip.cross(&force) };
            let task = TaskPoint::new(at.pose, load, Target::ToolTip);
            let corrected = made.correct(&position, &[force.x, force.y, force.z, 0.0, 0.0, 0.0]).to_vec();
            cases.push((task, at.clone(), [at.drives.clone(), corrected]));
        }
    }
    let expected = BruteForce::new(&machines, &uncertainty, &errors, &cases, 512);
    expected.check("code", made.spread.as_ref().unwrap(), 0.0);
    assert!(made.field_text().unwrap()[0].contains("better than no correction with"));
}

/// A folder with a process file.
fn shop(tables: &str) -> (tempfile::TempDir, impl Fn(&str) -> String + use<>) {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path().to_path_buf();
    std::fs::write(root.join("process.toml"), format!("schema = 1\n{tables}")).unwrap();
    (folder, move |name: &str| root.join(name).to_str().unwrap().to_owned())
}

/// The words of both outputs, and the exit code.
fn said(arguments: &[&str]) -> (Option<i32>, String) {
    let (code, out, err) = told(arguments);
    (code, (out + &err).split_whitespace().collect::<Vec<_>>().join(" "))
}

#[test]
fn the_first_screen_of_a_table_says_what_it_leaves_on_machines_as_they_may_be() {
    let (_folder, at) = shop(&format!("{FORCE}{}{TOLERANCES}", varied("leg.*.stiffness", 0.3)));
    let (process, out) = (at("process.toml"), at("out"));
    let table = ["--box", "-20,20,-20,20,-20,20", "--tolerance", "0.05", "--grid", "2", "--no-figures"];
    let own = ["export-correction", "--machine", "orthoglide", "--process", &process, "--out", &out];
    let (code, words) = said(&[&own[..], &table, &["--verbose"]].concat());
    assert_eq!(code, Some(0), "{words}");
    for part in [
        "with a table of 2 × 2 × 2 points the tool of orthoglide stays within 0.05 mm with",
        "if all numbers were exact), anywhere in the box. It is better than no correction with",
        "The model itself is assumed to be wrong",
        "each of 256 draws is one machine and one factor of the force for the whole box",
    ] {
        assert!(words.contains(part), "{part}: {words}");
    }
    let read = |name: &str| std::fs::read_to_string(at(&format!("out/{name}"))).unwrap();
    for name in ["summary.json", "correction.json"] {
        let json: Value = serde_json::from_str(&read(name)).unwrap();
        let left = &json["uncertainty"]["field"]["ways"][1];
        assert!(left["largest"]["p95_mm"].as_f64().unwrap() > 0.02 && left["better"].is_f64(), "{name}: {left}");
        assert_eq!(json["uncertainty"]["draws"], 256);
    }
    assert!(
        read("field.csv")
            .starts_with("x_mm,y_mm,z_mm,correction,error_p95_mm,error_median_mm,within_tolerance_probability")
    );
    assert!(read("report.html").contains("What is left on machines as they may be?"));
    // What is not there, or not wanted, is refused with its key.
    let (_folder, at) = shop(&format!("{FORCE}{}", varied("arm.*.stiffness", 0.3)));
    let (process, out) = (at("process.toml"), at("out"));
    for command in ["export-correction", "export-realtime"] {
        let (code, words) = said(&[command, "--machine", "orthoglide", "--process", &process, "--out", &out]);
        assert!(code == Some(2) && words.contains("uncertainty.parameter[0].name"), "{command}: {words}");
        assert!(words.contains("arm.*.stiffness"), "{command}: {words}");
    }
}

#[test]
fn the_readme_of_code_says_what_it_leaves() {
    for (tables, is_there) in [(String::new(), false), (varied("leg.*.stiffness", 0.3), true)] {
        let (_folder, at) = shop(&format!("tolerance_mm = 0.4\n{tables}"));
        let (process, out) = (at("process.toml"), at("out"));
        let area = ["--box", "-20,-20,30,20,20,70", "--force-N", "100", "--moment-Nmm", "0"];
        let own = ["export-realtime", "--machine", "orthoglide", "--process", &process, "--out", &out];
        let (code, words) = said(&[&own[..], &area].concat());
        assert_eq!(code, Some(0), "{words}");
        let readme = std::fs::read_to_string(at("out/README.md")).unwrap();
        for text in [&words, &readme] {
            assert_eq!(text.contains("with kinetostat_correct the tool of orthoglide stays"), is_there, "{text}");
            assert_eq!(text.contains("than no correction with"), is_there, "{text}");
        }
        assert!(!readme.contains("FIELD"), "{readme}");
    }
}

#[test]
fn threads_leave_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let machine = Machine::named("orthoglide").unwrap();
    let process = process(&machine, &format!("{FORCE}{}{TOLERANCES}", varied("leg.*.stiffness", 0.3)));
    let corners = [-20.0, 20.0].map(Vector3::repeat);
    let asked = CorrectionQuestion::new(&process, Some(corners), None, 0.05, Some([2; 3])).unwrap();
    let options = CorrectionExport { formats: Vec::new(), figures: false, inputs: Inputs::default() };
    let at = |threads: usize| folder.path().join(threads.to_string());
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| export(&asked, &options, &at(threads), &Work::default()).unwrap());
    }
    assert_same(&at(2), &at(1), "threads");
}
