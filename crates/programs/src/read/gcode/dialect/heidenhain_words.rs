//! Words of Heidenhain's motion blocks: coordinates, radius, feed, direction of arcs and M functions.

use std::ops::Range;

use crate::{
    model::{
        TurnDirection,
        gcode::{
            Distance, Fault, FeedMode, Foreign, ForeignWord, GWord, MotionCode, Refusal, Setting, Unsupported, Word,
        },
    },
    read::scan::Scan,
};

/// First word of a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Verb {
    /// L, a straight line.
    Line,
    /// C, an arc about the centre in force.
    Arc,
    /// CR, an arc by its radius.
    ArcByRadius,
    /// LP, CP: to polar coordinates about the centre in force.
    PolarLine,
    PolarArc,
    /// CT, CTP: along the tangent before it.
    TangentialArc,
    /// CC, the centre of arcs.
    Centre,
    /// No verb: M functions alone.
    None,
}

static LINE: ForeignWord = ForeignWord { name: "L", meaning: GWord::Motion(MotionCode::Line) };
static RAPID: ForeignWord = ForeignWord { name: "L", meaning: GWord::Motion(MotionCode::Rapid) };
static CLOCKWISE: ForeignWord =
    ForeignWord { name: "C", meaning: GWord::Motion(MotionCode::Arc(TurnDirection::Clockwise)) };
static COUNTER_CLOCKWISE: ForeignWord =
    ForeignWord { name: "C", meaning: GWord::Motion(MotionCode::Arc(TurnDirection::CounterClockwise)) };
static CENTRE: ForeignWord = ForeignWord { name: "CC", meaning: GWord::Setting(Setting::Pole) };
static SENSE: ForeignWord = ForeignWord { name: "DR", meaning: GWord::Auxiliary };
static FEED_OF_TOOL: ForeignWord = ForeignWord { name: "F AUTO", meaning: GWord::FeedOfTool };
static OTHER_M: ForeignWord = ForeignWord { name: "M", meaning: GWord::Auxiliary };
static FOUND_ANGLE: ForeignWord = ForeignWord { name: "Q120", meaning: GWord::Auxiliary };
static END: ForeignWord = ForeignWord { name: "M30", meaning: GWord::End };
static MACHINE: ForeignWord = ForeignWord { name: "M91", meaning: GWord::Machine };
static RETRACT: ForeignWord = ForeignWord { name: "M140", meaning: GWord::Retract };
/// M128: coordinates are those of the tip (TCPM).
pub(crate) static OF_TIP: ForeignWord = ForeignWord { name: "M128", meaning: GWord::TipControl };
/// M129: coordinates are no longer those of the tip.
pub(crate) static OF_MACHINE: ForeignWord = ForeignWord { name: "M129", meaning: GWord::TipControlEnds };
static PER_TURN: ForeignWord = ForeignWord { name: "M136", meaning: GWord::Feed(FeedMode::PerRevolution) };
static PER_MINUTE: ForeignWord = ForeignWord { name: "M137", meaning: GWord::Feed(FeedMode::PerMinute) };

/// Creates the word of `letter` with `value`, from byte `start` to the end of its `number`; `Err` if these are far apart.
pub(crate) fn numbered_word(letter: char, value: f64, start: usize, number: Range<usize>) -> Result<Word, Refusal> {
    let word = Word::plain(letter, value, start..number.end);
    // Nobody writes a number that far from its letter.
    let before = u8::try_from(number.start - start).map_err(|_| word.refuse(Fault::NotAWord))?;
    Ok(Word { around: [before, 0], ..word })
}

/// Returns why no number comes next: a parameter stands there, or nothing.
pub(crate) fn number_fault(scan: &Scan) -> Foreign {
    let rest = scan.line[scan.at..].trim_ascii_start();
    let rest = rest.strip_prefix(b"+").or_else(|| rest.strip_prefix(b"-")).unwrap_or(rest);
    match rest.first() {
        Some(b'Q' | b'q') => Foreign::Parameter,
        _ => Foreign::NoNumber,
    }
}

