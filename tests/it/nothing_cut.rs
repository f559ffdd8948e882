//! Programs in which no motion counts as cutting: the first line says so, and the exit code is 1.

use crate::support::command::told;

const REST: &str = "[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]";

fn rapid(motion: &str) -> String {
    format!(
        "MODULE m\nPERS tooldata t:=[TRUE,[[0,0,150],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];\nPROC main()\n\
         MoveJ [[-150,0,0],[0,0,1,0],{REST}],v100,fine,t;\n{motion} [[0,0,0],[0,0,1,0],{REST}],v100,fine,t;\nENDPROC\nENDMODULE\n"
    )
}

/// A listing of FANUC with these motions between two positions.
fn listing(motion: &str) -> String {
    let position = |number: u32, x: &str| {
        format!(
            "P[{number}]{{\n   GP1:\n\tUF : 0, UT : 1,\t\tCONFIG : 'N U T, 0, 0, 0',\n\tX = {x} mm, Y = 0.0 mm, Z = 0.0 mm,\n\
             \tW = 0.0 deg, P = 180.0 deg, R = 0.0 deg\n}};\n"
        )
    };
    format!(
        "/PROG J\n/MN\n   1:  J P[1] 100% FINE    ;\n   2:  {motion}    ;\n/POS\n{}{}/END\n",
        position(1, "-150.0"),
        position(2, "0.0")
    )
}

/// Compensates `program` under a constant force, with `more` in the process; exit code, what was printed, and what was written is the same.
fn answer(name: &str, program: &str, more: &str) -> (Option<i32>, String, bool) {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let is_robot = ["mod", "src", "script", "ls"].iter().any(|end| name.ends_with(end));
    let (machine, origin) =
        if is_robot { ("ur10e", "[700.0, 0.0, 300.0]") } else { ("orthoglide", "[0.0, 0.0, 100.0]") };
    std::fs::write(at(name), program).unwrap();
    // Data of other makers for an arm without the usual wrist.
    let more = if is_robot { format!("[robot_program]\nignore_configuration = true\n{more}") } else { more.to_owned() };
    let process = format!(
        "schema = 1\n[placement]\norigin_mm = {origin}\n[force.path_frame]\nradial_force_N = 50.0\ntangential_force_N = -10.0\naxial_force_N = \
         -5.0\n{more}"
    );
    std::fs::write(at("process.toml"), process).unwrap();
    let out = at(&format!("out_{name}"));
    let (code, printed, _) =
        told(&["compensate", &at(name), "--machine", machine, "--process", &at("process.toml"), "--out", &out]);
    let report: serde_json::Value =
        serde_json::from_slice(&std::fs::read(format!("{out}.report.json")).unwrap()).unwrap();
    assert_eq!(report["cuts_nowhere"], code == Some(1), "{name}");
    (code, printed.split_whitespace().collect::<Vec<_>>().join(" "), std::fs::read_to_string(out).unwrap() == program)
}

#[test]
fn a_program_that_cuts_nowhere_says_so_first() {
    let iso = "G21 G90 G17\nG0 X0 Y0 Z0\nG0 X10\nG0 Y10\nM30\n";
    let klartext = "BEGIN PGM P MM\nTOOL CALL 1 Z S900\nL X+0 Y+0 Z+0 R0 FMAX\nL X+10 R0 FMAX\nEND PGM P MM\n";
    for (name, program, which) in [
        ("p.nc", iso.to_owned(), "G1, G2, G3 and cycles"),
        ("p.mpf", iso.replace("G21", "G710"), "G1, G2, G3 and cycles"),
        ("p.h", klartext.to_owned(), "L, C and CR at feed"),
        ("p.apt", "UNITS/MM\nRAPID\nGOTO/0,0,0\nRAPID\nGOTO/10,0,0\nFINI\n".to_owned(), "motions without RAPID"),
        ("p.csv", "x_mm,y_mm,z_mm,cutting\n0,0,0,0\n10,0,0,0\n".to_owned(), "points marked as cutting"),
        ("p.mod", rapid("MoveJ"), "MoveL and MoveC"),
        (
            "p.src",
            "DEF p()\n$TOOL={X 0,Y 0,Z 150,A 0,B 0,C 0}\n$BASE=$NULLFRAME\nPTP {X -150,Y 0,Z 0,A 0,B 180,C 0}\nPTP {X 0,Y 0,Z 0,A 0,B 180,C 0}\nEND\n"
                .to_owned(),
            "LIN, CIRC and splines",
        ),
        (
            "p.script",
            "def p():\n  set_tcp(p[0,0,0.15,0,0,0])\n  movej(p[-0.15,0,0,0,3.14159,0])\n  movej(p[0,0,0,0,3.14159,0])\nend\n".to_owned(),
            "movel, movep and movec",
        ),
        ("p.ls", listing("J P[2] 100% FINE"), "L and C"),
    ] {
        let (code, printed, is_same) = answer(name, &program, "");
        assert_eq!(code, Some(1), "{name}: {printed}");
        assert!(printed.starts_with(&format!("✗ Nothing was corrected: only {which} cut ")), "{name}: {printed}");
        assert!(printed.contains(&format!("No motion of {name} counts as cutting, so nothing was corrected.")), "{printed}");
        assert!(is_same || name == "p.csv", "{name}");
    }
    // One motion that cuts is enough.
    for (name, program) in [
        ("p.nc", iso.replace("G0 Y10", "G1 Y10 F100")),
        ("p.mod", rapid("MoveL")),
        ("p.ls", listing("L P[2] 100mm/sec FINE")),
    ] {
        let (code, printed, _) = answer(name, &program, "");
        assert_eq!(code, Some(0), "{name}: {printed}");
    }
}

#[test]
fn a_program_without_cut_is_said_to_be_corrected_for_the_rest_alone() {
    let errors = "[[chain_error]]\nchain = \"x\"\nturn_about_drive_axis_deg = 1.0\n";
    let (code, printed, is_same) = answer("p.nc", "G21 G90 G17\nG0 X0 Y0 Z0\nG0 X10\nM30\n", errors);
    assert_eq!(code, Some(1));
    assert!(printed.starts_with("✗ Corrected without a cutting force: only G1, G2, G3 and cycles cut "), "{printed}");
    assert!(printed.contains("so it was corrected for what acts without a cutting force alone"), "{printed}");
    assert!(!is_same);
}
