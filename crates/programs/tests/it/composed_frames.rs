//! Poses composed in robot programs, against plain 4×4 matrices that share no code with the readers; and what is too deep or too long.

use std::f64::consts::PI;

use kinetostat_programs::{
    NumberFormat, Orientation, Sampling, WriteOptions,
    gcode::{Dialect, GcodeOptions, GcodeProgram},
    robot::{Language, RobotOptions, RobotProgram},
};
use nalgebra::Isometry3;

type Matrix = [[f64; 4]; 4];

const ONE: Matrix = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

fn times(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..4).map(|k| a[i][k] * b[k][j]).sum()))
}

fn inverse(a: &Matrix) -> Matrix {
    let mut out = ONE;
    for i in 0..3 {
        out[i][..3].copy_from_slice(&std::array::from_fn::<_, 3, _>(|j| a[j][i]));
        out[i][3] = -(0..3).map(|j| a[j][i] * a[j][3]).sum::<f64>();
    }
    out
}

/// About x, y or z by this angle, rad.
fn about(axis: usize, angle: f64) -> Matrix {
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut out = ONE;
    (out[i][i], out[j][j], out[i][j], out[j][i]) = (angle.cos(), angle.cos(), -angle.sin(), angle.sin());
    out
}

fn at(place: [f64; 3]) -> Matrix {
    let mut out = ONE;
    (0..3).for_each(|axis| out[axis][3] = place[axis]);
    out
}

/// By Rodrigues' formula, of the vector about which it turns by its length, rad.
fn rodrigues(v: [f64; 3]) -> Matrix {
    let angle = v.iter().map(|c| c * c).sum::<f64>().sqrt();
    let k = v.map(|c| if angle > 0.0 { c / angle } else { 0.0 });
    let cross = [[0.0, -k[2], k[1]], [k[2], 0.0, -k[0]], [-k[1], k[0], 0.0]];
    let mut out = ONE;
    for i in 0..3 {
        for j in 0..3 {
            let square: f64 = (0..3).map(|m| cross[i][m] * cross[m][j]).sum();
            out[i][j] += angle.sin() * cross[i][j] + (1.0 - angle.cos()) * square;
        }
    }
    out
}

fn of_quaternion([w, x, y, z]: [f64; 4]) -> Matrix {
    let mut out = ONE;
    out[0][..3].copy_from_slice(&[1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)]);
    out[1][..3].copy_from_slice(&[2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)]);
    out[2][..3].copy_from_slice(&[2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)]);
    out
}

/// Numbers from 0 to 1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f64 / (1u64 << 24) as f64
    }

    fn three(&mut self, most: f64) -> [f64; 3] {
        std::array::from_fn(|_| ((self.next() * 2.0 - 1.0) * most * 1e4).round() / 1e4)
    }
}

/// The world is W.
fn in_world() -> RobotOptions {
    let mut options = RobotOptions::default();
    options.bases.insert(RobotOptions::WORLD.to_owned(), Isometry3::identity());
    options
}

/// Ends of the motions of a program, and how the tool stands there.
fn ends(program: &RobotProgram) -> Vec<Matrix> {
    let path = program.toolpath(Sampling::new(1e4, 1e4).unwrap().with_max_turn(9.0).unwrap()).unwrap();
    let matrix = |k: usize| {
        let point = &path.points()[k];
        let Some(Orientation::Platform(rotation)) = point.orientation else { panic!("no orientation") };
        let (turned, mut out) = (rotation.to_rotation_matrix(), at(point.position_mm.into()));
        (0..9).for_each(|entry| out[entry / 3][entry % 3] = turned[(entry / 3, entry % 3)]);
        out
    };
    (0..path.len()).map(matrix).collect()
}

fn is_same(a: &Matrix, b: &Matrix, within_mm: f64, text: &str) {
    for i in 0..3 {
        for j in 0..4 {
            let within = if j == 3 { within_mm } else { 1e-6 };
            assert!((a[i][j] - b[i][j]).abs() < within, "{i} {j}: {} {}\n{text}", a[i][j], b[i][j]);
        }
    }
}

/// The program with all its points moved by (0.3, -0.2, 0.1) mm, as text.
fn moved(program: &RobotProgram) -> String {
    let path = program.toolpath(Sampling::new(1e4, 1e4).unwrap().with_max_turn(9.0).unwrap()).unwrap();
    let goals: Vec<_> = path.positions_mm().iter().map(|p| p + nalgebra::Vector3::new(0.3, -0.2, 0.1)).collect();
    let written =
        program.rewrite(&path, &goals, None, WriteOptions::with_decimals(NumberFormat::new(4, 4).unwrap())).unwrap();
    String::from_utf8(written.bytes().to_vec()).unwrap()
}

