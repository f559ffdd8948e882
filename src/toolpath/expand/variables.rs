//! Variables of macros: numbered and named ones, local to a call or not.

use std::collections::BTreeMap;

use crate::toolpath::model::gcode::{Dialect, Fault, MacroFault};

/// All variables, and those of each call.
#[derive(Debug)]
pub(crate) struct Variables {
    common: BTreeMap<String, f64>,
    /// The innermost call last.
    local: Vec<BTreeMap<String, f64>>,
    /// Whose expressions they stand in.
    pub dialect: Dialect,
}

impl Default for Variables {
    fn default() -> Variables {
        Variables::of(Dialect::Iso)
    }
}

/// The largest number of a variable that is the program's own; those above are the machine's.
const OWN: u32 = 999;
/// The largest number of a variable that is local to a call.
const LOCAL: u32 = 33;

impl Variables {
    pub fn of(dialect: Dialect) -> Variables {
        Variables { common: BTreeMap::new(), local: vec![BTreeMap::new()], dialect }
    }

    /// The value of `#name`, `None` if it has none.
    pub fn get(&self, name: &str) -> Result<Option<f64>, Fault> {
        let own = self.map(name).get(name).copied();
        match name.parse::<u32>() {
            Ok(number) if number > OWN => Err(Fault::Macro(MacroFault::MachineState)),
            Err(_) if name.starts_with('_') && own.is_none() => Err(Fault::Macro(MacroFault::MachineState)),
            _ => Ok(own),
        }
    }

    pub fn is_set(&self, name: &str) -> bool {
        self.map(name).contains_key(name)
    }

    pub fn set(&mut self, name: &str, value: Option<f64>) -> Result<(), Fault> {
        if name.parse::<u32>().is_ok_and(|number| number > OWN || number == 0) {
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

    /// A call begins, with `arguments` by the numbers of their variables.
    pub fn call(&mut self, arguments: &[(u32, f64)]) {
        self.local.push(named(arguments));
    }

    /// Whether the variables of the innermost call are still its `arguments`.
    pub fn are(&self, arguments: &[(u32, f64)]) -> bool {
        self.local.last() == Some(&named(arguments))
    }

    /// The innermost call ends.
    pub fn end_call(&mut self) {
        if self.local.len() > 1 {
            self.local.pop();
        }
    }

    fn map(&self, name: &str) -> &BTreeMap<String, f64> {
        match self.local.last() {
            Some(local) if is_local(name) => local,
            _ => &self.common,
        }
    }
}

/// #1 to #33 and names without a leading `_`.
fn is_local(name: &str) -> bool {
    name.parse::<u32>().map_or(!name.starts_with('_'), |number| number <= LOCAL)
}

fn named(arguments: &[(u32, f64)]) -> BTreeMap<String, f64> {
    arguments.iter().map(|(number, value)| (number.to_string(), *value)).collect()
}

/// The variable that Fanuc's G65 gives the value after `letter` (its first kind of arguments).
pub(crate) fn argument(letter: char) -> Option<u32> {
    // #10, #12 and #14 to #16 have none.
    let at = "ABCIJKDEF-H-M---QRSTUVWXYZ".find(letter).filter(|_| letter != '-')?;
    u32::try_from(at + 1).ok()
}
