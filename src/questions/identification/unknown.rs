//! Unknown parameters: chosen by name patterns, and the coordinates in which they are fitted.

use crate::{
    input::{check::Check, error::Result},
    machine::{Machine, Parameter, Unit, is_pattern_of},
};

/// A parameter to identify.
#[derive(Debug, Clone, PartialEq)]
pub struct Unknown {
    /// Name of the parameter in the machine.
    pub name: String,
    /// Unit of its value.
    pub unit: Unit,
    /// Value in the machine of the study, where the fit starts.
    pub start: f64,
    /// Coordinate in which it is fitted.
    pub coordinate: Coordinate,
}

/// How a parameter is mapped to a coordinate that is 0 at its start value and in which 1 is a noticeable change.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Coordinate {
    /// Logarithm of value over start, for what must stay positive: stiffnesses, elastic constants, masses, backlash.
    Logarithm,
    /// Change of the value, divided by this number of its units.
    Linear(f64),
}

impl Unknown {
    /// Makes an unknown of `parameter` and chooses its coordinate; `Err` if it has no value to start from.
    fn new(parameter: Parameter, check: &Check) -> Result<Self> {
        let Parameter { name, value: Some(start), unit, .. } = parameter else {
            let problem = format!("{} is \"unknown\" in the machine file: expected an initial value", parameter.name);
            return check.fail(problem);
        };
        let is_positive = unit.is_stiffness() || unit == Unit::KG || name.ends_with(".backlash");
        let coordinate = match unit {
            _ if is_positive && start > 0.0 => Coordinate::Logarithm,
            Unit::MM | Unit::DEG => Coordinate::Linear(1.0),
            _ if start == 0.0 => Coordinate::Linear(1.0),
            _ => Coordinate::Linear(start.abs()),
        };
        Ok(Self { name, unit, start, coordinate })
    }

    /// Returns the largest coordinate, either way, in a fit: a factor of a thousand, a metre, or an angle that is still an error.
    pub(super) fn search_limit(&self) -> f64 {
        match self.coordinate {
            Coordinate::Logarithm => 7.0,
            Coordinate::Linear(_) if self.unit == Unit::DEG => 29.0,
            Coordinate::Linear(_) => 1000.0,
        }
    }

    /// Whether coordinate `x` is at or beyond the limit within which the parameter is searched.
    pub fn is_at_limit(&self, x: f64) -> bool {
        x.abs() >= self.search_limit()
    }

    /// Returns the longest step of the coordinate in one iteration of a fit.
    pub(super) fn longest_step(&self) -> f64 {
        match self.coordinate {
            Coordinate::Logarithm => 1.0,
            Coordinate::Linear(_) => 50.0,
        }
    }

    /// Returns the value of the parameter at coordinate `x`, in its unit.
    pub fn value(&self, x: f64) -> f64 {
        match self.coordinate {
            Coordinate::Logarithm => self.start * libm::exp(x),
            Coordinate::Linear(scale) => self.start + scale * x,
        }
    }

    /// Returns the coordinate at which the parameter has `value`; `None` where it cannot have it.
    pub fn coordinate_at(&self, value: f64) -> Option<f64> {
        match self.coordinate {
            Coordinate::Logarithm => (value > 0.0).then(|| libm::log(value / self.start)),
            Coordinate::Linear(scale) => Some((value - self.start) / scale),
        }
    }

    /// Returns the unit of the coordinate for tables: `ln` of a factor, or the unit of the value with its scale.
    pub fn coordinate_unit(&self) -> String {
        match self.coordinate {
            Coordinate::Logarithm => "ln of the factor".into(),
            Coordinate::Linear(1.0) => self.unit.in_files().into(),
            Coordinate::Linear(scale) => format!("{scale} {}", self.unit.in_files()).trim_end().into(),
        }
    }

    /// Returns the derivative of the value by the coordinate at coordinate `x`, in the unit of the parameter.
    pub fn slope(&self, x: f64) -> f64 {
        match self.coordinate {
            Coordinate::Logarithm => self.value(x),
            Coordinate::Linear(scale) => scale,
        }
    }
}

/// Returns the parameters of `machine` that match `patterns`, each once, in that order. `Err` if there are none, too many, or unfit ones.
pub(crate) fn unknowns(machine: &Machine, patterns: &[String], check: &Check) -> Result<Vec<Unknown>> {
    let all = machine.parameters();
    let mut matched: Vec<Unknown> = Vec::new();
    for (i, pattern) in patterns.iter().enumerate() {
        let check = check.item(i);
        let named: Vec<&Parameter> = all.iter().filter(|parameter| is_pattern_of(pattern, &parameter.name)).collect();
        if named.is_empty() {
            // Says the nearest names.
            let error = machine.parameter(pattern).err().map_or_else(String::new, |error| error.to_string());
            check.misfit(error, ())?;
        }
        for parameter in named {
            if !matched.iter().any(|other| other.name == parameter.name) {
                matched.push(Unknown::new(parameter.clone(), &check)?);
            }
        }
    }
    match matched.len() {
        0 if patterns.is_empty() => check.fail("must name at least one parameter, got none".into()),
        0..=MOST => {
            let names: Vec<&str> = matched.iter().map(|unknown| unknown.name.as_str()).collect();
            machine.variations(&names).or_else(|error| check.fail(error.to_string()))?;
            Ok(matched)
        }
        count => check.fail(format!("must name at most {MOST} parameters, got {count}")),
    }
}

/// Most parameters that are sought together.
const MOST: usize = 200;
