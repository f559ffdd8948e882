//! What programs say of the posture of an arm, against definitions written here from the manuals and against what two makers' controllers computed.
//!
//! Joints give pose and configuration by the forward kinematics below, which share nothing with the library; a program is written from these two, and
//! the library has to find the joints.

use kinetostat::{
    compensation::Method,
    input::Folder,
    machine::Machine,
    process::Process,
    products::program::{CorrectedPath, Part, ProgramAsWritten, ProgramJob},
    work::Work,
};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

#[derive(Clone, Copy, Debug, PartialEq)]
enum Maker {
    Abb,
    Kuka,
    Fanuc,
}

/// Lengths of an arm, mm: height and offset of axis 2, lower arm, offset and length of the forearm, flange from the wrist centre.
#[derive(Clone, Copy, Debug)]
struct Arm {
    maker: Maker,
    lengths: [f64; 6],
    travel: [[f64; 2]; 6],
}

const WIDE: [[f64; 2]; 6] =
    [[-180.0, 180.0], [-180.0, 180.0], [-180.0, 180.0], [-300.0, 300.0], [-125.0, 125.0], [-360.0, 360.0]];

/// An ABB arm, as RobotStudio has it in the measurements below: IRB 6700.
const IRB: Arm = Arm { maker: Maker::Abb, lengths: [780.0, 320.0, 1125.0, 200.0, 1392.5, 350.0], travel: WIDE };
/// A FANUC arm, as ROBOGUIDE has it: M-20iD/25, world at the height of axis 2.
const M20: Arm = Arm { maker: Maker::Fanuc, lengths: [0.0, 75.0, 840.0, 215.0, 890.0, 90.0], travel: WIDE };
const KR: Arm = Arm {
    maker: Maker::Kuka,
    lengths: [675.0, 350.0, 1150.0, 41.0, 1200.0, 240.0],
    travel: [[-170.0, 170.0], [-195.0, 40.0], [-115.0, 150.0], [-185.0, 185.0], [-120.0, 120.0], [-350.0, 350.0]],
};

fn turn(axis: Vector3<f64>, degrees: f64) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::identity(), UnitQuaternion::new(axis * degrees.to_radians()))
}

fn shift(x: f64, y: f64, z: f64) -> Isometry3<f64> {
    Isometry3::translation(x, y, z)
}

impl Arm {
    /// Poses at joints in degrees: of the link behind axis 1, of that behind axis 2, of the forearm at the elbow, at the wrist centre and of the flange.
    fn poses(&self, q: [f64; 6]) -> [Isometry3<f64>; 5] {
        let [d1, a1, a2, a3, d4, d6] = self.lengths;
        let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
        let up = turn(y, 90.0);
        let [first, second, third, fourth, fifth, sixth, hand] = match self.maker {
            Maker::Abb => [q[0], q[1], q[2], q[3], q[4], q[5], 0.0],
            // From the upright position, as the others.
            Maker::Kuka => [-q[0], q[1] + 90.0, q[2] - 90.0, -q[3], q[4], -q[5], 0.0],
            Maker::Fanuc => [q[0], q[1], -q[1] - q[2], -q[3], -q[4], -q[5], 180.0],
        };
        let base = turn(z, first) * shift(a1, 0.0, d1);
        let lower = base * turn(y, second);
        let elbow = lower * shift(0.0, 0.0, a2) * turn(y, third);
        let wrist = elbow * shift(d4, 0.0, self.rise(a3)) * turn(x, fourth);
        let flange = wrist * turn(y, fifth) * turn(x, sixth) * shift(d6, 0.0, 0.0) * up * turn(z, hand);
        [base, lower, elbow, wrist, flange]
    }

    /// Height of the forearm's axis above axis 3.
    fn rise(&self, a3: f64) -> f64 {
        if self.maker == Maker::Kuka { -a3 } else { a3 }
    }

