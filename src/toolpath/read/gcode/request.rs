//! The words of one line, sorted by what they ask for.

use crate::toolpath::model::gcode::{Dialect, Fault, GWord, MotionCode, Refusal, Setting, Unsupported, Word};

/// What one line asks for, before any state is looked at.
#[derive(Debug)]
pub(crate) struct Request<'w> {
    words: &'w [Word],
    /// The G words, at most one of each group.
    pub g_words: Vec<(&'w Word, GWord)>,
    /// Whether M2 or M30 is among the words.
    pub ends_program: bool,
    /// Whether M6 is among the words.
    pub changes_tool: bool,
    /// M70 to M73, which keep and restore modes.
    pub keeps: Option<(&'w Word, u32)>,
}

impl<'w> Request<'w> {
    /// Sorts `words` and refuses what no state could make right.
    pub fn of(words: &'w [Word], dialect: Dialect) -> Result<Request<'w>, Refusal> {
        let changes_tool = words.iter().any(|word| word.letter == 'M' && word.value == 6.0);
        let mut request = Request { words, g_words: Vec::new(), ends_program: false, changes_tool, keeps: None };
        for (at, word) in words.iter().enumerate() {
            match (word.asks, word.letter) {
                (Some(vocable), _) => request.add_g(word, vocable.asks)?,
                (None, 'G') => request.add_g(word, dialect.g_word(word)?)?,
                (None, 'M') => request.add_m(word, dialect)?,
                (None, letter) => {
                    check_letter(word)?;
                    if words[..at].iter().any(|other| other.letter == letter) {
                        return Err(word.refuse(Fault::Repeated { letter }));
                    }
                }
            }
        }
        Ok(request)
    }

    fn add_g(&mut self, word: &'w Word, g: GWord) -> Result<(), Refusal> {
        self.ends_program |= g == GWord::End;
        if matches!(g, GWord::End | GWord::Auxiliary) {
            return Ok(());
        }
        if let Some((other, _)) = self.g_words.iter().find(|(_, other)| other.group() == g.group()) {
            let other = other.asks.map_or_else(|| format!("G{}", other.value), |vocable| vocable.name.to_owned());
            return Err(word.refuse(Fault::Conflict { other }));
        }
        self.g_words.push((word, g));
        Ok(())
    }

    fn add_m(&mut self, word: &'w Word, dialect: Dialect) -> Result<(), Refusal> {
        self.ends_program |= matches!(word.whole()?, 2 | 30);
        if let Some(unsupported) = Unsupported::of_m(word, self.words, dialect) {
            return Err(word.refuse(Fault::Unsupported(unsupported)));
        }
        if let Some(code) = word.keeps_modes(dialect) {
            check_keeps(self.words, word, code)?;
            self.keeps = Some((word, code));
        }
        Ok(())
    }

    /// L, P and Q must have a word to belong to; `in_cycle` says whether a cycle is in force.
    pub fn check_parameters(&self, in_cycle: bool) -> Result<(), Refusal> {
        let m = self.words.iter().any(|word| word.letter == 'M');
        let g = |test: fn(&GWord) -> bool| self.g_words.iter().any(|(_, g)| test(g));
        let setting = self.setting().is_some();
        let smoothing = g(|g| *g == GWord::Smoothing);
        // Of an arc, LinuxCNC reads P as turns.
        let of_m = m && self.arc_words().next().is_none();
        for (letter, owned) in [
            ('L', in_cycle || setting),
            ('P', in_cycle || setting || smoothing || of_m || g(GWord::takes_p)),
            ('Q', in_cycle || smoothing || m || g(GWord::takes_p)),
        ] {
            if let Some(word) = self.letter(letter).filter(|_| !owned) {
                return Err(word.refuse(Fault::StrayParameter));
            }
        }
        Ok(())
    }

    /// Whether the line leads to a place outside the workpiece frame.
    pub fn leaves(&self) -> bool {
        self.g_words.iter().any(|(_, g)| matches!(g, GWord::Home | GWord::Machine | GWord::Retract))
    }

    /// The word whose coordinates set something.
    pub fn setting(&self) -> Option<(&'w Word, Setting)> {
        self.g_words.iter().find_map(|(word, g)| match g {
            GWord::Setting(setting) => Some((*word, *setting)),
            _ => None,
        })
    }

    /// The word with this letter, which is not G or M.
    pub fn letter(&self, letter: char) -> Option<&'w Word> {
        self.words.iter().find(|word| word.letter == letter)
    }

    /// The word that does exactly `g`.
    pub fn g(&self, g: GWord) -> Option<&'w Word> {
        self.g_words.iter().find(|(_, other)| *other == g).map(|(word, _)| *word)
    }

    /// The motion word on the line.
    pub fn motion_word(&self) -> Option<MotionCode> {
        self.g_words.iter().find_map(|(_, g)| match g {
            GWord::Motion(code) => Some(*code),
            _ => None,
        })
    }

    /// The word itself.
    pub fn motion_word_itself(&self) -> Option<&'w Word> {
        self.g_words.iter().find(|(_, g)| matches!(g, GWord::Motion(_))).map(|(word, _)| *word)
    }

    /// The X, Y and Z words.
    pub fn axes(&self) -> [Option<&'w Word>; 3] {
        ['X', 'Y', 'Z'].map(|letter| self.letter(letter))
    }

    /// The A, B and C words.
    pub fn rotary(&self) -> [Option<&'w Word>; 3] {
        ['A', 'B', 'C'].map(|letter| self.letter(letter))
    }

    /// The I, J and K words.
    pub fn centres(&self) -> [Option<&'w Word>; 3] {
        ['I', 'J', 'K'].map(|letter| self.letter(letter))
    }

    /// The I, J, K and R words, in the order of the line.
    pub fn arc_words(&self) -> impl Iterator<Item = &'w Word> {
        self.words.iter().filter(|word| matches!(word.letter, 'I' | 'J' | 'K' | 'R'))
    }

    /// Refuses I, J, K and R where there is no arc.
    pub fn refuse_arc_words(&self) -> Result<(), Refusal> {
        self.arc_words().next().map_or(Ok(()), |word| Err(word.refuse(Fault::NotAnArc)))
    }
}

