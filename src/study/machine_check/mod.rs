//! What a designer wants to know of a machine before trusting it.

#[cfg(feature = "report")]
pub mod report;

use nalgebra::{Matrix6, Vector3, Vector6};
use serde::Serialize;

use crate::{
    machine::{Coordinate, Drive, Geometry, Machine, Mobility, SpringLaw, ToolAxisSource},
    spatial::{Wrench, rotation_log},
    statics::{
        State, Status, Workspace, chain_stiffnesses, deformation_energies, equilibrium, principal_stiffnesses,
        rigid_wrenches, tool_compliance, unloaded_compliance, unloaded_stiffness,
    },
    study::sources::TO_ROUNDING,
};

/// Findings about a machine.
#[derive(Debug, Clone, Serialize)]
pub struct Findings {
    /// Mobility at home.
    pub mobility: Mobility,
    /// Drive positions at home, mm or rad.
    pub home_drives: Vec<f64>,
    /// Each named point and corner of the workspace: its name, position in mm, and what the inverse kinematics says.
    pub reached: Vec<(String, Vector3<f64>, Result<(), String>)>,
    /// Largest error of forward after inverse kinematics over the reached places: mm, and rad.
    pub round_trip: (f64, f64),
    /// Unloaded stiffness at home; `None` where the machine is rigid in some direction or singular.
    pub stiffness: Option<Matrix6<f64>>,
    /// Unloaded compliance at home; `None` where the platform is free.
    pub compliance: Option<Matrix6<f64>>,
    /// Wrenches at P (N, N·mm) that move nothing, and the names of the chains that are rigid in some direction.
    pub rigid: (Vec<Vector6<f64>>, Vec<String>),
    /// Principal stiffnesses of the tool tip at home, N/mm, ascending.
    pub tool_stiffness: Option<[f64; 3]>,
    /// Share of each elastic element in the compliance of the tool tip at home, all directions together; sums to 1.
    pub compliance_shares: Vec<(String, f64)>,
    /// What looks wrong.
    pub warnings: Vec<String>,
}

/// An element with a larger share in the compliance makes all others irrelevant.
const DOMINANT_SHARE: f64 = 0.99;
/// An element with a smaller share could as well be rigid.
const NEGLIGIBLE_SHARE: f64 = 1e-5;

/// An element with a smaller share does not move the tool tip for its place, whatever its stiffness: a wrist axis through
/// the tip.
const UNMOVED_SHARE: f64 = 1e-15;

/// A tool that leans less from an axis of the platform is along it, degrees.
const SKEW_TOOL_DEG: f64 = 0.1;

/// A tool tip nearer to P has no direction from it, mm.
const SHORTEST_TOOL_MM: f64 = 1e-6;
/// A tool that leans farther from the direction of its tip points back, degrees.
const RIGHT_ANGLE_DEG: f64 = 90.0 + SKEW_TOOL_DEG;

/// A drive this many times softer than all others of its kind may have its stiffness in another unit.
const FAR_SOFTER: f64 = 100.0;

/// Largest difference between the home sought and the home found that is not worth a word: rad, and fraction of the reach.
const HOME_TOLERANCE: f64 = 1e-5;

/// Examines `machine` at home, at its named points and at the corners of its workspace.
pub fn check(machine: &Machine) -> Findings {
    let mut findings = geometric(machine);
    let mut workspace = Workspace::new(machine);
    findings.stiffness = unloaded_stiffness(machine, &machine.home, &mut workspace);
    findings.compliance = unloaded_compliance(machine, &machine.home, &mut workspace);
    let rigid = findings.compliance.filter(|_| findings.stiffness.is_none()).map(|compliance| {
        let home = State::rigid(machine, &machine.home);
        let chains = chain_stiffnesses(machine, &machine.home.drives, &home, &mut workspace);
        let rigid = machine.chains.iter().zip(chains).filter(|(_, stiffness)| stiffness.is_none());
        (rigid_wrenches(&compliance, machine.reach), rigid.map(|(chain, _)| chain.name.clone()).collect())
    });
    findings.rigid = rigid.unwrap_or_default();
    let (tool_stiffness, compliance_shares, status) = compliance(machine, &mut workspace);
    findings.tool_stiffness = tool_stiffness;
    findings.compliance_shares = compliance_shares;
    findings.warnings = warnings(machine, &findings, &status);
    findings
}

