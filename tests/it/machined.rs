//! The machined surface of a program, and the bend of the tool where it makes a wall, against sums and lines of their own.

use crate::support::{command::told, uncertain::job};
use kinetostat::{
    Work,
    compensation::Method,
    files::Foreign,
    process::cutting::CuttingLaw,
    products::program::{
        CompensateOptions, Compensated, NoFiles, ProgramJob,
        files::{ProgramFiles, ProgramOutcome, compensate_into},
    },
};
use nalgebra::Vector3;
use serde_json::Value;

/// A shoulder of 2.5 mm on the side of the part at larger y, 5 mm deep, along x; the tool comes from below.
const LINE: &str = "G21 G90\nS8000 M3\nG0 X-30 Y0 Z-10\nG1 Z0 F2400\nX30\nG0 Z-10\n";
const BENDS: &str = "helix_deg = 30.0\nstick_out_mm = 40.0\nyoungs_modulus_N_per_mm2 = 6e5\n";

fn process(tool: &str) -> String {
    format!(
        "tolerance_mm = 0.05\n[placement]\norigin_mm = [0.0, 0.0, 100.0]\n[force.end_milling]\nmaterial = \"Al 7075-T6\"\n[stock]\n\
         box = {{ min_mm = [-20.0, 2.5, -5.0], max_mm = [20.0, 30.0, 10.0] }}\n[tools.1]\ndiameter_mm = 10.0\nteeth = 4\n{tool}"
    )
}

#[test]
fn the_memory_of_the_stock_is_said_before_it_is_cut() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    std::fs::write(at("part.nc"), LINE).unwrap();
    std::fs::write(at("process.toml"), format!("schema = 1\n{}", process(BENDS))).unwrap();
    let (program, process, out) = (at("part.nc"), at("process.toml"), at("out.nc"));
    let (_, _, said) = told(&["compensate", &program, "--machine", "orthoglide", "--process", &process, "--out", &out]);
    // 40 mm and 27.5 mm in cells of a quarter of a millimetre are 17,600 columns.
    let megabytes = said.split_once("the stock, in cells of 0.25 mm, takes at most ").expect(&said).1;
    let megabytes: f64 = megabytes.split_once(" MB").unwrap().0.parse().unwrap();
    assert!((1.0..20.0).contains(&megabytes), "{said}");
}

/// Three prismatic joints in series, each with its stiffness.
pub const MILL: &str = r#"
schema = 1
name = "mill"
title = "a Cartesian mill"
[platform]
tool_tip_mm = [0.0, 0.0, 0.0]
tool_axis = [0.0, 0.0, -1.0]
controls = ["x", "y", "z"]
[home]
position_mm = [0.0, 0.0, 0.0]
[workspace]
min_mm = [-1000.0, -1000.0, -1000.0]
max_mm = [1000.0, 1000.0, 1000.0]
[[chain]]
name = "mill"
elements = [
  { prismatic_drive = { name = "X", axis = "x", stiffness_N_per_mm = 1000.0, home_mm = 0.0 } },
  { prismatic_drive = { name = "Y", axis = "y", stiffness_N_per_mm = 2000.0, home_mm = 0.0 } },
  { prismatic_drive = { name = "Z", axis = "z", stiffness_N_per_mm = 4000.0, home_mm = 0.0 } },
]
[[mount]]
name = "mill"
chain = "mill"
"#;

/// Compensates the program into a folder and returns its report and its table of points.
fn compensated(process: &str, program: &str) -> (Value, Vec<Vec<String>>, Vec<u8>) {
    compensated_on("orthoglide", process, program)
}

fn compensated_on(machine: &str, process: &str, program: &str) -> (Value, Vec<Vec<String>>, Vec<u8>) {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.nc");
    let files = ProgramFiles::prepare(&out, Foreign::Kept).unwrap();
    let job = job(machine, process, ("part.nc", program));
    let work = Work::default();
    match compensate_into(job, &CompensateOptions::by(Method::Direct), &files, "part.nc", &work).unwrap() {
        ProgramOutcome::Written(_) => (),
        ProgramOutcome::Refused(..) => panic!("refused"),
    }
    let read = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    let report = serde_json::from_slice(&read("out.nc.report.json")).unwrap();
    let table = String::from_utf8(read("out.nc.points.csv")).unwrap();
    let rows = table.lines().map(|line| line.split(',').map(str::to_string).collect()).collect();
    (report, rows, read("out.nc.part.ply"))
}

