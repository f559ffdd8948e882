//! Clearance of bodies along paths: against dense samples, with a rod between two samples, and what is said of it.

use std::{fs, path::Path};

use base64::{Engine, engine::general_purpose::STANDARD};
use kinetostat::{
    Folder,
    answer::clearance::nearest_words,
    machine::{Configuration, Machine},
    process::{Process, file::CellFrame},
    simulation::{
        clearance::{ClearanceState, MachineCell, PathClearance},
        tasks::tasks,
        with_drives_left,
    },
    spatial::Pose,
};
use kinetostat_cell::{Body, Cell};
use nalgebra::{Isometry3, Point3};
use proptest::{
    strategy::{Strategy, ValueTree},
    test_runner::TestRunner,
};

use crate::support::command::told;

/// The end of a cutter at the tool tip.
const CUTTER: &str = r#"
[[platform.body]]
name = "cutter"
grade = "given"
shapes = [{ capsule = { from_mm = [90.0, 0.0, 316.0], to_mm = [90.0, 0.0, 319.0], radius_mm = 1.0 } }]
"#;

/// A six-axis arm with a pedestal, a forearm, a wrist, a spindle that points down, and a cutter.
fn arm() -> String {
    without_cutter().replacen("\n[home]", &format!("{CUTTER}\n[home]"), 1)
}

fn without_cutter() -> String {
    let text = include_str!("../machines/kr270.toml");
    let joint = |name: &str, body: &str| {
        let line = text.lines().find(|line| line.contains(&format!("name = \"{name}\""))).unwrap();
        (line.to_owned(), format!("  {{ body = {{ {body} }} }},\n{line}"))
    };
    let [forearm, wrist] = [
        joint(
            "A4",
            r#"name = "forearm", grade = "given", shapes = [{ capsule = { from_mm = [-1100.0, 0.0, 0.0], to_mm = [-400.0, 0.0, 0.0], radius_mm = 180.0 } }]"#,
        ),
        joint(
            "A6",
            r#"name = "wrist", grade = "enclosing", shapes = [{ capsule = { from_mm = [0.0, 0.0, 0.0], to_mm = [60.0, 0.0, 0.0], radius_mm = 140.0 } }]"#,
        ),
    ];
    let bodies = r#"
[[platform.body]]
name = "spindle"
grade = "given"
shapes = [{ cylinder = { from_mm = [0.0, 0.0, 0.0], to_mm = [0.0, 0.0, 230.0], radius_mm = 60.0 } }]

[[body]]
name = "pedestal"
grade = "given"
shapes = [{ cylinder = { from_mm = [0.0, 0.0, 0.0], to_mm = [0.0, 0.0, 300.0], radius_mm = 300.0 } }]

[home]"#;
    text.replace(&forearm.0, &forearm.1).replace(&wrist.0, &wrist.1).replacen("\n[home]", bodies, 1)
}

/// A process with the table `cell` given, its workpiece in front of the arm.
fn process(cell: &str) -> String {
    format!("schema = 1\n[placement]\norigin_mm = [1700.0, 0.0, 500.0]\n[sampling]\nmax_segment_mm = 400.0\n{cell}")
}

/// Two clamps beside the part, and a post on the base.
const CLAMPS: &str = r#"
[cell]
rapid = "joint"
[[cell.body]]
name = "left clamp"
on = "part"
grade = "given"
shapes = [{ box = { size_mm = [40.0, 40.0, 200.0], at_mm = [-170.0, 0.0, 80.0] } }]
[[cell.body]]
name = "right clamp"
on = "part"
grade = "given"
shapes = [{ box = { size_mm = [40.0, 40.0, 200.0], at_mm = [170.0, 20.0, 80.0], rotation_deg = [0.0, 0.0, 30.0] } }]
[[cell.body]]
name = "post"
on = "base"
grade = "given"
shapes = [{ capsule = { from_mm = [1500.0, 350.0, 0.0], to_mm = [1500.0, 350.0, 900.0], radius_mm = 25.0 } }]
"#;

/// A program along a path, and the configurations at its points.
fn follow(process: &Process, program: &str) -> (PathClearance, Vec<Configuration>) {
    let file = process.parse_program(program.as_bytes().to_vec(), Path::new("part.nc")).unwrap();
    let path = process.mark_cutting(file.toolpath(process.sampling).unwrap(), "part.nc").unwrap();
    let process = &with_drives_left(process.clone(), &path, Some(&file), "part.nc").unwrap();
    let tasks = tasks(process, &path, "part.nc").unwrap();
    let cell = MachineCell::new(&process.machine, process.cell.as_ref().unwrap()).unwrap();
    let (mut along, mut at) = (cell.begin(&process.placement), vec![process.machine.home.clone()]);
    for (point, task) in path.points().iter().zip(&tasks) {
        at.push(process.machine.inverse_kinematics_from(&at[at.len() - 1], &task.pose).unwrap());
        along.add(task, at.last(), point.into());
    }
    (along.finish(), at.split_off(1))
}

fn checked(machine: &Machine, cell: &str) -> Process {
    Process::from_toml(&process(cell), "process", Folder::in_memory([]), machine).unwrap_or_else(|e| panic!("{e}"))
}

