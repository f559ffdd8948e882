//! The machined surface against the part of the drawing: closed forms of shoulders and bosses, in any frame, tolerances of tools, and what is no part.

use crate::stock::{binary_stl, box_triangles, job_beside};
use kinetostat::{
    Machine, Work,
    compensation::Method,
    files::Foreign,
    input::Folder,
    process::Process,
    products::program::{
        CompensateOptions,
        files::{ProgramFiles, ProgramOutcome, compensate_into},
    },
};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde_json::Value;

type Triangles = Vec<[[f64; 3]; 3]>;

/// A shoulder on the side of the blank at larger y, as wide as y is below 5, 5 mm deep, along x; the tool comes from below.
const LINE: &str = "G21 G90\nS8000 M3\nG0 X-30 Y0 Z-10\nG1 Z0 F2400\nX30\nG0 Z-10\n";
const PROCESS: &str = "tolerance_mm = 0.05\n[placement]\norigin_mm = [0.0, 0.0, 100.0]\n[force.end_milling]\nmaterial = \"Al 7075-T6\"\n[stock]\n\
                       mesh = \"blank.stl\"\npart = \"part.stl\"\n[tools.1]\ndiameter_mm = 10.0\nteeth = 4\n";
const BLANK: [[f64; 3]; 2] = [[-20.0, 2.5, -5.0], [20.0, 30.0, 10.0]];

/// The blank with a shoulder whose wall and floor are at these y and z.
fn shoulder(wall: f64, floor: f64) -> Triangles {
    let outline = [(wall, -5.0), (30.0, -5.0), (30.0, 10.0), (2.5, 10.0), (2.5, floor), (wall, floor)];
    let at = |x: f64, k: usize| [x, outline[k % 6].0, outline[k % 6].1];
    let sides = (0..6).flat_map(|k| {
        let [a, b, c, d] = [at(-20.0, k), at(-20.0, k + 1), at(20.0, k + 1), at(20.0, k)];
        [[a, b, c], [a, c, d]]
    });
    let ends = [[0, 1, 5], [1, 2, 5], [2, 3, 5], [3, 4, 5]];
    let ends = ends.iter().flat_map(|[a, b, c]| {
        [[at(20.0, *a), at(20.0, *b), at(20.0, *c)], [at(-20.0, *a), at(-20.0, *c), at(-20.0, *b)]]
    });
    sides.chain(ends).collect()
}

/// A solid turned about z in facets, from its outline (r, z), up on its outside.
fn turned_solid(outline: &[(f64, f64)], facets: usize) -> Triangles {
    let at = |(r, z): (f64, f64), k: usize| {
        let angle = std::f64::consts::TAU * (k % facets) as f64 / facets as f64;
        [r * angle.cos(), r * angle.sin(), z]
    };
    let bands = outline.windows(2).flat_map(|ends| {
        (0..facets).flat_map(move |k| {
            let [a, b, c, d] = [at(ends[0], k), at(ends[0], k + 1), at(ends[1], k + 1), at(ends[1], k)];
            [[a, b, c], [a, c, d]]
        })
    });
    // Those on the axis have two equal corners.
    bands.filter(|[a, b, c]| a != b && b != c && c != a).collect()
}

fn turn(triangles: &[[[f64; 3]; 3]], degrees: f64) -> Triangles {
    let (sine, cosine) = degrees.to_radians().sin_cos();
    let turned = |[x, y, z]: [f64; 3]| [cosine * x - sine * y, sine * x + cosine * y, z];
    triangles.iter().map(|own| own.map(turned)).collect()
}

/// A corner of a face of the part file: position, deviation without compensation and as written, and the same against the part.
type Corner = [f64; 7];

struct Found {
    surface: Value,
    cautions: Vec<String>,
    faces: Vec<[Corner; 4]>,
    page: String,
}

