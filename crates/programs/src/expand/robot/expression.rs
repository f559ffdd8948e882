//! Expressions of RAPID and KRL: numbers, truths, strings, data and their parts, functions and operators.
//!
//! Which operators bind closer is that of ABB, *Technical reference manual, RAPID Overview*, expressions, and of KUKA, *Expert Programming*,
//! priority of operators. Where ABB's manual leaves open what NOT takes in, brackets are asked for.

use crate::{
    expand::robot::{syntax::is_of_name, value::Value},
    model::robot::{Language, RobotFault},
    read::{
        robot::{krl::brace_span, scan::check_depth},
        scan::Scan,
    },
};

/// What expressions ask for: values of data and functions.
pub(crate) trait Names {
    /// Language of the expressions.
    fn language(&self) -> Language;
    /// Returns the number of levels of brackets, signs, branches and data that are open.
    fn depth(&mut self) -> &mut usize;
    /// Returns the value of the datum `name` (in capitals).
    fn value(&mut self, name: &str) -> Result<Value, RobotFault>;
    /// Returns the value of the function `name` (in capitals).
    fn call(&mut self, name: &str, arguments: &[Argument]) -> Result<Value, RobotFault>;
}

/// An argument of a function or procedure: `\Rx:=5` has a name (in capitals), `\Conc` no value.
#[derive(Clone, Debug)]
pub(crate) struct Argument {
    pub name: Option<String>,
    pub value: Result<Value, RobotFault>,
    /// Its expression.
    pub text: String,
}

/// Operators by how close they bind, the loosest first.
const OPERATORS: [&[&str]; 5] =
    [&["OR", "XOR"], &["AND"], &["<>", "<=", ">=", "<", ">", "="], &["+", "-"], &["*", "/", "DIV", "MOD"]];

/// As [`OPERATORS`], those of KRL.
const KRL_OPERATORS: [&[&str]; 7] =
    [&["==", "<>", "<=", ">=", "<", ">"], &["OR"], &["EXOR"], &["AND"], &["+", "-"], &["*", "/"], &[":"]];

/// A reader of expressions in a statement.
pub(crate) struct Reader<'t, 'n> {
    pub scan: Scan<'t>,
    /// Without them expressions are only passed over.
    names: Option<&'n mut dyn Names>,
    language: Language,
    depth: usize,
}

impl<'t, 'n> Reader<'t, 'n> {
    /// Starts at the beginning of `text`.
    pub fn new(text: &'t [u8], names: &'n mut dyn Names) -> Self {
        let language = names.language();
        Self { scan: Scan::new(text), names: Some(names), language, depth: 0 }
    }

    /// Starts a reader that passes over expressions of which only the end matters.
    pub fn without_values(text: &'t [u8], language: Language) -> Self {
        Self { scan: Scan::new(text), names: None, language, depth: 0 }
    }

    /// Whether the expressions are those of KRL.
    fn is_krl(&self) -> bool {
        self.language == Language::Krl
    }

    /// Returns the operators by how close they bind.
    fn operators(&self) -> &'static [&'static [&'static str]] {
        if self.is_krl() { &KRL_OPERATORS } else { &OPERATORS }
    }

    /// Reads an expression up to where none goes on.
    pub fn expression(&mut self) -> Result<Value, RobotFault> {
        self.nested(|reader| reader.binary(0))
    }

    /// Reads one level deeper; `Err` beyond [`DEEPEST`](crate::read::scan::DEEPEST) levels.
    fn nested(&mut self, read: impl FnOnce(&mut Self) -> Result<Value, RobotFault>) -> Result<Value, RobotFault> {
        *self.level() += 1;
        let depth = *self.level();
        let value = check_depth(self.scan.line, depth).and_then(|()| read(self));
        *self.level() -= 1;
        value
    }

    /// Returns the number of levels that are open.
    fn level(&mut self) -> &mut usize {
        match &mut self.names {
            Some(names) => names.depth(),
            None => &mut self.depth,
        }
    }