    /// Whether the wrist centre is behind axis 1, and behind the lower arm; and how far from the nearest of the three borders, mm or degrees.
    fn sides(&self, q: [f64; 6]) -> ([bool; 2], f64) {
        let [base, lower, _, wrist, _] = self.poses(q);
        let ahead = base.inverse_transform_point(&wrist.translation.vector.into()).x + self.lengths[1];
        let before = lower.inverse_transform_point(&wrist.translation.vector.into()).x;
        ([ahead < 0.0, before < 0.0], ahead.abs().min(before.abs()).min(q[4].abs() * 20.0))
    }

    /// The configuration by the definitions of the maker.
    fn configuration(&self, q: [f64; 6]) -> String {
        let ([is_back, is_behind], _) = self.sides(q);
        match self.maker {
            // Technical reference manual RAPID, confdata.
            Maker::Abb => {
                let quadrant = |axis: usize| (q[axis] / 90.0).floor() + 0.0;
                let cfx = 4 * u8::from(is_back) + 2 * u8::from(is_behind) + u8::from(q[4] < 0.0);
                format!("[{},{},{},{cfx}]", quadrant(0), quadrant(3), quadrant(5))
            }
            // KUKA System Software, Status and Turn: bit 1 of S by the angle of A3.
            Maker::Kuka => {
                let straight = f64::atan2(-self.lengths[3], self.lengths[4]).to_degrees();
                let s = u8::from(is_back) + 2 * u8::from(q[2] >= straight) + 4 * u8::from(q[4] < 0.0);
                let t: u32 = (0..6).map(|axis| u32::from(q[axis] < 0.0) << axis).sum();
                format!("S {s},T {t}")
            }
            // FANUC, as ROBOGUIDE has it in the measurements below.
            Maker::Fanuc => {
                let letter = |is: bool, [yes, no]: [&'static str; 2]| if is { yes } else { no };
                let turns = |axis: usize| (q[axis] / 360.0).round() + 0.0;
                format!(
                    "{} {} {}, {}, {}, {}",
                    letter(q[4] < 0.0, ["N", "F"]),
                    letter(is_behind, ["D", "U"]),
                    letter(is_back, ["B", "T"]),
                    turns(0),
                    turns(3),
                    turns(5)
                )
            }
        }
    }

    /// The arm as a machine, with its home at these joints, degrees.
    fn machine(&self, home: [f64; 6]) -> Machine {
        let [d1, a1, a2, a3, d4, d6] = self.lengths;
        let drive = |axis: usize, about: &str, shown: &str| {
            let [low, high] = self.travel[axis];
            format!(
                "  {{ revolute_drive = {{ name = \"J{}\", axis = \"{about}\", stiffness_Nmm_per_rad = 1e9, home_deg = {:.6}, \
                 travel_deg = [{low:.1}, {high:.1}]{shown} }} }},\n",
                axis + 1,
                home[axis]
            )
        };
        let of = |joints: &str| format!(", shown = {{ of = {{ {joints} }} }}");
        let (j1, j3, j4, j5, j6) = match self.maker {
            Maker::Abb => Default::default(),
            Maker::Kuka => (of("J1 = -1.0"), String::new(), of("J4 = -1.0"), String::new(), of("J6 = -1.0")),
            Maker::Fanuc => {
                (String::new(), of("J2 = -1.0, J3 = -1.0"), of("J4 = -1.0"), of("J5 = -1.0"), of("J6 = -1.0"))
            }
        };
        let fixed = |x: f64, z: f64| format!("  {{ fixed = {{ translation_mm = [{x:.3}, 0.0, {z:.3}] }} }},\n");
        let lower = if self.maker == Maker::Kuka { fixed(a2, 0.0) } else { fixed(0.0, a2) };
        let hand = if self.maker == Maker::Fanuc { "[180.0, -90.0, 0.0]" } else { "[0.0, 90.0, 0.0]" };
        let flange = self.poses(home)[4];
        let (roll, pitch, yaw) = flange.rotation.euler_angles();
        let at = flange.translation.vector;
        let [roll, pitch, yaw] = [roll, pitch, yaw].map(f64::to_degrees);
        let text = format!(
            "schema = 1\nname = \"arm\"\ntitle = \"Arm\"\nsource = \"a test\"\n[platform]\ntool_tip_mm = [0.0, 0.0, 0.0]\n\
             tool_axis = [0.0, 0.0, 1.0]\ncontrols = [\"x\", \"y\", \"z\", \"rotation_x\", \"rotation_y\", \"rotation_z\"]\n\
             [home]\nposition_mm = [{:.9}, {:.9}, {:.9}]\nrotation_deg = [{roll:.9}, {pitch:.9}, {yaw:.9}]\n\
             [workspace]\nmin_mm = [{:.1}, {:.1}, {:.1}]\nmax_mm = [{:.1}, {:.1}, {:.1}]\n[[chain]]\nname = \"arm\"\nelements = [\n\
             {}{}{}{}{lower}{}{}{}{}{}  {{ fixed = {{ translation_mm = [{d6:.3}, 0.0, 0.0], rotation_deg = {hand} }} }},\n]\n\
             [[mount]]\nname = \"arm\"\nchain = \"arm\"\n",
            at.x,
            at.y,
            at.z,
            at.x - 10.0,
            at.y - 10.0,
            at.z - 10.0,
            at.x + 10.0,
            at.y + 10.0,
            at.z + 10.0,
            fixed(0.0, d1),
            drive(0, "z", &j1),
            fixed(a1, 0.0),
            drive(1, "y", ""),
            drive(2, "y", &j3),
            fixed(d4, self.rise(a3)),
            drive(3, "x", &j4),
            drive(4, "y", &j5),
            drive(5, "x", &j6),
        );
        Machine::from_toml(&text, "arm.toml").unwrap_or_else(|refused| panic!("{refused}\n{text}"))
    }

    fn file_name(&self) -> &'static str {
        match self.maker {
            Maker::Abb => "part.mod",
            Maker::Kuka => "part.src",
            Maker::Fanuc => "part.ls",
        }
    }