/// Examines what does not depend on stiffness.
pub fn check_geometry(geometry: &Geometry) -> Findings {
    let machine = geometry.kinematics();
    let mut findings = geometric(machine);
    findings.warnings = warnings(machine, &findings, &Status::Solved);
    findings
}

/// Findings of the rigid machine, without warnings.
fn geometric(machine: &Machine) -> Findings {
    let (reached, round_trip) = places(machine);
    Findings {
        mobility: machine.mobility(&machine.home),
        home_drives: machine.home.drives.clone(),
        reached,
        round_trip,
        stiffness: None,
        compliance: None,
        rigid: Default::default(),
        tool_stiffness: None,
        compliance_shares: Vec::new(),
        warnings: Vec::new(),
    }
}

/// A place, its position, and what the inverse kinematics says of it.
type Place = (String, Vector3<f64>, Result<(), String>);

fn places(machine: &Machine) -> (Vec<Place>, (f64, f64)) {
    let (min, max) = (machine.workspace.min, machine.workspace.max);
    let mut places: Vec<(String, Vector3<f64>)> = vec![("home".into(), machine.home.pose.translation)];
    places.extend(machine.points.iter().map(|point| (point.name.clone(), point.position)));
    for corner in 0..8 {
        let pick = |i: usize| if corner >> i & 1 == 0 { min[i] } else { max[i] };
        places.push((format!("corner {}", corner + 1), Vector3::new(pick(0), pick(1), pick(2))));
    }
    let mut worst: (f64, f64) = (0.0, 0.0);
    let visit = |(name, position): (String, Vector3<f64>)| {
        let reached = match machine.command(position) {
            Err(unreachable) => Err(unreachable.to_string()),
            Ok(at) => match machine.forward_kinematics(&at.drives) {
                Err(unreachable) => Err(format!("forward kinematics fails: {unreachable}")),
                Ok(back) => {
                    let turn = rotation_log(&(back.pose.rotation * at.pose.rotation.transpose()));
                    worst.0 = worst.0.max((back.pose.translation - at.pose.translation).norm());
                    worst.1 = worst.1.max(turn.norm());
                    Ok(())
                }
            },
        };
        (name, position, reached)
    };
    (places.into_iter().map(visit).collect(), worst)
}

/// The force by which elements' shares in the compliance of the tool are told, N.
const FORCE_N: f64 = 1.0;

/// Principal stiffnesses of the tool tip and each element's share in its compliance, from a force along x, y and z.
fn compliance(machine: &Machine, workspace: &mut Workspace) -> (Option<[f64; 3]>, Vec<(String, f64)>, Status) {
    // What the weight bends is not the load's.
    let machine = &machine.weightless();
    let home = &machine.home;
    let lever = home.pose.rotation * machine.tool_tip;
    let mut shares: Vec<(String, f64)> = Vec::new();
    let mut tip = None;
    let mut status = Status::Solved;
    for axis in 0..3 {
        let mut force = Vector3::zeros();
        force[axis] = FORCE_N;
        let load = Wrench { force, moment: lever.cross(&force) };
        let mut rest = State::rigid(machine, home);
        equilibrium(machine, &home.drives, &Wrench::zero(), &mut rest, workspace, &TO_ROUNDING);
        let mut state = rest.clone();
        let outcome = equilibrium(machine, &home.drives, &load, &mut state, workspace, &TO_ROUNDING);
        status = outcome.status.clone();
        if outcome.status != Status::Solved {
            return (None, Vec::new(), status);
        }
        tip = outcome.compliance.map(|compliance| principal_stiffnesses(&tool_compliance(&compliance, lever)));
        for (index, (name, energy)) in
            deformation_energies(machine, &home.drives, &rest, &state).into_iter().enumerate()
        {
            match shares.get_mut(index) {
                Some((_, sum)) => *sum += energy,
                None => shares.push((name, energy)),
            }
        }
    }
    let total: f64 = shares.iter().map(|(_, energy)| energy).sum();
    for (_, share) in &mut shares {
        *share /= total;
    }
    (tip, shares, status)
}

