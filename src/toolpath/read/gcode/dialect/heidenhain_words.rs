//! Words of Heidenhain's blocks of motion: coordinates, radius, feed, sense and M functions.

use std::ops::Range;

use crate::toolpath::{
    model::{
        Turn,
        gcode::{Distance, Fault, FeedMode, Foreign, GWord, MotionCode, Refusal, Setting, Unsupported, Vocable, Word},
    },
    read::scan::Scan,
};

/// What a block begins with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Verb {
    /// L.
    Line,
    /// C.
    Arc,
    /// CR.
    ArcByRadius,
    /// CC.
    Centre,
    /// M functions alone.
    None,
}

static LINE: Vocable = Vocable { name: "L", asks: GWord::Motion(MotionCode::Line) };
static RAPID: Vocable = Vocable { name: "L", asks: GWord::Motion(MotionCode::Rapid) };
static CLOCKWISE: Vocable = Vocable { name: "C", asks: GWord::Motion(MotionCode::Arc(Turn::Clockwise)) };
static COUNTER_CLOCKWISE: Vocable = Vocable { name: "C", asks: GWord::Motion(MotionCode::Arc(Turn::CounterClockwise)) };
static CENTRE: Vocable = Vocable { name: "CC", asks: GWord::Setting(Setting::Pole) };
static SENSE: Vocable = Vocable { name: "DR", asks: GWord::Auxiliary };
static FEED_OF_TOOL: Vocable = Vocable { name: "F AUTO", asks: GWord::FeedOfTool };
static OTHER_M: Vocable = Vocable { name: "M", asks: GWord::Auxiliary };
static END: Vocable = Vocable { name: "M30", asks: GWord::End };
static MACHINE: Vocable = Vocable { name: "M91", asks: GWord::Machine };
static RETRACT: Vocable = Vocable { name: "M140", asks: GWord::Retract };
/// M128.
pub(crate) static OF_TIP: Vocable = Vocable { name: "M128", asks: GWord::TipControl };
/// M129.
pub(crate) static OF_MACHINE: Vocable = Vocable { name: "M129", asks: GWord::TipControlEnds };
static PER_TURN: Vocable = Vocable { name: "M136", asks: GWord::Feed(FeedMode::PerRevolution) };
static PER_MINUTE: Vocable = Vocable { name: "M137", asks: GWord::Feed(FeedMode::PerMinute) };

/// The word `letter` from `start` to the end of its `number`.
pub(crate) fn word(letter: char, value: f64, start: usize, number: Range<usize>) -> Result<Word, Refusal> {
    let word = Word::plain(letter, value, start..number.end);
    // Nobody writes a number that far from its letter.
    let before = u8::try_from(number.start - start).map_err(|_| word.refuse(Fault::NotAWord))?;
    Ok(Word { around: [before, 0], ..word })
}

/// Why no number comes next: a parameter, or nothing.
pub(crate) fn no_number(scan: &Scan) -> Foreign {
    let rest = scan.line[scan.at..].trim_ascii_start();
    let rest = rest.strip_prefix(b"+").or_else(|| rest.strip_prefix(b"-")).unwrap_or(rest);
    match rest.first() {
        Some(b'Q' | b'q') => Foreign::Parameter,
        _ => Foreign::NoNumber,
    }
}

/// The words of a block whose verb stands from `start` to where `scan` is; `tool_feed` is what F AUTO means.
pub(crate) fn words(scan: Scan, verb: Verb, start: usize, tool_feed: Option<f64>) -> Result<Vec<Word>, Refusal> {
    let verb_span = start..scan.at;
    let mut block = Block { scan, verb, words: Vec::new(), sense: None, is_rapid: false, tool_feed };
    while block.scan.next().is_some() {
        block.word()?;
    }
    block.finished(verb_span)
}

/// The coordinates of a block that has nothing else.
pub(crate) fn coordinates(mut scan: Scan) -> Result<Vec<Word>, Refusal> {
    let mut words = Vec::new();
    while scan.next().is_some() {
        let start = scan.at;
        let letters = scan.letters();
        match axis(&letters) {
            Some((letter @ 'X'..='Z', distance)) => words.push(coordinate(&mut scan, letter, distance, start)?),
            Some(_) => return Err(scan.refuse(start, Foreign::Frame)),
            None if letters.starts_with('Q') => return Err(scan.refuse(start, Foreign::Parameter)),
            None => return Err(scan.refuse(start, Foreign::Unknown)),
        }
    }
    Ok(words)
}