fn clearance(machine: &Machine, cell: &str, program: &str) -> PathClearance {
    follow(&checked(machine, cell), program).0
}

/// The least distance at many states of the straight moves between configurations, by poses that are solved one by one.
fn sampled(process: &Process, at: &[Configuration], count: usize) -> f64 {
    let machine = &process.machine;
    let own = machine.cell().unwrap();
    let mut bodies: Vec<Body> = machine.bodies().unwrap();
    let frames = machine.frame_count();
    let first = bodies.len();
    bodies.extend(process.cell.as_ref().unwrap().bodies.iter().map(|(on, body)| {
        let mut body = body.clone();
        body.frame = if *on == CellFrame::Part { frames } else { 0 };
        body
    }));
    let across = Cell::new(bodies, |a, b| (a < first) == (b < first));
    let (mut least, mut poses) = (f64::INFINITY, Vec::new());
    for pair in at.windows(2) {
        let mut near = pair[0].clone();
        for k in 0..=count {
            let s = k as f64 / count as f64;
            let tip = |at: &Configuration| at.pose.transform(machine.tool_tip);
            let here = tip(&pair[0]) + (tip(&pair[1]) - tip(&pair[0])) * s;
            let rotation = pair[0].pose.rotation;
            near = machine
                .inverse_kinematics_from(&near, &Pose { rotation, translation: here - rotation * machine.tool_tip })
                .unwrap();
            machine.frame_poses(&near, &mut poses);
            poses.push(Isometry3::translation(1700.0, 0.0, 500.0));
            least =
                least.min(own.nearest(&poses).unwrap().distance_mm).min(across.nearest(&poses).unwrap().distance_mm);
        }
    }
    least
}

#[test]
fn no_state_between_two_points_is_nearer_than_the_bound() {
    let machine = Machine::from_toml(&arm(), "arm").unwrap();
    let process = checked(&machine, CLAMPS);
    let mut runner = TestRunner::deterministic();
    let mut hits = 0;
    for _ in 0..24 {
        let places = proptest::collection::vec(proptest::array::uniform3(0.0f64..1.0), 4)
            .new_tree(&mut runner)
            .unwrap()
            .current();
        let line = |place: &[f64; 3]| {
            format!(
                "G1 X{:.3} Y{:.3} Z{:.3} F1000\n",
                400.0 * place[0] - 200.0,
                400.0 * place[1] - 200.0,
                20.0 + 200.0 * place[2]
            )
        };
        let program = format!("G21 G90\n{}", places.iter().map(line).collect::<String>());
        let (found, at) = follow(&process, &program);
        assert!(found.not_looked_at.is_empty(), "{:?}", found.not_looked_at);
        let (least, sampled) = (found.at_least_mm.unwrap(), sampled(&process, &at, 300));
        // How much deeper bodies go than 5 mm is not looked for.
        assert!(least <= sampled + 1e-6 || least < -5.0, "{program}{least} > {sampled}");
        assert!(least > sampled - 2.0, "{program}{least} < {sampled}");
        hits += usize::from(least < 0.0);
        assert_eq!(found.state == ClearanceState::Hit, least <= 0.0);
    }
    assert!((3..24).contains(&hits), "{hits}");
}

/// A post of 6 mm between two points of a path, 300 mm apart, somewhere in what the spindle sweeps.
#[test]
fn a_rod_between_two_points_is_not_missed() {
    let machine = Machine::from_toml(&arm(), "arm").unwrap();
    let mut runner = TestRunner::deterministic();
    for _ in 0..40 {
        let [along, across, up] = proptest::array::uniform3(0.0f64..1.0).new_tree(&mut runner).unwrap().current();
        // The spindle stands 90 mm beside the tip, from 90 to 320 mm above it.
        let x = -60.0 + 300.0 * along;
        let y = 110.0 * across - 55.0;
        let z = 155.0 + 200.0 * up;
        let cell = format!(
            "[cell]\n[[cell.body]]\nname = \"rod\"\non = \"part\"\ngrade = \"given\"\nshapes = [{{ capsule = {{ from_mm = [{x:?}, {y:?}, {z:?}], to_mm = [{x:?}, {y:?}, {:?}], radius_mm = 3.0 }} }}]\n",
            z + 15.0
        );
        let found = clearance(&machine, &cell, "G21 G90\nG1 X-150 Y0 Z60 F1000\nG1 X150\n");
        let nearest = found.nearest.clone().unwrap();
        assert_eq!(found.state, ClearanceState::Hit, "{cell}{found:?}");
        assert_eq!(nearest.names, ["spindle", "rod"], "{found:?}");
    }
}