    /// A program to these poses of the flange with these configurations; a motion from point to point where `free`.
    fn program(&self, targets: &[(bool, Isometry3<f64>, String)]) -> String {
        let with_abc = |pose: &Isometry3<f64>| {
            let (c, b, a) = pose.rotation.euler_angles();
            [a, b, c].map(f64::to_degrees)
        };
        let mut text = String::new();
        match self.maker {
            Maker::Abb => {
                text += "MODULE part\nPROC main()\n";
                for (is_free, pose, configuration) in targets {
                    let (p, q) = (pose.translation.vector, pose.rotation);
                    text += &format!(
                        "{} [[{:.9},{:.9},{:.9}],[{:.12},{:.12},{:.12},{:.12}],{configuration},[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;\n",
                        if *is_free { "MoveJ" } else { "MoveL" },
                        p.x,
                        p.y,
                        p.z,
                        q.w,
                        q.i,
                        q.j,
                        q.k
                    );
                }
                text += "ENDPROC\nENDMODULE\n";
            }
            Maker::Kuka => {
                text += "DEF part()\n$BASE=$NULLFRAME\n$TOOL={X 0,Y 0,Z 0,A 0,B 0,C 0}\n$VEL.CP=0.1\n";
                for (is_free, pose, configuration) in targets {
                    let (p, [a, b, c]) = (pose.translation.vector, with_abc(pose));
                    text += &format!(
                        "{} {{X {:.9},Y {:.9},Z {:.9},A {a:.10},B {b:.10},C {c:.10},{configuration}}}\n",
                        if *is_free { "PTP" } else { "LIN" },
                        p.x,
                        p.y,
                        p.z
                    );
                }
                text += "END\n";
            }
            Maker::Fanuc => {
                text += "/PROG  PART\n/ATTR\nLINE_COUNT\t= 9;\n/MN\n   1:  UFRAME_NUM=0 ;\n   2:  UTOOL_NUM=0 ;\n";
                for (k, (is_free, ..)) in targets.iter().enumerate() {
                    let (word, speed) = if *is_free { ("J", "50%") } else { ("L", "100mm/sec") };
                    text += &format!("{:4}:{word} P[{}] {speed} FINE    ;\n", k + 3, k + 1);
                }
                text += "/POS\n";
                for (k, (_, pose, configuration)) in targets.iter().enumerate() {
                    let (p, [r, pitch, w]) = (pose.translation.vector, with_abc(pose));
                    text += &format!(
                        "P[{}]{{\n   GP1:\n\tUF : 0, UT : 0,\t\tCONFIG : '{configuration}',\n\tX = {:.9}  mm,\tY = {:.9}  mm,\tZ = {:.9}  mm,\n\
                         \tW = {w:.10} deg,\tP = {pitch:.10} deg,\tR = {r:.10} deg\n}};\n",
                        k + 1,
                        p.x,
                        p.y,
                        p.z
                    );
                }
                text += "/END\n";
            }
        }
        text
    }

