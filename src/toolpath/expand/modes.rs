//! Modes that M70 and M73 keep and M72 or the end of a subprogram restores: in what is written out, as words, since the one place a
//! control keeps them in for the main program would have to hold those of every call.

use std::collections::BTreeMap;

use crate::toolpath::{
    expand::{
        line::{CalledWord, SourceLine},
        run::Run,
    },
    model::{
        gcode::{ArcCentres, Contradiction, Dialect, Fault, GWord, GcodeOptions, LengthUnit, Setting, Word},
        plain,
    },
    read::gcode::{
        check_keeps, lex,
        lines::{self, Code},
    },
};

/// What is kept, by modal group, and the words that it begins with.
const KEPT: [(&str, &str); 13] = [
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
/// The letters of lengths, as G43.1 has them.
const LENGTHS: &str = "XYZUVW";
/// The others with a P of their own.
const OVERRIDES: [(&str, &str); 3] =
    [("speed override", "M51 P1"), ("adaptive feed", "M52 P0"), ("feed hold", "M53 P1")];

/// The words in force.
#[derive(Clone, Debug)]
pub(crate) struct Modes {
    words: BTreeMap<&'static str, String>,
    /// What G43.1 has set since, and the unit that it was written in.
    lengths: BTreeMap<char, (f64, LengthUnit)>,
    /// As it is written, and the unit that it was written in.
    feed: Option<(f64, String, LengthUnit)>,
    speed: Option<String>,
}

/// What is kept at one level of calls.
#[derive(Debug, Default)]
pub(crate) struct Frame {
    kept: Option<Modes>,
    /// Whether it is restored at the end of the subprogram.
    restores: bool,
    /// Whether it was called by LinuxCNC's `o… call`.
    pub by_o_word: bool,
}

impl Modes {
    pub fn new(options: &GcodeOptions) -> Modes {
        let mut words: BTreeMap<_, _> =
            KEPT.into_iter().chain(OVERRIDES).map(|(group, word)| (group, word.to_owned())).collect();
        if options.unit == Some(LengthUnit::Inch) {
            words.insert("unit", "G20".to_owned());
        }
        if options.arc_centres == ArcCentres::Absolute {
            words.insert("centres", "G90.1".to_owned());
        }
        Modes { words, lengths: BTreeMap::new(), feed: None, speed: None }
    }

    fn unit(&self) -> LengthUnit {
        if self.words["unit"] == "G20" { LengthUnit::Inch } else { LengthUnit::Millimetre }
    }

    /// Takes the words of a line that is written.
    fn see(&mut self, words: &[Word], dialect: Dialect) {
        let written = |word: &Word| format!("{}{}", word.letter, plain(word.value));
        let of_letters: BTreeMap<char, &Word> = words.iter().map(|word| (word.letter, word)).collect();
        let with = |word: &Word, letters: &[char]| {
            let own = letters.iter().filter_map(|letter| of_letters.get(letter)).map(|word| written(word));
            std::iter::once(written(word)).chain(own).collect::<Vec<_>>().join(" ")
        };
        for word in words {
            match (word.letter, word.whole().ok()) {
                ('G', _) => {
                    let own = GWord::of(word, dialect);
                    if let Ok(GWord::Setting(Setting::Length)) = own {
                        let unit = self.unit();
                        let given = words.iter().filter(|word| LENGTHS.contains(word.letter));
                        self.lengths.extend(given.map(|word| (word.letter, (word.value, unit))));
                    }
                    let group = own.map_or("", GWord::group);
                    if group == TOOL_LENGTH {
                        self.lengths.clear();
                    }
                    if let Some(text) = self.words.get_mut(group) {
                        *text = with(
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
                    let text = with(word, &['P']);
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

    /// The lines that lead from these to those that were `kept`. A feed is read in the unit in force before its line.
    fn lines_to(&self, kept: &Modes) -> Vec<String> {
        let differs = |group: &str| {
            self.words[group] != kept.words[group] || (group == TOOL_LENGTH && self.lengths != kept.lengths)
        };
        let mut lines: Vec<String> = differs("unit").then(|| kept.words["unit"].clone()).into_iter().collect();
        let mut words = Vec::new();
        for (group, _) in &KEPT[1..10] {
            words.extend(differs(group).then(|| kept.words[group].clone()));
        }
        let in_kept_unit = |value: f64, unit: LengthUnit| {
            let value = if unit == kept.unit() { value } else { value * unit.mm() / kept.unit().mm() };
            plain(value)
        };
        let is_other_feed = self.feed != kept.feed || differs("unit") || differs("feed mode");
        if is_other_feed && kept.words["feed mode"] != "G93" {
            words.push(match &kept.feed {
                Some((_, text, unit)) if *unit == kept.unit() => text.clone(),
                Some((value, _, unit)) => format!("F{}", in_kept_unit(*value, *unit)),
                None => "F0".to_owned(),
            });
        }
        if self.speed != kept.speed || differs("spindle mode") {
            words.push(kept.speed.clone().unwrap_or_else(|| "S0".to_owned()));
        }
        lines.extend((!words.is_empty()).then(|| words.join(" ")));
        if differs(TOOL_LENGTH) && !kept.lengths.is_empty() {
            let lengths =
                kept.lengths.iter().map(|(letter, (value, unit))| format!(" {letter}{}", in_kept_unit(*value, *unit)));
            lines.push(format!("G43.1{}", lengths.collect::<String>()));
        }
        if differs("coolant") {
            lines.push("M9".to_owned());
            lines.extend(kept.words["coolant"].lines().filter(|line| *line != "M9").map(String::from));
        }
        let with_p = KEPT[11..].iter().chain(&OVERRIDES);
        lines.extend(with_p.filter(|(group, _)| differs(group)).map(|(group, _)| kept.words[group].clone()));
        lines
    }
}

impl Run<'_> {
    /// What is written of a line: without the word, if it keeps or restores modes, and behind the words that restore them.
    pub(crate) fn kept_and_restored(&mut self, line: &SourceLine, bytes: Vec<u8>) -> Result<Vec<u8>, (usize, Fault)> {
        // What cannot be read is refused once all is written out.
        let Some(words) = words_of(&bytes) else { return Ok(bytes) };
        let keeps = words.iter().find_map(|word| Some((word, word.keeps_modes(self.dialect)?)));
        let Some((word, code)) = keeps else {
            self.modes.see(&words, self.dialect);
            return Ok(bytes);
        };
        let at = |fault| (line.begin, fault);
        check_keeps(&words, word, code).map_err(|refusal| at(refusal.fault))?;
        let is_main = self.frames.len() == 1;
        let Some(frame) = self.frames.last_mut() else { return Ok(bytes) };
        match code {
            72 => {
                let kept = frame.kept.clone().ok_or_else(|| at(Fault::NothingKept))?;
                self.restore(kept);
            }
            71 => frame.kept = None,
            73 if !is_main && !frame.by_o_word && self.dialect != Dialect::LinuxCnc => {
                return Err(at(Fault::Contradicts(Contradiction::KeptModes)));
            }
            _ => {
                frame.kept = Some(self.modes.clone());
                // A later M70 says to what, not whether.
                frame.restores |= code == 73 && !is_main;
            }
        }
        self.modes.see(&words, self.dialect);
        let source = SourceLine::new(&bytes);
        let own = CalledWord { letter: 'M', value: Some(word.value), span: word.span.clone() };
        Ok(source.without(&[own]).map_or_else(Vec::new, |rest| rest.bytes))
    }

    /// A run through a subprogram ends.
    pub(crate) fn restore_at_return(&mut self) {
        let Some(frame) = self.frames.last_mut() else { return };
        let kept = frame.kept.take().filter(|_| frame.restores);
        frame.restores = false;
        if let Some(kept) = kept {
            self.restore(kept);
        }
    }

    fn restore(&mut self, kept: Modes) {
        for line in self.modes.lines_to(&kept) {
            self.write(line.into_bytes());
        }
        self.modes = kept;
    }
}

fn words_of(bytes: &[u8]) -> Option<Vec<Word>> {
    match lines::code(bytes).ok()? {
        Code::Words { text, .. } => lex::words(&text).ok(),
        _ => None,
    }
}
