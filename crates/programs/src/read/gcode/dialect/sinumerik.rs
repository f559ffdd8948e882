//! Lines of Sinumerik programs: addresses with numbers (`X10`, `X=IC(5)`, `S1=900`), and names, alone or with values or arguments.

use std::ops::Range;

use crate::{
    model::gcode::{Distance, Fault, Foreign, InclinedFault, Refusal, Unsupported, Word},
    read::{
        gcode::{
            Statement,
            dialect::sinumerik_words::{self, Assigned, Name},
            lines,
        },
        scan::Scan,
    },
};

/// Parses `line` into words, or as a `%`; `Err` for what is not followed: words of contours too, unless `follows_contours`.
pub(crate) fn parse_line(line: &[u8], follows_contours: bool) -> Result<Statement, Refusal> {
    let prefix = lines::prefix_len(line);
    if line.get(prefix) == Some(&b'%') {
        return Ok(Statement::Percent);
    }
    let mut block = Block {
        scan: Scan::of_line(line, prefix),
        words: Vec::new(),
        adds: false,
        machine_axis: None,
        follows_contours,
    };
    while let Some(byte) = block.scan.next() {
        block.read_token(byte)?;
    }
    Ok(Statement::Words { words: block.into_words()?, prefix })
}

/// A block that is being read.
struct Block<'a> {
    scan: Scan<'a>,
    words: Vec<Word>,
    /// Whether coordinates add to the zero in force (ATRANS).
    adds: bool,
    /// Refusal of a coordinate of the machine, if there is one.
    machine_axis: Option<Refusal>,
    follows_contours: bool,
}

