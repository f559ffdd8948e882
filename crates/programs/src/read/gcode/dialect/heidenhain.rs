//! Heidenhain's conversational programs, block by block: the first words of a block say what it is.

use crate::{
    model::{
        Plane,
        gcode::{Fault, Foreign, ForeignWord, GWord, LengthUnit, Refusal, Setting, Unsupported, Word},
    },
    read::{
        gcode::{
            Statement,
            dialect::{
                block_numbers, heidenhain_plane,
                heidenhain_words::{self, OF_MACHINE, OF_TIP, Verb},
            },
            lines,
        },
        scan::Scan,
    },
};

/// A reader of the blocks of a Heidenhain program.
#[derive(Default)]
pub(crate) struct Reader {
    /// The block that the next line continues, as `~` at the end of a line says.
    continued: Option<Continued>,
    /// Feed of the last TOOL CALL.
    tool_feed: Option<f64>,
    /// Whether words of contours are returned, not refused.
    follows_contours: bool,
    has_begun: bool,
}

/// Kind of a block of several lines.
#[derive(Clone, Copy, PartialEq)]
enum Continued {
    /// A block that does not change where the tool goes.
    Passive,
    /// A comment with a block number.
    Comment,
    /// CYCL DEF 247, which sets a preset.
    Preset,
}

static MILLIMETRE: ForeignWord = ForeignWord { name: "MM", meaning: GWord::Unit(LengthUnit::Millimetre) };
static INCH: ForeignWord = ForeignWord { name: "INCH", meaning: GWord::Unit(LengthUnit::Inch) };
static END: ForeignWord = ForeignWord { name: "END PGM", meaning: GWord::End };
static TOOL_Z: ForeignWord = ForeignWord { name: "Z", meaning: GWord::Plane(Plane::Xy) };
static TOOL_Y: ForeignWord = ForeignWord { name: "Y", meaning: GWord::Plane(Plane::Zx) };
static TOOL_X: ForeignWord = ForeignWord { name: "X", meaning: GWord::Plane(Plane::Yz) };
static SHIFT: ForeignWord =
    ForeignWord { name: "CYCL DEF 7", meaning: GWord::Setting(Setting::Translation { afresh: false }) };
static PRESET: ForeignWord = ForeignWord { name: "CYCL DEF 247", meaning: GWord::Preset };

/// Accepted forms of FUNCTION TCPM.
const TCPM: [&str; 2] = ["F TCP AXIS POS PATHCTRL AXIS", "F TCP AXIS POS PATHCTRL AXIS REFPNT TIP-TIP"];

impl Reader {
    /// Starts before the first line of a program whose contours are written out.
    pub fn of_contours() -> Reader {
        Reader { follows_contours: true, ..Reader::default() }
    }

    /// Parses the next line into words; lines that do not change where the tool goes have none.
    pub fn parse_line(&mut self, line: &[u8]) -> Result<Statement, Refusal> {
        let is_continued = line.trim_ascii_end().ends_with(b"~");
        let number = block_numbers::leading_number(line);
        // In a program with numbers, a block that has one is a new one.
        self.continued = self.continued.filter(|block| *block != Continued::Comment || number.is_none());
        if let Some(block) = self.continued {
            self.continued = self.continued.filter(|_| is_continued);
            let words = if block == Continued::Preset { preset_words(Scan::of_line(line, 0))? } else { Vec::new() };
            if block == Continued::Preset && words.is_empty() && !is_continued {
                return Err(Scan::of_line(line, 0).refuse_all(lines::prefix_len(line), Foreign::NoPreset));
            }
            // What goes on behind it sets nothing more.
            if !words.is_empty() {
                self.continued = self.continued.map(|_| Continued::Passive);
            }
            return Ok(Statement::Words { words, prefix: 0 });
        }
        let has_number = number.is_some();
        let start = number.map_or_else(|| lines::prefix_len(line), |(range, _)| range.end);
        let mut scan = Scan::of_line(line, start);
        scan.next();
        let prefix = scan.at;
        // A heading of the program's outline, or what simulators note before the program.
        let is_empty = matches!(scan.peek(), None | Some(b'*')) || (scan.peek() == Some(b'(') && !self.has_begun);
        self.has_begun |= !is_empty;
        let words = if is_empty { Vec::new() } else { self.block_words(scan, is_continued)? };
        if is_continued && !is_empty {
            self.continued.get_or_insert(Continued::Passive);
        } else if is_continued && has_number {
            self.continued = Some(Continued::Comment);
        }
        Ok(Statement::Words { words, prefix })
    }