/// What a program without stock is written over has a surface of its own, which is not that of the new one.
#[test]
fn a_surface_of_the_program_before_does_not_stay() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.nc");
    let without_stock = "[force.path_frame]\nradial_force_N = 100.0\ntangential_force_N = 0.0\naxial_force_N = 0.0\n";
    for (process, has_surface) in [(process(""), true), (without_stock.into(), false), (without_stock.into(), false)] {
        let files = ProgramFiles::prepare(&out, Foreign::Kept).unwrap();
        let job = job("orthoglide", &process, ("part.nc", LINE));
        compensate_into(job, &CompensateOptions::by(Method::Direct), &files, "part.nc", &Work::default()).unwrap();
        assert_eq!(folder.path().join("out.nc.part.ply").exists(), has_surface);
    }
}

/// Returns the numbers of a column where the tool cuts the shoulder.
fn column(rows: &[Vec<String>], name: &str) -> Vec<f64> {
    let at = |name: &str| rows[0].iter().position(|own| own == name).unwrap_or_else(|| panic!("{name}: {:?}", rows[0]));
    let (own, removed) = (at(name), at("engagement_most_removed_mm2"));
    let is_cut = |row: &&Vec<String>| row[removed].parse::<f64>().unwrap() > 1.0;
    rows[1..].iter().filter(is_cut).map(|row| row[own].parse().unwrap()).collect()
}

/// The wall of a straight pass is off by what the tool is off across it at each height: tip and rotation; the tip of the written program is where it is wanted, and its wall leans as the machine
/// does.
#[test]
fn the_wall_of_a_straight_pass_is_off_as_the_tool_is() {
    let (report, rows, ply) = compensated(&process(""), LINE);
    let surface = &report["machined_surface"];
    let number = |side: &str, what: &str| surface[side][what]["mm"].as_f64().unwrap();
    // As the tool goes without compensation: the program as written and the part of it that is corrected.
    let without = job("orthoglide", &process(""), ("part.nc", LINE));
    let cut = errors_without(&without);
    // Across the wall at its foot and 5 mm above it, towards the spindle at −z; and the end of the tool over the floor.
    let up = Vector3::new(0.0, 0.0, -5.0);
    let largest = |of: &dyn Fn(&Off) -> f64| cut.iter().map(of).fold(0.0, f64::max);
    let wall = largest(&|(error, turn)| error.y.abs().max((error + turn.cross(&up)).y.abs()));
    let floor = largest(&|(error, turn)| error.z.abs() + 5.0 * turn.norm());
    assert!(wall > 0.05, "{wall}");
    let found = number("without_compensation", "most_left").max(number("without_compensation", "most_missing"));
    assert!(found > wall - 2e-3 && found < wall.max(floor) + 2e-3, "{found}: {wall} {floor}");
    let after = column(&rows, "error_after_mm").into_iter().fold(0.0, f64::max);
    let (leans, tilts) = (largest(&|own| own.1.cross(&up).y.abs()), largest(&|own| 5.0 * own.1.norm()));
    let found = number("as_written", "most_left").max(number("as_written", "most_missing"));
    assert!(
        leans > 0.01 && found > leans - after - 1e-3 && found < leans.max(tilts) + after + 1e-3,
        "{found} {leans} {tilts} {after}"
    );
    // Wall 40 × 5 and floor 40 × 2.5 of the shoulder, to its round end.
    let area = surface["as_written"]["area_mm2"].as_f64().unwrap();
    assert!((area - 40.0 * 7.5).abs() < 4.0, "{area}");
    let header =
        String::from_utf8_lossy(&ply[..ply.windows(10).position(|own| own == b"end_header").unwrap()]).to_string();
    let count = |what: &str| -> usize {
        header.lines().find_map(|line| line.strip_prefix(what)).unwrap().trim().parse().unwrap()
    };
    assert_eq!(count("element vertex"), 4 * count("element face"));
    let body = ply.len() - header.len() - "end_header\n".len();
    assert_eq!(body, count("element vertex") * 25 + count("element face") * 17);
}

