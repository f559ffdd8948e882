//! Energy of a machine's springs and masses in a state.

use nalgebra::Vector6;

use super::state::{ChainState, State};
use crate::{
    machine::{Anchor, Chain, Machine, PointSpring, Route, Spring, SpringLaw},
    spatial::Pose,
};

/// Elastic energy U of all springs at `state` with drives at `drives` (mm, rad), N·mm. Its gradient, with that of
/// [`weight_energy`], is what the equilibrium equations balance.
pub fn elastic_energy(machine: &Machine, drives: &[f64], state: &State) -> f64 {
    spring_energies(machine, drives, state).iter().map(|(_, energy)| energy).sum()
}

/// Elastic energy of each spring at `state` with drives at `drives` (mm, rad), N·mm, with the spring's name: chain and element.
pub fn spring_energies(machine: &Machine, drives: &[f64], state: &State) -> Vec<(String, f64)> {
    let mut energies = Vec::new();
    for (c, (chain, chain_state)) in machine.chains.iter().zip(&state.chains).enumerate() {
        for spring in &chain.springs {
            let energy = joint_group_energy(spring, &chain_state.coordinates);
            energies.push((format!("{} {}", chain.name, spring.name), energy));
        }
        for (j, joint) in chain.passive.iter().enumerate().filter(|(_, joint)| joint.stiffness > 0.0) {
            let stretch = chain_state.coordinates[chain.passive_coordinate(j)] - joint.neutral;
            energies.push((format!("{} {}", chain.name, joint.name), 0.5 * joint.stiffness * stretch * stretch));
        }
        for_each_route(chain, drives_from_chain(machine, drives, c), chain_state, &mut |route, frames| {
            for spring in &route.point_springs {
                let stretch = length(spring, frames) - spring.free_length;
                let energy = 0.5 * spring.stiffness * stretch * stretch + spring.preload * stretch;
                energies.push((format!("{} {}", chain.name, spring.name), energy));
            }
        });
    }
    if let Some(stiffness) = machine.tool_stiffness() {
        let tool_deflections = tool_deflections(machine, state);
        energies.push((TOOL.into(), 0.5 * tool_deflections.dot(&(stiffness * tool_deflections))));
    }
    energies
}

/// Name of the tool among the springs.
const TOOL: &str = "tool";

/// Deflections of the tool at T (mm, rad) in the axes of the straight tool.
fn tool_deflections(machine: &Machine, state: &State) -> Vector6<f64> {
    let tool = machine.tool();
    let way = state.platform().compose(&tool).inverse().compose(&state.pose.compose(&tool));
    // Tx Ty Tz Rx Ry Rz: the angles of V(θ).
    let (r, t) = (way.rotation, way.translation);
    let angles = [libm::atan2(-r[(1, 2)], r[(2, 2)]), libm::asin(r[(0, 2)]), libm::atan2(-r[(0, 1)], r[(0, 0)])];
    Vector6::new(t.x, t.y, t.z, angles[0], angles[1], angles[2])
}

/// Energy of each spring by its change of deflection from state `from` to state `to` alone, N·mm, with its name; drives at `drives` (mm, rad).
pub fn deformation_energies(machine: &Machine, drives: &[f64], from: &State, to: &State) -> Vec<(String, f64)> {
    let mut energies = Vec::new();
    for (c, (chain, (from, to))) in machine.chains.iter().zip(from.chains.iter().zip(&to.chains)).enumerate() {
        let mut change: Vec<f64> = to.coordinates.iter().zip(&from.coordinates).map(|(to, from)| to - from).collect();
        for (j, joint) in chain.passive.iter().enumerate().filter(|(_, joint)| joint.stiffness > 0.0) {
            let turned = change[chain.passive_coordinate(j)];
            energies.push((format!("{} {}", chain.name, joint.name), 0.5 * joint.stiffness * turned * turned));
        }
        // The law of a parallelogram is that of where it stands.
        change[chain.virtual_count..].copy_from_slice(&from.coordinates[chain.virtual_count..]);
        for spring in &chain.springs {
            energies.push((format!("{} {}", chain.name, spring.name), joint_group_energy(spring, &change)));
        }
        let drives = drives_from_chain(machine, drives, c);
        let lengths = |state: &ChainState| {
            let mut lengths = Vec::new();
            for_each_route(chain, drives, state, &mut |route, frames| {
                lengths.extend(route.point_springs.iter().map(|spring| (length(spring, frames), spring.clone())));
            });
            lengths
        };
        for ((from, spring), (to, _)) in lengths(from).into_iter().zip(lengths(to)) {
            let stretch = to - from;
            energies.push((format!("{} {}", chain.name, spring.name), 0.5 * spring.stiffness * stretch * stretch));
        }
    }
    if let Some(stiffness) = machine.tool_stiffness() {
        let change = tool_deflections(machine, to) - tool_deflections(machine, from);
        energies.push((TOOL.into(), 0.5 * change.dot(&(stiffness * change))));
    }
    energies
}

