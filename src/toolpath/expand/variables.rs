//! Macro variables, numbered and named, common or local to a call.

use std::collections::BTreeMap;

use crate::toolpath::model::gcode::{Dialect, Fault, MacroFault};

/// Values of all variables that are set.
#[derive(Debug)]
pub(crate) struct Variables {
    common: BTreeMap<String, f64>,
    /// Local variables of each call, the innermost last.
    local: Vec<BTreeMap<String, f64>>,
    /// Dialect whose rules the expressions follow.
    pub dialect: Dialect,
}

impl Default for Variables {
    /// Starts without any variables, by the rules of ISO.
    fn default() -> Variables {
        Variables::new(Dialect::Iso)
    }
}

/// Largest number of a variable of programs; those above are system variables.
const LAST_OWN: u32 = 999;
/// Largest number of a local variable.
const LAST_LOCAL: u32 = 33;

impl Variables {
    /// Starts without any variables, by the rules of `dialect`.
    pub fn new(dialect: Dialect) -> Variables {
        Variables { common: BTreeMap::new(), local: vec![BTreeMap::new()], dialect }
    }

    /// Returns the value of `#name`, `None` if it is not set. `Err` for system variables.
    pub fn get(&self, name: &str) -> Result<Option<f64>, Fault> {
        let value = self.scope(name).get(name).copied();
        match name.parse::<u32>() {
            Ok(number) if number > LAST_OWN => Err(Fault::Macro(MacroFault::MachineState)),
            Err(_) if name.starts_with('_') && value.is_none() => Err(Fault::Macro(MacroFault::MachineState)),
            _ => Ok(value),
        }
    }

    /// Whether `#name` has a value.
    pub fn is_set(&self, name: &str) -> bool {
        self.scope(name).contains_key(name)
    }

    /// Sets `#name`, or removes it by `None`. `Err` for system variables.
    pub fn set(&mut self, name: &str, value: Option<f64>) -> Result<(), Fault> {
        if name.parse::<u32>().is_ok_and(|number| number > LAST_OWN || number == 0) {
            return Err(Fault::Macro(MacroFault::MachineState));
        }
        let is_local = is_local(name);
        let map = match self.local.last_mut() {
            Some(local) if is_local => local,
            _ => &mut self.common,
        };
        match value {
            Some(value) => map.insert(name.to_owned(), value),
            None => map.remove(name),
        };
        Ok(())
    }

    /// Begins a call with `arguments` by the numbers of their variables.
    pub fn call(&mut self, arguments: &[(u32, f64)]) {
        self.local.push(by_variable(arguments));
    }

    /// Whether the local variables of the innermost call are still its `arguments`.
    pub fn has_arguments(&self, arguments: &[(u32, f64)]) -> bool {
        self.local.last() == Some(&by_variable(arguments))
    }

    /// Ends the innermost call.
    pub fn end_call(&mut self) {
        if self.local.len() > 1 {
            self.local.pop();
        }
    }

    /// Returns the variables among which `name` belongs: those of the innermost call if it is local, else the common ones.
    fn scope(&self, name: &str) -> &BTreeMap<String, f64> {
        match self.local.last() {
            Some(local) if is_local(name) => local,
            _ => &self.common,
        }
    }
}

/// Whether `name` is local: #1 to #33, and names without a leading `_`.
fn is_local(name: &str) -> bool {
    name.parse::<u32>().map_or(!name.starts_with('_'), |number| number <= LAST_LOCAL)
}

/// Returns the values of arguments by the names of their variables.
fn by_variable(arguments: &[(u32, f64)]) -> BTreeMap<String, f64> {
    arguments.iter().map(|(number, value)| (number.to_string(), *value)).collect()
}

/// Returns the number of the variable that takes the value after `letter` in Fanuc's G65 (first kind of arguments), if there is one.
pub(crate) fn argument_variable(letter: char) -> Option<u32> {
    // #10, #12 and #14 to #16 have none.
    let at = "ABCIJKDEF-H-M---QRSTUVWXYZ".find(letter).filter(|_| letter != '-')?;
    u32::try_from(at + 1).ok()
}