/// The part as VTK polygons has the corners and the deviations of the PLY file.
#[cfg(feature = "vtk")]
#[test]
fn the_part_as_vtk_polygons_is_that_of_the_ply_file() {
    use vtkio::model::{Attribute, DataSet, IOBuffer, Piece, Vtk};
    let folder = tempfile::tempdir().unwrap();
    let files = ProgramFiles::prepare(&folder.path().join("out.nc"), Foreign::Kept).unwrap();
    let job = job("orthoglide", &process(""), ("part.nc", LINE));
    compensate_into(job, &CompensateOptions::by(Method::Direct), &files, "part.nc", &Work::default()).unwrap();
    let read = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    let ply = read("out.nc.part.ply");
    let start = ply.windows(11).position(|own| own == b"end_header\n").unwrap() + 11;
    let float = |k: usize, own: usize| f32::from_le_bytes(ply[start + 25 * k + 4 * own..][..4].try_into().unwrap());
    let vtk = Vtk::parse_xml(read("out.nc.part.vtp").as_slice()).unwrap();
    let DataSet::PolyData { pieces, .. } = vtk.data else { panic!("polygons") };
    let [Piece::Inline(piece)] = pieces.as_slice() else { panic!("one piece") };
    let IOBuffer::F32(points) = &piece.points else { panic!("points") };
    assert!(points.len() > 300 && points.iter().enumerate().all(|(k, own)| *own == float(k / 3, k % 3)));
    let mut compared = 0;
    for (column, name) in ["without_compensation_mm", "as_written_mm"].into_iter().enumerate() {
        let array = piece.data.cell.iter().find_map(|own| match own {
            Attribute::DataArray(array) if array.name == name => Some(&array.data),
            _ => None,
        });
        let Some(IOBuffer::F32(values)) = array else { panic!("{name}") };
        assert_eq!(12 * values.len(), points.len());
        for (face, own) in values.iter().enumerate().filter(|own| !own.1.is_nan()) {
            assert_eq!(*own, float(4 * face, 3 + column), "{name} {face}");
            compared += usize::from(*own != 0.0);
        }
    }
    assert!(compared > 100, "{compared}");
}

/// A shoulder on the side of the part at smaller y, milled down from above, so that the tool is pushed off its wall. Each draw multiplies the force: so it does the distance of the wall without compensation, and as written what
/// is left of the force beyond the nominal one. The same where the tool bends as well; and the stock that is cut again says so.
#[test]
fn the_distribution_of_a_wall_is_that_of_the_force() {
    hold_the_distribution_of_a_wall("");
}

#[test]
#[ignore = "takes half a minute; .ci/full runs it"]
fn the_distribution_of_a_wall_by_a_tool_that_bends_is_that_of_the_force() {
    hold_the_distribution_of_a_wall(BENDS);
}

