//! Expressions of LinuxCNC and Fanuc, Sinumerik and Heidenhain, with angles in degrees.
//!
//! What operators there are and which bind closer is that of Siemens, *SINUMERIK 840D sl/828D Programming Manual Job Planning*, 1.7 Priority of the
//! operations, and of Heidenhain, *iTNC 530 User's Manual Conversational Programming*, entering formulas directly.

use crate::{
    expand::variables::Variables,
    model::gcode::{Dialect, Fault, MacroFault},
    read::scan::{DEEPEST, bracket_depth},
};

/// Values that differ by less are equal, as in LinuxCNC.
const EQUAL: f64 = 1e-6;
/// Numbers of Sinumerik whose relative difference is smaller are equal.
const RELATIVELY_EQUAL: f64 = 1e-12;
/// Those that differ by a smaller share, and yet differ, may be equal to a control or not.
const NEARLY_EQUAL: f64 = 1e-9;
/// Half of the last decimal of coordinates, in inches.
const LAST_PLACE: f64 = 5e-5;

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

    /// Skips blanks and returns the next byte without taking it; `None` at the end.
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
            Some(b'[' | b'(') => self.bracket(),
            Some(b'#') if self.variables.dialect.is_iso() => {
                self.at += 1;
                let name = self.name()?;
                self.variables.get(&name)
            }
            Some(byte) if byte.is_ascii_digit() || byte == b'.' => self.literal(),
            _ => match self.variables.dialect {
                Dialect::Sinumerik => self.sinumerik_value(),
                Dialect::Heidenhain => self.heidenhain_value(),
                _ => self.function(),
            },
        }
    }

    /// Reads a variable, a constant or a function of Sinumerik's, and returns its value.
    fn sinumerik_value(&mut self) -> MacroValue {
        let name = self.identifier();
        if self.peek() != Some(b'(') {
            return match name.as_str() {
                "TRUE" => Ok(Some(1.0)),
                "FALSE" => Ok(Some(0.0)),
                "NOT" => {
                    let value = self.nested(|reader| reader.number().map(Some))?;
                    apply_operator("XOR", value, Some(1.0), Dialect::Sinumerik).map(Some)
                }
                "" => Err(Fault::Macro(MacroFault::Expression { expected: OPERAND })),
                _ => self.element(name).and_then(|name| self.variables.get(&name)),
            };
        }
        if name == "NOT" {
            return apply_operator("XOR", self.bracket()?, Some(1.0), Dialect::Sinumerik).map(Some);
        }
        let (first, others) = self.arguments()?;
        let value = match (name.as_str(), &others[..]) {
            ("POT", []) => first * first,
            ("TRUNC", []) => first.trunc(),
            ("ROUND", []) => first.round(),
            ("ATAN2", [second]) => libm::atan2(first, *second).to_degrees(),
            ("MINVAL", [second]) => first.min(*second),
            ("MAXVAL", [second]) => first.max(*second),
            ("BOUND", [most, value]) if first <= *most => value.clamp(first, *most),
            (name, []) => unary_function(name, first)
                .filter(|_| !matches!(name, "ATAN" | "LOG"))
                .ok_or(Fault::Macro(MacroFault::Expression { expected: OPERAND }))?,
            _ => return Err(Fault::Macro(MacroFault::Expression { expected: OPERAND })),
        };
        check_finite(value).map(Some)
    }

    /// Reads a Q parameter, π or a function of Heidenhain's, which takes the value behind it.
    fn heidenhain_value(&mut self) -> MacroValue {
        const NAMES: [&str; 16] = [
            "SQRT", "SQ", "ASIN", "ACOS", "ATAN", "SIN", "COS", "TAN", "LN", "LOG", "EXP", "NEG", "INT", "ABS", "FRAC",
            "SGN",
        ];
        if self.peek() == Some(b'Q') {
            let name = self.q_name()?;
            return self.variables.get(&name);
        }
        if self.takes("PI") {
            return Ok(Some(std::f64::consts::PI));
        }
        let name = NAMES.iter().find(|name| self.takes(name));
        let name = name.ok_or(Fault::Macro(MacroFault::Expression { expected: OPERAND }))?;
        let x = self.nested(|reader| reader.number().map(Some))?.unwrap_or_default();
        let value = match *name {
            "SQ" => x * x,
            "NEG" => -x,
            "INT" => x.trunc(),
            "FRAC" => x.fract(),
            // Of 0 it is 1 to the iTNC 530, and 0 to later ones.
            "SGN" if x == 0.0 => {
                return Err(Fault::Macro(MacroFault::Expression { expected: "SGN of a number other than 0" }));
            }
            "SGN" => x.signum(),
            name => unary_function(name, x).ok_or(Fault::Macro(MacroFault::Expression { expected: OPERAND }))?,
        };
        check_finite(value).map(Some)
    }

    /// Reads Heidenhain's `Q5`, `QL5` or `QR5`.
    pub fn q_name(&mut self) -> Result<String, Fault> {
        let name = self.identifier();
        let number = name.trim_start_matches(char::is_alphabetic);
        match (&name[..name.len() - number.len()], number.parse::<u32>()) {
            (kind @ ("Q" | "QL" | "QR"), Ok(number)) => Ok(format!("{kind}{number}")),
            _ => Err(Fault::Macro(MacroFault::Expression { expected: "a Q parameter such as Q5" })),
        }
    }

    /// Takes letters, digits and `_`.
    pub fn identifier(&mut self) -> String {
        self.skip_blanks();
        let rest = &self.text[self.at..];
        let length = rest.iter().take_while(|byte| is_of_name(**byte)).count();
        self.at += length;
        String::from_utf8_lossy(&rest[..length]).into_owned()
    }

    /// Returns the name of Sinumerik's variable `name`, with the index in brackets that comes next, if any: `R[5]` is `R5`, `R05` too.
    pub fn element(&mut self, name: String) -> Result<String, Fault> {
        if self.peek() != Some(b'[') {
            let number = name.strip_prefix('R').and_then(|number| number.parse::<u32>().ok());
            return Ok(number.map_or(name, |number| format!("R{number}")));
        }
        let index = self.bracket()?.ok_or(Fault::Macro(MacroFault::NoValue))?;
        match index.round() {
            whole if whole == index && (0.0..=1e6).contains(&whole) && name == "R" => Ok(format!("R{whole}")),
            whole if whole == index && (0.0..=1e6).contains(&whole) => Ok(format!("{name}[{whole}]")),
            _ => Err(Fault::Macro(MacroFault::Expression { expected: "one whole number in the brackets" })),
        }
    }

    /// Reads the arguments of a function in brackets: the first, and the others.
    fn arguments(&mut self) -> Result<(f64, Vec<f64>), Fault> {
        let value =
            |reader: &mut Self| reader.nested(|reader| reader.binary(0))?.ok_or(Fault::Macro(MacroFault::NoValue));
        self.expect("(")?;
        let first = value(self)?;
        let mut others = Vec::new();
        while self.takes(",") {
            others.push(value(self)?);
        }
        self.expect(")")?;
        Ok((first, others))
    }

    /// Applies `read` one level deeper; `Err` beyond [`DEEPEST`] levels.
    fn nested(&mut self, read: impl FnOnce(&mut Self) -> MacroValue) -> MacroValue {
        self.depth += 1;
        if self.depth > DEEPEST {
            let depth = bracket_depth(self.text).max(self.depth);
            return Err(Fault::Macro(MacroFault::TooNested { depth, most: DEEPEST }));
        }
        let found = read(self);
        self.depth -= 1;
        found
    }

    /// Reads an expression without brackets around it, as on the right of Fanuc's `=`.
    pub fn expression(&mut self) -> MacroValue {
        self.binary(0)
    }

    /// Reads an expression in brackets, `[ … ]` or but in ISO code `( … )`, and returns its value.
    pub fn bracket(&mut self) -> MacroValue {
        let is_round = !self.variables.dialect.is_iso() && self.takes("(");
        if !is_round {
            self.expect("[")?;
        }
        let found = self.nested(|reader| reader.binary(0))?;
        self.expect(if is_round { ")" } else { "]" })?;
        Ok(found)
    }

    /// Reads a plain number without sign; of Sinumerik's with an exponent (`1.5EX-3`), of Heidenhain's with a comma.
    fn literal(&mut self) -> MacroValue {
        let rest = &self.text[self.at..];
        let dialect = self.variables.dialect;
        let is_comma = |b: u8| b == b',' && dialect == Dialect::Heidenhain;
        let mut length = rest.iter().take_while(|b| b.is_ascii_digit() || **b == b'.' || is_comma(**b)).count();
        if dialect == Dialect::Sinumerik && rest[length..].starts_with(b"EX") {
            length +=
                2 + rest[length + 2..].iter().take_while(|b| b.is_ascii_digit() || matches!(b, b'+' | b'-')).count();
        }
        self.at += length;
        let text = std::str::from_utf8(&rest[..length]).ok();
        let text = text.map(|text| text.replace(',', ".").replace("EX", "e"));
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
        const ISO: &[&[&str]] =
            &[&["AND", "OR", "XOR"], &["EQ", "NE", "GE", "GT", "LE", "LT"], &["+", "-"], &["*", "/", "MOD"], &["**"]];
        const SINUMERIK: &[&[&str]] =
            &[&["==", "<>", "<=", ">=", "<", ">"], &["OR"], &["XOR"], &["AND"], &["+", "-"], &["*", "/", "DIV", "MOD"]];
        const HEIDENHAIN: &[&[&str]] =
            &[&["EQU", "NE", "GT", "LT"], &["LEN", "ANG"], &["+", "-"], &["*", "/", "DIV", "%"], &["^"]];
        let dialect = self.variables.dialect;
        let levels = match dialect {
            Dialect::Sinumerik => SINUMERIK,
            Dialect::Heidenhain => HEIDENHAIN,
            _ => ISO,
        };
        let Some(operators) = levels.get(level) else { return self.value() };
        let mut left = self.binary(level + 1)?;
        let mut count = 0;
        loop {
            // `**` is no `*`.
            let is_power = self.peek() == Some(b'*') && self.text.get(self.at + 1) == Some(&b'*');
            let taken = operators.iter().find(|operator| {
                // A word of Sinumerik's that only begins so: ORIAXES.
                let next = self.text.get(self.at + operator.len());
                let goes_on = dialect == Dialect::Sinumerik
                    && operator.starts_with(|c: char| c.is_ascii_alphabetic())
                    && next.is_some_and(|next| is_of_name(*next));
                (**operator != "*" || !is_power) && !goes_on && self.takes(operator)
            });
            let Some(operator) = taken else { return Ok(left) };
            count += 1;
            if count > 1 && !dialect.is_iso() && (level == 0 || *operator == "^") {
                return Err(Fault::Macro(MacroFault::Expression { expected: "brackets that say what comes first" }));
            }
            let right = self.binary(level + 1)?;
            let is_negative = |value: Option<f64>| value.is_some_and(|value| value < 0.0);
            // Fanuc's remainder is that of the amounts.
            let divides = matches!(*operator, "MOD" | "%") || (*operator == "DIV" && dialect == Dialect::Sinumerik);
            if divides && (is_negative(left) || is_negative(right)) && dialect != Dialect::LinuxCnc {
                return Err(Fault::Macro(MacroFault::Expression { expected: "MOD of no negative number" }));
            }
            left = Some(apply_operator(operator, left, right, dialect)?);
        }
    }

    /// Reads a function with its argument in brackets, and returns its value; angles are in degrees.
    fn function(&mut self) -> MacroValue {
        const NAMES: [&str; 14] =
            ["ABS", "ACOS", "ASIN", "ATAN", "COS", "EXISTS", "EXP", "FIX", "FUP", "LN", "ROUND", "SIN", "SQRT", "TAN"];
        let Some(name) = NAMES.iter().find(|name| self.takes(name)) else {
            return Err(Fault::Macro(MacroFault::Expression { expected: OPERAND }));
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
            "ATAN" => {
                self.expect("/")?;
                libm::atan2(x, self.bracket()?.ok_or(Fault::Macro(MacroFault::NoValue))?).to_degrees()
            }
            // Fanuc rounds towards and from zero, LinuxCNC down and up.
            "FIX" | "FUP" if x < 0.0 => {
                return Err(Fault::Macro(MacroFault::Expression { expected: "FIX and FUP of no negative number" }));
            }
            "FIX" => x.floor(),
            "FUP" => x.ceil(),
            "ROUND" => {
                self.has_rounded |= (x - x.round()).abs() >= LAST_PLACE;
                x.round()
            }
            name => unary_function(name, x).unwrap_or(f64::NAN),
        };
        check_finite(value).map(Some)
    }
}