/// The words of a line that count: of a line that sets a machine (Marlin's M92, M104 … M299), the others are parameters of M.
pub(crate) fn that_count(words: &[Word]) -> &[Word] {
    let first = words.iter().position(|word| word.letter != 'N');
    let has = |letters: &[char]| words.iter().any(|word| letters.contains(&word.letter));
    let sets = |word: &Word| match word.whole() {
        Ok(92 | 200..=299) => !has(&['G']),
        // LinuxCNC has these for its users, and a coordinate beside them is one.
        // Haas asks the operator with M109 P.
        Ok(109) if has(&['P']) => false,
        Ok(104..=109 | 140 | 190) => !has(&['G', 'X', 'Y', 'Z']),
        _ => false,
    };
    match first {
        Some(at) if words[at].letter == 'M' && sets(&words[at]) => &words[..=at],
        _ => words,
    }
}

/// Refuses what stands beside `word`, M70 to M73, and is not read as LinuxCNC reads it: of M72 all, since it drops motions, and what
/// counts before the modes are kept (F, S and their modes, M).
pub(crate) fn check_keeps(words: &[Word], word: &Word, code: u32) -> Result<(), Refusal> {
    let is_before = |other: &Word| match other.letter {
        'F' | 'S' | 'M' => true,
        'G' => matches!(other.tenths(), Some(930..=970)),
        _ => code == 72,
    };
    let beside = words.iter().find(|other| *other != word && other.letter != 'N' && (code == 72 || is_before(other)));
    beside.map_or(Ok(()), |other| Err(other.refuse(Fault::BesideKept { code })))
}

/// Refuses letters that have no meaning here.
fn check_letter(word: &Word) -> Result<(), Refusal> {
    let unsupported = match word.letter {
        'U' | 'V' | 'W' if word.value != 0.0 => Unsupported::SecondaryAxis,
        _ => return Ok(()),
    };
    Err(word.refuse(Fault::Unsupported(unsupported)))
}
