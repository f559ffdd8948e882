//! Edits words of a line and leaves all else of it as it is.

use crate::{
    model::gcode::{MotionCode, Word},
    read::gcode::{Style, is_axis_word},
};

/// New text at one word: before it, in its place, and after it.
#[derive(Clone, Debug, Default)]
struct Slot {
    before: Vec<String>,
    text: Option<String>,
    after: Vec<String>,
}

/// A line that is being edited; blanks and comments between words stay.
#[derive(Clone, Debug)]
pub(crate) struct LineEdit<'a> {
    content: &'a [u8],
    words: &'a [Word],
    style: Style,
    slots: Vec<Slot>,
}

impl<'a> LineEdit<'a> {
    /// Starts with the line `content` unchanged, whose words are `words`.
    pub fn new(content: &'a [u8], words: &'a [Word], style: Style) -> LineEdit<'a> {
        let text = |word: &Word| String::from_utf8_lossy(&content[word.span.clone()]).into_owned();
        let slots = words.iter().map(|word| Slot { text: Some(text(word)), ..Slot::default() }).collect();
        LineEdit { content, words, style: style.adapted_to(content, words), slots }
    }

    /// Style of new words on this line.
    pub fn style(&self) -> Style {
        self.style
    }

    /// Index of the first word that passes `test`.
    pub fn find(&self, test: impl Fn(&Word) -> bool) -> Option<usize> {
        self.words.iter().position(test)
    }

    /// Replaces the number of the word with index `index`; its letter and what stands around the number stay.
    pub fn set_number(&mut self, index: usize, number: &str) {
        let word = &self.words[index];
        if let Some(text) = &mut self.slots[index].text {
            let number = if is_axis_word(word) || is_rotary_word(word) {
                self.style.numbers.write(number)
            } else {
                number.to_owned()
            };
            let end = text.len() - usize::from(word.around[1]);
            text.replace_range(usize::from(word.around[0])..end, &number);
        }
    }

    /// Removes the word with index `index` and the blanks before it, and returns its text; `None` if it was removed before.
    pub fn remove(&mut self, index: usize) -> Option<String> {
        self.slots[index].text.take()
    }

    /// Replaces the word with index `index` by `text`.
    pub fn replace(&mut self, index: usize, text: String) {
        self.slots[index].text = Some(text);
    }

    /// Adds a missing coordinate (0 = X, 1 = Y, 2 = Z) beside the others, else behind the motion word, else before the arc words.
    pub fn add_axis(&mut self, axis: usize, number: &str) {
        const LETTERS: [char; 3] = ['X', 'Y', 'Z'];
        let text = self.style.axis(axis, number);
        let position = |letter: char| self.find(|word| word.letter == letter);
        let lower = LETTERS[..axis].iter().rev().find_map(|letter| position(*letter));
        let higher = LETTERS[axis + 1..].iter().find_map(|letter| position(*letter));
        let motion = || self.find(is_motion_word);
        match (lower, higher) {
            (Some(index), _) => self.slots[index].after.push(text),
            (None, Some(index)) => self.slots[index].before.push(text),
            (None, None) => match (motion(), self.find(is_arc_word)) {
                (Some(index), _) => self.slots[index].after.push(text),
                (None, Some(index)) => self.slots[index].before.push(text),
                (None, None) => self.slots.last_mut().into_iter().for_each(|s| s.after.push(text.clone())),
            },
        }
    }

    /// Sets the angle of the rotary axis `letter` to `number`, or adds its word behind the last axis word.
    pub fn set_rotary(&mut self, letter: char, number: &str) {
        match self.find(|word| word.letter == letter) {
            Some(index) => self.set_number(index, number),
            None => {
                let text = self.style.coordinate(letter, number);
                let last = self.words.iter().rposition(|word| is_axis_word(word) || is_rotary_word(word));
                if let Some(slot) = self.slots.get_mut(last.unwrap_or_default()) {
                    slot.after.push(text);
                }
            }
        }
    }

    /// Adds the word `letter` with `number` behind the last of X, Y, Z and R.
    pub fn add_last(&mut self, letter: char, number: &str) {
        let text = self.style.word(letter, number);
        let last = self.words.iter().rposition(|word| is_axis_word(word) || word.letter == 'R');
        if let Some(slot) = self.slots.get_mut(last.unwrap_or_default()) {
            slot.after.push(text);
        }
    }

    /// Sets the number of the arc word `letter`, or adds the word: in the order I J K, else behind the axis words.
    pub fn set_arc_word(&mut self, letter: char, number: &str) {
        let text = self.style.word(letter, number);
        let any = |letters: &[char]| self.find(|word| letters.contains(&word.letter));
        let positions = (any(&[letter]), any(if letter == 'K' { &['I', 'J'] } else { &['I'] }), any(&['J', 'K']));
        match positions {
            (Some(index), ..) => self.set_number(index, number),
            (None, Some(index), _) if letter != 'I' => self.slots[index].after.push(text),
            (None, _, Some(index)) if letter != 'K' => self.slots[index].before.push(text),
            _ => self.add_last(letter, number),
        }
    }

    /// Makes `code` the motion of the line; if it has no motion word, adds one before the coordinates.
    pub fn set_motion(&mut self, code: MotionCode) {
        let text = self.style.motion(code);
        if let Some(index) = self.find(|word| is_motion_word(word) && word.meaning.is_some()) {
            self.slots[index].text = Some(text);
        } else if let Some(index) = self.find(is_motion_word) {
            self.set_number(index, &text[1..]);
        } else {
            self.add_motion(code);
        }
    }

    /// Adds the word of the motion `code` before the coordinates of a line that has none.
    pub fn add_motion(&mut self, code: MotionCode) {
        let place = self.find(|word| is_axis_word(word) || is_arc_word(word)).or_else(|| self.find(is_rotary_word));
        if let Some(index) = place {
            self.slots[index].before.insert(0, self.style.motion(code));
        }
    }

    /// Returns the bytes of the edited line; what stands between words stays.
    pub fn render(self) -> Vec<u8> {
        let mut out = Vec::with_capacity(self.content.len() + 16);
        let mut from = 0;
        for (word, slot) in self.words.iter().zip(self.slots) {
            let gap = &self.content[from..word.span.start];
            let texts: Vec<String> = slot.before.into_iter().chain(slot.text).chain(slot.after).collect();
            let kept = if texts.is_empty() { gap.trim_ascii_end() } else { gap };
            out.extend_from_slice(kept);
            out.extend_from_slice(texts.join(self.style.separator()).as_bytes());
            from = word.span.end;
        }
        out.extend_from_slice(&self.content[from..]);
        out
    }
}