/// A pose in URScript: `p[…]`, or poses in functions up to `depth` deep.
fn script_pose(random: &mut Random, depth: usize) -> String {
    match (random.next() * 4.0) as usize {
        0 if depth > 0 => format!("pose_inv({})", script_pose(random, depth - 1)),
        1 | 2 if depth > 0 => {
            format!("pose_trans({}, {})", script_pose(random, depth - 1), script_pose(random, depth - 1))
        }
        _ => {
            let ([x, y, z], [a, b, c]) = (random.three(0.3), random.three(1.5));
            format!("p[{x},{y},{z},{a},{b},{c}]")
        }
    }
}

/// What a pose of URScript is, mm; returns what stands behind it.
fn script_value(text: &str) -> (Matrix, &str) {
    let text = text.trim_start();
    if let Some(rest) = text.strip_prefix("pose_inv(") {
        let (value, rest) = script_value(rest);
        return (inverse(&value), rest.trim_start().strip_prefix(')').unwrap());
    }
    if let Some(rest) = text.strip_prefix("pose_trans(") {
        let (first, rest) = script_value(rest);
        let (second, rest) = script_value(rest.trim_start().strip_prefix(',').unwrap());
        return (times(&first, &second), rest.trim_start().strip_prefix(')').unwrap());
    }
    let (numbers, rest) = text.strip_prefix("p[").unwrap().split_once(']').unwrap();
    let n: Vec<f64> = numbers.split(',').map(|number| number.trim().parse().unwrap()).collect();
    (times(&at([n[0] * 1e3, n[1] * 1e3, n[2] * 1e3]), &rodrigues([n[3], n[4], n[5]])), rest)
}

#[test]
fn nested_pose_trans_leads_where_matrices_say() {
    let mut random = Random(1);
    for case in 0..150 {
        let mut target = script_pose(&mut random, 0);
        for _ in 0..case % 7 {
            target = format!("pose_trans({},{target})", script_pose(&mut random, 5));
        }
        let source = format!("def prog():\n  movel(p[0,0,0,0,0,0], v=0.1)\n  movel({target}, a=1.2, v=0.05)\nend\n");
        let program =
            RobotProgram::parse(source.clone(), "p.script", Language::UrScript, None, &in_world()).expect(&source);
        let expected = script_value(&target).0;
        is_same(&ends(&program)[1], &expected, 1e-6, &source);
        let written = moved(&program);
        let line = written.lines().nth(2).unwrap();
        let mut goal = expected;
        [0.3, -0.2, 0.1].iter().zip(0..).for_each(|(by, axis): (_, usize)| goal[axis][3] += by);
        is_same(&script_value(line.trim().strip_prefix("movel(").unwrap()).0, &goal, 2e-4, &written);
    }
}

#[test]
fn what_stands_around_a_pose_is_followed_in_full_or_refused() {
    let program = |line: &str| {
        let source = format!("def prog():\n  f=p[0,0,0.1,0,0,1]\n  movel(p[0,0,0,0,0,0], v=0.1)\n  {line}\nend\n");
        RobotProgram::parse(source, "p.script", Language::UrScript, None, &in_world())
            .map_err(|error| error.to_string())
    };
    for line in [
        "movel(pose_trans(f,p[0,0,0,0,0,0])*2, v=0.1)",
        "movel(pose_trans(f,pose_inv(p[0,0,0,0,0,0])), v=0.1)",
        "movel(pose_trans(f,p[0,0,0,0,0,0],f), v=0.1)",
        "movel(pose_add(f,p[0,0,0,0,0,0]), v=0.1)",
        "movel(pose_trans(pose_add(f,f),p[0,0,0,0,0,0]), v=0.1)",
        "movel(pose_trans(f,get_inverse_kin(p[0,0,0,0,0,0])), v=0.1)",
        "movel(get_inverse_kin(p[0,0,0,0,0,0])+[0,0,0,0,0,1], v=0.1)",
        "movel(pose_trans(f,p[0,0,0,0,0,0], v=0.1)",
        "movec(pose_trans(f,pose_trans(f,p[0,0.1,0,0,0,0])),pose_trans(pose_trans(f,f),p[0.1,0.1,0,0,0,0]), v=0.1)",
    ] {
        let refused = program(line).unwrap_err();
        assert!(refused.starts_with("p.script:4: "), "{refused}");
    }
    assert!(
        program("movel(get_inverse_kin(pose_trans(f,pose_trans(f,p[0,0,0,0,0,0])), [0,0,0,0,0,0]), v=0.1)").is_ok()
    );
}

