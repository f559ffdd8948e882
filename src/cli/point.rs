//! `kinetostat point`: solves one location and explains it.

use clap::{ArgGroup, Args};
use kinetostat::{
    compensation::Target,
    input::{
        error::{Error, Result},
        names::listed,
    },
    inspect::point::{
        NominalCommand, PointLoad, PointQuestion,
        report::{point_json, point_text, unreachable_json},
        solve,
    },
    machine::{Branch, ChainError, Machine, Motion},
    process::{ForceLaw, MillingForce, file::Cutter},
    simulation::Machines,
    spatial::{Pose, Wrench},
    statics::Status,
};
use nalgebra::Vector3;
use serde_json::{Value, json};

use super::{
    Ending, any_numbers, choice, number, numbers,
    on_machine::{self, Setting},
    print, print_json, say,
};

/// Solve one location: how far the tool moves there and which drive commands compensate that.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("place").args(["position", "at", "pose", "joints"]).required(true)), after_help = "\
The milling force lives in the frame of the tool: z from the spindle to the tool tip (tool_axis in the machine file), x the
x axis of the platform across it, φ from x towards y. FR > 0 pushes the tool along φ, FT > 0 along φ + 90°, FZ < 0 back into
the spindle. Picture: docs/forces.svg.

Examples:
  kinetostat point --machine orthoglide --position 126.35,126.35,126.35 --phi 130 --chain-errors 1,-1,1
  kinetostat point --machine orthoglide --at Q1 --phi 130 --law paper_eq17
  kinetostat point --machine orthoglide --at Q1 --phi 130 --cutter D=10,z=4,ae=5,ap=8,fz=0.08,cut=down,n=8000 --material 'Al 6082-T6'
  kinetostat point --machine orthoglide --at Q0 --wrench 215,-10,-25,1000,21500,0 --json
  kinetostat point --machine robot.toml --pose 1600,200,900,0,180,30 --wrench 0,0,-500,0,0,0 --full-pose
  kinetostat point --machine kr270 --pose 1600,200,900,0,180,30 --branch front-up-flip
  kinetostat point --machine robot.toml --joints 0,-20,110,0,40,0
  kinetostat point --machine orthoglide --at Q1 --phi 130 --set leg.foot.height=22 --set x.turn=0.5
  kinetostat point --machine cell.toml --at Q0 --wrench 300,0,0,0,0,0 --lock rail=500 --lock table=30")]
