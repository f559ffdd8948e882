//! Elastic energy of a state.

use super::state::State;
use crate::machine::{Machine, SpringLaw};

/// Elastic energy U of all springs at `state`, N·mm. Its gradient is what the equilibrium equations balance.
pub fn elastic_energy(machine: &Machine, state: &State) -> f64 {
    let mut energy = 0.0;
    for (chain, chain_state) in machine.chains.iter().zip(&state.chains) {
        for spring in &chain.springs {
            let theta = &chain_state.coordinates[spring.start..spring.start + spring.law.size()];
            let entry = |i: usize, j: usize| match &spring.law {
                SpringLaw::Drive(stiffness) => *stiffness,
                SpringLaw::Link(stiffness) => stiffness[(i, j)],
                SpringLaw::Parallelogram { passive, terms } => {
                    let (sin, cos) = (2.0 * chain_state.coordinates[*passive]).sin_cos();
                    terms[0][(i, j)] + terms[1][(i, j)] * cos + terms[2][(i, j)] * sin
                }
            };
            for (i, a) in theta.iter().enumerate() {
                for (j, b) in theta.iter().enumerate() {
                    energy += 0.5 * a * entry(i, j) * b;
                }
            }
        }
        for (j, joint) in chain.passive.iter().enumerate() {
            let stretch = chain_state.coordinates[chain.passive_coordinate(j)] - joint.neutral;
            energy += 0.5 * joint.stiffness * stretch * stretch;
        }
    }
    energy
}