/// A target of RAPID and where it is, in Offs and RelTool up to `depth` deep.
fn rapid_target(random: &mut Random, depth: usize) -> (String, Matrix) {
    let step = random.three(30.0);
    let [x, y, z] = step;
    if depth == 0 {
        // A quaternion of whole squares.
        let rotation = of_quaternion([0.2, 0.4, -0.8, 0.4]);
        return (
            format!("[[{x},{y},{z}],[0.2,0.4,-0.8,0.4],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"),
            times(&at(step), &rotation),
        );
    }
    let (inner, pose) = rapid_target(random, depth - 1);
    if random.next() < 0.4 {
        return (format!("Offs({inner},{x},{y},{z})"), times(&at(step), &pose));
    }
    // About x, the new y and the new z, after the step along the axes of the tool.
    let (turns, mut options, mut turned) = (random.three(90.0), String::new(), ONE);
    for (axis, name) in ["Rx", "Ry", "Rz"].into_iter().enumerate().filter(|_| random.next() < 0.6) {
        options += &format!("\\{name}:={}", turns[axis]);
        turned = times(&turned, &about(axis, turns[axis] * PI / 180.0));
    }
    (format!("RelTool({inner},{x},{y},{z}{options})"), times(&times(&pose, &at(step)), &turned))
}

#[test]
fn nested_offs_and_reltool_lead_where_matrices_say() {
    let mut random = Random(2);
    let frame = times(&times(&at([100.0, 20.0, 5.0]), &of_quaternion([0.5, 0.5, 0.5, 0.5])), &at([1.0, 2.0, 3.0]));
    for case in 0..100 {
        let (target, pose) = rapid_target(&mut random, 1 + case % 6);
        let source = format!(
            "MODULE m\nPERS wobjdata w:=[FALSE,TRUE,\"\",[[100,20,5],[0.5,0.5,0.5,0.5]],[[1,2,3],[1,0,0,0]]];\nPROC main()\n\
             MoveJ [[0,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;\nMoveL {target},v100,fine,tool0\\WObj:=w;\nENDPROC\nENDMODULE\n"
        );
        let program = RobotProgram::parse_expanded(source.clone(), "p.mod", Language::Rapid, [], &in_world(), false);
        let program = program.unwrap_or_else(|refused| panic!("{refused}\n{source}"));
        is_same(&ends(&program)[1], &times(&frame, &pose), 1e-6, &source);
        let written = moved(&program);
        let line = written.lines().find(|line| line.contains("MoveL")).unwrap();
        let numbers: Vec<f64> = line.split(['[', ']', ',']).filter_map(|number| number.trim().parse().ok()).collect();
        let placed = times(&at([numbers[0], numbers[1], numbers[2]]), &of_quaternion([3, 4, 5, 6].map(|k| numbers[k])));
        let mut goal = times(&frame, &pose);
        [0.3, -0.2, 0.1].iter().zip(0..).for_each(|(by, axis): (_, usize)| goal[axis][3] += by);
        is_same(&times(&frame, &placed), &goal, 2e-4, &written);
    }
}

/// A frame of KRL and its matrix: by `:` from the left, and in brackets.
fn krl_frame(random: &mut Random, depth: usize) -> (String, Matrix) {
    if depth > 0 && random.next() < 0.8 {
        let ((a, left), (b, right)) = (krl_frame(random, depth - 1), krl_frame(random, depth - 1));
        let text = if b.contains(':') || random.next() < 0.3 { format!("{a}:({b})") } else { format!("{a}:{b}") };
        return (text, times(&left, &right));
    }
    let ([x, y, z], angles) = (random.three(40.0), random.three(80.0));
    let [a, b, c] = angles.map(|angle| angle * PI / 180.0);
    let turned = times(&times(&about(2, a), &about(1, b)), &about(0, c));
    let [a, b, c] = angles;
    (format!("{{X {x},Y {y},Z {z},A {a},B {b},C {c}}}"), times(&at([x, y, z]), &turned))
}

