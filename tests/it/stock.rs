//! Engagement found from the stock: forces against the closed forms of cuts whose width and depth are given, energy against removed volume, and what is refused.

use crate::support::uncertain::{LEVER, job};
use kinetostat::{
    Machine, Work,
    input::{Folder, error::Result},
    process::{
        Engaged, Process,
        cutting::{CuttingLaw, EndMilling},
    },
    products::program::ProgramJob,
    toolpath::{PathPoint, Toolpath},
};
use nalgebra::Vector3;

const MATERIAL: &str = "material = \"Al 7075-T6\"";
const KIENZLE: &str = "material = \"C45E\"\nradial_ratio = 0.4\naxial_ratio = -0.1";
/// A line of 40 mm of a tool that points along +z, as that of the Orthoglide, and comes from below.
const LINE: &str = "G21 G90\nS8000 M3\nG0 X-20 Y0 Z-10\nG1 Z0 F2400\nX20\nG0 Z-10\n";
const TOOL: &str = "[tools.1]\ndiameter_mm = 10.0\nteeth = 4\n";

/// The job of a program on the Orthoglide that cuts a box, which begins at z = −5.
fn cut(stock_y: [f64; 2], tool: &str, law: &str, program: &str) -> ProgramJob {
    job("orthoglide", &process(stock_y, tool, law), ("part.nc", program))
}

fn process([from, to]: [f64; 2], tool: &str, law: &str) -> String {
    format!(
        "[sampling]\nmax_segment_mm = 1.0\n[force.end_milling]\n{law}\n[stock]\n\
         box = {{ min_mm = [-60.0, {from:?}, -5.0], max_mm = [60.0, {to:?}, 20.0] }}\n{tool}"
    )
}

/// Points on the line in the middle of the box, with their engagement.
fn middle(job: &ProgramJob) -> Vec<(PathPoint, Engaged)> {
    let points = job.path.points().iter().copied().zip(job.path.engagements().iter().copied());
    points.filter(|(point, _)| point.position_mm.z == 0.0 && point.position_mm.x.abs() < 10.0).collect()
}

/// Moment about the tip of what acts up on the teeth of a cylinder, about the heading and about its left, as a plain sum over the turn; N·mm.
fn moment_of_axial_force(law: &EndMilling) -> [f64; 2] {
    const STEPS: usize = 20_000;
    let (arc, c) = (law.arc(), 0.075);
    let step = (arc.exit - arc.entry) / STEPS as f64;
    let mut sum = [0.0; 2];
    for k in 0..STEPS {
        let (sine, cosine) = (arc.entry + (k as f64 + 0.5) * step).sin_cos();
        let up = law.edge.on_edge(c * sine).z * law.depth_mm * law.diameter_mm / 2.0 * step;
        // To the left of the heading by the cosine of ψ, ahead by its sine.
        sum[0] += up * cosine;
        sum[1] -= up * sine;
    }
    sum.map(|own| own * f64::from(law.teeth) / std::f64::consts::TAU)
}

/// A shoulder whose width and depth are found has the force of one whose width and depth are given, on both sides and by both kinds of laws; it acts in the middle of the
/// depth.
#[test]
fn a_shoulder_has_the_force_of_its_width_and_depth() {
    for law in [MATERIAL, KIENZLE] {
        for width in [0.5, 2.5, 5.0, 9.0, 10.0] {
            for (cut_words, stock_y) in [("up", [-50.0, width - 5.0]), ("down", [5.0 - width, 50.0])] {
                let given = format!(
                    "[force.end_milling]\ndiameter_mm = 10.0\nteeth = 4\naxial_depth_mm = 5.0\nradial_width_mm = {width:?}\n\
                     cut = \"{cut_words}\"\n{law}\n"
                );
                let CuttingLaw::EndMilling(given) = job("orthoglide", &given, ("part.nc", LINE)).process.cutting else {
                    panic!("no end mill")
                };
                let exact = given.mean(0.075);
                let found = cut(stock_y, TOOL, law, LINE);
                let all = middle(&found);
                assert!(all.len() > 15);
                for (point, own) in all {
                    let load = point.load.unwrap();
                    // Heading x, its left seen from the spindle −y, the spindle −z.
                    let in_feed = |own: Vector3<f64>| Vector3::new(own.x, -own.y, -own.z);
                    let (force, moment) = (in_feed(load.force_N), in_feed(load.moment_Nmm));
                    assert!(
                        (force - exact.force_N).norm() < 1e-3 * force.norm(),
                        "{width} {cut_words}: {force} {exact:?}"
                    );
                    let [about_heading, about_left] = moment_of_axial_force(&given);
                    let exact = Vector3::new(
                        about_heading - 2.5 * exact.force_N.y,
                        about_left + 2.5 * exact.force_N.x,
                        exact.torque_Nmm,
                    );
                    assert!((moment - exact).norm() < 1e-3 * exact.norm(), "{width} {cut_words}: {moment} {exact}");
                    assert!((own.width_mm - width).abs() < 2e-3 && (own.depth_mm - 5.0).abs() < 1e-6, "{own:?}");
                    assert!(own.milling == if width == 10.0 { "both" } else { cut_words }, "{width}: {own:?}");
                }
            }
        }
    }
}

const COEFFICIENTS: &str = "coefficients = { tangential_cutting_N_per_mm2 = 900.0, radial_cutting_N_per_mm2 = 400.0, axial_cutting_N_per_mm2 = -150.0, \
                            tangential_edge_N_per_mm = 12.0, radial_edge_N_per_mm = 10.0, axial_edge_N_per_mm = -2.0 }";

