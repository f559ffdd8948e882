//! Writes a G-code program back with other feeds: F words change or are added, all else stays byte for byte.

use std::{
    collections::{BTreeMap, BTreeSet},
    ops::Range,
};

use thiserror::Error;

use crate::{
    expand::edit::LineEdit,
    model::{
        Rewritten,
        gcode::{Dialect, FeedMode, GWord, GcodeError, MotionCode, Word},
        number::{decimals_in, format_plain, format_shortest},
    },
    read::gcode::{Block, CalledFile, GcodeProgram, effective_words, lines},
    write::gcode::{Calls, FoldFailure},
};

/// Largest share by which a feed is rounded down.
const ROUNDED: f64 = 0.005;
/// Equal feeds, as a share: one may come through inches.
const SAME: f64 = 1e-9;

/// Why the feeds of a program cannot be changed.
#[derive(Debug, Error)]
pub enum FeedFault {
    /// The program cannot be followed.
    #[error(transparent)]
    Program(#[from] GcodeError),
    /// A line, from 1, beside which no feed can be changed, and why.
    #[error("line {line} {why}")]
    Line {
        /// The line, from 1.
        line: usize,
        /// Why, as a verb with what belongs to it.
        why: &'static str,
    },
    /// Calls that leave a line no feed of its own.
    #[error("{0}")]
    Calls(FoldFailure),
}

/// A line of a program that moves the tool at feed rate.
#[derive(Clone, Debug, PartialEq)]
pub struct FedLine {
    /// Indices of its motions.
    pub motions: Range<usize>,
    /// File and line that it comes from. A line that runs several times is written once.
    pub place: (usize, usize),
    /// Whether its feed is bound to the spindle: a tap's.
    pub is_bound: bool,
    /// Index of the line as read.
    line: usize,
    mode: FeedMode,
    /// How many mm one unit of F is.
    unit_mm: f64,
    /// The number after F that is in force there.
    number: f64,
    /// As it is written in the program.
    text: String,
    has_word: bool,
    /// What has become of the feed in force since the fed line before.
    since: Since,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Since {
    Stays,
    /// A line has set it.
    Set,
    /// It is what M70 has saved, or that of a line before which may be switched off: not known.
    Restored,
}

/// What the words of a line, whether it moves the tool or not, make of the feed in force.
#[derive(Clone, Debug)]
struct FeedWords {
    /// Index of the line, from 0.
    line: usize,
    /// Bytes of the number after F in the line.
    number: Option<Range<usize>>,
    /// Whether M72 restores the feed that was saved.
    restores: bool,
    /// Whether the line moves to positions of the machine (G53, and Sinumerik's G153 and SUPA).
    to_machine: bool,
    /// Whether it is a dwell.
    dwells: bool,
    /// Whether it makes the motion a rapid one; `None` where it names none.
    is_rapid: Option<bool>,
}

impl FeedWords {
    fn of(line: usize, words: &[Word], dialect: Dialect) -> Self {
        let number = effective_words(words).iter().find(|word| word.letter == 'F').map(Word::number);
        let restores = words.iter().any(|word| word.mode_save_code(dialect) == Some(72));
        let mut own = Self { line, number, restores, to_machine: false, dwells: false, is_rapid: None };
        for word in words {
            let meaning = match word.meaning {
                Some(vocable) => Some(vocable.meaning),
                None if word.letter == 'G' => dialect.g_word(word).ok(),
                None => None,
            };
            match meaning {
                Some(GWord::Machine) => own.to_machine = true,
                Some(GWord::Dwell) => own.dwells = true,
                Some(GWord::Motion(code)) => own.is_rapid = Some(code == MotionCode::Rapid),
                _ => {}
            }
        }
        own
    }
}

impl FedLine {
    /// Whether both lines have the same feed in force.
    pub fn has_feed_of(&self, other: &FedLine) -> bool {
        self.mode == other.mode && is_same(self.own(), other.own())
    }