#[test]
fn what_is_assumed_or_not_looked_at_clears_nothing() {
    let machine = Machine::from_toml(&arm(), "arm").unwrap();
    let straight = "G21 G90\nG1 X-50 Y0 Z120 F1000\nG1 X50\n";
    let clear = clearance(&machine, CLAMPS, straight);
    assert_eq!(clear.state, ClearanceState::Clear, "{clear:?}");
    let assumed = clearance(&machine, &CLAMPS.replacen("\"given\"", "\"assumed\"", 1), straight);
    assert_eq!((assumed.state, assumed.assumed), (ClearanceState::Unknown, vec!["left clamp".to_owned()]));
    let rapid = "G21 G90\nG0 X-50 Y0 Z120\nG0 X50\n";
    assert_eq!(clearance(&machine, CLAMPS, rapid).state, ClearanceState::Clear);
    for way in ["", "rapid = \"per_axis\""] {
        let found = clearance(&machine, &CLAMPS.replace("rapid = \"joint\"", way), rapid);
        assert_eq!(found.state, ClearanceState::Unknown, "{found:?}");
        assert!(found.not_looked_at[0].starts_with("rapid moves"), "{found:?}");
    }
    let alone = clearance(&Machine::from_toml(&without_cutter(), "arm").unwrap(), CLAMPS, straight);
    assert_eq!(alone.state, ClearanceState::Unknown, "{alone:?}");
    assert!(alone.not_looked_at[0].starts_with("the cutter: no body reaches the tool tip"), "{alone:?}");
    // What is on the tool, or on the last link, may be the cutter.
    let on_tool = format!("{CLAMPS}{}", post("cutter", "tool", [0.0, 0.0, -60.0, 0.0, 2.0]));
    let told = clearance(&Machine::from_toml(&without_cutter(), "arm").unwrap(), &on_tool, straight);
    assert_eq!((told.state, told.not_looked_at), (ClearanceState::Clear, vec![]));
    let (machine, mut poses) = (Machine::from_toml(&without_cutter(), "arm").unwrap(), Vec::new());
    machine.frame_poses(&machine.home, &mut poses);
    let wrist = machine.bodies().unwrap().into_iter().find(|own| own.name == "wrist").unwrap();
    let tip: [f64; 3] = poses[wrist.frame].inverse_transform_point(&(poses[1] * Point3::from(machine.tool_tip))).into();
    let shape = "radius_mm = 140.0 } }";
    let tip = format!("{shape}, {{ capsule = {{ from_mm = {tip:?}, to_mm = {tip:?}, radius_mm = 2.0 }} }}");
    let on_link = without_cutter().replace(shape, &tip);
    let told = clearance(&Machine::from_toml(&on_link, "arm").unwrap(), CLAMPS, straight);
    assert!(told.not_looked_at.is_empty(), "{told:?}");
    // More room is wanted than there is.
    let least = clear.at_least_mm.unwrap();
    let wanted = CLAMPS.replace("[cell]", &format!("[cell]\nclearance_mm = {:?}", least + 5.0));
    assert_eq!(clearance(&machine, &wanted, straight).state, ClearanceState::Hit);
}

/// A body of the cell made of one capsule, with its axis along z of its frame.
fn post(name: &str, on: &str, [x, y, low, high, radius]: [f64; 5]) -> String {
    format!(
        "[[cell.body]]\nname = \"{name}\"\non = \"{on}\"\ngrade = \"given\"\nshapes = [{{ capsule = {{ from_mm = [{x:?}, {y:?}, {low:?}], to_mm = [{x:?}, \
         {y:?}, {high:?}], radius_mm = {radius:?} }} }}]\n"
    )
}

#[test]
fn a_holder_hits_what_clamps_the_part() {
    let machine = Machine::from_toml(&arm(), "arm").unwrap();
    let clamp = post("clamp", "part", [-100.0, 0.0, 0.0, 60.0, 15.0]);
    // The tool frame has its origin at the tip and z towards it.
    let holder = post("holder", "tool", [0.0, 0.0, -140.0, -60.0, 30.0]);
    let program = "G21 G90\nG1 X-200 Y0 Z5 F1000\nG1 X100\n";
    let found = clearance(&machine, &format!("[cell]\n{clamp}{holder}"), program);
    assert_eq!(found.state, ClearanceState::Hit, "{found:?}");
    assert_eq!(found.nearest.unwrap().names, ["clamp", "holder"]);
}

/// The arm with its tool, which the process describes, along z of P, which points down at home.
fn upright() -> String {
    without_cutter()
        .replace("tool_tip_mm = [90.0, 0.0, 320.0]", "tool_tip_mm = [90.0, 0.0, 320.0]\ntool_axis = [0.0, 0.0, 1.0]")
}

/// A process that cuts a stock of 120 x 40 x 20 mm with tool 1, and a clamp.
fn cut(tool: &str, clamp: [f64; 5]) -> String {
    let stock = "[force.end_milling]\nmaterial = \"Al 7075-T6\"\n[stock]\nbox = { min_mm = [-60.0, -20.0, -20.0], max_mm = [60.0, 20.0, 0.0] }";
    let tool = format!("[tools.1]\ndiameter_mm = 10.0\nteeth = 2\n{tool}\n[tools.2]\ndiameter_mm = 12.0\nteeth = 2\n");
    let cell = format!("[cell]\nrapid = \"joint\"\n{}", post("clamp", "part", clamp));
    process(&format!("{stock}\n{tool}{cell}")).replace("max_segment_mm = 400.0", "max_segment_mm = 5.0")
}

/// A line through the stock, 2 mm deep.
const CUT: &str = "G21 G90\nT1 M6\nS8000 M3\nG1 X-90 Y0 Z-2 F1000\nG1 X90\nM30\n";
const SHANK: &str = "shank = { diameter_mm = 12.0, from_mm = 25.0 }\n";
const HOLDER: &str = "holder = { diameter_mm = 60.0, from_mm = 40.0 }\n";

