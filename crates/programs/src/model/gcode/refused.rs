//! Reasons for refusing words: unsupported features, contradictory words, impossible arcs; and a fault with its position in a line.

use std::ops::Range;

use thiserror::Error;

use crate::model::gcode::{Dialect, Fault, GcodeError, Word};

/// A feature of the language that cannot be followed, so that ignoring it would cut something else.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum Unsupported {
    /// G41, G42 and their kin.
    #[error(
        "cutter radius compensation is not followed as the control makes it; expected the path of the tool centre with G40, or \
         cutter_compensation = \"off\" in [gcode] of the process file, which writes it"
    )]
    CutterCompensation,
    /// G75, G77 to G79, G87, G88, G76 of threads.
    #[error("this canned cycle is not supported; expected the cycle written out as G0 and G1 moves")]
    CannedCycle,
    /// G16, G50, G51, G68: polar, scaled and rotated coordinates.
    #[error("polar, scaled or rotated coordinates are not supported; expected plain coordinates")]
    Transform,
    /// G43.5.
    #[error("tool axes as vectors (G43.5) are not supported; expected angles of rotary axes with G43.4")]
    ToolVector,
    /// G5, G6, G33 and other motions.
    #[error("this motion is not supported; expected G0, G1, G2 or G3")]
    Motion,
    /// G31, G37, G38.2 and their kin: moves that a touch ends.
    #[error(
        "goes on until something is touched, so that the program does not say where it ends; expected G0 or G1 to a position, and what \
         measures in a program of its own"
    )]
    Touch,
    /// Any other G word.
    #[error("this G word is not supported; expected a word of a 3-axis mill program")]
    UnknownG,
    /// U, V, W.
    #[error("secondary axes are not supported; expected X, Y and Z only")]
    SecondaryAxis,
    /// `,R` and `,C`.
    #[error(
        "corners that the control rounds or bevels (,R ,C) are not supported; expected the corner written as moves"
    )]
    Corner,
    /// `,R` or `,C` elsewhere than between straight lines.
    #[error(
        "corners that the control rounds or bevels (,R ,C) are followed between two straight lines of G17 and G90 that are long enough; expected \
         the corner written as moves"
    )]
    CornerPlace,
    /// G68 without centre or angle.
    #[error(
        "rotates by what the line does not say; expected X, Y and R on the line of G68, in G17 and G90, and no other motion"
    )]
    FrameCentre,
    /// The first motion behind G68, G69 or G16.
    #[error(
        "leads to a place that depends on the control here; expected X and Y in G90 behind G68 and G69, radius and angle behind G16"
    )]
    FrameStart,
    /// A word that is not followed under G68 or G16.
    #[error("not followed while coordinates are rotated or polar; expected it before G68 or G16, or behind G69 or G15")]
    InFrame,
    /// The language of Okuma's OSP.
    #[error(
        "a program of Okuma's OSP control, whose words mean other things than those of ISO code; expected ISO code"
    )]
    Okuma,
    /// The first block of Heidenhain's DIN/ISO: `%PART G71`.
    #[error(
        "a program of Heidenhain's DIN/ISO, in which M91, G54 and others mean other things than in ISO code; expected Klartext (BEGIN PGM)"
    )]
    DinIso,
    /// M97, M98, M99, M198, O words after the first.
    #[error(
        "subprograms are not read; expected one program, or expand in [gcode] of the process file (--expand), which writes it out"
    )]
    Subprogram,
    /// M21 to M23.
    #[error(
        "mirrors axes on some controls; expected a program without it, or dialect = \"haas\" in [gcode], to which it is a function of the user's"
    )]
    Mirror,
    /// M128, M129, M428 to M430.
    #[error(
        "turns tool-tip programming (X, Y and Z of the tip) on or off on some controls; expected G43.4 and G49, or, where it is another \
         function of Fanuc or Haas, that dialect in [gcode]"
    )]
    TipFunction,
    /// Marlin's M206, M218, M290, M428.
    #[error(
        "moves the zero or the tool (Marlin); expected a program without it, or dialect = \"fanuc\" or \"haas\" in [gcode], to which it is \
         another function"
    )]
    MovedZero,
    /// M46 with P, M96.
    #[error("goes on elsewhere in the program as the machine says; expected the lines in the order they run")]
    Jump,
    /// M47.
    #[error(
        "runs the program from its first line again (Mach); expected M2 or M30, or dialect = \"fanuc\" or \"haas\" in [gcode], to which it \
         is another function"
    )]
    Again,
    /// M109 with P.
    #[error("asks for the value of a variable (Haas); expected a program that assigns it")]
    Asked,
    /// G53 with an arc in force.
    #[error("machine coordinates with an arc are not supported; expected G53 with G0 or G1")]
    MachineArc,
}

