//! Paths on which revolute joints of an arm go beyond half a turn: at home, where programs begin, the same pose is a full turn away.

use kinetostat::{
    compensation::Method, input::Folder, machine::Machine, process::file::Process, products::program::ProgramJob,
    work::Work,
};
use nalgebra::Rotation3;

/// The arm of the catalogue whose drives have the travel, degrees; the others as they are.
fn arm(travel: &[(&str, &str)]) -> Machine {
    let mut text = std::fs::read_to_string("crates/engine/src/machine/catalogue/kr270.toml").unwrap();
    for (drive, own) in travel {
        let line = text.lines().find(|line| line.contains(&format!("name = \"{drive}\""))).unwrap().to_owned();
        let (start, rest) = line.split_once("travel_deg = [").unwrap();
        let (_, end) = rest.split_once(']').unwrap();
        text = text.replace(&line, &format!("{start}travel_deg = [{own}]{end}"));
    }
    Machine::from_toml(&text, "arm").unwrap()
}

/// A program of straight moves to where the arm stands with each of `drives` (rad): `X, Y, Z, A, B, C` in its base.
fn program(machine: &Machine, drives: &[Vec<f64>]) -> String {
    let mut text = String::from("DEF turns ( )\n$BASE={X 0,Y 0,Z 0,A 0,B 0,C 0}\n$TOOL=TOOL_DATA[1]\n$VEL.CP=0.02\n");
    for (k, drives) in drives.iter().enumerate() {
        let at = machine.forward_kinematics(drives).unwrap().pose;
        let tip = at.transform(machine.tool_tip);
        let (c, b, a) = Rotation3::from_matrix_unchecked(at.rotation).euler_angles();
        let [a, b, c] = [a, b, c].map(f64::to_degrees);
        let motion = if k == 0 { "PTP" } else { "LIN" };
        let close = if k == 0 { "" } else { " C_DIS" };
        text +=
            &format!("{motion} {{X {:.6},Y {:.6},Z {:.6},A {a:.9},B {b:.9},C {c:.9}}}{close}\n", tip.x, tip.y, tip.z);
    }
    text + "END\n"
}

fn job(machine: &Machine, text: String, tangential: f64) -> ProgramJob {
    let process = format!(
        "schema = 1\n[force.path_frame]\nradial_force_N = 215.0\ntangential_force_N = {tangential}\naxial_force_N = -25.0\n[sampling]\nmax_segment_mm = 1000.0\n"
    );
    let process = Process::from_toml(&process, "process", Folder::in_memory([]), machine).unwrap();
    let folder = Folder::in_memory([("turns.src".into(), text.into_bytes())]);
    let file = process.program_in_folder(&folder, "turns.src").unwrap();
    ProgramJob::new(process, file, "turns.src", &Work::default()).unwrap()
}

/// The drives that the nominal machine gets at the ends of moves of a program that drives it along `drives`, and what is not solved.
fn track(machine: &Machine, drives: &[Vec<f64>]) -> (Vec<Vec<f64>>, Vec<String>) {
    let job = job(machine, program(machine, drives), -60.0);
    let (mut at_ends, mut failed) = (Vec::new(), Vec::new());
    job.pass_by(Method::None, &|| (), |part, answers| {
        for (k, answer) in part.range().zip(answers) {
            let source = job.path.points()[k].source;
            if !answer.status.is_success() {
                failed.push(format!("move {}: {}", source.segment, answer.status.reason(machine)));
            }
            if job.path.points().get(k + 1).is_none_or(|next| next.source.segment != source.segment) {
                at_ends.push(answer.nominal_drives.clone());
            }
        }
        Ok(())
    })
    .unwrap();
    (at_ends, failed)
}

/// From home, drive `number` taken evenly through the angles `by_way_of`, degrees, in about so many moves.
fn sweep(machine: &Machine, number: usize, by_way_of: &[f64], moves: usize) -> Vec<Vec<f64>> {
    let ends: Vec<f64> =
        std::iter::once(machine.home.drives[number].to_degrees()).chain(by_way_of.iter().copied()).collect();
    let length: f64 = ends.windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum();
    let mut all = vec![machine.home.drives.clone()];
    for pair in ends.windows(2) {
        let steps = ((pair[1] - pair[0]).abs() / length * moves as f64).ceil();
        for k in 1..=steps as usize {
            let mut drives = machine.home.drives.clone();
            drives[number] = (pair[0] + (pair[1] - pair[0]) * k as f64 / steps).to_radians();
            all.push(drives);
        }
    }
    all
}