fn hold_the_distribution_of_a_wall(tool: &str) {
    let folder = tempfile::tempdir().unwrap();
    let machine = folder.path().join("mill.toml");
    std::fs::write(&machine, MILL).unwrap();
    let program = "G21 G90\nS8000 M3\nG0 X-30 Y0 Z20\nG0 Z-5\nG1 X30 F2400\nG0 Z20\n";
    let process = |tool: &str, tolerance: f64| {
        format!(
            "tolerance_mm = {tolerance}\n[gcode]\nwrite_tolerance_mm = 0.0\n[force.end_milling]\nmaterial = \"Al 7075-T6\"\n[stock]\n\
             box = {{ min_mm = [-20.0, -30.0, -15.0], max_mm = [20.0, -2.5, 0.0] }}\n[tools.1]\ndiameter_mm = 10.0\nteeth = 4\n{tool}\n\
             [uncertainty.process]\nforce_relative_std = 0.15\n[uncertainty.model]\nrelative_std = 0.0\n"
        )
    };
    // Logarithm of a factor whose standard deviation is 0.15 of its median.
    let std = (0.5 * (1.0 + (1.0 + 4.0 * 0.15f64 * 0.15).sqrt())).ln().sqrt();
    let factor = |z: f64| (z * std).exp();
    let (low, high) = (factor(-1.644_854), factor(1.644_854));
    let tolerance = 0.012;
    // Of 128 draws, of a Sobol sequence: the quantiles of 5 and 95 % of factors are known to 2 %.
    let (report, ..) = compensated_on(machine.to_str().unwrap(), &process(tool, tolerance), program);
    let surface = &report["machined_surface"];
    let of = |keys: &[&str]| keys.iter().fold(surface, |own, key| &own[*key]).as_f64().unwrap();
    assert_eq!(of(&["distribution", "draws"]), 128.0);
    let nominal = of(&["without_compensation", "most_left", "mm"]);
    assert!(nominal > 0.02 && of(&["without_compensation", "most_missing", "mm"]) < 0.5 * nominal, "{surface}");
    let p95 = of(&["distribution", "without_compensation", "most_left_p95_mm"]);
    assert!((p95 / (high * nominal) - 1.0).abs() < 0.03, "{tool}: {p95} {nominal}");
    for (what, share) in [("most_left", high - 1.0), ("most_missing", 1.0 - low)] {
        let found = of(&["distribution", "as_written", &format!("{what}_p95_mm")]);
        // Where the tool bends, the heights of the wall are not all at the mean that the program aims at.
        let (wanted, beside) = (share * nominal, of(&["as_written", what, "mm"]));
        assert!((found - wanted).abs() < 0.1 * wanted + beside, "{tool} {what}: {found} {wanted} {beside}");
    }
    if tool.is_empty() {
        // How probable it is that the wall is within the tolerance, and that its line takes too much.
        let written = &surface["distribution"]["as_written"];
        let below = |share: f64| kinetostat::process::uncertainty::normal_cdf(share.ln() / std);
        let gouged = below(1.0 - tolerance / nominal);
        let within = below(1.0 + tolerance / nominal) - gouged;
        let found = written["within_tolerance_probability"].as_f64().unwrap();
        assert!((found - within).abs() < 0.03, "{within}: {written}");
        let line = &written["gouge_probabilities"][0];
        assert!((line["probability"].as_f64().unwrap() - gouged).abs() < 0.03, "{gouged}: {line}");
        assert_eq!(line["line"], 5);
    }
}

