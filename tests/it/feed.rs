//! Feeds that are chosen by limits: against closed forms of the force, evaluated here on the feed that the text of the program has.

use std::{f64::consts::PI, path::Path};

use kinetostat::{
    Machine, Work,
    compensation::Method,
    input::{Folder, error::Result},
    process::{Process, feed::FeedQuantity},
    products::program::{CompensateOptions, Compensated, NoFiles, ProgramJob},
    toolpath::ProgramFile,
};

use crate::support::{command::told, uncertain::job};

const SPEED: f64 = 8000.0;
const TEETH: f64 = 4.0;
/// The file as it is, and a part of a path that is twice as deep.
const LAW: &str = "tangential_cutting_N_per_mm2 = 900.0\nradial_cutting_N_per_mm2 = 400.0\naxial_cutting_N_per_mm2 = 0.0\n\
                   tangential_edge_N_per_mm = 12.0\nradial_edge_N_per_mm = 8.0\nteeth = 4\n";
const LIGHT_MM: f64 = 1.0;
const DEEP_MM: f64 = 2.0;

fn process(feed: &str) -> String {
    format!(
        "[force.slot_milling]\n{LAW}axial_depth_mm = {LIGHT_MM:?}\n[force_of_feature.DEEP.slot_milling]\n{LAW}axial_depth_mm = {DEEP_MM:?}\n\
         [feed]\n{feed}"
    )
}

/// The same without the deep part.
fn light(feed: &str) -> String {
    format!("[force.slot_milling]\n{LAW}axial_depth_mm = {LIGHT_MM:?}\n[feed]\n{feed}")
}

/// Tangential and radial force at this feed, mm/min, in N.
fn components(feed: f64, depth_mm: f64) -> [f64; 2] {
    let edges = TEETH * depth_mm;
    let c = feed / (SPEED * TEETH);
    [(900.0, 12.0), (400.0, 8.0)].map(|(cutting, edge)| edges * (cutting * c / 4.0 + edge / PI))
}

fn force(feed: f64, depth_mm: f64) -> f64 {
    let [tangential, radial] = components(feed, depth_mm);
    tangential.hypot(radial)
}

/// The feed at which the force is `limit`, by bisection.
fn feed_at(limit: f64, depth_mm: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1e5);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if force(middle, depth_mm) < limit { low = middle } else { high = middle }
    }
    low
}

fn text(job: &ProgramJob) -> String {
    let ProgramFile::Gcode(program) = &job.file else { panic!("no G-code") };
    String::from_utf8(program.source().to_vec()).unwrap()
}

/// The number after F in each line that has one.
fn numbers(text: &str) -> Vec<f64> {
    let word = |line: &str| Some(line.split_once('F')?.1.split(' ').next()?.parse().unwrap());
    text.lines().filter_map(word).collect()
}

const PROGRAM: &str = "%\r\nG21 G90 (PART)\r\nS8000 M3\r\nG0 X0 Y0 Z0\r\nN10 G1 X20 F1000 M8 ; slot\r\nG0 X0 Y10\r\n\
                       F1500\r\nG1 X10\r\n(DEEP)\r\nX20\r\nG1 Y20 F800\r\nM30\r\n%\r\n";

fn attempt(process: &str, (name, program): (&str, &str)) -> Result<ProgramJob> {
    let machine = Machine::named_or_file("orthoglide")?;
    let process = Process::from_toml(&format!("schema = 1\n{process}"), "p.toml", Folder::in_memory([]), &machine)?;
    let folder = Folder::in_memory([(name.to_owned(), program.as_bytes().to_vec())]);
    let program = process.program_in_folder(&folder, name)?;
    ProgramJob::new(process, program, name, &Work::default())
}

fn refusal(process: &str, program: (&str, &str)) -> String {
    attempt(process, program).unwrap_err().to_string()
}

