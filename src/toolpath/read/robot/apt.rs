//! APT and the CLDATA of CAM systems as text: `GOTO/x,y,z,i,j,k` and the records that set feed, units and tool.
//!
//! Followed are FROM, GOTO, GODLTA, RAPID, FEDRAT, SPINDL, UNITS, LOADTL and MULTAX. Other records that do not move the tool are ignored;
//! circles, cycles, tool compensation, rotary tables and the geometry of APT are refused.

use std::ops::Range;

use crate::toolpath::{
    model::robot::{Component, Frames, INCH_MM, MotionKind, Number, RobotFault, RobotOptions, Statement, Target},
    read::{
        robot::{LineCursor, Refusal, trimmed},
        scan::Scan,
    },
};

/// Unit of a feed.
#[derive(Clone, Copy, Debug, PartialEq)]
enum FeedUnit {
    /// mm/min per unit.
    PerMinute(f64),
    /// mm per spindle revolution and unit.
    PerTurn(f64),
    /// A unit that is not followed.
    Other,
}

/// A reader of APT records with the modes in force.
#[derive(Debug)]
pub(crate) struct Reader<'a> {
    source: &'a [u8],
    options: &'a RobotOptions,
    lines: LineCursor<'a>,
    unit_mm: f64,
    feed: Option<(f64, FeedUnit)>,
    spindle_rev_per_min: Option<f64>,
    tool: Option<u32>,
    is_rapid: bool,
    /// Words of the first MSYS, the axes of the coordinates.
    system: Option<Vec<String>>,
    /// Line of FINI, at which the program ends.
    end_line: Option<usize>,
}

impl<'a> Reader<'a> {
    /// Starts at the first record of `source`.
    pub fn new(source: &'a [u8], options: &'a RobotOptions) -> Self {
        Self {
            source,
            options,
            lines: LineCursor::new(source),
            unit_mm: 1.0,
            feed: None,
            spindle_rev_per_min: None,
            tool: None,
            is_rapid: false,
            system: None,
            end_line: None,
        }
    }

    /// Returns the next record that moves the tool; `None` at the end, `Err` for a record that is not followed.
    pub fn next(&mut self) -> Result<Option<Statement>, Refusal> {
        while let Some((at, line, code)) = self.next_record() {
            let found = self.follow_record(at.clone(), line, &code);
            if let Some(statement) = found.map_err(|fault| Refusal { line, at, fault })? {
                return Ok(Some(statement));
            }
        }
        Ok(None)
    }

    /// Returns the next record: its bytes, its first line, and its text with blanks for comments and line breaks; `None` at the end.
    fn next_record(&mut self) -> Option<(Range<usize>, usize, Vec<u8>)> {
        loop {
            let (mut range, mut is_continued) = code_range(self.source, self.lines.advance()?);
            let first = self.lines.line;
            while is_continued && let Some(next) = self.lines.advance() {
                let (more, more_follow) = code_range(self.source, next);
                (range.end, is_continued) = (more.end, more_follow);
            }
            let at = trimmed(self.source, range);
            if at.is_empty() {
                continue;
            }
            // What stands behind a `$` is a comment.
            let mut behind = false;
            let blank = |byte: &u8| {
                behind = (behind || *byte == b'$') && !matches!(byte, b'\r' | b'\n');
                if behind || matches!(byte, b'\r' | b'\n') { b' ' } else { *byte }
            };
            return Some((at.clone(), first, self.source[at].iter().map(blank).collect()));
        }
    }

