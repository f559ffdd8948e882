//! What written programs ask of a control: how many blocks they have, and that they do not step back at corners.

use crate::support::programs::programs_in;
use kinetostat::{
    compensation::Method,
    input::Folder,
    machine::Machine,
    process::{Process, file::WRITE_TOLERANCE_MM},
    products::program::{CorrectedPath, Part, ProgramAsWritten, ProgramJob, WrittenCalls, report},
    toolpath::{
        blocks::{Blocks, BlocksBeforeAfter, Percentiles},
        gcode::GcodeProgram,
    },
    work::Work,
};
use nalgebra::Vector6;

const ORTHOGLIDE: &str = include_str!("../../crates/engine/src/machine/catalogue/orthoglide.toml");

/// An Orthoglide of 30 times the size, on which every program finds room.
fn large() -> Machine {
    let mut text = ORTHOGLIDE.replace("stiffness_N_per_mm = 1e6", "stiffness_N_per_mm = 3e7");
    for length in [73.65, 126.35, 341.0, 165.0, 26.0, 20.0, 310.0, 80.0, 12.0, 31.0, 100.0] {
        text = text.replace(&format!(" {length:?}"), &format!(" {:?}", 30.0 * length));
        text = text.replace(&format!("-{length:?}"), &format!("-{:?}", 30.0 * length));
        text = text.replace(&format!("[{length:?}"), &format!("[{:?}", 30.0 * length));
    }
    Machine::from_toml(&text, "large.toml").unwrap()
}

