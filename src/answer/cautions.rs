//! What the first screen says besides the answer, because it may not be meant: places outside the machine's workspace
//! box, large errors, tables of a process that are not used.

use nalgebra::Vector3;

use crate::{
    files::words::signed,
    machine::{ChainError, Machine, OutsideWorkspace, Zeroed},
};

/// Rotations of a chain above this are said, rad.
const LARGE_ROTATION: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// What must be known with any answer about `machine` with `errors` at `positions` of P (O, mm), each of which is a `noun`.
pub fn of_machine(
    machine: &Machine,
    errors: &[ChainError],
    noun: &str,
    positions: impl Iterator<Item = Vector3<f64>>,
) -> String {
    zeroed(machine) + &carried(machine) + &large_errors(machine, errors) + &outside_workspace(machine, noun, positions)
}

/// A sentence if `positions` of P (O, mm), each of which is a `noun`, are not all inside the machine's workspace box.
pub fn outside_workspace(machine: &Machine, noun: &str, positions: impl Iterator<Item = Vector3<f64>>) -> String {
    Outside::of(machine, positions).words(noun)
}

/// Positions outside a machine's workspace box, counted one by one.
#[derive(Debug, Default)]
pub struct Outside {
    count: usize,
    outside: usize,
    first: Option<OutsideWorkspace>,
}

impl Outside {
    /// Those of `positions` of P (O, mm).
    pub fn of(machine: &Machine, positions: impl Iterator<Item = Vector3<f64>>) -> Self {
        let mut outside = Self::default();
        positions.for_each(|position| outside.add(machine, position));
        outside
    }

    /// Takes a position of P (O, mm).
    pub fn add(&mut self, machine: &Machine, position: Vector3<f64>) {
        self.count += 1;
        if let Some(found) = machine.outside_workspace(position) {
            self.outside += 1;
            self.first.get_or_insert(found);
        }
    }

    /// Whether there are any.
    pub fn any(&self) -> bool {
        self.outside > 0
    }

    /// What a first screen begins with if there are any: that `machine` cannot run `what` as it is placed.
    pub fn verdict(&self, machine: &Machine, what: &str) -> String {
        match self.outside {
            0 => String::new(),
            outside => format!(
                "As placed, {what} cannot be run: {outside} of {} points are outside the workspace box of the {}. The results were computed all the same. ",
                self.count,
                machine.short_title()
            ),
        }
    }

    /// A sentence if there are any; each position is a `noun`.
    pub fn words(&self, noun: &str) -> String {
        let Self { count, outside, first } = self;
        match first {
            Some(first) => signed(&format!(
                "Outside the machine's workspace box: {outside} of {count} {noun}s; the first: {first}.\n"
            )),
            None => String::new(),
        }
    }
}

/// From where deflections of `machine` are measured, if it has weight or springs.
pub fn zeroed(machine: &Machine) -> String {
    let Some(own) = machine.own_forces() else { return String::new() };
    let from = match machine.zeroed {
        Zeroed::AtRest => {
            format!("from where it rests under its {own}, calibrated there (zeroed = \"at_rest\")")
        }
        Zeroed::Weightless => format!("from the rigid model, without {own} (zeroed = \"weightless\")"),
        Zeroed::AtHome => {
            format!("from the rigid model, its drives calibrated under its {own} at home (zeroed = \"at_home\")")
        }
    };
    format!("Deflections of {} are measured {from}.\n", machine.name)
}

/// That deflections are those from the workpiece, where its carrier bends as well, and where other drives stand.
pub fn carried(machine: &Machine) -> String {
    let mut text = String::new();
    if let Some(carrier) = &machine.carrier {
        text += &format!(
            "Deflections are of the tool from the workpiece: its carrier {} bears the opposite load and bends as well.\n",
            carrier.name
        );
    }
    text + &machine.locked_words().map_or_else(String::new, |words| format!("Locked or external axes: {words}.\n"))
}

/// A sentence for each chain of `machine` that `errors` turn far.
pub fn large_errors(machine: &Machine, errors: &[ChainError]) -> String {
    let mut text = String::new();
    for (chain, error) in machine.chains.iter().zip(errors) {
        let turn = error.base.angular.norm().max(error.end.angular.norm());
        if turn > LARGE_ROTATION {
            text += &format!(
                "Chain {} is turned by {:.1}\u{b0} by its errors: more than what assembly leaves; is it meant?\n",
                chain.name,
                turn.to_degrees()
            );
        }
    }
    text
}

/// Tables of a process that a study over the workspace has no use for, if there are any.
pub fn not_used(tables: &[&str]) -> String {
    match tables {
        [] => String::new(),
        tables => format!("Not used: {} of the process.\n", tables.join(", ")),
    }
}
