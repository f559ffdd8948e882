//! A word of a line: a letter with its number.

use std::ops::Range;

use crate::toolpath::model::gcode::{Dialect, Distance, Fault, Refusal, Vocable};

/// A letter with its number.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Word {
    /// The letter in upper case.
    pub letter: char,
    /// The number, the nearest `f64` to what is written.
    pub value: f64,
    /// The bytes of the word in its line.
    pub span: Range<usize>,
    /// How many bytes of it stand before its number and behind it: 1 and 0 of `X5`, 5 and 1 of `X=IC(5)`.
    pub around: [u8; 2],
    /// Whether its coordinate is a position or a step, if the word itself says so.
    pub distance: Option<Distance>,
    /// What a word asks for that is none of ISO.
    pub asks: Option<&'static Vocable>,
}

impl Word {
    /// Stands for the letter of a word that is none of ISO: the sense of an arc, Heidenhain's `DR+`.
    pub const SENSE: char = '↺';

    /// A letter followed by its number.
    pub fn plain(letter: char, value: f64, span: Range<usize>) -> Word {
        Word { letter, value, span, around: [1, 0], distance: None, asks: None }
    }

    /// The bytes of its number.
    pub fn number(&self) -> Range<usize> {
        self.span.start + usize::from(self.around[0])..self.span.end - usize::from(self.around[1])
    }

    /// The number in tenths if it has no finer part: 901 for G90.1.
    pub fn tenths(&self) -> Option<u32> {
        let tenths = self.value * 10.0;
        let whole = tenths.round();
        ((whole - tenths).abs() < 1e-9 && (0.0..=1e6).contains(&whole)).then_some(whole as u32)
    }

    /// The number if it is whole and not negative.
    pub fn whole(&self) -> Result<u32, Refusal> {
        match self.tenths() {
            Some(tenths) if tenths % 10 == 0 => Ok(tenths / 10),
            _ => Err(self.refuse(Fault::NotWhole { letter: self.letter })),
        }
    }

    /// The number of M70 to M73, which keep and restore modes for LinuxCNC; Fanuc and Haas do not have them.
    pub fn keeps_modes(&self, dialect: Dialect) -> Option<u32> {
        let is_read = self.letter == 'M' && matches!(dialect, Dialect::Iso | Dialect::LinuxCnc);
        self.whole().ok().filter(|code| is_read && matches!(code, 70..=73))
    }

    /// `fault` at this word.
    pub fn refuse(&self, fault: Fault) -> Refusal {
        Refusal::new(self.span.clone(), fault)
    }
}