fn job(machine: &Machine, process: &str, program: &[u8], name: &str) -> ProgramJob {
    let process = Process::from_toml(&format!("schema = 1\n{process}"), "process", Folder::in_memory([]), machine)
        .unwrap_or_else(|error| panic!("{error}"));
    let folder = Folder::in_memory([(name.into(), program.to_vec())]);
    let file = process.program_in_folder(&folder, name).unwrap();
    ProgramJob::new(process, file, name, &Work::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn force(times: f64) -> String {
    let [radial, tangential, axial] = [215.0, -10.0, -25.0].map(|force: f64| force * times);
    format!(
        "[force.path_frame]\nradial_force_N = {radial:?}\ntangential_force_N = {tangential:?}\naxial_force_N = {axial:?}\n"
    )
}

fn written(job: &ProgramJob) -> (ProgramAsWritten, BlocksBeforeAfter) {
    let mut corrected = CorrectedPath::new(job);
    let take = |part: &Part<'_>, answers: &[_]| {
        corrected.add(job, part, answers);
        Ok(())
    };
    job.pass_by(Method::Direct, &|| (), take).unwrap();
    assert_eq!(corrected.failures, []);
    let written = job.write(&corrected).unwrap();
    let blocks = written.blocks.clone().unwrap();
    (written, blocks)
}

fn program(name: &str) -> Vec<u8> {
    programs_in("tests/programs").into_iter().find(|(own, _)| own == name).unwrap().1
}

const OFFSETS: &str = "[gcode]\nunit = \"mm\"\ng55_mm = [100.0, -20.0, 3.5]\ng56_mm = [0.0, 0.0, 0.0]\noffsets_mm = { \"G59.1\" = \
                       [80.0, 1.0, 0.0], \"G54.1 P7\" = [-5.0, 0.0, 0.25], \"G15 H3\" = [40.0, 0.0, 0.0] }\n";

#[test]
fn written_programs_are_hardly_longer() {
    let machine = large();
    let growth = |name: &str, source: &[u8], tolerance_mm: f64| {
        let process = format!(
            "[placement]\norigin_mm = [900.0, 900.0, 900.0]\n{}{OFFSETS}write_tolerance_mm = {tolerance_mm:?}\n{}",
            force(30.0),
            // Whose G10 L20 it is does not show.
            if name == "offsets_g10.nc" { "dialect = \"linuxcnc\"\n" } else { "" }
        );
        let (written, blocks) = written(&job(&machine, &process, source, name));
        // Decimals of a tenth of an inch step by more than the tolerance.
        assert!(written.rounded_mm <= tolerance_mm.max(3f64.sqrt() * 0.0254 * 0.1), "{name} {}", written.rounded_mm);
        blocks.after.lines as f64 / blocks.before.lines as f64
    };
    let mut all: Vec<(f64, String)> = Vec::new();
    // Of the pen's E nobody says how it is shared among the lines that one becomes.
    for (name, source) in
        programs_in("crates/programs/tests/gcode").into_iter().filter(|(name, _)| name != "pen_plotter.gcode")
    {
        let grown = growth(&name, &source, WRITE_TOLERANCE_MM);
        // It is the tolerance that asks for more.
        assert!(grown <= 4.0 || growth(&name, &source, 10.0 * WRITE_TOLERANCE_MM) <= 4.0, "{name} {grown}");
        all.push((grown, name));
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Programs of few lines, of which most have a corner behind which the force turns: two lines for one.
    assert!(all.len() >= 30 && all[all.len() / 2].0 < 1.5, "{all:?}");
}

/// Steps of a written program along the directions of the program's own blocks, of which each is one, mm: the shortest.
fn shortest_step(program: &[u8], written: &ProgramAsWritten) -> f64 {
    let ends = |bytes: &[u8]| {
        let program = GcodeProgram::parse(bytes, "steps.nc", &Default::default()).unwrap();
        let path = program.toolpath(kinetostat::toolpath::Sampling::new(1.0, 1e4).unwrap()).unwrap();
        path.points().to_vec()
    };
    let (before, after) = (ends(program), ends(&written.bytes));
    // The plunge may be more blocks than it was: counted from the end.
    let pairs = before.windows(2).rev().zip(after.windows(2).rev());
    let steps = pairs.filter(|(before, _)| before[1].cutting && before[0].cutting && before[1].tangent.z == 0.0);
    let steps = steps.map(|(before, after)| (after[1].position_mm - after[0].position_mm).dot(&before[1].tangent));
    steps.fold(f64::INFINITY, f64::min)
}

#[test]
fn behind_a_corner_of_a_polyline_the_force_lies_between_those_before_and_after() {
    let machine = Machine::named("orthoglide").unwrap();
    // Rows there and back, half a millimetre apart, so that corners lie closer than the force takes to turn.
    let rows = (0..120).map(|k| {
        let (row, at) = (k / 20, k % 20);
        let x = if row % 2 == 0 { at } else { 19 - at };
        format!("{},{},0,600\n", 0.5 * f64::from(x), 0.5 * f64::from(row))
    });
    let path = String::from("x_mm,y_mm,z_mm,feed_mm_per_min\n") + &rows.collect::<String>();
    let job = job(&machine, &force(1.0), path.as_bytes(), "path.csv");
    let whole = nalgebra::Vector3::new(215.0, -10.0, -25.0).norm();
    let sizes: Vec<f64> = job
        .parts()
        .flat_map(|part| part.unwrap().tasks().iter().map(|task| task.load.force.norm()).collect::<Vec<_>>())
        .collect();
    assert!(sizes.iter().all(|size| *size <= whole * (1.0 + 1e-9)), "{sizes:?}");
    assert!(sizes.iter().any(|size| *size < 0.8 * whole), "{sizes:?}");
}

#[test]
fn a_square_of_small_steps_is_never_stepped_back_on() {
    let machine = Machine::named("orthoglide").unwrap();
    let source = program("square_steps.nc");
    let of = |corner: &str| {
        let process = format!("[placement]\norigin_mm = [50.0, 40.0, 60.0]\n{}{corner}", force(1.0));
        let job = job(&machine, &process, &source, "square_steps.nc");
        let (written, blocks) = written(&job);
        (shortest_step(&source, &written), blocks)
    };
    let (step, blocks) = of("");
    assert!(step > 0.03, "{step}");
    let growth = blocks.after.lines as f64 / blocks.before.lines as f64;
    assert!(growth < 1.1, "{blocks:?}");
    let (rate, most) = (blocks.after.per_second.unwrap(), blocks.before.per_second.unwrap().max);
    assert!(rate.p95 < 1.5 * most, "{blocks:?}");
    // Where the force turns at once, the program goes back in the block behind a corner.
    let (at_once, blocks) = of("[compensate]\ncorner_mm = 0.0\n");
    assert!(at_once < -0.1, "{at_once} {blocks:?}");
}

#[test]
fn an_engraving_turns_as_it_did() {
    let machine = Machine::named("orthoglide").unwrap();
    let source = program("engraving.nc");
    let of = |corner: &str| -> (Blocks, Blocks) {
        let process = format!("[placement]\norigin_mm = [50.0, 40.0, 60.0]\n{}{corner}", force(1.0));
        let (_, blocks) = written(&job(&machine, &process, &source, "engraving.nc"));
        (blocks.before, blocks.after)
    };
    let (before, after) = of("");
    assert!(after.lines as f64 / (before.lines as f64) < 1.1, "{after:?}");
    let p95 = |blocks: &Blocks| [blocks.turns_deg.unwrap().p95, blocks.per_second.unwrap().p95];
    assert!(p95(&after)[0] < 4.0 * p95(&before)[0] && p95(&after)[1] < 2.0 * p95(&before)[1], "{after:?} {before:?}");
    let (_, at_once) = of("[compensate]\ncorner_mm = 0.0\n");
    assert!(p95(&at_once)[0] > 2.0 * p95(&after)[0], "{at_once:?} {after:?}");
}

/// Wrenches along an L and back on its second leg, point by point, with the length of the path up to each.
fn wrenches(corner: &str) -> Vec<(f64, Vector6<f64>)> {
    let machine = Machine::named("orthoglide").unwrap();
    let program = b"G21 G90\nG0 X0 Y0 Z0\nG1 X10 F100\nY10\nY0\n";
    let job = job(&machine, &format!("{}[compensate]\n{corner}", force(1.0)), program, "corner.nc");
    let mut wrenches = Vec::new();
    for part in job.parts() {
        let part = part.unwrap();
        let points = part.points.iter().zip(part.tasks());
        wrenches.extend(points.map(|(point, task)| (point.arc_length_mm, task.load.to_vector())));
    }
    wrenches
}

#[test]
fn the_force_goes_over_evenly_from_one_move_to_the_next() {
    let (jumping, even) = (wrenches("corner_mm = 0.0"), wrenches("corner_mm = 2.0"));
    let begin = jumping[0].0;
    let along = |k: usize| jumping[k].1;
    let (first, second, back) = (along(5), along(15), along(25));
    assert!((first - second).norm() > 100.0 && (back - second).norm() > 100.0);
    for ((length, wrench), (_, before)) in even.iter().zip(&jumping).skip(1) {
        let mut expected = *before;
        for (corner, jump) in [(10.0, second - first), (20.0, back - second)] {
            let from = length - begin - corner;
            expected -= jump * if from > 1e-9 { (1.0 - from / 2.0).max(0.0) } else { 0.0 };
        }
        assert!((wrench - expected).norm() < 1e-9, "{length}: {wrench} {expected}");
    }
    // Where the path turns back, the sideways force passes through nothing.
    assert!((even[21].1 - (second + back) / 2.0).norm() < 1e-9);
    assert_eq!(wrenches(""), even);
}

#[test]
fn percentiles_are_values() {
    let spread = |values: &[f64]| Percentiles::of(values.to_vec());
    assert_eq!(spread(&[]), None);
    assert_eq!(spread(&[2.0]), Some(Percentiles { p50: 2.0, p95: 2.0, max: 2.0 }));
    let hundred: Vec<f64> = (1..=100).rev().map(f64::from).collect();
    assert_eq!(spread(&hundred), Some(Percentiles { p50: 50.0, p95: 95.0, max: 100.0 }));
}

#[test]
fn a_square_turns_by_right_angles_at_the_rate_of_its_sides() {
    let program = "G21 G90\nG0 X0 Y0 Z0\nG1 X10 F600\nY10\nX0\nY0 F1200\nG0 Z5\n";
    let blocks = Blocks::of(&GcodeProgram::parse(program, "square.nc", &Default::default()).unwrap()).unwrap();
    assert_eq!((blocks.lines, blocks.moves), (7, 4));
    assert_eq!(blocks.per_second, Some(Percentiles { p50: 1.0, p95: 2.0, max: 2.0 }));
    let turns = blocks.turns_deg.unwrap();
    assert!((turns.p50 - 90.0).abs() < 1e-9 && (turns.max - 90.0).abs() < 1e-9, "{turns:?}");
}

#[test]
fn what_blocks_ask_of_a_control_is_told_in_three_digits() {
    let spread = |[p50, p95, max]: [f64; 3]| Some(Percentiles { p50, p95, max });
    let of = |per_second, turns_deg| Blocks {
        lines: 1,
        moves: 1,
        per_second: spread(per_second),
        turns_deg: spread(turns_deg),
    };
    let blocks = BlocksBeforeAfter {
        before: of([0.0, 0.01234, 0.1], [0.0, 1.0, 2.0]),
        after: of([2.5, 12.345, 90.0], [0.0, 504.3, 2689.0]),
    };
    let told = report::blocks_text(&job(&large(), "", b"G21 G90\nG0 X0 Y0 Z0\nG1 X1 F100\n", "part.nc"), Some(&blocks));
    for expected in [
        "half up to 2.5, 95 % up to 12.3, at most 90 (before 0, 0.012, 0.1).\n",
        "half up to 0°, 95 % up to 504°, at most 2689° (before 0°, 1°, 2°).\n",
    ] {
        assert!(told.contains(expected), "{told}");
    }
}

#[test]
fn lines_that_stay_and_units_that_are_taken_are_named() {
    let machine = large();
    let told = |head: &str| {
        let program = format!("{head}G0 X0 Y0 Z0\nG1 X10 F100\n");
        report::notes_text(&job(&machine, "", program.as_bytes(), "part.nc"), &WrittenCalls::None)
    };
    assert_eq!(
        told("G90 G17\nM3 S1000\nG0 Z5\nM8\nG0 X1\n"),
        "The program names no unit before line 3: mm is taken; G20, G21 or unit in [gcode] says which it is.\n\
         Left as written: 2 motions, lines 3 and 5, where the position of the tool in X, Y and Z is not known; start_mm in \
         [gcode] says where the program begins.\n"
    );
    assert_eq!(told("G21 G90 G17\n"), "");
    let many = told(&"G0 Z5\n".repeat(19));
    assert!(many.contains("19 motions, lines 1, 2, 3, 4, 5, 6, 7, 8 and 11 more,"), "{many}");
}