/// Passes 3 mm deep over the floor of a pass before, with a wall of 0.1 mm beside: the sum of closed forms over the floor and the wall, computed apart from the program.
#[test]
fn a_pass_over_an_earlier_floor_has_the_force_of_floor_and_wall() {
    for (floor, exact) in [(0.6, [-31.8, 46.4, -12.0]), (0.3, [-19.7, 21.1, -6.6]), (0.4, [-23.7, 29.5, -8.4])] {
        let program = format!(
            "G21 G90\nS8000 M3\nG0 X-20 Y0.1 Z-10\nG1 Z{:.1} F2400\nX20\nG0 Z-10\nX-20 Y0\nG1 Z-2\nX20\nG0 Z-10\n",
            -2.0 - floor
        );
        let found = cut([-50.0, 50.0], TOOL, COEFFICIENTS, &program);
        let points = found.path.points().iter().zip(found.path.engagements());
        let points: Vec<_> =
            points.filter(|(own, _)| own.position_mm.z == -2.0 && own.position_mm.x.abs() < 10.0).collect();
        assert!(points.len() > 15);
        for (point, own) in points {
            let force = point.load.unwrap().force_N;
            let off = Vector3::new(force.x, -force.y, -force.z) - Vector3::from(exact);
            assert!(off.amax() < 0.06, "{floor}: {force}");
            assert!(own.regions == 2 && (own.depth_mm - 3.0).abs() < 1e-6 && (own.width_mm - 10.0).abs() < 1e-3);
            assert_eq!(own.end_mm2, 0.0);
        }
    }
}

/// The force where a tooth passes the wall, over its height: sums over 2000 heights and 4000 elements of the edge for each, computed apart from the program.
#[test]
fn the_force_at_a_wall_is_the_mean_over_its_height() {
    for (helix, stock_y, exact) in [
        (30.0, [2.5, 50.0], 54.153),
        (45.0, [2.5, 50.0], 117.513),
        (30.0, [-50.0, -2.5], -22.273),
        (45.0, [-50.0, -2.5], 7.281),
    ] {
        let tool = format!("{TOOL}helix_deg = {helix:?}\nstick_out_mm = 40.0\nyoungs_modulus_N_per_mm2 = 6.0e5\n");
        for (_, own) in middle(&cut(stock_y, &tool, COEFFICIENTS, LINE)) {
            let across = f64::from(own.bend.unwrap().across_N[1].unwrap());
            assert!((across - exact).abs() < 0.05, "{helix} {stock_y:?}: {across} instead of {exact}");
        }
    }
}

/// What teeth do in a turn is what the removed volume takes, whatever the shape of the tool, on a level move and on a ramp.
#[test]
fn torque_is_that_of_the_removed_volume() {
    let law = "coefficients = { tangential_cutting_N_per_mm2 = 900.0, radial_cutting_N_per_mm2 = 400.0, axial_cutting_N_per_mm2 = -150.0 }";
    let ramp = LINE.replace("G1 Z0 F2400\nX20\n", "G1 Z-4 F2400\nX20 Z3\n");
    for shape in ["", "shape = \"ball\"\n", "shape = \"bull_nose\"\ncorner_radius_mm = 2.0\n"] {
        for (program, share) in [(LINE, 1e-3), (&ramp, 4e-3)] {
            let found = cut([-3.0, 50.0], &format!("{TOOL}{shape}"), law, program);
            let mut count = 0;
            for (k, (point, own)) in found.path.points().iter().zip(found.path.engagements()).enumerate() {
                if own.removed_mm2 == 0.0 || point.tangent.xy().norm() < 0.1 {
                    continue;
                }
                // The end of a flat tool that goes down cuts without being in the law.
                let before = found.path.points()[k - 1].position_mm;
                let falls = point.position_mm.z > before.z && !shape.contains("ball");
                if falls {
                    continue;
                }
                let torque = -point.load.unwrap().moment_Nmm.z;
                let exact = 900.0 * own.removed_mm2 * (2400.0 / 8000.0) / std::f64::consts::TAU;
                assert!((torque / exact - 1.0).abs() < share, "{shape}: {torque} instead of {exact}, {own:?}");
                count += 1;
            }
            assert!(count > 20 || program != LINE, "{shape}");
        }
    }
}

/// A second pass on the same line is in air, and so is what comes before contact: no force, and no engagement. Blocks that go nowhere change nothing.
#[test]
fn air_is_found() {
    let twice = LINE.replace("X20\n", "X20\nX-20\n");
    let found = cut([-3.0, 50.0], TOOL, MATERIAL, &twice);
    let turn = found.path.points().iter().position(|point| point.position_mm.x == 20.0).unwrap();
    let (first, second) = found.path.points().split_at(turn + 1);
    assert!(second.iter().all(|point| point.load.is_none()));
    let cuts = |point: &&PathPoint| point.position_mm.z == 0.0 && point.position_mm.x > -19.9;
    assert!(first.iter().filter(cuts).all(|point| point.cutting && point.load.is_some()));
    // A stock that begins at x = 0 is touched from x = −5 on.
    let late = process([-50.0, 50.0], TOOL, MATERIAL).replace("[-60.0,", "[0.0,");
    let late = job("orthoglide", &late, ("part.nc", LINE));
    for (point, own) in late.path.points().iter().zip(late.path.engagements()) {
        if point.position_mm.z == 0.0 {
            assert_eq!(point.load.is_some(), point.position_mm.x > -4.5, "{point:?}");
            assert_eq!(own.removed_mm2 > 0.0, point.load.is_some(), "{own:?}");
        }
    }
    let still = LINE.replace("X20\n", "X0\nG1 X0 F1200\nG1 X0.0000001\nG1 X20 F2400\n");
    let still = cut([-3.0, 50.0], TOOL, MATERIAL, &still);
    let plain = cut([-3.0, 50.0], TOOL, MATERIAL, LINE);
    let at = |job: &ProgramJob, x: f64| {
        let points = job.path.points().iter().filter(|point| (point.position_mm.x - x).abs() < 1e-6);
        points.filter(|point| point.position_mm.z == 0.0).map(|point| point.load.unwrap().force_N).collect::<Vec<_>>()
    };
    for x in [0.0, 1.0, 10.0] {
        for force in at(&still, x) {
            assert!((force - at(&plain, x)[0]).norm() < 1e-6 * force.norm(), "{x}: {force}");
        }
    }
}

