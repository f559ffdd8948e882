//! Spline motions of KRL on a loaded arm: corrected as lines and circles are, and what is not verified of them.

use kinetostat::process::Process;

use crate::robot_compensated::{compensated, process};

/// Positions in the braces of a text, mm; what is left out stays.
fn written_points(text: &str) -> Vec<(String, [f64; 3])> {
    let mut here = [0.0; 3];
    let mut found = Vec::new();
    for line in text.lines().filter(|line| line.contains('{') && !line.contains("DECL")) {
        let word = line.split_whitespace().next().unwrap().to_owned();
        let last = line.rsplit_once('{').unwrap().1;
        for part in last.split('}').next().unwrap().split(',') {
            let (name, number) = part.trim().split_once(' ').unwrap();
            if let Some(axis) = ["X", "Y", "Z"].iter().position(|axis| *axis == name) {
                here[axis] = number.trim().parse().unwrap();
            }
        }
        found.push((word, here));
    }
    found
}

fn written(process: Process, source: &str) -> String {
    String::from_utf8(compensated(process, &[("part.src", source)]).1.bytes).unwrap()
}

/// The same lines and circles by LIN and CIRC give the same numbers; points of SPL those of LIN that arrive along the same tangent.
#[test]
fn splines_on_a_loaded_arm_are_corrected_as_lines_and_circles_are() {
    let head = "DEF part()\nPTP {X 0.000,Y 0.000,Z 30.000,A -90,B 0,C -90}\n$VEL.CP=0.02\n";
    let lines = "LIN {X 0.000,Y 0.000,Z 0.000}\nLIN {X 60.000,Y 0.000,Z 0.000}\nLIN {X 60.000,Y 40.000,Z 0.000}\nCIRC {X 45.000,Y 55.000,Z \
                 0.000},{X 30.000,Y 40.000,Z 0.000}\nLIN {X 0.000,Y 40.000,Z 0.000}\n";
    let as_splines = |text: &str| text.replace("LIN", "SLIN").replace("CIRC", "SCIRC").replace(" C_DIS", " C_SPL");
    let plain = as_splines(&written(process(""), &format!("{head}{lines}END\n")));
    assert!(plain.contains(" C_SPL"), "{plain}");
    assert_eq!(written(process(""), &format!("{head}{}END\n", as_splines(lines))), plain);
    // In a block, with the same points and without approximation.
    let block = format!("{head}SPLINE\n{}ENDSPLINE\nEND\n", as_splines(lines));
    let in_block = written(process(""), &block);
    assert_eq!(written_points(&in_block), written_points(&plain));
    assert!(!in_block.contains("C_"), "{in_block}");
    // Curves: (80, 0) is reached along a line, (100, 10) halfway between its two chords, (110, 30) along the line behind it.
    let loose = "[gcode]\nwrite_tolerance_mm = 5.0\n";
    let curve = format!(
        "{head}SPLINE\nSLIN {{X 0.000,Y 0.000,Z 0.000}}\nSLIN {{X 60.000,Y 0.000,Z 0.000}}\nSPL {{X 80.000,Y 0.000,Z 0.000}}\nSPL {{X 100.000,Y 0.000,Z 0.000}}\nSPL {{X 116.000,Y \
         12.000,Z 0.000}}\nSPL {{X 120.000,Y 30.000,Z 0.000}}\nSLIN {{X 120.000,Y 50.000,Z 0.000}}\nENDSPLINE\nEND\n"
    );
    let found = written_points(&written(process(loose), &curve));
    assert_eq!(found.iter().filter(|(word, _)| word == "SPL").count(), 4);
    let unit = |x: f64, y: f64| [x / x.hypot(y), y / x.hypot(y)];
    let mean = |a: [f64; 2], b: [f64; 2]| unit(a[0] + b[0], a[1] + b[1]);
    let (to_third, to_fourth) = (unit(16.0, 12.0), unit(4.0, 18.0));
    for (k, at, tangent) in [
        (2, [60.0, 0.0], [1.0, 0.0]),
        (3, [80.0, 0.0], [1.0, 0.0]),
        (4, [100.0, 0.0], mean([1.0, 0.0], to_third)),
        (5, [116.0, 12.0], mean(to_third, to_fourth)),
        (6, [120.0, 30.0], [0.0, 1.0]),
        (7, [120.0, 50.0], [0.0, 1.0]),
    ] {
        // A line of 20 mm along the tangent ends there.
        let [x, y] = [at[0] - 20.0 * tangent[0], at[1] - 20.0 * tangent[1]];
        let line =
            format!("{}PTP {{X {x:.9},Y {y:.9},Z 0}}\nLIN {{X {:.3},Y {:.3},Z 0.000}}\nEND\n", head, at[0], at[1]);
        let alone = written_points(&written(process(loose), &line));
        let ((_, spline), (_, line)) = (&found[k], alone.last().unwrap());
        let off = spline.iter().zip(line).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1.1e-3, "point {k}: {spline:?} {line:?}");
        let moved = (spline[0] - at[0]).hypot(spline[1] - at[1]);
        assert!(moved > 0.05, "point {k} moved by {moved}");
    }
}

#[test]
fn what_is_not_proved_of_splines_is_said() {
    let source = "DEF part()\nPTP {X 0.0,Y 0.0,Z 30.0,A -90,B 0,C -90}\n$VEL.CP=0.02\nSPLINE\nSLIN {X 0.0,Y 0.0,Z 0.0}\nSPL {X 20.0}\nSPL {X 40.0,Y \
                  5.0}\nENDSPLINE\nEND\n";
    let (job, as_written) = compensated(process(""), &[("part.src", source)]);
    let notes = kinetostat::products::program::report::notes_text(&job, &as_written.calls);
    assert!(
        notes.contains("Corrected at their points alone, as segments of splines (SPL): 2 motions, lines 6 and 7. How the controller"),
        "{notes}"
    );
}
