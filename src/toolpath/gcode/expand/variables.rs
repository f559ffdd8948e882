//! Variables of macros: numbered and named ones, local to a call or not.

use std::collections::BTreeMap;

use crate::toolpath::gcode::error::Fault;

/// All variables, and those of each call.
#[derive(Debug)]
pub(super) struct Variables {
    common: BTreeMap<String, f64>,
    /// The innermost call last.
    local: Vec<BTreeMap<String, f64>>,
}

impl Default for Variables {
    fn default() -> Variables {
        Variables { common: BTreeMap::new(), local: vec![BTreeMap::new()] }
    }
}

/// The largest number of a variable that is the program's own; those above are the machine's.
const OWN: u32 = 999;
/// The largest number of a variable that is local to a call.
const LOCAL: u32 = 33;

impl Variables {
    /// The value of `#name`, `None` if it has none.
    pub fn get(&self, name: &str) -> Result<Option<f64>, Fault> {
        let own = self.map(name).get(name).copied();
        match name.parse::<u32>() {
            Ok(number) if number > OWN => Err(Fault::MachineState),
            Err(_) if name.starts_with('_') && own.is_none() => Err(Fault::MachineState),
            _ => Ok(own),
        }
    }

    pub fn is_set(&self, name: &str) -> bool {
        self.map(name).contains_key(name)
    }

    pub fn set(&mut self, name: &str, value: Option<f64>) -> Result<(), Fault> {
        if name.parse::<u32>().is_ok_and(|number| number > OWN || number == 0) {
            return Err(Fault::MachineState);
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

    /// A call begins, with `arguments` as #1 and so on.
    pub fn call(&mut self, arguments: &[f64]) {
        let numbered = (1..).zip(arguments).map(|(number, value): (u32, _)| (number.to_string(), *value));
        self.local.push(numbered.collect());
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