fn clearance_of_cut(tool: &str, clamp: [f64; 5], program: &str) -> PathClearance {
    let machine = Machine::from_toml(&upright(), "arm").unwrap();
    let process = Process::from_toml(&cut(tool, clamp), "process", Folder::in_memory([]), &machine);
    follow(&process.unwrap_or_else(|e| panic!("{e}")), program).0
}

#[test]
fn shank_and_holder_of_the_tool_table_are_bodies_on_the_tool() {
    // Beside the stock: as high as the holder, as high as the shank, and in the way of the cutter.
    let [beside, near, ahead] =
        [[0.0, 40.0, 0.0, 60.0, 15.0], [0.0, 40.0, 0.0, 20.0, 15.0], [85.0, 0.0, -20.0, 0.0, 5.0]];
    let both = format!("{SHANK}{HOLDER}");
    let hit = clearance_of_cut(&both, beside, CUT);
    assert_eq!(hit.state, ClearanceState::Hit, "{hit:?}");
    assert_eq!(hit.nearest.unwrap().names, ["clamp", "holder of tool 1"]);
    // What is wide and enclosing is the wrist alone; the cut holds the tool against the stock, so that nothing is left out.
    let clear = clearance_of_cut(&both, near, CUT);
    assert_eq!((clear.state, clear.not_looked_at), (ClearanceState::Clear, vec![]));
    // What holds the shank is not known, whether it is said how far it sticks out or not.
    for bends in ["", "stick_out_mm = 30.0\nhelix_deg = 30.0\nyoungs_modulus_N_per_mm2 = 600000.0\n"] {
        let open = clearance_of_cut(&format!("{bends}{SHANK}"), near, CUT);
        assert_eq!(
            (open.state, open.assumed),
            (ClearanceState::Unknown, vec!["holder of tool 1".to_owned()]),
            "{bends}"
        );
    }
    let cutter = clearance_of_cut(SHANK, ahead, CUT);
    assert_eq!(
        (cutter.state, cutter.nearest.unwrap().names),
        (ClearanceState::Hit, ["clamp", "tool 1"].map(String::from))
    );
    // Without shank and holder no end of the cutter is known: it may hit, and clears nothing.
    let alone = |clamp| clearance_of_cut("", clamp, CUT);
    assert_eq!(alone(ahead).state, ClearanceState::Hit);
    assert_eq!((alone(near).state, alone(near).assumed), (ClearanceState::Unknown, vec!["tool 1".to_owned()]));
    // As is a holder that begins beyond P, up to which the shank goes.
    let beyond = "holder = { diameter_mm = 600.0, from_mm = 330.0 }\n";
    let found = clearance_of_cut(&format!("{SHANK}{beyond}"), beside, CUT);
    assert_eq!((found.state, found.assumed), (ClearanceState::Unknown, vec!["holder of tool 1".to_owned()]));
    // The first tool is looked at alone.
    let second = clearance_of_cut(&both, near, &CUT.replace("M30", "T2 M6\nG1 X-90"));
    assert_eq!(second.state, ClearanceState::Unknown);
    assert!(second.not_looked_at[0].starts_with("ways of other tools than the first"), "{second:?}");
    // Whose way is not looked at, nor its ends with the first tool, which would hit.
    let narrow = CUT.replace("T1 M6", "T1 M6\nG1 X-90 Y-80 Z80 F1000\nT2 M6");
    let narrow = clearance_of_cut(&both, [-90.0, 30.0, 0.0, 60.0, 15.0], &narrow);
    assert_eq!(narrow.state, ClearanceState::Unknown, "{narrow:?}");
    let other = clearance_of_cut(&both, beside, &CUT.replace("T1", "T2"));
    assert_eq!((other.state, other.assumed), (ClearanceState::Unknown, vec!["tool 2".to_owned()]));
}

#[test]
fn a_part_that_stands_in_its_table_is_told() {
    let table = |top: f64| post("table", "table", [1700.0, 0.0, 0.0, top - 20.0, 20.0]);
    let told = |top: f64| {
        let cell = format!("[cell]\n{}{}", table(top), post("vice", "part", [0.0, 0.0, 20.0, 40.0, 20.0]));
        clearance(&Machine::from_toml(&arm(), "arm").unwrap(), &cell, "G21 G90\nG1 X-50 Y0 Z120 F1000\nG1 X50\n")
    };
    let (free, stands) = (told(499.0), told(508.0));
    assert_eq!((free.state, free.nearest.as_ref().unwrap().point.is_some()), (ClearanceState::Clear, true), "{free:?}");
    assert_eq!((stands.state, stands.nearest.as_ref().unwrap().point), (ClearanceState::Hit, None));
    let text = stands.hit_text(|_| "on the way".into()).unwrap();
    let way_out = "if they may, may_touch = [[\"table\", \"vice\"]] of [cell] says so";
    assert_eq!(text, format!("table and vice overlap by 8.0 mm where the workpiece is put; {way_out}"));
}

