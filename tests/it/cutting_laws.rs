//! Cutting forces on each point of a path, of which the force of the paper is one, and which points cut.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use kinetostat::{
    MillingForce, Pose,
    inspect::point::PointLoad,
    nalgebra::Vector3,
    process::{
        CuttingRule, ForceLaw,
        cutting::{CuttingLaw, EdgeForce, PathFrame, SlotMilling},
        file::Cutter,
    },
    spatial::frame_about,
    toolpath::{
        Circle, Load, PathPoint, Plane, Sampling, Toolpath, TurnDirection, gcode::GcodeProgram, polyline::Polyline,
    },
};

use crate::support::path_loads;

fn read(source: &str) -> Toolpath {
    Polyline::read(source, "path.csv").unwrap().toolpath().clone()
}

fn laws() -> [CuttingLaw; 2] {
    let force = MillingForce { law: ForceLaw::Rotated, ..MillingForce::KLIMCHIK_GROOVE };
    let force_of = |cutting, edge| EdgeForce { cutting, edge };
    let milling = SlotMilling {
        tangential: force_of(800.0, 10.0),
        radial: force_of(300.0, 8.0),
        axial: force_of(-150.0, -2.0),
        depth_mm: 2.0,
        teeth: 3,
        feed_per_tooth_mm: Some(0.05),
        spindle: TurnDirection::Clockwise,
    };
    [CuttingLaw::PathFrame(PathFrame { force }), CuttingLaw::SlotMilling(milling)]
}

const NO_LOAD: Load = Load { force_N: Vector3::new(0.0, 0.0, 0.0), moment_Nmm: Vector3::new(0.0, 0.0, 0.0) };

/// Loads on a tool along z of W.
fn loads(law: &CuttingLaw, path: &Toolpath) -> Vec<Load> {
    loads_on(law, path, Vector3::z())
}

/// Loads on a tool along `axis` of W.
fn loads_on(law: &CuttingLaw, path: &Toolpath, axis: Vector3<f64>) -> Vec<Load> {
    let loads = path_loads(law, path).unwrap();
    path.points().iter().zip(loads).map(|(p, load)| load.on_tool(p.tangent, &frame_about(axis))).collect()
}

#[test]
fn all_forces_turn_with_the_tool() {
    // The same cut on a machine that stands in any other way: forces stand in the same way to tool and motion.
    let path = read("x_mm,y_mm,z_mm\n0,0,0\n5,2,0\n5,2,-1\n9,3,-3\n");
    for angles in [Vector3::new(PI, 0.0, 0.0), Vector3::new(FRAC_PI_2, 0.0, 0.4), Vector3::new(0.3, -1.2, 2.0)] {
        let turn = Pose::from_roll_pitch_yaw(angles).rotation;
        let turned = path.points().iter().map(|p| PathPoint { tangent: turn * p.tangent, ..*p }).collect();
        let turned = Toolpath::assemble(turned);
        for law in laws() {
            let (here, there) = (loads(&law, &path), loads_on(&law, &turned, turn * Vector3::z()));
            for (here, there) in here.iter().zip(&there) {
                assert!((turn * here.force_N - there.force_N).norm() < 1e-11, "{} {}", here.force_N, there.force_N);
            }
        }
    }
}

#[test]
fn the_signs_are_those_of_the_picture() {
    // Tool down, as on most mills; the feed along x.
    let force = MillingForce { radial: 7.0, tangential: 3.0, axial: -2.0, law: ForceLaw::Rotated };
    let path = read("x_mm,y_mm,z_mm\n0,0,0\n5,0,0\n");
    let down = loads_on(&CuttingLaw::PathFrame(PathFrame { force }), &path, -Vector3::z())[0].force_N;
    // Along the feed; to the right seen from the workpiece, which is +y; and up, into the spindle.
    assert!((down - Vector3::new(3.0, 7.0, 2.0)).norm() < 1e-12, "{down}");
    // Spindle horizontal, tool along y, feed along x: nothing radial lies along the tool.
    let level = loads_on(&CuttingLaw::PathFrame(PathFrame { force }), &path, Vector3::y())[0].force_N;
    assert!((level - Vector3::new(3.0, -2.0, 7.0)).norm() < 1e-12, "{level}");
}

