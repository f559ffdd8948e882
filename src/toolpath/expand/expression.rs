//! Expressions of macros and what they are worth: LinuxCNC's and Fanuc's, angles in degrees.

use crate::toolpath::{
    expand::variables::Variables,
    model::gcode::{Dialect, Fault, MacroFault},
};

/// What two values may differ by and be equal, as for LinuxCNC.
const EQUAL: f64 = 1e-6;
/// Half of the last decimal of coordinates, in inches.
const LAST_PLACE: f64 = 5e-5;
/// The deepest brackets.
const DEEPEST: usize = 64;

type Found = Result<Option<f64>, Fault>;

/// A text of code, in capitals and without comments, read from the left.
pub(crate) struct Reader<'t> {
    text: &'t [u8],
    pub at: usize,
    variables: &'t Variables,
    depth: usize,
    /// Whether ROUND has changed a number beyond the decimals of coordinates.
    pub has_rounded: bool,
}

impl<'t> Reader<'t> {
    pub fn new(text: &'t str, at: usize, variables: &'t Variables) -> Reader<'t> {
        Reader { text: text.as_bytes(), at, variables, depth: 0, has_rounded: false }
    }

    pub fn skip_blanks(&mut self) {
        while self.text.get(self.at) == Some(&b' ') {
            self.at += 1;
        }
    }

    pub fn peek(&mut self) -> Option<u8> {
        self.skip_blanks();
        self.text.get(self.at).copied()
    }

    /// Takes `token` if it comes next.
    pub fn takes(&mut self, token: &str) -> bool {
        self.skip_blanks();
        let found = self.text[self.at..].starts_with(token.as_bytes());
        self.at += if found { token.len() } else { 0 };
        found
    }

    fn expect(&mut self, token: &'static str) -> Result<(), Fault> {
        if self.takes(token) { Ok(()) } else { Err(Fault::Macro(MacroFault::Expression { expected: token })) }
    }

    /// A number that must be there.
    pub fn number(&mut self) -> Result<f64, Fault> {
        self.value()?.ok_or(Fault::Macro(MacroFault::NoValue))
    }

    /// A value: a number, a variable, an expression in brackets, a function, any with signs; `None` is Fanuc's null.
    pub fn value(&mut self) -> Found {
        match self.peek() {
            Some(b'-') => {
                self.at += 1;
                self.deeper(|reader| reader.number().map(|value| Some(-value)))
            }
            Some(b'+') => {
                self.at += 1;
                self.deeper(Reader::value)
            }
            Some(b'[') => self.bracket(),
            Some(b'#') => {
                self.at += 1;
                let name = self.name()?;
                self.variables.get(&name)
            }
            Some(byte) if byte.is_ascii_digit() || byte == b'.' => self.literal(),
            _ => self.function(),
        }
    }

    fn deeper(&mut self, read: impl FnOnce(&mut Self) -> Found) -> Found {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(Fault::Macro(MacroFault::Expression { expected: "fewer brackets and signs" }));
        }
        let found = read(self);
        self.depth -= 1;
        found
    }

    /// What is assigned: Fanuc's needs no brackets.
    pub fn expression(&mut self) -> Found {
        self.binary(0)
    }

    /// `[ … ]`.
    pub fn bracket(&mut self) -> Found {
        self.expect("[")?;
        let found = self.deeper(|reader| reader.binary(0))?;
        self.expect("]")?;
        Ok(found)
    }

    fn literal(&mut self) -> Found {
        let rest = &self.text[self.at..];
        let length = rest.iter().take_while(|b| b.is_ascii_digit() || **b == b'.').count();
        self.at += length;
        let text = std::str::from_utf8(&rest[..length]).ok();
        text.and_then(|text| text.parse().ok()).map(Some).ok_or(Fault::NotAWord)
    }

    /// What follows `#`: the name of a variable.
    pub fn name(&mut self) -> Result<String, Fault> {
        if self.peek() == Some(b'<') {
            let rest = &self.text[self.at + 1..];
            let length =
                rest.iter().position(|b| *b == b'>').ok_or(Fault::Macro(MacroFault::Expression { expected: ">" }))?;
            self.at += length + 2;
            return Ok(String::from_utf8_lossy(&rest[..length]).replace(' ', ""));
        }
        let number = self.deeper(|reader| reader.number().map(Some))?.unwrap_or_default();
        match number.round() {
            whole if (whole - number).abs() < EQUAL && (0.0..=1e6).contains(&whole) => Ok(format!("{whole}")),
            _ => Err(Fault::Macro(MacroFault::Expression { expected: "a whole number after #" })),
        }
    }

    /// Operators that bind at `level` or closer, the loosest first.
    fn binary(&mut self, level: usize) -> Found {
        const LEVELS: [&[&str]; 5] =
            [&["AND", "OR", "XOR"], &["EQ", "NE", "GE", "GT", "LE", "LT"], &["+", "-"], &["*", "/", "MOD"], &["**"]];
        let Some(operators) = LEVELS.get(level) else { return self.value() };
        let mut left = self.binary(level + 1)?;
        loop {
            // `**` is no `*`.
            let is_power = self.peek() == Some(b'*') && self.text.get(self.at + 1) == Some(&b'*');
            let taken = operators.iter().find(|operator| (**operator != "*" || !is_power) && self.takes(operator));
            let Some(operator) = taken else { return Ok(left) };
            let right = self.binary(level + 1)?;
            let is_negative = |value: Option<f64>| value.is_some_and(|value| value < 0.0);
            // Fanuc's remainder is that of the amounts.
            if *operator == "MOD"
                && (is_negative(left) || is_negative(right))
                && self.variables.dialect != Dialect::LinuxCnc
            {
                return Err(Fault::Macro(MacroFault::Expression { expected: "MOD of no negative number" }));
            }
            left = Some(apply(operator, left, right)?);
        }
    }

    fn function(&mut self) -> Found {
        const NAMES: [&str; 14] =
            ["ABS", "ACOS", "ASIN", "ATAN", "COS", "EXISTS", "EXP", "FIX", "FUP", "LN", "ROUND", "SIN", "SQRT", "TAN"];
        let Some(name) = NAMES.iter().find(|name| self.takes(name)) else {
            return Err(Fault::Macro(MacroFault::Expression { expected: "a number, a variable, a function or [" }));
        };
        if *name == "EXISTS" {
            self.expect("[")?;
            self.expect("#")?;
            let name = self.name()?;
            self.expect("]")?;
            return Ok(Some(f64::from(u8::from(self.variables.is_set(&name)))));
        }
        let x = self.bracket()?.ok_or(Fault::Macro(MacroFault::NoValue))?;
        let value = match *name {
            "ABS" => x.abs(),
            "ACOS" => x.acos().to_degrees(),
            "ASIN" => x.asin().to_degrees(),
            "ATAN" => {
                self.expect("/")?;
                x.atan2(self.bracket()?.ok_or(Fault::Macro(MacroFault::NoValue))?).to_degrees()
            }
            "COS" => x.to_radians().cos(),
            "EXP" => x.exp(),
            // Fanuc rounds towards and from zero, LinuxCNC down and up.
            "FIX" | "FUP" if x < 0.0 => {
                return Err(Fault::Macro(MacroFault::Expression { expected: "FIX and FUP of no negative number" }));
            }
            "FIX" => x.floor(),
            "FUP" => x.ceil(),
            "LN" => x.ln(),
            "ROUND" => {
                self.has_rounded |= (x - x.round()).abs() >= LAST_PLACE;
                x.round()
            }
            "SIN" => x.to_radians().sin(),
            "SQRT" => x.sqrt(),
            _ => x.to_radians().tan(),
        };
        finite(value).map(Some)
    }
}