/// Compensates a program that cuts a blank.
fn compensated(process: &str, program: &str, [blank, part]: [&Triangles; 2]) -> Found {
    let scratch = tempfile::tempdir().unwrap();
    let file = scratch.path().join("mill.toml");
    // A machine that does not rotate, so that walls are off as the tip is.
    std::fs::write(&file, crate::machined::MILL.replace("tool_axis = [0.0, 0.0, -1.0]", "tool_axis = [0.0, 0.0, 1.0]"))
        .unwrap();
    let machine = Machine::named_or_file(file.to_str().unwrap()).unwrap();
    let files = [("blank.stl", binary_stl(blank)), ("part.stl", binary_stl(part))];
    let job = job_beside(process, &machine, program, &files).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let files = ProgramFiles::prepare(&folder.path().join("out.nc"), Foreign::Kept).unwrap();
    let ProgramOutcome::Written(written) =
        compensate_into(job, &CompensateOptions::by(Method::Direct), &files, "part.nc", &Work::default()).unwrap()
    else {
        panic!("refused")
    };
    let read = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    let report: Value = serde_json::from_slice(&read("out.nc.report.json")).unwrap();
    let ply = read("out.nc.part.ply");
    let start = ply.windows(11).position(|own| own == b"end_header\n").unwrap() + 11;
    let header = String::from_utf8_lossy(&ply[..start]).to_string();
    let against = "property float against_part_without_compensation_mm\nproperty float against_part_as_written_mm\nproperty int line";
    assert!(header.contains(against), "{header}");
    let faces = header.lines().find_map(|line| line.strip_prefix("element face ")).unwrap().parse::<usize>().unwrap();
    assert_eq!(ply.len() - start, faces * (4 * 33 + 17));
    let float = |at: usize| f64::from(f32::from_le_bytes(ply[at..at + 4].try_into().unwrap()));
    let corner = |k: usize| std::array::from_fn(|own| float(start + 33 * k + 4 * own));
    let faces = (0..faces).map(|face| std::array::from_fn(|own| corner(4 * face + own))).collect();
    let page = String::from_utf8_lossy(&read("out.nc.html")).to_string();
    Found { surface: report["machined_surface"].clone(), cautions: written.headline.cautions, faces, page }
}

/// A program that goes 0.1 mm too deep and stays 0.2 mm away from the wall is told so, by its line, whatever way it is turned and placed; what the machine adds is added to that, at
/// each place of the wall and the floor.
#[test]
fn what_a_program_leaves_and_gouges_is_told_by_line() {
    let (blank, part) = (box_triangles(BLANK[0], BLANK[1], 0.0), shoulder(5.2, -0.1));
    for degrees in [0.0_f64, 37.0] {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let at = |x: f64| format!("X{:.5} Y{:.5}", x * cosine, x * sine);
        let program = LINE.replace("X-30 Y0", &at(-30.0)).replace("X30", &at(30.0));
        let process = match degrees {
            0.0 => PROCESS.into(),
            _ => PROCESS.replace("origin_mm = [0.0, 0.0, 100.0]", "origin_mm = [10.0, -20.0, 80.0]\nyaw_deg = 25.0"),
        };
        let found = compensated(&process, &program, [&turn(&blank, degrees), &turn(&part, degrees)]);
        let own = &found.surface["against_part"];
        for (side, what, exact) in [("as_programmed", "most_left", 0.2), ("as_programmed", "most_missing", 0.1)] {
            let (mm, line) = (&own[side][what]["mm"], &own[side][what]["line"]);
            assert!((mm.as_f64().unwrap() - exact).abs() < 1e-5 && line == 5, "{degrees}: {own:#}");
        }
        let written = |what: &str| own["as_written"][what]["mm"].as_f64().unwrap();
        assert!((written("most_left") - 0.2).abs() < 0.02 && (written("most_missing") - 0.1).abs() < 0.02, "{own:#}");
        assert_eq!(own["part"], "part.stl");
        let lines = own["worst_lines"].as_array().unwrap();
        assert!(lines.iter().all(|own| own["tolerance_mm"] == 0.05 && own["line"] == 5), "{own:#}");
        let signs: Vec<bool> = lines.iter().map(|own| own["mm"].as_f64().unwrap() > 0.0).collect();
        assert_eq!(signs, [true, false]);
        let gouge = &found.cautions[0];
        assert!(
            gouge.starts_with("The program as written gouges the part (part.stl) by 0.1") && gouge.contains("line 5"),
            "{gouge}"
        );
        assert!(found.page.contains("Lines out of tolerance against the part as written"));
        assert!(found.page.contains(">\u{2212}0.1000 mm<"), "as programmed in the table");
        let mut checked = [0; 2];
        for face in &found.faces {
            let middle: [f64; 7] = std::array::from_fn(|own| face.iter().map(|corner| corner[own]).sum::<f64>() / 4.0);
            let [x, y, z, deviations @ ..] = middle;
            let [x, y] = [cosine * x + sine * y, cosine * y - sine * x];
            // Nearer to a corner another side of the part is nearest.
            let is_floor = (z - 0.0).abs() < 1e-3 && (3.2..4.0).contains(&y);
            let is_wall = (y - 5.0).abs() < 1e-3 && (-4.0..-2.0).contains(&z);
            if x.abs() > 19.0 || !(is_floor || is_wall) {
                continue;
            }
            checked[usize::from(is_wall)] += 1;
            for course in 0..2 {
                let exact = deviations[course] + if is_wall { 0.2 } else { -0.1 };
                let near = deviations[course + 2];
                assert!((near - exact).abs() < 2e-4, "{degrees}: {exact} {near} at ({x}, {y}, {z})");
            }
        }
        assert!(checked.into_iter().all(|count| count > 100), "{checked:?}");
    }
}

