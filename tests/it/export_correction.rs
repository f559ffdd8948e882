//! `kinetostat export-correction`: corrections as tables that a controller reads.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    process::Command,
    sync::LazyLock,
};

use kinetostat::{
    compensation::{Session, TaskPoint, simulate_drives},
    machine::Machine,
    process::{Process, cutting::CuttingLaw},
    products::correction::{CorrectionQuestion, CorrectionResult, CorrectionTable, Corrector, ForceTerms, answer},
    simulation::{Machines, Source},
    spatial::{Pose, Wrench},
    statics::State,
    work::Work,
};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde_json::Value;

use crate::support::command::told;

/// Most entries that LinuxCNC reads from a `COMP_FILE`.
const MAX_ENTRIES: usize = 256;

const FORCE: &str = "[force.path_frame]\nradial_force_N = 215.0\ntangential_force_N = -10.0\naxial_force_N = -25.0\n";
/// An offset of a drive, which a table for that drive alone takes.
const OFFSET: &str = "[[chain_error]]\nchain = \"x\"\ndrive_offsets_mm_or_deg = [0.3]\n";
const ERRORS: &str = "[[chain_error]]\nchain = \"x\"\nturn_about_drive_axis_deg = 1.0\n";

fn process(machine: &Machine, tables: &str) -> Process {
    let text = format!("schema = 1\n{tables}");
    Process::from_toml(&text, "process.toml", Path::new(""), machine).unwrap()
}

/// A question about a built-in machine in a cube about home.
fn question(
    name: &str,
    tables: &str,
    half_mm: f64,
    tolerance_mm: f64,
    counts: Option<[usize; 3]>,
) -> CorrectionQuestion {
    let machine = Machine::named(name).unwrap();
    let centre = machine.home.pose.translation;
    let corners = [-half_mm, half_mm].map(|side| centre + Vector3::repeat(side));
    CorrectionQuestion::new(&process(&machine, tables), Some(corners), None, tolerance_mm, counts).unwrap()
}

fn answered(question: &CorrectionQuestion) -> CorrectionResult {
    answer(question, &Work::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// How far the tool is from where it is wanted, by a session of the library alone.
fn residual_mm(
    question: &CorrectionQuestion,
    session: &mut Session,
    corrector: &Corrector<'_>,
    (position, force): (Vector3<f64>, Vector3<f64>),
) -> f64 {
    let machine = &question.machine;
    let pose = Pose { rotation: question.orientation, translation: position };
    let at = machine.inverse_kinematics(&pose).unwrap();
    session.set_state(&at, &State::rigid(machine, &at));
    let moment = (at.pose.rotation * machine.tool_tip).cross(&force);
    let task = TaskPoint::new(at.pose, Wrench { force, moment }, question.target);
    let correction = corrector.correction(&at, position, force);
    let drives: Vec<f64> = at.drives.iter().zip(&correction).map(|(nominal, own)| nominal + own).collect();
    let found = simulate_drives(session, &task, &drives);
    assert!(found.status.is_success(), "{position} {force}: {:?}", found.status);
    found.task_error()
}

/// The largest error at `count` random positions and forces, drawn evenly.
fn largest_at_random(question: &CorrectionQuestion, corrector: &Corrector<'_>, count: usize, seed: u64) -> f64 {
    let machines = Machines::new(&question.machine, &question.errors).unwrap();
    let threads = 2;
    let part = |thread: u64| {
        let mut session = machines.session(Source::All);
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed + thread);
        let mut largest = 0.0f64;
        for _ in 0..count / threads {
            let [min, max] = question.corners;
            let share = Vector3::from_fn(|_, _| random.random::<f64>());
            let force = loop {
                let force = Vector3::from_fn(|_, _| 2.0 * random.random::<f64>() - 1.0);
                if force.norm() <= 1.0 {
                    break force * question.largest_force_N;
                }
            };
            let case = (min + (max - min).component_mul(&share), force);
            largest = largest.max(residual_mm(question, &mut session, corrector, case));
        }
        largest
    };
    std::thread::scope(|scope| {
        let all: Vec<_> = (0..threads as u64).map(|thread| scope.spawn(move || part(thread))).collect();
        all.into_iter().map(|own| own.join().unwrap()).fold(0.0, f64::max)
    })
}

/// A table for the Orthoglide, found once.
fn orthoglide() -> &'static (CorrectionQuestion, CorrectionResult) {
    static FOUND: LazyLock<(CorrectionQuestion, CorrectionResult)> = LazyLock::new(|| {
        let asked = question("orthoglide", &format!("{FORCE}{ERRORS}"), 40.0, TOLERANCE_MM, None);
        let found = answered(&asked);
        (asked, found)
    });
    &FOUND
}