/// Returns the words of a motion block whose verb spans from byte `start` to the cursor `scan`; `tool_feed` is the feed of F AUTO.
pub(crate) fn motion_words(scan: Scan, verb: Verb, start: usize, tool_feed: Option<f64>) -> Result<Vec<Word>, Refusal> {
    let verb_span = start..scan.at;
    let mut block = Block { scan, verb, words: Vec::new(), sense: None, is_rapid: false, tool_feed };
    while block.scan.next().is_some() {
        block.read_word()?;
    }
    block.into_words(verb_span)
}

/// Returns the words of a block that has only coordinates X, Y and Z; `Err` for anything else.
pub(crate) fn coordinate_words(mut scan: Scan) -> Result<Vec<Word>, Refusal> {
    let mut words = Vec::new();
    while scan.next().is_some() {
        let start = scan.at;
        let letters = scan.take_letters();
        match parse_axis(&letters) {
            Some((letter @ 'X'..='Z', distance)) => words.push(coordinate_word(&mut scan, letter, distance, start)?),
            Some(_) => return Err(scan.refuse(start, Foreign::Frame)),
            None if letters.starts_with('Q') => return Err(scan.refuse(start, Foreign::Parameter)),
            None => return Err(scan.refuse(start, Foreign::Unknown)),
        }
    }
    Ok(words)
}

/// Returns the axis that `letters` name, and incremental distance if they begin with I; `None` if they name none.
fn parse_axis(letters: &str) -> Option<(char, Option<Distance>)> {
    let (name, distance) = match letters.strip_prefix('I') {
        Some(name) => (name, Some(Distance::Incremental)),
        None => (letters, None),
    };
    match name.as_bytes() {
        [byte @ (b'X'..=b'Z' | b'A'..=b'C')] => Some((char::from(*byte), distance)),
        _ => None,
    }
}

/// Reads the number behind `letter`, which begins at byte `start`, and returns its word.
pub(crate) fn coordinate_word(
    scan: &mut Scan,
    letter: char,
    distance: Option<Distance>,
    start: usize,
) -> Result<Word, Refusal> {
    scan.next();
    let (value, number) = scan.take_decimal()?.ok_or_else(|| scan.refuse(start, number_fault(scan)))?;
    Ok(Word { distance, ..numbered_word(letter, value, start, number)? })
}

/// Returns the word of `RND R5` or `CHF 5`, which begins at byte `start`; `Err` with anything else, such as a feed of its own.
pub(crate) fn corner_words(mut scan: Scan, name: &str, start: usize) -> Result<Vec<Word>, Refusal> {
    let is_rounding = name == "RND";
    if is_rounding {
        scan.next();
        scan.take_letters();
    }
    let word = coordinate_word(&mut scan, if is_rounding { 'f' } else { 'h' }, None, start)?;
    if scan.next().is_some() { Err(scan.refuse(scan.at, Foreign::Corner)) } else { Ok(vec![word]) }
}

/// A motion block that is being read.
struct Block<'a> {
    scan: Scan<'a>,
    verb: Verb,
    words: Vec<Word>,
    sense: Option<TurnDirection>,
    is_rapid: bool,
    tool_feed: Option<f64>,
}

