//! Elastic energy of a state.

use super::state::State;
use crate::machine::{Machine, Spring, SpringLaw};

/// Elastic energy U of all springs at `state`, N·mm. Its gradient is what the equilibrium equations balance.
pub fn elastic_energy(machine: &Machine, state: &State) -> f64 {
    spring_energies(machine, state).iter().map(|(_, energy)| energy).sum()
}

/// Elastic energy of each spring at `state`, N·mm, with the spring's name: chain and element.
pub fn spring_energies(machine: &Machine, state: &State) -> Vec<(String, f64)> {
    let mut energies = Vec::new();
    for (chain, chain_state) in machine.chains.iter().zip(&state.chains) {
        for spring in &chain.springs {
            let energy = link_energy(spring, &chain_state.coordinates);
            energies.push((format!("{} {}", chain.name, spring.name), energy));
        }
        for (j, joint) in chain.passive.iter().enumerate().filter(|(_, joint)| joint.stiffness > 0.0) {
            let stretch = chain_state.coordinates[chain.passive_coordinate(j)] - joint.neutral;
            energies.push((format!("{} {}", chain.name, joint.name), 0.5 * joint.stiffness * stretch * stretch));
        }
    }
    energies
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
