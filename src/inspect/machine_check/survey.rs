//! Surveys the machine over its workspace: stiffness and softest place of the tool tip, displacement by weight, payload, and span from home.

use nalgebra::Vector3;
use serde::Serialize;

use super::machine_size;
use crate::{
    machine::{Configuration, Machine, Motion},
    simulation::sources::TO_ROUNDING,
    spatial::{Grid, Wrench},
    statics::{
        Outcome, Scratch, State, Status, deformation_energies, drive_forces, equilibrium, principal_stiffnesses,
        tool_compliance, unloaded_compliance,
    },
};

/// Points along each side of the workspace.
const POINTS: usize = 5;
/// Most Newton iterations for droop over all places, and as many for payload; those of the built-in machines take at most 700.
const MAX_ITERATIONS: usize = 8_000;

/// Findings on a grid over the workspace.
#[derive(Debug, Clone, Serialize)]
pub struct Survey {
    /// Points of the grid along x, y and z.
    pub counts: [usize; 3],
    /// Number of grid points that are reached.
    pub reached: usize,
    /// Place with the softest tool tip; `None` where the tip is free or rigid everywhere.
    pub softest: Option<Softest>,
    /// Displacement by weight; `None` without weight.
    pub droop: Option<Droop>,
    /// Largest mass the tool can carry; `None` without gravity or without a limit of a drive's force.
    pub payload: Option<Payload>,
    /// Number of reached grid points where droop or payload was not sought, as the places before took too many iterations.
    pub left_out: usize,
}

/// The place with the softest tool tip.
#[derive(Debug, Clone, Serialize)]
pub struct Softest {
    /// Position of P, mm.
    pub position_mm: Vector3<f64>,
    /// Principal stiffnesses of the tool tip against the workpiece, N/mm, ascending.
    pub tool_stiffness_n_per_mm: [f64; 3],
    /// Share of each elastic element in the compliance of the tool tip, as at home.
    pub compliance_shares: Vec<(String, f64)>,
}

/// Displacement of the tool tip by weight from the rigid machine, seen from the workpiece where that is carried.
#[derive(Debug, Clone, Serialize)]
pub struct Droop {
    /// Smallest and largest distance, mm.
    pub range_mm: [f64; 2],
    /// Position of P with the largest distance, mm.
    pub position_mm: Vector3<f64>,
    /// Number of places where the weight has no stable equilibrium, and the reason at the first.
    pub without: Option<(usize, String)>,
}

/// Surveys a grid of places over the workspace, oriented as at home.
pub(super) fn survey(machine: &Machine, scratch: &mut Scratch) -> Survey {
    let (min, max) = (machine.workspace.min, machine.workspace.max);
    let grid = Grid::new(min, max, [0, 1, 2].map(|axis| if max[axis] > min[axis] { POINTS } else { 1 }));
    let places: Vec<Configuration> =
        (0..grid.len()).filter_map(|index| machine.inverse_kinematics_at(grid.position(index)).ok()).collect();
    let (mut of_droop, mut of_payload) = (Effort::new(MAX_ITERATIONS), Effort::new(MAX_ITERATIONS));
    Survey {
        counts: grid.counts(),
        reached: places.len(),
        softest: softest(&machine.weightless(), &places, scratch),
        droop: droop(machine, &places, scratch, &mut of_droop),
        payload: payload(machine, &places, scratch, &mut of_payload),
        left_out: of_droop.left_out.max(of_payload.left_out),
    }
}

/// What equilibria at many places may still cost: in iterations, not in seconds, so that a machine always has the same survey.
struct Effort {
    /// Newton iterations that are left.
    iterations: usize,
    /// Places that are not looked at as none are left.
    left_out: usize,
}

impl Effort {
    /// Returns one of so many Newton iterations.
    fn new(iterations: usize) -> Self {
        Self { iterations, left_out: 0 }
    }

    /// Takes off what `outcome` cost.
    fn spend(&mut self, outcome: &Outcome) {
        self.iterations = self.iterations.saturating_sub(outcome.iterations);
    }

    /// Whether another place may be looked at; otherwise counts it.
    fn is_left(&mut self) -> bool {
        self.left_out += usize::from(self.iterations == 0);
        self.iterations > 0
    }
}