/// Each line is fed as fast as its force allows, faster or slower, down to rounding; all else of the text stays, and the minutes are those of the moves.
#[test]
fn a_slot_is_fed_up_to_its_force() {
    let limit = 80.0;
    let found = job("orthoglide", &process("max_force_N = 80.0\nchange = [0.3, 3.0]\n"), ("part.nc", PROGRAM));
    let written = text(&found);
    let [light, deep] = [LIGHT_MM, DEEP_MM].map(|depth| feed_at(limit, depth));
    assert!(light > 1500.0 && deep < 800.0, "{light} {deep}");
    let all = numbers(&written);
    // Its own line stays, and what follows has a word of its own.
    let expected = [(light, 1000.0), (1500.0, 1500.0), (light, 1500.0), (deep, 1500.0), (deep, 800.0)];
    assert_eq!(all.len(), expected.len(), "{written}");
    for (own, (most, programmed)) in all.iter().zip(expected) {
        assert!(*own <= most && *own > 0.993 * most, "{own} {most} {programmed}");
    }
    let without = |text: &str| -> Vec<String> {
        let words = text.split(' ').filter(|word| !word.starts_with('F'));
        words.flat_map(|word| word.split(" F").next().map(String::from)).collect()
    };
    let stripped = |text: &str| {
        let lines = text.split("\r\n").map(|line| without(line).join(" "));
        lines.collect::<Vec<_>>()
    };
    assert_eq!(stripped(&written), stripped(PROGRAM));
    let feed = found.feed.as_ref().unwrap();
    let minutes =
        |feeds: [f64; 4]| -> f64 { [20.0, 10.0, 10.0, 10.0].iter().zip(feeds).map(|(way, feed)| way / feed).sum() };
    let [before, after] = feed.minutes;
    assert!((before - minutes([1000.0, 1500.0, 1500.0, 800.0])).abs() < 1e-9, "{before}");
    assert!((after - minutes([all[0], all[2], all[3], all[4]])).abs() < 1e-9, "{after}");
    assert_eq!((feed.lines, feed.words, feed.exceeded.len()), ([2, 2, 0, 0], 4, 0));
    assert_eq!(feed.stopped_by, [4, 0, 0, 0, 0, 0, 0]);
    let (quantity, most, [(programmed, _), (now, place)]) = &feed.largest[0];
    assert_eq!((*quantity, *most), (FeedQuantity::Force, limit));
    assert!((programmed - force(1500.0, DEEP_MM)).abs() < 1e-6 && *now <= limit, "{programmed} {now} {place}");
}

/// The program that `compensate` writes has these feeds: forces of its own text are below the limit.
#[test]
fn the_compensated_program_keeps_the_limit() {
    let found = job("orthoglide", &process("max_force_N = 80.0\nchange = [0.3, 3.0]\n"), ("part.nc", PROGRAM));
    let work = Work::default();
    let Compensated::Verified(verified) =
        found.compensate(&CompensateOptions::by(Method::Direct), &mut NoFiles, &work).unwrap()
    else {
        panic!("refused")
    };
    let without = process("max_force_N = 1e6\n").split("[feed]").next().unwrap().to_string();
    let machine = Machine::named_or_file("orthoglide").unwrap();
    let without =
        Process::from_toml(&format!("schema = 1\n{without}"), "p.toml", Folder::in_memory([]), &machine).unwrap();
    let again = without.parse_program(verified.written.bytes, Path::new("out.nc")).unwrap();
    let path = again.toolpath(without.sampling).unwrap();
    let mut most = [0.0f64; 2];
    for point in path.points().iter().filter(|point| point.cutting) {
        let depth = if point.feature.is_some() { DEEP_MM } else { LIGHT_MM };
        let own = force(point.feed_mm_per_min.unwrap(), depth);
        most[usize::from(point.feature.is_some())] = most[usize::from(point.feature.is_some())].max(own);
    }
    assert!(most.iter().all(|own| *own <= 80.0 && *own > 79.0), "{most:?}");
}

