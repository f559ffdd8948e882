//! Values of robot programs: numbers, truths, texts and lists of them, and what operators make of them.

use nalgebra::{Isometry3, Translation3};

use crate::{
    expand::robot::expression::KRL_PARTS,
    model::robot::{RobotFault, abc_of_rotation, rotation_of_abc},
};

/// A value that a program computes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    Number(f64),
    /// An INT of KRL, whose quotients are whole.
    Integer(i32),
    Truth(bool),
    /// A string, with its quotes.
    Text(String),
    /// A record or an array: its parts in order. A record of KRL has all of [`KRL_PARTS`].
    List(Vec<Value>),
    /// A part or an element that has no value yet.
    Unknown,
}

/// Numbers of controllers have seven digits: those whose difference is a smaller share, and yet differ, may be equal to a controller or not.
const NEARLY_EQUAL: f64 = 1e-6;

/// Longest text.
const MAX_BYTES: usize = 10_000;

impl Value {
    /// Returns the number; `Err` for other values.
    pub fn number(&self) -> Result<f64, RobotFault> {
        match self {
            Value::Number(number) if number.is_finite() => Ok(*number),
            Value::Integer(number) => Ok(f64::from(*number)),
            Value::Unknown => Err(RobotFault::NoValue { name: "a part or element".to_owned() }),
            _ => Err(RobotFault::Form { expected: "a finite number" }),
        }
    }

    /// Returns the truth; `Err` for other values.
    pub fn truth(&self) -> Result<bool, RobotFault> {
        match self {
            Value::Truth(truth) => Ok(*truth),
            _ => Err(RobotFault::Form { expected: "a condition that is TRUE or FALSE" }),
        }
    }

    /// Returns the whole number, as counters and indices are; `Err` for other values.
    pub fn whole(&self) -> Result<usize, RobotFault> {
        let number = self.number()?;
        let is_whole = number.fract() == 0.0 && (0.0..=1e6).contains(&number);
        if is_whole { Ok(number as usize) } else { Err(RobotFault::Form { expected: "a whole number from 0 on" }) }
    }

    /// Returns `N` numbers of a list; `Err` if it is not one of so many numbers.
    pub fn numbers<const N: usize>(&self) -> Result<[f64; N], RobotFault> {
        const EXPECTED: RobotFault = RobotFault::Form { expected: "numbers in brackets, as many as the type has" };
        let Value::List(parts) = self else { return Err(EXPECTED) };
        let mut numbers = [0.0; N];
        if parts.len() != N {
            return Err(EXPECTED);
        }
        for (number, part) in numbers.iter_mut().zip(parts) {
            *number = part.number()?;
        }
        Ok(numbers)
    }

    /// Returns the part with index `at` (from 0); `Err` if there is none.
    pub fn part(&mut self, at: usize) -> Result<&mut Value, RobotFault> {
        let part = if let Value::List(parts) = self { parts.get_mut(at) } else { None };
        part.ok_or(RobotFault::Form { expected: "an index or part that the value has" })
    }

    /// Returns about how many bytes the value takes.
    pub fn size(&self) -> usize {
        match self {
            Value::List(parts) => parts.iter().map(Value::size).sum(),
            Value::Text(text) => text.len(),
            _ => size_of::<Value>(),
        }
    }

    /// Returns a list of numbers.
    pub fn list(numbers: impl IntoIterator<Item = f64>) -> Value {
        Value::List(numbers.into_iter().map(Value::Number).collect())
    }

    /// Returns a whole number of KRL; `Err` for one of more than 32 bits.
    pub fn integer(number: f64) -> Result<Value, RobotFault> {
        match f64::from(i32::MIN) <= number && number <= f64::from(i32::MAX) {
            true => Ok(Value::Integer(number as i32)),
            false => Err(WHOLE),
        }
    }

    /// Returns a record of KRL whose parts have no values.
    pub fn record() -> Value {
        Value::List(vec![Value::Unknown; KRL_PARTS.len()])
    }

    /// Returns the value that a datum of the KRL type `kind` takes when this is assigned.
    pub fn taken_as(self, kind: &str) -> Result<Value, RobotFault> {
        let kept = match kind {
            "FRAME" => 0..6,
            "POS" => 0..8,
            "E6POS" => 0..14,
            "AXIS" => 14..20,
            "E6AXIS" => 8..20,
            _ => 0..KRL_PARTS.len(),
        };
        match (kind, self) {
            ("REAL", Value::Integer(number)) => Ok(Value::Number(f64::from(number))),
            // To the nearest, where that does not depend on how the controller rounds.
            ("INT", Value::Number(number)) if (number.fract().abs() - 0.5).abs() > 1e-4 => {
                Value::integer(number.round())
            }
            ("INT", Value::Number(_)) => Err(WHOLE),
            (_, Value::List(mut parts)) if parts.len() == KRL_PARTS.len() => {
                let others = parts.iter_mut().enumerate().filter(|(at, _)| !kept.contains(at));
                others.for_each(|(_, part)| *part = Value::Unknown);
                Ok(Value::List(parts))
            }
            (_, value) => Ok(value),
        }
    }

