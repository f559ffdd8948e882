//! Contours that Sinumerik and Heidenhain make of few words: roundings, chamfers, tangential arcs, polar and rotated coordinates.

use std::f64::consts::{FRAC_PI_2, PI};

use kinetostat_programs::{
    Sampling, Toolpath, WriteOptions,
    gcode::{Dialect, GcodeError, GcodeOptions, GcodeProgram},
};
use nalgebra::Vector3;

fn expanded(source: &str, dialect: Dialect) -> Result<GcodeProgram, GcodeError> {
    let options = GcodeOptions { dialect: Some(dialect), ..GcodeOptions::default() };
    GcodeProgram::parse_expanded(source, "part", &options, &|_| None)
}

fn path(program: &GcodeProgram) -> Toolpath {
    let path = program.toolpath(Sampling::new(0.01, 0.2).unwrap()).unwrap();
    let same = program.rewrite(&path, &path.positions_mm(), WriteOptions::default()).unwrap();
    assert_eq!(same.bytes(), program.source());
    path
}

fn sinumerik(blocks: &str) -> String {
    format!("G17 G90 G71 G54\nG0 X0 Y0 Z0\nG1 F100\n{blocks}\nM30\n")
}

fn heidenhain(blocks: &str) -> String {
    format!("0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S1000 F100\n2 L X+0 Y+0 Z+0 R0 FMAX\n{blocks}\n90 END PGM A MM\n")
}

fn read(blocks: &str, dialect: Dialect) -> GcodeProgram {
    let source = if dialect == Dialect::Sinumerik { sinumerik(blocks) } else { heidenhain(blocks) };
    expanded(&source, dialect).unwrap_or_else(|error| panic!("{error}"))
}

/// Ends of the motions behind the start at the origin, mm.
fn ends(program: &GcodeProgram) -> Vec<[f64; 3]> {
    path(program).points().iter().filter(|p| p.source.parameter == 1.0).skip(1).map(|p| p.position_mm.into()).collect()
}

fn length(program: &GcodeProgram) -> f64 {
    path(program).positions_mm().windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
}

/// Largest angle by which the way turns between two steps, rad.
fn largest_turn(program: &GcodeProgram) -> f64 {
    let positions = path(program).positions_mm();
    let steps: Vec<Vector3<f64>> =
        positions.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| step.norm() > 1e-6).collect();
    steps.windows(2).map(|pair| pair[0].angle(&pair[1])).fold(0.0, f64::max)
}

fn assert_ends(program: &GcodeProgram, expected: &[[f64; 3]]) {
    let found = ends(program);
    assert_eq!(found.len(), expected.len(), "{found:?}\n{}", String::from_utf8_lossy(program.source()));
    for (found, expected) in found.iter().zip(expected) {
        assert!((0..3).all(|axis| (found[axis] - expected[axis]).abs() < 1e-6), "{found:?} {expected:?}");
    }
}

fn refusal(blocks: &str, dialect: Dialect) -> String {
    let source = if dialect == Dialect::Sinumerik { sinumerik(blocks) } else { heidenhain(blocks) };
    expanded(&source, dialect).expect_err(blocks).to_string()
}

#[test]
fn corners_are_cut_off() {
    let rounded = [
        read("X20 RND=5\nY20 RND=4\nX0", Dialect::Sinumerik),
        read("L X+20 Y+0\nRND R5\nL X+20 Y+20\nRND R4\nL X+0 Y+20", Dialect::Heidenhain),
    ];
    for program in &rounded {
        assert_ends(
            program,
            &[[15.0, 0.0, 0.0], [20.0, 5.0, 0.0], [20.0, 16.0, 0.0], [16.0, 20.0, 0.0], [0.0, 20.0, 0.0]],
        );
        assert!((length(program) - (15.0 + 11.0 + 16.0 + FRAC_PI_2 * 9.0)).abs() < 0.01);
    }
    // The chamfer itself is 2 mm, then each of its sides is.
    let chamfer = read("X20 CHF=2\nY20 CHR=2 ; side\nX0", Dialect::Sinumerik);
    let leg = 2.0_f64.sqrt();
    let corners = [[20.0 - leg, 0.0, 0.0], [20.0, leg, 0.0], [20.0, 18.0, 0.0], [18.0, 20.0, 0.0], [0.0, 20.0, 0.0]];
    assert_ends(&chamfer, &corners);
    assert_ends(
        &read("L X+20 Y+0\nCHF 2\nL X+20 Y+20", Dialect::Heidenhain),
        &[[18.0, 0.0, 0.0], [20.0, 2.0, 0.0], [20.0, 20.0, 0.0]],
    );
    // In G91, and with the rounding in force: the last corner before a move away is none.
    let modal = read("G91 RNDM=1\nX10\nY10\nZ5\nG90 RNDM=0\nX0", Dialect::Sinumerik);
    assert_ends(&modal, &[[9.0, 0.0, 0.0], [10.0, 1.0, 0.0], [10.0, 10.0, 0.0], [10.0, 10.0, 5.0], [0.0, 10.0, 5.0]]);
    // Tangential blocks have no corner.
    assert_ends(&read("X20 RND=5\nX30", Dialect::Sinumerik), &[[20.0, 0.0, 0.0], [30.0, 0.0, 0.0]]);
}