    fn job(&self, home: [f64; 6], text: &str, process: &str) -> Result<ProgramJob, String> {
        let machine = self.machine(home);
        let process = format!(
            "schema = 1\n[placement]\norigin_mm = [0.0, 0.0, 0.0]\n[sampling]\nmax_segment_mm = 20.0\n{process}"
        );
        let process =
            Process::from_toml(&process, "process", Folder::in_memory([]), &machine).map_err(|e| e.to_string())?;
        let folder = Folder::in_memory([(self.file_name().to_owned(), text.as_bytes().to_vec())]);
        let file = process.program_in_folder(&folder, self.file_name()).map_err(|e| e.to_string())?;
        ProgramJob::new(process, file, self.file_name(), &Work::default()).map_err(|e| e.to_string())
    }
}

/// Joints, degrees, at the end of each motion of `job`.
fn joints_at_ends(job: &ProgramJob) -> Vec<Option<[f64; 6]>> {
    let mut found = Vec::new();
    job.pass_by(Method::None, &|| (), |part, results| {
        let ends = part.points.iter().zip(results).filter(|(point, _)| point.source.parameter == 1.0);
        found.extend(ends.map(|(_, result)| {
            let drives: Option<[f64; 6]> = result.nominal_drives.as_slice().try_into().ok();
            drives.filter(|_| result.status.is_success()).map(|drives| drives.map(f64::to_degrees))
        }));
        Ok(())
    })
    .unwrap();
    found
}

struct Random(u64);

impl Random {
    fn between(&mut self, [low, high]: [f64; 2]) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * ((self.0 >> 11) as f64 / (1u64 << 53) as f64)
    }

    /// Joints of `arm` within its travel and away from where two of its postures meet, degrees.
    fn joints(&mut self, arm: &Arm) -> [f64; 6] {
        loop {
            let q = arm.travel.map(|[low, high]| self.between([low + 13.0, high - 13.0]));
            if arm.sides(q).1 > 150.0 {
                return q;
            }
        }
    }
}

fn assert_near(found: Option<[f64; 6]>, wanted: [f64; 6], about: &str) {
    let found = found.unwrap_or_else(|| panic!("{about}: no posture, expected {wanted:?}"));
    let off = found.iter().zip(wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off < 1e-4, "{about}: joints {found:?}, expected {wanted:?}");
}