/// A drill has its thrust in solid material alone, and after a way that is not known the tool begins anew.
#[test]
fn a_drill_works_in_material_and_an_unknown_way_cuts_nothing() {
    let law = "diameter_mm = 10.0\nmaterial = \"SCM440 269 HB\"";
    let own = process([-50.0, 50.0], &format!("{TOOL}shape = \"drill\"\n"), law).replace("end_milling", "drilling");
    let holes = "G21 G90\nS1000 M3\nG0 X0 Y0 Z-10\nG1 Z5 F150\nG0 Z-10\nG1 Z5\nG0 Z-10\nX-70\nG1 Z5\nG0 Z-10\n";
    let found = job("orthoglide", &own, ("part.nc", holes));
    let bottoms: Vec<_> = found.path.points().iter().filter(|point| point.position_mm.z == 5.0).collect();
    assert_eq!(bottoms.len(), 3);
    // F = 570 K D f^0.85 against the drill, which comes from below.
    let [first, again, beside] = [0, 1, 2].map(|hole| bottoms[hole].load.map_or(0.0, |load| load.force_N.z));
    let plain = process([-50.0, 50.0], "", law).replace("end_milling", "drilling");
    let plain = job("orthoglide", plain.split("[stock]").next().unwrap(), ("part.nc", holes));
    let CuttingLaw::Drilling(drill) = plain.process.cutting else { panic!("no drill") };
    assert!((first + drill.thrust_and_torque(0.15).0).abs() < 1e-9 && again == 0.0 && beside == 0.0);
    assert!(found.path.points().iter().all(|point| point.position_mm.z >= -8.1 || point.load.is_none()));
    let gap = "G21 G90\nS8000 M3\nG0 X-20 Y0 Z-10\nG1 Z0 F600\nG1 X20 F2400\nG28\nG1 X-20 Y40 Z0\nG0 Z-10\nG0 X0 Y10\nG1 Z0\nG1 Y30\n";
    let found = problem(&process([-50.0, 50.0], TOOL, MATERIAL), &Machine::named("orthoglide").unwrap(), gap);
    assert!(found.contains("begins with the tool in the stock"), "{found}");
    let found = cut([-50.0, 50.0], TOOL, MATERIAL, &gap.replace("G1 X-20 Y40 Z0\n", "G0 Z-10\n"));
    let middle = found.path.points().iter().find(|point| point.position_mm.y == 20.0).unwrap();
    assert!(middle.load.unwrap().force_N.norm() > 300.0, "{middle:?}");
}

/// A ball has the force of a plain sum over its sphere and a turn: on the level, on ramps, straight down half beside the part.
#[test]
fn a_ball_has_the_force_of_the_sum_over_its_edge() {
    let law = "coefficients = { tangential_cutting_N_per_mm2 = 900.0, radial_cutting_N_per_mm2 = 400.0, axial_cutting_N_per_mm2 = -150.0, \
               tangential_edge_N_per_mm = 20.0, radial_edge_N_per_mm = 25.0, axial_edge_N_per_mm = 5.0 }";
    let tool = format!("{TOOL}shape = \"ball\"\n");
    let c = 2400.0 / 8000.0 / 4.0;
    // The way in axes of the field, x ahead and z to the spindle, the depth, and how far the material reaches to the left and right of the tip.
    for (program, way, depth, side) in [
        (LINE.to_string(), [1.0, 0.0], 5.0, [-3.0, 50.0]),
        (LINE.to_string(), [1.0, 0.0], 5.0, [-50.0, 50.0]),
        (LINE.replace("G1 Z0 F2400\nX20", "G1 Z-2 F2400\nX20 Z2"), [40.0, -4.0], 5.0, [-50.0, 50.0]),
        (LINE.replace("X-20 Y0 Z-10\nG1 Z0 F2400\nX20", "X0 Y0 Z-10\nG1 Z0 F2400"), [0.0, -1.0], 5.0, [0.0, 50.0]),
    ] {
        let found = cut(side, &tool, law, &program);
        let points = found.path.points().iter().filter(|point| point.load.is_some() && point.position_mm.z > -2.1);
        let point = points
            .min_by(|a, b| {
                a.position_mm
                    .x
                    .abs()
                    .total_cmp(&b.position_mm.x.abs())
                    .then(b.position_mm.z.total_cmp(&a.position_mm.z))
            })
            .unwrap();
        let (load, depth) = (point.load.unwrap(), depth + point.position_mm.z);
        let way = nalgebra::Vector2::from(way).normalize();
        let (mut sum, steps) = (Vector3::zeros(), 1200);
        let step = std::f64::consts::PI / steps as f64;
        for polar in 0..steps / 2 {
            let kappa = (polar as f64 + 0.5) * step;
            let height = 5.0 - 5.0 * kappa.cos();
            for turn in 0..2 * steps {
                let theta = (turn as f64 + 0.5) * step;
                let (ahead, left) = (theta.cos(), theta.sin());
                let h = c * (kappa.sin() * ahead * way.x - kappa.cos() * way.y);
                // Left of the heading is −y, as the tool comes from below.
                let y = -5.0 * kappa.sin() * left;
                if h <= 0.0 || height > depth || y < side[0] || y > side[1] {
                    continue;
                }
                let [t, r, a] = [900.0 * h + 20.0, 400.0 * h + 25.0, -150.0 * h + 5.0];
                let outward = -r * kappa.sin() + a * kappa.cos();
                let own = Vector3::new(
                    outward * ahead - t * left,
                    outward * left + t * ahead,
                    r * kappa.cos() + a * kappa.sin(),
                );
                sum += own * (5.0 * step * step * 4.0 / std::f64::consts::TAU);
            }
        }
        let force = load.force_N;
        let force = Vector3::new(force.x, -force.y, -force.z);
        // To what slices and columns of a ball know its depth to.
        assert!((force - sum).norm() < 0.015 * sum.norm(), "{force} instead of {sum}\n{program}");
    }
}

/// A shoulder 5 mm deep, cut with 10 mm: what is wider than that must not begin lower than its top.
#[test]
fn a_shank_or_holder_in_the_stock_is_refused() {
    let process = |body: &str| process([2.5, 30.0], &format!("{TOOL}{body}\n"), MATERIAL);
    let orthoglide = Machine::named_or_file("orthoglide").unwrap();
    for (name, diameter, from, meets) in [
        ("holder", 40.0, 4.0, true),
        ("holder", 40.0, 5.1, false),
        ("shank", 12.0, 3.0, true),
        ("shank", 10.0, 3.0, false),
        ("shank", 8.0, 0.5, false),
    ] {
        let process = process(&format!("{name} = {{ diameter_mm = {diameter:?}, from_mm = {from:?} }}"));
        if meets {
            let found = problem(&process, &orthoglide, LINE);
            assert!(found.contains(&format!("move 2: has the {name} of its tool in the stock at (")), "{found}");
        } else {
            let job = job("orthoglide", &process, ("part.nc", LINE));
            assert!(middle(&job).iter().all(|own| own.1.depth_mm > 4.9), "{name} {diameter} {from}");
        }
    }
}