    /// Returns the words of the block at the cursor. `is_continued`: a `~` ends its line, which motions cannot have.
    fn block_words(&mut self, mut scan: Scan, is_continued: bool) -> Result<Vec<Word>, Refusal> {
        let start = scan.at;
        let name = scan.take_letters();
        let verb = match name.as_str() {
            "L" => Verb::Line,
            "C" => Verb::Arc,
            "CR" => Verb::ArcByRadius,
            "CC" => Verb::Centre,
            "LP" if self.follows_contours => Verb::PolarLine,
            "CP" if self.follows_contours => Verb::PolarArc,
            "CT" | "CTP" if self.follows_contours => Verb::TangentialArc,
            "RND" | "CHF" if self.follows_contours => return heidenhain_words::corner_words(scan, &name, start),
            "M" => Verb::None,
            _ => return self.other_block_words(&name, scan, start),
        };
        if is_continued {
            return Err(scan.refuse_all(start, Foreign::Continued));
        }
        if verb == Verb::None {
            scan.at = start;
        }
        heidenhain_words::motion_words(scan, verb, start, self.tool_feed)
    }

    /// Returns the words of a block that begins with `name`, at byte `start`, and is no motion; `Err` if it is not followed.
    fn other_block_words(&mut self, name: &str, mut scan: Scan, start: usize) -> Result<Vec<Word>, Refusal> {
        scan.next();
        let scan = scan;
        let mut rest = scan;
        let second = rest.take_letters();
        let refuse = |foreign: Foreign| Err(scan.refuse_all(start, foreign));
        match (name, second.as_str()) {
            ("BEGIN", "PGM") => unit_word(scan, start),
            ("END", "PGM") => Ok(vec![Word { meaning: Some(&END), ..Word::plain('G', 0.0, start..rest.at) }]),
            ("BLK", _) | ("TOOL", "DEF") | ("STOP" | "LBL", _) => Ok(Vec::new()),
            ("FUNCTION", "RESET") if ends_with(&rest, "TCPM") => Ok(vec![g_word(&OF_MACHINE, start..scan.line.len())]),
            ("FUNCTION", "RESET") => Ok(Vec::new()),
            // Rotary axes turn evenly to their own angles; with others the tool would turn otherwise.
            ("FUNCTION", "TCPM") if TCPM.contains(&rest_of_line(&rest).as_str()) => {
                Ok(vec![g_word(&OF_TIP, start..scan.line.len())])
            }
            ("FUNCTION", "MODE") if ends_with(&rest, "MILL") => Ok(Vec::new()),
            ("PLANE", _) => heidenhain_plane::plane_words(rest, &second, start),
            ("TOOL", "CALL") => self.tool_call_words(rest),
            ("CYCL", "DEF") => self.cycle_words(rest, start),
            ("CALL", "LBL") | ("IF", _) => refuse(Foreign::Flow),
            ("CALL" | "SEL", _) => refuse(Foreign::Call),
            ("FN", _) if matches!(scan.line.get(scan.at..), Some([b'9', ..] | [b'1', b'0'..=b'2', ..])) => {
                refuse(Foreign::Flow)
            }
            ("FN", _) => refuse(Foreign::Parameter),
            ("Q" | "QL" | "QR" | "QS" | "DECLARE", _) => refuse(Foreign::Parameter),
            ("CYCL" | "PATTERN" | "TCH", _) => refuse(Foreign::Cycle),
            ("FUNCTION" | "LN", _) => refuse(Foreign::Kinematics),
            ("LP" | "CP" | "CTP" | "TRANS", _) => refuse(Foreign::Frame),
            ("CT" | "APPR" | "DEP" | "SPL", _) => refuse(Foreign::Motion),
            ("FL" | "FLT" | "FC" | "FCT" | "FPOL" | "FSELECT", _) => refuse(Foreign::Motion),
            ("RND" | "CHF", _) => refuse(Foreign::Corner),
            _ => refuse(Foreign::Unknown),
        }
    }

    /// Returns the words of TOOL CALL (the tool, the plane by its axis, S and F), and keeps F for F AUTO.
    fn tool_call_words(&mut self, mut scan: Scan) -> Result<Vec<Word>, Refusal> {
        let mut words = Vec::new();
        scan.next();
        if let Some((number, range)) = scan.take_decimal()? {
            words.push(Word::plain('T', number, range.clone()));
            words.push(Word::plain('M', 6.0, range));
        }
        while let Some(byte) = scan.next() {
            let start = scan.at;
            if byte == b'"' {
                scan.skip_closed(b'"', b'"')?;
                continue;
            }
            if scan.take_decimal()?.is_some() {
                // How much it is longer or thicker than its table says.
                continue;
            }
            let letters = scan.take_letters();
            let plane = match letters.as_str() {
                "Z" => &TOOL_Z,
                "Y" => &TOOL_Y,
                "X" => &TOOL_X,
                "DL" | "DR" => continue,
                "S" | "F" => {
                    let letter = if letters == "S" { 'S' } else { 'F' };
                    let word = heidenhain_words::coordinate_word(&mut scan, letter, None, start)?;
                    if letter == 'F' {
                        self.tool_feed = Some(word.value);
                    }
                    words.push(word);
                    continue;
                }
                "U" | "V" | "W" => {
                    return Err(scan.refuse(start, Fault::Unsupported(Unsupported::SecondaryAxis)));
                }
                "Q" | "QL" | "QR" | "QS" | "SQ" | "FQ" => return Err(scan.refuse(start, Foreign::Parameter)),
                _ => return Err(scan.refuse(start, Foreign::Unknown)),
            };
            words.push(Word { meaning: Some(plane), ..Word::plain('G', 0.0, start..scan.at) });
        }
        Ok(words)
    }