    /// Follows the record with the text `code` on line `line`: returns the statement if it moves the tool, or else sets modes.
    fn follow_record(&mut self, at: Range<usize>, line: usize, code: &[u8]) -> Result<Option<Statement>, RobotFault> {
        let slash = code.iter().position(|byte| *byte == b'/');
        let major = String::from_utf8_lossy(&code[..slash.unwrap_or(code.len())]).trim().to_ascii_uppercase();
        let word = major.split(|c: char| !(c.is_ascii_alphanumeric() || c == '-')).next().unwrap_or_default();
        let minor = slash.map_or(&code[code.len()..], |slash| &code[slash + 1..]);
        let words = minor_words(minor);
        let has = |word: &str| words.iter().any(|minor_word| minor_word == word);
        let number = || words.iter().find_map(|word| word.parse::<f64>().ok()).filter(|number| number.is_finite());
        match word {
            "GOTO" | "FROM" | "GODLTA" => {
                if let Some(end) = self.end_line {
                    return Err(RobotFault::AfterEnd { end });
                }
                let minor_at = slash.map_or(at.end, |slash| at.start + slash + 1);
                return self.motion(word, at, line, minor, minor_at).map(Some);
            }
            "GOHOME" => {
                return Ok(Some(self.statement(at.clone(), line, at.start..at.start, MotionKind::PointToPoint)));
            }
            "RAPID" => self.is_rapid = true,
            "FEDRAT" => {
                self.is_rapid = false;
                self.feed = number().map(|number| (number, self.feed_unit(&has)));
            }
            "SPINDL" => match number().filter(|speed| *speed > 0.0) {
                Some(speed) if !has("SFM") && !has("SMM") => self.spindle_rev_per_min = Some(speed),
                Some(_) => self.spindle_rev_per_min = None,
                None if has("OFF") => self.spindle_rev_per_min = None,
                None => {}
            },
            "UNITS" | "UNIT" => {
                self.unit_mm = match words.first().map(String::as_str) {
                    Some("MM") => 1.0,
                    Some("INCHES" | "INCH" | "IN") => INCH_MM,
                    _ => return Err(RobotFault::Form { expected: "UNITS/MM or UNITS/INCHES" }),
                };
            }
            "LOADTL" => self.tool = number().filter(|tool| *tool >= 0.0 && tool.fract() == 0.0).map(|tool| tool as u32),
            "MSYS" | "MCSYS" => {
                if *self.system.get_or_insert_with(|| words.clone()) != words {
                    return RobotFault::not_followed("second systems of coordinates are", "one MSYS");
                }
            }
            "FINI" => self.end_line = Some(line),
            "TLAXIS" if is_z_axis(&words) => {}
            "CYCLE" | "CUTCOM" | "TRACUT" | "ROTABL" | "ROTHED"
                if words.first().is_some_and(|word| word == "OFF" || word == "NOMORE") => {}
            _ if is_in_list(word, REFUSED) => {
                return RobotFault::not_followed(
                    "circles, cycles, compensation, turned tables and computed motions are",
                    "GOTO/x,y,z,i,j,k",
                );
            }
            _ if major.contains('=') || is_in_list(word, IGNORED) => {}
            _ => {
                let known = self.options.calls_kept.iter().any(|kept| kept.eq_ignore_ascii_case(word));
                if !known {
                    return Err(RobotFault::Call { name: word.to_owned() });
                }
            }
        }
        Ok(None)
    }

    /// Returns the unit of a FEDRAT record; `has` tells whether the record has a word.
    fn feed_unit(&self, has: &dyn Fn(&str) -> bool) -> FeedUnit {
        match () {
            () if has("MMPM") => FeedUnit::PerMinute(1.0),
            () if has("IPM") => FeedUnit::PerMinute(INCH_MM),
            () if has("MMPR") => FeedUnit::PerTurn(1.0),
            () if has("IPR") => FeedUnit::PerTurn(INCH_MM),
            () if has("PERREV") || has("UPR") => FeedUnit::PerTurn(self.unit_mm),
            () if has("INVERS") || has("INVRS") => FeedUnit::Other,
            () => FeedUnit::PerMinute(self.unit_mm),
        }
    }

    /// Returns the statement of GOTO, FROM or GODLTA (`word`), whose numbers `minor` begin at byte `minor_at` of the source.
    fn motion(
        &mut self,
        word: &str,
        at: Range<usize>,
        line: usize,
        minor: &[u8],
        minor_at: usize,
    ) -> Result<Statement, RobotFault> {
        let expected = RobotFault::Form { expected: "three plain numbers x,y,z, or six with the tool axis i,j,k" };
        let (mut scan, mut numbers) = (Scan::new(minor), Vec::new());
        loop {
            let (value, range) = scan.number()?;
            let entry = numbers.len();
            let component = if entry < 3 { Component::Position(entry) } else { Component::Rotation(entry - 3) };
            numbers.push(Number { component, at: range, value });
            if !scan.takes(b',') {
                break;
            }
        }
        if !scan.is_done() || !matches!(numbers.len(), 3 | 6) || (word == "GODLTA" && numbers.len() != 3) {
            return Err(expected);
        }
        let (first, last) = (numbers[0].at.start, numbers[numbers.len() - 1].at.end);
        for number in &mut numbers {
            number.at = number.at.start - first..number.at.end - first;
        }
        let pose = minor_at + first..minor_at + last;
        let kind = if self.is_rapid || word == "FROM" { MotionKind::PointToPoint } else { MotionKind::Line };
        self.is_rapid &= word == "FROM";
        let keyword = at.start..at.start + word.len();
        Ok(Statement {
            end: Some(Target { at: pose.clone(), text: self.source[pose.clone()].to_vec(), numbers }),
            suffix: pose.end..at.end,
            is_step: word == "GODLTA",
            ..self.statement(at, line, keyword, kind)
        })
    }

