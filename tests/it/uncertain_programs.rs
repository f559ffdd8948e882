//! Compensated programs where inputs are uncertain: what the program as written leaves on other machines, against brute force.

use crate::support::{
    command::told,
    uncertain::{Drawn, EXACT_MODEL, NC, TOLERANCES, draws, job, verified},
};
use kinetostat::{
    compensation::{Method, Session, TaskPoint, compensate, simulate},
    process::uncertainty::{P95, quantile},
    products::program::CompensateOptions,
    simulation::{settings, spread::DeflectionSpread, spread_along::LargestSpread},
};
use serde_json::Value;

const ORTHOGLIDE: &str = "[placement]\nreference = \"platform_point\"\n[force.path_frame]\nradial_force_N = 215.0\ntangential_force_N = -10.0\naxial_force_N = -25.0\n";
const ARM: &str = "[placement]\norigin_mm = [2100.0, 0.0, 650.0]\n[force.path_frame]\nradial_force_N = 300.0\ntangential_force_N = -200.0\naxial_force_N = -100.0\n";
const COARSE: &str = "[sampling]\nmax_segment_mm = 15.0\n";
const POLYLINE: &str = "x_mm,y_mm,z_mm,platform_qw,platform_qx,platform_qy,platform_qz,feed_mm_per_min\n\
                        0,0,0,0.5,-0.5,0.5,-0.5,600\n15,0,0,0.5,-0.5,0.5,-0.5,600\n30,5,0,0.5,-0.45,0.55,-0.49497475,600\n";

fn uncertain(pattern: &str) -> String {
    format!(
        "[uncertainty]\nmachine = \"exact\"\n[[uncertainty.parameter]]\nname = \"{pattern}\"\nrelative_std = 0.3\n{TOLERANCES}{EXACT_MODEL}"
    )
}

/// Machines whose legs pull against one another, and an arm with weight; programs with moves that do not cut, as they are rounded when written.
#[test]
fn written_programs_agree_with_brute_force() {
    for (machine, pattern, process, name, program, tolerance) in [
        ("orthoglide", "material.aluminium.*", ORTHOGLIDE, "part.nc", NC, 0.3),
        ("fanuc_r2000ic", "arm.*.stiffness", ARM, "part.csv", POLYLINE, 0.5),
    ] {
        let process = format!("tolerance_mm = {tolerance}\n{process}{COARSE}{}", uncertain(pattern));
        let job = job(machine, &process, (name, program));
        let (verified, kept) = verified(&job, &CompensateOptions::by(Method::Direct)).unwrap();
        let count = 1024;
        // Without compensation and as written: of each point, and of all that count.
        let mut sizes = vec![[Vec::new(), Vec::new()]; kept.tasks.len() + 1];
        let uncertainty = job.uncertainty.as_ref().unwrap();
        for Drawn { unloaded, actual, factor } in draws(uncertainty, &job.process.errors, count) {
            let new = || Session::new(&job.machine, &actual, settings()).with_unloaded_machine(&unloaded);
            let (mut sessions, mut largest) = ([new(), new()], [0.0f64; 2]);
            for (k, (task, commanded)) in kept.tasks.iter().zip(&kept.commanded).enumerate() {
                let task = TaskPoint { load: task.load.scale(factor), ..*task };
                let answers =
                    [compensate(&mut sessions[0], &task, Method::None), simulate(&mut sessions[1], &task, commanded)];
                for (i, answer) in answers.into_iter().enumerate() {
                    assert!(answer.outcome.is_some(), "{:?}", answer.status);
                    let size = answer.position_error.norm();
                    sizes[k][i].push(size);
                    largest[i] = if job.is_counted(k) { largest[i].max(size) } else { largest[i] };
                }
            }
            let whole = sizes.last_mut().unwrap();
            (0..2).for_each(|i| whole[i].push(largest[i]));
        }
        let check = |what: &str, spread: &DeflectionSpread, sizes: &[f64]| {
            for (value, share) in [(spread.p95_mm, P95), (spread.median_mm, 0.5)] {
                let error = 3.0 * (share * (1.0 - share) / count as f64).sqrt();
                let [low, high] = [share - error, share + error].map(|share| quantile(&mut sizes.to_vec(), share));
                let value = value.unwrap();
                // In air only rounding is left.
                assert!(
                    (low - 1e-6..=high + 1e-6).contains(&value),
                    "{machine} {what}: {value}, not {low} to {high} ({share}): {spread:?}"
                );
            }
            let expected = sizes.iter().filter(|size| **size <= tolerance).count() as f64 / count as f64;
            let within = spread.within_tolerance.unwrap();
            assert!((within - expected).abs() < 0.015, "{machine} {what}: {expected}, {spread:?}");
        };
        let rounded = verified.written.rounded_mm;
        let share_worse = |[plain, left]: &[Vec<f64>; 2]| {
            let worse = left.iter().zip(plain).filter(|(left, plain)| **left > 1.005 * **plain + rounded).count();
            worse as f64 / count as f64
        };
        for (k, (spread, sizes)) in kept.spread.iter().zip(&sizes).enumerate() {
            let spread = spread.as_ref().unwrap();
            check(&format!("{k} plain"), &spread.plain, &sizes[0]);
            check(&format!("{k} written"), spread.compensated.as_ref().unwrap(), &sizes[1]);
            if job.is_counted(k) {
                let expected = share_worse(sizes);
                assert!((spread.worse.unwrap() - expected).abs() < 0.01, "{machine} {k}: {expected}, {spread:?}");
            }
        }
        let (whole, sizes) = (verified.spread.unwrap(), sizes.last().unwrap());
        let of_written: LargestSpread = whole.compensated.unwrap();
        check("whole, plain", &whole.plain.spread, &sizes[0]);
        check("whole, written", &of_written.spread, &sizes[1]);
        let counted = (0..kept.tasks.len()).filter(|k| job.is_counted(*k)).count();
        assert!(of_written.is_confirmed && of_written.points == counted, "{of_written:?}");
        assert_eq!(counted < kept.tasks.len(), name == "part.nc");
        assert!((whole.worse.unwrap() - share_worse(sizes)).abs() < 0.01, "{machine}: {:?}", whole.worse);
        // Far from what the program leaves with the inputs that it was computed from.
        let nominal = verified.passes.last().unwrap().summary.max_mm.unwrap();
        assert!(of_written.spread.p95_mm.unwrap() > 10.0 * nominal, "{machine}: {nominal}, {of_written:?}");
    }
}