impl Unsupported {
    /// Returns why `word`, an M word of a line with `words`, is refused: it may change where the tool goes. `None` if it may stay.
    pub(crate) fn for_m_word(word: &Word, words: &[Word], dialect: Dialect) -> Option<Unsupported> {
        let has_p = || words.iter().any(|word| word.letter == 'P');
        let is_other_to = |dialects: &[Dialect]| dialects.contains(&dialect);
        let is_builder_function = is_other_to(&[Dialect::Fanuc, Dialect::Haas]);
        match word.whole_number().ok()? {
            97..=99 | 198 => Some(Unsupported::Subprogram),
            21..=23 if !is_other_to(&[Dialect::Haas, Dialect::Sinumerik, Dialect::Heidenhain]) => {
                Some(Unsupported::Mirror)
            }
            _ if !dialect.is_iso() => None,
            46 if has_p() => Some(Unsupported::Jump),
            96 => Some(Unsupported::Jump),
            109 if has_p() => Some(Unsupported::Asked),
            47 if !is_builder_function => Some(Unsupported::Again),
            128 | 129 | 428..=430 if !is_builder_function => Some(Unsupported::TipFunction),
            206 | 218 | 290 if !is_builder_function => Some(Unsupported::MovedZero),
            _ => None,
        }
    }
}

/// A word that controls read in contradictory ways.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum Contradiction {
    /// G10 L20.
    #[error(
        "G10 L20 P1 puts G54.1 P1 at these machine coordinates on Fanuc and Haas, and on LinuxCNC and Grbl gives these coordinates of G54 to \
         where the tool is"
    )]
    WorkOffset,
    /// G43.1 with coordinates.
    #[error("G43.1 with X, Y or Z moves there on Fanuc, and on LinuxCNC and Grbl sets the length of the tool")]
    Length,
    /// M73 in a subprogram that is called by its number.
    #[error(
        "M73 in a subprogram restores modes at its end on LinuxCNC, and is a function of the machine on Fanuc and Haas"
    )]
    KeptModes,
    /// ROUND in the number of a word.
    #[error(
        "ROUND in the number of a word rounds to the last decimal of a coordinate on Fanuc and Haas, and on LinuxCNC to a whole number"
    )]
    Rounded,
}

/// Why the words of an arc define no arc.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum ArcFault {
    /// Start and end at different distances from the centre.
    #[error(
        "arc starts {start_mm:.4} mm and ends {end_mm:.4} mm from its centre; expected equal radii to {rounding_mm} mm or 0.1 %"
    )]
    Radii {
        /// Distance from centre to start, mm.
        start_mm: f64,
        /// Distance from centre to end, mm.
        end_mm: f64,
        /// How far they may differ in any case, mm.
        rounding_mm: f64,
    },
    /// The centre is the start.
    #[error("arc of radius zero; expected a centre away from the start")]
    NoRadius,
    /// A radius too small to reach the end.
    #[error("radius {radius_mm:.4} mm cannot reach an end {chord_mm:.4} mm away; expected at least half the distance")]
    TooShort {
        /// The radius given, mm.
        radius_mm: f64,
        /// Distance from start to end in the plane, mm.
        chord_mm: f64,
    },
    /// A radius and no distance: any centre would do.
    #[error("radius form with its end at its start has no definite centre; expected a full circle by its centre")]
    NoChord,
}

/// A fault and the bytes of the line that it is about, before file and line number are known.
#[derive(Clone, Debug, PartialEq)]
pub struct Refusal {
    /// Bytes of the line the fault is about.
    pub span: Range<usize>,
    pub fault: Fault,
}

/// Most characters of a line in a message.
const SHOWN: usize = 80;

impl Refusal {
    /// Creates the refusal of the bytes `span` of a line because of `fault`.
    pub fn new(span: Range<usize>, fault: Fault) -> Refusal {
        Refusal { span, fault }
    }

    /// Converts the refusal to an error with the file's name, the line number from 1, and the refused text quoted from `content`, the line.
    pub fn locate(self, file: &str, line: usize, content: &[u8]) -> GcodeError {
        let before = content.get(..self.span.start).unwrap_or_default();
        let found = String::from_utf8_lossy(content.get(self.span).unwrap_or_default());
        let is_long = found.chars().count() > SHOWN;
        let shown: String = found.chars().take(if is_long { SHOWN - 1 } else { SHOWN }).collect();
        GcodeError {
            file: file.to_owned(),
            line,
            column: String::from_utf8_lossy(before).chars().count() + 1,
            found: if is_long { shown + "…" } else { shown },
            fault: self.fault,
            dialect: Dialect::Iso,
        }
    }
}