#[test]
fn a_hit_of_assumed_shapes_hides_no_certain_one() {
    let machine = Machine::from_toml(&arm(), "arm").unwrap();
    let program = "G21 G90\nG1 X-200 Y0 Z120 F1000\nG1 X200\n";
    let deep = post("deep", "part", [-60.0, 0.0, 0.0, 180.0, 30.0]).replace("\"given\"", "\"assumed\"");
    let less = |x: f64| post("less", "part", [x, 0.0, 0.0, 121.0, 5.0]);
    for x in [60.0, -60.0, -120.0] {
        let found = clearance(&machine, &format!("[cell]\n{deep}{}", less(x)), program);
        let nearest = found.nearest.unwrap();
        assert_eq!((found.state, nearest.is_assumed), (ClearanceState::Hit, false), "{x} {:?}", nearest.names);
        assert!(nearest.names.contains(&"less".to_owned()));
    }
    let found = clearance(&machine, &format!("[cell]\n{deep}"), program);
    assert_eq!((found.state, found.nearest.unwrap().is_assumed), (ClearanceState::Hit, true));
    // Nor does one that is only too near hide one that overlaps, whichever is certain; the least distance is of both.
    let wanted = "[cell]\nclearance_mm = 60.0\n";
    let beside = |name: &str, x: f64| post(name, "part", [x, 95.0, 0.0, 180.0, 5.0]);
    let assumed = |body: String| body.replace("\"given\"", "\"assumed\"");
    for (near, hit) in [
        (beside("near", -60.0), deep.clone()),
        (assumed(beside("near", -60.0)), deep.replace("\"assumed\"", "\"given\"")),
        (assumed(beside("near", -60.0)), deep.clone()),
    ] {
        let found = clearance(&machine, &format!("{wanted}{near}{hit}"), program);
        let nearest = found.nearest.as_ref().unwrap();
        assert!(nearest.names.contains(&"deep".to_owned()) && found.at_least_mm.unwrap() < -1.0, "{:?}", nearest.names);
    }
    // And a part that stands in its table does not hide what is hit on the path.
    let table = |depth: f64| post("table", "table", [1700.0, 0.0, 0.0, 480.0 + depth, 20.0]);
    let vice = post("vice", "part", [0.0, 0.0, 20.0, 40.0, 20.0]);
    let found = clearance(&machine, &format!("[cell]\n{}{vice}{}", table(0.2), less(60.0)), program);
    let text = found.hit_text(|_| "on the way".into()).unwrap();
    assert!(text.contains("table and vice overlap") && text.contains("less overlap by"), "{text}");
    assert_eq!((found.also.len(), found.also.iter().filter(|own| own.point.is_none()).count()), (1, 1), "{text}");
    // Each is told by its own depth, also where another is deeper.
    let ghost = assumed(post("ghost", "base", [1700.0, 0.0, 0.0, 500.0, 20.0]));
    let found = clearance(&machine, &format!("[cell]\n{}{ghost}{vice}", table(0.2)), program);
    let words = nearest_words(&found).unwrap();
    assert!(
        words.contains("table and vice overlap by 0.2 mm") && found.at_least_mm.unwrap() < -1.0,
        "{words} {found:?}"
    );
}

#[test]
fn a_tool_of_a_comment_is_a_name() {
    let machine = Machine::from_toml(&upright(), "arm").unwrap();
    let beside = [0.0, 40.0, 0.0, 60.0, 15.0];
    let process = |text: &str| Process::from_toml(text, "process", Folder::in_memory([]), &machine);
    let listed =
        |name: &str| cut(HOLDER, beside).replace("[cell]", &format!("[cell]\nmay_touch = [[\"clamp\", \"{name}\"]]"));
    assert!(process(&listed("tool 7")).is_ok() && process(&listed("shank of tool 7")).is_ok());
    for other in ["tool seven", "tool 07", "tool +7", "neck of tool 7"] {
        let said = process(&listed(other)).unwrap_err().to_string();
        assert!(
            said.contains(&format!("no body is called \"{other}\"")) && said.contains("holder of tool N"),
            "{said}"
        );
    }
    let taken = process(&cut(HOLDER, beside).replace("\"clamp\"", "\"tool 7\"")).unwrap_err().to_string();
    assert!(taken.contains("\"tool 7\" is the name of the stock or of a tool"), "{taken}");
}

#[test]
fn noses_of_cutters_are_balls_or_enclosed() {
    let machine = Machine::from_toml(&upright(), "arm").unwrap();
    let grades = |shape: &str| {
        let text = cut(&format!("shape = {shape}\n{HOLDER}"), [0.0, 40.0, 0.0, 20.0, 15.0]);
        let process = Process::from_toml(&text, "process", Folder::in_memory([]), &machine).unwrap();
        let file = process.parse_program(CUT.as_bytes().to_vec(), Path::new("part.nc")).unwrap();
        let path = process.mark_cutting(file.toolpath(process.sampling).unwrap(), "part.nc").unwrap();
        let process = with_drives_left(process, &path, Some(&file), "part.nc").unwrap();
        let own = process.cell.unwrap();
        let bodies = own.bodies[own.before_tool..].iter().map(|(_, body)| (body.name.clone(), body.grade, body.ball()));
        bodies.collect::<Vec<_>>()
    };
    let [flat, ball] = ["\"flat\"", "\"ball\""].map(grades);
    assert_eq!(flat.iter().map(|own| own.0.as_str()).collect::<Vec<_>>(), ["tool 1", "holder of tool 1"]);
    assert!(flat.iter().chain(&ball).all(|own| own.1 == kinetostat_cell::BodyGrade::Given));
    // From the holder's begin to P, 320 mm above the tip.
    assert!((flat[1].2.0.z + 180.0).abs() < 1e-9, "{flat:?}");
    let bull = grades("\"bull_nose\"\ncorner_radius_mm = 2.0");
    assert_eq!(bull[0].1, kinetostat_cell::BodyGrade::Enclosing);
}