/// Runs `compensate` in a new folder: exit code, words of both outputs, and the folder.
fn command(process: &str, more: &[&str]) -> (Option<i32>, String, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    std::fs::write(at("part.nc"), NC).unwrap();
    std::fs::write(at("process.toml"), format!("schema = 1\n{process}")).unwrap();
    let (part, process, out) = (at("part.nc"), at("process.toml"), at("out.nc"));
    let own = ["compensate", &part, "--machine", "orthoglide", "--process", &process, "--out", &out];
    let (code, out, err) = told(&[&own, more].concat());
    let words = (out + &err).split_whitespace().collect::<Vec<_>>().join(" ");
    (code, words, folder)
}

#[test]
fn the_first_screen_of_a_program_is_its_verdict() {
    let process =
        |tolerance: f64, uncertain: &str| format!("tolerance_mm = {tolerance}\n{ORTHOGLIDE}{COARSE}{uncertain}");
    let (code, exact, _) = command(&process(0.3, ""), &[]);
    assert_eq!(code, Some(0), "{exact}");
    assert!(exact.contains("if all inputs are exact.") && exact.contains("inputs taken as exact"), "{exact}");

    let (code, words, folder) = command(&process(5.0, &uncertain("leg.*.stiffness")), &[]);
    assert_eq!(code, Some(0), "{words}");
    // By what this process says nobody knows what control, backlash, heat and bodies add.
    let begin = "? Not decided: 8 of 12 causes unknown [simulated] ● force ○ weight ◐ force uncertainty ○ stiffness ◐ geometry ○ accuracy ";
    let expected = "By the deflection alone: Within tolerance: the tool of orthoglide, with the compensated program, stays within 5 mm all along part.nc with more than 99.9 % \
                    probability, within ";
    assert!(words.starts_with(begin) && words.contains(expected), "{words}");
    assert!(words.contains("draws, all points solved") && !words.contains("inputs taken as exact"), "{words}");
    for sentence in [
        "Compensation makes the largest distance larger by more than 0.5 % with ",
        "What spreads the answer most is ",
        "The engine, solved at each of ",
    ] {
        assert!(words.contains(sentence), "{sentence} is missing in {words}");
    }
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    let report: Value = serde_json::from_str(&read("out.nc.report.json")).unwrap();
    let largest = &report["uncertainty"]["largest"]["compensated"]["spread"];
    let p95 = largest["p95_mm"].as_f64().unwrap();
    assert!(words.contains(&format!("within {p95:.3} mm with 95 %")), "{p95}: {words}");
    let points = read("out.nc.points.csv");
    let head: Vec<&str> = points.lines().next().unwrap().split(',').collect();
    let column = |name: &str| -> Vec<f64> {
        let place = head.iter().position(|own| *own == name).unwrap_or_else(|| panic!("{name} is not in {head:?}"));
        points.lines().skip(1).filter_map(|row| row.split(',').nth(place).unwrap().parse().ok()).collect()
    };
    let most = column("error_after_p95_mm").into_iter().fold(0.0, f64::max);
    assert!(most > 0.5 * p95 && most <= p95 * 1.01, "{most} at a point, {p95} along all");
    let after = column("error_after_mm").into_iter().fold(0.0, f64::max);
    assert!(after < 0.2 * p95, "{after} with nominal numbers");
    let worse = column("worse_probability");
    assert!(!worse.is_empty() && worse.iter().all(|share| (0.0..=1.0).contains(share)), "{worse:?}");
    assert!(read("out.nc.html").contains("before, 95 % below"));

    let (_, words, _) = command(&process(0.001, &uncertain("leg.*.stiffness")), &[]);
    assert!(words.contains("Out of tolerance: "), "{words}");
    // What cannot be judged is not.
    let (_, words, _) = command(&process(5.0, &uncertain("leg.*.stiffness")), &["--method", "none"]);
    assert!(words.contains("Within tolerance: the tool of orthoglide, as programmed, "), "{words}");
    let in_air = process(5.0, &uncertain("leg.*.stiffness"));
    let in_air = in_air.replace("radial_force_N = 215.0", "radial_force_N = 0.0");
    let in_air = in_air.replace("= -10.0\naxial_force_N = -25.0", "= 0.0\naxial_force_N = 0.0");
    let (_, words, _) = command(&in_air, &[]);
    assert!(words.contains("No cutting force is given: there is no verdict. The tool of orthoglide, "), "{words}");
    let outside = process(5.0, &uncertain("leg.*.stiffness"))
        .replace("[placement]", "[placement]\norigin_mm = [900.0, 0.0, 0.0]");
    let (_, words, _) = command(&outside, &[]);
    assert!(!words.contains("ithin tolerance: the tool"), "{words}");
}