/// Says where the platform stands if that is not the home pose of the machine file.
fn other_home(machine: &Machine) -> Option<String> {
    let (found, sought) = (machine.home.pose, machine.home_sought);
    let shift = (found.translation - sought.translation).norm();
    let turn = rotation_log(&(found.rotation * sought.rotation.transpose())).norm();
    if shift <= HOME_TOLERANCE * machine.reach && turn <= HOME_TOLERANCE {
        return None;
    }
    // Rounded first: what is nothing has no sign.
    let [x, y, z]: [f64; 3] = found.translation.map(|v| (v * 1e3).round() * 1e-3 + 0.0).into();
    Some(format!(
        "home: the chains hold the platform at ({x:.3}, {y:.3}, {z:.3}) mm, which is {shift:.3} mm and {:.3}° from the \
         home in the machine file",
        turn.to_degrees()
    ))
}

/// Says that the direction of the tool was assumed, where it is none of the platform's axes.
fn skew_tool(machine: &Machine) -> Option<String> {
    let axis = machine.tool_axes.column(2);
    let angle = axis.amax().min(1.0).acos().to_degrees();
    if machine.tool_axis_source != ToolAxisSource::TowardsTip || angle < SKEW_TOOL_DEG {
        return None;
    }
    let mut nearest = [0.0; 3];
    nearest[axis.iamax()] = axis[axis.iamax()].signum();
    Some(format!(
        "tool axis: assumed from P to the tool tip, which is {angle:.1}° from the nearest axis of the platform; milling \
         forces follow it: give its direction, such as platform.tool_axis = {nearest:?}"
    ))
}

/// Asks about a tool whose direction is given against that from P to its tip.
fn tool_towards_the_spindle(machine: &Machine) -> Option<String> {
    let towards_tip = machine.tool_tip.try_normalize(SHORTEST_TOOL_MM)?;
    let angle = machine.tool_axes.column(2).dot(&towards_tip).clamp(-1.0, 1.0).acos().to_degrees();
    (machine.tool_axis_source == ToolAxisSource::Given && angle > RIGHT_ANGLE_DEG).then(|| {
        format!(
            "tool axis: platform.tool_axis is {angle:.0}° from the direction from P to the tool tip: it is the one from the \
             spindle to the tip, and axial forces follow it; is its sign wrong?"
        )
    })
}

/// Names the drives without travel.
fn without_travel(machine: &Machine) -> Option<String> {
    let labels = machine.drive_labels();
    let without: Vec<&str> =
        labels.iter().zip(machine.drives()).filter(|(_, (_, d))| d.travel.is_none()).map(|(l, _)| l.as_str()).collect();
    let noun = if without.len() == 1 { "drive" } else { "drives" };
    let text = || format!("{noun} {}: no travel is given, so no place is too far for them", without.join(", "));
    (!without.is_empty()).then(text)
}

/// Says which of the controlled coordinates the drives cannot control at home, and which translations they could control
/// and are not asked to.
fn wrong_controls(machine: &Machine) -> Vec<String> {
    let named = |coordinates: &[Coordinate]| match coordinates {
        [] => "nothing".to_string(),
        some => some.iter().map(|c| c.name()).collect::<Vec<_>>().join(", "),
    };
    let (count, controls) = (machine.controlled_count(&machine.home), &machine.controls);
    let possible = machine.controllable(&machine.home);
    if count < controls.len() {
        return vec![format!(
            "platform.controls: of {} the drives can control only {count} independently at home; by the mobility there they \
             control {}: wrong platform.controls or a singular home",
            named(controls),
            named(&possible)
        )];
    }
    let is_left = |c: &&Coordinate| matches!(c, Coordinate::Translation(_)) && !controls.contains(c);
    let left: Vec<Coordinate> = possible.iter().filter(is_left).copied().collect();
    if machine.redundancy == 0 || left.is_empty() {
        return Vec::new();
    }
    vec![format!(
        "platform.controls: {} could be controlled, too: it follows from {} as the drives move least, and places where it \
         does not are refused",
        named(&left),
        named(controls)
    )]
}

