//! Modes that M70 and M73 save and M72 or the end of a subprogram restores; an expanded program has words in their place.

use std::collections::BTreeMap;

use crate::{
    expand::{
        line::{CalledWord, SourceLine},
        run::Run,
    },
    model::{
        format_plain,
        gcode::{ArcCentres, Contradiction, Dialect, Fault, GWord, GcodeOptions, LengthUnit, Setting, Word},
    },
    read::gcode::{
        check_mode_save, lex,
        lines::{self, Code},
    },
};

/// Modal groups that are saved, with their words at the start.
const SAVED: [(&str, &str); 13] = [
    ("unit", "G21"),
    ("plane", "G17"),
    ("distance", "G90"),
    ("centres", "G91.1"),
    ("work offset", "G54"),
    (TOOL_LENGTH, "G49"),
    ("return level", "G98"),
    ("feed mode", "G94"),
    ("spindle mode", "G97"),
    ("spindle", "M5"),
    ("coolant", "M9"),
    // A P of its own, as those that follow.
    (PATH_CONTROL, "G64"),
    ("feed override", "M50 P1"),
];
const PATH_CONTROL: &str = "path control";
const TOOL_LENGTH: &str = "tool length";
/// Letters of the lengths of G43.1.
const LENGTHS: &str = "XYZUVW";
/// Groups whose words have a P of their own.
const OVERRIDES: [(&str, &str); 3] =
    [("speed override", "M51 P1"), ("adaptive feed", "M52 P0"), ("feed hold", "M53 P1")];

/// Words in force, by modal group.
#[derive(Clone, Debug)]
pub(crate) struct Modes {
    words: BTreeMap<&'static str, String>,
    /// Lengths that G43.1 has set since, and their units.
    lengths: BTreeMap<char, (f64, LengthUnit)>,
    /// Value of F, its word, and its unit.
    feed: Option<(f64, String, LengthUnit)>,
    speed: Option<String>,
}

/// Saved modes at one level of calls.
#[derive(Debug, Default)]
pub(crate) struct CallFrame {
    saved: Option<Modes>,
    /// Whether the end of the subprogram restores them.
    restores: bool,
    /// Whether LinuxCNC's `o… call` made the call.
    pub by_o_word: bool,
}

impl Modes {
    /// Modes at the start of a program.
    pub fn new(options: &GcodeOptions) -> Modes {
        let mut words: BTreeMap<_, _> =
            SAVED.into_iter().chain(OVERRIDES).map(|(group, word)| (group, word.to_owned())).collect();
        if options.unit == Some(LengthUnit::Inch) {
            words.insert("unit", "G20".to_owned());
        }
        if options.arc_centres == ArcCentres::Absolute {
            words.insert("centres", "G90.1".to_owned());
        }
        Modes { words, lengths: BTreeMap::new(), feed: None, speed: None }
    }

    /// Unit in force.
    fn unit(&self) -> LengthUnit {
        if self.words["unit"] == "G20" { LengthUnit::Inch } else { LengthUnit::Millimetre }
    }

    /// Updates the modes by the words of a line that is written.
    fn update(&mut self, words: &[Word], dialect: Dialect) {
        let written = |word: &Word| format!("{}{}", word.letter, format_plain(word.value));
        let by_letter: BTreeMap<char, &Word> = words.iter().map(|word| (word.letter, word)).collect();
        let with_parameters = |word: &Word, letters: &[char]| {
            let parameters = letters.iter().filter_map(|letter| by_letter.get(letter)).map(|word| written(word));
            std::iter::once(written(word)).chain(parameters).collect::<Vec<_>>().join(" ")
        };
        for word in words {
            match (word.letter, word.whole_number().ok()) {
                ('G', _) => {
                    let g_word = GWord::parse(word, dialect);
                    if let Ok(GWord::Setting(Setting::Length)) = g_word {
                        let unit = self.unit();
                        let given = words.iter().filter(|word| LENGTHS.contains(word.letter));
                        self.lengths.extend(given.map(|word| (word.letter, (word.value, unit))));
                    }
                    let group = g_word.map_or("", GWord::modal_group);
                    if group == TOOL_LENGTH {
                        self.lengths.clear();
                    }
                    if let Some(text) = self.words.get_mut(group) {
                        *text = with_parameters(
                            word,
                            match group {
                                PATH_CONTROL => &['P', 'Q'],
                                "work offset" => &['P'],
                                TOOL_LENGTH => &['H'],
                                "spindle mode" => &['D'],
                                _ => &[],
                            },
                        );
                    }
                }
                ('M', Some(3..=5)) => drop(self.words.insert("spindle", written(word))),
                ('M', Some(9)) => drop(self.words.insert("coolant", "M9".into())),
                ('M', Some(code @ (7 | 8))) => {
                    let both =
                        [7, 8].into_iter().filter(|m| *m == code || self.words["coolant"].contains(&format!("M{m}")));
                    let both = both.map(|m| format!("M{m}")).collect::<Vec<_>>().join("\n");
                    self.words.insert("coolant", both);
                }
                ('M', Some(code @ (48 | 49))) => {
                    for (group, m) in [("feed override", "M50"), ("speed override", "M51")] {
                        self.words.insert(group, format!("{m} P{}", u8::from(code == 48)));
                    }
                }
                ('M', Some(code @ 50..=53)) => {
                    let group = ["feed override", "speed override", "adaptive feed", "feed hold"][code as usize - 50];
                    let text = with_parameters(word, &['P']);
                    self.words.insert(group, if text.contains('P') { text } else { text + " P1" });
                }
                ('S', _) => self.speed = Some(written(word)),
                _ => {}
            }
        }
        if let Some(word) = words.iter().find(|word| word.letter == 'F') {
            self.feed = Some((word.value, written(word), self.unit()));
        }
    }