#[test]
fn nested_frames_of_krl_lead_where_matrices_say() {
    let mut random = Random(3);
    for case in 0..100 {
        let ((base, frame), (target, pose)) = (krl_frame(&mut random, case % 4), krl_frame(&mut random, 1 + case % 6));
        let source = format!(
            "DEF p()\n$TOOL={{X 0,Y 0,Z 0,A 0,B 0,C 0}}\n$BASE=$NULLFRAME\nPTP {{X 0,Y 0,Z 0,A 0,B 0,C 0}}\n$BASE={base}\nLIN {target}\nEND\n"
        );
        let program = RobotProgram::parse_expanded(source.clone(), "p.src", Language::Krl, [], &in_world(), false);
        let program = program.unwrap_or_else(|refused| panic!("{refused}\n{source}"));
        is_same(&ends(&program)[1], &times(&frame, &pose), 1e-6, &source);
    }
}

#[test]
fn a_base_that_begins_with_a_bracket_is_computed() {
    let frame = "{X 10,Y 0,Z 0,A 90,B 0,C 0}";
    let source = format!(
        "DEF p()\n$TOOL={{X 0,Y 0,Z 0,A 0,B 0,C 0}}\n$BASE=$NULLFRAME\nPTP {{X 0,Y 0,Z 0,A 0,B 0,C 0}}\n$BASE=({frame}:{frame})\n\
         LIN {{X 1,Y 2,Z 3,A 0,B 0,C 0}}\nEND\n"
    );
    let refused = RobotProgram::parse(source.clone(), "p.src", Language::Krl, None, &in_world()).unwrap_err();
    assert!(refused.fault.may_vanish_on_expansion(), "{refused}");
    let program = RobotProgram::parse_expanded(source.clone(), "p.src", Language::Krl, [], &in_world(), true).unwrap();
    is_same(&ends(&program)[1], &times(&at([9.0, 8.0, 3.0]), &about(2, PI)), 1e-9, &source);
}

/// Frames of Sinumerik: afresh (TRANS, ROT) or within the one in force (ATRANS, AROT), with moves in each; where these lead.
fn sinumerik_frames(random: &mut Random, count: usize) -> (String, Vec<Matrix>) {
    let (mut text, mut frame, mut places) = (String::new(), ONE, Vec::new());
    for _ in 0..count {
        let within = random.next() < 0.6;
        let prefix = if within { "A" } else { "" };
        let own = match random.next() < 0.5 {
            true => {
                let [x, y, z] = random.three(40.0);
                text += &format!("{prefix}TRANS X{x} Y{y} Z{z}\n");
                at([x, y, z])
            }
            false => {
                let degrees = random.three(180.0)[0];
                text += &format!("{prefix}ROT {}{degrees}\n", if random.next() < 0.5 { "RPL=" } else { "Z" });
                about(2, degrees * PI / 180.0)
            }
        };
        frame = if within { times(&frame, &own) } else { own };
        for _ in 0..2 {
            let [x, y, z] = random.three(30.0);
            text += &format!("G1 X{x} Y{y} Z{z}\n");
            places.push(times(&frame, &at([x, y, z])));
        }
    }
    (text, places)
}

#[test]
fn composed_frames_of_sinumerik_lead_where_matrices_say() {
    let options = GcodeOptions { dialect: Some(Dialect::Sinumerik), ..GcodeOptions::default() };
    let read = |source: &str| GcodeProgram::parse_expanded(source.to_owned(), "p.mpf", &options, &|_| None);
    let mut random = Random(4);
    for case in 0..100 {
        let (frames, places) = sinumerik_frames(&mut random, 1 + case % 6);
        let source = format!("G90 G17 G710 G54\nG0 X0 Y0 Z0\nG1 X1 Y1 Z1 F500\n{frames}TRANS\nM30\n");
        let program = read(&source).unwrap_or_else(|refused| panic!("{refused}\n{source}"));
        let path = program.toolpath(Sampling::new(1e4, 1e4).unwrap()).unwrap();
        for (point, place) in path.positions_mm().iter().skip(2).zip(&places) {
            (0..3).for_each(|axis| assert!((point[axis] - place[axis][3]).abs() < 1e-5, "{source}"));
        }
        assert_eq!(path.len(), 2 + places.len());
    }
    for line in ["SCALE X1.5 Y1.5", "ASCALE X1.5 Y1.5", "AMIRROR X1", "ROT X30", "AROTS X10 Y20"] {
        let refused = read(&format!("G90 G17 G710\nG0 X0 Y0 Z0\nATRANS X5\n{line}\nG1 X9 Y9 F500\nM30\n")).unwrap_err();
        assert!(refused.to_string().starts_with("p.mpf:4:"), "{refused}");
    }
}