#[test]
fn roundings_are_tangential_to_lines_and_arcs() {
    for blocks in [
        "X20 RND=3\nG3 X20 Y20 CR=12",
        "X20 RND=3\nG2 X20 Y20 CR=12",
        "G3 X20 Y0 CR=14 RND=2\nG1 Y20",
        "G2 X20 Y0 CR=14 RND=2\nG1 Y-20",
        "G3 X20 Y0 CR=14 RND=2\nG3 X20 Y20 CR=14",
        "G3 X20 Y0 CR=14 RND=2\nG2 X20 Y20 CR=14",
        "G2 X20 Y0 CR=14 RND=2\nG3 X40 Y0 I10 J-3",
        "X20 Y3 RND=1.5\nX3 Y9",
    ] {
        let turn = largest_turn(&read(blocks, Dialect::Sinumerik));
        assert!(turn < 0.25, "{blocks}: {turn}");
    }
}

#[test]
fn arcs_are_found_by_what_they_meet() {
    let through = read("G1 X10 Y0\nCIP X20 Y10 I1=IC(7.0710678118654755) J1=2.9289321881345245", Dialect::Sinumerik);
    assert_ends(&through, &[[10.0, 0.0, 0.0], [20.0, 10.0, 0.0]]);
    assert!((length(&through) - 10.0 - FRAC_PI_2 * 10.0).abs() < 0.01 && largest_turn(&through) < 0.1);
    for program in [
        read("X10\nCT X20 Y10\nG1 Y15\nCT X10 Y25\nX5 Y20", Dialect::Sinumerik),
        read("L X+10 Y+0\nCT X+20 Y+10\nL X+20 Y+15\nCT X+10 Y+25\nCT X+5 Y+20", Dialect::Heidenhain),
    ] {
        assert_eq!(ends(&program).len(), 5);
        assert!(largest_turn(&program) < 0.1, "{}", largest_turn(&program));
    }
    let helix = read("X10\nG3 X10 Y0 Z-6 I-10 J0 TURN=2", Dialect::Sinumerik);
    assert_ends(&helix, &[[10.0, 0.0, 0.0], [10.0, 0.0, -2.0], [10.0, 0.0, -4.0], [10.0, 0.0, -6.0]]);
    assert!((length(&helix) - 10.0 - libm::hypot(6.0 * PI * 10.0, 6.0)).abs() < 0.05);
    let turns = read("L X+10 Y+0\nCC X+0 Y+0\nCP IPA-450 DR-", Dialect::Heidenhain);
    assert_ends(&turns, &[[10.0, 0.0, 0.0], [10.0, 0.0, 0.0], [0.0, -10.0, 0.0]]);
}

#[test]
fn helices_of_polar_arcs_become_lines_within_a_micrometre() {
    let helix = read("L X+10 Y+0\nCC X+2 Y+0\nCP IPA+810 IZ-9 DR+ F50 M90\nL X+30", Dialect::Heidenhain);
    let text = String::from_utf8_lossy(helix.source()).into_owned();
    assert!(text.contains(" F50 M90\n") && text.matches("M90").count() == 1 && !text.contains("CP"), "{text}");
    let positions = path(&helix).positions_mm();
    let (on, behind): (Vec<Vector3<f64>>, _) =
        positions.into_iter().skip_while(|p| p.x < 10.0).partition(|p| p.z > -8.999_99);
    assert_eq!(behind.last(), Some(&Vector3::new(30.0, 8.0, -9.0)));
    let mut turned = 0.0;
    for pair in on.windows(2) {
        let [a, b] = [pair[0], pair[1]].map(|p| libm::atan2(p.y, p.x - 2.0));
        turned += (b - a).rem_euclid(2.0 * PI);
        assert!((libm::hypot(pair[1].x - 2.0, pair[1].y) - 8.0).abs() < 0.00101, "{}", pair[1]);
        assert!((pair[1].z + 9.0 * turned / (4.5 * PI)).abs() < 0.001, "{}", pair[1]);
    }
    assert!((turned - 4.5 * PI).abs() < 0.1, "{turned}");
    // Where it does not rise, it is an arc of the plane.
    let flat = read("L X+10 Y+0 Z-9\nCC X+2 Y+0\nCP IPA+450 Z-9 DR+", Dialect::Heidenhain);
    let text = String::from_utf8_lossy(flat.source()).into_owned();
    assert!(text.contains("C X+10.0 Y+0.0 DR+\nC X+2.0 Y+8.0 DR+\n"), "{text}");
    // In inches a micrometre is no shorter.
    let inches = heidenhain("L X+1 Y+0\nCC X+0 Y+0\nCP IPA+360 IZ-1 DR+").replace("A MM", "A INCH");
    let inches = expanded(&inches, Dialect::Heidenhain).unwrap();
    let lines = String::from_utf8_lossy(inches.source()).lines().count();
    assert!((350..370).contains(&lines), "{lines}");
}

