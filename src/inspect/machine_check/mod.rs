//! Checks a machine as a whole, as a designer wants to know it before trusting it.

mod bodies;
#[cfg(feature = "report")]
pub mod report;
mod survey;
mod units;

use nalgebra::{Matrix6, Vector3, Vector6};
use serde::Serialize;

pub use self::bodies::{BodiesFound, NearestPair};
pub use self::survey::{Droop, Payload, Softest, Span, Survey};
use self::survey::{compliance, spans, survey};

use crate::{
    input::error::Result,
    machine::{
        Branch, Chain, Clearance, Coordinate, Drive, Geometry, Machine, Mobility, Posture, SpringLaw, ToolAxisSource,
    },
    spatial::rotation_log,
    statics::{Scratch, State, Status, chain_stiffnesses, rigid_wrenches, unloaded_compliance, unloaded_stiffness},
};

/// Findings of a machine check.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Findings {
    /// Mobility at home.
    pub mobility: Mobility,
    /// Drive positions at home, mm or rad.
    pub home_drives: Vec<f64>,
    /// Each named point and workspace corner: name, position of P (O, mm), and whether inverse kinematics reaches it.
    pub reached: Vec<(String, Vector3<f64>, std::result::Result<(), String>)>,
    /// How far P can go from home along x, y and z, mm, oriented as at home; `None` along an axis that the drives do not control.
    pub spans: [Option<Span>; 3],
    /// Largest error of forward after inverse kinematics over the reached places: mm, and rad.
    pub round_trip: (f64, f64),
    /// Distance to singularity at home, see [`Machine::conditioning`].
    pub conditioning: f64,
    /// Distance of an arm at home from the singularities between its branches.
    pub clearance: Option<Clearance>,
    /// Posture of an arm in the home pose on each branch; `None` where it does not reach. Empty for other machines.
    pub branches: Vec<(Branch, Option<Posture>)>,
    /// Unloaded stiffness at home; `None` where the machine is rigid in some direction or singular.
    pub stiffness: Option<Matrix6<f64>>,
    /// Unloaded compliance at home; `None` where the platform is free.
    pub compliance: Option<Matrix6<f64>>,
    /// Wrenches at P (N, N·mm) that cause no motion, and the names of the chains that are rigid in some direction.
    pub rigid: (Vec<Vector6<f64>>, Vec<String>),
    /// Principal stiffnesses of the tool tip at home, N/mm, ascending.
    pub tool_stiffness: Option<[f64; 3]>,
    /// Share of each elastic element in the compliance of the tool tip at home, all directions together; sums to 1.
    pub compliance_shares: Vec<(String, f64)>,
    /// Its bodies; `None` without any.
    pub bodies: Option<BodiesFound>,
    /// Findings over the workspace; `None` where only the geometry is known.
    pub survey: Option<Survey>,
    /// Warnings, a sentence each.
    pub warnings: Vec<String>,
}

/// Share in the compliance above which an element makes all others irrelevant.
const DOMINANT_SHARE: f64 = 0.99;
/// Share in the compliance below which an element could as well be rigid.
const NEGLIGIBLE_SHARE: f64 = 1e-5;

/// Share of the compliance below which an element does not move the tool tip by its position, whatever its stiffness: a wrist axis through the tip.
const UNMOVED_SHARE: f64 = 1e-7;

/// Angle of the tool from an axis of the platform below which it is along that axis, degrees.
const SKEW_TOOL_DEG: f64 = 0.1;

/// Distance of the tool tip from P below which it has no direction, mm.
const SHORTEST_TOOL_MM: f64 = 1e-6;
/// Angle of the tool from the direction of its tip above which it points back, degrees.
const RIGHT_ANGLE_DEG: f64 = 90.0 + SKEW_TOOL_DEG;

/// How many times softer than all others of its kind a drive must be for its unit to be questioned.
const FAR_SOFTER: f64 = 100.0;

/// Largest difference between home as given and as found that causes no warning: rad, and fraction of the characteristic length.
const HOME_TOLERANCE: f64 = 1e-5;