/// Returns the place among `places` where the tool tip of the weightless `machine` is softest; `None` where it is free or rigid everywhere.
fn softest(machine: &Machine, places: &[Configuration], scratch: &mut Scratch) -> Option<Softest> {
    let mut softest: Option<(f64, &Configuration)> = None;
    let mut carrier = machine.carrier.clone();
    for at in places {
        let lever = at.pose.rotation * machine.tool_tip;
        let Some(compliance) = unloaded_compliance(machine, at, scratch) else { continue };
        let mut tip = tool_compliance(&compliance, lever);
        if let Some(carrier) = &mut carrier {
            let touched = carrier.set_touch_point(at.pose.translation + lever);
            let carried = unloaded_compliance(carrier, &touched, &mut Scratch::new(carrier));
            let Some(carried) = carried else { continue };
            tip += tool_compliance(&carried, Vector3::zeros());
        }
        let [least, ..] = principal_stiffnesses(&tip);
        if least.is_finite() && softest.is_none_or(|(softer, _)| least < softer) {
            softest = Some((least, at));
        }
    }
    let (_, at) = softest?;
    let there = compliance(machine, at, scratch).ok()?;
    Some(Softest {
        position_mm: at.pose.translation,
        tool_stiffness_n_per_mm: there.stiffness?,
        compliance_shares: there.shares,
    })
}

/// Returns the range of the tool tip's displacement by weight over `places`; `None` without weight or places.
fn droop(machine: &Machine, places: &[Configuration], scratch: &mut Scratch, effort: &mut Effort) -> Option<Droop> {
    if !machine.has_weight() || places.is_empty() {
        return None;
    }
    let mut carrier = machine.carrier.clone();
    let mut droop = Droop { range_mm: [f64::INFINITY, 0.0], position_mm: places[0].pose.translation, without: None };
    for at in places {
        if !effort.is_left() {
            continue;
        }
        let mut state = State::rigid(machine, at);
        let outcome = equilibrium(machine, &at.drives, &Wrench::zero(), &mut state, scratch, &TO_ROUNDING);
        effort.spend(&outcome);
        if outcome.status != Status::Solved {
            droop.without.get_or_insert_with(|| (0, outcome.status.reason(machine))).0 += 1;
            continue;
        }
        let mut displacement = machine.tool_displacement(&at.pose, &state.pose);
        if let Some(carrier) = &mut carrier {
            let at_tip = carrier.set_touch_point(at.pose.translation + at.pose.rotation * machine.tool_tip);
            let mut state = State::rigid(carrier, &at_tip);
            let mut scratch = Scratch::new(carrier);
            let outcome = equilibrium(carrier, &at_tip.drives, &Wrench::zero(), &mut state, &mut scratch, &TO_ROUNDING);
            effort.spend(&outcome);
            if outcome.status != Status::Solved {
                droop.without.get_or_insert_with(|| (0, outcome.status.reason(carrier))).0 += 1;
                continue;
            }
            displacement -= state.pose.translation - at_tip.pose.translation;
        }
        let displacement = displacement.norm();
        let [least, largest] = &mut droop.range_mm;
        *least = least.min(displacement);
        if displacement > *largest {
            (*largest, droop.position_mm) = (displacement, at.pose.translation);
        }
    }
    Some(droop)
}

/// Force for the shares of elements in the compliance of the tool tip, N.
const FORCE_N: f64 = 1.0;

/// Compliance of the tool tip at a place.
pub(super) struct Compliance {
    /// Principal stiffnesses, N/mm, ascending; `None` where the platform is free.
    pub stiffness: Option<[f64; 3]>,
    /// Share of each elastic element, all directions together; sums to 1. Empty where the tip is rigid.
    pub shares: Vec<(String, f64)>,
}