const TOLERANCE_MM: f64 = 0.02;

/// 50 000 positions and forces, drawn evenly.
fn is_not_exceeded(seed: u64) {
    let (asked, found) = orthoglide();
    let bound = found.with_table.error_mm;
    assert!(bound <= TOLERANCE_MM);
    let largest = largest_at_random(asked, &Corrector::Table(&found.table), 50_000, seed);
    // And it is no bound that is far away.
    assert!((0.5 * bound..=bound).contains(&largest), "{largest} {:?}", found.with_table);
}

#[test]
fn no_random_position_and_force_exceeds_the_bound() {
    is_not_exceeded(7);
}

#[test]
fn nor_do_others() {
    is_not_exceeded(1007);
}

#[test]
fn one_node_less_along_any_axis_breaks_the_tolerance() {
    let (asked, found) = orthoglide();
    let counts = found.table.grid.counts();
    assert!(counts.iter().any(|&count| count > 2), "{counts:?}");
    let machines = Machines::new(&asked.machine, &asked.errors).unwrap();
    for axis in (0..3).filter(|&axis| counts[axis] > 2) {
        let mut fewer = counts;
        fewer[axis] -= 1;
        let fixed = CorrectionQuestion { counts: Some(fewer), ..asked.clone() };
        let CorrectionResult { with_table: worst, table, .. } = answered(&fixed);
        // Looked at once more, by a session of the library alone.
        let case = (Vector3::from(worst.position_mm), Vector3::from(worst.force_N));
        let left = residual_mm(asked, &mut machines.session(Source::All), &Corrector::Table(&table), case);
        assert!(
            left > TOLERANCE_MM && (left - worst.error_mm).abs() < 1e-9,
            "{fewer:?} of {counts:?}: {left} {worst:?}"
        );
    }
}

#[test]
fn a_perfect_machine_without_load_has_a_table_of_zeros() {
    let found = answered(&question("orthoglide", "", 40.0, 0.005, None));
    assert_eq!(found.table.grid.counts(), [2; 3]);
    assert_eq!(found.table.terms, ForceTerms::Constant);
    assert!(found.table.values.iter().all(|value| value.abs() < 1e-9), "{:?}", found.table.values);
    assert!(found.without.error_mm < 1e-9);
}

#[test]
fn machines_of_all_kinds_have_tables_that_are_exact_at_their_nodes() {
    for (name, half_mm, counts) in [
        ("tripteron", 20.0, [2; 3]),
        ("delta_3puu", 10.0, [2; 3]),
        ("rotary_delta", 10.0, [2; 3]),
        ("hexapod", 10.0, [2; 3]),
        ("fanuc_r2000ic", 10.0, [2; 3]),
        ("delta_3prpar", 10.0, [2; 3]),
    ] {
        let asked = question(name, FORCE, half_mm, 100.0, Some(counts));
        let found = answered(&asked);
        let machines = Machines::new(&asked.machine, &asked.errors).unwrap();
        let mut session = machines.session(Source::All);
        for node in 0..found.table.grid.len() {
            let case = (found.table.grid.position(node), Vector3::zeros());
            let left = residual_mm(&asked, &mut session, &Corrector::Table(&found.table), case);
            assert!(left < 1e-6, "{name}: {left}");
        }
        assert!(found.with_table.error_mm < found.without.error_mm, "{name}: {found:?}");
        // Each joint is an axis where the rails stand along the axes.
        let is_axis = ["tripteron", "delta_3puu", "delta_3prpar"].contains(&name);
        assert_eq!(found.per_joint.is_ok(), is_axis, "{name}: {:?}", found.per_joint.err());
    }
}