#[test]
fn no_force_on_rapid_moves_and_on_plunges_an_axial_one_that_is_given_alone() {
    let path = read("x_mm,y_mm,z_mm,cutting\n0,0,5,0\n0,0,0,1\n0,0,-1,1\n5,0,-1,1\n9,0,-1,0\n");
    for law in laws() {
        let loads = loads(&law, &path);
        assert_eq!(loads[0], NO_LOAD);
        for plunge in &loads[1..3] {
            assert_eq!((plunge.force_N.x, plunge.force_N.y), (0.0, 0.0));
            // The side of an end mill cuts nothing there.
            assert_eq!(plunge.force_N.z != 0.0, matches!(law, CuttingLaw::PathFrame(_)));
        }
        assert!(loads[3].force_N.xy().norm() > 1.0);
        assert_eq!(loads[4], NO_LOAD);
    }
    assert_eq!(loads(&CuttingLaw::None, &path), [NO_LOAD; 5]);
}

#[test]
fn forces_turn_with_the_path_and_lean_on_nothing_else() {
    for law in laws() {
        let along_x = loads(&law, &read("x_mm,y_mm,z_mm\n0,0,0\n5,0,0\n"))[0].force_N;
        let along_y = loads(&law, &read("x_mm,y_mm,z_mm\n3,1,0\n3,9,0\n"))[0].force_N;
        assert!((along_y - Vector3::new(-along_x.y, along_x.x, along_x.z)).norm() < 1e-12);
    }
}

#[test]
fn loads_of_the_path_are_taken_as_they_are_and_missed_where_the_tool_cuts() {
    let path = read("x_mm,y_mm,z_mm,force_x_N,force_y_N,force_z_N,cutting\n0,0,0,1,2,3,1\n1,0,0,4,5,6,0\n");
    let loads = loads(&CuttingLaw::FromPath, &path);
    assert_eq!(loads[0].force_N, Vector3::new(1.0, 2.0, 3.0));
    assert_eq!(loads[1].force_N, Vector3::new(4.0, 5.0, 6.0));
    assert_eq!(
        path_loads(&CuttingLaw::None, &path).unwrap_err().to_string(),
        "the path brings loads along, but the process has no cutting force: expected force.from_path = true, or a \
         path without force columns"
    );
    for law in laws() {
        assert_eq!(
            path_loads(&law, &path).unwrap_err().to_string(),
            "the path brings loads along, but the process takes the cutting force from elsewhere: expected \
             force.from_path = true, or a path without force columns"
        );
    }
    let bare = read("x_mm,y_mm,z_mm,cutting\n0,0,0,0\n1,0,0,1\n");
    assert_eq!(
        path_loads(&CuttingLaw::FromPath, &bare).unwrap_err().to_string(),
        "the path gives no load for move 2: expected the columns force_x_N, force_y_N, force_z_N"
    );
}

fn circle(turn: TurnDirection) -> Circle {
    Circle {
        centre_mm: Vector3::new(4.0, -5.0, 6.0),
        diameter_mm: 50.0,
        plane: Plane::Xy,
        turn,
        start_angle_rad: 0.2,
        points: 73,
    }
}

#[test]
fn on_a_counter_clockwise_circle_the_tool_angle_is_the_polar_angle() {
    for law in [ForceLaw::PaperEq17, ForceLaw::Rotated] {
        let frame = PathFrame { force: MillingForce { law, ..MillingForce::KLIMCHIK_GROOVE } };
        let circle = circle(TurnDirection::CounterClockwise);
        for point in circle.toolpath().unwrap().points() {
            let arm = point.position_mm - circle.centre_mm;
            let polar = arm.y.atan2(arm.x);
            let phi = PathFrame::tool_angle(point.tangent).unwrap();
            assert!((phi - polar).sin().abs() < 1e-12 && (phi - polar).cos() > 0.0);
            assert!((frame.force(point.tangent) - frame.force.force(polar)).norm() < 1e-10);
        }
    }
}