/// What was measured has in it what the model leaves out.
#[test]
fn a_measured_pass_has_no_distribution() {
    let process = format!("tolerance_mm = 5.0\n{ORTHOGLIDE}{COARSE}{}", uncertain("leg.*.stiffness"));
    let folder = tempfile::tempdir().unwrap();
    let measured = folder.path().join("measured.csv");
    let job = job("orthoglide", &format!("{ORTHOGLIDE}{COARSE}"), ("part.nc", NC));
    let rows = job.path.points().iter().map(|point| {
        let [x, y, z]: [f64; 3] = point.position_mm.into();
        format!("{:?},{y:?},{z:?}\n", x + 0.1)
    });
    std::fs::write(&measured, format!("x_mm,y_mm,z_mm\n{}", rows.collect::<String>())).unwrap();
    let (code, words, folder) = command(&process, &["--measured", measured.to_str().unwrap()]);
    assert!(code == Some(2) && words.contains("is not computed for a measured pass"), "{code:?} {words}");
    assert!(!folder.path().join("out.nc").exists());
}

/// What is asked of a machine or a command that cannot answer it is refused, and nothing is written.
#[test]
fn uncertain_inputs_are_refused_where_nothing_computes_them() {
    let process = |uncertain: &str| format!("{ORTHOGLIDE}{COARSE}{uncertain}");
    let (code, words, folder) =
        command(&process("[[uncertainty.parameter]]\nname = \"arm.*\"\nrelative_std = 0.1\n"), &[]);
    assert_eq!(code, Some(2), "{words}");
    assert!(words.contains("process.toml") && words.contains("uncertainty.parameter[0].name"), "{words}");
    assert!(!folder.path().join("out.nc").exists());
    let (code, words, _) = command(&process("[uncertainty]\ncovariance = \"nowhere.csv\"\n"), &[]);
    assert!(code == Some(2) && words.contains("\"nowhere.csv\" is not a file"), "{words}");

    let (code, words, folder) = command(&process("[uncertainty.process]\nforce_relative_std = 0.15\n"), &[]);
    assert_eq!(code, Some(0), "{words}");
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (part, file) = (at("part.nc"), at("process.toml"));
    let on = ["--machine", "orthoglide", "--process", &file];
    let (code, out, err) = told(&[&["compare", "--path", &part][..], &on].concat());
    assert_eq!(code, Some(2), "{out}{err}");
    assert!(err.contains("is not computed for a comparison of places") && err.contains("process.toml"), "{err}");
    for (table, problem) in [
        (
            "[online]\ncircle = { centre_mm = [0.0, 0.0, 0.0], diameter_mm = 40.0, points = 9 }\nfeed_mm_per_min = 600.0\n",
            "process.force_relative_std: is given by force_errors_percent in an online study",
        ),
        (
            "[path]\nfile = \"part.nc\"\nmethods = [\"direct\"]\n[uncertainty.process]\nforce_relative_std = 0.1\n",
            "is also given by",
        ),
    ] {
        let study = folder.path().join("study");
        std::fs::create_dir_all(&study).unwrap();
        std::fs::copy(&part, study.join("part.nc")).unwrap();
        std::fs::copy(&file, study.join("process.toml")).unwrap();
        let text =
            format!("schema = 3\nquestion = \"?\"\nmachine = \"orthoglide\"\nprocess = \"process.toml\"\n{table}");
        std::fs::write(study.join("study.toml"), text).unwrap();
        let (code, out, err) = told(&["run", study.to_str().unwrap(), "--quiet"]);
        assert!(code != Some(0) && err.contains(problem), "{code:?} {out}{err}");
    }
}
