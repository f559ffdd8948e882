//! Macro variables, numbered and named, common or local to a call.

use std::collections::BTreeMap;

use crate::model::gcode::{Dialect, Fault, MacroFault};

/// Values of all variables that are set.
#[derive(Debug)]
pub(crate) struct Variables {
    common: BTreeMap<String, f64>,
    /// Local variables of each call, the innermost last.
    local: Vec<BTreeMap<String, f64>>,
    /// Kinds of declared variables (DEF INT, DEF BOOL), by the number of scopes in which they are.
    kinds: BTreeMap<(usize, String), Kind>,
    /// Dialect whose rules the expressions follow.
    pub dialect: Dialect,
}

/// Kind of a variable that Sinumerik's DEF or PROC declares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    Real,
    /// Values are rounded.
    Int,
    /// All but 0 is 1.
    Bool,
}

impl Kind {
    /// Returns `value` as a variable of this kind holds it.
    pub fn converted(self, value: f64) -> f64 {
        match self {
            Kind::Real => value,
            Kind::Int => value.round(),
            Kind::Bool => f64::from(u8::from(value != 0.0)),
        }
    }
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
        Variables { common: BTreeMap::new(), local: vec![BTreeMap::new()], kinds: BTreeMap::new(), dialect }
    }

    /// Returns the value of the variable `name`, `None` if it is not set. `Err` for system variables.
    pub fn get(&self, name: &str) -> Result<Option<f64>, Fault> {
        let value = self.scope(name).get(name).copied();
        match name.parse::<u32>() {
            _ if !self.dialect.is_iso() => Ok(value),
            Ok(number) if number > LAST_OWN => Err(Fault::Macro(MacroFault::MachineState)),
            Err(_) if name.starts_with('_') && value.is_none() => Err(Fault::Macro(MacroFault::MachineState)),
            _ => Ok(value),
        }
    }

    /// Whether `#name` has a value.
    pub fn is_set(&self, name: &str) -> bool {
        self.scope(name).contains_key(name)
    }

    /// Sets the variable `name`, or removes it by `None`. `Err` for system variables, and those that Sinumerik's DEF has not declared.
    pub fn set(&mut self, name: &str, value: Option<f64>) -> Result<(), Fault> {
        if name.parse::<u32>().is_ok_and(|number| number > LAST_OWN || number == 0) {
            return Err(Fault::Macro(MacroFault::MachineState));
        }
        let kind = self.kinds.get(&(self.local.len(), name.to_owned())).copied();
        if self.dialect == Dialect::Sinumerik && kind.is_none() && is_local(self.dialect, name) {
            return Err(Fault::Macro(MacroFault::Undeclared));
        }
        let value = value.map(|value| kind.unwrap_or(Kind::Real).converted(value));
        let is_local = is_local(self.dialect, name);
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

    /// Declares the variable `name` in the innermost call, with its initial `value`.
    pub fn declare(&mut self, name: &str, kind: Kind, value: f64) -> Result<(), Fault> {
        self.kinds.insert((self.local.len(), name.to_owned()), kind);
        self.set(name, Some(value))
    }

    /// Whether the variable or array `name` is declared in the innermost call.
    pub fn is_declared(&self, name: &str) -> bool {
        let is_key = |name: &str| self.kinds.contains_key(&(self.local.len(), name.to_owned()));
        !self.kinds.is_empty() && (is_key(name) || is_key(&format!("{name}[0]")))
    }

    /// Begins a call with `arguments` by the names of their variables.
    pub fn call(&mut self, arguments: &Arguments) {
        self.local.push(values(arguments));
        let depth = self.local.len();
        self.kinds.extend(arguments.iter().map(|(name, kind, _)| ((depth, name.clone()), *kind)));
    }

    /// Whether the local variables of the innermost call are still its `arguments`.
    pub fn has_arguments(&self, arguments: &Arguments) -> bool {
        self.local.last() == Some(&values(arguments))
    }

    /// Ends the innermost call.
    pub fn end_call(&mut self) {
        if self.local.len() > 1 {
            self.kinds.retain(|(scopes, _), _| *scopes < self.local.len());
            self.local.pop();
        }
    }

    /// Returns the variables among which `name` belongs: those of the innermost call if it is local, else the common ones.
    fn scope(&self, name: &str) -> &BTreeMap<String, f64> {
        match self.local.last() {
            Some(local) if is_local(self.dialect, name) => local,
            _ => &self.common,
        }
    }
}

/// Arguments of a call: name and kind of each variable, and its value.
pub(crate) type Arguments = Vec<(String, Kind, f64)>;

/// Returns the values of arguments by the names of their variables.
fn values(arguments: &Arguments) -> BTreeMap<String, f64> {
    arguments.iter().map(|(name, _, value)| (name.clone(), *value)).collect()
}

/// Whether `name` is local: #1 to #33 and names without a leading `_`, Sinumerik's names other than R1, Heidenhain's QL.
fn is_local(dialect: Dialect, name: &str) -> bool {
    match dialect {
        Dialect::Sinumerik => !is_r_parameter(name),
        Dialect::Heidenhain => name.starts_with("QL"),
        _ => name.parse::<u32>().map_or(!name.starts_with('_'), |number| number <= LAST_LOCAL),
    }
}

/// Whether `name` is one of Sinumerik's R parameters: R1.
pub(crate) fn is_r_parameter(name: &str) -> bool {
    name.strip_prefix('R').is_some_and(|number| number.parse::<u32>().is_ok())
}

/// Returns the number of the variable that takes the value after `letter` in Fanuc's G65 (first kind of arguments), if there is one.
pub(crate) fn argument_variable(letter: char) -> Option<u32> {
    // #10, #12 and #14 to #16 have none.
    let at = "ABCIJKDEF-H-M---QRSTUVWXYZ".find(letter).filter(|_| letter != '-')?;
    u32::try_from(at + 1).ok()
}
