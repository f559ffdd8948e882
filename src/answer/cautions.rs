//! Cautions of the first screen: positions outside the workspace box, large chain errors, process tables that are not used.

use nalgebra::Vector3;

use crate::{
    files::words::{cannot_be_run, with_minus_signs},
    machine::{ChainError, Grade, Machine, OutsideWorkspace, ZeroState},
    page::headline::{State, Verdict},
};

/// Rotation of a chain by its errors above which a caution is given, rad.
const LARGE_ROTATION: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// Returns all cautions about results of `machine` with `errors` at `positions` of P (O, mm), each of which is called a `noun`.
pub fn machine_cautions(
    machine: &Machine,
    errors: &[ChainError],
    noun: &str,
    positions: impl Iterator<Item = Vector3<f64>>,
) -> String {
    let outside = OutsidePositions::of(machine, positions);
    zeroing(machine) + &carrier(machine) + &large_errors(machine, errors) + &outside.text(noun)
}

/// Counts positions, and those of them that are outside a machine's workspace box.
#[derive(Debug, Default)]
pub struct OutsidePositions {
    count: usize,
    outside: usize,
    first: Option<OutsideWorkspace>,
}

impl OutsidePositions {
    /// Counts which of `positions` of P (O, mm) are outside the workspace box of `machine`.
    pub fn of(machine: &Machine, positions: impl Iterator<Item = Vector3<f64>>) -> Self {
        let mut outside = Self::default();
        positions.for_each(|position| outside.add(machine, position));
        outside
    }

    /// Adds a position of P (O, mm) to the counts.
    pub fn add(&mut self, machine: &Machine, position: Vector3<f64>) {
        self.count += 1;
        if let Some(excess) = machine.outside_workspace(position) {
            self.outside += 1;
            self.first.get_or_insert(excess);
        }
    }

    /// Returns the number of positions outside the workspace box.
    pub fn outside(&self) -> usize {
        self.outside
    }

    /// Returns a sentence for the first screen that `machine` cannot run `what` as it is placed; empty if no position is outside.
    pub fn verdict(&self, machine: &Machine, what: &str) -> String {
        match self.outside {
            0 => String::new(),
            outside => {
                cannot_be_run(what, outside as u64, self.count as u64, &machine.name)
                    + "The results were computed all the same. "
            }
        }
    }

    /// Returns the first sentence where `machine` cannot run the path; `None` where it can, or its workspace box is assumed.
    pub fn sentence(&self, machine: &Machine) -> Option<String> {
        let is_barred = self.outside > 0 && !has_assumed_workspace(machine);
        is_barred.then(|| "As placed, this path cannot be run; numbers are computed regardless.".into())
    }

    /// Returns the verdict that `machine` cannot run a path with positions outside; only partly so if its workspace box is assumed.
    pub fn state(&self, machine: &Machine) -> Verdict {
        let Self { count, outside, .. } = self;
        let text = format!("{outside} of {count} points outside");
        match has_assumed_workspace(machine) {
            true => Verdict::new(State::Partly, text + " an assumed box"),
            false => Verdict::new(State::Bad, text + " the workspace"),
        }
    }

    /// Returns a sentence that counts the positions outside the workspace box, each called a `noun`; empty if there are none.
    pub fn text(&self, noun: &str) -> String {
        let Self { count, outside, first } = self;
        match first {
            Some(first) => with_minus_signs(&format!(
                "Outside the machine's workspace box: {outside} of {count} {noun}s; the first: {first}.\n"
            )),
            None => String::new(),
        }
    }
}

/// Whether the workspace box of `machine` is assumed.
fn has_assumed_workspace(machine: &Machine) -> bool {
    machine.provenance_of("workspace.min.x").is_some_and(|about| about.grade == Grade::Assumed)
}

/// Returns the caution that the workspace box, which bounds all places, is graded assumed in the file of `machine`; empty where not.
pub fn assumed_workspace(machine: &Machine) -> String {
    if !has_assumed_workspace(machine) {
        return String::new();
    }
    let line = machine.line_of("workspace").map_or_else(String::new, |line| format!(", line {line} of its file"));
    format!(
        "The workspace box of {} is assumed{line}: places at which P would leave it do not count, and the best place is that of the box \
         given.\n",
        machine.name
    )
}

/// Returns a sentence on the state from which deflections of `machine` are measured; empty if it has neither weight nor springs.
pub fn zeroing(machine: &Machine) -> String {
    let Some(loads) = machine.own_load_text() else { return String::new() };
    let from = match machine.zeroed {
        ZeroState::AtRest => {
            format!("from the machine at rest under its {loads}, calibrated there (zeroed = \"at_rest\")")
        }
        ZeroState::Weightless => format!("from the rigid model, without {loads} (zeroed = \"weightless\")"),
        ZeroState::AtHome => {
            format!("from the rigid model, its drives calibrated under its {loads} at home (zeroed = \"at_home\")")
        }
    };
    format!("Deflections of {} are measured {from}.\n", machine.name)
}

/// Returns sentences that deflections are from the workpiece, if its carrier bends as well, and where locked or external axes are.
pub fn carrier(machine: &Machine) -> String {
    let mut text = String::new();
    if let Some(carrier) = &machine.carrier {
        text += &format!(
            "Deflections are of the tool from the workpiece: its carrier {} bears the opposite load and bends as well.\n",
            carrier.name
        );
    }
    text + &machine.locked_text().map_or_else(String::new, |words| format!("Locked or external axes: {words}.\n"))
}

/// Returns a sentence for each chain of `machine` that `errors` rotate by a large angle.
pub fn large_errors(machine: &Machine, errors: &[ChainError]) -> String {
    let mut text = String::new();
    for (chain, error) in machine.chains.iter().zip(errors) {
        let turn = error.base.angular.norm().max(error.end.angular.norm());
        if turn > LARGE_ROTATION {
            text += &format!(
                "Chain {} is turned by {:.1}\u{b0} by its errors: more than assembly leaves; is that rotation intended?\n",
                chain.name,
                turn.to_degrees()
            );
        }
    }
    text
}

/// Returns a sentence that names the process `tables` that a study over the workspace does not use; empty if there are none.
pub fn unused_tables(tables: &[&str]) -> String {
    match tables {
        [] => String::new(),
        tables => format!("Not used: {} of the process.\n", tables.join(", ")),
    }
}