impl Block<'_> {
    /// Reads the token that begins with `byte`.
    fn read_token(&mut self, byte: u8) -> Result<(), Refusal> {
        let start = self.scan.at;
        match byte {
            b'(' => self.scan.skip_closed(b'(', b')'),
            b'$' => Err(self.scan.refuse(start, Foreign::Parameter)),
            b':' if self.words.is_empty() => {
                self.scan.at += 1;
                self.scan.take_while(|byte| byte.is_ascii_digit());
                Ok(())
            }
            _ if byte.is_ascii_alphabetic() || byte == b'_' => {
                let after = self.scan.line.get(start + 1);
                match after.is_some_and(|byte| byte.is_ascii_alphabetic() || *byte == b'_') || byte == b'_' {
                    true => self.read_name(),
                    false => self.read_address(char::from(byte.to_ascii_uppercase())),
                }
            }
            _ => Err(self.scan.refuse(start, Fault::Character)),
        }
    }

    /// Reads a name with its arguments or value.
    fn read_name(&mut self) -> Result<(), Refusal> {
        let start = self.scan.at;
        let range = self.scan.take_while(|byte| byte.is_ascii_alphanumeric() || byte == b'_');
        let name = self.scan.upper_text(range.clone());
        if self.scan.peek() == Some(b':') && self.words.iter().all(|word| word.letter == 'N') {
            // A label; jumps to it are refused.
            self.scan.at += 1;
            return Ok(());
        }
        let refuse = |scan: &Scan, foreign: Foreign| Err(scan.refuse(start, foreign));
        let is_indexed = self.scan.peek() == Some(b'[');
        if is_indexed {
            self.scan.skip_closed(b'[', b']')?;
        }
        if self.scan.takes(b'=') {
            match sinumerik_words::assigned_name(&name) {
                Ok(Assigned::Radius) => return self.read_value('R', start),
                Ok(Assigned::Passive) => return self.skip_value(),
                Ok(Assigned::OfContour(letter, _)) if self.follows_contours => return self.read_value(letter, start),
                Ok(Assigned::OfContour(_, foreign)) => return refuse(&self.scan, foreign),
                Err(foreign) => return refuse(&self.scan, foreign),
            }
        }
        let has_arguments = !is_indexed && self.scan.next() == Some(b'(');
        let words = match name.as_str() {
            "CYCLE800" if has_arguments => Some(swivel_words(&mut self.scan, start)?),
            "CYCLE84" | "CYCLE840" if has_arguments => Some(tapping_words(&mut self.scan, start)?),
            _ => None,
        };
        if let Some(words) = words {
            self.words.extend(words);
            return Ok(());
        }
        match sinumerik_words::plain_name(&name, has_arguments) {
            Err(foreign) => refuse(&self.scan, foreign),
            Ok(Name::Passive) if has_arguments => self.scan.skip_closed(b'(', b')'),
            Ok(Name::Passive) => Ok(()),
            Ok(Name::OfContour(letter, number, _)) if self.follows_contours && !has_arguments => {
                self.words.push(Word::plain(letter, number, range));
                Ok(())
            }
            Ok(Name::OfContour(.., foreign)) => refuse(&self.scan, foreign),
            Ok(Name::Word(vocable)) if has_arguments && vocable.name != sinumerik_words::TRANSFORMED => {
                refuse(&self.scan, Foreign::Call)
            }
            Ok(Name::Word(vocable)) => {
                if has_arguments {
                    self.scan.skip_closed(b'(', b')')?;
                }
                self.adds |= vocable.name == "ATRANS";
                self.words.push(Word { meaning: Some(vocable), ..Word::plain('G', 0.0, range) });
                Ok(())
            }
        }
    }

    /// Reads an address: a letter, alone or with a number of its own (`S1=`).
    fn read_address(&mut self, letter: char) -> Result<(), Refusal> {
        let start = self.scan.at;
        self.scan.at += 1;
        let mut extension = self.scan;
        let digits = extension.take_while(|byte| byte.is_ascii_digit());
        if !digits.is_empty() && extension.takes(b'=') {
            let is_master = extension.upper_text(digits).parse::<u32>().is_ok_and(|number| number < 2);
            self.scan.at = extension.at;
            if self.follows_contours && is_master && matches!(letter, 'I' | 'J' | 'K') {
                return self.read_value(letter.to_ascii_lowercase(), start);
            }
            return self.read_numbered_address(letter, is_master, start);
        }
        match letter {
            'R' => return Err(self.scan.refuse(start, Foreign::Parameter)),
            'L' | 'P' => return Err(self.scan.refuse(start, Foreign::Call)),
            'U' | 'V' | 'W' => {
                return Err(self.scan.refuse(start, Fault::Unsupported(Unsupported::SecondaryAxis)));
            }
            _ if !sinumerik_words::is_address(letter) => return Err(self.scan.refuse(start, Fault::NotAWord)),
            _ => {}
        }
        let assigns = self.scan.takes(b'=');
        match letter {
            // Tools may have names.
            'T' if assigns && !self.scan.next().is_some_and(|byte| byte.is_ascii_digit()) => self.skip_value(),
            'D' | 'H' if assigns => self.skip_value(),
            _ => self.read_value(letter, start),
        }
    }

    /// Reads the value of the address `letter` with a number of its own (`S1=900`); `is_master`: that number is below 2.
    fn read_numbered_address(&mut self, letter: char, is_master: bool, start: usize) -> Result<(), Refusal> {
        match letter {
            'S' if is_master => return self.read_value('S', start),
            // Of a spindle that is none of the program's end: M1=5.
            'M' => {
                self.read_value('M', start)?;
                self.words.last_mut().into_iter().for_each(|word| word.meaning = Some(&sinumerik_words::OTHER));
                return Ok(());
            }
            'S' | 'T' | 'D' | 'H' => return self.skip_value(),
            'X' | 'Y' | 'Z' => {
                self.machine_axis = Some(self.scan.refuse(start, Foreign::MachineAxis));
                return self.skip_value();
            }
            _ => {}
        }
        Err(self.scan.refuse(
            start,
            match letter {
                'A' | 'B' | 'C' => Foreign::Kinematics,
                'I' | 'J' | 'K' => Foreign::Motion,
                _ => Foreign::Parameter,
            },
        ))
    }

    /// Reads the number of the word `letter` that begins at `start`.
    fn read_value(&mut self, letter: char, start: usize) -> Result<(), Refusal> {
        self.scan.next();
        let (distance, closes) = self.read_mode();
        self.scan.next();
        let Some((value, number)) = self.scan.take_decimal()? else {
            let foreign = match self.scan.peek() {
                Some(byte) if byte.is_ascii_graphic() => Foreign::Parameter,
                _ => Foreign::NoNumber,
            };
            return Err(self.scan.refuse(start, foreign));
        };
        if self.scan.line[number.clone()].contains(&b',') {
            return Err(self.scan.refuse(start, Foreign::NoNumber));
        }
        let ends = if closes { self.scan.takes(b')') } else { true };
        let span = start..self.scan.at;
        let exponent = self.scan.line[self.scan.at..].get(..2).is_some_and(|next| next.eq_ignore_ascii_case(b"EX"));
        if !ends || exponent || matches!(self.scan.next(), Some(b'+' | b'-' | b'*' | b'/' | b'[' | b'=' | b'<' | b'>'))
        {
            return Err(self.scan.refuse(start, Foreign::Parameter));
        }
        let (before, behind) = (number.start - span.start, span.end - number.end);
        let (Ok(before), Ok(behind)) = (u8::try_from(before), u8::try_from(behind)) else {
            return Err(self.scan.refuse(start, Fault::NotAWord));
        };
        let mut word = Word { around: [before, behind], distance, ..Word::plain(letter, value, span) };
        match letter {
            'D' | 'H' => return Ok(()),
            'M' => word.meaning = Some(sinumerik_words::m_word(word.whole_number()?)),
            _ => {}
        }
        self.words.push(word);
        Ok(())
    }

    /// Takes `IC(`, `AC(` or a mode of rotary axes, if one comes next; returns its distance mode, and whether a bracket is to be closed.
    fn read_mode(&mut self) -> (Option<Distance>, bool) {
        let mut probe = self.scan;
        let distance = match probe.take_letters().as_str() {
            "IC" => Distance::Incremental,
            "AC" | "DC" | "ACP" | "ACN" => Distance::Absolute,
            _ => return (None, false),
        };
        if !probe.takes(b'(') {
            return (None, false);
        }
        self.scan.at = probe.at;
        (Some(distance), true)
    }

    /// Skips a value up to the next blank; strings and brackets count as one.
    fn skip_value(&mut self) -> Result<(), Refusal> {
        self.scan.next();
        while let Some(byte) = self.scan.peek().filter(|byte| !lines::is_blank(*byte)) {
            match byte {
                b'"' => self.scan.skip_closed(b'"', b'"')?,
                b'(' => self.scan.skip_closed(b'(', b')')?,
                b'[' => self.scan.skip_closed(b'[', b']')?,
                _ => self.scan.at += 1,
            }
        }
        Ok(())
    }

    /// Returns the words of the complete block; `Err` for machine coordinates without G74 or G75, and coordinates with G4.
    fn into_words(mut self) -> Result<Vec<Word>, Refusal> {
        let has = |numbers: [u32; 2]| {
            let is_one = |word: &Word| word.whole_number().is_ok_and(|number| numbers.contains(&number));
            self.words.iter().any(|word| word.letter == 'G' && word.meaning.is_none() && is_one(word))
        };
        if let Some(refusal) = self.machine_axis.take().filter(|_| !has([74, 75])) {
            return Err(refusal);
        }
        if has([4, 4]) {
            if let Some(word) = self.words.iter().find(|word| matches!(word.letter, 'X' | 'Y' | 'Z')) {
                return Err(word.refuse(Fault::NotACoordinate { word: "G4" }));
            }
            // F is how long, in seconds, and S how many turns.
            self.words.retain(|word| !matches!(word.letter, 'F' | 'S'));
        }
        let tap = self.words.iter().find(|word| word.letter == Word::RETRACT);
        // Its name, three heights and the feed.
        let is_beside = self.words.iter().filter(|word| word.letter != 'N').count() > 5;
        if let Some(word) = tap.filter(|_| is_beside) {
            return Err(word.refuse(Fault::Foreign(Foreign::CycleValue { expected: "a block of its own" })));
        }
        for word in self.words.iter_mut().filter(|_| self.adds) {
            word.distance = Some(Distance::Incremental);
        }
        Ok(self.words)
    }
}