impl Block<'_> {
    /// Whether the block is an arc.
    fn is_arc(&self) -> bool {
        matches!(self.verb, Verb::Arc | Verb::ArcByRadius | Verb::PolarArc | Verb::TangentialArc)
    }

    /// Whether the block may have polar coordinates.
    fn is_polar(&self) -> bool {
        matches!(self.verb, Verb::PolarLine | Verb::PolarArc | Verb::TangentialArc)
    }

    /// Takes the parameter (Q120 to Q122) with the angle of the axis `letter` that PLANE with STAY has found; returns whether it comes next.
    fn takes_found_angle(&mut self, letter: char) -> bool {
        let mut ahead = self.scan;
        ahead.next();
        ahead.takes(b'+');
        let name: &[u8] = match letter {
            'A' => b"Q120",
            'B' => b"Q121",
            'C' => b"Q122",
            _ => return false,
        };
        let rest = &ahead.line[ahead.at..];
        let found = rest.get(..4).is_some_and(|text| text.eq_ignore_ascii_case(name))
            && !rest.get(4).is_some_and(u8::is_ascii_alphanumeric);
        if found {
            self.scan.at = ahead.at + 4;
        }
        found
    }

    /// Reads the next word of the block; `Err` if it is not followed.
    fn read_word(&mut self) -> Result<(), Refusal> {
        let start = self.scan.at;
        let letters = self.scan.take_letters();
        if let Some((letter, distance)) = parse_axis(&letters).filter(|_| self.verb != Verb::None) {
            if self.verb == Verb::Line && distance.is_none() && self.takes_found_angle(letter) {
                let word = Word::plain(letter, 0.0, start..self.scan.at);
                self.words.push(Word { meaning: Some(&FOUND_ANGLE), ..word });
                return Ok(());
            }
            let word = coordinate_word(&mut self.scan, letter, distance, start)?;
            self.words.push(word);
            return Ok(());
        }
        if letters == "M" {
            return self.read_m_word(start);
        }
        let polar = match letters.as_str() {
            "PR" => Some(('p', None)),
            "PA" => Some(('a', None)),
            "IPA" => Some(('a', Some(Distance::Incremental))),
            _ => None,
        };
        if let Some((letter, distance)) = polar.filter(|_| self.is_polar()) {
            self.words.push(coordinate_word(&mut self.scan, letter, distance, start)?);
            return Ok(());
        }
        let refuse = |scan: &Scan, fault: Fault| Err(scan.refuse(start, fault));
        match letters.as_str() {
            "U" | "V" | "W" | "IU" | "IV" | "IW" => {
                return refuse(&self.scan, Fault::Unsupported(Unsupported::SecondaryAxis));
            }
            // How far M140 goes, and how far M120 looks ahead.
            "MB" | "LA" => {
                if self.scan.next().is_some_and(|byte| byte.is_ascii_alphabetic()) {
                    self.scan.take_letters();
                } else {
                    self.scan.take_decimal()?;
                }
            }
            "R" if self.verb == Verb::Line || self.is_arc() || self.is_polar() => self.read_radius(start)?,
            "RL" | "RR" => return refuse(&self.scan, Foreign::Compensation { off: "R0" }.into()),
            "F" | "FMAX" | "FAUTO" if self.verb == Verb::Line || self.is_arc() || self.is_polar() => {
                self.read_feed(&letters, start)?
            }
            "DR" if self.is_arc() => {
                let turn = match self.scan.next() {
                    Some(b'+') => TurnDirection::CounterClockwise,
                    Some(b'-') => TurnDirection::Clockwise,
                    _ => return refuse(&self.scan, Foreign::NoSense.into()),
                };
                self.scan.at += 1;
                if self.sense.replace(turn).is_some() {
                    return refuse(&self.scan, Foreign::Twice.into());
                }
                let sense = Word::plain(Word::SENSE, 0.0, start..self.scan.at);
                self.words.push(Word { meaning: Some(&SENSE), ..sense });
            }
            "FQ" | "Q" | "QL" | "QR" | "QS" => return refuse(&self.scan, Foreign::Parameter.into()),
            "PA" | "PR" | "IPA" | "IPR" => return refuse(&self.scan, Foreign::Frame.into()),
            _ => return refuse(&self.scan, Foreign::Unknown.into()),
        }
        Ok(())
    }

    /// Reads R: the radius of CR, else R0 (tool radius compensation off).
    fn read_radius(&mut self, start: usize) -> Result<(), Refusal> {
        match self.scan.take_decimal()? {
            Some((value, number)) if self.verb == Verb::ArcByRadius && value != 0.0 => {
                self.words.push(numbered_word('R', value, start, number)?);
                Ok(())
            }
            Some((0.0, _)) => Ok(()),
            // As the block before.
            None if !matches!(self.scan.peek(), Some(b'+' | b'-')) => Ok(()),
            _ => Err(self.scan.refuse(start, Foreign::Compensation { off: "R0" })),
        }
    }

    /// Reads F with a number, MAX or AUTO; F alone changes nothing.
    fn read_feed(&mut self, letters: &str, start: usize) -> Result<(), Refusal> {
        let mut kind = letters[1..].to_owned();
        if kind.is_empty() {
            let mut rest = self.scan;
            rest.next();
            kind = rest.take_letters();
            match kind.as_str() {
                "MAX" | "AUTO" => self.scan = rest,
                "Q" | "QL" | "QR" => return Err(self.scan.refuse(start, Foreign::Parameter)),
                _ => kind.clear(),
            }
        }
        match (kind.as_str(), self.tool_feed) {
            ("MAX", _) if self.is_arc() => return Err(self.scan.refuse(start, Foreign::RapidArc)),
            ("MAX", _) => self.is_rapid = true,
            ("AUTO", Some(feed)) => self.words.push(numbered_word('F', feed, start, self.scan.at..self.scan.at)?),
            ("AUTO", None) => {
                let feed = Word::plain('G', 0.0, start..self.scan.at);
                self.words.push(Word { meaning: Some(&FEED_OF_TOOL), ..feed });
            }
            _ => {
                self.scan.next();
                match self.scan.take_decimal()? {
                    Some((value, number)) => self.words.push(numbered_word('F', value, start, number)?),
                    None if number_fault(&self.scan) == Foreign::Parameter => {
                        return Err(self.scan.refuse(start, Foreign::Parameter));
                    }
                    None => {}
                }
            }
        }
        Ok(())
    }

    /// Reads an M function; M without a number is none.
    fn read_m_word(&mut self, start: usize) -> Result<(), Refusal> {
        self.scan.next();
        let Some((value, number)) = self.scan.take_decimal()? else { return Ok(()) };
        let mut word = numbered_word('M', value, start, number)?;
        let meaning = match word.whole_number()? {
            2 | 30 => &END,
            91 | 92 => &MACHINE,
            136 => &PER_TURN,
            137 => &PER_MINUTE,
            140 => &RETRACT,
            128 => {
                self.skip_feed_of_m128()?;
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
        word.meaning = Some(meaning);
        self.words.push(word);
        Ok(())
    }

    /// Skips the F of M128, the feed of its compensating moves.
    fn skip_feed_of_m128(&mut self) -> Result<(), Refusal> {
        let mut rest = self.scan;
        rest.next();
        if rest.take_letters() == "F" {
            rest.next();
            if rest.take_decimal()?.is_some() {
                self.scan = rest;
            }
        }
        Ok(())
    }

    /// Returns the words of the block, the verb at `span` first. `Err` if an arc lacks its direction, end or radius.
    fn into_words(mut self, span: Range<usize>) -> Result<Vec<Word>, Refusal> {
        let has = |test: fn(char) -> bool| self.words.iter().any(|word| test(word.letter));
        let refuse = |foreign: Foreign| Err(self.scan.refuse(span.start, foreign));
        let (meaning, value) = match (self.verb, self.sense) {
            (Verb::None, _) => return Ok(self.words),
            (Verb::Centre, _) => (&CENTRE, 0.0),
            (Verb::Line | Verb::PolarLine, _) if self.is_rapid => (&RAPID, 0.0),
            (Verb::Line | Verb::PolarLine, _) => (&LINE, 1.0),
            (Verb::TangentialArc, _) => {
                self.words.insert(0, Word::plain('u', 0.0, span));
                return Ok(self.words);
            }
            (_, None) => return refuse(Foreign::NoSense),
            _ if !has(|letter| matches!(letter, 'X' | 'Y' | 'Z' | 'a')) => return refuse(Foreign::NoEnd),
            (Verb::ArcByRadius, _) if !has(|letter| letter == 'R') => return refuse(Foreign::NoRadius),
            (_, Some(TurnDirection::Clockwise)) => (&CLOCKWISE, 2.0),
            (_, Some(TurnDirection::CounterClockwise)) => (&COUNTER_CLOCKWISE, 3.0),
        };
        self.words.insert(0, Word { meaning: Some(meaning), ..Word::plain('G', value, span) });
        Ok(self.words)
    }
}