/// However coarsely the path is sampled, what it meets between its points is found, by feed and by rapid moves.
#[test]
fn what_lies_between_points_is_found() {
    let coarse = process([-3.0, 50.0], TOOL, MATERIAL).replace("max_segment_mm = 1.0", "max_segment_mm = 5.0");
    let wall = coarse.replace("[-60.0,", "[-0.15,").replace("max_mm = [60.0", "max_mm = [0.15");
    let found = job("orthoglide", &wall, ("part.nc", LINE));
    assert!(found.path.engagements().iter().any(|own| own.removed_mm2 > 0.0 && own.depth_mm == 5.0));
    let machine = Machine::named("orthoglide").unwrap();
    for program in [LINE.replace("G1 Z0 F2400\nX20", "G0 Z0\nG0 X20"), LINE.replace("G1 Z0 F2400", "G0 Z0")] {
        let own = if program.contains("G0 X20") { wall.clone() } else { process([-50.0, 50.0], TOOL, MATERIAL) };
        let found = problem(&own, &machine, &program);
        assert!(found.contains("is rapid and goes through the stock at ("), "{found}");
    }
    // What is thinner than a cell is found, too.
    let thin = coarse.replace("[-60.0,", "[-0.06,").replace("max_mm = [60.0", "max_mm = [0.06") + "cell_mm_of";
    let thin = thin.replace("[tools.1]", "cell_mm = 3.0\n[tools.1]").replace("cell_mm_of", "");
    let found = problem(&thin, &machine, &LINE.replace("G1 Z0 F2400\nX20", "G0 Z0\nG0 X20"));
    assert!(found.contains("is rapid and goes through the stock at ("), "{found}");
    // In steps of less than half the sampling into solid material, sideways and with a ball.
    let steps: String = (1..20).map(|step| format!("Y{:?}\n", 15.0 - 0.4 * f64::from(step))).collect();
    let side = LINE.replace("Y0 Z-10\nG1 Z0 F2400\nX20\n", &format!("Y15 Z-10\nG1 Z0 F2400\n{steps}"));
    let found = cut([-50.0, 9.8], TOOL, MATERIAL, &side);
    let last = found.path.points().iter().rev().find(|point| point.position_mm.z == 0.0).unwrap();
    assert!(last.load.unwrap().force_N.norm() > 100.0, "{last:?}");
    // In the opened slot a rapid move is free, also a little beside it.
    let back = LINE.replace("X20\n", "X20\nG0 X-20 Y0.005\n");
    cut([-50.0, 50.0], TOOL, MATERIAL, &back);
}

fn problem(process: &str, machine: &Machine, program: &str) -> String {
    job_beside(process, machine, program, &[]).map(|_| ()).unwrap_err().to_string()
}

/// The job of a program beside whose process file there are `files`.
pub(crate) fn job_beside(
    process: &str,
    machine: &Machine,
    program: &str,
    files: &[(&str, Vec<u8>)],
) -> Result<ProgramJob> {
    let text = format!("schema = 1\n{process}");
    let files = files.iter().map(|(name, bytes)| (name.to_string(), bytes.clone()));
    let folder = Folder::in_memory(files.chain([("part.nc".to_string(), program.as_bytes().to_vec())]));
    let process = Process::from_toml(&text, "process.toml", folder.clone(), machine)?;
    let program = process.program_in_folder(&folder, "part.nc")?;
    ProgramJob::new(process, program, "part.nc", &Work::default())
}

#[test]
fn what_cannot_be_cut_is_refused() {
    let machine = Machine::named("orthoglide").unwrap();
    let own = process([-50.0, 50.0], TOOL, MATERIAL);
    let without_stock = own.split("[stock]").next().unwrap();
    for (process, program, expected) in [
        (own.clone(), &LINE.replace("G1 Z0 F2400\nX20", "G1 Z0 F2400\nG0 X20"), "move 3: is rapid and goes through the stock at ("),
        (own.clone(), &LINE.replace("S8000", "T3 M6\nS8000"), "move 2: is of tool 3, whose geometry is not known: expected [tools.3]"),
        (own.clone() + &TOOL.replace("tools.1", "tools.2"), &LINE.to_string(), "move 2: does not say which tool cuts: expected T before it"),
        (own.clone(), &LINE.replace("S8000 M3\n", ""), "spindle speed not given on move"),
        (own.replace("[stock]", "teeth = 4\n[stock]"), &LINE.to_string(), "force.end_milling.teeth: stands in [tools]: expected no such key"),
        (own.replace("[stock]", "axial_depth_mm = 4.0\n[stock]"), &LINE.to_string(), "axial_depth_mm: is found from the stock"),
        (without_stock.to_string(), &LINE.to_string(), "diameter_mm: missing: expected"),
        (format!("{without_stock}{TOOL}"), &LINE.to_string(), "tools.1: has no effect without [stock]"),
        (own.replace(TOOL, ""), &LINE.to_string(), "move 2: cuts with a tool that is not known: expected it, such as [tools.1]"),
        (own.replace("max_mm = [60.0", "max_mm = [-70.0"), &LINE.to_string(), "stock.box:"),
        (format!("[placement]\nreference = \"platform_point\"\n{own}"), &LINE.to_string(), "stock: is cut by the tool tip, and the path is of the platform point"),
        (own.clone(), &LINE.replace("Z-10\nG1", "Z-4\nG1"), "move 1: begins with the tool in the stock"),
        (own.replace("-5.0]", "5.0]"), &LINE.to_string(), "part.nc: nothing touches the stock"),
        (own.replace("= 1.0\n[force", "= 5.1\n[force"), &LINE.to_string(), "sampling.max_segment_mm: is 5.1: expected at most 5"),
        (format!("{own}[cutting]\nmax_feed_mm_per_min = 1000.0\n"), &LINE.to_string(), "cutting: is given where [stock] is"),
        (own.replace(&format!("[force.end_milling]\n{MATERIAL}\n"), ""), &LINE.to_string(), "force: missing: expected end_milling or drilling"),
        (own.clone(), &LINE.replace("F2400", "F0"), "feed"),
        (own.replace("teeth = 4", "teeth = 4\nhelix_deg = 30.0"), &LINE.to_string(), "tools.1.helix_deg: has no effect without stick_out_mm"),
        (own.replace("teeth = 4", "teeth = 4\nstick_out_mm = 30.0"), &LINE.to_string(), "tools.1.helix_deg: missing"),
        (own.replace("teeth = 4", "teeth = 4\nstick_out_mm = 4.0\nhelix_deg = 0.0\nyoungs_modulus_N_per_mm2 = 6e5"), &LINE.to_string(), "sticks out 4 mm: expected less, as the holder would cut"),
        (own.replace("[stock]", "[stock]\nnatural_frequencies_Hz = [0.0]"), &LINE.to_string(), "stock.natural_frequencies_Hz[0]"),
        (own.replace("end_milling]", "drilling]").replace(MATERIAL, "diameter_mm = 9.0\nmaterial = \"SCM440 269 HB\""), &LINE.replace("Z0 F2400", "Z5 F240"), "drills with 10 mm by its tool and 9 mm by its force"),
        (without_stock.replace(MATERIAL, "diameter_mm = 10.0\nradial_width_mm = 10.0\naxial_depth_mm = 1.0\nmaterial = \"Al 7075-T6\""), &LINE.to_string(), "force.end_milling.teeth: missing"),
        (own.replace("[tools.1]", "cell_mm = 0.0001\n[tools.1]"), &LINE.to_string(), "stock.cell_mm:"),
        (own.replace("[tools.1]", "[tools.1]\ncorner_radius_mm = 1.0"), &LINE.to_string(), "corner_radius_mm: is of shape = \"bull_nose\""),
        (own.replace("[tools.1]", "[tools.1]\nshape = \"bull_nose\"\ncorner_radius_mm = 7.0"), &LINE.to_string(), "tools.1: "),
        (own.replace("[force.end_milling]", "[force.slot_milling]\ntangential_cutting_N_per_mm2 = 1.0\nradial_cutting_N_per_mm2 = 1.0\naxial_cutting_N_per_mm2 = 1.0\naxial_depth_mm = 1.0\nteeth = 2").replace(MATERIAL, ""), &LINE.to_string(), "slot_milling: is given where [stock] is"),
    ] {
        let found = problem(&process, &machine, program);
        assert!(found.contains(expected), "{found}\ninstead of {expected}\n{process}");
    }
}