/// In inches, per revolution and by inverse time it is the same feed.
#[test]
fn any_mode_of_the_feed_gives_the_same() {
    let program = |start: &str, x: f64, f: &str| format!("{start} G90\nS8000 M3\nG0 X0 Y0 Z0\nG1 X{x} F{f}\n");
    let texts = [
        (program("G21", 25.4, "1000.0"), 1.0),
        (program("G20", 1.0, "39.37"), 25.4),
        (program("G21 G95", 25.4, "0.125"), SPEED),
        (program("G21 G93", 25.4, "39.37"), 25.4),
    ];
    for (limit, depth) in [(40.0, LIGHT_MM), (55.0, LIGHT_MM)] {
        for (program, unit) in &texts {
            let feed = format!("max_force_N = {limit:?}\nchange = [0.2, 3.0]\n");
            let found = job("orthoglide", &light(&feed), ("part.nc", program));
            let own = numbers(&text(&found))[0] * unit;
            // Cuts of the depth of the file alone: there is no feature.
            assert!(force(own, depth) <= limit && own > 0.994 * feed_at(limit, depth), "{own} {program}");
            let read = found.path.points().last().unwrap().feed_mm_per_min.unwrap();
            assert!((read / own - 1.0).abs() < 1e-9, "{read} {own}");
        }
    }
}

/// Behind a line whose feed was changed, one that cuts nothing has the programmed feed again; it is not fed faster.
#[test]
fn air_keeps_its_feed() {
    let stock = "[sampling]\nmax_segment_mm = 1.0\n[force.end_milling]\nmaterial = \"Al 7075-T6\"\n[stock]\n\
                 box = { min_mm = [-60.0, -50.0, -5.0], max_mm = [0.0, 50.0, 20.0] }\n[tools.1]\ndiameter_mm = 10.0\nteeth = 4\n";
    let program = "G21 G90\nS8000 M3\nG0 X-40 Y0 Z-10\nG1 Z0 F300\nX-20 F2400\nX10\nX40\nX60 Y1\nG0 Z-10\n";
    let found =
        job("orthoglide", &format!("{stock}[feed]\nmax_force_N = 300.0\nchange = [0.2, 1.5]\n"), ("part.nc", program));
    let written = text(&found);
    let lines: Vec<&str> = written.lines().collect();
    assert_eq!(lines[6], "X40 F2400", "{written}");
    assert_eq!((lines[7], lines[3]), ("X60 Y1", "G1 Z0 F300"), "{written}");
    let feed = found.feed.unwrap();
    // The plunge, whose end teeth have no law, is not fed faster.
    assert_eq!((feed.lines[3], feed.stopped_by[6]), (2, 1), "{feed:?}");
    let forces = found.path.points().iter().filter_map(|point| point.load).map(|load| load.force_N.norm());
    let most = forces.fold(0.0, f64::max);
    assert!(most <= 300.0 && most > 297.0, "{most}");
}

/// Torque is that of the removed volume, power that torque times the turns.
#[test]
fn torque_and_power_are_those_of_the_volume() {
    let stock = "[sampling]\nmax_segment_mm = 1.0\n[force.end_milling]\n\
                 coefficients = { tangential_cutting_N_per_mm2 = 900.0, radial_cutting_N_per_mm2 = 400.0, axial_cutting_N_per_mm2 = -150.0 }\n\
                 [stock]\nbox = { min_mm = [-60.0, -50.0, -5.0], max_mm = [60.0, 50.0, 20.0] }\n[tools.1]\ndiameter_mm = 10.0\nteeth = 4\n";
    let program = "G21 G90\nS8000 M3\nG0 X-40 Y0 Z-10\nG1 Z0 F100\nX20 F2400\nG0 Z-10\n";
    // A slot of 10 mm by 5 mm: N·mm for each mm/rev, over a turn.
    let torque = |feed: f64| 900.0 * 50.0 * feed / SPEED / (2.0 * PI) / 1e3;
    let power = |feed: f64| torque(feed) * 2.0 * PI * SPEED / 60.0 / 1e3;
    for limit in [format!("max_torque_Nm = {:?}", torque(1800.0)), format!("max_power_kW = {:?}", power(3000.0))] {
        let found = job("orthoglide", &format!("{stock}[feed]\n{limit}\n"), ("part.nc", program));
        let own = numbers(&text(&found))[1];
        let most = if limit.contains("torque") { 1800.0 } else { 3000.0 };
        assert!(own <= most * 1.001 && own > 0.99 * most, "{own} {limit}");
    }
}