#[test]
fn the_rotated_law_pushes_right_of_and_along_the_motion() {
    let force = MillingForce { radial: 7.0, tangential: 3.0, axial: -2.0, law: ForceLaw::Rotated };
    for turn in [TurnDirection::CounterClockwise, TurnDirection::Clockwise] {
        for point in circle(turn).toolpath().unwrap().points() {
            let right = point.tangent.cross(&Vector3::z());
            let wanted = right * 7.0 + point.tangent * 3.0 - Vector3::z() * 2.0;
            assert!((PathFrame { force }.force(point.tangent) - wanted).norm() < 1e-12);
        }
    }
}

#[test]
fn a_ramp_has_the_heading_of_its_projection_and_a_plunge_none() {
    let ramp = Vector3::new(0.6, 0.0, -0.8);
    assert!((PathFrame::tool_angle(ramp).unwrap() + FRAC_PI_2).abs() < 1e-15);
    let frame = PathFrame { force: MillingForce::KLIMCHIK_GROOVE };
    for tangent in [-Vector3::z(), Vector3::z(), Vector3::new(1e-9, 0.0, -1.0), Vector3::zeros()] {
        assert_eq!(PathFrame::tool_angle(tangent), None);
        assert_eq!(frame.force(tangent), Vector3::new(0.0, 0.0, -25.0));
    }
}

#[test]
fn moment_is_the_one_of_eq_16() {
    let wrench = MillingForce::KLIMCHIK_GROOVE.wrench(0.7, &Pose::from_translation(Vector3::new(0.0, 0.0, 100.0)));
    let f = wrench.force;
    assert!((wrench.moment - Vector3::new(-f.y * 100.0, f.x * 100.0, 0.0)).norm() < 1e-12);
}

#[test]
fn printed_law_varies_and_rotated_law_does_not() {
    let in_plane = |law: ForceLaw, degrees: f64| {
        let f = MillingForce { law, ..MillingForce::KLIMCHIK_GROOVE }.force(degrees.to_radians());
        f.x.hypot(f.y)
    };
    assert!((in_plane(ForceLaw::PaperEq17, 45.0) - 205.0).abs() < 1e-9);
    assert!((in_plane(ForceLaw::PaperEq17, 135.0) - 225.0).abs() < 1e-9);
    for degrees in [0.0, 45.0, 135.0] {
        assert!((in_plane(ForceLaw::Rotated, degrees) - 215f64.hypot(10.0)).abs() < 1e-9);
    }
}

#[test]
fn height_and_feed_say_what_cuts() {
    let source = "G0 X0 Y0 Z5\nG1 Z-1 F100\nG1 X4 F300\nG1 Z5\nG1 X8 F2000\n";
    let program = GcodeProgram::parse(source, "p.nc", &Default::default()).unwrap();
    let path = program.toolpath(Sampling::new(0.01, 2.0).unwrap()).unwrap();
    let cutting = |rule: CuttingRule| {
        let path = rule.apply(path.clone());
        path.points().iter().filter(|p| p.cutting).map(|p| p.position_mm.into()).collect::<Vec<[f64; 3]>>()
    };
    assert_eq!(cutting(CuttingRule::default()).len(), path.len() - 1);
    let below = CuttingRule { below_z_mm: Some(0.0), ..CuttingRule::default() };
    assert_eq!(cutting(below), [[0.0, 0.0, -1.0], [2.0, 0.0, -1.0], [4.0, 0.0, -1.0]]);
    let slow = CuttingRule { max_feed_mm_per_min: Some(100.0), ..CuttingRule::default() };
    assert!(cutting(slow).iter().all(|p| p[0] == 0.0));
    let above = CuttingRule { above_z_mm: Some(4.0), ..CuttingRule::default() };
    assert!(cutting(above).iter().all(|p| p[2] >= 4.0) && !cutting(above).is_empty());
    assert_eq!(
        CuttingRule { max_feed_mm_per_min: Some(400.0), ..below }.text(),
        "every move but rapid ones, with z of the workpiece up to 0 mm and a feed up to 400 mm/min"
    );
}