/// The axis that letters name, and whether as a step.
fn axis(letters: &str) -> Option<(char, Option<Distance>)> {
    let (name, distance) = match letters.strip_prefix('I') {
        Some(name) => (name, Some(Distance::Incremental)),
        None => (letters, None),
    };
    match name.as_bytes() {
        [byte @ (b'X'..=b'Z' | b'A'..=b'C')] => Some((char::from(*byte), distance)),
        _ => None,
    }
}

fn coordinate(scan: &mut Scan, letter: char, distance: Option<Distance>, start: usize) -> Result<Word, Refusal> {
    scan.next();
    let (value, number) = scan.decimal()?.ok_or_else(|| scan.refuse(start, no_number(scan)))?;
    Ok(Word { distance, ..word(letter, value, start, number)? })
}

struct Block<'a> {
    scan: Scan<'a>,
    verb: Verb,
    words: Vec<Word>,
    sense: Option<Turn>,
    is_rapid: bool,
    tool_feed: Option<f64>,
}

impl Block<'_> {
    fn is_arc(&self) -> bool {
        matches!(self.verb, Verb::Arc | Verb::ArcByRadius)
    }

    fn word(&mut self) -> Result<(), Refusal> {
        let start = self.scan.at;
        let letters = self.scan.letters();
        if let Some((letter, distance)) = axis(&letters).filter(|_| self.verb != Verb::None) {
            let word = coordinate(&mut self.scan, letter, distance, start)?;
            self.words.push(word);
            return Ok(());
        }
        if letters == "M" {
            return self.m_function(start);
        }
        let refuse = |scan: &Scan, fault: Fault| Err(scan.refuse(start, fault));
        match letters.as_str() {
            "U" | "V" | "W" | "IU" | "IV" | "IW" => {
                return refuse(&self.scan, Fault::Unsupported(Unsupported::SecondaryAxis));
            }
            // How far M140 goes, and how far M120 looks ahead.
            "MB" | "LA" => {
                if self.scan.next().is_some_and(|byte| byte.is_ascii_alphabetic()) {
                    self.scan.letters();
                } else {
                    self.scan.decimal()?;
                }
            }
            "R" if matches!(self.verb, Verb::Line | Verb::Arc | Verb::ArcByRadius) => self.radius(start)?,
            "RL" | "RR" => return refuse(&self.scan, Foreign::Compensation { off: "R0" }.into()),
            "F" | "FMAX" | "FAUTO" if self.verb == Verb::Line || self.is_arc() => self.feed(&letters, start)?,
            "DR" if self.is_arc() => {
                let turn = match self.scan.next() {
                    Some(b'+') => Turn::CounterClockwise,
                    Some(b'-') => Turn::Clockwise,
                    _ => return refuse(&self.scan, Foreign::NoSense.into()),
                };
                self.scan.at += 1;
                if self.sense.replace(turn).is_some() {
                    return refuse(&self.scan, Foreign::Twice.into());
                }
                let sense = Word::plain(Word::SENSE, 0.0, start..self.scan.at);
                self.words.push(Word { asks: Some(&SENSE), ..sense });
            }
            "FQ" | "Q" | "QL" | "QR" | "QS" => return refuse(&self.scan, Foreign::Parameter.into()),
            "PA" | "PR" | "IPA" | "IPR" => return refuse(&self.scan, Foreign::Frame.into()),
            _ => return refuse(&self.scan, Foreign::Unknown.into()),
        }
        Ok(())
    }

    /// R: the radius of CR; otherwise whether the control takes the tool's radius into account.
    fn radius(&mut self, start: usize) -> Result<(), Refusal> {
        match self.scan.decimal()? {
            Some((value, number)) if self.verb == Verb::ArcByRadius && value != 0.0 => {
                self.words.push(word('R', value, start, number)?);
                Ok(())
            }
            Some((0.0, _)) => Ok(()),
            // As the block before.
            None if !matches!(self.scan.peek(), Some(b'+' | b'-')) => Ok(()),
            _ => Err(self.scan.refuse(start, Foreign::Compensation { off: "R0" })),
        }
    }

    /// F with a number, MAX or AUTO; without any of them it is as before.
    fn feed(&mut self, letters: &str, start: usize) -> Result<(), Refusal> {
        let mut kind = letters[1..].to_owned();
        if kind.is_empty() {
            let mut rest = self.scan;
            rest.next();
            kind = rest.letters();
            match kind.as_str() {
                "MAX" | "AUTO" => self.scan = rest,
                "Q" | "QL" | "QR" => return Err(self.scan.refuse(start, Foreign::Parameter)),
                _ => kind.clear(),
            }
        }
        match (kind.as_str(), self.tool_feed) {
            ("MAX", _) if self.is_arc() => return Err(self.scan.refuse(start, Foreign::RapidArc)),
            ("MAX", _) => self.is_rapid = true,
            ("AUTO", Some(feed)) => self.words.push(word('F', feed, start, self.scan.at..self.scan.at)?),
            ("AUTO", None) => {
                let feed = Word::plain('G', 0.0, start..self.scan.at);
                self.words.push(Word { asks: Some(&FEED_OF_TOOL), ..feed });
            }
            _ => {
                self.scan.next();
                match self.scan.decimal()? {
                    Some((value, number)) => self.words.push(word('F', value, start, number)?),
                    None if no_number(&self.scan) == Foreign::Parameter => {
                        return Err(self.scan.refuse(start, Foreign::Parameter));
                    }
                    None => {}
                }
            }
        }
        Ok(())
    }

    /// M with a number; without one it is none.
    fn m_function(&mut self, start: usize) -> Result<(), Refusal> {
        self.scan.next();
        let Some((value, number)) = self.scan.decimal()? else { return Ok(()) };
        let mut word = word('M', value, start, number)?;
        let asks = match word.whole()? {
            2 | 30 => &END,
            91 | 92 => &MACHINE,
            136 => &PER_TURN,
            137 => &PER_MINUTE,
            140 => &RETRACT,
            128 => {
                self.feed_of_compensation()?;
                &OF_TIP
            }
            129 => &OF_MACHINE,
            0..=88 | 200.. => &OTHER_M,
            90 | 94 | 101 | 102 | 105..=111 | 113 | 115..=117 | 120 | 126 | 127 | 134 | 135 | 145 | 148 | 149 => {
                &OTHER_M
            }
            89 | 99 => return Err(word.refuse(Fault::Foreign(Foreign::Cycle))),
            114 | 130 | 144 => return Err(word.refuse(Fault::Foreign(Foreign::Kinematics))),
            _ => return Err(word.refuse(Fault::Foreign(Foreign::MFunction))),
        };
        word.asks = Some(asks);
        self.words.push(word);
        Ok(())
    }

    /// The F that M128 may have: how fast the other axes follow.
    fn feed_of_compensation(&mut self) -> Result<(), Refusal> {
        let mut rest = self.scan;
        rest.next();
        if rest.letters() == "F" {
            rest.next();
            if rest.decimal()?.is_some() {
                self.scan = rest;
            }
        }
        Ok(())
    }

    /// The words, the verb first.
    fn finished(mut self, span: Range<usize>) -> Result<Vec<Word>, Refusal> {
        let has = |test: fn(char) -> bool| self.words.iter().any(|word| test(word.letter));
        let refuse = |foreign: Foreign| Err(self.scan.refuse(span.start, foreign));
        let (asks, value) = match (self.verb, self.sense) {
            (Verb::None, _) => return Ok(self.words),
            (Verb::Centre, _) => (&CENTRE, 0.0),
            (Verb::Line, _) if self.is_rapid => (&RAPID, 0.0),
            (Verb::Line, _) => (&LINE, 1.0),
            (_, None) => return refuse(Foreign::NoSense),
            _ if !has(|letter| matches!(letter, 'X' | 'Y' | 'Z')) => return refuse(Foreign::NoEnd),
            (Verb::ArcByRadius, _) if !has(|letter| letter == 'R') => return refuse(Foreign::NoRadius),
            (_, Some(Turn::Clockwise)) => (&CLOCKWISE, 2.0),
            (_, Some(Turn::CounterClockwise)) => (&COUNTER_CLOCKWISE, 3.0),
        };
        self.words.insert(0, Word { asks: Some(asks), ..Word::plain('G', value, span) });
        Ok(self.words)
    }
}