/// Returns the machine's characteristic length or the diagonal of its workspace, whichever is larger, mm.
fn machine_size(machine: &Machine) -> f64 {
    machine.characteristic_length.max((machine.workspace.max - machine.workspace.min).norm())
}

/// Checks `machine` at home, at its named points, and over its workspace; returns all findings with warnings.
///
/// # Errors
/// The mesh of a body cannot be read, is open or inside out.
pub fn check(machine: &Machine) -> Result<Findings> {
    let mut findings = kinematic_findings(machine)?;
    let mut scratch = Scratch::new(machine);
    findings.stiffness = unloaded_stiffness(machine, &machine.home, &mut scratch);
    findings.compliance = unloaded_compliance(machine, &machine.home, &mut scratch);
    let rigid = findings.compliance.filter(|_| findings.stiffness.is_none()).map(|compliance| {
        let home = State::rigid(machine, &machine.home);
        let chains = chain_stiffnesses(machine, &machine.home.drives, &home, &mut scratch);
        let rigid = machine.chains.iter().zip(chains).filter(|(_, stiffness)| stiffness.is_none());
        (
            rigid_wrenches(&compliance, machine.characteristic_length),
            rigid.map(|(chain, _)| chain.name.clone()).collect(),
        )
    });
    findings.rigid = rigid.unwrap_or_default();
    let mut status = Status::Solved;
    // What the weight bends is not the load's.
    match compliance(&machine.weightless(), &machine.home, &mut scratch) {
        Ok(at_home) => (findings.tool_stiffness, findings.compliance_shares) = (at_home.stiffness, at_home.shares),
        Err(failed) => status = failed,
    }
    findings.survey = Some(survey(machine, &mut scratch));
    findings.warnings = warnings(machine, &findings, &status);
    let parameters = machine.parameters();
    findings.warnings.extend(units::geometry_questions(machine, &findings, &parameters));
    findings.warnings.extend(units::unit_questions(machine, &findings, &parameters));
    Ok(findings)
}

/// Checks what does not depend on stiffness: mobility, kinematics, spans, branches and bodies.
///
/// # Errors
/// As [`check`].
pub fn check_geometry(geometry: &Geometry) -> Result<Findings> {
    let machine = geometry.kinematics();
    let mut findings = kinematic_findings(machine)?;
    findings.warnings = warnings(machine, &findings, &Status::Solved);
    findings.warnings.extend(units::geometry_questions(machine, &findings, &machine.parameters()));
    Ok(findings)
}

/// Returns the findings that need no stiffness, without warnings.
fn kinematic_findings(machine: &Machine) -> Result<Findings> {
    let (reached, round_trip) = check_places(machine);
    Ok(Findings {
        bodies: bodies::bodies_found(machine, &reached)?,
        mobility: machine.mobility(&machine.home),
        home_drives: machine.home.drives.clone(),
        reached,
        spans: spans(machine),
        round_trip,
        conditioning: machine.conditioning(&machine.home),
        clearance: machine.clearance(&machine.home),
        branches: home_branches(machine),
        ..Findings::default()
    })
}

/// Returns the posture in the home pose on each branch of an arm, `None` where it does not reach; empty for other machines.
fn home_branches(machine: &Machine) -> Vec<(Branch, Option<Posture>)> {
    if machine.branch_of(&machine.home).is_none() {
        return Vec::new();
    }
    let postures = machine.postures_at(&machine.home.pose);
    let on_branch = |branch: Branch| (branch, postures.iter().find(|posture| posture.branch == branch).cloned());
    Branch::ALL.into_iter().map(on_branch).collect()
}

/// Name and position (P in O, mm) of a place, and whether inverse kinematics reaches it.
type Place = (String, Vector3<f64>, std::result::Result<(), String>);