/// A boss that is turned exactly has left on its drawing in facets what chords are inside of the circle, at their middles.
#[test]
fn chords_of_the_drawing_are_in_the_distance() {
    let blank = turned_solid(&[(0.0, -5.0), (13.0, -5.0), (13.0, 10.0), (0.0, 10.0)], 24);
    let part = turned_solid(&[(0.0, -5.0), (10.0, -5.0), (10.0, 0.0), (13.0, 0.0), (13.0, 10.0), (0.0, 10.0)], 24);
    let program = "G21 G90\nS8000 M3\nG0 X-25 Y0 Z-10\nG1 Z0 F2400\nX-15\nG2 X-15 Y0 I15 J0\nG0 X-25\nG0 Z-10\n";
    let found = compensated(PROCESS, program, [&blank, &part]);
    let own = &found.surface["against_part"]["as_programmed"];
    let of = |what: &str| own[what]["mm"].as_f64().unwrap();
    let sagitta = 10.0 * (1.0 - (std::f64::consts::PI / 24.0).cos());
    assert!((of("most_left") - sagitta).abs() < 0.006, "{sagitta} {own:#}");
    assert!(of("most_missing") < 0.006, "{own:#}");
    assert_eq!(own["most_left"]["line"], 6);
}

/// A tool is held to its own tolerance, and to that of the process where it has none; without that, only what has one is judged.
#[test]
fn each_tool_has_its_tolerance() {
    let blank = box_triangles(BLANK[0], BLANK[1], 0.0);
    let part = box_triangles(BLANK[0], [20.0, 30.0, 10.0], 0.0);
    let other = "T2 M6\nG0 X-30 Y32.5\nG1 Z0 F2400\nX30\nG0 Z-10\n";
    let program = LINE.replace("G0 X-30", "T1 M6\nG0 X-30") + other;
    for (tolerance, first, judged) in [("tolerance_mm = 1e-9\n", 0.0, 2), ("", 0.0, 1)] {
        let process = PROCESS.replace("tolerance_mm = 0.05\n", tolerance).replace("part = \"part.stl\"\n", "");
        let process = process + "[tools.2]\ndiameter_mm = 10.0\nteeth = 4\ntolerance_mm = 20.0\n";
        let machine = Machine::named("orthoglide").unwrap();
        let job = job_beside(&process, &machine, &program, &[("blank.stl", binary_stl(&blank))]).unwrap();
        assert_eq!(job.process.tolerance_mm.is_some(), judged == 2);
        let found =
            compensated(&process.replace("[tools.1]", "part = \"part.stl\"\n[tools.1]"), &program, [&blank, &part]);
        let tools = found.surface["by_tool"].as_array().unwrap();
        assert_eq!(tools.iter().map(|own| own["tool"].as_u64()).collect::<Vec<_>>(), [Some(1), Some(2)]);
        let area = |own: &Value| own["as_written"]["area_mm2"].as_f64().unwrap();
        let within = |own: &Value| own["as_written"]["area_within_tolerance_mm2"].as_f64();
        // Wall and floor of each shoulder.
        assert!(tools.iter().all(|own| (area(own) - 40.0 * 7.5).abs() < 4.0), "{tools:?}");
        assert_eq!(within(&tools[0]), (judged == 2).then_some(first));
        assert_eq!(within(&tools[1]), Some(area(&tools[1])));
        assert!((within(&found.surface).unwrap() - area(&tools[1])).abs() < 1e-9);
        let share = if judged == 2 { "50 %" } else { "100 %" };
        let words = format!(
            "{share} of {} is within the tolerance of the tool that made it",
            if judged == 2 { "the machined surface" } else { "what has a tolerance" }
        );
        assert!(found.cautions.iter().any(|own| own.contains(&words)), "{:?}", found.cautions);
        assert!(found.page.contains("What each tool made last, against the part (part.stl)"));
    }
}