/// Returns the tool tip's compliance at configuration `at` of the weightless `machine`; or the status of a force without equilibrium.
pub(super) fn compliance(machine: &Machine, at: &Configuration, scratch: &mut Scratch) -> Result<Compliance, Status> {
    let lever = at.pose.rotation * machine.tool_tip;
    let mut carrier = machine.carrier.clone();
    let mut shares: Vec<(String, f64)> = Vec::new();
    let mut stiffness = None;
    for axis in 0..3 {
        let force = Vector3::ith(axis, FORCE_N);
        let load = Wrench { force, moment: lever.cross(&force) };
        let (outcome, mut energies) = elastic_energies(machine, at, &load, scratch)?;
        let mut of_tip = outcome.compliance.map(|compliance| tool_compliance(&compliance, lever));
        if let Some(carrier) = &mut carrier {
            let (at, load) = (
                carrier.set_touch_point(at.pose.translation + lever),
                Wrench { force: -force, moment: Vector3::zeros() },
            );
            let (outcome, of_carrier) = elastic_energies(carrier, &at, &load, &mut Scratch::new(carrier))?;
            energies.extend(of_carrier);
            let carried = outcome.compliance.map(|compliance| tool_compliance(&compliance, Vector3::zeros()));
            of_tip = of_tip.zip(carried).map(|(tip, carried)| tip + carried);
        }
        stiffness = of_tip.map(|compliance| principal_stiffnesses(&compliance));
        for (index, (name, energy)) in energies.into_iter().enumerate() {
            match shares.get_mut(index) {
                Some((_, sum)) => *sum += energy,
                None => shares.push((name, energy)),
            }
        }
    }
    let total: f64 = shares.iter().map(|(_, energy)| energy).sum();
    if stiffness.is_some_and(|[least, ..]: [f64; 3]| least.is_infinite()) || total == 0.0 {
        shares.clear();
    }
    for (_, share) in &mut shares {
        *share /= total;
    }
    Ok(Compliance { stiffness, shares })
}

/// Returns the equilibrium under `load`, and the name and energy (N·mm) of each elastic element; or the status without equilibrium.
fn elastic_energies(
    machine: &Machine,
    at: &Configuration,
    load: &Wrench,
    scratch: &mut Scratch,
) -> Result<(Outcome, Vec<(String, f64)>), Status> {
    let mut rest = State::rigid(machine, at);
    equilibrium(machine, &at.drives, &Wrench::zero(), &mut rest, scratch, &TO_ROUNDING);
    let mut state = rest.clone();
    let outcome = equilibrium(machine, &at.drives, load, &mut state, scratch, &TO_ROUNDING);
    if outcome.status != Status::Solved {
        return Err(outcome.status);
    }
    let energies = deformation_energies(machine, &at.drives, &rest, &state);
    Ok((outcome, energies))
}

/// Mass step from which the growth of drive forces is found, kg.
const TRIAL_KG: f64 = 1.0;
/// Number of corrections of the mass for the bending it causes.
const CORRECTIONS: usize = 4;
/// Growth of a drive's force per kilogram below which it does not carry the mass, as a share of the weight, of revolute joints at the characteristic length.
const NOT_CARRIED: f64 = 1e-6;

/// The largest mass at the tool tip, and where it is reached.
#[derive(Debug, Clone, Serialize)]
pub struct Payload {
    /// The largest mass, kg; 0 where the machine's own weight is too much for a drive.
    pub kilograms: f64,
    /// Label of the drive at its limit.
    pub drive: String,
    /// Position of P, mm.
    pub position_mm: Vector3<f64>,
}

/// A mass, kg, and the index of the drive that it takes to its limit.
type MaxMass = (f64, usize);

/// Returns the largest mass at the tool tip for which no drive exceeds its force limit at any of `places`, own weight included; `None`
/// without gravity or limits, or where no drive carries the mass.
fn payload(machine: &Machine, places: &[Configuration], scratch: &mut Scratch, effort: &mut Effort) -> Option<Payload> {
    if machine.gravity == Vector3::zeros() || machine.drives().all(|(_, drive)| drive.force_limit.is_none()) {
        return None;
    }
    let mut least: Option<(MaxMass, &Configuration)> = None;
    for at in places {
        if !effort.is_left() {
            continue;
        }
        let limit = mass_at_limit(machine, at, 0.0, scratch, effort);
        if let Some(limit) = limit.filter(|limit| least.is_none_or(|(other, _)| limit.0 < other.0)) {
            least = Some((limit, at));
        }
    }
    let ((mut kilograms, mut drive), at) = least?;
    for _ in 0..CORRECTIONS {
        match mass_at_limit(machine, at, kilograms, scratch, effort) {
            Some(limit) if kilograms > 0.0 => (kilograms, drive) = limit,
            _ => break,
        }
    }
    let drive = machine.drive_labels().swap_remove(drive);
    Some(Payload { kilograms, drive, position_mm: at.pose.translation })
}