    /// Creates a statement without target, with the modes in force.
    fn statement(&self, at: Range<usize>, line: usize, keyword: Range<usize>, kind: MotionKind) -> Statement {
        let feed = self.feed.and_then(|(feed, unit)| match unit {
            FeedUnit::PerMinute(mm) => Some(feed * mm),
            FeedUnit::PerTurn(mm) => Some(feed * mm * self.spindle_rev_per_min?),
            FeedUnit::Other => None,
        });
        Statement {
            frames: Frames { unit_mm: self.unit_mm, ..Frames::default() },
            feed_mm_per_min: feed.filter(|feed| *feed > 0.0),
            spindle_rev_per_min: self.spindle_rev_per_min,
            tool: self.tool,
            ..Statement::new(at, line, keyword, kind)
        }
    }
}

/// Returns the range of a line's code without its comment (`$$`), and whether `$` continues it on the next line.
fn code_range(source: &[u8], line: Range<usize>) -> (Range<usize>, bool) {
    let text = &source[line.clone()];
    // A byte order mark is no code.
    let start = if text.starts_with(b"\xef\xbb\xbf") { line.start + 3 } else { line.start };
    let is_text = TEXTS.iter().any(|word| {
        let text = text.trim_ascii_start();
        text.get(..word.len()).is_some_and(|begin| begin.eq_ignore_ascii_case(word.as_bytes()))
    });
    let dollar = text.iter().position(|byte| *byte == b'$').filter(|_| !is_text);
    match dollar {
        Some(at) if text.get(at + 1) == Some(&b'$') => (start..(line.start + at).max(start), false),
        Some(at) => (start..line.start + at + 1, true),
        None => (start..line.end, false),
    }
}

/// Splits a record at its commas into words and numbers, in upper case.
fn minor_words(minor: &[u8]) -> Vec<String> {
    let text = String::from_utf8_lossy(minor).to_ascii_uppercase();
    text.split(',').map(|word| word.trim().to_owned()).collect()
}

/// Whether the numbers among `words` are a direction along +z.
fn is_z_axis(words: &[String]) -> bool {
    let numbers: Vec<f64> = words.iter().filter_map(|word| word.parse().ok()).collect();
    matches!(numbers.as_slice(), [x, y, z] if *x == 0.0 && *y == 0.0 && *z > 0.0)
}

/// Records of free text, in which `$` has no meaning.
const TEXTS: [&str; 6] = ["PPRINT", "PARTNO", "REMARK", "TPRINT", "LETTER", "PPFUN"];

/// Records that are refused: they move the tool in other ways, or change what motions mean.
const REFUSED: &str = "CIRCLE MOVARC CYCLE CUTCOM TRACUT REFSYS TRANS ROTATE ROTABL ROTHED ORIGIN COPY CALL MACRO TERMAC LOOPST \
    LOOPND JUMPTO IF GOLFT GORGT GOFWD GOBACK GOUP GODOWN GO INDIRP INDIRV PSIS THICK TLLFT TLRGT TLON TLAXIS \
    POLYGO NURBS SPLINE INSERT";

/// Records that are ignored: they neither move the tool nor change what motions mean.
const IGNORED: &str = "PPRINT PARTNO REMARK TPRINT LETTER PPFUN MACHIN MULTAX COOLNT CUTTER TLDATA TOOL TOOLNO SELCTL TURRET UNLOAD \
    INTOL OUTTOL TOLER MAXANG MAXDP AUXFUN PREFUN OPSTOP STOP DELAY DWELL END END-OF-PATH FINI SEQNO OPTIOM \
    OPSKIP CLEARP CLAMP CLRSRF PAINT TMARK DISPLAY PLABEL CLPRNT NOPOST PRINT PUNCH LINTOL BREAK CHECK ARCSLP \
    LEADER REWIND RESET SET ISN AIR";

/// Whether `word` is one of the blank-separated `words`.
fn is_in_list(word: &str, words: &str) -> bool {
    words.split_whitespace().any(|listed| listed == word)
}