/// A program of another part, or frame, comes nowhere near; it gouges nothing.
#[test]
fn a_program_that_is_nowhere_near_its_part_is_told() {
    let blank = box_triangles(BLANK[0], BLANK[1], 0.0);
    let found = compensated(PROCESS, LINE, [&blank, &shoulder(7.5, 2.0)]);
    let near = "The program comes no nearer to the part than 2.00 mm: is the part in the frame of the program?";
    assert!(found.cautions.iter().any(|own| own == near), "{:?}", found.cautions);
    assert!(found.cautions.iter().all(|own| !own.contains("gouges")), "{:?}", found.cautions);
}

/// Stock above the part that no move reaches is told with its height, area and place, and so far only; what is beside the part as seen from the spindle counts as well.
#[test]
fn what_no_move_reaches_above_the_part_is_told() {
    let blank = box_triangles(BLANK[0], BLANK[1], 0.0);
    let none = compensated(PROCESS, LINE, [&blank, &shoulder(5.0, 0.0)]);
    assert!(none.surface["against_part"]["not_reached"].is_null(), "{:#}", none.surface["against_part"]);
    // The part is 1 mm below the top of the stock, which is to the spindle at −z.
    let outline = |triangles: Triangles| -> Triangles {
        triangles.into_iter().map(|own| own.map(|[x, y, z]| [x, y, if z < -4.5 { -4.0 } else { z }])).collect()
    };
    let found = compensated(PROCESS, LINE, [&blank, &outline(shoulder(5.0, 0.0))]);
    let own = &found.surface["against_part"]["not_reached"];
    let (high, area) = (own["mm"].as_f64().unwrap(), own["area_mm2"].as_f64().unwrap());
    assert!((high - 1.0).abs() < 1e-4 && (area - 40.0 * 25.0).abs() < 10.0, "{own:#}");
    assert!((own["position_mm"][2].as_f64().unwrap() + 5.0).abs() < 1e-4, "{own:#}");
    assert!(
        found.cautions.iter().any(|own| own.starts_with("No move of the program reaches ")),
        "{:?}",
        found.cautions
    );
}

