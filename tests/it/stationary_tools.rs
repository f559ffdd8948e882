//! A robot that holds the part below a stationary tool, against the same robot seen from its base.

use kinetostat::{
    input::Folder,
    machine::{Configuration, Machine},
    process::Process,
    spatial::{Pose, Wrench},
    statics::{Scratch, State, Status, equilibrium},
    toolpath::Orientation,
};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use crate::robot_compensated::compensated;

const TOOL: &str = "[tool]\nstationary = true\ntip_mm = [1650.0, 200.0, 700.0]\naxis = [0.0, 0.2, 1.0]\n";
const CUT: &str = "[placement]\norigin_mm = [0.0, 0.0, 0.0]\n[force.path_frame]\nradial_force_N = 300.0\n\
                   tangential_force_N = -200.0\naxial_force_N = -100.0\n";
const TIP: Vector3<f64> = Vector3::new(1650.0, 200.0, 700.0);

fn arm() -> Machine {
    Machine::named_or_file("irb7600").unwrap()
}

fn process(machine: &str, more: &str) -> Result<Process, String> {
    let (text, machine) = (format!("schema = 1\n{CUT}{more}"), Machine::named_or_file(machine).unwrap());
    Process::from_toml(&text, "process", Folder::in_memory([]), &machine).map_err(|refused| refused.to_string())
}

/// Returns where P of `machine` comes to rest at `drives` under the wrench about P that `load` gives for a pose of it.
fn rest(machine: &Machine, at: &Configuration, drives: &[f64], load: impl Fn(&Pose) -> Wrench) -> Pose {
    let (mut pose, mut scratch) = (at.pose, Scratch::new(machine));
    for _ in 0..8 {
        let mut state = State::rigid(machine, at);
        let outcome = equilibrium(machine, drives, &load(&pose), &mut state, &mut scratch, &Default::default());
        assert_eq!(outcome.status, Status::Solved);
        pose = state.pose;
    }
    pose
}

#[test]
fn the_machine_seen_from_the_part_moves_and_bends_as_it_does() {
    let (held, seen) = (arm(), process("irb7600", TOOL).unwrap().machine);
    let force = Vector3::new(400.0, -700.0, 300.0);
    for turned in [[0.0; 6], [0.3, -0.2, 0.1, 0.4, -0.3, 0.6], [-0.5, 0.15, 0.2, -0.7, 0.2, -1.2]] {
        let drives: Vec<f64> = held.home.drives.iter().zip(turned).map(|(at, by)| at + by).collect();
        // Its chain begins at the part.
        let from_part: Vec<f64> = drives.iter().rev().copied().collect();
        let [here, there] = [(&held, &drives), (&seen, &from_part)]
            .map(|(machine, drives)| machine.forward_kinematics(drives).unwrap());
        // P of the machine seen from the part is at the tip.
        let expected = here.pose.inverse().compose(&Pose::from_translation(TIP));
        assert!((there.pose.translation - expected.translation).norm() < 1e-6);
        assert!((there.pose.rotation - expected.rotation).norm() < 1e-9);
        // A force on the tool, in axes of the part, and its reaction on the part where the tool is.
        let bent = rest(&seen, &there, &from_part, |pose| Wrench {
            force,
            moment: (pose.rotation * seen.tool_tip).cross(&force),
        });
        let reaction = rest(&held, &here, &drives, |pose| {
            let force = -(pose.rotation * force);
            Wrench { force, moment: (TIP - pose.translation).cross(&force) }
        });
        let expected = reaction.inverse().compose(&Pose::from_translation(TIP));
        assert!((there.pose.translation - bent.translation).norm() > 0.1);
        assert!(
            (bent.translation - expected.translation).norm() < 1e-6,
            "{} {}",
            bent.translation,
            expected.translation
        );
    }
}

const RAPID: &str = "MODULE M\n\
    TASK PERS tooldata drill := [FALSE, [[1650,200,700], [0.9950041652780258,0.09983341664682815,0,0]], [1,[0,0,0.001],[1,0,0,0],0,0,0]];\n\
    TASK PERS wobjdata block := [TRUE, TRUE, \"\", [[0,0,150], [1,0,0,0]], [[20,-10,0], [0.9238795325112867,0,0,0.3826834323650898]]];\n\
    PROC main()\n\
    ConfJ\\Off; ConfL\\Off;\n\
    MoveAbsJ [[0,0,0,0,50,0],[9E9,9E9,9E9,9E9,9E9,9E9]], v100, z5, tool0;\n\
    MoveJ [[0,0,40],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]], v100, fine, drill\\WObj:=block;\n\
    MoveL [[0,0,-5],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]], v20, fine, drill\\WObj:=block;\n\
    MoveL [[60,30,-5],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]], v20, fine, drill\\WObj:=block;\n\
    ENDPROC\nENDMODULE\n";

