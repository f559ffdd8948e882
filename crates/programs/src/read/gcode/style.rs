//! The style in which a program's author writes words, as its lines show it.

use crate::model::gcode::{Dialect, MotionCode, Word};

/// Style of words, so that new words look like their neighbours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Style {
    /// Whether blanks part the words: `G1 X5`, not `G1X5`.
    pub is_spaced: bool,
    /// Whether letters are lower case.
    pub is_lower: bool,
    /// Whether motion words have two digits: `G01`.
    pub is_padded: bool,
    pub numbers: NumberStyle,
    pub dialect: Dialect,
}

/// Style of coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct NumberStyle {
    /// Whether numbers above 0 have a plus: `X+5`.
    pub has_plus: bool,
    /// Whether a comma stands for the point: `X5,25`.
    pub has_comma: bool,
    /// Whether an equals sign stands before the number: `X=5`.
    pub has_equals: bool,
}

impl NumberStyle {
    /// Formats `number`, given with a point and without plus and blanks, in this style.
    pub(crate) fn write(self, number: &str) -> String {
        let plus = if self.has_plus && !number.starts_with(['+', '-']) { "+" } else { "" };
        let number = format!("{plus}{number}");
        if self.has_comma { number.replace('.', ",") } else { number }
    }
}

impl Style {
    /// Returns the plainest style of `dialect`: `G1 X5`.
    pub fn plain(dialect: Dialect) -> Style {
        let numbers = NumberStyle { has_plus: dialect == Dialect::Heidenhain, has_comma: false, has_equals: false };
        Style { is_spaced: true, is_lower: false, is_padded: false, numbers, dialect }
    }

    /// Returns the style of one line; what its `words` do not show is taken from `self`.
    pub fn adapted_to(self, content: &[u8], words: &[Word]) -> Style {
        ObservedStyle::default().observe_line(content, words).or(self)
    }

    /// Formats a word of an upper-case `letter` and `number`.
    pub fn word(self, letter: char, number: &str) -> String {
        let letter = if self.is_lower { letter.to_ascii_lowercase() } else { letter };
        format!("{letter}{number}")
    }

    /// Formats the word of the coordinate `axis` (0 = X, 1 = Y, 2 = Z).
    pub fn axis(self, axis: usize, number: &str) -> String {
        self.coordinate(['X', 'Y', 'Z'][axis], number)
    }

    /// Formats the word of the axis `letter`, with its equals sign, plus and comma.
    pub fn coordinate(self, letter: char, number: &str) -> String {
        let equals = if self.numbers.has_equals { "=" } else { "" };
        self.word(letter, &format!("{equals}{}", self.numbers.write(number)))
    }

    /// Returns the word with which a new straight line must begin in this dialect, if any.
    pub fn line_prefix(self) -> Option<String> {
        (self.dialect == Dialect::Heidenhain).then(|| self.motion(MotionCode::Line))
    }

    /// Formats the motion word of `code`.
    pub fn motion(self, code: MotionCode) -> String {
        let number = code.number();
        if self.dialect == Dialect::Heidenhain {
            // Arcs stay as they are or become lines.
            return if self.is_lower { "l".into() } else { "L".into() };
        }
        self.word('G', &if self.is_padded { format!("{number:02}") } else { number.to_string() })
    }

    /// Text between two words.
    pub fn separator(self) -> &'static str {
        if self.is_spaced { " " } else { "" }
    }
}

/// Style as far as lines have shown it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ObservedStyle {
    is_spaced: Option<bool>,
    is_lower: Option<bool>,
    is_padded: Option<bool>,
    has_plus: Option<bool>,
    has_comma: Option<bool>,
    has_equals: Option<bool>,
}

impl ObservedStyle {
    /// Adds what the line `content` shows and the lines before do not.
    pub fn observe_line(self, content: &[u8], words: &[Word]) -> ObservedStyle {
        let spaced = || words.windows(2).any(|pair| pair[0].span.end < pair[1].span.start);
        let first = || words.iter().find(|word| word.letter != 'N');
        let motion = || words.iter().find(|word| word.letter == 'G' && word.value < 4.0);
        let is_padded = |word: &Word| word.span.len() == 3 && content[word.span.start + 1] == b'0';
        let axes = || words.iter().rev().filter(|word| is_axis_word(word));
        let plus = |word: &Word| match content[word.number()].first() {
            Some(b'-') | None => None,
            first => Some(first == Some(&b'+')),
        };
        let mark = |word: &Word| content[word.number()].iter().find(|b| matches!(b, b',' | b'.'));
        let equals = |word: &Word| content[word.span.start..word.number().start].contains(&b'=');
        ObservedStyle {
            is_spaced: self.is_spaced.or_else(|| (words.len() > 1).then(spaced)),
            is_lower: self.is_lower.or_else(|| first().map(|word| content[word.span.start].is_ascii_lowercase())),
            is_padded: self.is_padded.or_else(|| motion().map(is_padded)),
            has_plus: self.has_plus.or_else(|| axes().find_map(plus)),
            has_comma: self.has_comma.or_else(|| axes().find_map(mark).map(|mark| *mark == b',')),
            has_equals: self.has_equals.or_else(|| axes().next().map(equals)),
        }
    }

    /// Returns the observed style, with what no line shows taken from `style`.
    pub fn or(self, style: Style) -> Style {
        Style {
            is_spaced: self.is_spaced.unwrap_or(style.is_spaced),
            is_lower: self.is_lower.unwrap_or(style.is_lower),
            is_padded: self.is_padded.unwrap_or(style.is_padded),
            numbers: NumberStyle {
                has_plus: self.has_plus.unwrap_or(style.numbers.has_plus),
                has_comma: self.has_comma.unwrap_or(style.numbers.has_comma),
                has_equals: self.has_equals.unwrap_or(style.numbers.has_equals),
            },
            dialect: style.dialect,
        }
    }
}

/// Whether `word` is an X, Y or Z word.
pub(crate) fn is_axis_word(word: &Word) -> bool {
    matches!(word.letter, 'X' | 'Y' | 'Z')
}