    /// Returns the number after F that is `ratio` times the programmed one, rounded down, though not below the `least` ratio; `None` for the programmed one.
    pub fn scaled(&self, ratio: f64, least: f64) -> Option<String> {
        if is_same(ratio, 1.0) {
            return None;
        }
        let wanted = self.number * ratio;
        let decimals = (-libm::log10(ROUNDED * wanted).floor()).clamp(0.0, 6.0) as i32;
        let [coarse, fine] = [decimals, decimals + 2].map(|decimals| 10f64.powi(decimals));
        let down = (wanted * coarse * (1.0 + SAME)).floor() / coarse;
        let rounded = if down < least * self.number { (wanted * fine * (1.0 - SAME)).ceil() / fine } else { down };
        // A control may read a number without point in another unit.
        Some(match self.text.contains('.') {
            true => format_shortest(rounded, decimals_in(&self.text).min(1) as u8),
            false => format_plain(rounded),
        })
    }

    /// Returns by how much the feed of `number`, or of `None` the programmed one, is larger than the programmed one.
    pub fn ratio_of(&self, number: Option<&String>) -> f64 {
        number.and_then(|own| own.parse::<f64>().ok()).map_or(1.0, |own| own / self.number)
    }

    fn own(&self) -> f64 {
        self.number * self.unit_mm
    }
}

fn is_same(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME * b.abs()
}

impl GcodeProgram {
    /// Returns the lines that move the tool at a feed that is known.
    ///
    /// # Errors
    /// A program that cannot be followed, or with a line beside which no feed can be changed.
    pub fn fed_lines(&self) -> Result<Vec<FedLine>, FeedFault> {
        let mut lines: Vec<FedLine> = Vec::new();
        let (mut motions, mut since, mut text, mut mode) = (0, Since::Stays, String::new(), None);
        let (mut unfit, mut is_at_feed) = (None, false);
        // A call that begins with / may set the feed, or not.
        let deletes_calls = self.expansion.as_ref().is_some_and(|expansion| {
            expansion.files.iter().any(|file| file.bytes.split(|byte| *byte == b'\n').any(lines::is_deletable))
        });
        let look = |line: usize, words: &[Word]| FeedWords::of(line, words, self.dialect);
        self.walk_words(look, |block, words| {
            let first = motions;
            motions += block.map_or(0, |block| block.motions.len());
            is_at_feed = words.is_rapid.map_or(is_at_feed, |is_rapid| !is_rapid);
            if words.to_machine && is_at_feed {
                unfit = unfit.or(Some((words.line + 1, "moves by feed to a position of the machine (G53, SUPA), where the feed that is changed before would hold")));
            }
            if words.dwells && words.number.is_some() && self.dialect != Dialect::Sinumerik {
                unfit = unfit.or(Some((words.line + 1, "has F beside G4, which some controls take for a time and others for a feed")));
            }
            let fed = block.and_then(|block| {
                let motion = block.motions.first().filter(|motion| motion.code != MotionCode::Rapid)?;
                Some((block.line, motion, motion.modal.feed.filter(|feed| *feed > 0.0)?))
            });
            if words.restores {
                since = Since::Restored;
            } else if words.number.is_some() && since != Since::Restored {
                since = Since::Set;
            }
            if let Some(number) = &words.number {
                text = String::from_utf8_lossy(&self.content(words.line)[number.clone()]).into_owned();
            }
            // With block delete switched on it does not run.
            let is_unsure = deletes_calls || lines::is_deletable(self.content(words.line));
            let Some((line, motion, feed)) = fed else {
                if is_unsure {
                    since = Since::Restored;
                }
                return Ok::<(), GcodeError>(());
            };
            if mode.replace(motion.modal.feed_mode).is_some_and(|own| own != motion.modal.feed_mode) {
                since = Since::Set;
            }
            let is_inverse = motion.modal.feed_mode == FeedMode::InverseTime;
            let unit_mm = if is_inverse { 1.0 } else { motion.modal.feed_unit_mm };
            let number = feed / unit_mm;
            if !text.parse::<f64>().is_ok_and(|own| is_same(own, number)) {
                text = format_plain(number);
            }
            let place = match &self.expansion {
                Some(expansion) if expansion.keeps_calls => {
                    let origin = expansion.origin(line + 1);
                    (origin.file, origin.line)
                }
                _ => (0, line),
            };
            lines.push(FedLine {
                motions: first..motions,
                place,
                is_bound: matches!(motion.code, MotionCode::Cycle(74 | 84)),
                line,
                mode: motion.modal.feed_mode,
                unit_mm,
                number,
                text: text.clone(),
                has_word: words.number.is_some(),
                since,
            });
            since = if is_unsure { Since::Restored } else { Since::Stays };
            Ok(())
        })?;
        unfit.map_or(Ok(lines), |(line, why)| Err(FeedFault::Line { line, why }))
    }