/// The deflection without compensation is force over stiffness; where no feed of those allowed keeps a limit, its line, value and limit are said.
#[test]
fn deflection_is_limited_and_what_is_not_kept_is_said() {
    let program = "G21 G90\nS8000 M3\nG0 X0 Y0 Z0\nG1 X1 F1000\n";
    // Along x a prismatic joint of 10 N/µm: the radial force is against the feed.
    let microns = |feed: f64| components(feed, LIGHT_MM)[1] / 10.0;
    let most = microns(1400.0);
    let found = job("lever", &light(&format!("max_deflection_mm = {:?}\n", most / 1e3)), ("part.nc", program));
    let own = numbers(&text(&found))[0];
    assert!(own <= 1400.0 && own > 0.993 * 1400.0, "{own}");
    let found = job("lever", &light("max_deflection_mm = 0.0005\nchange = [0.8, 1.0]\n"), ("part.nc", program));
    let feed = found.feed.as_ref().unwrap();
    assert_eq!(numbers(&text(&found)), [800.0]);
    let [(place, FeedQuantity::Deflection, value, 0.0005)] = feed.exceeded.as_slice() else { panic!("{feed:?}") };
    assert!((value * 1e3 - microns(800.0)).abs() < 1e-6 && place.starts_with("line 4,"), "{value} {place}");
}

/// The fastest feed is a limit like others, also of what is programmed faster; a feed that need not change by much stays, without a new word.
#[test]
fn the_fastest_feed_binds_and_what_is_near_stays() {
    let found = job("orthoglide", &process("max_force_N = 1e4\nmax_mm_per_min = 1200.0\n"), ("part.nc", PROGRAM));
    assert_eq!(numbers(&text(&found))[..3], [1200.0, 1500.0, 1200.0]);
    let limit = force(1500.0 * 1.03, DEEP_MM);
    let near =
        job("orthoglide", &process(&format!("max_force_N = {limit:?}\nchange = [0.5, 1.0]\n")), ("part.nc", PROGRAM));
    assert_eq!((text(&near), near.feed.unwrap().words), (PROGRAM.to_string(), 0));
}

/// A line that runs twice has one feed, that of the run that allows least; a feed that is computed cannot be written.
#[test]
fn calls_stay() {
    let program =
        "O1\nG21 G90\nS8000 M3\nG0 X0 Y0 Z0\nM98 P100\n(DEEP)\nG0 X0 Y10\nM98 P100\nM30\nO100\nG1 X20 F1000\nM99\n";
    let limits = process("max_force_N = 80.0\nchange = [0.3, 3.0]\n");
    let found = job("orthoglide", &limits, ("part.nc", program));
    let all = numbers(&text(&found));
    let most = feed_at(80.0, DEEP_MM);
    assert!(all.len() == 2 && all[0] == all[1] && all[0] <= most && all[0] > 0.993 * most, "{all:?} {:?}", found.feed);
    assert_eq!(found.feed.as_ref().unwrap().words, 1);
    let work = Work::default();
    let Compensated::Verified(verified) =
        found.compensate(&CompensateOptions::by(Method::None), &mut NoFiles, &work).unwrap()
    else {
        panic!("refused")
    };
    let written = String::from_utf8(verified.written.bytes).unwrap();
    assert!(written.contains("M98 P100") && numbers(&written) == all[..1], "{written}");
    let computed = program.replace("F1000", "F#101").replace("G0 X0 Y0 Z0", "#101=1000\nG0 X0 Y0 Z0");
    let message = refusal(&limits, ("part.nc", &computed));
    assert!(
        message.contains("line 12 is computed, and so has no feed that can be written: expected --expand"),
        "{message}"
    );
}