#[test]
fn a_cutter_named_in_one_line_has_the_force_of_end_milling() {
    let parse = |text: &str| Cutter::parse(text, "Al 6082-T6").map_err(|refused| refused.to_string());
    let cutter = parse("D=10,z=4,ae=5,ap=8,fz=0.08,cut=down,n=8000").unwrap();
    // Half immersion, from π/2 to π: ∫ sin ψ = 1; K_tc = 631 N/mm², K_te = 13 N/mm.
    let torque = 4.0 * 8.0 / TAU * (631.0 * 0.08 + 13.0 * FRAC_PI_2) * 5.0;
    assert!((cutter.force().torque_Nmm - torque).abs() < 1e-9 * torque, "{}", cutter.force().torque_Nmm);
    let power = torque / 1e3 * 8000.0 * TAU / 60.0;
    assert!((cutter.power_watts().unwrap() - power).abs() < 1e-9 * power);
    assert_eq!(cutter.feed_mm_per_min(), Some(2560.0));
    assert_eq!(parse("D=10,z=4,ae=5,ap=8,fz=0.08,cut=up").unwrap().power_watts(), None);
    // At a point the load is that of a path along φ + 90°.
    let path = read("x_mm,y_mm,z_mm\n0,0,0\n5,2,0\n");
    let axes = frame_about(Vector3::z());
    let along = axes.tr_mul(&path.points()[1].tangent);
    let phi = (-along.x).atan2(along.y);
    let wanted = loads(&CuttingLaw::EndMilling(cutter.law), &path)[1];
    let cut = cutter.force();
    let tool = Pose { rotation: axes, translation: Vector3::zeros() };
    let found = PointLoad::Cut(cut.into(), phi, cut.torque_Nmm).wrench(&tool);
    assert!((found.force - wanted.force_N).norm() < 1e-9, "{} {}", found.force, wanted.force_N);
    assert!((found.moment - wanted.moment_Nmm).norm() < 1e-9, "{} {}", found.moment, wanted.moment_Nmm);
    for (text, problem) in [
        ("D=10,z=4", "radial_width_mm: missing"),
        ("D=10,z=4,ae=5,ap=8,cut=up", "fz: missing: expected the feed per tooth in mm"),
        ("D=10,z=4,ae=5,ap=8,fz=0.1", "cut: missing"),
        ("D=10,z=4,ae=15,ap=8,fz=0.1", "must be at most diameter_mm"),
        ("D=10,D=5", "D=5: is given twice"),
        ("D", "expected entries such as D=10"),
        ("D=ten", "D=ten: expected a number"),
        ("z=4.5", "expected a whole number"),
        ("cut=left", "expected cut=up or cut=down"),
        ("vc=300", "vc=300: expected D, z, ae, ap, fz, cut, n, kr and ka"),
        ("D=10,z=4,ae=10,ap=8,fz=0.1,n=0", "n: must be"),
    ] {
        let refused = parse(text).unwrap_err();
        assert!(refused.contains(problem) && refused.contains("--cutter"), "{text}: {refused}");
    }
    assert!(Cutter::parse("D=10,z=4,ae=10,ap=8,fz=0.1", "cheese").is_err());
    assert!(Cutter::parse("D=10,z=4,ae=10,ap=8,fz=0.1", "C45E").is_err());
    assert!(Cutter::parse("D=10,z=4,ae=10,ap=8,fz=0.1,kr=0.3,ka=-0.1", "C45E").is_ok());
}
