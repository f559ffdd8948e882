//! Engine forces are the gradient of the energy of springs and masses: between neighbouring equilibria, dU = F·dx + drive work.
//!
//! A dead moment about fixed axes is not conservative, so the work is integrated along the path; the trapezoid rule over
//! n parts errs by O(1/n²), which is checked and extrapolated away.

use crate::support::{
    balance::energy,
    cases::cases,
    engine::*,
    machines::{HUNG, machine_file, places, some_errors, some_load},
};
use kinetostat::{
    machine::{Chain, Machine, Motion},
    spatial::Wrench,
    statics::{ChainState, State, Status, elastic_energy},
};
use nalgebra::Vector6;
use proptest::prelude::*;

/// A way of loading: load and drives go linearly from the first pair to the second.
struct Path<'a> {
    machine: &'a Machine,
    loads: [Wrench; 2],
    drives: [Vec<f64>; 2],
    start: State,
}

/// Forces at one point of the path.
struct Station {
    state: State,
    load: Vector6<f64>,
    drives: Vec<f64>,
    /// Force with which each drive holds the springs of the joints it moves.
    holding: Vec<f64>,
}

/// Forces by which what the drives of a chain are commanded is held.
fn holding(chain: &Chain, own: &ChainState) -> Vec<f64> {
    let torque = |joint: usize| chain.drives[joint].stiffness * own.coordinates[chain.drives[joint].coordinate];
    let by = |drive: usize| -> f64 {
        (0..chain.drives.len()).map(|joint| chain.joint_per_drive(joint, drive) * torque(joint)).sum()
    };
    (0..chain.drives.len()).map(|drive| -by(drive)).collect()
}

impl Path<'_> {
    fn station(&self, share: f64, near: &State) -> Station {
        let load = self.loads[0].to_vector() * (1.0 - share) + self.loads[1].to_vector() * share;
        let mix = |(a, b): (&f64, &f64)| a * (1.0 - share) + b * share;
        let drives: Vec<f64> = self.drives[0].iter().zip(&self.drives[1]).map(mix).collect();
        let mut state = near.clone();
        let outcome = resettle(self.machine, &drives, &Wrench::from_vector(&load), &mut state);
        assert_eq!(outcome.status, Status::Solved, "{} at share {share} of the path", self.machine.name);
        let chains = self.machine.chains.iter().zip(&state.chains);
        let holding = chains.flat_map(|(chain, own)| holding(chain, own)).collect();
        Station { state, load, drives, holding }
    }

    /// What the energy grows by, the elastic energy at both ends, and the work of load and drives by the trapezoid rule over
    /// `parts` parts.
    fn energies_and_work(&self, parts: usize) -> (f64, f64, f64) {
        let first = self.station(0.0, &self.start);
        let of = |station: &Station| {
            let Station { drives, state, .. } = station;
            (energy(self.machine, drives, state), elastic_energy(self.machine, drives, state))
        };
        let (before, elastic_before) = of(&first);
        let (mut last, mut work) = (first, 0.0);
        for part in 1..=parts {
            let next = self.station(part as f64 / parts as f64, &last.state);
            let motion = motion_between(&last.state.pose, &next.state.pose);
            work += 0.5 * (last.load + next.load).dot(&motion);
            for drive in 0..next.drives.len() {
                let force = 0.5 * (last.holding[drive] + next.holding[drive]);
                work += force * (next.drives[drive] - last.drives[drive]);
            }
            last = next;
        }
        let (after, elastic_after) = of(&last);
        (after - before, elastic_before.abs() + elastic_after.abs(), work)
    }

    fn check(&self) -> Result<(), TestCaseError> {
        let (gain, elastic, coarse) = self.energies_and_work(4);
        let (.., fine) = self.energies_and_work(8);
        let scale = elastic.max(1.0);
        let extrapolated = fine + (fine - coarse) / 3.0;
        prop_assert!(
            (extrapolated - gain).abs() < 1e-7 * scale,
            "{}: energy grows by {gain} N·mm, work is {extrapolated} N·mm",
            self.machine.name
        );
        let (error, finer) = ((coarse - gain).abs(), (fine - gain).abs());
        prop_assert!(finer < 0.3 * error + 1e-9 * scale, "trapezoid errors {error:e}, {finer:e} do not fall by 4");
        Ok(())
    }
}

fn loading(
    name: &str,
    share: [f64; 3],
    parts: [[f64; 6]; 2],
    degrees: [f64; 3],
    push_mm: f64,
) -> Result<(), TestCaseError> {
    let nominal = catalogue_machine(name);
    let (_, low, high) = CATALOGUE.into_iter().find(|entry| entry.0 == name).unwrap();
    let at = at_position(&nominal, position_in_box(&nominal, low, high, share));
    let machine = with_assembly_errors(&nominal, degrees);
    let pushed = at.drives.iter().enumerate().map(|(i, rho)| rho + push_mm * [1.0, -0.5, 0.3][i]).collect();
    let path = Path {
        machine: &machine,
        loads: parts.map(|p| wrench_from(400.0, 30_000.0, p)),
        drives: [at.drives.clone(), pushed],
        start: State::rigid(&nominal, &at),
    };
    path.check()
}

fn parts() -> impl Strategy<Value = [f64; 6]> {
    prop::array::uniform6(-1.0..1.0f64)
}

fn share() -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(0.0..1.0f64)
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn energy_is_the_work_of_the_load(s in share(), a in parts(), b in parts()) {
        for (name, ..) in CATALOGUE {
            loading(name, s, [a, b], [0.0; 3], 0.0)?;
        }
    }

    #[test]
    fn energy_is_the_work_of_load_and_drives_with_chain_errors(
        s in share(), a in parts(), b in parts(), degrees in prop::array::uniform3(-1.5..1.5f64), push in -2.0..2.0f64,
    ) {
        for (name, ..) in CATALOGUE {
            loading(name, s, [a, b], degrees, push)?;
        }
    }
}

#[test]
fn energy_of_an_undeflected_machine_is_zero() {
    for (name, ..) in CATALOGUE {
        let machine = catalogue_machine(name);
        let energy = elastic_energy(&machine, &machine.home.drives, &State::rigid(&machine, &machine.home));
        assert_eq!(energy, 0.0, "{name}: energy at home");
    }
}

#[test]
fn energy_of_springs_and_masses_is_the_work_of_load_and_drives() {
    for name in HUNG {
        let nominal = machine_file(name);
        for (seed, at) in places(&nominal, 3).into_iter().enumerate() {
            let machine = nominal.with_errors(&some_errors(&nominal, seed));
            let push = |(i, (_, drive)): (usize, (usize, &kinetostat::machine::Drive))| {
                let size = if drive.motion == Motion::Revolute { 0.01 } else { 3.0 };
                at.drives[i] + size * [1.0, -0.5, 0.3][i % 3]
            };
            let path = Path {
                machine: &machine,
                loads: [some_load(&machine, 500.0, seed), some_load(&machine, 500.0, seed + 7)],
                drives: [at.drives.clone(), machine.drives().enumerate().map(push).collect()],
                start: State::rigid(&nominal, &at),
            };
            path.check().unwrap_or_else(|failure| panic!("{failure}"));
        }
    }
}
