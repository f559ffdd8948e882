//! Process files: what a good one means, and that no wrench table panics. Broken ones are in `bad_input`.

use std::{fs, path::Path};

use kinetostat::{
    compensation::{ErrorNorm, Target},
    input::Inputs,
    machine::Machine,
    process::{
        ForceLaw, MillingForce, PathReference, Process,
        cutting::{
            CutDirection, CuttingLaw, DrillingLaw, EdgeForce, EdgeLaw, EndMilling, Kienzle, MeanOrPeak, PathFrame,
            SlotMilling, WrenchTable,
        },
        file::CorrectionLimits,
    },
    toolpath::{NumberFormat, Sampling, TurnDirection},
};
use nalgebra::Vector3;
use proptest::prelude::*;

use crate::support::cases::cases;

const COLUMNS: &str = "arc_length_mm,force_x_N,force_y_N,force_z_N,moment_x_Nmm,moment_y_Nmm,moment_z_Nmm";

fn orthoglide() -> Machine {
    Machine::named_or_file("orthoglide").unwrap()
}

fn process(text: &str) -> Process {
    let text = format!("schema = 1\n{text}");
    Process::from_toml(&text, "process.toml", Path::new(""), &orthoglide()).unwrap()
}

#[test]
fn an_empty_process_is_no_force_on_a_perfect_machine() {
    let process = process("");
    assert_eq!(process.placement, Default::default());
    assert_eq!(process.cutting, CuttingLaw::None);
    assert_eq!(process.errors, vec![Default::default(); 3]);
    assert_eq!(process.sampling, Sampling::default());
    assert_eq!(process.limits, CorrectionLimits::default());
    assert_eq!((process.corner_mm, process.write_tolerance_mm, process.helical_arcs), (2.0, 0.005, true));
    assert_eq!(process.target, Target::ToolTip);
    assert_eq!(process.gcode, Default::default());
    let own = NumberFormat::new(3, 5).unwrap();
    assert_eq!(process.decimals.format(own), Ok(own));
}

#[test]
fn every_key_arrives_in_the_program_s_units() {
    let process = process(
        r#"
        [placement]
        origin_mm = [1.0, -2.0, 3.0]
        yaw_deg = 90.0
        reference = "platform_point"
        [force.path_frame]
        radial_force_N = 215.0
        tangential_force_N = -10.0
        axial_force_N = -25.0
        law = "rotated"
        [[chain_error]]
        chain = "y"
        end_translation_mm = [0.1, 0.2, 0.3]
        [sampling]
        chordal_tolerance_mm = 0.01
        [limits]
        max_correction_mm = 1.5
        max_correction_change_mm = 0.1
        force_limit_N = 400.0
        objective = "worst"
        [compensate]
        target = "platform_point"
        corner_mm = 0.5
        [gcode]
        g54_mm = [10.0, 20.0, 30.0]
        g59_mm = [-1.0, 0.0, 0.0]
        decimals_mm = 6
        write_tolerance_mm = 0.01
        helical_arcs = false
        "#,
    );
    assert_eq!(process.placement.origin_mm, Vector3::new(1.0, -2.0, 3.0));
    assert_eq!(process.placement.roll_pitch_yaw.z, std::f64::consts::FRAC_PI_2);
    assert_eq!(process.placement.reference, PathReference::PlatformPoint);
    let force = MillingForce { law: ForceLaw::Rotated, ..MillingForce::KLIMCHIK_GROOVE };
    assert_eq!(process.cutting, CuttingLaw::PathFrame(PathFrame { force }));
    assert_eq!(process.errors[0], Default::default());
    assert_eq!(process.errors[1].end.linear, Vector3::new(0.1, 0.2, 0.3));
    assert_eq!(process.sampling, Sampling::new(0.01, 1.0).unwrap());
    let limits = CorrectionLimits {
        correction_mm: Some(1.5),
        correction_change_mm: Some(0.1),
        force_N: Some(400.0),
        objective: ErrorNorm::Worst,
        unloaded_gouge_mm: None,
    };
    assert_eq!(process.limits, limits);
    assert_eq!(process.target, Target::PlatformPoint);
    assert_eq!((process.corner_mm, process.write_tolerance_mm, process.helical_arcs), (0.5, 0.01, false));
    let offsets: Vec<(String, Vector3<f64>)> =
        process.gcode.work_offsets_mm.iter().map(|(offset, zero)| (offset.to_string(), *zero)).collect();
    let expected = [("G54", [10.0, 20.0, 30.0]), ("G59", [-1.0, 0.0, 0.0])];
    assert_eq!(offsets, expected.map(|(name, zero)| (name.to_string(), Vector3::from(zero))));
    assert_eq!(process.decimals.format(NumberFormat::new(3, 5).unwrap()), NumberFormat::new(6, 5));
}

