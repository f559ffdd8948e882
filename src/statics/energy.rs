//! Energy of a state: of its springs, and of its masses.

use super::state::{ChainState, State};
use crate::{
    machine::{Anchor, Chain, Machine, Route, Spring, SpringLaw},
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
            let energy = link_energy(spring, &chain_state.coordinates);
            energies.push((format!("{} {}", chain.name, spring.name), energy));
        }
        for (j, joint) in chain.passive.iter().enumerate().filter(|(_, joint)| joint.stiffness > 0.0) {
            let stretch = chain_state.coordinates[chain.passive_coordinate(j)] - joint.neutral;
            energies.push((format!("{} {}", chain.name, joint.name), 0.5 * joint.stiffness * stretch * stretch));
        }
        for_each_route(chain, drives_of(machine, drives, c), chain_state, &mut |route, frames| {
            let place = |anchor: &Anchor| anchor.frame.map_or(anchor.at, |frame| frames[frame].transform(anchor.at));
            for spring in &route.point_springs {
                let stretch = (place(&spring.to) - place(&spring.from)).norm() - spring.free_length;
                let energy = 0.5 * spring.stiffness * stretch * stretch + spring.preload * stretch;
                energies.push((format!("{} {}", chain.name, spring.name), energy));
            }
        });
    }
    energies
}

/// Energy of the machine's masses at `state` with drives at `drives` (mm, rad), `−Σ m g·p`, N·mm: zero where they all are at O.
pub fn weight_energy(machine: &Machine, drives: &[f64], state: &State) -> f64 {
    let mut moment = nalgebra::Vector3::zeros();
    for (c, (chain, chain_state)) in machine.chains.iter().zip(&state.chains).enumerate() {
        for_each_route(chain, drives_of(machine, drives, c), chain_state, &mut |route, frames| {
            for mass in &route.masses {
                moment += frames[mass.frame].transform(mass.at) * mass.kilograms;
            }
        });
    }
    if let Some(mass) = &machine.platform_mass {
        moment += state.pose.transform(mass.at) * mass.kilograms;
    }
    -machine.gravity.dot(&moment)
}

/// The drives from those of chain `chain` on.
fn drives_of<'a>(machine: &Machine, drives: &'a [f64], chain: usize) -> &'a [f64] {
    let before: usize = machine.chains[..chain].iter().map(|chain| chain.drives.len()).sum();
    &drives[before..]
}

/// Tells `each` every route of a chain with the poses of its frames.
fn for_each_route(chain: &Chain, drives: &[f64], state: &ChainState, each: &mut impl FnMut(&Route, &[Pose])) {
    fn walk(route: &Route, start: &Pose, values: &[f64], each: &mut impl FnMut(&Route, &[Pose])) {
        let mut frames = Vec::new();
        route.forward(start, values, &mut Vec::new(), &mut frames);
        each(route, &frames);
        for inner in &route.loops {
            walk(&inner.route, &frames[inner.from], values, each);
        }
    }
    let mut values = state.coordinates.clone();
    chain.add_joints(drives, &mut values);
    walk(&chain.route, &Pose::identity(), &values, each);
}

/// `½ θᵀ K θ` of one group of virtual joints.
fn link_energy(spring: &Spring, coordinates: &[f64]) -> f64 {
    let theta = &coordinates[spring.start..spring.start + spring.law.size()];
    let entry = |i: usize, j: usize| match &spring.law {
        SpringLaw::Drive(stiffness) => *stiffness,
        SpringLaw::Link(stiffness) => stiffness[(i, j)],
        SpringLaw::Parallelogram { passive, terms } => {
            let (sin, cos) = (2.0 * coordinates[*passive]).sin_cos();
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