/// Three hundred paths: to a random posture from point to point, along a line over borders of quadrants and turns, and to another posture.
#[test]
fn the_configuration_of_a_program_chooses_the_posture() {
    let mut random = Random(7);
    let mut over_borders = 0;
    for k in 0..300 {
        let arm = [IRB, KR, M20][k % 3];
        let [from, other, home] = [(); 3].map(|()| random.joints(&arm));
        let mut along = from.map(|q| q + random.between([-2.0, 2.0]));
        for wrist in [3, 5] {
            along[wrist] = from[wrist] + random.between([-12.0, 12.0]);
        }
        over_borders += usize::from(arm.configuration(from) != arm.configuration(along));
        let targets = [(true, from), (false, along), (true, other)];
        let poses = targets.map(|(is_free, q)| (is_free, arm.poses(q)[4], arm.configuration(q)));
        let text = arm.program(&poses);
        let job = arm.job(home, &text, "").unwrap_or_else(|refused| panic!("{k}: {refused}\n{text}"));
        let found = joints_at_ends(&job);
        for ((_, wanted), found) in targets.into_iter().zip(found) {
            assert_near(found, wanted, &format!("path {k}\n{text}"));
        }
    }
    assert!(over_borders > 10, "{over_borders} of the lines cross a border");
}

/// One number or letter that is not so: the error names line, data and posture.
#[test]
fn data_that_contradict_the_posture_are_refused_by_line() {
    let mut random = Random(3);
    for (arm, wrong, line, shown) in [
        (IRB, ["[0,0,0,1]", "[0,0,0,0]", "[2,0,0,1]", "[0,-3,0,1]"].as_slice(), "line 4", "confdata"),
        (KR, &["S 2,T 2", "S 6,T 2", "S 3,T 18", "S 0,T 18"], "line 6", "S "),
        (M20, &["F U T, 0, 0, 0", "N D T, 0, 0, 0", "N U B, 0, 0, 0", "N U T, 0, 1, 0"], "line 8", "CONFIG"),
    ] {
        let home = match arm.maker {
            Maker::Abb => [5.0, 10.0, 5.0, 100.0, 60.0, 20.0],
            Maker::Kuka => [5.0, -80.0, 100.0, 10.0, 60.0, 20.0],
            Maker::Fanuc => [5.0, 10.0, 5.0, 10.0, -60.0, 20.0],
        };
        let along = home.map(|q| q + random.between([-1.0, 1.0]));
        let good = arm.configuration(along);
        let named = good.replace(",T", ", T");
        for (is_free, first) in [(false, arm.configuration(home)), (true, arm.configuration(home))] {
            for wrong in wrong.iter().filter(|wrong| **wrong != good) {
                let targets =
                    [(true, arm.poses(home)[4], first.clone()), (is_free, arm.poses(along)[4], (*wrong).to_owned())];
                let refused = arm.job(home, &arm.program(&targets), "");
                // From point to point another posture may be reached.
                let Err(refused) = refused else {
                    assert!(is_free, "{wrong}");
                    continue;
                };
                assert!(refused.contains(line) && refused.contains(shown) && refused.contains(&named), "{refused}");
            }
        }
    }
}

/// A row of the numbers of a controller: as the constant that holds them says.
type MeasuredRow = ([f64; 6], &'static str, [f64; 3], &'static str, [f64; 6]);