    /// Returns the program, read again, with these numbers after F on its fed `lines` (`None`: the programmed one), and how many F words it has that are new.
    ///
    /// # Errors
    /// A program that cannot be followed, or whose calls leave a line no feed of its own.
    pub fn with_feeds(
        &self,
        lines: &[FedLine],
        numbers: &[Option<String>],
    ) -> Result<(GcodeProgram, usize), FeedFault> {
        let mut in_force = None;
        let mut written = BTreeSet::new();
        for (line, number) in lines.iter().zip(numbers) {
            let wanted = line.own() * line.ratio_of(number.as_ref());
            match line.since {
                Since::Set => in_force = Some(line.own()),
                Since::Restored => in_force = None,
                Since::Stays => {}
            }
            if !in_force.is_some_and(|own| is_same(own, wanted)) {
                written.insert(line.place);
            }
            in_force = Some(wanted);
        }
        if numbers.iter().all(Option::is_none) {
            written.clear();
        }
        let edits = lines.iter().zip(numbers).filter(|(line, _)| written.contains(&line.place));
        let edits: BTreeMap<usize, (&FedLine, &str)> =
            edits.map(|(line, number)| (line.line, (line, number.as_ref().unwrap_or(&line.text).as_str()))).collect();
        let (mut bytes, mut line_ends) = (Vec::with_capacity(self.source.len()), Vec::with_capacity(self.lines.len()));
        let copy_to = |bytes: &mut Vec<u8>, line_ends: &mut Vec<usize>, end: usize| {
            for line in line_ends.len()..end {
                bytes.extend_from_slice(&self.source[self.lines.content(line).start..self.lines.ending(line).end]);
                line_ends.push(bytes.len());
            }
        };
        self.walk(|block: &Block| {
            let Some((line, number)) = edits.get(&block.line) else { return Ok::<(), GcodeError>(()) };
            copy_to(&mut bytes, &mut line_ends, block.line);
            let words = block.motions.first().map_or(&[][..], |motion| &motion.words);
            let mut edit = LineEdit::new(self.content(block.line), words, self.style);
            match edit.find(|word| word.letter == 'F').filter(|_| line.has_word) {
                Some(index) => edit.set_number(index, number),
                None => edit.add_last('F', number),
            }
            bytes.extend(edit.render());
            bytes.extend_from_slice(&self.source[self.lines.ending(block.line)]);
            line_ends.push(bytes.len());
            Ok(())
        })?;
        copy_to(&mut bytes, &mut line_ends, self.lines.len());
        let reading = (self.name.clone(), self.options.clone());
        let rewritten = Rewritten { bytes, pieces: Vec::new(), parameters: Vec::new(), line_ends, reading };
        let program = match self.folded_calls(&rewritten) {
            Some(Calls::WrittenOut(failure)) => return Err(FeedFault::Calls(failure)),
            Some(Calls::Stay { program, beside }) => {
                let of = |name: &str| {
                    beside.iter().find(|file| file.name == name).map(|CalledFile { bytes, .. }| bytes.clone())
                };
                GcodeProgram::parse_with_calls(program, &self.name, &self.options, &of)?
            }
            None => {
                let mut program = rewritten.read()?;
                if self.expansion.is_some() {
                    program.expansion.clone_from(&self.expansion);
                    program.notes.clone_from(&self.notes);
                    program.own_format = self.own_format;
                }
                program
            }
        };
        Ok((program, written.len()))
    }
}