/// Returns the words of CYCLE800, which begins at byte `start` and whose arguments are at the cursor: `(_FR, _TC, _ST, _MODE, _X0, _Y0, _Z0, _A, _B,
/// _C, _X1, _Y1, _Z1, _DIR, …)`. `Err` for what is not followed.
fn swivel_words(scan: &mut Scan, start: usize) -> Result<Vec<Word>, Refusal> {
    const NUMBERS: &str = "plain numbers as its arguments";
    let arguments = take_arguments(scan)?;
    let span = start..scan.at;
    let line = scan.line;
    let refuse = |expected| Refusal::new(span.clone(), Fault::Inclined(InclinedFault::Form { expected }));
    let is_within = |range: &Range<usize>| !line[range.clone()].is_empty();
    let word = |vocable| Word { meaning: Some(vocable), ..Word::plain('G', 0.0, span.clone()) };
    let name = arguments.get(1).map(|range| &line[range.clone()]);
    if !arguments.iter().any(is_within) {
        return Ok(vec![word(&sinumerik_words::SWIVEL_OFF)]);
    }
    if name == Some(b"\"0\"".as_slice()) {
        return Ok(vec![word(&sinumerik_words::SWIVEL_OFF), word(&sinumerik_words::RETRACTS)]);
    }
    let number = |index: usize| {
        let text = arguments.get(index).map_or(&line[..0], |range| &line[range.clone()]);
        if text.is_empty() { Ok(0.0) } else { plain_number(text).ok_or_else(|| refuse(NUMBERS)) }
    };
    // What follows the tip where it swivels does not count, as the position is not known behind it.
    if ![0.0, 10.0].contains(&number(2)?) {
        return Err(refuse("a new plane, _ST 0 or 10"));
    }
    let (mode, third) = (number(3)?, number(9)?);
    let swivel = sinumerik_words::swivel(mode).filter(|_| mode != sinumerik_words::SOLID_ANGLE || third == 0.0);
    let swivel = swivel.ok_or_else(|| refuse("_MODE axis by axis, such as 57, or 64 (solid angle) with no _C"))?;
    let mut words = vec![word(swivel)];
    let letters = [('X', 4), ('Y', 5), ('Z', 6), ('I', 7), ('J', 8), ('K', 9), ('P', 10), ('L', 11), ('R', 12)];
    for (letter, index) in letters {
        words.push(Word { distance: Some(Distance::Absolute), ..Word::plain(letter, number(index)?, span.clone()) });
    }
    let direction = match number(13)? {
        0.0 => None,
        1.0 => Some(&sinumerik_words::HIGHER),
        -1.0 => Some(&sinumerik_words::LOWER),
        _ => return Err(refuse("_DIR -1, 0 or 1")),
    };
    words.extend(direction.map(word));
    Ok(words)
}