/// Joints and what RobotStudio (CalcRobT, IRB 6700) and ROBOGUIDE (M-20iD/25) computed of them: LeroyDu56/robconv, tests/fixtures/probes/results.
const MEASURED: [MeasuredRow; 16] = [
    (
        [0.0, 0.0, 0.0, 0.0, -90.0, 0.0],
        "[0,0,0,1]",
        [1712.5, 0.0, 2455.0],
        "N U T, 0, 0, 0",
        [965.0, 0.0, 965.0, -180.0, 0.0, 0.0],
    ),
    (
        [0.0, 0.0, 0.0, 0.0, 90.0, 0.0],
        "[0,0,0,0]",
        [1712.5, 0.0, 1755.0],
        "F U T, 0, 0, 0",
        [965.0, 0.0, 1145.0, 0.0, 0.0, -180.0],
    ),
    (
        [0.0, 0.0, 0.0, 0.0, -30.0, 0.0],
        "[0,0,0,1]",
        [2015.609, 0.0, 2280.0],
        "N U T, 0, 0, 0",
        [1042.942, 0.0, 1010.0, 180.0, -60.0, 0.0],
    ),
    (
        [0.0, 0.0, 0.0, 0.0, 30.0, 0.0],
        "[0,0,0,0]",
        [2015.609, 0.0, 1930.0],
        "F U T, 0, 0, 0",
        [1042.942, 0.0, 1100.0, 0.0, -60.0, 180.0],
    ),
    (
        [0.0, 0.0, 0.0, 185.0, -90.0, 0.0],
        "[0,2,0,1]",
        [1712.5, 30.505, 1756.332],
        "N U T, 0, 1, 0",
        [965.0, 7.844, 1144.657, -5.0, 0.0, 0.0],
    ),
    (
        [0.0, 0.0, 0.0, -185.0, -90.0, 0.0],
        "[0,-3,0,1]",
        [1712.5, -30.505, 1756.332],
        "N U T, 0, -1, 0",
        [965.0, -7.844, 1144.657, 5.0, 0.0, 0.0],
    ),
    (
        [0.0, 0.0, 0.0, 0.0, -90.0, 190.0],
        "[0,0,2,1]",
        [1712.5, 0.0, 2455.0],
        "N U T, 0, 0, 1",
        [965.0, 0.0, 965.0, 180.0, 0.0, -170.0],
    ),
    (
        [0.0, 0.0, 0.0, 0.0, -90.0, -190.0],
        "[0,0,-3,1]",
        [1712.5, 0.0, 2455.0],
        "N U T, 0, 0, -1",
        [965.0, 0.0, 965.0, -180.0, 0.0, 170.0],
    ),
    (
        [0.0, 0.0, 0.0, 0.0, -90.0, 350.0],
        "[0,0,3,1]",
        [1712.5, 0.0, 2455.0],
        "N U T, 0, 0, 1",
        [965.0, 0.0, 965.0, 180.0, 0.0, -10.0],
    ),
    (
        [0.0, 40.0, 60.0, 0.0, -90.0, 0.0],
        "[0,0,0,1]",
        [1342.975, 0.0, 174.949],
        "N D T, 0, 0, 0",
        [951.688, 0.0, 1476.74, 180.0, -60.0, 0.0],
    ),
    (
        [0.0, 40.0, -60.0, 0.0, -90.0, 0.0],
        "[0,0,0,1]",
        [2163.547, 0.0, 2634.894],
        "N U T, 0, 0, 0",
        [1168.195, 0.0, -64.785, -180.0, 60.0, 0.0],
    ),
    (
        [0.0, -60.0, -80.0, 0.0, -90.0, 0.0],
        "[0,0,0,5]",
        [-2074.529, 0.0, 1816.257],
        "N D B, 0, 0, 0",
        [-374.813, 0.0, -434.773, -180.0, 80.0, 0.0],
    ),
    (
        [0.0, -60.0, 80.0, 0.0, -90.0, 0.0],
        "[0,0,0,1]",
        [842.354, 0.0, 1383.068],
        "N U B, 0, 0, 0",
        [-621.015, 0.0, 1318.185, 180.0, -80.0, 0.0],
    ),
    (
        [0.0, 60.0, 80.0, 0.0, -90.0, 0.0],
        "[0,0,0,1]",
        [581.095, 0.0, 26.094],
        "N D T, 0, 0, 0",
        [833.907, 0.0, 1318.185, 180.0, -80.0, 0.0],
    ),
    (
        [90.0, 0.0, 0.0, 0.0, -90.0, 0.0],
        "[1,0,0,1]",
        [0.0, 1712.5, 2455.0],
        "N U T, 0, 0, 0",
        [0.0, 965.0, 965.0, -180.0, 0.0, 90.0],
    ),
    (
        [-150.0, 0.0, 0.0, 0.0, -90.0, 0.0],
        "[-2,0,0,1]",
        [-1483.068, -856.25, 2455.0],
        "N U T, 0, 0, 0",
        [-835.714, -482.5, 965.0, -180.0, 0.0, -150.0],
    ),
];

