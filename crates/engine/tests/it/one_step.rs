//! A Newton step as a function of numbers, and what is written down of it.

use kinetostat_engine::{
    Machine, Wrench,
    lanes::MAX_LANES,
    nalgebra::Vector3,
    statics::{
        State,
        one_step::{StepInput, origin_index, state_from_numbers, state_numbers, step, step_program},
    },
};

/// States near equilibria of a machine all over its workspace, and what is asked there.
fn inputs(machine: &Machine, given: StepInput, seed: usize) -> Vec<f64> {
    let share = |k: usize| (0.618_033_988_749_894_9 * (seed * 16 + k + 1) as f64).fract();
    let (low, high) = (machine.workspace.min, machine.workspace.max);
    // Not to its corners, of which some are nearly singular.
    let at = Vector3::from_fn(|i, _| low[i] + (0.1 + 0.8 * share(i)) * (high[i] - low[i]));
    let configuration = machine.inverse_kinematics_at(at).unwrap();
    let mut state = State::rigid(machine, &configuration);
    for (c, chain) in state.chains.iter_mut().enumerate() {
        for (i, coordinate) in chain.coordinates.iter_mut().enumerate() {
            *coordinate += 1e-4 * (share(7 * c + i) - 0.5);
        }
        chain.wrench = Wrench::new(std::array::from_fn(|i| 50.0 * (share(5 * c + i) - 0.5)));
    }
    let mut all = state_numbers(&configuration.drives, &state);
    let asked = at + machine.home.pose.rotation * machine.tool_tip;
    if given == StepInput::Tip {
        all.extend(asked.iter());
    }
    all.extend((0..6).map(|i| 50.0 * (share(3 + i) - 0.5)));
    all
}

#[test]
fn what_is_written_down_has_the_bits_of_the_engine() {
    for name in ["orthoglide", "tripteron", "delta_3puu", "rotary_delta"] {
        let machine = Machine::named(name).unwrap();
        for given in [StepInput::Tip, StepInput::Drives] {
            let postures: Vec<Vec<f64>> = (0..MAX_LANES).map(|seed| inputs(&machine, given, 1000 + seed)).collect();
            let program = step_program(&machine, given, &postures).unwrap();
            let mut values = Vec::new();
            for seed in 0..100 {
                let inputs = inputs(&machine, given, seed);
                let expected: Vec<f64> = step(&machine, given, &inputs).unwrap();
                assert_eq!(program.evaluate(&inputs, &mut values), expected, "{name}, {given:?}, state {seed}");
            }
        }
    }
}

#[test]
fn a_state_is_what_its_numbers_say() {
    let machine = Machine::named("rotary_delta").unwrap();
    let all = inputs(&machine, StepInput::Drives, 3);
    let (drives, state) = state_from_numbers(&machine, &all);
    assert_eq!(state_numbers(&drives, &state), all[..all.len() - 6]);
    assert_eq!(state.pose.translation.as_slice(), &all[origin_index(3)..origin_index(3) + 3]);
}