    /// Reads operands and the operators that bind at `level` or closer.
    fn binary(&mut self, level: usize) -> Result<Value, RobotFault> {
        let Some(operators) = self.operators().get(level) else { return self.operand() };
        let mut left = self.binary(level + 1)?;
        let mut count = 0;
        while let Some(operator) = operators.iter().find(|operator| self.takes_word(operator)) {
            count += 1;
            if operators.contains(&"<=") && count > 1 {
                return Err(BRACKETS);
            }
            let right = self.binary(level + 1)?;
            left = if self.names.is_some() { left.apply(operator, &right)? } else { left };
        }
        Ok(left)
    }

    /// Takes an operator or a word if it comes next; returns whether it did.
    pub fn takes_word(&mut self, word: &str) -> bool {
        self.scan.skip_blanks();
        let rest = self.scan.rest();
        let begins = rest.get(..word.len()).is_some_and(|text| text.eq_ignore_ascii_case(word.as_bytes()));
        let is_name = word.starts_with(|c: char| c.is_ascii_alphabetic());
        let goes_on = is_name && rest.get(word.len()).is_some_and(|byte| is_of_name(*byte));
        let found = begins && !goes_on;
        self.scan.at += if found { word.len() } else { 0 };
        found
    }

    /// Reads a value with its sign, NOT, parts and indices.
    fn operand(&mut self) -> Result<Value, RobotFault> {
        let nested = |reader: &mut Self| reader.nested(Self::operand);
        if self.scan.takes(b'-') {
            let value = nested(self)?;
            return match value {
                _ if self.names.is_none() => Ok(value),
                Value::List(parts) => {
                    let parts = parts.iter().map(|part| Ok(Value::Number(-part.number()?)));
                    parts.collect::<Result<_, _>>().map(Value::List)
                }
                Value::Integer(_) => Value::Integer(0).apply("-", &value),
                value => value.number().map(|number| Value::Number(-number)),
            };
        }
        if self.scan.takes(b'+') {
            return nested(self);
        }
        if self.takes_word("NOT") {
            let value = nested(self)?;
            let goes_on = !self.is_krl() && !self.scan.is_done() && {
                let mut ahead = Self { scan: self.scan, names: None, ..*self };
                OPERATORS[1..].iter().copied().flatten().any(|operator| ahead.takes_word(operator))
            };
            return match value {
                _ if goes_on => Err(BRACKETS),
                _ if self.names.is_none() => Ok(value),
                value => value.truth().map(|truth| Value::Truth(!truth)),
            };
        }
        self.datum()
    }

    /// Reads a number, a string, a list, an expression in brackets, a datum or a function, with its parts and indices.
    pub fn datum(&mut self) -> Result<Value, RobotFault> {
        let value = self.primary()?;
        self.parts(value)
    }

    /// Reads a number, a string, a list, an expression in brackets, a datum or a function.
    fn primary(&mut self) -> Result<Value, RobotFault> {
        match self.scan.next() {
            Some(b'(') => {
                self.scan.at += 1;
                let value = self.expression()?;
                self.scan.expect(b')', ")")?;
                Ok(value)
            }
            Some(b'[') => {
                self.scan.at += 1;
                let mut parts = Vec::new();
                while !self.scan.takes(b']') {
                    if !parts.is_empty() {
                        self.scan.expect(b',', ", or ]")?;
                    }
                    parts.push(self.expression()?);
                }
                Ok(Value::List(parts))
            }
            Some(b'"') => {
                let rest = self.scan.rest();
                let mut quotes = 0;
                // A quote within is written twice.
                let end = rest.iter().enumerate().position(|(at, byte)| {
                    quotes += usize::from(*byte == b'"');
                    *byte == b'"' && at > 0 && quotes % 2 == 0 && rest.get(at + 1) != Some(&b'"')
                });
                let end = end.ok_or(RobotFault::Form { expected: "\" at the end of the string" })?;
                self.scan.at += end + 1;
                Ok(Value::Text(String::from_utf8_lossy(&rest[..=end]).into_owned()))
            }
            Some(byte) if byte.is_ascii_digit() || byte == b'.' => {
                let (value, at) = self.scan.number()?;
                match self.is_krl() && self.scan.line[at].iter().all(u8::is_ascii_digit) {
                    true => Value::integer(value),
                    false => Ok(Value::Number(value)),
                }
            }
            Some(b'{') if self.is_krl() => self.aggregate(),
            Some(b'\'') if self.is_krl() => self.bits(),
            Some(b'#') if self.is_krl() => {
                self.scan.at += 1;
                Ok(Value::Text(format!("#{}", self.scan.name().0.to_ascii_uppercase())))
            }
            _ => self.named(),
        }
    }