#[test]
fn polar_coordinates_count_from_the_pole() {
    let (s, c) = (30f64.to_radians().sin() * 10.0, 30f64.to_radians().cos() * 10.0);
    let corners = [[60.0, 40.0, 0.0], [50.0 + c, 40.0 + s, 0.0], [50.0 + s, 40.0 + c, 0.0], [50.0, 50.0, 0.0]];
    assert_ends(&read("G111 X50 Y40\nAP=0 RP=10\nAP=30\nAP=IC(30)\nG3 AP=90", Dialect::Sinumerik), &corners);
    assert_ends(&read("CC X+50 Y+40\nLP PR+10 PA+0\nLP PA+30\nLP IPA+30\nCP PA+90 DR+", Dialect::Heidenhain), &corners);
    // From where the tool is, and from the pole before; the zero without any.
    assert_ends(
        &read("X5 Y5\nG110 X5 Y0\nG0 AP=90 RP=2\nG112 Y10\nG1 AP=180 RP=3", Dialect::Sinumerik),
        &[[5.0, 5.0, 0.0], [10.0, 7.0, 0.0], [7.0, 15.0, 0.0]],
    );
    assert_ends(&read("AP=90 RP=7 Z2", Dialect::Sinumerik), &[[0.0, 7.0, 2.0]]);
    // In G18 angles count from Z.
    assert_ends(&read("G18\nAP=90 RP=7", Dialect::Sinumerik), &[[7.0, 0.0, 0.0]]);
}

#[test]
fn coordinates_rotate_in_the_plane() {
    let blocks = "TRANS X100 Y10\nAROT Z90\nG1 X5 Y0\nX10\nY10\nATRANS X1\nX10 Y10\nG91 X1\nG90 G3 X11 Y20 CR=5\nROT RPL=30\nG1 X2 Y0\nTRANS\nX3";
    let (c, s) = (30f64.to_radians().cos(), 30f64.to_radians().sin());
    assert_ends(
        &read(blocks, Dialect::Sinumerik),
        &[
            [100.0, 15.0, 0.0],
            [100.0, 20.0, 0.0],
            [90.0, 20.0, 0.0],
            [90.0, 21.0, 0.0],
            [90.0, 22.0, 0.0],
            [80.0, 22.0, 0.0],
            [2.0 * c, 2.0 * s, 0.0],
            [3.0, 2.0 * s, 0.0],
        ],
    );
    // A single coordinate keeps the other where it is in the new coordinates.
    assert_ends(
        &read("X10 Y0\nROT Z90\nX4\nROT\nX1", Dialect::Sinumerik),
        &[[10.0, 0.0, 0.0], [10.0, 4.0, 0.0], [1.0, 4.0, 0.0]],
    );
    assert_ends(&read("SCALE X1 Y1\nX4\nSCALE\nX5", Dialect::Sinumerik), &[[4.0, 0.0, 0.0], [5.0, 0.0, 0.0]]);
}

