//! Macro expressions of LinuxCNC and Fanuc, with angles in degrees.

use crate::toolpath::{
    expand::variables::Variables,
    model::gcode::{Dialect, Fault, MacroFault},
};

/// Values that differ by less are equal, as in LinuxCNC.
const EQUAL: f64 = 1e-6;
/// Half of the last decimal of coordinates, in inches.
const LAST_PLACE: f64 = 5e-5;
/// Most nested brackets and signs.
const DEEPEST: usize = 64;

/// A value; `None` is Fanuc's null.
type MacroValue = Result<Option<f64>, Fault>;

/// A cursor over code in upper case without comments, which evaluates what it reads.
pub(crate) struct Reader<'t> {
    text: &'t [u8],
    /// Index of the next byte.
    pub at: usize,
    variables: &'t Variables,
    depth: usize,
    /// Whether ROUND has changed a number by more than half the last decimal of coordinates.
    pub has_rounded: bool,
}

impl<'t> Reader<'t> {
    /// Starts at byte `at` of `text`.
    pub fn new(text: &'t str, at: usize, variables: &'t Variables) -> Reader<'t> {
        Reader { text: text.as_bytes(), at, variables, depth: 0, has_rounded: false }
    }

    /// Skips blanks.
    pub fn skip_blanks(&mut self) {
        while self.text.get(self.at) == Some(&b' ') {
            self.at += 1;
        }
    }

    /// Skips blanks and returns the next byte without taking it.
    pub fn peek(&mut self) -> Option<u8> {
        self.skip_blanks();
        self.text.get(self.at).copied()
    }

    /// Skips blanks and takes `token` if it comes next; returns whether it did.
    pub fn takes(&mut self, token: &str) -> bool {
        self.skip_blanks();
        let found = self.text[self.at..].starts_with(token.as_bytes());
        self.at += if found { token.len() } else { 0 };
        found
    }

    /// Skips blanks and takes `token`; `Err` if something else comes next.
    fn expect(&mut self, token: &'static str) -> Result<(), Fault> {
        if self.takes(token) { Ok(()) } else { Err(Fault::Macro(MacroFault::Expression { expected: token })) }
    }

    /// Reads a value that must not be null.
    pub fn number(&mut self) -> Result<f64, Fault> {
        self.value()?.ok_or(Fault::Macro(MacroFault::NoValue))
    }

    /// Reads a value: a number, a variable, an expression in brackets or a function, any of them with signs.
    pub fn value(&mut self) -> MacroValue {
        match self.peek() {
            Some(b'-') => {
                self.at += 1;
                self.nested(|reader| reader.number().map(|value| Some(-value)))
            }
            Some(b'+') => {
                self.at += 1;
                self.nested(Reader::value)
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

    /// Applies `read` one level deeper; `Err` beyond [`DEEPEST`] levels.
    fn nested(&mut self, read: impl FnOnce(&mut Self) -> MacroValue) -> MacroValue {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(Fault::Macro(MacroFault::Expression { expected: "fewer brackets and signs" }));
        }
        let found = read(self);
        self.depth -= 1;
        found
    }

    /// Reads an expression without brackets around it, as on the right of Fanuc's `=`.
    pub fn expression(&mut self) -> MacroValue {
        self.binary(0)
    }

    /// Reads an expression in brackets, `[ … ]`, and returns its value.
    pub fn bracket(&mut self) -> MacroValue {
        self.expect("[")?;
        let found = self.nested(|reader| reader.binary(0))?;
        self.expect("]")?;
        Ok(found)
    }

    /// Reads a plain number without sign.
    fn literal(&mut self) -> MacroValue {
        let rest = &self.text[self.at..];
        let length = rest.iter().take_while(|b| b.is_ascii_digit() || **b == b'.').count();
        self.at += length;
        let text = std::str::from_utf8(&rest[..length]).ok();
        text.and_then(|text| text.parse().ok()).map(Some).ok_or(Fault::NotAWord)
    }

    /// Reads the name of a variable behind `#`: `<name>`, or a number, which may be computed.
    pub fn name(&mut self) -> Result<String, Fault> {
        if self.peek() == Some(b'<') {
            let rest = &self.text[self.at + 1..];
            let length =
                rest.iter().position(|b| *b == b'>').ok_or(Fault::Macro(MacroFault::Expression { expected: ">" }))?;
            self.at += length + 2;
            return Ok(String::from_utf8_lossy(&rest[..length]).replace(' ', ""));
        }
        let number = self.nested(|reader| reader.number().map(Some))?.unwrap_or_default();
        match number.round() {
            whole if (whole - number).abs() < EQUAL && (0.0..=1e6).contains(&whole) => Ok(format!("{whole}")),
            _ => Err(Fault::Macro(MacroFault::Expression { expected: "a whole number after #" })),
        }
    }

    /// Reads operands and the binary operators that bind at `level` (0 the loosest) or closer, and returns the value.
    fn binary(&mut self, level: usize) -> MacroValue {
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
            left = Some(apply_operator(operator, left, right)?);
        }
    }

    /// Reads a function with its argument in brackets, and returns its value; angles are in degrees.
    fn function(&mut self) -> MacroValue {
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
            "ACOS" => libm::acos(x).to_degrees(),
            "ASIN" => libm::asin(x).to_degrees(),
            "ATAN" => {
                self.expect("/")?;
                libm::atan2(x, self.bracket()?.ok_or(Fault::Macro(MacroFault::NoValue))?).to_degrees()
            }
            "COS" => libm::cos(x.to_radians()),
            "EXP" => libm::exp(x),
            // Fanuc rounds towards and from zero, LinuxCNC down and up.
            "FIX" | "FUP" if x < 0.0 => {
                return Err(Fault::Macro(MacroFault::Expression { expected: "FIX and FUP of no negative number" }));
            }
            "FIX" => x.floor(),
            "FUP" => x.ceil(),
            "LN" => libm::log(x),
            "ROUND" => {
                self.has_rounded |= (x - x.round()).abs() >= LAST_PLACE;
                x.round()
            }
            "SIN" => libm::sin(x.to_radians()),
            "SQRT" => x.sqrt(),
            _ => libm::tan(x.to_radians()),
        };
        check_finite(value).map(Some)
    }
}

/// Returns `value`; `Err` if it is not finite.
fn check_finite(value: f64) -> Result<f64, Fault> {
    if value.is_finite() { Ok(value) } else { Err(Fault::Macro(MacroFault::NotFinite)) }
}

/// Returns the value of a binary operator; comparisons and logic give 1 or 0. `Err` for null (`None`) in arithmetic, or no finite value.
fn apply_operator(operator: &str, left: Option<f64>, right: Option<f64>) -> Result<f64, Fault> {
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
        "+" => check_finite(a + b),
        "-" => check_finite(a - b),
        "*" => check_finite(a * b),
        "/" => check_finite(a / b),
        "MOD" => check_finite(a.rem_euclid(b)),
        _ => check_finite(libm::pow(a, b)),
    }
}