    /// Reads `{E6POS: X 1.5, Y -2, S 'B110'}`: plain numbers, each at the place of its part.
    fn aggregate(&mut self) -> Result<Value, RobotFault> {
        if self.names.is_none() {
            let text = self.scan.line;
            return brace_span(&mut self.scan, text).map(|_| Value::Unknown);
        }
        self.scan.expect(b'{', "{")?;
        let mut ahead = self.scan;
        if !ahead.name().0.is_empty() && ahead.takes(b':') {
            self.scan = ahead;
        }
        let mut value = Value::record();
        loop {
            let at = krl_part(self.scan.name().0)?;
            let number = match self.scan.next() {
                Some(b'\'') => self.bits()?,
                _ => Value::Number(self.scan.number()?.0),
            };
            *value.part(at)? = number.taken_as(krl_part_type(at))?;
            if self.scan.takes(b'}') {
                return Ok(value);
            }
            self.scan.expect(b',', ", or } behind a plain number")?;
        }
    }

    /// Reads a number in binary or hexadecimal digits: `'B110'`, `'H1F'`.
    fn bits(&mut self) -> Result<Value, RobotFault> {
        const EXPECTED: RobotFault = RobotFault::Form { expected: "'B110' or 'H1F'" };
        self.scan.expect(b'\'', "'")?;
        let digits = self.scan.name().0;
        self.scan.expect(b'\'', "'")?;
        let radix = match digits.as_bytes().first() {
            Some(b'B' | b'b') => 2,
            Some(b'H' | b'h') => 16,
            _ => return Err(EXPECTED),
        };
        i32::from_str_radix(&digits[1..], radix).map(Value::Integer).map_err(|_| EXPECTED)
    }

    /// Reads a datum or a function.
    fn named(&mut self) -> Result<Value, RobotFault> {
        let name = self.scan.name().0.to_ascii_uppercase();
        match name.as_str() {
            "" => return Err(RobotFault::Form { expected: "a number, a datum, a function or a bracket" }),
            "TRUE" => return Ok(Value::Truth(true)),
            "FALSE" => return Ok(Value::Truth(false)),
            _ => {}
        }
        if !self.scan.takes(b'(') {
            return match &mut self.names {
                Some(names) => names.value(&name),
                None => Ok(Value::Number(0.0)),
            };
        }
        let arguments = self.arguments(Some(b')'))?;
        self.scan.expect(b')', ")")?;
        match &mut self.names {
            Some(names) => names.call(&name, &arguments),
            None => Ok(Value::Number(0.0)),
        }
    }

    /// Reads arguments up to `close`, or to the end.
    pub fn arguments(&mut self, close: Option<u8>) -> Result<Vec<Argument>, RobotFault> {
        let mut arguments = Vec::new();
        while self.scan.next().is_some_and(|byte| Some(byte) != close) {
            let separated = self.scan.takes(b',');
            let is_named = self.scan.takes(b'\\');
            if !separated && !is_named && !arguments.is_empty() {
                return Err(RobotFault::Form { expected: ", between arguments" });
            }
            let name = is_named.then(|| self.scan.name().0.to_ascii_uppercase());
            let has_value = match is_named {
                true => self.scan.takes(b':') && self.scan.takes(b'='),
                false => true,
            };
            let from = self.scan.skip_blanks().at;
            let value = match (has_value, self.names.is_some()) {
                (false, _) => Ok(Value::Truth(true)),
                // A datum of a type that is not followed, such as a tool, is an argument too: by its name.
                (true, true) => {
                    let mut over = Self { scan: self.scan, names: None, ..*self };
                    over.expression()?;
                    let end = over.scan;
                    let value = self.expression();
                    self.scan = end;
                    value
                }
                (true, false) => Ok(self.expression()?),
            };
            let text = String::from_utf8_lossy(&self.scan.line[from..self.scan.at]).trim().to_owned();
            arguments.push(Argument { name, value, text });
        }
        Ok(arguments)
    }