#[test]
fn bodies_of_the_tool_table_are_named_as_they_are_told() {
    let machine = Machine::from_toml(&upright(), "arm").unwrap();
    let beside = [0.0, 40.0, 0.0, 60.0, 15.0];
    let listed = "[cell]\nmay_touch = [[\"clamp\", \"holder of tool 1\"]]";
    let process = |text: String| Process::from_toml(&text, "process", Folder::in_memory([]), &machine);
    let allowed = process(cut(HOLDER, beside).replace("[cell]", listed)).unwrap();
    assert_eq!(follow(&allowed, CUT).0.state, ClearanceState::Clear);
    let taken = process(cut(HOLDER, beside).replace("\"clamp\"", "\"holder of tool 1\"")).unwrap_err().to_string();
    assert!(taken.contains("\"holder of tool 1\" is the name of the stock or of a tool"), "{taken}");
    let machine = Machine::from_toml(&upright().replace("\"spindle\"", "\"tool 1\""), "arm").unwrap();
    let taken = Process::from_toml(&cut(HOLDER, beside), "process", Folder::in_memory([]), &machine).unwrap_err();
    assert!(taken.to_string().contains("has a body \"tool 1\", the name of the stock or its tool"), "{taken}");
}

#[test]
fn a_holder_that_hits_a_clamp_is_told_first() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let (machine, program) = (file("arm.toml", &upright()), file("part.nc", CUT));
    let out = folder.path().join("out.nc").to_str().unwrap().to_owned();
    for (tool, hits) in [(format!("{SHANK}{HOLDER}"), true), (SHANK.to_owned(), false)] {
        let process = file("process.toml", &cut(&tool, [0.0, 40.0, 0.0, 60.0, 15.0]));
        let arguments =
            ["compensate", &program, "--machine", &machine, "--process", &process, "--out", &out, "--force"];
        let (ended, said, error) = told(&arguments);
        assert_eq!(ended == Some(1), hits, "{said}{error}");
        let first = said.lines().next().unwrap_or_default();
        assert_eq!(first.contains("clamp hits holder of tool 1"), hits, "{said}{error}");
    }
}

#[test]
fn what_stands_on_the_base_is_held_against_the_first_link() {
    let line = arm().lines().find(|line| line.contains("name = \"A2\"")).unwrap().to_owned();
    let motor = "  { body = { name = \"motor\", grade = \"given\", shapes = [{ capsule = { from_mm = [600.0, 0.0, 0.0], to_mm = [600.0, 0.0, 50.0], \
                 radius_mm = 100.0 } }] } },\n";
    let machine = Machine::from_toml(&arm().replace(&line, &format!("{motor}{line}")), "arm").unwrap();
    let at_home = machine.bodies().unwrap().iter().position(|body| body.name == "motor").unwrap();
    let mut poses = Vec::new();
    machine.frame_poses(&machine.home, &mut poses);
    let centre = poses[machine.bodies().unwrap()[at_home].frame] * nalgebra::Point3::new(600.0, 0.0, 25.0);
    // Beside where it stands at home, where the arm turns to.
    let (angle, radius) = (centre.y.atan2(centre.x) + 0.2, centre.coords.xy().norm());
    let column = post("column", "base", [radius * angle.cos(), radius * angle.sin(), 0.0, centre.z + 200.0, 40.0]);
    let found = clearance(&machine, &format!("[cell]\n{column}"), "G21 G90\nG1 X0 Y-300 Z60 F1000\nG1 Y600\n");
    assert_eq!(found.state, ClearanceState::Hit, "{found:?}");
    assert_eq!(found.nearest.unwrap().names, ["motor", "column"]);
}

#[test]
fn a_way_that_the_program_does_not_say_clears_nothing() {
    let machine = Machine::from_toml(&arm(), "arm").unwrap();
    let way = "G21 G90\nG1 X-50 Y0 Z120 F1000\nG28 Z0\nG1 X0 Y0\nG1 Z120\nG1 X50\n";
    let found = clearance(&machine, CLAMPS, way);
    assert_eq!(found.state, ClearanceState::Unknown, "{found:?}");
    assert!(found.not_looked_at[0].contains("start the program does not say"), "{found:?}");
    // Where it ends is looked at all the same: it may hit.
    let into = "G21 G90\nG1 X-50 Y0 Z120 F1000\nG28 Z0\nG1 X-260 Y0\nG1 Z20\n";
    assert_eq!(clearance(&machine, CLAMPS, into).state, ClearanceState::Hit);
    let per_axis = CLAMPS.replace("\"joint\"", "\"per_axis\"");
    assert_eq!(clearance(&machine, &per_axis, "G21 G90\nG0 X-50 Y0 Z120\nG0 X-260 Z20\n").state, ClearanceState::Hit);
    let tools = clearance(&machine, CLAMPS, "G21 G90\nT1 M6\nG1 X-50 Y0 Z120 F1000\nG1 X50\nT2 M6\nG1 X0\n");
    assert_eq!(tools.state, ClearanceState::Unknown, "{tools:?}");
}