/// Returns the mass that takes the first drive to its limit, extrapolated from `kilograms`; `None` without equilibrium or such a drive.
fn mass_at_limit(
    machine: &Machine,
    at: &Configuration,
    kilograms: f64,
    scratch: &mut Scratch,
    effort: &mut Effort,
) -> Option<MaxMass> {
    let start = loaded_forces(machine, at, kilograms, scratch, effort)?;
    let more = loaded_forces(machine, at, kilograms + TRIAL_KG, scratch, effort)?;
    let limits = machine.drives().map(|(_, drive)| (drive.force_limit, drive.motion));
    let mut least: Option<MaxMass> = None;
    for (drive, (limit, motion)) in limits.enumerate() {
        let Some(limit) = limit else { continue };
        let lever = if motion == Motion::Revolute { machine.characteristic_length } else { 1.0 };
        if kilograms == 0.0 && start[drive].abs() > limit {
            return Some((0.0, drive));
        }
        let per_kilogram = (more[drive] - start[drive]) / TRIAL_KG;
        if per_kilogram.abs() <= NOT_CARRIED * machine.gravity.norm() * lever {
            continue;
        }
        let mass = (kilograms + (limit - start[drive] * per_kilogram.signum()) / per_kilogram.abs()).max(0.0);
        if least.is_none_or(|(other, _)| mass < other) {
            least = Some((mass, drive));
        }
    }
    least
}

/// Returns the forces of all drives with a mass at the tool tip, N or N·mm; `None` without equilibrium.
fn loaded_forces(
    machine: &Machine,
    at: &Configuration,
    kilograms: f64,
    scratch: &mut Scratch,
    effort: &mut Effort,
) -> Option<Vec<f64>> {
    let force = machine.gravity * kilograms;
    let load = Wrench { force, moment: (at.pose.rotation * machine.tool_tip).cross(&force) };
    let mut state = State::rigid(machine, at);
    let outcome = equilibrium(machine, &at.drives, &load, &mut state, scratch, &TO_ROUNDING);
    effort.spend(&outcome);
    outcome.is_equilibrium().then(|| drive_forces(machine, &state))
}

/// Length of the steps from home, as a share of the machine's size.
const STEP: f64 = 0.04;
/// Farthest distance from home that is tried, in sizes of the machine, plus the travel of prismatic joints.
const FARTHEST: f64 = 4.0;
/// Length of the steps farther away, where only slides lead, as a share of the distance beyond.
const SLIDE_STEP: f64 = 0.25;
/// Resolution of a span, mm.
const RESOLUTION_MM: f64 = 0.1;

/// Distances of P from home along an axis of O, towards negative and positive coordinates, mm.
pub type Span = [f64; 2];

/// Returns the spans along x, y and z with the tool oriented as at home; `None` along an uncontrolled axis, infinite where nothing ends it.
pub(super) fn spans(machine: &Machine) -> [Option<Span>; 3] {
    let along = |axis: usize| {
        let direction = Vector3::ith(axis, 1.0);
        machine.controls_translation(axis).then(|| [-farthest(machine, -direction), farthest(machine, direction)])
    };
    [along(0), along(1), along(2)]
}

/// Returns how far P can go from home along the unit vector `direction` (O), mm; infinite where nothing ends it.
fn farthest(machine: &Machine, direction: Vector3<f64>) -> f64 {
    let home = machine.home.pose.translation;
    let is_reached = |distance: f64| machine.inverse_kinematics_at(home + direction * distance).is_ok();
    let machine_size = machine_size(machine);
    let (step, slides_alone) = (STEP * machine_size, FARTHEST * machine_size);
    let farthest = slides_alone + slide_travel(machine);
    let (mut near, mut far) = (0.0, step);
    while is_reached(far) {
        (near, far) = (far, far + step.max(SLIDE_STEP * (far - slides_alone)));
        if near > farthest {
            return f64::INFINITY;
        }
    }
    while far - near > RESOLUTION_MM {
        let middle = 0.5 * (near + far);
        if is_reached(middle) { near = middle } else { far = middle }
    }
    near
}

/// Returns the sum of the travels of all prismatic joints, mm.
fn slide_travel(machine: &Machine) -> f64 {
    let slides = machine.drives().filter(|(_, drive)| drive.motion == Motion::Prismatic);
    slides.filter_map(|(_, drive)| drive.travel).map(|(least, largest)| largest - least).sum()
}