    /// Reads the parts and indices behind a value: `.trans.x`, `{2}`.
    fn parts(&mut self, mut value: Value) -> Result<Value, RobotFault> {
        let path = self.path()?;
        if self.names.is_none() {
            return Ok(value);
        }
        let mut part = &mut value;
        for at in &path {
            part = part.part(*at)?;
        }
        Ok(part.clone())
    }

    /// Reads parts and indices, `.trans.x` and `{2}`, as indices from 0.
    pub fn path(&mut self) -> Result<Vec<usize>, RobotFault> {
        let mut path = Vec::new();
        loop {
            let [opening, closing] = if self.is_krl() { [b'[', b']'] } else { [b'{', b'}'] };
            if self.scan.takes(b'.') {
                let name = self.scan.name().0;
                path.push(match self.is_krl() {
                    true if self.names.is_none() => 0,
                    true => krl_part(name)?,
                    false => part_index(name)?,
                });
            } else if self.scan.takes(opening) {
                // KRL has `A[]` for all of an array.
                while !(self.is_krl() && self.scan.next() == Some(b']')) {
                    let index = self.expression()?;
                    if self.names.is_some() {
                        let index = index.whole()?.checked_sub(1);
                        path.push(index.ok_or(RobotFault::Form { expected: "an index from 1 on" })?);
                    }
                    if !self.scan.takes(b',') {
                        break;
                    }
                }
                self.scan.expect(closing, "the end of the index")?;
            } else {
                return Ok(path);
            }
        }
    }
}

/// Fault of operators whose order is not certain.
const BRACKETS: RobotFault = RobotFault::Form { expected: "brackets that say what comes first" };

/// Returns the index of the part `name` of a target, a pose, a position or an orientation.
fn part_index(name: &str) -> Result<usize, RobotFault> {
    const PARTS: [&[&str]; 6] = [
        &["trans", "x", "q1", "eax_a", "cf1"],
        &["rot", "y", "q2", "eax_b", "cf4"],
        &["robconf", "z", "q3", "eax_c", "cf6"],
        &["extax", "q4", "eax_d", "cfx"],
        &["eax_e"],
        &["eax_f"],
    ];
    let is_here = |names: &&[&str]| names.iter().any(|known| known.eq_ignore_ascii_case(name));
    PARTS.iter().position(is_here).ok_or(RobotFault::Form { expected: "a part of a target, a pose or a position" })
}

/// Names of the parts of a point or of joint positions of KRL.
pub(crate) const KRL_PARTS: [&str; 20] =
    ["X", "Y", "Z", "A", "B", "C", "S", "T", "E1", "E2", "E3", "E4", "E5", "E6", "A1", "A2", "A3", "A4", "A5", "A6"];

/// Returns the index of the part `name` of a point or of joint positions of KRL.
fn krl_part(name: &str) -> Result<usize, RobotFault> {
    let at = KRL_PARTS.iter().position(|known| known.eq_ignore_ascii_case(name));
    at.ok_or(RobotFault::Form { expected: "X Y Z A B C S T E1 … E6, or A1 … A6" })
}

/// Returns the type of the part of a point or of joint positions with index `at`: status and turn are whole numbers.
pub(crate) fn krl_part_type(at: usize) -> &'static str {
    if matches!(at, 6 | 7) { "INT" } else { "REAL" }
}