/// A roughing tool whose force varies by itself leaves 0.006 mm to a finishing one: the wall is gouged where its force is so much beyond the nominal one that it takes more than that and the
/// tolerance, by its own line.
#[test]
fn a_roughing_pass_may_gouge_what_another_tool_finishes() {
    let folder = tempfile::tempdir().unwrap();
    let machine = folder.path().join("mill.toml");
    std::fs::write(&machine, MILL).unwrap();
    let (allowance, tolerance) = (0.006, 0.008);
    let program = format!(
        "G21 G90\nS8000 M3\nT1 M6\nG0 X-30 Y{allowance} Z20\nG0 Z-5\nG1 X30 F2400\nG0 Z20\nT2 M6\nG0 X-30 Y0\nG0 Z-5\nG1 X30 F2400\nG0 Z20\n"
    );
    let process = format!(
        "tolerance_mm = {tolerance}\n[gcode]\nwrite_tolerance_mm = 0.0\n[force.end_milling]\nmaterial = \"Al 7075-T6\"\n[stock]\n\
         box = {{ min_mm = [-20.0, -30.0, -15.0], max_mm = [20.0, -2.5, 0.0] }}\n[tools.1]\ndiameter_mm = 10.0\nteeth = 4\n\
         [tools.2]\ndiameter_mm = 10.0\nteeth = 4\n\
         [uncertainty.process]\nforce_relative_std = 0.15\nforce_per_tool = true\n[uncertainty.model]\nrelative_std = 0.0\n"
    );
    let (report, rows, _) = compensated_on(machine.to_str().unwrap(), &process, &program);
    let column = |name: &str| rows[0].iter().position(|own| own == name).unwrap();
    let (line, force) = (column("line"), column("cutting_force_y_N"));
    let deflection = |wanted: &str| {
        let own =
            rows[1..].iter().filter(|row| row[line] == wanted).map(|row| row[force].parse::<f64>().unwrap() / 2e3);
        own.fold(0.0, |most: f64, own| if own.abs() > most.abs() { own } else { most })
    };
    let (rough, std) = (deflection("6"), (0.5 * (1.0 + (1.0 + 4.0 * 0.15f64 * 0.15).sqrt())).ln().sqrt());
    // The compensated roughing tool is off by (f − 1) of its deflection, away from the wall where that is positive.
    assert!(rough > 0.06, "{rough}");
    let gouged = kinetostat::process::uncertainty::normal_cdf((1.0 - (allowance + tolerance) / rough).ln() / std);
    let written = &report["machined_surface"]["distribution"]["as_written"];
    let found = 1.0 - written["nothing_missing_beyond_tolerance_probability"].as_f64().unwrap();
    assert!(gouged > 0.05 && (found - gouged).abs() < 0.03, "{found} {gouged}: {written}");
}

/// A mill that is soft across the wall is pushed off it, and then cuts less: deflection and force agree where the force of a program whose wall is moved by the deflection makes this deflection.
#[test]
fn without_compensation_the_tool_is_where_its_own_cut_pushes_it() {
    let folder = tempfile::tempdir().unwrap();
    let machine = folder.path().join("mill.toml");
    let stiffness = 800.0;
    let soft =
        MILL.replace("1000.0,", "1e9,").replace("2000.0,", &format!("{stiffness:?},")).replace("4000.0,", "1e9,");
    std::fs::write(&machine, soft).unwrap();
    let process = "[force.end_milling]\nmaterial = \"Al 7075-T6\"\n[stock]\n\
        box = { min_mm = [-20.0, -30.0, -15.0], max_mm = [20.0, -3.0, 0.0] }\n[tools.1]\ndiameter_mm = 10.0\nteeth = 4\n";
    let at = |y: f64| {
        let program = format!("G21 G90\nS8000 M3\nG0 X-30 Y{y} Z20\nG0 Z-5\nG1 X30 F2400\nG0 Z20\n");
        job(machine.to_str().unwrap(), process, ("part.nc", &program))
    };
    // Where the whole width is cut, and the force across the wall there.
    let pushed = |y: f64| {
        let job = at(y);
        let middle = job.path.points().iter().position(|point| point.cutting && point.position_mm.x.abs() < 1e-9);
        job.path.points()[middle.unwrap()].load.unwrap().force_N.y / stiffness
    };
    let (mut low, mut high) = (0.0, pushed(0.0));
    assert!(high > 0.15, "{high}");
    let programmed = high;
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        (low, high) = if pushed(middle) > middle { (middle, high) } else { (low, middle) };
    }
    let verified =
        match at(0.0).compensate(&CompensateOptions::by(Method::Direct), &mut NoFiles, &Work::default()).unwrap() {
            Compensated::Verified(verified) => verified,
            Compensated::Refused(..) => panic!("refused"),
        };
    let found = verified.deflected_cut.unwrap();
    assert!(found.has_converged() && found.rounds < 6, "{found:?}");
    assert!((found.programmed_mm - programmed).abs() < 1e-6, "{found:?} {programmed}");
    assert!(programmed - low > 0.01 && (found.largest.1 - low).abs() < 1e-4, "{found:?} {low}");
}

type Off = (Vector3<f64>, Vector3<f64>);