#[test]
fn the_makers_controllers_mean_the_same_postures() {
    for (joints, confdata, abb, config, fanuc) in MEASURED {
        // The definitions and the kinematics of this test.
        assert!((IRB.poses(joints)[4].translation.vector - Vector3::from(abb)).norm() < 1e-3, "{joints:?}");
        let [x, y, z, w, p, r] = fanuc;
        let pose = Isometry3::from_parts(
            Translation3::new(x, y, z),
            UnitQuaternion::from_euler_angles(w.to_radians(), p.to_radians(), r.to_radians()),
        );
        let own = M20.poses(joints)[4];
        assert!((own.translation.vector - pose.translation.vector).norm() < 1e-3, "{joints:?}");
        assert!(own.rotation.angle_to(&pose.rotation) < 1e-6, "{joints:?}");
        assert_eq!([IRB.configuration(joints), M20.configuration(joints)], [confdata, config], "{joints:?}");
        // The library.
        for (arm, configuration) in [(IRB, confdata), (M20, config)] {
            let text = arm.program(&[(true, arm.poses(joints)[4], configuration.to_owned())]);
            let home = [20.0, 15.0, 10.0, 40.0, 35.0, -30.0];
            let job = arm.job(home, &text, "").unwrap_or_else(|refused| panic!("{refused}\n{text}"));
            assert_near(joints_at_ends(&job)[0], joints, &text);
        }
    }
}

fn written(job: &ProgramJob) -> ProgramAsWritten {
    let mut corrected = CorrectedPath::new(job);
    let take = |part: &Part<'_>, answers: &[_]| {
        corrected.add(job, part, answers);
        Ok(())
    };
    job.pass_by(Method::Direct, &|| (), take).unwrap();
    assert_eq!(corrected.failures, []);
    job.write(&corrected).unwrap()
}

/// At another γ the arm stands otherwise: what is written says how, by the definitions above at the joints that are simulated.
#[test]
fn what_is_written_has_the_configuration_of_its_own_targets() {
    for (arm, home) in [
        (IRB, [5.0, 10.0, 5.0, 20.0, 60.0, 80.0]),
        (KR, [5.0, -80.0, 100.0, 10.0, 60.0, 20.0]),
        (M20, [5.0, 10.0, 5.0, 10.0, -60.0, -120.0]),
    ] {
        let pose = arm.poses(home)[4];
        let beside = |x: f64| {
            Isometry3::from_parts(
                Translation3::from(pose.translation.vector + Vector3::new(0.0, x, 0.0)),
                pose.rotation,
            )
        };
        let targets = [(true, pose), (false, beside(30.0)), (false, beside(60.0))];
        let text = arm.program(&targets.map(|(is_free, pose)| (is_free, pose, arm.configuration(home))));
        // Nothing changes: the same bytes.
        let job = arm.job(home, &text, "").unwrap_or_else(|refused| panic!("{refused}\n{text}"));
        assert_eq!(String::from_utf8(written(&job).bytes).unwrap(), text);
        let turned = "[redundancy]\ngamma = \"best_constant\"\nrange_deg = [90.0, 150.0]\nstep_deg = 30.0\n\
                      [force.path_frame]\nradial_force_N = 300.0\ntangential_force_N = -200.0\naxial_force_N = -100.0\n";
        let job = arm.job(home, &text, turned).unwrap_or_else(|refused| panic!("{refused}\n{text}"));
        let joints = joints_at_ends(&job);
        let said = String::from_utf8(written(&job).bytes).unwrap();
        let mut rest = said.as_str();
        for joints in joints {
            let own = arm.configuration(joints.unwrap());
            let at = rest.find(&own).unwrap_or_else(|| panic!("{own} at {joints:?} in\n{said}"));
            rest = &rest[at + own.len()..];
        }
        assert!(!said.contains(&arm.configuration(home)), "{said}");
    }
}