/// Shares of elements, those of the same name in several chains together: a design mounted three times has its wrong
/// stiffness three times.
fn shares_by_element(findings: &Findings) -> Vec<(String, String, f64)> {
    let mut elements: Vec<(&str, Vec<&str>, f64)> = Vec::new();
    for (name, share) in &findings.compliance_shares {
        // Chain names hold no spaces.
        let (chain, element) = name.split_once(' ').unwrap_or(("", name));
        match elements.iter_mut().find(|(known, ..)| *known == element) {
            Some((_, chains, sum)) => {
                chains.push(chain);
                *sum += share;
            }
            None => elements.push((element, vec![chain], *share)),
        }
    }
    let named = |(element, chains, share): (&str, Vec<&str>, f64)| {
        (format!("{} {element}", chains.join(", ")), element.to_string(), share)
    };
    elements.into_iter().map(named).collect()
}

/// Whether most of the compliance in `element` is worth a question. It is not where nothing else moves the tool; and among
/// drives alone, which differ by nature, only in one that is far softer than the others of its kind.
fn may_be_too_soft(machine: &Machine, findings: &Findings, element: &str) -> bool {
    let others = shares_by_element(findings).into_iter().filter(|(_, other, _)| other != element);
    if others.map(|(.., share)| share).fold(0.0, f64::max) < UNMOVED_SHARE {
        return false;
    }
    let is_drive = |law: &SpringLaw| matches!(law, SpringLaw::Drive(_));
    let has_links = machine.chains.iter().flat_map(|chain| &chain.springs).any(|spring| !is_drive(&spring.law));
    let has_sprung_joints = machine.chains.iter().flat_map(|chain| &chain.passive).any(|joint| joint.stiffness > 0.0);
    if has_links || has_sprung_joints {
        return true;
    }
    let drives = |is_it: bool| machine.drives().map(|(_, drive)| drive).filter(move |d| (d.name == element) == is_it);
    let softest = |own: &Drive| {
        let alike = drives(false).filter(|other| other.motion == own.motion);
        alike.map(|other| other.stiffness).reduce(f64::min)
    };
    drives(true).any(|own| softest(own).is_some_and(|other| own.stiffness < other / FAR_SOFTER))
}

fn warnings(machine: &Machine, findings: &Findings, status: &Status) -> Vec<String> {
    let mut warnings = Vec::new();
    if *status != Status::Solved {
        warnings.push(format!("home: a load of 1 N has no stable equilibrium ({})", status.reason(machine)));
    }
    warnings.extend(other_home(machine));
    warnings.extend(skew_tool(machine));
    warnings.extend(tool_towards_the_spindle(machine));
    let mobility = &findings.mobility;
    if mobility.uncontrolled > 0 {
        warnings.push(format!(
            "home: motions left with all drives locked: {} (expected: 0): a singular home, a missing drive or an idle joint",
            mobility.uncontrolled
        ));
    }
    warnings.extend(wrong_controls(machine));
    warnings.extend(without_travel(machine));
    for (name, element, share) in shares_by_element(findings) {
        if share > DOMINANT_SHARE && may_be_too_soft(machine, findings, &element) {
            warnings.push(format!(
                "{name}: makes {:.3} % of the tool's compliance; is its stiffness 1000 times too small (unit)?",
                share * 100.0
            ));
        }
    }
    for (name, share) in &findings.compliance_shares {
        if (UNMOVED_SHARE..NEGLIGIBLE_SHARE).contains(share) {
            warnings.push(format!(
                "{name}: makes {share:.1e} of the tool's compliance; is its stiffness 1000 times too large (unit)?"
            ));
        }
    }
    for (name, position, reached) in &findings.reached {
        if let Err(reason) = reached {
            let [x, y, z]: [f64; 3] = (*position).into();
            warnings.push(format!("{name} ({x}, {y}, {z}) mm cannot be reached: {reason}"));
        }
    }
    warnings
}