/// Most of what is nested, in every language.
const LEVELS: usize = 20_000;

/// What is nested [`LEVELS`] deep.
fn nest(open: &str, inner: &str, close: &str) -> String {
    format!("{}{inner}{}", open.repeat(LEVELS), close.repeat(LEVELS))
}

#[test]
fn what_is_too_deep_in_a_robot_program_is_an_error_that_names_depth_and_limit() {
    let chain = |one: &dyn Fn(usize) -> String| (1..=LEVELS).map(one).collect::<String>();
    let rest = "[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]";
    let module = |data: &str, body: &str| {
        format!(
            "MODULE m\nCONST robtarget p:=[[1,2,3],[0,0,1,0],{rest}];\n{data}PROC main()\n{body}ENDPROC\nENDMODULE\n"
        )
    };
    let go = "MoveL p,v1,fine,tool0;\n";
    let robot = [
        (
            Language::UrScript,
            format!("def p():\nmovel({}, v=0.1)\nend\n", nest("pose_trans(p[0,0,0,0,0,0],", "p[0,0,0,0,0,0]", ")")),
        ),
        (Language::UrScript, format!("def p():\nset_tcp({})\nend\n", nest("pose_inv(", "p[0,0,0,0,0,0]", ")"))),
        (Language::Rapid, module("", &format!("MoveL {},v1,fine,tool0;\n", nest("Offs(", "p", ",1,1,1)")))),
        (Language::Rapid, module("", &format!("IF {}=1 {go}", nest("(", "1", ")")))),
        (Language::Rapid, module("", &format!("MoveL Offs(p,{},0,0),v1,fine,tool0;\n", nest("-", "1", "")))),
        (Language::Rapid, module("", &format!("{}{go}", "IF TRUE ".repeat(LEVELS)))),
        (Language::Rapid, module("", &nest("IF TRUE THEN\n", go, "ENDIF\n"))),
        (
            Language::Rapid,
            module(
                &format!("CONST num a0:=1;\n{}", chain(&|k| format!("CONST num a{k}:=a{};\n", k - 1))),
                &format!("MoveL Offs(p,a{LEVELS},0,0),v1,fine,tool0;\n"),
            ),
        ),
        (
            Language::Krl,
            format!("DEF p()\nLIN {}\nEND\n", nest("{X 1,Y 2,Z 3,A 0,B 0,C 0}:(", "{X 1,Y 2,Z 3,A 0,B 0,C 0}", ")")),
        ),
        (
            Language::Krl,
            format!("DEF p()\n{}END\n", nest("IF TRUE THEN\n", "LIN {X 1,Y 2,Z 3,A 0,B 0,C 0}\n", "ENDIF\n")),
        ),
        (Language::Ls, format!("/PROG P\n/MN\n1: {}L P[1] 9mm/sec FINE ;\n/POS\n/END\n", "IF R[1]=1,".repeat(LEVELS))),
    ];
    for (language, source) in robot {
        let parsed = RobotProgram::parse(source.clone(), "p", language, None, &in_world());
        let refused = match parsed {
            Err(refused)
                if refused.fault.may_vanish_on_expansion() && matches!(language, Language::Rapid | Language::Krl) =>
            {
                RobotProgram::parse_expanded(source, "p", language, [], &in_world(), true).unwrap_err()
            }
            parsed => parsed.unwrap_err(),
        };
        let message = refused.to_string();
        assert!(
            message.contains(" levels of ") && message.contains("expected at most 64"),
            "{}",
            &message[..300.min(message.len())]
        );
        assert!(message.starts_with("p:") && message.len() < 400);
    }
    // A chain of calls ends at its own limit, in the time of its length.
    let calls = module("", "p1;\n").replace(
        "ENDMODULE\n",
        &format!(
            "{}PROC p{}()\n{go}ENDPROC\nENDMODULE\n",
            chain(&|k| format!("PROC p{k}()\np{};\nENDPROC\n", k + 1)),
            LEVELS + 1
        ),
    );
    let refused = RobotProgram::parse_expanded(calls, "p.mod", Language::Rapid, [], &in_world(), true).unwrap_err();
    assert!(refused.to_string().contains("calls more than 16 deep are not followed"), "{refused}");
}