#[test]
fn programs_are_written_closer_where_the_tolerance_is_small() {
    for (tolerance, written) in [("0.005", 0.0005), ("0.02", 0.002), ("0.5", 0.005)] {
        assert_eq!(process(&format!("tolerance_mm = {tolerance}")).write_tolerance_mm, written, "{tolerance}");
    }
    let given = "tolerance_mm = 0.005\n[gcode]\nwrite_tolerance_mm = 0.0";
    assert_eq!(process(given).write_tolerance_mm, 0.0);
}

#[test]
fn slot_milling_keeps_each_coefficient_in_its_place() {
    let process = process(
        r#"
        [force.slot_milling]
        tangential_cutting_N_per_mm2 = 800.0
        radial_cutting_N_per_mm2 = 300.0
        axial_cutting_N_per_mm2 = -150.0
        tangential_edge_N_per_mm = 10.0
        radial_edge_N_per_mm = 8.0
        axial_depth_mm = 2.0
        teeth = 3
        spindle = "counter_clockwise"
        "#,
    );
    let milling = SlotMilling {
        tangential: EdgeForce { cutting: 800.0, edge: 10.0 },
        radial: EdgeForce { cutting: 300.0, edge: 8.0 },
        axial: EdgeForce { cutting: -150.0, edge: 0.0 },
        depth_mm: 2.0,
        teeth: 3,
        feed_per_tooth_mm: None,
        spindle: TurnDirection::CounterClockwise,
    };
    assert_eq!(process.cutting, CuttingLaw::SlotMilling(milling));
}

#[test]
fn end_milling_takes_its_coefficients_from_a_table_kienzle_or_a_material() {
    let milling = |keys: &str| {
        let tables =
            "[force.end_milling]\ndiameter_mm = 10.0\nteeth = 4\naxial_depth_mm = 5.0\nradial_width_mm = 2.5\n";
        let process = process(&format!("{tables}{keys}"));
        let CuttingLaw::EndMilling(milling) = process.cutting else { panic!("{:?}", process.cutting) };
        milling
    };
    let given = milling(
        "cut = \"down\"\nload = \"peak\"\nspindle = \"counter_clockwise\"\nfeed_per_tooth_mm = 0.05\n\
         coefficients = { tangential_cutting_N_per_mm2 = 800.0, radial_cutting_N_per_mm2 = 300.0, \
         axial_cutting_N_per_mm2 = -150.0, radial_edge_N_per_mm = 8.0 }\n",
    );
    let edge = EdgeLaw::Linear {
        tangential: EdgeForce { cutting: 800.0, edge: 0.0 },
        radial: EdgeForce { cutting: 300.0, edge: 8.0 },
        axial: EdgeForce { cutting: -150.0, edge: 0.0 },
    };
    let wanted = EndMilling {
        edge,
        diameter_mm: 10.0,
        teeth: 4,
        depth_mm: 5.0,
        width_mm: 2.5,
        direction: CutDirection::Down,
        feed_per_tooth_mm: Some(0.05),
        spindle: TurnDirection::CounterClockwise,
        over_turn: MeanOrPeak::Peak,
    };
    assert_eq!(given, wanted);
    assert!(given.force(0.05) == given.peak(0.05) && given.peak(0.05) != given.mean(0.05));
    let of_table = milling("cut = \"up\"\nmaterial = \"Al 7075-T6\"\n");
    let EdgeLaw::Linear { tangential, axial, .. } = of_table.edge else { panic!("{of_table:?}") };
    assert_eq!((tangential.cutting, tangential.edge, axial.cutting), (767.01, 27.7, -222.0));
    let kienzle = |exponent| EdgeLaw::Kienzle {
        tangential: Kienzle { specific_force: 2220.0, exponent },
        tangential_share: 1.0,
        radial_ratio: 0.4,
        axial_ratio: -0.1,
    };
    let ratios = "cut = \"up\"\nradial_ratio = 0.4\naxial_ratio = -0.1\n";
    assert_eq!(milling(&format!("{ratios}material = \"C45E\"\n")).edge, kienzle(0.14));
    let own = "kienzle = { specific_force_N_per_mm2 = 2220.0, exponent = 0.2 }\n";
    assert_eq!(milling(&format!("{ratios}{own}")).edge, kienzle(0.2));
}

