//! Rotation about the tool axis along a pocket on a slanted face, cut by the FANUC R-2000iC: a lattice of 10 000 points, 72 turns
//! and up to 8 branches on two threads, held against a minute and 1 GB.

use std::time::Instant;

use kinetostat::{
    machine::Machine,
    process::{CutPath, GammaChoice, Process, RedundancyObjective, RedundancySettings},
    redundancy::{FoundGamma, GammaProblem, PathCost, search_gamma},
    toolpath::polyline::Polyline,
    work::Work,
};

/// Seconds that this bench is held against.
const GOAL_S: f64 = 60.0;
const POINTS: usize = 10_000;

const PROCESS: &str = "schema = 1
[placement]
origin_mm = [1900.0, 0.0, 800.0]
pitch_deg = -35.0
[force.path_frame]
radial_force_N = 300.0
tangential_force_N = -200.0
axial_force_N = -150.0
";

const ROBOT: &str = include_str!("../crates/engine/src/machine/catalogue/fanuc_r2000ic.toml");

/// The machine of `toml`, which stands on all branches if its travel is not limited.
fn without_travel(toml: &str) -> String {
    let blocks = toml.split("[[provenance]]\n").filter(|block| !block.contains("arm.J1.travel"));
    let mut text = blocks.collect::<Vec<_>>().join("[[provenance]]\n");
    while let Some(from) = text.find(", travel_deg = [") {
        let length = text[from..].find(']').map_or(0, |end| end + 1);
        text.replace_range(from..from + length, "");
    }
    text
}

/// Lines back and forth over a face of 200 mm by as much as it takes, 1 mm from point to point.
fn zigzag(points: usize) -> String {
    let mut rows = String::from("x_mm,y_mm,z_mm,feed_mm_per_min\n");
    for k in 0..points {
        let (line, along) = (k / 200, (k % 200) as f64);
        let y = if line % 2 == 0 { along - 99.5 } else { 99.5 - along };
        rows += &format!("{},{y},0,1200\n", line as f64 * 2.0 - 50.0);
    }
    rows
}

fn show(name: &str, along: &PathCost) {
    let shown = |value: Option<f64>| value.map_or_else(|| "none".into(), |value| format!("{value:.4}"));
    println!(
        "  {name:<16} worst {} mm, mean {} mm, rms {} mm, {} of {} points",
        shown(along.worst_mm),
        shown(along.mean_mm),
        shown(along.rms_mm),
        along.solved,
        along.points
    );
}

/// Processor time of this process, s; 0 where it is not known.
fn processor_s() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = stat.rsplit(')').next().unwrap_or_default().split_whitespace();
    // Of the user and of the system, in hundredths of a second.
    fields.skip(11).take(2).filter_map(|ticks| ticks.parse::<f64>().ok()).sum::<f64>() / 100.0
}

fn main() {
    // Cargo passes harness options, and `cargo test --benches` only asks that the bench runs.
    let given = std::env::args().skip(1).find_map(|argument| argument.parse().ok());
    let is_test = !std::env::args().any(|argument| argument == "--bench");
    let points: usize = given.unwrap_or(if is_test { 30 } else { POINTS });
    let robot = Machine::named_or_file("fanuc_r2000ic").expect("built in");
    let free = Machine::from_toml(&without_travel(ROBOT), "fanuc_r2000ic").expect("a machine");
    for (name, machine) in [("R-2000iC", robot), ("the same, its travel not limited", free)] {
        println!("{name}");
        on_machine(&machine, points);
    }
    if let Ok(status) = std::fs::read_to_string("/proc/self/status") {
        let peak = status.lines().find(|line| line.starts_with("VmHWM")).unwrap_or_default();
        println!("{}", peak.trim());
    }
}

fn on_machine(machine: &Machine, points: usize) {
    let process = Process::from_toml(PROCESS, "process", std::path::PathBuf::new(), machine).expect("a process");
    let path: CutPath = Polyline::read(zigzag(points), "path.csv").expect("a path").toolpath().clone().into();
    let loads = process.loads(&path).expect("loads");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("threads");
    for objective in [RedundancyObjective::Rms, RedundancyObjective::Worst] {
        let turn = RedundancySettings { gamma: GammaChoice::Best, objective, ..RedundancySettings::default() };
        let asked = GammaProblem {
            machine: &process.machine,
            errors: &process.errors,
            placement: &process.placement,
            target: process.target,
            path: &path,
            loads: &loads,
            settings: &turn,
        };
        let (started, before) = (Instant::now(), processor_s());
        let found: FoundGamma = pool.install(|| search_gamma(asked, &Work::default())).expect("a machine that turns");
        let (by_clock, of_processor) = (started.elapsed().as_secs_f64(), processor_s() - before);
        println!(
            "{objective:?}, {points} points: {by_clock:.1} s by the clock, {of_processor:.1} s of processor time on two threads, \
             {:.2} of the goal of {GOAL_S:.0} s each",
            0.5 * of_processor / GOAL_S
        );
        match &found.on_lattice {
            Ok(found) => println!("  lattice: {:.4} mm at {} points", found.value_mm, found.points.len()),
            Err(dead_end) => println!("  lattice: {}", dead_end.reason()),
        }
        println!("  branches left out: {}", found.refused.len());
        show("as programmed", &found.as_programmed);
        for (name, turned) in [("best constant", &found.best_constant), ("best", &found.best)] {
            match turned {
                Ok(turned) => {
                    show(name, &turned.along);
                    let branch = turned.branch.map(|branch| branch.label());
                    println!(
                        "    turns {:.1?} deg, branch {branch:?}, {:?}",
                        turned.range_deg, turned.along.first_failure
                    );
                }
                Err(dead_end) => println!("  {name}: {}", dead_end.reason()),
            }
        }
    }
}