#[test]
fn coordinates_that_are_not_controlled_stay_where_they_are() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/machines/fivebar.toml");
    let machine = Machine::from_file(&file).unwrap();
    let fixed: Vec<usize> = machine.uncontrolled_axes().collect();
    assert_eq!(fixed.len(), 1);
    let centre = machine.home.pose.translation;
    let corners = [-5.0, 5.0].map(|side| centre + Vector3::repeat(side));
    let asked = CorrectionQuestion::new(&process(&machine, FORCE), Some(corners), None, 1.0, Some([3; 3])).unwrap();
    let found = answered(&asked);
    assert_eq!(found.table.grid.len(), 9);
    assert_eq!(found.table.grid.axes[fixed[0]], [centre[fixed[0]]]);
    assert!(found.with_table.error_mm <= 1.0, "{:?}", found.with_table);
    let beside = corners.map(|corner| corner + Vector3::ith(fixed[0], 50.0));
    let refused = CorrectionQuestion::new(&process(&machine, FORCE), Some(beside), None, 1.0, None).unwrap_err();
    assert!(refused.to_string().contains("the drives do not control"), "{refused}");
}

#[test]
fn a_table_for_each_joint_takes_what_depends_on_it_alone() {
    // An offset of a drive is its own; that its rail is askew shows with where the others stand.
    let errors =
        "[[chain_error]]\nchain = \"x\"\ndrive_offsets_mm_or_deg = [0.3]\nbase_rotation_deg = [0.05, 0.1, 0.0]\n";
    let asked = question("tripteron", errors, 100.0, 0.05, None);
    let found = answered(&asked);
    let (tables, worst) = found.per_joint.unwrap();
    assert!(worst.error_mm < found.without.error_mm, "{worst:?} {:?}", found.without);
    assert!(worst.error_mm > found.with_table.error_mm, "{worst:?} {:?}", found.with_table);
    for table in &tables {
        assert!(table.positions_mm.len() <= MAX_ENTRIES);
        assert!(table.positions_mm.windows(2).all(|pair| pair[0] < pair[1]));
        let (at, correction) = (table.positions_mm[3], table.corrections_mm[3]);
        assert_eq!(table.correction(at), correction);
        assert_eq!(table.correction(table.positions_mm[0] - 1e3), table.corrections_mm[0]);
    }
}

/// A folder with a process file, and the arguments of a small export.
struct Shop {
    folder: tempfile::TempDir,
}

impl Shop {
    fn new(tables: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("process.toml"), format!("schema = 1\n{tables}")).unwrap();
        Self { folder }
    }

    fn out(&self) -> PathBuf {
        self.folder.path().join("out")
    }

    fn arguments(&self, machine: &str, more: &[&str]) -> Vec<String> {
        let process = self.folder.path().join("process.toml").display().to_string();
        let out = self.out().display().to_string();
        let mut all: Vec<String> =
            ["export-correction", "--machine", machine, "--process", &process, "--out", &out].map(String::from).into();
        all.extend(more.iter().map(|word| word.to_string()));
        all
    }

    fn told(&self, machine: &str, more: &[&str]) -> (Option<i32>, String, String) {
        let all = self.arguments(machine, more);
        told(&all.iter().map(String::as_str).collect::<Vec<_>>())
    }

    fn refused(&self, machine: &str, more: &[&str], message: &str) {
        let (code, _, error) = self.told(machine, more);
        let error = error.split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(code, Some(2), "{more:?}: {error}");
        assert!(error.contains(message), "{more:?}: {error}");
    }

    fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.out().join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }
}

const SMALL: &[&str] = &["--box", "480,520,480,520,490,510", "--tolerance", "0.05", "--no-figures"];

