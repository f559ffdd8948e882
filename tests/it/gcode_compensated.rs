//! G-code that is written out and compensated by the program: cutter radius compensation, and five axes.

use kinetostat::toolpath::{
    Sampling,
    gcode::{GcodeOptions, GcodeProgram},
};

use crate::support::command::{printed, told};

#[test]
fn compensation_writes_the_centre_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let program = "G21 G90 G17\nG0 X0 Y-20 Z0\nG42 G1 X0 Y0 D1 F200\nX40\nY20\nX60\nG40 G1 X60 Y0\nM30\n";
    write("step.nc", program);
    write(
        "process.toml",
        "schema = 1\nplacement.origin_mm = [0.0, 0.0, 0.0]\n[force.path_frame]\nradial_force_N = 50.0\ntangential_force_N = 80.0\naxial_force_N = -20.0\n\
         [gcode]\ncutter_compensation = \"off\"\ncutter_radius_mm = { D1 = 5.0 }\n",
    );
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (source, process, out) = (path("step.nc"), path("process.toml"), path("out.nc"));
    let said = printed(&["compensate", &source, "--machine", "orthoglide", "--process", &process, "--out", &out]);
    let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(said.contains("the lines are the path of the tool centre, for radii of D1 = 5.000 mm."), "{said}");
    let report = std::fs::read_to_string(path("out.nc.report.json")).unwrap();
    let found: serde_json::Value = serde_json::from_str(&report).unwrap();
    assert_eq!(found["cutter_radii_written_out_mm"], serde_json::json!({ "D1": 5.0 }));
    let out = std::fs::read_to_string(out).unwrap();
    assert!(!out.contains("G42") && out.contains("G3 "), "{out}");
    // Corrections are some hundredths of a millimetre: the path is that of the centre.
    let options = GcodeOptions::default();
    let corrected = GcodeProgram::parse(out, "out.nc", &options).unwrap().toolpath(Sampling::default()).unwrap();
    let beside = corrected.points().iter().filter(|point| (point.position_mm.x - 20.0).abs() < 5.0);
    let heights: Vec<f64> = beside.map(|point| point.position_mm.y).collect();
    assert!(!heights.is_empty() && heights.iter().all(|y| (y + 5.0).abs() < 0.5), "{heights:?}");
}

#[test]
fn a_five_axis_program_is_compensated_on_an_arm_and_a_hexapod() {
    // The tool of the hexapod points up at home: its workpiece hangs above it.
    for (machine, place_of_part) in
        [("kr270", "origin_mm = [1700.0, 0.0, 560.0]"), ("hexapod", "origin_mm = [0.0, 0.0, 900.0]\nroll_deg = 180.0")]
    {
        let folder = tempfile::tempdir().unwrap();
        let place = |name: &str| folder.path().join(name).display().to_string();
        let program = "G21 G90 G17\nG43.4 H1\nG0 X0 Y0 Z0 A0 C0\nG1 X20 A8 F600\nG3 X20 Y20 I0 J10 A-4 C20\nG1 X0 Y20 A0 C0\nM30\n";
        std::fs::write(place("part.nc"), program).unwrap();
        let process = format!(
            "schema = 1\n[placement]\n{place_of_part}\n[[gcode.rotary]]\nletter = \"C\"\nabout = [0.0, 0.0, 1.0]\nturns = \"tool\"\n\
             [[gcode.rotary]]\nletter = \"A\"\nabout = [1.0, 0.0, 0.0]\nturns = \"tool\"\n"
        );
        std::fs::write(place("free.toml"), &process).unwrap();
        let force = "[force.path_frame]\nlaw = \"rotated\"\nradial_force_N = 300.0\ntangential_force_N = -200.0\naxial_force_N = -100.0\n";
        std::fs::write(place("cut.toml"), process + force).unwrap();
        let run = |process: &str, out: &str| {
            let arguments = ["compensate", &place("part.nc"), "--machine", machine, "--process", &place(process)];
            told(&[&arguments[..], &["--out", &place(out), "--quiet"]].concat())
        };
        let (code, text, said) = run("free.toml", "same.nc");
        assert_eq!(code, Some(0), "{machine}: {text}{said}");
        assert_eq!(std::fs::read_to_string(place("same.nc")).unwrap(), program);
        let (code, text, said) = run("cut.toml", "out.nc");
        assert_eq!(code, Some(0), "{machine}: {text}{said}");
        let report = std::fs::read_to_string(place("out.nc.report.json")).unwrap();
        let report: serde_json::Value = serde_json::from_str(&report).unwrap();
        let passes = report["passes"].as_array().unwrap();
        let left = |pass: &serde_json::Value| pass["error_max_mm"].as_f64().unwrap();
        assert!(left(&passes[0]) > 0.03 && left(passes.last().unwrap()) < 0.006, "{report:#}");
    }
}
