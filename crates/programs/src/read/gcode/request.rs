//! What the words of one line ask for, before any state counts.

use crate::model::gcode::{AngleChoice, Dialect, Fault, GWord, MotionCode, Refusal, Setting, Unsupported, Word};

/// Words of one line, sorted by what they ask for.
#[derive(Debug)]
pub(crate) struct Request<'w> {
    words: &'w [Word],
    /// G words with their meanings, at most one of each group.
    pub g_words: Vec<(&'w Word, GWord)>,
    /// Whether M2 or M30 is among the words.
    pub ends_program: bool,
    /// Whether M6 is among the words.
    pub changes_tool: bool,
    /// M70 to M73, which save and restore modes.
    pub mode_word: Option<(&'w Word, u32)>,
}

impl<'w> Request<'w> {
    /// Sorts the `words` of a line. `Err` for what is wrong in any state: two words of a group, repeated letters, unsupported words.
    pub fn from_words(words: &'w [Word], dialect: Dialect) -> Result<Request<'w>, Refusal> {
        let changes_tool = words.iter().any(|word| word.letter == 'M' && word.value == 6.0);
        let mut request = Request { words, g_words: Vec::new(), ends_program: false, changes_tool, mode_word: None };
        for (at, word) in words.iter().enumerate() {
            match (word.meaning, word.letter) {
                (Some(vocable), _) => request.add_g(word, vocable.meaning)?,
                (None, 'G') => request.add_g(word, dialect.g_word(word)?)?,
                (None, 'M') => request.add_m(word, dialect)?,
                (None, letter) => {
                    check_letter(word)?;
                    if let Some(other) = words[..at].iter().find(|other| other.letter == letter) {
                        return Err(word.refuse(match letter {
                            'T' => Fault::TwoTools { first: other.value },
                            _ => Fault::Repeated { letter },
                        }));
                    }
                }
            }
        }
        Ok(request)
    }

    /// Adds a G word with the meaning `g`; `Err` if another one of its group is there.
    fn add_g(&mut self, word: &'w Word, g: GWord) -> Result<(), Refusal> {
        self.ends_program |= g == GWord::End;
        if matches!(g, GWord::End | GWord::Auxiliary) {
            return Ok(());
        }
        // Which of them counts differs from control to control.
        let ends_own_cycle =
            |a: GWord, b: GWord| a == GWord::CancelMotion && matches!(b, GWord::Motion(MotionCode::Cycle(_)));
        let contradicts = |other: GWord| {
            other.modal_group() == g.modal_group() || ends_own_cycle(other, g) || ends_own_cycle(g, other)
        };
        if let Some((other, _)) = self.g_words.iter().find(|(_, other)| contradicts(*other)) {
            let other = other.meaning.map_or_else(|| format!("G{}", other.value), |vocable| vocable.name.to_owned());
            return Err(word.refuse(Fault::Conflict { other }));
        }
        self.g_words.push((word, g));
        Ok(())
    }

    /// Adds an M word; `Err` if it is not followed.
    fn add_m(&mut self, word: &'w Word, dialect: Dialect) -> Result<(), Refusal> {
        self.ends_program |= matches!(word.whole_number()?, 2 | 30);
        if let Some(unsupported) = Unsupported::for_m_word(word, self.words, dialect) {
            return Err(word.refuse(Fault::Unsupported(unsupported)));
        }
        if let Some(code) = word.mode_save_code(dialect) {
            check_mode_save(self.words, word, code)?;
            self.mode_word = Some((word, code));
        }
        Ok(())
    }

    /// Refuses L, P and Q that belong to no word. `in_cycle`: whether a cycle is in force.
    pub fn check_parameters(&self, in_cycle: bool) -> Result<(), Refusal> {
        let m = self.words.iter().any(|word| word.letter == 'M');
        let g = |test: fn(&GWord) -> bool| self.g_words.iter().any(|(_, g)| test(g));
        let setting = self.setting().is_some();
        let smoothing = g(|g| *g == GWord::Smoothing);
        // Of an arc, LinuxCNC reads P as turns.
        let is_of_m_word = m && self.arc_words().next().is_none();
        for (letter, has_owner) in [
            ('L', in_cycle || setting),
            ('P', in_cycle || setting || smoothing || is_of_m_word || g(GWord::takes_p)),
            ('Q', in_cycle || smoothing || m || g(GWord::takes_p)),
        ] {
            if let Some(word) = self.find_word(letter).filter(|_| !has_owner) {
                return Err(word.refuse(Fault::StrayParameter));
            }
        }
        Ok(())
    }

    /// Whether the line leads to a position outside the workpiece frame (G28, G53).
    pub fn leaves_frame(&self) -> bool {
        self.g_words.iter().any(|(_, g)| matches!(g, GWord::Home | GWord::Machine | GWord::Retract))
    }

    /// Returns the word whose coordinates set something (G10, G52, G92, …), and what; `None` if there is none.
    pub fn setting(&self) -> Option<(&'w Word, Setting)> {
        self.g_words.iter().find_map(|(word, g)| match g {
            GWord::Setting(setting) => Some((*word, *setting)),
            _ => None,
        })
    }

    /// Returns the word that turns the tool along z of the inclined plane, and by which rule; `None` if there is none.
    pub fn alignment(&self) -> Option<(&'w Word, AngleChoice)> {
        self.g_words.iter().find_map(|(word, g)| match g {
            GWord::Align(choice) => Some((*word, *choice)),
            _ => None,
        })
    }

    /// Returns the word that finds the angles for the inclined plane, and by which rule; `None` if there is none.
    pub fn angle_search(&self) -> Option<(&'w Word, AngleChoice)> {
        self.g_words.iter().find_map(|(word, g)| match g {
            GWord::FindAngles(choice) => Some((*word, *choice)),
            _ => None,
        })
    }

    /// Returns the word with this letter, other than G and M; `None` if there is none.
    pub fn find_word(&self, letter: char) -> Option<&'w Word> {
        self.words.iter().find(|word| word.letter == letter)
    }

    /// Returns the word whose meaning is `g`; `None` if there is none.
    pub fn find_g(&self, g: GWord) -> Option<&'w Word> {
        self.g_words.iter().find(|(_, other)| *other == g).map(|(word, _)| *word)
    }

    /// Returns the motion that a G word of the line commands; `None` if none does.
    pub fn motion_word(&self) -> Option<MotionCode> {
        self.g_words.iter().find_map(|(_, g)| match g {
            GWord::Motion(code) => Some(*code),
            _ => None,
        })
    }

    /// Returns the G word that commands the motion; `None` if none does.
    pub fn motion_word_source(&self) -> Option<&'w Word> {
        self.g_words.iter().find(|(_, g)| matches!(g, GWord::Motion(_))).map(|(word, _)| *word)
    }

    /// Returns the X, Y and Z words, in this order.
    pub fn axis_words(&self) -> [Option<&'w Word>; 3] {
        ['X', 'Y', 'Z'].map(|letter| self.find_word(letter))
    }

    /// Returns the A, B and C words, in this order.
    pub fn rotary_words(&self) -> [Option<&'w Word>; 3] {
        ['A', 'B', 'C'].map(|letter| self.find_word(letter))
    }

    /// Returns the I, J and K words, in this order.
    pub fn centre_words(&self) -> [Option<&'w Word>; 3] {
        ['I', 'J', 'K'].map(|letter| self.find_word(letter))
    }

    /// The I, J, K and R words, in the order they are written.
    pub fn arc_words(&self) -> impl Iterator<Item = &'w Word> {
        self.words.iter().filter(|word| matches!(word.letter, 'I' | 'J' | 'K' | 'R'))
    }

    /// Refuses I, J, K and R, for lines without an arc.
    pub fn refuse_arc_words(&self) -> Result<(), Refusal> {
        self.arc_words().next().map_or(Ok(()), |word| Err(word.refuse(Fault::NotAnArc)))
    }
}