#[test]
fn what_is_too_deep_in_gcode_is_an_error_that_names_depth_and_limit() {
    for (dialect, line) in [
        (Dialect::LinuxCnc, format!("G1 X{}", nest("[", "1", "]"))),
        (Dialect::LinuxCnc, format!("G1 X[{}]", nest("-", "1", ""))),
        (Dialect::LinuxCnc, format!("G1 X[{}]", nest("SIN[", "1", "]"))),
        (Dialect::Fanuc, format!("#1={}", nest("#[", "1", "]"))),
        (Dialect::Fanuc, format!("IF [{} EQ 1] GOTO 1", nest("[", "1", "]"))),
        (Dialect::Sinumerik, format!("R1={}", nest("(", "1", ")"))),
        (Dialect::Sinumerik, format!("R1={}", nest("SIN(", "1", ")"))),
        (Dialect::Sinumerik, format!("R{}=1", nest("[R", "[1]", "]"))),
        (Dialect::Heidenhain, format!("Q1 = {}", nest("(", "1", ")"))),
        (Dialect::Heidenhain, format!("Q1 = {}", nest("SIN ", "1", ""))),
    ] {
        let source = match dialect {
            Dialect::Heidenhain => format!("BEGIN PGM P MM\n{line}\nEND PGM P MM\n"),
            _ => format!("G90\n{line}\nM30\n"),
        };
        let options = GcodeOptions { dialect: Some(dialect), ..GcodeOptions::default() };
        let refused = GcodeProgram::parse_expanded(source, "p.nc", &options, &|_| None).unwrap_err().to_string();
        assert!(refused.contains(" levels of ") && refused.contains("expected at most 64"), "{refused}");
        assert!(refused.starts_with("p.nc:2:") && refused.len() < 400, "{refused}");
    }
}

#[test]
fn what_is_too_long_written_out_is_an_error_with_its_limit() {
    let (comment, blanks) = ("c".repeat(1 << 20), " ".repeat(1 << 20));
    let expanded = |dialect, source: String| {
        let options = GcodeOptions { dialect: Some(dialect), ..GcodeOptions::default() };
        GcodeProgram::parse_expanded(source, "p.nc", &options, &|_| None).unwrap_err().to_string()
    };
    let jumps = expanded(Dialect::Fanuc, format!("G90 G21\n#1=1\nN1 IF [#1 EQ 1] GOTO 1 ({comment})\nM30\n"));
    assert!(jumps.starts_with("p.nc:3:") && jumps.contains("more than 256 MiB in all"), "{}", &jumps[..300]);
    let repeats = expanded(
        Dialect::Sinumerik,
        format!("G90\nA1: R1=R1 ;{comment}\nB1: R2=1\nREPEAT A1 B1 P=400000\nM30\n").replace("R1=R1", "R1=1"),
    );
    assert!(
        repeats.contains("more than 256 MiB in all, with 3997") && repeats.contains(" more runs of this section"),
        "{}",
        &repeats[..300]
    );
    let pecks =
        expanded(Dialect::Fanuc, "G90 G21 G0 X0 Y0 Z10\nG91 G83 X1 Z-100 R-1 Q0.02 L10000 F9\nG80\nM30\n".to_owned());
    assert!(pecks.starts_with("p.nc:2:") && pecks.contains("has run 1000000 lines"), "{pecks}");
    let module = format!(
        "MODULE m\nPROC main()\nFOR i FROM 1 TO 900000 DO\nMoveL {blanks}[[i,2,3],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v1,fine,tool0;\nENDFOR\nENDPROC\nENDMODULE\n"
    );
    let refused =
        RobotProgram::parse_expanded(module, "p.mod", Language::Rapid, [], &in_world(), true).unwrap_err().to_string();
    assert!(refused.contains("more than 256 MiB in all"), "{}", &refused[..300.min(refused.len())]);
}

#[test]
#[ignore = "takes a GB of memory"]
fn a_program_of_more_lines_than_points_is_refused_at_once() {
    let refused = GcodeProgram::parse(vec![b'\n'; 35_000_000], "p.nc", &GcodeOptions::default()).unwrap_err();
    assert_eq!(refused.to_string(), "p.nc:1:1: ``: a program of 35000000 lines; expected at most 20000000");
}