/// A tool that lies along x, pointing at the stock from the side, has the force of one that stands, turned as it is.
#[test]
fn a_tool_that_points_sideways_cuts_as_one_that_stands() {
    let sideways =
        LEVER.replace("tool_tip_mm = [0.0, 0.0, 50.0]", "tool_tip_mm = [50.0, 0.0, 0.0]\ntool_axis = [1.0, 0.0, 0.0]");
    let machine = Machine::from_toml(&sideways, "lever.toml").unwrap();
    // A cylinder along z of the workpiece is none along the tool.
    let cylinder = process([-50.0, 50.0], TOOL, MATERIAL);
    let cylinder = cylinder.replace(
        "box = { min_mm = [-60.0, -50.0, -5.0], max_mm = [60.0, 50.0, 20.0] }",
        "cylinder = { base_mm = [0.0, 0.0, 0.0], diameter_mm = 50.0, height_mm = 20.0 }",
    );
    let cylinder = format!("[gcode]\ntool_axis = [-1.0, 0.0, 0.0]\n{cylinder}");
    let found = problem(&cylinder, &machine, "G21 G90\nS8000 M3\nG0 X0 Y0 Z0\nG1 X0.5 F600\n");
    assert!(found.contains("stock.cylinder: stands along z of the workpiece, and the tool is not along it"), "{found}");
    let text = format!("schema = 1\n[gcode]\ntool_axis = [-1.0, 0.0, 0.0]\n{}", process([-50.0, 50.0], TOOL, MATERIAL));
    let process = Process::from_toml(&text, "process.toml", Folder::in_memory([]), &machine).unwrap();
    // Into the box from x = −60 on, 5 mm deep and 3 mm wide at its rim, along +y.
    let at = |y: f64| Vector3::new(-55.0, y, -7.0);
    let line = Toolpath::line(at(-60.0), at(20.0), process.sampling).unwrap();
    let mut points = line.points().to_vec();
    for point in &mut points {
        (point.feed_mm_per_min, point.spindle_rev_per_min) = (Some(2400.0), Some(8000.0));
    }
    let path = Toolpath::assemble(points);
    let path = process.mark_cutting(path, "part.nc").unwrap();
    let (point, own) = (path.points()[50], path.engagements()[50]);
    assert!((own.depth_mm - 5.0).abs() < 1e-6 && (own.width_mm - 3.0).abs() < 2e-3, "{own:?}");
    // Seen from the spindle at −x the tool moves along y; the part is at larger z.
    let standing = cut([2.0, 50.0], TOOL, MATERIAL, LINE);
    let (other, _) = middle(&standing)[5];
    let [a, b] = [point, other].map(|point| point.load.unwrap().force_N);
    let turned = [Vector3::new(b.z, b.x, b.y), Vector3::new(b.z, b.x, -b.y)];
    assert!(turned.iter().any(|own| (a - own).norm() < 1e-3 * a.norm()), "{a} instead of {b}, turned");
}