#[test]
fn a_part_that_is_moved_below_a_standing_tool_is_cut_where_the_program_says() {
    let process = process("irb7600", TOOL).unwrap();
    let (job, written) = compensated(process, &[("part.mod", RAPID)]);
    let text = String::from_utf8_lossy(&written.bytes).into_owned();
    assert!(text.contains("MoveAbsJ [[0,0,0,0,50,0]") && text != RAPID, "{text}");
    let held = arm();
    let block = Isometry3::new(Vector3::new(20.0, -10.0, 150.0), Vector3::z() * std::f64::consts::FRAC_PI_4);
    // The targets turn the tool by half a turn about x of the block, and its frame stands by as much about its own x in the base.
    let [turned, stands] = [Vector3::x() * std::f64::consts::PI, Vector3::x() * 0.2].map(UnitQuaternion::new);
    let base_in_part = block.rotation * turned * stands.inverse();
    let mut largest = 0f64;
    for part in job.parts().map(Result::unwrap) {
        for ((k, point), task) in part.range().zip(part.points).zip(part.tasks()) {
            // What the controller leads the flange to, so that the tool is where the written program has it in the part.
            let Some(Orientation::Platform(turned)) = point.orientation else { panic!("{:?}", point.orientation) };
            assert!(turned.angle_to(&base_in_part) < 1e-9);
            let commanded = Isometry3::from_parts(written.sent.positions[k].into(), turned);
            let flange = Isometry3::from_parts(TIP.into(), UnitQuaternion::identity()) * commanded.inverse();
            let flange = Pose {
                rotation: flange.rotation.to_rotation_matrix().into_inner(),
                translation: flange.translation.vector,
            };
            let at = held.inverse_kinematics(&flange).unwrap();
            let rested = rest(&held, &at, &at.drives, |pose| {
                let force = -(pose.rotation * task.load.force);
                Wrench { force, moment: (TIP - pose.translation).cross(&force) }
            });
            let cut = rested.transform(point.position_mm);
            // What the program may be off as it is written.
            assert!((cut - TIP).norm() < 0.0055, "{k}: {}", cut - TIP);
            largest = largest.max((at.pose.transform(point.position_mm) - TIP).norm());
        }
    }
    assert!(largest > 0.1, "{largest}");
    let first = block * nalgebra::Point3::new(0.0, 0.0, 40.0);
    assert!((job.path.points()[0].position_mm - first.coords).norm() < 1e-9);
}

#[test]
fn what_a_standing_tool_cannot_be_is_refused() {
    for (machine, more, why) in [
        ("irb7600", "[tool]\nstationary = true\n", "expected tip_mm and axis beside it"),
        ("kr500", TOOL, "without_weight = true"),
        ("kr500", "[tool]\nwithout_weight = true\n", "expected stationary = true"),
        ("hexapod", TOOL, "expected a machine of one chain"),
        (
            "irb7600",
            &format!("{TOOL}[[chain_error]]\nchain = \"arm\"\nturn_about_drive_axis_deg = 1.0\n"),
            "no such table",
        ),
    ] {
        let refused = process(machine, more).unwrap_err();
        assert!(refused.contains(why), "{refused}");
    }
    let uncertain = format!("{TOOL}[uncertainty.process]\nforce_relative_std = 0.1\n");
    assert!(process("irb7600", &uncertain).unwrap_err().contains("is not followed with [uncertainty]"));
    assert!(process("kr500", &format!("{TOOL}without_weight = true\n")).is_ok());
    let refused = |name: &str, source: &str, more: &str| {
        let folder = Folder::in_memory([(name.to_owned(), source.as_bytes().to_vec())]);
        let process = process("irb7600", more).unwrap();
        assert_eq!(process.clone().as_programmed("a map").is_err(), !more.is_empty());
        process.program_in_folder(&folder, name).unwrap_err().to_string()
    };
    for (source, more, why) in [
        (RAPID.to_owned(), "", "or stationary = true in [tool] of the process"),
        (RAPID.replace(" fine, drill", " fine, tool0"), TOOL, "expected a tool with robhold FALSE"),
        (RAPID.replace("[FALSE, [[", "[TRUE, [["), TOOL, "expected a tool with robhold FALSE"),
        (RAPID.replace("[TRUE, TRUE", "[FALSE, TRUE"), TOOL, "expected one that the robot holds"),
        (RAPID.replace("PERS wobjdata block", "PERS wobjdata other"), TOOL, "where block stands to the base before it"),
        (RAPID.replace("PERS tooldata drill", "PERS tooldata other"), TOOL, "a tooldata with its numbers"),
        (RAPID.replace("\\WObj:=block", ""), TOOL, "motions in wobj0 with a stationary tool"),
        (RAPID.replace("[[1650,", "[[1651,"), TOOL, "mm of the base"),
    ] {
        let found = refused("part.mod", &source, more);
        assert!(found.contains(why), "{found}");
    }
    let tables = format!("schema = 1\n{}{TOOL}", CUT.replacen("0.0", "30.0", 1));
    let elsewhere = Process::from_toml(&tables, "process", Folder::in_memory([]), &arm()).unwrap();
    let folder = Folder::in_memory([("part.mod".to_owned(), RAPID.as_bytes().to_vec())]);
    let found = elsewhere.program_in_folder(&folder, "part.mod").unwrap_err().to_string();
    assert!(found.contains("says itself where the part is"), "{found}");
    let krl = "DEF part()\n$VEL.CP=0.02\nLIN {X 30,Y 0,Z 0,A 0,B 0,C 0}\nEND\n";
    assert!(refused("part.src", krl, TOOL).contains("KRL is not followed with a stationary tool"));
}
