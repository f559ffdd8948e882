//! A word of a line: a letter with its number.

use std::ops::Range;

use crate::model::gcode::{Dialect, Distance, Fault, ForeignWord, Refusal};

/// A word of a block as read: a letter with its number.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Word {
    /// The letter in upper case.
    pub letter: char,
    /// The number, the nearest `f64` to what is written.
    pub value: f64,
    /// The bytes of the word in its line.
    pub span: Range<usize>,
    /// How many bytes of the word come before and after its number: 1 and 0 in `X5`, 5 and 1 in `X=IC(5)`.
    pub around: [u8; 2],
    /// Whether the coordinate is absolute or incremental, if the word itself says so.
    pub distance: Option<Distance>,
    /// The meaning of a word that ISO does not have.
    pub meaning: Option<&'static ForeignWord>,
}

impl Word {
    /// Stands for the letter of a word that is none of ISO: the sense of an arc, Heidenhain's `DR+`.
    pub const SENSE: char = '↺';

    /// Stands for the letters of the height to which a tap is retracted, and of its feed, both in brackets (CYCLE84).
    pub const RETRACT: char = '↑';
    pub const TAP_FEED: char = '↓';

    /// Letters of words of contours, which are read only to be written out as lines and arcs: polar angle and radius (AP, RP; PA, PR), turns
    /// (TURN), rounding (RND), chamfer by its own length (CHF) and by that of a side (CHR), rounding in force (RNDM), angle of a rotation (RPL),
    /// third point of an arc (I1, J1, K1); the arcs themselves (CT, CIP), and rotations and scales (ROT 0, AROT 1, SCALE 2, ASCALE 3).
    const OF_CONTOURS: &str = "aptfchmlijkuvw";

    /// Whether the word is of a contour that is written out as lines and arcs.
    pub fn is_of_contour(&self) -> bool {
        Word::OF_CONTOURS.contains(self.letter)
    }

    /// Creates a word that is a letter directly followed by its number.
    pub fn plain(letter: char, value: f64, span: Range<usize>) -> Word {
        Word { letter, value, span, around: [1, 0], distance: None, meaning: None }
    }

    /// Returns the range of bytes of the number in its line.
    pub fn number(&self) -> Range<usize> {
        self.span.start + usize::from(self.around[0])..self.span.end - usize::from(self.around[1])
    }

    /// Returns the number in tenths (901 for G90.1); `None` if it has more decimals, is negative or above 100,000.
    pub fn tenths(&self) -> Option<u32> {
        let tenths = self.value * 10.0;
        let whole = tenths.round();
        ((whole - tenths).abs() < 1e-9 && (0.0..=1e6).contains(&whole)).then_some(whole as u32)
    }

    /// Returns the number if it is whole and not negative, or a refusal of the word.
    pub fn whole_number(&self) -> Result<u32, Refusal> {
        match self.tenths() {
            Some(tenths) if tenths % 10 == 0 => Ok(tenths / 10),
            _ => Err(self.refuse(Fault::NotWhole { letter: self.letter })),
        }
    }

    /// Returns 70 to 73 for M70 to M73 (save and restore of modes, as in LinuxCNC), which the dialects ISO and LinuxCNC have; `None` otherwise.
    pub fn mode_save_code(&self, dialect: Dialect) -> Option<u32> {
        let has_mode_saving = self.letter == 'M' && matches!(dialect, Dialect::Iso | Dialect::LinuxCnc);
        self.whole_number().ok().filter(|code| has_mode_saving && matches!(code, 70..=73))
    }

    /// Creates the refusal of this word because of `fault`.
    pub fn refuse(&self, fault: Fault) -> Refusal {
        Refusal::new(self.span.clone(), fault)
    }
}