/// Positions of joints say where the next motion begins.
#[test]
fn positions_of_joints_say_the_posture_before_a_path() {
    let start = [15.0, 20.0, 10.0, 170.0, 60.0, 200.0];
    let end = start.map(|q| q + 2.0);
    let [x, y, z, q] = {
        let pose = IRB.poses(end)[4];
        let (p, q) = (pose.translation.vector, pose.rotation);
        [
            format!("{:.9}", p.x),
            format!("{:.9}", p.y),
            format!("{:.9}", p.z),
            format!("{:.12},{:.12},{:.12},{:.12}", q.w, q.i, q.j, q.k),
        ]
    };
    let text = format!(
        "MODULE part\nCONST jointtarget jp:=[[15,20,10,170,60,200],[9E9,9E9,9E9,9E9,9E9,9E9]];\nPROC main()\nConfL\\Off;\n\
         MoveAbsJ jp,v100,fine,tool0;\nMoveL [[{x},{y},{z}],[{q}],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;\nENDPROC\nENDMODULE\n"
    );
    let job = IRB.job([5.0, 10.0, 5.0, 20.0, 60.0, 80.0], &text, "").unwrap();
    assert_near(joints_at_ends(&job)[0], end, &text);
    // With ConfL on the data count.
    let refused = IRB.job([5.0, 10.0, 5.0, 20.0, 60.0, 80.0], &text.replace("ConfL\\Off;\n", ""), "").unwrap_err();
    assert!(
        refused.contains("line 5: confdata [0,0,0,0], but the arm comes there with confdata [0,1,2,0]"),
        "{refused}"
    );
    let ignored = "[robot_program]\nignore_configuration = true\n";
    IRB.job([5.0, 10.0, 5.0, 20.0, 60.0, 80.0], &text.replace("ConfL\\Off;\n", ""), ignored).unwrap();
}

/// Of the postures at a pose, a cobot takes the one nearest to qnear.
#[test]
fn qnear_chooses_the_posture() {
    let machine = Machine::named("ur10e").unwrap();
    let (tip, home) = (machine.tool_tip, machine.home.clone());
    let at = home.pose.transform(tip) / 1e3;
    let r = UnitQuaternion::from_matrix(&home.pose.rotation).scaled_axis();
    let process = "schema = 1\n[placement]\norigin_mm = [0.0, 0.0, 0.0]\n";
    let process = Process::from_toml(process, "process", Folder::in_memory([]), &machine).unwrap();
    let mut postures: Vec<Vec<f64>> = Vec::new();
    for near in [
        [0.23, -1.71, -1.83, -1.17, 1.57, -1.34],
        [0.23, -3.2, 1.83, -3.0, 1.57, -1.34],
        [0.23, -1.71, -1.83, 1.97, -1.57, 1.8],
    ] {
        let [a, b, c, d, e, f] = near;
        let text = format!(
            "movej(get_inverse_kin(p[{:.9},{:.9},{:.9},{:.9},{:.9},{:.9}], [{a},{b},{c},{d},{e},{f}]), a=1.4, v=1.05)\n",
            at.x, at.y, at.z, r.x, r.y, r.z
        );
        let folder = Folder::in_memory([("part.script".to_owned(), text.into_bytes())]);
        let file = process.program_in_folder(&folder, "part.script").unwrap();
        let job = ProgramJob::new(process.clone(), file, "part.script", &Work::default()).unwrap();
        let [Some(found)] = joints_at_ends(&job)[..] else { panic!("no posture near {near:?}") };
        let off = found.iter().zip(near).map(|(found, near)| (found.to_radians() - near).abs()).fold(0.0, f64::max);
        assert!(off < 0.6, "{found:?} near {near:?}");
        postures.push(found.to_vec());
    }
    postures.dedup_by(|a, b| a.iter().zip(b.iter()).all(|(a, b)| (a - b).abs() < 1.0));
    assert_eq!(postures.len(), 3);
}