/// How far a place is outside of a stock is known near its corners, edges and hollows: against the distance from two boxes that it is made of.
#[test]
fn a_part_that_sticks_out_is_told_by_how_much() {
    let machine = Machine::named("orthoglide").unwrap();
    let stock = binary_stl(&shoulder(12.0, 3.0));
    let mut random = Xoshiro256PlusPlus::seed_from_u64(5);
    let mut refused = 0;
    for _ in 0..300 {
        let at = [[-24.0, 24.0], [-2.0, 34.0], [-9.0, 14.0]]
            .map(|[low, high]| f64::from(random.random_range(low..high) as f32));
        let [a, b, c] = [[0.0, 20.0, 5.0], [1.0, 21.0, 6.0], [1.0, 20.0, 7.0]];
        let minus = |p: [f64; 3]| [0, 1, 2].map(|axis| p[axis] - at[axis]);
        let ([u, v, w], cross) = ([a, b, c].map(minus), |p: [f64; 3], q: [f64; 3]| {
            [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
        });
        let volume: f64 = cross(v, w).iter().zip(u).map(|(own, other)| own * other).sum();
        let [b, c] = if volume > 0.0 { [b, c] } else { [c, b] };
        let part = [[a, b, c], [at, b, a], [at, c, b], [at, a, c]];
        let process = format!("schema = 1\n{PROCESS}");
        let folder = [("blank.stl", stock.clone()), ("part.stl", binary_stl(&part))];
        let folder = Folder::in_memory(folder.map(|(name, bytes)| (name.to_string(), bytes)));
        let found = Process::from_toml(&process, "process.toml", folder, &machine).map(|_| ());
        let from_box = |low: [f64; 3], high: [f64; 3]| -> f64 {
            let squares = (0..3).map(|axis| (low[axis] - at[axis]).max(at[axis] - high[axis]).max(0.0).powi(2));
            squares.sum::<f64>().sqrt()
        };
        let outside = from_box([-20.0, 2.5, 3.0], BLANK[1]).min(from_box([-20.0, 12.0, -5.0], BLANK[1]));
        if (outside - 0.1).abs() < 1e-5 || volume.abs() < 1e-3 {
            continue;
        }
        match found {
            Ok(()) => assert!(outside < 0.1, "{at:?}: {outside}"),
            Err(error) => {
                refused += 1;
                let (error, words) =
                    (error.to_string(), |mm: f64| format!("sticks out of the stock by {mm:.3} mm at ("));
                let is_told = error.contains(&words(outside - 1e-6)) || error.contains(&words(outside + 1e-6));
                assert!(is_told && error.contains("stock.part: part.stl: "), "{at:?}: {error} instead of {outside}");
            }
        }
    }
    assert!((100..290).contains(&refused), "{refused}");
}

#[test]
fn what_is_no_part_is_refused() {
    let machine = Machine::named("orthoglide").unwrap();
    let (blank, part) = (box_triangles(BLANK[0], BLANK[1], 0.0), shoulder(5.0, 0.0));
    let inside_out: Triangles = part.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    let scaled = |by: f64| -> Triangles { part.iter().map(|own| own.map(|own| own.map(|own| by * own))).collect() };
    let cylinder = PROCESS.replace(
        "mesh = \"blank.stl\"",
        "cylinder = { base_mm = [0.0, 20.0, -5.0], diameter_mm = 30.0, height_mm = 15.0 }",
    );
    let cuboid = |half: f64| {
        PROCESS.replace(
            "mesh = \"blank.stl\"",
            &format!("box = {{ min_mm = [{:?}, 2.5, -5.0], max_mm = [{half:?}, 30.0, 10.0] }}", -half),
        )
    };
    let large =
        PROCESS.replace("mesh = \"blank.stl\"", "box = { min_mm = [-20.0, 0.0, -5.0], max_mm = [20.0, 30.0, 10.0] }");
    for (process, part, expected) in [
        (
            PROCESS.to_string(),
            binary_stl(&part[1..]),
            "stock.part: part.stl: mesh: it is open at the edge between vertices",
        ),
        (PROCESS.to_string(), binary_stl(&inside_out), "stock.part: part.stl: mesh: it faces inwards at ("),
        (PROCESS.to_string(), b"no mesh".to_vec(), "stock.part: part.stl: is no STL file"),
        (
            PROCESS.to_string(),
            binary_stl(&scaled(1.01)),
            "stock.part: part.stl: it sticks out of the stock by 0.374 mm at (20.200, 30.300, 10.100) mm",
        ),
        (cylinder, binary_stl(&part), "stock.part: part.stl: it sticks out of the stock by 11.57"),
        (cuboid(19.9 - 1e-3), binary_stl(&part), "stock.part: part.stl: it sticks out of the stock by 0.101 mm at ("),
        (
            large,
            binary_stl(&scaled(1e-3)),
            "stock.part: is 0.040 mm large, and the path 60 mm: expected mm, not metres",
        ),
        (PROCESS.replace("part.stl", "no.stl"), Vec::new(), "stock.part: \"no.stl\" is not a file in the folder"),
        (PROCESS.to_string() + "tolerance_mm = 0.0\n", binary_stl(&part), "tools.1.tolerance_mm: "),
    ] {
        let files = [("blank.stl", binary_stl(&blank)), ("part.stl", part)];
        let found = job_beside(&process, &machine, LINE, &files).map(|_| ()).unwrap_err().to_string();
        assert!(found.contains(expected), "{found}\ninstead of {expected}");
    }
    // As a part's, a stock's surface faces outwards.
    let turned: Triangles = blank.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    let files = [("blank.stl", binary_stl(&turned)), ("part.stl", binary_stl(&part))];
    let found = job_beside(PROCESS, &machine, LINE, &files).map(|_| ()).unwrap_err().to_string();
    assert!(found.contains("it faces inwards at ("), "{found}");
    // By rounding a part may be a little larger than its stock; what it is read from is an input.
    let files = |part: &Triangles| [("blank.stl", binary_stl(&blank)), ("part.stl", binary_stl(part))];
    let inputs =
        |process: &str, part: &Triangles| job_beside(process, &machine, LINE, &files(part)).unwrap().process.inputs;
    inputs(&cuboid(19.95), &part);
    let change = inputs(PROCESS, &part).change_since(&inputs(PROCESS, &shoulder(5.1, 0.0))).unwrap();
    assert!(change.starts_with("part.stl"), "{change}");
}