#[track_caller]
fn is_driven(machine: &Machine, drives: &[Vec<f64>], what: &str) {
    let (at_ends, failed) = track(machine, drives);
    assert_eq!(failed, Vec::<String>::new(), "{what}");
    assert_eq!(at_ends.len(), drives.len(), "{what}");
    for (k, (found, wanted)) in at_ends.iter().zip(drives).enumerate() {
        let off = found.iter().zip(wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-6, "{what}, move {k}: {found:?}, expected {wanted:?}");
    }
}

#[test]
fn five_thousand_moves_pass_half_a_turn_on_each_joint_that_can() {
    let wide = "-350.0, 350.0";
    let machine = arm(&[("A1", wide), ("A4", wide)]);
    let ways: [(usize, &[f64]); 3] =
        [(0, &[290.0, -310.0, -200.0]), (3, &[340.0, -345.0, -200.0]), (5, &[-349.0, 345.0, 200.0])];
    for (number, by_way_of) in ways {
        is_driven(&machine, &sweep(&machine, number, by_way_of, 5000), &format!("A{}", number + 1));
    }
}

#[test]
fn a_joint_without_end_counts_its_turns_and_one_with_an_end_says_where_it_is() {
    let far = "-3000.0, 3000.0";
    is_driven(&arm(&[("A6", far)]), &sweep(&arm(&[("A6", far)]), 5, &[1100.0, -900.0], 4500), "A6");
    // Beyond 350° it has to be turned back once, and goes on from there.
    let machine = arm(&[]);
    let (at_ends, failed) = track(&machine, &sweep(&arm(&[("A6", far)]), 5, &[700.0], 1400));
    assert_eq!(failed.len(), 1, "{failed:?}");
    assert!(failed[0].starts_with("move 701: drive arm_A6 jumps from "), "{failed:?}");
    let last = at_ends.last().unwrap()[5].to_degrees();
    assert!((last - 340.0).abs() < 1e-6, "{last}");
}

#[test]
fn a_wrist_that_begins_on_its_other_branch_goes_on_there() {
    let machine = arm(&[("A4", "-350.0, 350.0")]);
    let flipped = machine.on_branch("front-up-flip".parse().unwrap()).unwrap();
    assert_ne!(machine.branch_of(&machine.home), flipped.branch_of(&flipped.home));
    // Around A4 at home of that branch, which is half a turn from that of the machine as it came.
    let at = flipped.home.drives[3].to_degrees();
    assert!((at.abs() - 180.0).abs() < 1e-6, "{at}");
    is_driven(&flipped, &sweep(&flipped, 3, &[at - 12.0, at + 12.0, at - 12.0, at], 2400), "A4");
}

#[test]
fn a_correction_that_does_not_fit_into_the_travel_is_no_turn_back() {
    let machine = arm(&[]);
    let (mut solved, mut beyond) = (0, 0);
    for (end, tangential) in [(185.0, -60.0), (-185.0, -60.0), (185.0, 60.0), (-185.0, 60.0)] {
        let job = job(&machine, program(&machine, &sweep(&machine, 3, &[end], 400)), tangential);
        job.pass_by(Method::Direct, &|| (), |_, answers| {
            for answer in answers {
                let reason = answer.status.reason(&machine);
                match answer.status.is_success() {
                    true => assert!(answer.delta_rho().iter().all(|change| change.abs() < 0.01), "{answer:?}"),
                    false => assert!(reason.contains("A4") && reason.contains("185"), "{reason}"),
                }
                *if answer.status.is_success() { &mut solved } else { &mut beyond } += 1;
            }
            Ok(())
        })
        .unwrap();
    }
    assert!(solved > 1500 && beyond > 0, "{solved} solved, {beyond} beyond the travel");
}