#[test]
fn all_formats_hold_the_same_numbers() {
    let shop = Shop::new(&format!("{FORCE}{OFFSET}"));
    let (code, text, error) = shop.told("tripteron", SMALL);
    assert_eq!(code, Some(0), "{text}{error}");
    assert!(text.contains("With a table of"), "{text}");
    let json: Value = serde_json::from_str(&shop.read("correction.json")).unwrap();
    let numbers =
        |value: &Value| -> Vec<f64> { value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect() };
    let values = numbers(&json["values"]);
    let mut reader = csv::Reader::from_path(shop.out().join("correction.csv")).unwrap();
    let header: Vec<String> = reader.headers().unwrap().iter().map(String::from).collect();
    assert_eq!(header[..3], ["x_mm", "y_mm", "z_mm"]);
    assert_eq!(
        header[3..].iter().map(|name| Value::from(name.as_str())).collect::<Vec<_>>(),
        *json["columns"].as_array().unwrap()
    );
    assert!(header.contains(&"delta_rho_x_Fx_mm_per_N".to_string()), "{header:?}");
    let rows: Vec<Vec<f64>> =
        reader.records().map(|row| row.unwrap().iter().map(|cell| cell.parse().unwrap()).collect()).collect();
    let from_csv: Vec<f64> = rows.iter().flat_map(|row| row[3..].to_vec()).collect();
    assert_eq!(from_csv, values);
    let axes: Vec<Vec<f64>> = (0..3).map(|axis| numbers(&json["axes"][axis]["nodes"])).collect();
    assert_eq!(rows.len(), axes.iter().map(Vec::len).product::<usize>());
    assert_eq!(rows[1][..3], [axes[0][1], axes[1][0], axes[2][0]]);
    // What is read back corrects as the table of the library does, within the bound that stands beside it.
    let machine = Machine::named("tripteron").unwrap();
    let asked = CorrectionQuestion::new(
        &process(&machine, &format!("{FORCE}{OFFSET}")),
        Some([[480.0, 480.0, 490.0].into(), [520.0, 520.0, 510.0].into()]),
        None,
        0.05,
        None,
    )
    .unwrap();
    let terms = serde_json::from_value(Value::from(match json["terms"].as_array().unwrap().len() {
        4 => "linear",
        _ => "quadratic",
    }));
    let found = answered(&asked);
    let read = CorrectionTable { terms: terms.unwrap(), values, ..found.table.clone() };
    assert_eq!(read, found.table);
    assert_eq!(json["bound"]["worst_with_table"]["error_mm"], found.with_table.error_mm);
    // LinuxCNC's files: ascending triplets and nothing else, the trim is what is added.
    let (tables, _) = found.per_joint.unwrap();
    for table in &tables {
        let text = shop.read(&format!("joint_{}.comp", table.drive));
        let lines: Vec<Vec<f64>> =
            text.lines().map(|line| line.split(' ').map(|word| word.parse().unwrap()).collect()).collect();
        assert!(lines.len() <= MAX_ENTRIES && lines.len() == table.positions_mm.len());
        for (line, (position, correction)) in lines.iter().zip(table.positions_mm.iter().zip(&table.corrections_mm)) {
            assert!((line[0] - position).abs() < 1e-6 && (line[1] - correction).abs() < 1e-6);
            assert_eq!(line[1], line[2]);
        }
    }
    let page = shop.read("report.html");
    assert!(page.contains("COMP_FILE_TYPE = 1") && page.contains("Where is the residual error?"));
    // Residuals: exact corrections leave nothing, the table keeps the tolerance.
    let mut most: BTreeMap<String, f64> = BTreeMap::new();
    for row in csv::Reader::from_path(shop.out().join("residual.csv")).unwrap().records() {
        let row = row.unwrap();
        let most = most.entry(row[3].to_string()).or_default();
        *most = most.max(row[4].parse().unwrap());
    }
    assert!(most["exact"] < 1e-6 && most["table"] <= 0.05 && most["none"] > 0.05, "{most:?}");
}

#[test]
fn threads_change_no_byte() {
    let folders = ["1", "4"].map(|threads| {
        let shop = Shop::new(&format!("{FORCE}{OFFSET}"));
        let arguments = shop.arguments("tripteron", SMALL);
        let mut command = Command::new(env!("CARGO_BIN_EXE_kinetostat"));
        let output = command.args(arguments).env("RAYON_NUM_THREADS", threads).output().unwrap();
        assert!(output.status.success());
        let files = std::fs::read_dir(shop.out()).unwrap().map(|entry| entry.unwrap().path());
        let read = |path: PathBuf| (path.file_name().unwrap().to_owned(), std::fs::read(&path).unwrap());
        files.map(read).collect::<BTreeMap<_, _>>()
    });
    assert!(folders[0].len() > 8);
    assert!(folders[0] == folders[1]);
}

#[test]
fn a_given_grid_that_is_too_coarse_is_told() {
    let shop = Shop::new(FORCE);
    let more = ["--box", "-60,60,-60,60,-60,60", "--grid", "2", "--no-figures", "--format", "json"];
    let (code, text, error) = shop.told("orthoglide", &more);
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert_eq!(code, Some(1), "{text}{error}");
    assert!(text.contains("more than the 0.005 mm asked for"), "{text}");
    assert!(text.contains("The table is out of tolerance (0.005 mm)."), "{text}");
    assert!(shop.out().join("correction.json").exists() && !shop.out().join("correction.csv").exists());
    assert!(!shop.out().join("joint_x.comp").exists());
}