/// What may stand where an expression begins.
const OPERAND: &str = "a number, a variable, a function or a bracket";

/// Whether `byte` may be in a name.
fn is_of_name(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_'
}

/// Returns the value at `x` of the function `name`, which dialects share; `None` if there is none. Angles are in degrees.
fn unary_function(name: &str, x: f64) -> Option<f64> {
    Some(match name {
        "ABS" => x.abs(),
        "ACOS" => libm::acos(x).to_degrees(),
        "ASIN" => libm::asin(x).to_degrees(),
        "ATAN" => libm::atan(x).to_degrees(),
        "COS" => libm::cos(x.to_radians()),
        "EXP" => libm::exp(x),
        "LN" => libm::log(x),
        "LOG" => libm::log10(x),
        "SIN" => libm::sin(x.to_radians()),
        "SQRT" => x.sqrt(),
        "TAN" => libm::tan(x.to_radians()),
        _ => return None,
    })
}

/// Returns `value`; `Err` if it is not finite.
fn check_finite(value: f64) -> Result<f64, Fault> {
    if value.is_finite() { Ok(value) } else { Err(Fault::Macro(MacroFault::NotFinite)) }
}

/// Returns the value of a binary operator; comparisons and logic give 1 or 0. `Err` for null (`None`) in arithmetic, or no finite value.
fn apply_operator(operator: &str, left: Option<f64>, right: Option<f64>, dialect: Dialect) -> Result<f64, Fault> {
    let truth = |is: bool| Ok(f64::from(u8::from(is)));
    // Only whether it is null can be asked of null.
    let (a, b) = match (operator, left, right) {
        ("EQ", None, other) | ("EQ", other, None) => return truth(other.is_none()),
        ("NE", None, other) | ("NE", other, None) => return truth(other.is_some()),
        (_, Some(a), Some(b)) => (a, b),
        _ => return Err(Fault::Macro(MacroFault::NoValue)),
    };
    let share = (a - b).abs() / a.abs().max(b.abs()).max(f64::MIN_POSITIVE);
    let equal = match dialect {
        Dialect::Sinumerik => share <= RELATIVELY_EQUAL,
        Dialect::Heidenhain => a == b,
        _ => (a - b).abs() < EQUAL,
    };
    let is_ordered = matches!(operator, "<" | ">" | "<=" | ">=" | "GT" | "LT");
    let is_near = a != b && share < NEARLY_EQUAL;
    if is_near
        && ((!dialect.is_iso() && is_ordered) || (dialect == Dialect::Heidenhain && matches!(operator, "EQU" | "NE")))
    {
        return Err(Fault::Macro(MacroFault::Expression {
            expected: "numbers that are equal, or differ by more than rounding",
        }));
    }
    // Fanuc's work on bits, LinuxCNC's on truths: of 0 and 1 they are the same.
    if matches!(operator, "AND" | "OR" | "XOR") && [a, b].iter().any(|value| *value != 0.0 && *value != 1.0) {
        return Err(Fault::Macro(MacroFault::Expression { expected: "AND, OR and XOR of comparisons" }));
    }
    match operator {
        "AND" => truth(a != 0.0 && b != 0.0),
        "OR" => truth(a != 0.0 || b != 0.0),
        "XOR" => truth((a != 0.0) != (b != 0.0)),
        "EQ" | "==" | "EQU" => truth(equal),
        "NE" | "<>" => truth(!equal),
        "GE" | ">=" => truth(a >= b),
        "GT" | ">" => truth(a > b),
        "LE" | "<=" => truth(a <= b),
        "LT" | "<" => truth(a < b),
        "+" => check_finite(a + b),
        "-" => check_finite(a - b),
        "*" => check_finite(a * b),
        "DIV" if dialect == Dialect::Sinumerik => check_finite((a / b).trunc()),
        "/" | "DIV" => check_finite(a / b),
        "MOD" | "%" => check_finite(a.rem_euclid(b)),
        "LEN" => check_finite(libm::hypot(a, b)),
        "ANG" => check_finite(libm::atan2(a, b).to_degrees().rem_euclid(360.0)),
        _ => check_finite(libm::pow(a, b)),
    }
}