/// Errors of the tip (mm) and rotations of the tool (rad) without compensation where it cuts, W axes (those of the base): solved for each point by itself.
fn errors_without(job: &ProgramJob) -> Vec<Off> {
    use kinetostat::compensation::{CompensationSettings, Session, compensate};
    let mut session = Session::new(&job.machine, &job.machines.actual, CompensationSettings::default());
    let mut errors = Vec::new();
    for part in job.parts() {
        let part = part.unwrap();
        for (k, task) in part.range().zip(part.tasks()) {
            if job.path.engagements()[k].removed_mm2 > 1.0 {
                let answer = compensate(&mut session, task, Method::None);
                errors.push((answer.position_error, answer.residual_rotation));
            }
        }
    }
    errors
}

/// Where a tooth passes the wall at a height, forces of all teeth bend the tool: as a sum over 4000 elements of its edge, within 0.1 µm, for both senses of rotation and
/// milling up and down; the program aims at the mean.
#[test]
fn the_wall_is_where_the_tool_is_when_it_makes_it() {
    for (spindle, stock_y, left) in [
        ("clockwise", [2.5, 30.0], false),
        ("clockwise", [-30.0, -2.5], true),
        ("counter_clockwise", [2.5, 30.0], false),
    ] {
        let text = process(BENDS)
            .replace("[-20.0, 2.5, -5.0]", &format!("[-40.0, {:?}, -5.0]", stock_y[0]))
            .replace("[20.0, 30.0, 10.0]", &format!("[40.0, {:?}, 10.0]", stock_y[1]))
            .replace("material = \"Al 7075-T6\"", &format!("material = \"Al 7075-T6\"\nspindle = \"{spindle}\""));
        let job = job("orthoglide", &text, ("part.nc", LINE));
        let CuttingLaw::EngagedMilling(law) = job.process.cutting else { panic!("no end mill") };
        let k = job.path.points().iter().position(|point| point.position_mm == Vector3::zeros()).unwrap();
        let bend = job.path.engagements()[k].bend.unwrap();
        // Seen from the spindle at −z the tool goes along x, and −y is on its left.
        assert!((bend.left + Vector3::y()).norm() < 1e-12);
        let side = if spindle == "clockwise" { 1.0 } else { -1.0 };
        let (radius, stick_out, depth, c): (f64, f64, f64, f64) = (5.0, 40.0, 5.0, 0.075);
        let rigidity = 6e5 * std::f64::consts::PI * 8.0_f64.powi(4) / 64.0;
        let lag = side * 30.0_f64.to_radians().tan() / radius;
        // Material within 2.5 mm of the wall: from 30° to 90° from the heading.
        let arc = if left { [30.0_f64, 90.0] } else { [-90.0, -30.0] }.map(f64::to_radians);
        let wall = if left { arc[1] } else { arc[0] };
        // Bend and force where a tooth passes the wall at a height.
        let at_wall = |height: f64, elements: usize| {
            let (mut bent, mut force) = (0.0, 0.0);
            for element in 0..elements {
                let z = depth * (element as f64 + 0.5) / elements as f64;
                for tooth in 0..4 {
                    let theta = wall + lag * (z - height) + std::f64::consts::FRAC_PI_2 * f64::from(tooth);
                    let theta = theta.sin().atan2(theta.cos());
                    if theta < arc[0] || theta > arc[1] {
                        continue;
                    }
                    let on_edge = law.edge.on_edge(c * theta.cos().max(0.0));
                    let own = (-on_edge.y * theta.sin() + side * on_edge.x * theta.cos()) * depth / elements as f64;
                    let (a, b) = (stick_out - height, stick_out - z);
                    let (short, long) = (a.min(b), a.max(b));
                    bent += own * short * short * (3.0 * long - short) / (6.0 * rigidity);
                    force += own;
                }
            }
            (bent, force)
        };
        let sums: Vec<_> = (0..=6).map(|at| at_wall(depth * f64::from(at) / 6.0, 4000)).collect();
        let heights = (0..200).map(|at| depth * (f64::from(at) + 0.5) / 200.0);
        let (mean, made_exact) = heights
            .map(|height| at_wall(height, 1000))
            .fold((0.0, 0.0), |sum, own| (sum.0 + own.0 / 200.0, sum.1 + own.1 / 200.0));
        for (at, (bent, _)) in sums.iter().enumerate() {
            let found = bend.at(left, depth * at as f64 / 6.0).unwrap();
            assert!((found - bent).abs() < 1e-4, "{spindle} {at}: {found} instead of {bent}");
        }
        assert!(bend.at(!left, 0.5).is_none());
        assert!((bend.aimed_mm - mean * bend.left).norm() < 1e-4);
        let [mean_force, made, peak] = bend.across_N.map(Option::unwrap);
        assert!((f64::from(made) - made_exact).abs() < 5e-3 * made_exact.abs() + 0.1, "{made} {made_exact}");
        assert!(peak.abs() >= made.abs() && peak.abs() > mean_force.abs(), "{:?}", bend.across_N);
        assert!(sums.iter().any(|own| own.0.abs() > 0.009), "{sums:?}");
    }
}