#[test]
fn deflection_that_may_close_the_gap_clears_nothing() {
    let machine = Machine::from_toml(&arm(), "arm").unwrap();
    let clear = clearance(&machine, CLAMPS, "G21 G90\nG1 X-50 Y0 Z120 F1000\nG1 X50\n");
    let least = clear.at_least_mm.unwrap();
    assert_eq!(clear.clone().moved_by(0.5 * least).state, ClearanceState::Clear);
    assert_eq!(clear.moved_by(1.5 * least).state, ClearanceState::Unknown);
}

#[test]
fn a_mesh_of_the_machine_is_among_what_was_read() {
    let folder = tempfile::tempdir().unwrap();
    let inputs = |size: f64| {
        fs::write(folder.path().join("post.stl"), cube(size)).unwrap();
        let with_mesh = arm().replacen(
            "\n[home]",
            "\n[[body]]\nname = \"column\"\nshapes = [{ mesh = { file = \"post.stl\" } }]\n\n[home]",
            1,
        );
        let path = folder.path().join("arm.toml");
        fs::write(&path, with_mesh).unwrap();
        checked(&Machine::from_file(&path).unwrap(), CLAMPS).inputs
    };
    let (small, large) = (inputs(100.0), inputs(110.0));
    assert_ne!(format!("{small:?}"), format!("{large:?}"));
    assert!(format!("{small:?}").contains("post.stl"));
}

/// A cube with a corner at the origin, as an ASCII STL file.
pub(crate) fn cube(size: f64) -> String {
    let corner = |k: usize| [k & 1, k >> 1 & 1, k >> 2].map(|bit| bit as f64 * size);
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangle = |[a, b, c]: [usize; 3]| {
        let vertex = |k: usize| {
            let [x, y, z] = corner(k);
            format!("vertex {x} {y} {z}\n")
        };
        format!("facet normal 0 0 0\nouter loop\n{}{}{}endloop\nendfacet\n", vertex(a), vertex(b), vertex(c))
    };
    let faces = faces.iter().flat_map(|&[a, b, c, d]| [triangle([a, b, c]), triangle([a, c, d])]);
    format!("solid cube\n{}endsolid cube\n", faces.collect::<String>())
}

#[test]
fn bodies_that_overlap_at_home_are_named() {
    let text = arm()
        .replace("radius_mm = 300.0", "radius_mm = 900.0")
        .replace("to_mm = [0.0, 0.0, 300.0]", "to_mm = [0.0, 0.0, 1900.0]");
    let machine = Machine::from_toml(&text, "arm").unwrap();
    let process = checked(&machine, CLAMPS);
    let cell = process.cell.as_ref().unwrap();
    let said = MachineCell::new(&process.machine, cell).unwrap_err().to_string();
    assert!(said.contains("process: cell.may_touch: pedestal and forearm overlap by"), "{said}");
    let allowed = text.replace("title = ", "may_touch = [[\"pedestal\", \"forearm\"]]\ntitle = ");
    let machine = Machine::from_toml(&allowed, "arm").unwrap();
    assert!(MachineCell::new(&machine, cell).is_ok());
}

#[test]
fn a_program_that_hits_something_says_so_first() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let machine = file("arm.toml", &arm());
    let process = file("process.toml", &process(CLAMPS));
    let out = folder.path().join("out.nc").to_str().unwrap().to_owned();
    for (z, code, expected) in [(60.0, Some(1), "hits left clamp"), (200.0, Some(0), "Bodies stay at least")] {
        let program = file("part.nc", &format!("G21 G90\nG1 X-250 Y0 Z{z} F1000\nG1 X100\nM30\n"));
        let arguments =
            ["compensate", &program, "--machine", &machine, "--process", &process, "--out", &out, "--force"];
        let (ended, said, error) = told(&arguments);
        assert_eq!(ended, code, "{said}{error}");
        let names_first = said.find("spindle and left clamp overlap").or(said.find(expected));
        assert!(names_first.is_some(), "{said}");
        let report = fs::read_to_string(format!("{out}.report.json")).unwrap();
        assert!(report.contains("\"clearance\""), "{report}");
        // What is hit is seen first.
        let page = fs::read_to_string(format!("{out}.html")).unwrap();
        let first = page.split("data:image/svg+xml;base64,").nth(1).unwrap().split('"').next().unwrap();
        let first = String::from_utf8(STANDARD.decode(first).unwrap()).unwrap();
        assert_eq!(first.contains("least distance of bodies"), code == Some(1));
    }
}