    /// Returns the lines that change these modes to those `saved`. F is read in the unit in force before its line.
    fn restoring_lines(&self, saved: &Modes) -> Vec<String> {
        let differs = |group: &str| {
            self.words[group] != saved.words[group] || (group == TOOL_LENGTH && self.lengths != saved.lengths)
        };
        let mut lines: Vec<String> = differs("unit").then(|| saved.words["unit"].clone()).into_iter().collect();
        let mut words = Vec::new();
        for (group, _) in &SAVED[1..10] {
            words.extend(differs(group).then(|| saved.words[group].clone()));
        }
        let in_unit = |value: f64, unit: LengthUnit| {
            let value = if unit == saved.unit() { value } else { value * unit.mm() / saved.unit().mm() };
            format_plain(value)
        };
        let is_other_feed = self.feed != saved.feed || differs("unit") || differs("feed mode");
        if is_other_feed && saved.words["feed mode"] != "G93" {
            words.push(match &saved.feed {
                Some((_, text, unit)) if *unit == saved.unit() => text.clone(),
                Some((value, _, unit)) => format!("F{}", in_unit(*value, *unit)),
                None => "F0".to_owned(),
            });
        }
        if self.speed != saved.speed || differs("spindle mode") {
            words.push(saved.speed.clone().unwrap_or_else(|| "S0".to_owned()));
        }
        lines.extend((!words.is_empty()).then(|| words.join(" ")));
        if differs(TOOL_LENGTH) && !saved.lengths.is_empty() {
            let lengths =
                saved.lengths.iter().map(|(letter, (value, unit))| format!(" {letter}{}", in_unit(*value, *unit)));
            lines.push(format!("G43.1{}", lengths.collect::<String>()));
        }
        if differs("coolant") {
            lines.push("M9".to_owned());
            lines.extend(saved.words["coolant"].lines().filter(|line| *line != "M9").map(String::from));
        }
        let with_p = SAVED[11..].iter().chain(&OVERRIDES);
        lines.extend(with_p.filter(|(group, _)| differs(group)).map(|(group, _)| saved.words[group].clone()));
        lines
    }
}

impl Run<'_> {
    /// Saves or restores modes by M70 to M73 in `bytes`, the evaluated `line`; returns them without that word. `Err` gives the faulty byte.
    pub(crate) fn save_or_restore(&mut self, line: &SourceLine, bytes: Vec<u8>) -> Result<Vec<u8>, (usize, Fault)> {
        // What cannot be read is refused once all is written out.
        let Some(words) = parse_words(&bytes) else { return Ok(bytes) };
        let mode_save = words.iter().find_map(|word| Some((word, word.mode_save_code(self.dialect)?)));
        let Some((word, code)) = mode_save else {
            self.modes.update(&words, self.dialect);
            return Ok(bytes);
        };
        let at = |fault| (line.begin, fault);
        check_mode_save(&words, word, code).map_err(|refusal| at(refusal.fault))?;
        let is_main = self.call_frames.len() == 1;
        let Some(frame) = self.call_frames.last_mut() else { return Ok(bytes) };
        match code {
            72 => {
                let saved = frame.saved.clone().ok_or_else(|| at(Fault::NothingKept))?;
                self.restore(saved);
            }
            71 => frame.saved = None,
            73 if !is_main && !frame.by_o_word && self.dialect != Dialect::LinuxCnc => {
                return Err(at(Fault::Contradicts(Contradiction::KeptModes)));
            }
            _ => {
                frame.saved = Some(self.modes.clone());
                // A later M70 says to what, not whether.
                frame.restores |= code == 73 && !is_main;
            }
        }
        self.modes.update(&words, self.dialect);
        let source = SourceLine::new(&bytes);
        let save_word = CalledWord { letter: 'M', value: Some(word.value), span: word.span.clone() };
        Ok(source.without_words(&[save_word]).map_or_else(Vec::new, |rest| rest.bytes))
    }

    /// Restores modes at the end of a run of a subprogram, if they were saved by M73.
    pub(crate) fn restore_at_return(&mut self) {
        let Some(frame) = self.call_frames.last_mut() else { return };
        let saved = frame.saved.take().filter(|_| frame.restores);
        frame.restores = false;
        if let Some(saved) = saved {
            self.restore(saved);
        }
    }

    /// Writes the lines that restore the modes `saved`, and puts them in force.
    fn restore(&mut self, saved: Modes) {
        for line in self.modes.restoring_lines(&saved) {
            self.write_line(line.into_bytes());
        }
        self.modes = saved;
    }
}

/// Returns the words of a line; `None` if it has none or cannot be read.
fn parse_words(bytes: &[u8]) -> Option<Vec<Word>> {
    match lines::parse_code(bytes).ok()? {
        Code::Words { text, .. } => lex::words(&text).ok(),
        _ => None,
    }
}