fn finite(value: f64) -> Result<f64, Fault> {
    if value.is_finite() { Ok(value) } else { Err(Fault::Macro(MacroFault::NotFinite)) }
}

fn apply(operator: &str, left: Option<f64>, right: Option<f64>) -> Result<f64, Fault> {
    let truth = |is: bool| Ok(f64::from(u8::from(is)));
    // Only whether it is null can be asked of null.
    let (a, b) = match (operator, left, right) {
        ("EQ", None, other) | ("EQ", other, None) => return truth(other.is_none()),
        ("NE", None, other) | ("NE", other, None) => return truth(other.is_some()),
        (_, Some(a), Some(b)) => (a, b),
        _ => return Err(Fault::Macro(MacroFault::NoValue)),
    };
    let equal = (a - b).abs() < EQUAL;
    // Fanuc's work on bits, LinuxCNC's on truths: of 0 and 1 they are the same.
    if matches!(operator, "AND" | "OR" | "XOR") && [a, b].iter().any(|value| *value != 0.0 && *value != 1.0) {
        return Err(Fault::Macro(MacroFault::Expression { expected: "AND, OR and XOR of comparisons" }));
    }
    match operator {
        "AND" => truth(a != 0.0 && b != 0.0),
        "OR" => truth(a != 0.0 || b != 0.0),
        "XOR" => truth((a != 0.0) != (b != 0.0)),
        "EQ" => truth(equal),
        "NE" => truth(!equal),
        "GE" => truth(a >= b),
        "GT" => truth(a > b),
        "LE" => truth(a <= b),
        "LT" => truth(a < b),
        "+" => finite(a + b),
        "-" => finite(a - b),
        "*" => finite(a * b),
        "/" => finite(a / b),
        "MOD" => finite(a.rem_euclid(b)),
        _ => finite(a.powf(b)),
    }
}
