//! How an author writes words, as lines show it.

use crate::toolpath::model::gcode::{Dialect, MotionCode, Word};

/// How an author writes words, so that new words look like their neighbours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Style {
    /// Blanks between words: `G1 X5`, not `G1X5`.
    pub spaced: bool,
    /// Lower-case letters.
    pub lower: bool,
    /// Two-digit motion words: `G01`.
    pub padded: bool,
    pub numbers: Numbers,
    pub dialect: Dialect,
}

/// How numbers of coordinates are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Numbers {
    /// A plus before numbers above 0: `X+5`.
    pub plus: bool,
    /// A comma instead of the point: `X5,25`.
    pub comma: bool,
    /// `X=5`.
    pub equals: bool,
}

impl Numbers {
    /// `number`, which is written with a point, without plus and without blanks, unless it is one of the line.
    pub(crate) fn write(self, number: &str) -> String {
        let plus = if self.plus && !number.starts_with(['+', '-']) { "+" } else { "" };
        let number = format!("{plus}{number}");
        if self.comma { number.replace('.', ",") } else { number }
    }
}

impl Style {
    /// What everyone can read: `G1 X5`.
    pub fn plain(dialect: Dialect) -> Style {
        let numbers = Numbers { plus: dialect == Dialect::Heidenhain, comma: false, equals: false };
        Style { spaced: true, lower: false, padded: false, numbers, dialect }
    }

    /// The style of one line; what the line does not show is taken from `self`.
    pub fn on_line(self, content: &[u8], words: &[Word]) -> Style {
        ShownStyle::default().or_on_line(content, words).over(self)
    }

    /// A word of this letter, which is given in upper case, and number.
    pub fn word(self, letter: char, number: &str) -> String {
        let letter = if self.lower { letter.to_ascii_lowercase() } else { letter };
        format!("{letter}{number}")
    }

    /// The word of a coordinate.
    pub fn axis(self, axis: usize, number: &str) -> String {
        self.coordinate(['X', 'Y', 'Z'][axis], number)
    }

    /// The word of an axis of this letter.
    pub fn coordinate(self, letter: char, number: &str) -> String {
        let equals = if self.numbers.equals { "=" } else { "" };
        self.word(letter, &format!("{equals}{}", self.numbers.write(number)))
    }

    /// What a new line begins with that is a straight line as well.
    pub fn next_line(self) -> Option<String> {
        (self.dialect == Dialect::Heidenhain).then(|| self.motion(MotionCode::Line))
    }

    /// A motion word.
    pub fn motion(self, code: MotionCode) -> String {
        let number = code.number();
        if self.dialect == Dialect::Heidenhain {
            // Arcs stay as they are or become lines.
            return if self.lower { "l".into() } else { "L".into() };
        }
        self.word('G', &if self.padded { format!("{number:02}") } else { number.to_string() })
    }

    /// What stands between two words.
    pub fn separator(self) -> &'static str {
        if self.spaced { " " } else { "" }
    }
}

/// A style as far as lines show it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ShownStyle {
    spaced: Option<bool>,
    lower: Option<bool>,
    padded: Option<bool>,
    plus: Option<bool>,
    comma: Option<bool>,
    equals: Option<bool>,
}

impl ShownStyle {
    /// With what the lines before do not show as this one does.
    pub fn or_on_line(self, content: &[u8], words: &[Word]) -> ShownStyle {
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
        ShownStyle {
            spaced: self.spaced.or_else(|| (words.len() > 1).then(spaced)),
            lower: self.lower.or_else(|| first().map(|word| content[word.span.start].is_ascii_lowercase())),
            padded: self.padded.or_else(|| motion().map(is_padded)),
            plus: self.plus.or_else(|| axes().find_map(plus)),
            comma: self.comma.or_else(|| axes().find_map(mark).map(|mark| *mark == b',')),
            equals: self.equals.or_else(|| axes().next().map(equals)),
        }
    }

    /// The style, what no line shows taken from `style`.
    pub fn over(self, style: Style) -> Style {
        Style {
            spaced: self.spaced.unwrap_or(style.spaced),
            lower: self.lower.unwrap_or(style.lower),
            padded: self.padded.unwrap_or(style.padded),
            numbers: Numbers {
                plus: self.plus.unwrap_or(style.numbers.plus),
                comma: self.comma.unwrap_or(style.numbers.comma),
                equals: self.equals.unwrap_or(style.numbers.equals),
            },
            dialect: style.dialect,
        }
    }
}

/// X, Y or Z.
pub(crate) fn is_axis_word(word: &Word) -> bool {
    matches!(word.letter, 'X' | 'Y' | 'Z')
}