    /// Returns the pose of a frame or point of KRL, mm.
    pub fn pose(&self) -> Result<Isometry3<f64>, RobotFault> {
        const EXPECTED: RobotFault = RobotFault::Form { expected: "a frame or point with X, Y, Z, A, B and C" };
        let Value::List(parts) = self else { return Err(EXPECTED) };
        let number = |at: usize| parts.get(at).and_then(|part| part.number().ok());
        if (8..14).any(|axis| number(axis).is_some_and(|number| number != 0.0)) {
            return RobotFault::not_followed("operators on points with external axes are", "external axes at 0");
        }
        let three = |from: usize| Some([number(from)?, number(from + 1)?, number(from + 2)?]);
        let (Some([x, y, z]), Some(abc)) = (three(0), three(3)) else { return Err(EXPECTED) };
        Ok(Isometry3::from_parts(Translation3::new(x, y, z), rotation_of_abc(abc)))
    }

    /// Applies the geometric operator of KRL: `other` is given in the frame that this is.
    fn combined(&self, other: &Value) -> Result<Value, RobotFault> {
        let pose = self.pose()? * other.pose()?;
        let abc = abc_of_rotation(&pose.rotation, 0.0);
        // What else the position has, it keeps: status, turns and external axes.
        let mut value = other.clone();
        for (at, number) in pose.translation.vector.iter().copied().chain(abc).enumerate() {
            *value.part(at)? = Value::Number(number);
        }
        Ok(value)
    }

    /// Applies the binary `operator` (in capitals) to this and `other`.
    pub fn apply(&self, operator: &str, other: &Value) -> Result<Value, RobotFault> {
        match operator {
            "AND" | "OR" | "XOR" | "EXOR" => {
                let (a, b) = (self.truth()?, other.truth()?);
                return Ok(Value::Truth(match operator {
                    "AND" => a && b,
                    "OR" => a || b,
                    _ => a != b,
                }));
            }
            "=" | "==" | "<>" => return Ok(Value::Truth(self.is_equal(other)? == (operator != "<>"))),
            ":" => return self.combined(other),
            _ => {}
        }
        match (self, other) {
            (Value::List(a), Value::List(b)) if a.len() == b.len() && matches!(operator, "+" | "-") => {
                let parts = a.iter().zip(b).map(|(a, b)| Ok(Value::Number(sum(operator, a.number()?, b.number()?))));
                parts.collect::<Result<_, _>>().map(Value::List)
            }
            (Value::Text(a), Value::Text(b)) if operator == "+" && a.len() + b.len() <= MAX_BYTES => {
                Ok(Value::Text(format!("{}{}", a.trim_end_matches('"'), b.trim_start_matches('"'))))
            }
            _ => self.apply_to_numbers(operator, other),
        }
    }

    /// Applies an operator between numbers.
    fn apply_to_numbers(&self, operator: &str, other: &Value) -> Result<Value, RobotFault> {
        if let (Value::Integer(a), Value::Integer(b)) = (self, other)
            && matches!(operator, "+" | "-" | "*" | "/")
        {
            let number = match operator {
                "+" => a.checked_add(*b),
                "-" => a.checked_sub(*b),
                "*" => a.checked_mul(*b),
                _ => a.checked_div(*b),
            };
            return number.map(Value::Integer).ok_or(WHOLE);
        }
        let (a, b) = (self.number()?, other.number()?);
        let is_ordered = |a: f64, b: f64| match a == b || differs_clearly(a, b) {
            true => Ok(()),
            false => Err(NEAR),
        };
        let number = match operator {
            "<" | ">" | "<=" | ">=" => {
                is_ordered(a, b)?;
                return Ok(Value::Truth(match operator {
                    "<" => a < b,
                    ">" => a > b,
                    "<=" => a <= b,
                    _ => a >= b,
                }));
            }
            "+" | "-" => sum(operator, a, b),
            "*" => a * b,
            "/" => a / b,
            "DIV" | "MOD" => {
                if a.fract() != 0.0 || b.fract() != 0.0 || a < 0.0 || b <= 0.0 {
                    return Err(RobotFault::Form { expected: "DIV and MOD of whole numbers that are not negative" });
                }
                if operator == "DIV" { (a / b).trunc() } else { a % b }
            }
            _ => return Err(RobotFault::Form { expected: "an operator between numbers" }),
        };
        Value::Number(number).number().map(Value::Number)
    }

    /// Whether two values are the same; `Err` for numbers that may or may not be, and for values of two kinds.
    pub fn is_equal(&self, other: &Value) -> Result<bool, RobotFault> {
        match (self, other) {
            (Value::Number(_) | Value::Integer(_), Value::Number(_) | Value::Integer(_)) => {
                let (a, b) = (self.number()?, other.number()?);
                if a == b || differs_clearly(a, b) { Ok(a == b) } else { Err(NEAR) }
            }
            (Value::Truth(a), Value::Truth(b)) => Ok(a == b),
            (Value::Text(a), Value::Text(b)) => Ok(a == b),
            _ => Err(RobotFault::Form { expected: "two numbers, two truths or two strings" }),
        }
    }
}

/// Fault of whole numbers that KRL does not have.
const WHOLE: RobotFault =
    RobotFault::Form { expected: "a whole number of 32 bits that is certain, and no division by 0" };

/// Fault of numbers that a controller may round to the same.
const NEAR: RobotFault = RobotFault::Form { expected: "numbers that are equal, or differ by more than rounding" };

/// Whether two numbers differ by more than rounding.
fn differs_clearly(a: f64, b: f64) -> bool {
    (a - b).abs() > NEARLY_EQUAL * a.abs().max(b.abs())
}

/// Returns the sum or the difference of two numbers.
fn sum(operator: &str, a: f64, b: f64) -> f64 {
    if operator == "+" { a + b } else { a - b }
}