/// In the corner of a pocket, where more is met, the feed falls until the force is that of the limit.
#[test]
fn a_corner_is_cut_at_the_limit() {
    let stock = "[placement]\norigin_mm = [0.0, 0.0, 100.0]\n[force.end_milling]\nmaterial = \"Al 7075-T6\"\n[stock]\n\
                 box = { min_mm = [-30.0, -20.0, 0.0], max_mm = [30.0, 20.0, 15.0] }\n[tools.1]\ndiameter_mm = 10.0\nteeth = 4\n";
    let program = "G21 G90\nS8000 M3\nG0 X-30 Y-22 Z-5\nG0 X-38\nG1 X-38 Y-22 Z3 F2000\nX10 Y-22\nX14 Y-19\nX17 Y-14\nX17 Y26\nG0 Z-10\n";
    let limit = 240.0;
    let found = job(
        "orthoglide",
        &format!("{stock}[feed]\nmax_force_N = {limit:?}\nchange = [0.1, 1.5]\n"),
        ("part.nc", program),
    );
    let mut by_line = std::collections::BTreeMap::new();
    for point in found.path.points() {
        if let Some(load) = point.load {
            let most = by_line.entry(found.file.line_of(point.source.segment).unwrap()).or_insert((0.0f64, 0.0));
            *most = (most.0.max(load.force_N.norm()), point.feed_mm_per_min.unwrap());
        }
    }
    assert!(by_line.len() >= 4 && by_line.values().all(|own| own.0 <= limit * 1.001), "{by_line:?}");
    let corner = by_line.values().filter(|own| own.1 < 2000.0 && own.0 > 0.9 * limit).count();
    assert!(corner >= 1 && by_line.values().any(|own| own.1 == 3000.0), "{by_line:?}");
}

/// What has no F words, or does not change them, says so by the key.
#[test]
fn other_programs_and_commands_refuse_it() {
    let limits = light("max_force_N = 100.0\n");
    let heidenhain = "BEGIN PGM P MM\nL X+0 Y+0 Z+0 R0 FMAX M3\nL X+10 F500\nEND PGM P MM\n";
    for (name, program) in [("p.csv", "x_mm,y_mm,z_mm,feed_mm_per_min\n0,0,0,100\n1,0,0,100\n"), ("p.h", heidenhain)] {
        let message = refusal(&limits, (name, program));
        let expected = format!("p.toml: feed: changes F words of G-code, and {name} is no such program");
        assert!(message.starts_with(&expected), "{message}");
    }
    let scratch = tempfile::tempdir().unwrap();
    let at = |name: &str| scratch.path().join(name).display().to_string();
    std::fs::write(at("part.nc"), PROGRAM).unwrap();
    std::fs::write(at("p.toml"), format!("schema = 1\n{limits}")).unwrap();
    let study =
        "schema = 3\nquestion = \"?\"\nmachine = \"orthoglide\"\nprocess = \"p.toml\"\n[path]\nfile = \"part.nc\"\n";
    std::fs::write(at("study.toml"), study).unwrap();
    for (arguments, name) in [
        (
            &["export-correction", "--machine", "orthoglide", "--process", &at("p.toml"), "--out", &at("out")][..],
            "export-correction",
        ),
        (
            &["compare", "--path", &at("part.nc"), "--process", &at("p.toml"), "--machine", "orthoglide"],
            "a comparison of places",
        ),
        (&["run", scratch.path().to_str().unwrap()], "a study"),
    ] {
        let (code, _, said) = told(arguments);
        let expected = format!(
            "feed: is not for {name}, which leaves feeds as programmed: only compensate changes those of a G-code program"
        );
        assert!(code == Some(2) && said.contains(&expected), "{said}");
    }
}

