//! The machines for which there is code for controllers.

use crate::{
    input::error::{Error, Result},
    machine::{Coordinate, Machine, Zeroed},
};

/// Refuses a machine by what is missing.
pub(super) fn check(machine: &Machine) -> Result<()> {
    let translations = (0..3).all(|axis| machine.controls_translation(axis));
    let controls = || machine.controls.iter().map(|c: &Coordinate| c.name()).collect::<Vec<_>>().join(", ");
    let problem = if !translations || machine.controls.len() != 3 {
        format!("its drives control {}: expected the translations x, y, z and nothing else", controls())
    } else if machine.drive_count() != 3 {
        format!("it has {} drives: expected three", machine.drive_count())
    } else if machine.turns_with_position {
        "its platform turns as it moves: expected one that keeps its orientation".into()
    } else if machine.carrier.is_some() {
        "what carries its workpiece can move or bend: expected a workpiece that stands fast".into()
    } else if machine.tool_compliance.is_some() {
        "its tool bends: expected a rigid one, without platform.tool_stiffness".into()
    } else if let (Zeroed::AtRest, Some(own)) = (machine.zeroed, machine.own_forces()) {
        format!(
            "it has {own} and is zeroed where it rests, from where it is elsewhere in the base frame: expected zeroed = \"weightless\" or \
             \"at_home\""
        )
    } else {
        return Ok(());
    };
    let problem = format!("{}: {problem}", machine.name);
    Err(Error::Argument { argument: "--machine".into(), problem })
}