/// Straight teeth leave a wall in down milling with no chip: there is the force of their edges alone, not the mean and not the peak.
#[test]
fn a_wall_of_straight_teeth_shows_the_force_of_edges() {
    let job = job("orthoglide", &process(&BENDS.replace("30.0\n", "0.0\n")), ("part.nc", LINE));
    let CuttingLaw::EngagedMilling(law) = job.process.cutting else { panic!("no end mill") };
    let k = job.path.points().iter().position(|point| point.position_mm == Vector3::zeros()).unwrap();
    let [mean, made, peak] = job.path.engagements()[k].bend.unwrap().across_N.map(|own| f64::from(own.unwrap()));
    // As in the section on end_milling of the guide.
    assert!((mean - 188.76).abs() < 0.02 && (peak - 429.58).abs() < 0.02, "{mean} {peak}");
    assert!((made - 5.0 * law.edge.on_edge(0.0).y).abs() < 1e-3, "{made}");
}

/// The written program puts the wall of a tool that bends where it is wanted, to within what the bend differs along its height.
#[test]
fn compensation_aims_at_the_wall_of_a_tool_that_bends() {
    let (rigid, ..) = compensated(&process(""), LINE);
    let (bending, rows, _) = compensated(&process(BENDS), LINE);
    let found = |report: &Value, side: &str| {
        let of = |what: &str| report["machined_surface"][side][what]["mm"].as_f64().unwrap();
        of("most_left").max(of("most_missing"))
    };
    // Without compensation the bend adds to what the machine does.
    assert!((found(&bending, "without_compensation") - found(&rigid, "without_compensation")).abs() > 0.005);
    let text = process(BENDS);
    let job = job("orthoglide", &text, ("part.nc", LINE));
    let bends = job.path.engagements().iter().filter_map(|own| own.bend.as_ref());
    let spread = bends
        .filter_map(|bend| {
            let aimed = bend.aimed_mm.dot(&bend.left);
            (0..=6)
                .map(|at| bend.at(false, 5.0 * f64::from(at) / 6.0).map(|own| (own - aimed).abs()))
                .max_by(|a, b| a.partial_cmp(b).unwrap())?
        })
        .fold(0.0, f64::max);
    let most = |name: &str| column(&rows, name).into_iter().fold(0.0, f64::max);
    let after = most("error_after_mm");
    // At the top of the wall and at the rim of the end.
    let leans = most("residual_rotation_deg").to_radians() * 5.0f64.hypot(5.0);
    assert!(
        spread > 1e-4 && found(&bending, "as_written") <= spread + after + leans + 1e-3,
        "{spread} {after} {leans}"
    );
    // Where no force acts the tool does not bend, and the program as written is off by what it corrects.
    let off = report_number(&bending, "without_force");
    assert!(off > 0.9 * found(&bending, "without_compensation") - leans - 0.01, "{off}");
}

fn report_number(report: &Value, key: &str) -> f64 {
    report[key]["error_max_mm"].as_f64().unwrap()
}