/// What the comment of a program says about its tool does what the same numbers in the process file do, in the unit of the program.
#[test]
fn tools_are_known_from_comments() {
    let orthoglide = Machine::named("orthoglide").unwrap();
    let own = |tool: &str| process([-3.0, 50.0], tool, MATERIAL);
    let with = |comment: &str, program: &str| format!("{comment}\n{}", program.replace("S8000", "T1 M6\nS8000"));
    let teeth = own("[tools.1]\nteeth = 4\n");
    for (comment, table) in [
        ("(T1 D=10. CR=0. - ZMIN=-5. - flat end mill)", TOOL.to_string()),
        ("(T1 D=10. CR=5. - ZMIN=-5. - ball end mill)", format!("{TOOL}shape = \"ball\"\n")),
        ("(T1 D=10. CR=1. - bullnose end mill)", format!("{TOOL}shape = \"bull_nose\"\ncorner_radius_mm = 1.0\n")),
        ("(T1 = End Mill {10 mm})", TOOL.to_string()),
    ] {
        let found = job_beside(&teeth, &orthoglide, &with(comment, LINE), &[]).unwrap();
        let given = job_beside(&own(&table), &orthoglide, &with("", LINE), &[]).unwrap();
        assert_eq!(found.path.engagements(), given.path.engagements(), "{comment}");
        assert!(found.path.points().iter().zip(given.path.points()).all(|(a, b)| a.load == b.load), "{comment}");
        // What stands in both may differ by the rounding of the comment.
        job_beside(&own(&table.replace("10.0", "10.008")), &orthoglide, &with(comment, LINE), &[]).unwrap();
    }
    // Teeth are in some comments; a program without T has one tool.
    let words = with("(  Tool #1: Flat End Mill 4 Flutes, Diam = 10mm, Len = 20mm)", LINE).replace("T1 M6\n", "");
    job_beside(&own(""), &orthoglide, &words, &[]).unwrap();
    let inches =
        "(T1 D=0.5 CR=0. - flat end mill)\nG20 G90\nT1 M6\nS8000 M3\nG0 X-.8 Y0 Z-.4\nG1 Z0 F94.5\nX.8\nG0 Z-.4\n";
    let found = job_beside(&teeth, &orthoglide, inches, &[]).unwrap();
    assert!((middle(&found)[3].1.width_mm - (6.35 + 3.0)).abs() < 2e-3);
}

#[test]
fn what_comments_leave_open_or_contradict_is_refused() {
    let orthoglide = Machine::named("orthoglide").unwrap();
    let ball = "(T1 D=6. CR=3. - ZMIN=-2. - ball end mill)";
    let chamfer = "(T1 D=6. CR=0. TAPER=45deg - ZMIN=-1. - chamfer mill)";
    for (comments, tool, expected) in [
        (
            ball,
            "",
            "is of tool 1, by the comment on line 1 a ball end mill of 6 mm, whose number of teeth is not known: expected tools.1.teeth",
        ),
        (
            ball,
            "[tools.1]\ndiameter_mm = 8.0\nteeth = 2",
            "move 2: is of tool 1, by tools.1 a tool of 8 mm with 2 teeth, and by the comment on line 1 a ball end mill of 6 mm: expected the same diameter",
        ),
        (ball, "[tools.1]\nshape = \"flat\"\nteeth = 2", "expected the same shape"),
        (
            "(T1 D=6. CR=0. - ZMIN=-2. - flat end mill)\n(T1 D=8. CR=0. - flat end mill)",
            "[tools.1]\nteeth = 2",
            "by the comment on line 1 a flat end mill of 6 mm, and by the comment on line 2 a flat end mill of 8 mm: expected the same diameter",
        ),
        (
            chamfer,
            "[tools.1]\nteeth = 2",
            "by the comment on line 1 a chamfer mill of 6 mm, which stock cannot be cut with",
        ),
        (chamfer, "[tools.1]\nshape = \"flat\"\nteeth = 2", "expected the same shape"),
        (
            "(T1 D=4.2 CR=0. - right hand tap)",
            "[tools.1]\nteeth = 2",
            "a right hand tap of 4.2 mm, which stock cannot be cut with",
        ),
        ("(T1 = V-Bit {60 deg})", "[tools.1]\nteeth = 2", "whose diameter is not known: expected tools.1.diameter_mm"),
        (
            "(T1  D=0.25 CR=0. - ZMIN=-0.0311 - 1-4 FLAT)",
            "[tools.1]\nteeth = 2",
            "whose shape is not known: expected tools.1.shape",
        ),
        (
            "(T1 D=8. CR=2. - 8 FINISH)",
            "[tools.1]\nshape = \"flat\"\nteeth = 2",
            "by the comment on line 1 a tool of 8 mm with corners of 2 mm: expected the same shape",
        ),
        (
            "(T1 D=8. CR=2. TAPER=10deg - cono)",
            "[tools.1]\nshape = \"bull_nose\"\ncorner_radius_mm = 2.0\nteeth = 2",
            "with a point of 10°: expected the same shape",
        ),
        (
            "(T1 = End Mill {0,5 inches})",
            "[tools.1]\nteeth = 2",
            "whose diameter is not known: expected tools.1.diameter_mm",
        ),
        (
            "(  Tool 1: Bull Nose End Mill 2 Flutes, Diam = 6mm)",
            "",
            "whose corner radius is not known: expected tools.1.corner_radius_mm",
        ),
        ("(T1 D=6. CR=5. - bullnose end mill)", "[tools.1]\nteeth = 2", "corner radius 5 mm: expected 0 to 3 mm"),
        ("(T1 D=0. CR=0. - flat end mill)", "[tools.1]\nteeth = 2", "diameter of the cutter is 0"),
        (
            "(T2 D=6. CR=0. - flat end mill)",
            "",
            "move 2: is of tool 1, whose geometry is not known: expected [tools.1]",
        ),
        (
            "(T1 D=6. CR=0. - flat end mill)\nG20 G0 X0 Y0 Z-0.4\nG21",
            "[tools.1]\nteeth = 2",
            "whose diameter is not known: expected tools.1.diameter_mm",
        ),
    ] {
        let program = format!("{comments}\n{}", LINE.replace("S8000", "T1 M6\nS8000"));
        let found = problem(&process([-3.0, 50.0], tool, MATERIAL), &orthoglide, &program);
        assert!(found.contains(expected), "{found}\ninstead of {expected}\n{program}");
    }
    // What touches nothing may have any shape.
    let beside = LINE.replace("X20\n", "X20\nG0 Z-10\nT2 M6\nG1 Z-8 X0 F600\n").replace("S8000", "T1 M6\nS8000");
    let program = chamfer.replace("T1", "T2") + "\n" + &beside;
    job_beside(&process([-3.0, 50.0], TOOL, MATERIAL), &orthoglide, &program, &[]).unwrap();
}

/// An STL file in text of the box between two corners, turned by an angle about z; its triangles in their order.
pub(crate) fn box_triangles(low: [f64; 3], high: [f64; 3], turn_deg: f64) -> Vec<[[f64; 3]; 3]> {
    let (sine, cosine) = turn_deg.to_radians().sin_cos();
    let corner = |k: usize| {
        let [x, y, z] = [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { high[axis] } else { low[axis] });
        [cosine * x - sine * y, sine * x + cosine * y, z]
    };
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    sides.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).map(|own| own.map(corner)).collect()
}