/// Whether `word` is G0, G1, G2 or G3.
fn is_motion_word(word: &Word) -> bool {
    word.letter == 'G' && matches!(word.tenths(), Some(0 | 10 | 20 | 30))
}

/// Whether `word` is A, B or C.
fn is_rotary_word(word: &Word) -> bool {
    matches!(word.letter, 'A' | 'B' | 'C')
}

/// Whether `word` is I, J, K or R, or Heidenhain's DR.
pub(crate) fn is_arc_word(word: &Word) -> bool {
    matches!(word.letter, 'I' | 'J' | 'K' | 'R' | Word::SENSE)
}

/// What becomes of a word where its line becomes several.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum LineShare {
    /// Each line has its own: what moves with the tool, by the length, and the words of arcs.
    Each,
    /// On the first line: what holds from there on, and what is done before the motion.
    First,
    /// On the last line: what is done behind the motion.
    Last,
    /// Refused: it may be an axis that moves with the tool, and is not followed.
    Axis,
}

/// Returns what becomes of `word` where its line, which has `words`, becomes several.
pub(crate) fn share_of(word: &Word, words: &[Word]) -> LineShare {
    let owns_e = |word: &Word| word.letter == 'M' && matches!(word.whole_number(), Ok(67 | 68));
    let parameters = || match words.iter().filter(|word| takes_parameters(word)).all(acts_at_end) {
        true => LineShare::Last,
        false => LineShare::First,
    };
    match word.letter {
        'A' | 'B' | 'C' | 'X' | 'Y' | 'Z' => LineShare::Each,
        _ if is_arc_word(word) => LineShare::Each,
        // Exact stop, of this motion alone.
        'G' if word.meaning.is_none() && word.tenths() == Some(90) => LineShare::Last,
        'M' if acts_at_end(word) => LineShare::Last,
        // Others are refused: what stands at 0 does not move.
        'U' | 'V' | 'W' if word.value == 0.0 => LineShare::First,
        // LinuxCNC's M67 and M68 have it for an output.
        'E' if words.iter().any(owns_e) => parameters(),
        'P' | 'Q' => parameters(),
        'D' | 'F' | 'G' | 'H' | 'L' | 'M' | 'N' | 'O' | 'S' | 'T' => LineShare::First,
        _ => LineShare::Axis,
    }
}

/// Whether P and Q on the line may belong to `word`.
pub(crate) fn takes_parameters(word: &Word) -> bool {
    word.letter == 'M' || (word.letter == 'G' && matches!(word.tenths(), Some(40 | 610 | 611 | 640)))
}

/// Whether `word` is an M word that controllers run after the motion of its block.
pub(crate) fn acts_at_end(word: &Word) -> bool {
    word.letter == 'M' && matches!(word.whole_number(), Ok(0 | 1 | 2 | 5 | 9 | 17 | 30 | 60 | 99))
}