#[test]
fn what_no_place_mends_is_told_of_all_places() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    file("arm.toml", &upright());
    file("part.nc", CUT);
    // The box of the workspace, too, bars places; but what the clamp is in the way of comes first, as nothing else helps there.
    file(
        "study.toml",
        "schema = 3\nquestion = \"Where?\"\nmachine = \"arm.toml\"\nprocess = \"process.toml\"\n\
         [[placement.feature]]\nname = \"part\"\nfile = \"part.nc\"\ntolerance_mm = 1.0\n\
         [placement.bounds]\nx_mm = [1700.0, 9700.0]\n[placement.fixed]\ny_mm = 0.0\nz_mm = 500.0\n\
         [placement.objective]\nweights = { worst_deflection = 1.0 }\n\
         [placement.search]\ngrid = { x = 5 }\nstarts = 1\nmax_iterations = 10\n",
    );
    let both = format!("{SHANK}{HOLDER}");
    let answer = |y_mm: f64| {
        file("process.toml", &cut(&both, [0.0, y_mm, 0.0, 60.0, 15.0]));
        told(&["run", &path("study.toml"), "--out", &path(&format!("out{y_mm}"))])
    };
    let (ended, said, error) = answer(40.0);
    assert!(ended == Some(1) && said.contains("No place can be cut"), "{ended:?} {said}{error}");
    let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(said.contains("At 5 of them") && said.contains("clamp and holder of tool 1 overlap by 5.0 mm"), "{said}");
    // 40 mm from the line, the clamp of 15 mm radius is 5 mm into the holder of 30, and 5 mm out of it at 50.
    let (ended, said, error) = answer(50.0);
    assert!(ended == Some(0), "{ended:?} {said}{error}");
}

#[test]
fn a_place_may_be_sought_where_bodies_stay_farthest_apart() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    let around = format!("[cell]\nrapid = \"joint\"\n{}", post("post", "base", [1700.0, 130.0, 0.0, 900.0, 25.0]));
    let cell =
        format!("[force.path_frame]\nradial_force_N = 50.0\ntangential_force_N = 50.0\naxial_force_N = 50.0\n{around}");
    let program = "G21 G90\nG1 X-100 Y0 Z160 F1000\nG1 X100\nM30\n";
    file("arm.toml", &arm());
    file("process.toml", &process(&cell));
    file("part.nc", program);
    let study = |objective: &str| {
        format!(
            "schema = 3\nquestion = \"Where?\"\nmachine = \"arm.toml\"\nprocess = \"process.toml\"\n\
             [[placement.feature]]\nname = \"part\"\nfile = \"part.nc\"\ntolerance_mm = 1.0\n\
             [placement.bounds]\ny_mm = [-20.0, 20.0]\n[placement.fixed]\nx_mm = 1700.0\nz_mm = 500.0\n\
             [placement.objective]\nweights = {{ {objective} = 1.0 }}\n\
             [placement.search]\ngrid = {{ y = 3 }}\nstarts = 1\nmax_iterations = 10\n\
             [[placement.candidate]]\nname = \"today\"\norigin_mm = [1700.0, 0.0, 500.0]\n"
        )
    };
    file("study.toml", &study("least_clearance"));
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (ended, said, error) = told(&["run", &path("study.toml"), "--out", &path("out")]);
    assert_eq!(ended, Some(0), "{said}{error}");
    let table = fs::read_to_string(folder.path().join("out/candidates.csv")).unwrap();
    let mut rows = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let column = rows.next().unwrap().iter().position(|name| *name == "least_clearance_mm").unwrap();
    let values: Vec<(String, f64)> = rows.map(|row| (row.concat(), row[column].parse().unwrap_or(f64::NAN))).collect();
    let today = values.iter().find(|(row, _)| row.contains("today")).unwrap_or_else(|| panic!("{table}")).1;
    let best = values.iter().map(|(_, value)| *value).fold(0.0, f64::max);
    // Where it is clamped within its allowance: no nearer than by 1 mm along x and y, and by half a degree at the clamps.
    let machine = Machine::from_toml(&arm(), "arm.toml").unwrap();
    let exactly = clearance(&machine, &around, program).at_least_mm.unwrap();
    assert!((exactly - 6.0..=exactly + 0.1).contains(&today), "{today} {exactly}");
    assert!(best > today + 5.0, "{table}");
    let figure = fs::read_to_string(folder.path().join("out/clearance.svg")).unwrap();
    assert!(figure.contains("Where bodies come nearest"), "{figure}");
    // What is said of the best place is so wherever it is clamped.
    let said_mm =
        said.split("Bodies stay at least ").nth(1).unwrap().split(' ').next().unwrap().parse::<f64>().unwrap();
    assert!((best - 0.3..=best + 0.05).contains(&said_mm), "{said}{table}");
    file("arm.toml", &arm().replace("grade = \"enclosing\"", "grade = \"assumed\""));
    let (ended, _, error) = told(&["run", &path("study.toml"), "--out", &path("assumed")]);
    assert!(ended == Some(2) && error.contains("the shape of wrist is assumed"), "{error}");
    file(
        "nocell.toml",
        &process("[force.path_frame]\nradial_force_N = 50.0\ntangential_force_N = 50.0\naxial_force_N = 50.0\n"),
    );
    file("study.toml", &study("least_clearance").replace("process.toml", "nocell.toml"));
    let (ended, _, error) = told(&["run", &path("study.toml"), "--out", &path("other")]);
    assert!(ended == Some(2) && error.contains("needs the table [cell]"), "{error}");
}