/// Returns whether home, named points and workspace corners are reached, and the largest round-trip error of the kinematics, mm and rad.
fn check_places(machine: &Machine) -> (Vec<Place>, (f64, f64)) {
    let (min, max) = (machine.workspace.min, machine.workspace.max);
    let mut places: Vec<(String, Vector3<f64>)> = vec![("home".into(), machine.home.pose.translation)];
    places.extend(machine.points.iter().map(|point| (point.name.clone(), point.position)));
    for corner in 0..8 {
        let pick = |i: usize| if corner >> i & 1 == 0 { min[i] } else { max[i] };
        places.push((format!("corner {}", corner + 1), Vector3::new(pick(0), pick(1), pick(2))));
    }
    let mut worst: (f64, f64) = (0.0, 0.0);
    let visit = |(name, position): (String, Vector3<f64>)| {
        let reached = match machine.inverse_kinematics_at(position) {
            Err(unreachable) => Err(unreachable.to_string()),
            Ok(at) => match machine.forward_kinematics(&at.drives) {
                Err(unreachable) => Err(format!(
                    "inverse kinematics finds drive positions, forward kinematics from them fails: {unreachable}"
                )),
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

/// Returns a warning if the chains do not hold the platform in the home pose of the machine file, else `None`.
fn home_warning(machine: &Machine) -> Option<String> {
    let (found, given) = (machine.home.pose, machine.home_target);
    let shift = (found.translation - given.translation).norm();
    let turn = rotation_log(&(found.rotation * given.rotation.transpose())).norm();
    if shift <= HOME_TOLERANCE * machine.characteristic_length && turn <= HOME_TOLERANCE {
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

/// Returns a warning if the tool's direction was assumed and is none of the platform's axes, else `None`.
fn skew_tool_warning(machine: &Machine) -> Option<String> {
    let axis = machine.tool_axes.column(2);
    let angle = libm::acos(axis.amax().min(1.0)).to_degrees();
    if machine.tool_axis_source != ToolAxisSource::TowardsTip || angle < SKEW_TOOL_DEG {
        return None;
    }
    let mut nearest = [0.0; 3];
    nearest[axis.iamax()] = axis[axis.iamax()].signum();
    Some(format!(
        "tool axis: assumed from P to the tool tip, which is {angle:.1}° from the nearest axis of the platform; milling \
         forces follow this axis: give its direction, such as platform.tool_axis = {nearest:?}"
    ))
}

/// Returns a warning if the given tool direction points against that from P to the tip, else `None`.
fn tool_sign_warning(machine: &Machine) -> Option<String> {
    let towards_tip = machine.tool_tip.try_normalize(SHORTEST_TOOL_MM)?;
    let angle = libm::acos(machine.tool_axes.column(2).dot(&towards_tip).clamp(-1.0, 1.0)).to_degrees();
    (machine.tool_axis_source == ToolAxisSource::Given && angle > RIGHT_ANGLE_DEG).then(|| {
        format!(
            "tool axis: platform.tool_axis is {angle:.0}° off the direction from P to the tool tip; is its sign wrong? The axis points from \
             the spindle to the tip, and axial forces follow the axis"
        )
    })
}

/// Returns a warning that names the drives without travel; `None` if all have one.
fn travel_warning(machine: &Machine) -> Option<String> {
    let labels = machine.drive_labels();
    let without: Vec<&str> =
        labels.iter().zip(machine.drives()).filter(|(_, (_, d))| d.travel.is_none()).map(|(l, _)| l.as_str()).collect();
    let noun = if without.len() == 1 { "drive" } else { "drives" };
    let text = || format!("{noun} {}: no travel is given, so no place is out of travel", without.join(", "));
    (!without.is_empty()).then(text)
}

/// Returns warnings about controlled coordinates that the drives cannot control at home, and about translations that they could control, too.
fn control_warnings(machine: &Machine) -> Vec<String> {
    let listed = |coordinates: &[Coordinate]| match coordinates {
        [] => "nothing".to_string(),
        some => some.iter().map(|c| c.name()).collect::<Vec<_>>().join(", "),
    };
    let (count, controls) = (machine.controlled_count(&machine.home), &machine.controls);
    let possible = machine.controllable_axes(&machine.home);
    if count < controls.len() {
        return vec![format!(
            "platform.controls: of {} the drives can control only {count} independently at home; by the mobility there they \
             control {}: wrong platform.controls or a singular home",
            listed(controls),
            listed(&possible)
        )];
    }
    let is_free = |c: &&Coordinate| matches!(c, Coordinate::Translation(_)) && !controls.contains(c);
    let free: Vec<Coordinate> = possible.iter().filter(is_free).copied().collect();
    if machine.redundancy == 0 || free.is_empty() {
        return Vec::new();
    }
    vec![format!(
        "platform.controls: {} could be controlled, too: without control the least motion of the drives gives that \
         coordinate from {}, and other values are refused",
        listed(&free),
        listed(controls)
    )]
}

/// Returns chains and name, name, and share summed over chains of each element: a design mounted thrice has its wrong stiffness thrice.
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

/// Returns whether most of the compliance in `element` suggests a wrong stiffness. It does not where nothing else moves the tool; and among
/// drives alone, which differ by nature, only in one far softer than the others of its kind.
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
    let softest = |drive: &Drive| {
        let alike = drives(false).filter(|other| other.motion == drive.motion);
        alike.map(|other| other.stiffness).reduce(f64::min)
    };
    drives(true).any(|drive| softest(drive).is_some_and(|other| drive.stiffness < other / FAR_SOFTER))
}

/// Returns the names, as in findings, of springs between two points; such a spring has a tiny share where it is soft beside what it spans.
fn spring_names(machine: &Machine) -> Vec<String> {
    let names_of = |chain: &Chain| -> Vec<String> {
        let springs = chain.route.with_loops().into_iter().flat_map(|route| &route.point_springs);
        springs.map(|spring| format!("{} {}", chain.name, spring.name)).collect()
    };
    machine.chains.iter().flat_map(names_of).collect()
}

/// Returns all warnings; `status` is that of the equilibrium at home under a load of 1 N.
fn warnings(machine: &Machine, findings: &Findings, status: &Status) -> Vec<String> {
    let mut warnings = Vec::new();
    if *status != Status::Solved {
        warnings.push(format!(
            "home: under a load of 1 N the machine is in no stable equilibrium ({})",
            status.reason(machine)
        ));
    }
    warnings.extend(home_warning(machine));
    warnings.extend(skew_tool_warning(machine));
    warnings.extend(tool_sign_warning(machine));
    let mobility = &findings.mobility;
    if mobility.uncontrolled > 0 {
        warnings.push(format!(
            "home: motions left with all drives locked: {} (expected: 0): a singular home, a missing drive or an idle joint",
            mobility.uncontrolled
        ));
    }
    warnings.extend(control_warnings(machine));
    warnings.extend(findings.bodies.as_ref().and_then(BodiesFound::warning));
    warnings.extend(travel_warning(machine));
    for (name, element, share) in shares_by_element(findings) {
        if share > DOMINANT_SHARE && may_be_too_soft(machine, findings, &element) {
            warnings.push(format!(
                "{name}: makes {:.3} % of the tool's compliance; is its stiffness 1000 times too small (unit)?",
                share * 100.0
            ));
        }
    }
    let springs = spring_names(machine);
    for (name, share) in &findings.compliance_shares {
        if (UNMOVED_SHARE..NEGLIGIBLE_SHARE).contains(share) && !springs.contains(name) {
            warnings.push(format!(
                "{name}: makes {share:.1e} of the tool's compliance; is its stiffness 1000 times too large (unit)?"
            ));
        }
    }
    if let Some(survey) = &findings.survey {
        if let Some((count, reason)) = survey.droop.as_ref().and_then(|droop| droop.without.as_ref()) {
            let places = survey.reached - survey.left_out;
            warnings.push(format!("weight: no stable equilibrium at {count} of {places} places ({reason})"));
        }
        if let Some(payload) = survey.payload.as_ref().filter(|payload| payload.kilograms == 0.0) {
            let [x, y, z]: [f64; 3] = payload.position_mm.into();
            warnings.push(format!(
                "{}: cannot hold the machine's own weight at ({x}, {y}, {z}) mm within its limit; is the limit 1000 times too small (unit)?",
                payload.drive
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