#[test]
fn bad_input_is_refused_in_words() {
    let shop = Shop::new(FORCE);
    for value in ["0", "-1", "nan"] {
        shop.refused("orthoglide", &["--tolerance", value], "--tolerance");
    }
    shop.refused("orthoglide", &["--tolerance", "0"], "must be greater than 0, got 0.0");
    shop.refused("orthoglide", &["--force-N", "-5"], "must be at least 0, got -5");
    shop.refused("orthoglide", &["--format", "xml"], "invalid value 'xml'");
    shop.refused("orthoglide", &["--grid", "1,4,4"], "--grid: nodes along x must be at least 2, got 1");
    shop.refused("orthoglide", &["--grid", "100"], "--grid: at most 40000 nodes, got [100, 100, 100]");
    shop.refused("orthoglide", &["--box", "9,3,0,1,0,1"], "--box: must begin below its end, got 9 to 3 mm along x");
    let far = ["--box", "0,2000,0,10,0,10", "--grid", "2"];
    shop.refused("orthoglide", &far, "--box: there is no correction for P at (");
    shop.refused("orthoglide", &far, "a table has no holes: expected a smaller box");
    let fine = ["--box", "-60,60,-60,60,-60,60", "--tolerance", "1e-7"];
    shop.refused("orthoglide", &fine, "--tolerance: no table of at most 40000 nodes stays within");
    let delta = ["--box", "-5,5,-5,5,-905,-900", "--grid", "2", "--format", "comp", "--tolerance", "9"];
    shop.refused("rotary_delta", &delta, "comp: a table for each drive over its own position would mean nothing");
    assert!(!shop.out().exists(), "a refusal leaves no folder behind");
    let by_path = Shop::new("[force]\nfrom_path = true\n");
    by_path.refused("orthoglide", &[], "--force-N: the force of this process is known only along a path");
}

#[test]
fn tables_for_joints_that_do_harm_are_written_only_if_asked_for_and_that_is_said_first() {
    let errors = [("x", 1.0), ("y", -1.0), ("z", 1.0)]
        .map(|(chain, turn)| format!("[[chain_error]]\nchain = \"{chain}\"\nturn_about_drive_axis_deg = {turn:?}\n"));
    let shop = Shop::new(&format!("{FORCE}{}", errors.concat()));
    let small = ["--box", "-50,50,-50,50,-40,40", "--grid", "3,3,2", "--tolerance", "0.05", "--no-figures"];
    let (code, text, _) = shop.told("orthoglide", &small);
    assert!(
        code == Some(0)
            && text.starts_with("✓ Within tolerance with the table [nominal inputs]\nTool off by up to ")
            && text.contains("  With a table of 3 × 3 × 2 points"),
        "{text}"
    );
    assert!(!shop.out().join("joint_x.comp").exists());
    let (code, text, _) = shop.told("orthoglide", &[&small[..], &["--format", "comp"]].concat());
    assert!(
        code == Some(0)
            && text.starts_with("✗ Do not use tables for single joints [nominal inputs]\n")
            && text.contains("\n  Do not use the tables for single joints"),
        "{text}"
    );
    assert!(shop.out().join("joint_x.comp").exists() && !shop.out().join("correction.csv").exists());
}

#[test]
fn files_of_others_stay() {
    let shop = Shop::new(FORCE);
    std::fs::create_dir(shop.out()).unwrap();
    std::fs::write(shop.out().join("correction.csv"), "mine").unwrap();
    shop.refused("tripteron", SMALL, "correction.csv: cannot be written: was not written by kinetostat");
    assert_eq!(shop.read("correction.csv"), "mine");
}

#[test]
fn the_force_of_a_process_is_its_largest_over_a_turn() {
    let machine = Machine::named("tripteron").unwrap();
    for law in ["paper_eq17", "rotated"] {
        let process = process(&machine, &format!("{FORCE}law = \"{law}\"\n"));
        let CuttingLaw::PathFrame(frame) = &process.cutting else { panic!("a path frame") };
        let over_a_turn = (0..3600).map(|tenth| frame.force.force(f64::from(tenth).to_radians() / 10.0).norm());
        let asked = CorrectionQuestion::new(&process, None, None, 0.1, None).unwrap();
        assert!((asked.largest_force_N - over_a_turn.fold(0.0, f64::max)).abs() < 1e-9, "{law}");
        assert_eq!(CorrectionQuestion::new(&process, None, Some(50.0), 0.1, None).unwrap().largest_force_N, 50.0);
    }
}