pub struct PointArguments {
    /// Built-in machine or machine file
    #[arg(long, short)]
    machine: String,
    /// Commanded position of the platform point P: x,y,z in mm
    #[arg(long, value_parser = numbers::<3>, allow_hyphen_values = true)]
    position: Option<[f64; 3]>,
    /// Named point of the machine instead of a position
    #[arg(long)]
    at: Option<String>,
    /// Commanded pose of P instead: x,y,z in mm and roll,pitch,yaw in degrees about the fixed axes of O
    #[arg(long, value_parser = numbers::<6>, allow_hyphen_values = true, value_name = "X,Y,Z,ROLL,PITCH,YAW")]
    pose: Option<[f64; 6]>,
    /// Positions of the drives instead, in the order of the machine, as a pendant shows them: mm or degrees
    #[arg(long, value_parser = any_numbers, allow_hyphen_values = true, value_name = "J1,J2,…")]
    joints: Option<std::vec::Vec<f64>>,
    /// Branch on which an arm with a spherical wrist is to stand [default: the one of home, and others where it does not reach]
    #[arg(long, value_parser = choice::branch(), conflicts_with = "joints")]
    branch: Option<Branch>,
    /// Tool angle φ of the milling force in degrees
    #[arg(long, value_parser = number, allow_hyphen_values = true, conflicts_with = "wrench")]
    phi: Option<f64>,
    /// Milling force on the tool: radial,tangential,axial in N
    #[arg(long, value_parser = numbers::<3>, allow_hyphen_values = true, default_value = "215,-10,-25", value_name = "FR,FT,FZ", requires = "phi", conflicts_with = "wrench")]
    force: [f64; 3],
    /// How the milling force turns with φ, eq. (17): as a rotation, or as the paper prints it
    #[arg(long, value_parser = choice::law(), default_value = "rotated", requires = "phi", conflicts_with = "wrench")]
    law: ForceLaw,
    /// Cutter and cut instead of the force: D, ae, ap, fz in mm, z teeth, cut=up or down, n in rev/min; kr and ka of Kienzle materials
    #[arg(long, value_name = "D=10,z=4,ae=5,ap=8,fz=0.08,cut=down,n=8000", requires_all = ["phi", "material"], conflicts_with_all = ["wrench", "force", "law"])]
    cutter: Option<String>,
    /// Material of the cut of --cutter, as in end_milling of a process file: Al 6082-T6
    #[arg(long, requires = "cutter")]
    material: Option<String>,
    /// Load at P in base axes instead of the milling force: fx,fy,fz,mx,my,mz in N and N·mm
    #[arg(long, value_parser = numbers::<6>, allow_hyphen_values = true)]
    wrench: Option<[f64; 6]>,
    /// Error of each chain: turn about its drive's axis in degrees
    #[arg(long, alias = "assembly", value_parser = any_numbers, allow_hyphen_values = true, value_name = "DEG,DEG,…")]
    chain_errors: Option<std::vec::Vec<f64>>,
    /// Another number of the machine, by its name (kinetostat machines NAME --parameters), or an error of a chain; repeatable
    #[arg(long, value_parser = on_machine::parse_setting, value_name = "NAME=VALUE")]
    set: Vec<Setting>,
    /// Lock a drive at a position, mm or degrees as a pendant shows it: one that the task does not need (a rail), or one under the
    /// workpiece; repeatable
    #[arg(long, value_parser = on_machine::parse_setting, value_name = "DRIVE=VALUE")]
    lock: Vec<Setting>,
    /// Compensate the platform point P instead of the tool tip
    #[arg(long)]
    platform: bool,
    /// Compensate the orientation as well as the tool tip
    #[arg(long, conflicts_with = "platform")]
    full_pose: bool,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// Runs `kinetostat point`: solves one location and prints the results, as text or as JSON.
pub fn point(arguments: &PointArguments) -> Result<Ending> {
    let changed = on_machine::geometry(&arguments.machine, &arguments.set, arguments.branch)?.machine()?;
    let set_errors = changed.parameter_errors();
    if arguments.chain_errors.is_some() && !set_errors.is_empty() {
        return Err(Error::argument("--set", "errors of chains are given by --chain-errors or by --set, not by both"));
    }
    let machine = if set_errors.is_empty() { changed } else { changed.nominal()? };
    let machine = on_machine::lock_drives(&machine, &arguments.lock)?;
    let place = commanded_place(arguments, &machine)?;
    let chain_errors_deg = checked_chain_errors(arguments, &machine)?;
    let errors = if set_errors.is_empty() { machine.assembly_errors(&chain_errors_deg) } else { set_errors };
    if arguments.platform && machine.tool_compliance.is_some() {
        let problem =
            "what is between P and the tool tip bends, so that P is not where the tool is: expected the tool tip";
        return Err(Error::argument("--platform", problem));
    }
    let cutter = match (&arguments.cutter, &arguments.material) {
        (Some(cutter), Some(material)) => Some(Cutter::parse(cutter, material)?),
        _ => None,
    };
    let question = PointQuestion {
        machines: Machines::new(&machine, &errors)?,
        errors,
        place,
        load: requested_load(arguments, cutter.as_ref()),
        target: match (arguments.platform, arguments.full_pose) {
            (true, _) => Target::PlatformPoint,
            (_, true) => Target::FullPose,
            _ => Target::ToolTip,
        },
        machine,
    };
    let answer = match solve(&question) {
        Ok(answer) => answer,
        Err(unreachable) => {
            let text = format!("unreachable: {unreachable}");
            if arguments.json {
                let json = unreachable_json(&question, &chain_errors_deg, &unreachable);
                print_json(&with_cutter(with_settings(json, arguments), cutter.as_ref()))?;
                say(&text);
            } else {
                print(&(text + "\n"))?;
            }
            return Ok(Ending::SomeUnsolved);
        }
    };
    if arguments.json {
        print_json(&with_cutter(with_settings(point_json(&answer, &chain_errors_deg), arguments), cutter.as_ref()))?;
    } else {
        for (name, value) in &arguments.set {
            print(&format!("with {name} = {value}\n"))?;
        }
        if let Some(cutter) = &cutter {
            print(&cutter_text(cutter))?;
        }
        print(&point_text(&answer))?;
    }
    Ok(Ending::of(answer.loaded.status == Status::Solved && answer.compensated.is_ok()))
}

/// Returns `json` with the parameters that `--set` changed.
fn with_settings(mut json: Value, arguments: &PointArguments) -> Value {
    if !arguments.set.is_empty() {
        json["set"] = arguments.set.iter().cloned().collect();
    }
    json
}

/// Returns `json` with force, torque and power of the `cutter`.
fn with_cutter(mut json: Value, cutter: Option<&Cutter>) -> Value {
    if let Some(cutter) = cutter {
        let cut = cutter.force();
        json["cut"] = json!({
            "force_along_feed_N": cut.force_N.x,
            "force_across_feed_N": cut.force_N.y,
            "force_to_spindle_N": cut.force_N.z,
            "force_N": cut.force_N.norm(),
            "torque_Nm": cut.torque_Nmm / 1e3,
            "power_kW": cutter.power_watts().map(|power| power / 1e3),
            "feed_mm_per_min": cutter.feed_mm_per_min(),
        });
    }
    json
}

/// Returns the lines that say force, torque and power of `cutter`.
fn cutter_text(cutter: &Cutter) -> String {
    let cut = cutter.force();
    let [along, across, to_spindle] = <[f64; 3]>::from(cut.force_N);
    let mut text = format!(
        "cut: {:.1} N on the tool, mean over a turn: {along:.1} N along the feed, {across:.1} N across it (along φ), {to_spindle:.1} N to \
         the spindle; torque {:.3} N·m",
        cut.force_N.norm(),
        cut.torque_Nmm.abs() / 1e3
    );
    if let (Some(power), Some(feed)) = (cutter.power_watts(), cutter.feed_mm_per_min()) {
        text += &format!(", power {:.3} kW, feed {feed:.0} mm/min", power / 1e3);
    }
    text + "\n"
}

/// Returns the command that the arguments give: a pose, drive positions, a position or a named point; an error if it does not fit the
/// machine.
fn commanded_place(arguments: &PointArguments, machine: &Machine) -> Result<NominalCommand> {
    if let Some([x, y, z, roll, pitch, yaw]) = arguments.pose {
        let rotation = Pose::from_roll_pitch_yaw(Vector3::new(roll, pitch, yaw).map(f64::to_radians));
        return Ok(NominalCommand::Pose(Pose { translation: Vector3::new(x, y, z), ..rotation }));
    }
    if let Some(joints) = &arguments.joints {
        let count = machine.drive_count();
        if joints.len() != count {
            let labels = machine.drive_labels().join(", ");
            let problem = format!("expected {count} positions, of the drives {labels}, got {}", joints.len());
            return Err(Error::argument("--joints", problem));
        }
        let drives = joints.iter().zip(machine.drives()).map(|(value, (_, drive))| drive.motion.from_shown(*value));
        let drives: Vec<f64> = drives.collect();
        if let Some(&(locked, at)) = machine.locked.iter().find(|&&(index, value)| drives[index] != value) {
            let motion = machine.drives().nth(locked).map_or(Motion::Prismatic, |(_, drive)| drive.motion);
            let problem = format!(
                "drive {} is locked at {}, got {}",
                machine.drive_labels()[locked],
                motion.position_text(motion.to_shown(at)),
                motion.position_text(joints[locked])
            );
            return Err(Error::argument("--joints", problem));
        }
        return Ok(NominalCommand::Drives(drives));
    }
    if let Some(position) = arguments.position {
        return Ok(NominalCommand::Position(position.into()));
    }
    let name = arguments.at.as_deref().unwrap_or_default();
    let known = listed(machine.points.iter().map(|point| &point.name));
    let problem = format!("machine {} has no point \"{name}\"; there are: {known}", machine.name);
    let point = machine.point(name).ok_or_else(|| Error::argument("--at", problem))?;
    Ok(NominalCommand::Position(point.position))
}

/// Returns the chain errors of `--chain-errors`, degrees; zeros if not given.
fn checked_chain_errors(arguments: &PointArguments, machine: &Machine) -> Result<Vec<f64>> {
    let (name, count) = (&machine.name, machine.chains.len());
    let Some(angles) = &arguments.chain_errors else { return Ok(vec![0.0; count]) };
    let problem = match angles.iter().find_map(|angle| ChainError::rotation_problem(angle.to_radians())) {
        _ if angles.len() != count => format!("expected {count} angles, one per chain of {name}, got {}", angles.len()),
        Some(problem) => problem,
        None => return Ok(angles.clone()),
    };
    Err(Error::argument("--chain-errors", problem))
}

/// Returns the load of the arguments: a wrench at P, the force of the `cutter`, a milling force on the tool, or none.
fn requested_load(arguments: &PointArguments, cutter: Option<&Cutter>) -> PointLoad {
    if let (Some(cut), Some(phi)) = (cutter.map(Cutter::force), arguments.phi) {
        return PointLoad::Cut(cut.into(), phi.to_radians(), cut.torque_Nmm);
    }
    let ([radial, tangential, axial], law) = (arguments.force, arguments.law);
    match (arguments.wrench, arguments.phi) {
        (Some(wrench), _) => PointLoad::Wrench(Wrench::new(wrench)),
        (None, Some(phi)) => PointLoad::Milling(MillingForce { radial, tangential, axial, law }, phi.to_radians()),
        (None, None) => PointLoad::Wrench(Wrench::zero()),
    }
}