/// Returns the words of a line without the parameters of an M word that sets the machine (Marlin's M92, M104 … M299).
pub(crate) fn effective_words(words: &[Word]) -> &[Word] {
    let first = words.iter().position(|word| word.letter != 'N');
    let has = |letters: &[char]| words.iter().any(|word| letters.contains(&word.letter));
    let sets = |word: &Word| match word.whole_number() {
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

/// Refuses words beside `word`, M70 to M73 (`code`), that controllers take in another order: F, S, their modes, M; beside M72 all.
pub(crate) fn check_mode_save(words: &[Word], word: &Word, code: u32) -> Result<(), Refusal> {
    let is_before = |other: &Word| match other.letter {
        'F' | 'S' | 'M' => true,
        'G' => matches!(other.tenths(), Some(930..=970)),
        _ => code == 72,
    };
    let beside = words.iter().find(|other| *other != word && other.letter != 'N' && (code == 72 || is_before(other)));
    beside.map_or(Ok(()), |other| Err(other.refuse(Fault::BesideKept { code })))
}

/// Refuses words of the secondary axes U, V and W that are not 0.
fn check_letter(word: &Word) -> Result<(), Refusal> {
    let unsupported = match word.letter {
        'U' | 'V' | 'W' if word.value != 0.0 => Unsupported::SecondaryAxis,
        _ => return Ok(()),
    };
    Err(word.refuse(Fault::Unsupported(unsupported)))
}