#[test]
fn what_is_no_line_or_arc_is_refused() {
    for (blocks, dialect, why) in [
        ("X20 RND=25\nY20", Dialect::Sinumerik, "lines or arcs that are long enough"),
        ("X20 RND=2\nZ20", Dialect::Sinumerik, "lines or arcs that are long enough"),
        ("X20 RND=2\nM8\nY20", Dialect::Sinumerik, "one behind the other"),
        ("X20 RND=2", Dialect::Sinumerik, "one behind the other"),
        ("X20 CHF=2\nG3 X20 Y20 CR=12", Dialect::Sinumerik, "lines or arcs"),
        ("G0 X20 RND=2\nG1 Y20", Dialect::Sinumerik, "lines or arcs"),
        ("X20 RND=2 FRC=50\nY20", Dialect::Sinumerik, "roundings and chamfers"),
        ("CIP X20 Y0 I1=10 J1=0", Dialect::Sinumerik, "expected three points of an arc in the plane"),
        ("CIP X20 Y0 Z3 I1=10 J1=5", Dialect::Sinumerik, "expected three points of an arc in the plane"),
        ("Z5\nCT X20 Y0", Dialect::Sinumerik, "expected a position that is known before it"),
        ("G91 AP=10 RP=5", Dialect::Sinumerik, "expected radius and angle that are known"),
        ("AP=IC(10) RP=5", Dialect::Sinumerik, "expected radius and angle that are known"),
        ("AP=10", Dialect::Sinumerik, "expected radius and angle that are known"),
        ("ROT X30", Dialect::Sinumerik, "expected a rotation in the plane"),
        ("AROT Z1 RPL=2", Dialect::Sinumerik, "expected RPL alone, or axes without it"),
        ("SCALE X2", Dialect::Sinumerik, "neither scale nor mirror"),
        ("MIRROR X0", Dialect::Sinumerik, "rotated, scaled, mirrored"),
        ("ROT Z30\nG18", Dialect::Sinumerik, "expected one plane while coordinates are rotated"),
        ("G55\nROT Z30\nX5", Dialect::Sinumerik, "expected a position that is known before it"),
        ("G3 X0 Y0 I5 AR=30", Dialect::Sinumerik, "this motion is not followed"),
        ("CC Y+5 Z-3\nCP IPA-90 DR-", Dialect::Heidenhain, "expected both coordinates of the plane"),
        ("L X+5 Y+0\nRND R2 F50\nL X+5 Y+5", Dialect::Heidenhain, "roundings and chamfers that the control inserts"),
        ("RND R5", Dialect::Heidenhain, "lines or arcs"),
        ("L X+10 Y+0\nCC X+0 Y+0\nCP IPA+1080 IZ-6 DR+ M9", Dialect::Heidenhain, "in a block of their own"),
        ("L X+10 Y+0\nCC X+0 Y+0\nCP IPA+360 IZ-6 DR-", Dialect::Heidenhain, "expected a position that is known"),
        ("L X+10 Y+0\nCC X+0 Y+0\nCP PR+10 PA+90 DR+", Dialect::Heidenhain, "expected CP without PR"),
        ("L X+10 Y+0\nCC X+0 Y+0\nCP IPA+360 IZ-6 Z-9 DR+", Dialect::Heidenhain, "expected each coordinate once"),
        ("L X+10 Y+0\nCC X+10 Y+0\nCP IPA+360 IZ-6 DR+", Dialect::Heidenhain, "expected a position that is known"),
        (
            "L Z+5 M91\nL X+10 Y+0\nCC X+0 Y+0\nCP IPA+90 IZ-1 DR+",
            Dialect::Heidenhain,
            "expected a position that is known",
        ),
        ("L Z+5 M91\nL X+10 Y+0\nCT X+15 Y+5 IZ-1", Dialect::Heidenhain, "expected a position that is known"),
        ("L Z+5 M91\nL X+10 Y+0\nL X+20 IZ-1\nRND R2\nL Y+20", Dialect::Heidenhain, "part:6:8: `IZ-1`"),
        ("G0 SUPA Z0\nG1 AP=90 RP=10 Z=IC(-1)", Dialect::Sinumerik, "expected a position that is known"),
        ("G0 SUPA Z0\nX5 Y0\nG3 AP=90 RP=5 Z=IC(-1)", Dialect::Sinumerik, "expected a position that is known"),
        ("ROT Z30\nG0 SUPA Z0\nG1 X5 Y5 Z=IC(-1)", Dialect::Sinumerik, "expected a position that is known"),
        (
            "L X+10 Y+0\nL Z+5 M91\nCC X+0 Y+0\nCP IPA+360 Z-6 DR+",
            Dialect::Heidenhain,
            "expected a position that is known",
        ),
        ("LP PR+5 PA+0", Dialect::Heidenhain, "expected a pole before it"),
        ("CC X+0 Y+5\nCP IPA+90 DR-", Dialect::Heidenhain, "expected a position that is known"),
        ("CT X+5 Y+5", Dialect::Heidenhain, "expected a position that is known"),
    ] {
        let found = refusal(blocks, dialect);
        assert!(found.contains(why), "{blocks}: {found}");
    }
}