/// Length of a spring between points, mm; `frames` are the poses of its route's frames.
fn length(spring: &PointSpring, frames: &[Pose]) -> f64 {
    let place = |anchor: &Anchor| anchor.frame.map_or(anchor.at, |frame| frames[frame].transform(anchor.at));
    (place(&spring.to) - place(&spring.from)).norm()
}

/// Energy of the machine's masses at `state` with drives at `drives` (mm, rad), `−Σ m g·p`, N·mm: zero where they all are at O.
pub fn weight_energy(machine: &Machine, drives: &[f64], state: &State) -> f64 {
    let mut moment = nalgebra::Vector3::zeros();
    for (c, (chain, chain_state)) in machine.chains.iter().zip(&state.chains).enumerate() {
        for_each_route(chain, drives_from_chain(machine, drives, c), chain_state, &mut |route, frames| {
            for mass in &route.masses {
                moment += frames[mass.frame].transform(mass.at) * mass.kilograms;
            }
        });
    }
    if let Some(mass) = &machine.platform_mass {
        moment += state.platform().transform(mass.at) * mass.kilograms;
    }
    -machine.gravity.dot(&moment)
}

/// Drive positions from those of chain number `chain` on.
fn drives_from_chain<'a>(machine: &Machine, drives: &'a [f64], chain: usize) -> &'a [f64] {
    let before: usize = machine.chains[..chain].iter().map(|chain| chain.drives.len()).sum();
    &drives[before..]
}

/// Calls `each` with every route of a chain, loops included, and the poses of its frames in O.
fn for_each_route(chain: &Chain, drives: &[f64], state: &ChainState, each: &mut impl FnMut(&Route, &[Pose])) {
    /// Calls `each` with `route`, which starts at `start`, and with the routes of its loops.
    fn walk(route: &Route, start: &Pose, values: &[f64], each: &mut impl FnMut(&Route, &[Pose])) {
        let mut frames = Vec::new();
        route.forward(start, values, &mut Vec::new(), &mut frames);
        each(route, &frames);
        for inner in &route.loops {
            walk(&inner.route, &frames[inner.from], values, each);
        }
    }
    let mut values = state.coordinates.clone();
    chain.add_joint_positions(drives, &mut values);
    walk(&chain.route, &Pose::identity(), &values, each);
}

/// Energy `½ θᵀ K θ` of one group of virtual joints, N·mm.
fn joint_group_energy(spring: &Spring, coordinates: &[f64]) -> f64 {
    let theta = &coordinates[spring.start..spring.start + spring.law.size()];
    let entry = |i: usize, j: usize| match &spring.law {
        SpringLaw::Drive(stiffness) => *stiffness,
        SpringLaw::Link(stiffness) => stiffness[(i, j)],
        SpringLaw::Parallelogram { passive, terms } => {
            let (sin, cos) = libm::sincos(2.0 * coordinates[*passive]);
            terms[0][(i, j)] + terms[1][(i, j)] * cos + terms[2][(i, j)] * sin
        }
    };
    let mut energy = 0.0;
    for (i, a) in theta.iter().enumerate() {
        for (j, b) in theta.iter().enumerate() {
            energy += 0.5 * a * entry(i, j) * b;
        }
    }
    energy
}