    /// Returns the words of CYCL DEF: a datum shift, a preset, or none for cycles that do not move the tool. `Err` for other cycles.
    fn cycle_words(&mut self, mut scan: Scan, start: usize) -> Result<Vec<Word>, Refusal> {
        scan.next();
        let refuse = |foreign: Foreign| Err(scan.refuse_all(start, foreign));
        let mut rest = scan;
        let Some((number, range)) = rest.take_decimal()? else { return refuse(Foreign::Cycle) };
        let is_continued = scan.line.trim_ascii_end().ends_with(b"~");
        match number.trunc() as u32 {
            7 if is_continued => refuse(Foreign::ContinuedShift),
            7 if scan.upper_text(range.clone()).ends_with(".0") => Ok(Vec::new()),
            7 => {
                if rest.next() == Some(b'#') {
                    return refuse(Foreign::DatumTable);
                }
                let mut words = vec![Word { meaning: Some(&SHIFT), ..Word::plain('G', 0.0, start..start + 4) }];
                words.extend(heidenhain_words::coordinate_words(rest)?);
                Ok(words)
            }
            247 => {
                let words = preset_words(rest)?;
                self.continued = match (is_continued, words.is_empty()) {
                    (true, true) => Some(Continued::Preset),
                    (true, false) => Some(Continued::Passive),
                    (false, true) => return refuse(Foreign::NoPreset),
                    (false, false) => None,
                };
                Ok(words)
            }
            9 | 13 | 32 => Ok(Vec::new()),
            8 | 10 | 11 | 26 => refuse(Foreign::Frame),
            19 if scan.upper_text(range).ends_with(".0") => Ok(Vec::new()),
            // Without angles it ends the inclined plane.
            19 if rest.next().is_none() => Ok(vec![g_word(&heidenhain_plane::OFF, start..start + 4)]),
            19 => refuse(Foreign::Kinematics),
            12 => refuse(Foreign::Call),
            _ => refuse(Foreign::Cycle),
        }
    }
}

/// Returns the word of the unit of BEGIN PGM, its last word; `Err` if it is neither MM nor INCH.
fn unit_word(scan: Scan, start: usize) -> Result<Vec<Word>, Refusal> {
    let text = scan.line.trim_ascii_end();
    let length = text.iter().rev().take_while(|byte| byte.is_ascii_alphabetic()).count();
    let span = text.len() - length..text.len();
    let unit = match scan.upper_text(span.clone()).as_str() {
        "MM" => &MILLIMETRE,
        "INCH" => &INCH,
        _ => return Err(scan.refuse_all(start, Foreign::NoUnit)),
    };
    Ok(vec![Word { meaning: Some(unit), ..Word::plain('G', 0.0, span) }])
}

/// Returns the word of the preset number behind `Q339=`; none if the line does not have it.
fn preset_words(mut scan: Scan) -> Result<Vec<Word>, Refusal> {
    let Some(at) = scan.line.windows(4).position(|text| text.eq_ignore_ascii_case(b"Q339")) else {
        return Ok(Vec::new());
    };
    scan.at = at + 4;
    if !scan.takes(b'=') {
        return Err(scan.refuse(at, Foreign::NoNumber));
    }
    Ok(vec![Word { meaning: Some(&PRESET), ..heidenhain_words::coordinate_word(&mut scan, 'G', None, at)? }])
}

/// Returns the rest of the line, in upper case with single blanks.
fn rest_of_line(scan: &Scan) -> String {
    let rest = scan.upper_text(scan.at..scan.line.len());
    rest.split_ascii_whitespace().collect::<Vec<_>>().join(" ")
}

/// Creates a G word with this meaning that spans the bytes `span`.
pub(crate) fn g_word(meaning: &'static ForeignWord, span: std::ops::Range<usize>) -> Word {
    Word { meaning: Some(meaning), ..Word::plain('G', 0.0, span) }
}

/// Whether the rest of the line ends with `word`, which is upper case.
fn ends_with(scan: &Scan, word: &str) -> bool {
    scan.upper_text(scan.at..scan.line.len()).trim_end().ends_with(word)
}
