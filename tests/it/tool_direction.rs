//! G-code of three axes is for a tool along the normal of its plane: a machine whose tool stands otherwise is another set-up.

use kinetostat::{input::Folder, machine::Machine, process::file::Process};

use crate::support::engine::machine_from;

/// A gantry whose tool points along `axis` of O, from the spindle to its tip.
fn gantry(axis: [f64; 3]) -> Machine {
    let slide = |name: &str| {
        format!(
            "{{ prismatic_drive = {{ name = \"{name}\", axis = \"{}\", stiffness_N_per_mm = 5e3 }} }}",
            name.to_lowercase()
        )
    };
    machine_from(&format!(
        "schema = 1\nname = \"gantry\"\ntitle = \"Gantry\"\n[home]\nposition_mm = [0.0, 0.0, 0.0]\n\
         [platform]\ncontrols = [\"x\", \"y\", \"z\"]\ntool_tip_mm = {:?}\ntool_axis = {axis:?}\n\
         [workspace]\nmin_mm = [-200.0, -200.0, -200.0]\nmax_mm = [200.0, 200.0, 200.0]\n\
         [[chain]]\nname = \"g\"\nelements = [{}, {}, {}]\n[[mount]]\nname = \"m\"\nchain = \"g\"\n",
        axis.map(|part| 100.0 * part),
        slide("X"),
        slide("Y"),
        slide("Z")
    ))
}

fn read(machine: &Machine, placement: &str, gcode: &str, program: &str) -> Result<(), String> {
    let text = format!("schema = 1\n[placement]\norigin_mm = [0.0, 0.0, 0.0]\n{placement}[gcode]\n{gcode}");
    let process = Process::from_toml(&text, "p.toml", Folder::in_memory([]), machine).map_err(|why| why.to_string())?;
    let folder = Folder::in_memory([("part.nc".into(), program.as_bytes().to_vec())]);
    process.program_in_folder(&folder, "part.nc").map(drop).map_err(|why| why.to_string())
}

const XY: &str = "G21 G90 G17\nG0 X0 Y0 Z20\nG1 Z0 F500\nG2 X20 Y0 I10 J0\nM30\n";
const ZX: &str = "G21 G90 G18\nG0 X0 Y0 Z20\nG1 Z0 F500\nG2 X20 Z0 I10 K0\nM30\n";
const BOTH: &str = "G21 G90 G17\nG0 X0 Y0 Z20\nG1 Z0 F500\nG18 G2 X20 Z0 I10 K0\nM30\n";

/// A direction that leans by so many degrees from −z towards x.
fn leaning(degrees: f64) -> [f64; 3] {
    let (sin, cos) = f64::to_radians(degrees).sin_cos();
    [sin, 0.0, -cos]
}

#[test]
fn a_tool_that_lies_is_refused_with_both_directions_and_the_key() {
    let (down, up, lies, across) = ([0.0, 0.0, -1.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    for (axis, program) in [(down, XY), (down, ZX), (down, BOTH), (up, XY), (across, ZX), (leaning(44.0), XY)] {
        read(&gantry(axis), "", "", program).unwrap_or_else(|why| panic!("{axis:?} {program}: {why}"));
    }
    for (axis, program, angle, meant) in [
        (lies, XY, "90.0", "z (G17)"),
        (lies, ZX, "90.0", "y (G18) or z (G17)"),
        (across, BOTH, "90.0", "z (G17)"),
        (leaning(60.0), XY, "60.0", "z (G17)"),
    ] {
        let refused = read(&gantry(axis), "", "", program).unwrap_err();
        let [x, y, z] = axis.map(|part: f64| (-part * 1e4).round() / 1e4 + 0.0);
        for words in [
            format!("part.nc: is for a tool along {meant} of W, and the tool of machine gantry"),
            format!("stands along ({x}, {y}, {z}) there, {angle} degrees from it"),
            format!("tool_axis = [{x:?}, {y:?}, {z:?}] in [gcode]"),
        ] {
            assert!(refused.contains(&words), "{words}: {refused}");
        }
    }
}

#[test]
fn a_direction_that_the_process_gives_is_that_of_the_machine() {
    let (lies, keys) = (gantry([1.0, 0.0, 0.0]), "tool_axis = [-2.0, 0.0, 0.0]\n");
    read(&lies, "", keys, XY).unwrap();
    // Yaw turns the part under the tool: what lay along −x of W now lies along y.
    let refused = read(&lies, "yaw_deg = 90.0\n", keys, XY).unwrap_err();
    assert!(refused.contains("along (0, 1, 0) of W, 90.0 degrees from it"), "{refused}");
    let refused = read(&lies, "", "tool_axis = [1.0, 0.0, 0.0]\n", XY).unwrap_err();
    assert!(refused.contains("180.0 degrees from it: expected the same direction"), "{refused}");
    let refused = read(&lies, "", "tool_axis = [0.0, 0.0, 0.0]\n", XY).unwrap_err();
    assert!(
        refused.contains("p.toml") && refused.contains("gcode.tool_axis") && refused.contains("no length"),
        "{refused}"
    );
}