fn ascii_stl(triangles: &[[[f64; 3]; 3]]) -> Vec<u8> {
    let mut text = "solid part of a test\n".to_string();
    for corners in triangles {
        text += "facet normal 0 0 0\n outer loop\n";
        text.extend(corners.iter().map(|[x, y, z]| format!("  vertex {x:e} {y:e} {z:e}\n")));
        text += " endloop\nendfacet\n";
    }
    // Its name is in Latin-1.
    [text.as_bytes(), b"ENDSOLID pi\xe8ce\r\n"].concat()
}

/// With a header that begins as a text does.
pub(crate) fn binary_stl(triangles: &[[[f64; 3]; 3]]) -> Vec<u8> {
    let mut bytes = format!("{:<80}", "solid of another program\n").into_bytes();
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for corners in triangles {
        bytes.extend([0; 12]);
        bytes.extend(corners.iter().flatten().flat_map(|own| (*own as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn mesh_process() -> String {
    let own = process([-3.0, 50.0], TOOL, MATERIAL);
    own.replace("box = { min_mm = [-60.0, -3.0, -5.0], max_mm = [60.0, 50.0, 20.0] }", "mesh = \"blank.stl\"")
}

/// A mesh is cut as the box that it is, in text and binary, also where it and the program are turned together, or the tool lies.
#[test]
fn a_mesh_is_cut_as_what_it_is() {
    let orthoglide = Machine::named("orthoglide").unwrap();
    let (low, high) = ([-60.0, -3.0, -5.0], [60.0, 50.0, 20.0]);
    let turned = |degrees: f64| {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let at = |x: f64| format!("X{:.5} Y{:.5}", x * cosine, x * sine);
        LINE.replace("X-20 Y0", &at(-19.9)).replace("X20", &at(19.9))
    };
    let given = cut([-3.0, 50.0], TOOL, MATERIAL, &turned(0.0));
    for degrees in [0.0, 30.0, 205.0] {
        let triangles = box_triangles(low, high, degrees);
        // A collapsed triangle, as some programs write them, is left out; 0 and −0 are one.
        let mut with_more = triangles.clone();
        with_more.push([triangles[0][0], triangles[0][1], triangles[0][0]]);
        for stl in [ascii_stl(&triangles), binary_stl(&triangles), binary_stl(&with_more)] {
            let found = job_beside(&mesh_process(), &orthoglide, &turned(degrees), &[("blank.stl", stl)]).unwrap();
            let turn = nalgebra::Rotation3::from_axis_angle(&Vector3::z_axis(), degrees.to_radians());
            for ((a, own), (b, other)) in found
                .path
                .points()
                .iter()
                .zip(found.path.engagements())
                .zip(given.path.points().iter().zip(given.path.engagements()))
            {
                assert!(
                    (own.width_mm - other.width_mm).abs() < 2e-3 && (own.depth_mm - other.depth_mm).abs() < 1e-5,
                    "{degrees}: {own:?} {other:?}"
                );
                assert_eq!(a.load.is_some(), b.load.is_some(), "{degrees}: {a:?}");
                if let Some((a, b)) = a.load.zip(b.load) {
                    assert!((a.force_N - turn * b.force_N).norm() <= 2e-3 * b.force_N.norm(), "{degrees}: {a:?} {b:?}");
                }
            }
        }
    }
    let sideways =
        LEVER.replace("tool_tip_mm = [0.0, 0.0, 50.0]", "tool_tip_mm = [50.0, 0.0, 0.0]\ntool_axis = [1.0, 0.0, 0.0]");
    let lever = Machine::from_toml(&sideways, "lever.toml").unwrap();
    let stl = binary_stl(&box_triangles(low, high, 0.0));
    let line = |y: f64| Vector3::new(-55.0, y, -7.0);
    let engagements = |process: &str| {
        let folder = Folder::in_memory([("blank.stl".to_string(), stl.clone())]);
        let process = Process::from_toml(&format!("schema = 1\n{process}"), "process.toml", folder, &lever).unwrap();
        let path = Toolpath::line(line(-60.0), line(20.0), process.sampling).unwrap();
        let mut points = path.points().to_vec();
        for point in &mut points {
            (point.feed_mm_per_min, point.spindle_rev_per_min) = (Some(2400.0), Some(8000.0));
        }
        let path = process.mark_cutting(Toolpath::assemble(points), "part.nc").unwrap();
        (path.engagements()[65].depth_mm, path.engagements()[65].width_mm)
    };
    let (a, b) = (engagements(&mesh_process()), engagements(&process([-3.0, 50.0], TOOL, MATERIAL)));
    assert!((a.0 - b.0).abs() < 1e-5 && (a.1 - b.1).abs() < 1e-3 && a.0 > 1.0, "{a:?} {b:?}");
}

#[test]
fn a_mesh_that_is_no_stock_is_refused() {
    let orthoglide = Machine::named("orthoglide").unwrap();
    let whole = box_triangles([-60.0, -3.0, -5.0], [60.0, 50.0, 20.0], 0.0);
    let scaled =
        |by: f64| -> Vec<[[f64; 3]; 3]> { whole.iter().map(|own| own.map(|own| own.map(|own| by * own))).collect() };
    let long = LINE.replace("X20", "X20\nX60");
    let text =
        |bytes: Vec<u8>, from: &str, to: &str| String::from_utf8_lossy(&bytes).replacen(from, to, 1).into_bytes();
    let mut cut_off = binary_stl(&whole);
    cut_off.truncate(400);
    for (stl, program, expected) in [
        (
            binary_stl(&whole[1..]),
            LINE,
            "process.toml: stock.mesh: blank.stl: mesh: it is open at the edge between vertices",
        ),
        (binary_stl(&[]), LINE, "stock.mesh: blank.stl: mesh: 0 triangles"),
        (ascii_stl(&[]), LINE, "stock.mesh: blank.stl: mesh: 0 triangles"),
        ([ascii_stl(&whole), ascii_stl(&whole)].concat(), LINE, "stock.mesh: blank.stl: has 2 solids: expected one"),
        (Vec::new(), LINE, "stock.mesh: blank.stl: is no STL file: expected"),
        (b"solid".to_vec(), LINE, "stock.mesh: blank.stl: triangle 1: EOF"),
        (cut_off, LINE, "stock.mesh: blank.stl: is no STL file: expected"),
        (binary_stl(&scaled(f64::NAN)), LINE, "blank.stl: has a vertex at (NaN, NaN, NaN) mm"),
        (text(ascii_stl(&whole), "-6e1", "nan"), LINE, "blank.stl: triangle 1: expected finite"),
        (text(ascii_stl(&whole), "vertex", "corner"), LINE, "blank.stl: triangle 1: vertex"),
        (binary_stl(&scaled(1e6)), LINE, "blank.stl: has a vertex at (-60000000,"),
        (
            binary_stl(&scaled(1e-3)),
            long.as_str(),
            "stock.mesh: is 0.120 mm large, and the path 80 mm: expected mm, not metres",
        ),
        (binary_stl(&scaled(0.0)), LINE, "stock.mesh: blank.stl: mesh: "),
    ] {
        let found = job_beside(&mesh_process(), &orthoglide, program, &[("blank.stl", stl)])
            .map(|_| ())
            .unwrap_err()
            .to_string();
        assert!(found.contains(expected), "{found}\ninstead of {expected}");
    }
    let found = problem(&mesh_process(), &orthoglide, LINE);
    assert!(found.contains("stock.mesh: \"blank.stl\" is not a file in the folder of the process file"), "{found}");
    let both = mesh_process()
        .replace("mesh =", "cylinder = { base_mm = [0.0, 0.0, 0.0], diameter_mm = 9.0, height_mm = 9.0 }\nmesh =");
    assert!(problem(&both, &orthoglide, LINE).contains("stock: expected one of box, cylinder and mesh"));
}

/// A change of the mesh, or of an earlier program, is one of the inputs.
#[test]
fn what_stock_is_read_from_is_an_input() {
    let orthoglide = Machine::named("orthoglide").unwrap();
    let inputs = |low: f64, earlier: &str| {
        let stl = binary_stl(&box_triangles([-60.0, -3.0, low], [60.0, 50.0, 20.0], 0.0));
        let process = mesh_process().replace("[stock]", "[stock]\nafter = [\"op1.nc\"]");
        let files = [("blank.stl", stl), ("op1.nc", earlier.as_bytes().to_vec())];
        job_beside(&process, &orthoglide, &LINE.replace("Z0", "Z2"), &files).unwrap().process.inputs
    };
    let own = inputs(-5.0, LINE);
    assert_eq!(own, inputs(-5.0, LINE));
    let change = |other| own.change_since(&other).unwrap();
    assert!(change(inputs(-4.9, LINE)).starts_with("blank.stl, line 1"));
    assert!(change(inputs(-5.0, &LINE.replace("F2400", "F1200"))).starts_with("op1.nc, line 4"));
}

/// A program behind another finds what the other leaves: as the second half of both in one.
#[test]
fn earlier_programs_are_cut_first() {
    let orthoglide = Machine::named("orthoglide").unwrap();
    let op1 = LINE.replace("G0 X-20", "T1 M6\nG0 X-20");
    // Wider by a millimetre on one side, and two deeper.
    let op2 = op1.replace("Y0", "Y1").replace("Z0", "Z2");
    let own = process([-50.0, 50.0], TOOL, MATERIAL);
    let one =
        job_beside(&own, &orthoglide, &(op1.clone() + &op2.replace("G21 G90\nS8000 M3\nT1 M6\n", "")), &[]).unwrap();
    let after = own.replace("[stock]", "[stock]\nafter = [\"op1.nc\"]");
    // Teeth are needed only where there is a force.
    let op1 = op1.replace("T1", "(T7 D=10. CR=0. - flat end mill)\nT7");
    let files = |earlier: &str| [("op1.nc", earlier.as_bytes().to_vec())];
    let found = job_beside(&after, &orthoglide, &op2, &files(&op1)).unwrap();
    let second = one.path.len() - found.path.len();
    let mut cut = 0;
    for ((a, own), (b, other)) in found
        .path
        .points()
        .iter()
        .zip(found.path.engagements())
        .zip(one.path.points()[second..].iter().zip(&one.path.engagements()[second..]))
    {
        // A peak is looked for where the force is the largest so far.
        let [own, other] = [own, other].map(|own| Engaged { peak_N: None, ..*own });
        assert_eq!((a.position_mm, a.load, own), (b.position_mm, b.load, other));
        cut += usize::from(a.load.is_some());
    }
    assert!(cut > 30);
    let middle = found.path.points().iter().position(|point| point.position_mm.x == 0.0).unwrap();
    assert!((found.path.engagements()[middle].depth_mm - 7.0).abs() < 1e-6);
    for (earlier, program, expected) in [
        (
            op1.replace("G1 Z0 F2400\nX20", "G1 Z0 F2400\nG0 X20"),
            &op2,
            "op1.nc: move 3: is rapid and goes through the stock at (",
        ),
        (
            op1.replace("T7 D", "T8 D"),
            &op2,
            "op1.nc: move 2: is of tool 7, whose geometry is not known: expected [tools.7]",
        ),
        (op1.replace("Z-10", "Z-4"), &op2, "op1.nc: move 1: begins with the tool in the stock"),
        (op1.replace("Z0", "Z-6"), &op2, "op1.nc: nothing touches the stock"),
        (op1.replace("X20", "Q20"), &op2, "op1.nc:"),
        ("M30\n".into(), &op2, "op1.nc: moves nowhere"),
        (op1.clone(), &op1.replace("(T7", "(T1").replace("T7", "T1"), "part.nc: nothing touches the stock"),
        (
            op1.replace("G0 Z-10\n", ""),
            &op2.replace("Z-10\nG1", "Z0\nG1"),
            "part.nc: move 1: begins with the tool in the stock",
        ),
    ] {
        let found = job_beside(&after, &orthoglide, program, &files(&earlier)).map(|_| ()).unwrap_err().to_string();
        assert!(found.contains(expected), "{found}\ninstead of {expected}\n{earlier}");
    }
    let found = job_beside(&after, &orthoglide, &op2, &[]).map(|_| ()).unwrap_err().to_string();
    assert!(found.contains("stock.after: \"op1.nc\" is not a file in the folder of the process file"), "{found}");
}
