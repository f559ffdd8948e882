//! The parameters sought: found by name, and the coordinates in which they are sought.

use crate::{
    input::{check::Check, error::Result},
    machine::{Machine, Parameter, Unit},
};

/// A parameter sought.
#[derive(Debug, Clone, PartialEq)]
pub struct Unknown {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: Unit,
    /// Its value in the machine of the study.
    pub start: f64,
    /// The coordinate in which it is sought.
    pub coordinate: Coordinate,
}

/// A coordinate that is 0 where the search starts; a unit of it is a change that would be noticed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Coordinate {
    /// The logarithm of value over start, of what must stay positive: stiffnesses, elastic constants, masses, backlash.
    Logarithm,
    /// The change over this many units.
    Linear(f64),
}

impl Unknown {
    fn new(parameter: Parameter, check: &Check) -> Result<Self> {
        let Parameter { name, value: Some(start), unit, .. } = parameter else {
            let problem = format!("{} is \"unknown\" in the machine file: expected an initial value", parameter.name);
            return check.fail(problem);
        };
        let positive = [Unit::N_PER_MM, Unit::NMM_PER_RAD, Unit::N_PER_MM2, Unit::KG];
        let is_positive = positive.contains(&unit) || name.ends_with(".backlash");
        let coordinate = match unit {
            _ if is_positive && start > 0.0 => Coordinate::Logarithm,
            Unit::MM | Unit::DEG => Coordinate::Linear(1.0),
            _ if start == 0.0 => Coordinate::Linear(1.0),
            _ => Coordinate::Linear(start.abs()),
        };
        Ok(Self { name, unit, start, coordinate })
    }

    /// How far from the start it is sought, in its coordinate: a factor of a thousand; a metre; an angle that is still an error.
    pub(super) fn farthest(&self) -> f64 {
        match self.coordinate {
            Coordinate::Logarithm => 7.0,
            Coordinate::Linear(_) if self.unit == Unit::DEG => 29.0,
            Coordinate::Linear(_) => 1000.0,
        }
    }

    /// Whether it is not sought beyond `x`.
    pub fn is_at_end(&self, x: f64) -> bool {
        x.abs() >= self.farthest()
    }

    /// The longest step of its coordinate that a search takes.
    pub(super) fn longest_step(&self) -> f64 {
        match self.coordinate {
            Coordinate::Logarithm => 1.0,
            Coordinate::Linear(_) => 50.0,
        }
    }

    /// Its value at `x`.
    pub fn value(&self, x: f64) -> f64 {
        match self.coordinate {
            Coordinate::Logarithm => self.start * x.exp(),
            Coordinate::Linear(scale) => self.start + scale * x,
        }
    }

    /// Where its value is `value`; `None` where it cannot be.
    pub fn at(&self, value: f64) -> Option<f64> {
        match self.coordinate {
            Coordinate::Logarithm => (value > 0.0).then(|| (value / self.start).ln()),
            Coordinate::Linear(scale) => Some((value - self.start) / scale),
        }
    }

    /// What a unit of its coordinate is: `ln` of a factor, or the unit of its value where that is changed by it.
    pub fn coordinate_unit(&self) -> String {
        match self.coordinate {
            Coordinate::Logarithm => "ln of the factor".into(),
            Coordinate::Linear(1.0) => self.unit.in_files().into(),
            Coordinate::Linear(scale) => format!("{scale} {}", self.unit.in_files()).trim_end().into(),
        }
    }

    /// Change of the value per unit of the coordinate at `x`.
    pub fn slope(&self, x: f64) -> f64 {
        match self.coordinate {
            Coordinate::Logarithm => self.value(x),
            Coordinate::Linear(scale) => scale,
        }
    }
}

/// Whether `pattern`, in which `*` stands for any letters but a dot, is `name`.
pub fn is_pattern_of(pattern: &str, name: &str) -> bool {
    match pattern.split_once('*') {
        None => pattern == name,
        Some((before, rest)) => name.strip_prefix(before).is_some_and(|left| {
            let ends = left.char_indices().map(|(at, _)| at).chain([left.len()]);
            ends.take_while(|&end| !left[..end].contains('.')).any(|end| is_pattern_of(rest, &left[end..]))
        }),
    }
}

/// The parameters of `machine` that `patterns` name, each once, in the order of the patterns.
pub(crate) fn unknowns(machine: &Machine, patterns: &[String], check: &Check) -> Result<Vec<Unknown>> {
    let all = machine.parameters();
    let mut found: Vec<Unknown> = Vec::new();
    for (i, pattern) in patterns.iter().enumerate() {
        let check = check.item(i);
        let named: Vec<&Parameter> = all.iter().filter(|parameter| is_pattern_of(pattern, &parameter.name)).collect();
        if named.is_empty() {
            // Says the nearest names.
            let error = machine.parameter(pattern).err().map_or_else(String::new, |error| error.to_string());
            return check.fail(error);
        }
        for parameter in named {
            if !found.iter().any(|other| other.name == parameter.name) {
                found.push(Unknown::new(parameter.clone(), &check)?);
            }
        }
    }
    match found.len() {
        0 => check.fail("must name at least one parameter, got none".into()),
        1..=MOST => {
            let names: Vec<&str> = found.iter().map(|unknown| unknown.name.as_str()).collect();
            machine.variations(&names).or_else(|error| check.fail(error.to_string()))?;
            Ok(found)
        }
        count => check.fail(format!("must name at most {MOST} parameters, got {count}")),
    }
}

/// Most parameters that are sought together.
const MOST: usize = 200;