/// Returns the words of CYCLE84 or CYCLE840, which begins at byte `start` and whose arguments are at the cursor, as it is written for one hole:
/// `(RTP, RFP,, DP,, …)`. `Err` for other forms, which become this one where the program is written out.
fn tapping_words(scan: &mut Scan, start: usize) -> Result<Vec<Word>, Refusal> {
    let open = scan.at;
    let arguments = take_arguments(scan)?;
    let (line, span) = (scan.line, start..scan.at);
    let text = |index: usize| arguments.get(index).map_or(&line[..0], |range| &line[range.clone()]);
    let height = |letter: char, index: usize| {
        let value = plain_number(text(index))?;
        let of_number = Word { around: [0; 2], ..Word::plain(letter, value, arguments[index].clone()) };
        Some(Word { distance: Some(Distance::Absolute), ..of_number })
    };
    let heights = (height(Word::RETRACT, 0), height('R', 1), height('Z', 3));
    match heights {
        (Some(retract), Some(clear), Some(bottom)) if [2, 4].iter().all(|index| text(*index).is_empty()) => {
            let cycle = Word { meaning: Some(&sinumerik_words::TAP), ..Word::plain('G', 0.0, start..open) };
            // PIT and SST, which CYCLE840 has not.
            let of_tap = plain_number(text(8))
                .zip(plain_number(text(10)))
                .filter(|_| line[start..open].trim_ascii_end().ends_with(b"84"));
            let feed = of_tap.map_or(0.0, |(pitch, speed)| (pitch * speed).abs());
            let feed = Word { around: [0; 2], ..Word::plain(Word::TAP_FEED, feed, span.end..span.end) };
            Ok(vec![cycle, retract, clear, bottom, feed])
        }
        _ => Err(Refusal::new(span, Foreign::Cycle.into())),
    }
}

/// Takes arguments in brackets, and returns where each stands without the blanks around it; a comma in a string parts none.
fn take_arguments(scan: &mut Scan) -> Result<Vec<Range<usize>>, Refusal> {
    let open = scan.at;
    scan.skip_closed(b'(', b')')?;
    let line = scan.line;
    let (mut arguments, mut from, mut is_text) = (Vec::new(), open + 1, false);
    for (at, byte) in line.iter().enumerate().take(scan.at).skip(open + 1) {
        is_text ^= *byte == b'"';
        if (*byte == b',' || at + 1 == scan.at) && !is_text {
            let begin = line[from..at].trim_ascii_start();
            arguments.push(at - begin.len()..at - begin.len() + begin.trim_ascii_end().len());
            from = at + 1;
        }
    }
    Ok(arguments)
}

/// Parses a number without an exponent; `None` for other text.
fn plain_number(text: &[u8]) -> Option<f64> {
    let is_plain = text.iter().all(|byte| byte.is_ascii_digit() || matches!(byte, b'.' | b'+' | b'-'));
    std::str::from_utf8(text).ok().filter(|_| is_plain)?.parse().ok()
}
