//! Values of robot programs: numbers, truths, texts and lists of them, and what operators make of them.

use crate::toolpath::model::robot::RobotFault;

/// A value that a program computes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    Number(f64),
    Truth(bool),
    /// A string, with its quotes.
    Text(String),
    /// A record or an array: its parts in order.
    List(Vec<Value>),
}

/// Numbers of controllers have seven digits: those whose difference is a smaller share, and yet differ, may be equal to a controller or not.
const NEARLY_EQUAL: f64 = 1e-6;

impl Value {
    /// Returns the number; `Err` for other values.
    pub fn number(&self) -> Result<f64, RobotFault> {
        match self {
            Value::Number(number) if number.is_finite() => Ok(*number),
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

    /// Returns a list of numbers.
    pub fn list(numbers: impl IntoIterator<Item = f64>) -> Value {
        Value::List(numbers.into_iter().map(Value::Number).collect())
    }

    /// Applies the binary `operator` (in capitals) to this and `other`.
    pub fn apply(&self, operator: &str, other: &Value) -> Result<Value, RobotFault> {
        match operator {
            "AND" | "OR" | "XOR" => {
                let (a, b) = (self.truth()?, other.truth()?);
                return Ok(Value::Truth(match operator {
                    "AND" => a && b,
                    "OR" => a || b,
                    _ => a != b,
                }));
            }
            "=" | "<>" => return Ok(Value::Truth(self.is_equal(other)? == (operator == "="))),
            _ => {}
        }
        match (self, other) {
            (Value::List(a), Value::List(b)) if a.len() == b.len() && matches!(operator, "+" | "-") => {
                let parts = a.iter().zip(b).map(|(a, b)| Ok(Value::Number(sum(operator, a.number()?, b.number()?))));
                parts.collect::<Result<_, _>>().map(Value::List)
            }
            (Value::Text(a), Value::Text(b)) if operator == "+" => {
                Ok(Value::Text(format!("{}{}", a.trim_end_matches('"'), b.trim_start_matches('"'))))
            }
            _ => self.apply_to_numbers(operator, other),
        }
    }

    /// Applies an operator between numbers.
    fn apply_to_numbers(&self, operator: &str, other: &Value) -> Result<Value, RobotFault> {
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
            (Value::Number(a), Value::Number(b)) if a == b || differs_clearly(*a, *b) => Ok(a == b),
            (Value::Number(_), Value::Number(_)) => Err(NEAR),
            (Value::Truth(a), Value::Truth(b)) => Ok(a == b),
            (Value::Text(a), Value::Text(b)) => Ok(a == b),
            _ => Err(RobotFault::Form { expected: "two numbers, two truths or two strings" }),
        }
    }
}

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