/// A line that may be switched off carries no feed for the next one; what moves or waits beside the path is refused where its feed would be another; a way that is not known is not fed
/// faster.
#[test]
fn no_line_relies_on_a_feed_that_may_not_be_there() {
    let feed = "max_force_N = 80.0\nchange = [0.3, 3.0]\n";
    let program = "G21 G90\nS8000 M3\nG0 X0 Y0 Z0\nG1 X10 F1500\n(DEEP)\n/G1 X20\nG1 X30\n";
    let all = numbers(&text(&job("orthoglide", &process(feed), ("part.nc", program))));
    let deep = feed_at(80.0, DEEP_MM);
    assert_eq!(all.len(), 3, "{all:?}");
    assert!(all[1..].iter().all(|own| *own <= deep && *own > 0.993 * deep), "{all:?} {deep}");
    // What a line that may be switched off does to the feed, whether it moves or not.
    for between in ["/F375", "/G0 Y1 F375", "/M98 P100"] {
        let called = if between.contains("M98") { "O100\nG1 Y1 F375\nM99\n" } else { "" };
        let program = format!("G21 G90\nS8000 M3\nG0 X0 Y0 Z0\nG1 X20 F500\n(DEEP)\n{between}\nG1 X40\nM30\n{called}");
        let written = text(&job("orthoglide", &process(feed), ("part.nc", &program)));
        let last = written.lines().find(|line| line.starts_with("G1 X40")).unwrap();
        assert!(last.contains('F'), "{written}");
    }
    for (line, expected) in [
        ("G53 G1 Z-5", "line 5 moves by feed to a position of the machine (G53"),
        ("G53 Z-5", "line 5 moves by feed to a position of the machine (G53"),
        ("G4 F3", "line 5 has F beside G4"),
    ] {
        let program = format!("G21 G90\nS8000 M3\nG0 X0 Y0 Z0\nG1 X10 F1000\n{line}\nG1 X20\n");
        let found = refusal(&light(feed), ("part.nc", &program));
        assert!(found.contains(expected), "{found}");
    }
    for line in ["G1 SUPA Z300", "G153 Z300"] {
        let program = format!("G71 G90 G54\nS8000 M3\nG0 X0 Y0 Z0\nG1 X10 F1000\n{line}\nG1 X20\nM30\n");
        let found = refusal(&light(feed), ("part.mpf", &program));
        assert!(found.contains("line 5 moves by feed to a position of the machine"), "{found}");
    }
    let rapid = "G21 G90\nS8000 M3\nG0 X0 Y0 Z0\nG1 X10 F1000\nG0 G53 Z0\nG0 X0 Y0 Z5\nG1 Z0\nX20 F1000\n";
    let all = numbers(&text(&job("orthoglide", &light(feed), ("part.nc", rapid))));
    // The way down keeps its feed.
    assert!(all.len() == 3 && all[0] > 1000.0 && all[1] == 1000.0 && all[2] > 1000.0, "{all:?}");
}

/// Where the force goes over behind a corner, each line answers for its own: a short one is not fed by the force of the line before.
#[test]
fn a_short_line_behind_a_corner_is_limited_by_its_own_force() {
    let process = process("max_deflection_mm = 0.3\nchange = [0.2, 3.0]\n");
    let process = format!("[compensate]\ncorner_mm = 5.0\n{process}");
    let program = "G21 G90\nS8000 M3\nG0 X0 Y0 Z0\nG1 X10 F1000\nY1\n(DEEP)\nX20\n";
    let job = job("orthoglide", &process, ("part.nc", program));
    let feed = job.feed.as_ref().unwrap();
    assert!(feed.exceeded.is_empty(), "{:?}", feed.exceeded);
    let most = job.pass_by(Method::None, &|| (), |_, _| Ok(())).unwrap().summary.max_mm.unwrap();
    assert!(most <= 0.3 * (1.0 + 1e-6), "{most}");
}