#[test]
fn a_cut_as_wide_as_the_cutter_needs_no_side() {
    let process = process(
        "[force.end_milling]\ndiameter_mm = 10.0\nteeth = 4\naxial_depth_mm = 5.0\nradial_width_mm = 10.0\n\
         material = \"Al 7075-T6\"\n",
    );
    let CuttingLaw::EndMilling(milling) = process.cutting else { panic!("{:?}", process.cutting) };
    assert_eq!((milling.arc().entry, milling.arc().exit), (0.0, std::f64::consts::PI));
}

#[test]
fn drilling_takes_its_law_from_kienzle_a_constant_or_a_material() {
    let law = |keys: &str| {
        let process = process(&format!("[force.drilling]\ndiameter_mm = 8.0\n{keys}\n"));
        let CuttingLaw::Drilling(drilling) = process.cutting else { panic!("{:?}", process.cutting) };
        drilling.law
    };
    assert_eq!(law("material_constant = 1.5"), DrillingLaw::MaterialConstant(1.5));
    assert_eq!(law("material = \"SCM440 269 HB\""), DrillingLaw::MaterialConstant(2.41));
    let lip = Kienzle { specific_force: 2220.0, exponent: 0.14 };
    let DrillingLaw::Kienzle { lip: found, point_angle, thrust_ratio } = law("material = \"C45E\"") else { panic!() };
    assert_eq!((found, thrust_ratio), (lip, 0.5));
    assert!((point_angle - 118f64.to_radians()).abs() < 1e-15);
    let given = law(
        "kienzle = { specific_force_N_per_mm2 = 2220.0, exponent = 0.14 }\npoint_angle_deg = 140.0\nthrust_ratio = 0.7",
    );
    let DrillingLaw::Kienzle { point_angle, thrust_ratio, .. } = given else { panic!() };
    assert!((point_angle - 140f64.to_radians()).abs() < 1e-15 && thrust_ratio == 0.7);
}

#[test]
fn a_table_is_read_from_the_folder_and_is_part_of_the_inputs() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("process.toml");
    fs::write(&file, "schema = 1\nforce.table.file = \"wrench.csv\"\n").unwrap();
    let rows = "0,1,2,3,4,5,6\n9,1,2,3,4,5,6\n";
    fs::write(folder.path().join("wrench.csv"), format!("{COLUMNS}\n{rows}")).unwrap();
    let process = Process::open(&file, &orthoglide()).unwrap();
    let CuttingLaw::Table(table) = &process.cutting else { panic!("{:?}", process.cutting) };
    assert_eq!(table.range_mm(), (0.0, 9.0));
    let text = "schema = 1\nforce.table.file = \"wrench.csv\"\n";
    let table = Inputs::of("wrench.csv", format!("{COLUMNS}\n{rows}"));
    assert_eq!(process.inputs, Inputs::of("process.toml", text).and(table));
    assert_eq!(self::process("force.from_path = true").cutting, CuttingLaw::FromPath);
}

/// Reads `source`; a table that is one answers within its range and refuses lengths outside.
fn exercise(source: &[u8]) -> Result<(), TestCaseError> {
    let Ok(table) = WrenchTable::read(source, "any.csv") else {
        return Ok(());
    };
    let (from, to) = table.range_mm();
    for length in [from, 0.5 * (from + to), to] {
        let load = table.load(length).unwrap();
        prop_assert!(load.force_N.iter().chain(&load.moment_Nmm).all(|value| value.is_finite()));
    }
    for length in [from - 1.0, to + 1.0, f64::NAN, f64::INFINITY] {
        // Beside 1e12 a step of 1 is still one.
        prop_assert!(table.load(length).is_err());
    }
    Ok(())
}

proptest! {
    #![proptest_config(cases(64))]

    #[test]
    fn no_bytes_panic(source in prop::collection::vec(any::<u8>(), 0..400)) {
        exercise(&source)?;
        exercise(&[COLUMNS.as_bytes(), b"\n", &source].concat())?;
    }

    #[test]
    fn nothing_like_a_table_panics(rows in "([-0-9.eE,\"naif \r\n]{0,12},?){0,40}") {
        exercise(format!("{COLUMNS}\n{rows}").as_bytes())?;
    }

    #[test]
    fn tables_are_read(rows in prop::collection::vec((0.0..1e3f64, prop::array::uniform6(-1e9..1e9f64)), 2..20)) {
        let mut length = 0.0;
        let mut source = format!("{COLUMNS}\n");
        for (step, [a, b, c, d, e, f]) in &rows {
            length += step + 1e-6;
            source += &format!("{length},{a},{b},{c},{d},{e},{f}\n");
        }
        prop_assert!(WrenchTable::read(source.as_bytes(), "any.csv").is_ok());
        exercise(source.as_bytes())?;
    }
}
