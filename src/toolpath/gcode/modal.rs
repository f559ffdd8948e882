//! The state words leave behind for later lines, and which words there are.

use crate::toolpath::{
    Plane, Turn,
    gcode::{
        error::{Fault, Refusal, Unsupported},
        lex::Word,
    },
};

/// The length unit of a program's coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum LengthUnit {
    /// Millimetres (G21).
    #[default]
    Millimetre,
    /// Inches of 25.4 mm (G20).
    Inch,
}

impl LengthUnit {
    /// How many mm one unit is.
    #[must_use]
    pub fn mm(self) -> f64 {
        match self {
            LengthUnit::Millimetre => 1.0,
            LengthUnit::Inch => 25.4,
        }
    }
}

/// The motion in force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MotionCode {
    /// G0.
    Rapid,
    /// G1.
    Line,
    /// G2, G3.
    Arc(Turn),
}

impl MotionCode {
    /// The number after G.
    pub fn number(self) -> u32 {
        match self {
            MotionCode::Rapid => 0,
            MotionCode::Line => 1,
            MotionCode::Arc(Turn::Clockwise) => 2,
            MotionCode::Arc(Turn::CounterClockwise) => 3,
        }
    }
}

/// Whether numbers are positions or steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Distance {
    /// G90, G90.1.
    Absolute,
    /// G91, G91.1.
    Incremental,
}

/// What is in force on a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Modal {
    pub motion: Option<MotionCode>,
    pub plane: Plane,
    pub unit: LengthUnit,
    /// Meaning of X, Y, Z.
    pub distance: Distance,
    /// Meaning of I, J, K.
    pub centres: Distance,
    /// 0 for G54 to 5 for G59.
    pub work_offset: usize,
    pub feed_mm_per_min: Option<f64>,
    pub spindle_rev_per_min: Option<f64>,
}

impl Modal {
    /// The state a controller starts in: G17, G54, G90, G91.1, G94, no motion in force.
    pub fn at_start(unit: LengthUnit) -> Modal {
        Modal {
            motion: None,
            plane: Plane::Xy,
            unit,
            distance: Distance::Absolute,
            centres: Distance::Incremental,
            work_offset: 0,
            feed_mm_per_min: None,
            spindle_rev_per_min: None,
        }
    }
}

/// What a G word does. Words that put things into the state this module takes for granted, or that do not change
/// where the tool goes, are [`GWord::Passive`] and stay in the program as they are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum GWord {
    Motion(MotionCode),
    /// G80.
    CancelMotion,
    Plane(Plane),
    Unit(LengthUnit),
    Distance(Distance),
    Centres(Distance),
    WorkOffset(usize),
    /// G4.
    Dwell,
    /// G28, G30.
    Home,
    /// G53.
    Machine,
    /// G61, G64: they may carry a P.
    PathControl,
    /// Those that only need their group, which no other word of the line may share: tool length (G43, G49), radius
    /// compensation off (G40), feed per minute (G94), spindle in rev/min (G97), return level (G98, G99), polar
    /// coordinates and rotation off (G15, G69).
    Passive(&'static str),
}

impl GWord {
    /// What `word`, a G word, does.
    pub fn of(word: &Word) -> Result<GWord, Refusal> {
        let tenths = word.tenths().ok_or_else(|| word.refuse(Fault::Unsupported(Unsupported::UnknownG)))?;
        GWord::supported(tenths).ok_or_else(|| word.refuse(Fault::Unsupported(unsupported(tenths))))
    }

    fn supported(tenths: u32) -> Option<GWord> {
        Some(match tenths {
            0 => GWord::Motion(MotionCode::Rapid),
            10 => GWord::Motion(MotionCode::Line),
            20 => GWord::Motion(MotionCode::Arc(Turn::Clockwise)),
            30 => GWord::Motion(MotionCode::Arc(Turn::CounterClockwise)),
            40 => GWord::Dwell,
            150 => GWord::Passive("polar"),
            170 => GWord::Plane(Plane::Xy),
            180 => GWord::Plane(Plane::Zx),
            190 => GWord::Plane(Plane::Yz),
            200 => GWord::Unit(LengthUnit::Inch),
            210 => GWord::Unit(LengthUnit::Millimetre),
            280 | 300 => GWord::Home,
            400 => GWord::Passive("radius compensation"),
            430 | 490 => GWord::Passive("tool length"),
            530 => GWord::Machine,
            540 | 550 | 560 | 570 | 580 | 590 => GWord::WorkOffset((tenths as usize - 540) / 10),
            610 | 611 | 640 => GWord::PathControl,
            690 => GWord::Passive("rotation"),
            800 => GWord::CancelMotion,
            900 => GWord::Distance(Distance::Absolute),
            910 => GWord::Distance(Distance::Incremental),
            901 => GWord::Centres(Distance::Absolute),
            911 => GWord::Centres(Distance::Incremental),
            940 => GWord::Passive("feed mode"),
            970 => GWord::Passive("spindle mode"),
            980 | 990 => GWord::Passive("return level"),
            _ => return None,
        })
    }

    /// The modal group: a line has one word of each.
    pub fn group(self) -> &'static str {
        match self {
            GWord::Motion(_) | GWord::CancelMotion => "motion",
            GWord::Plane(_) => "plane",
            GWord::Unit(_) => "unit",
            GWord::Distance(_) => "distance",
            GWord::Centres(_) => "centres",
            GWord::WorkOffset(_) => "work offset",
            GWord::Dwell | GWord::Home | GWord::Machine => "once",
            GWord::PathControl => "path control",
            GWord::Passive(group) => group,
        }
    }
}

/// Why the G word of this number is not followed.
fn unsupported(tenths: u32) -> Unsupported {
    match tenths {
        410..=429 => Unsupported::CutterCompensation,
        730..=769 | 810..=899 => Unsupported::CannedCycle,
        100..=109 | 520..=529 | 920..=929 => Unsupported::Origin,
        541..=599 => Unsupported::ManyOffsets,
        160 | 500..=519 | 680..=689 => Unsupported::Transform,
        930 => Unsupported::InverseTimeFeed,
        950 => Unsupported::FeedPerRevolution,
        960 => Unsupported::SurfaceSpeed,
        50..=69 | 330..=339 | 380..=389 => Unsupported::Motion,
        _ => Unsupported::UnknownG,
    }
}

/// The names of the work offsets, by their index.
pub(crate) const WORK_OFFSETS: [&str; 6] = ["G54", "G55", "G56", "G57", "G58", "G59"];

/// The names of a plane and of its two centre words.
pub(crate) fn plane_names(plane: Plane) -> (&'static str, &'static str) {
    match plane {
        Plane::Xy => ("G17", "I and J"),
        Plane::Zx => ("G18", "I and K"),
        Plane::Yz => ("G19", "J and K"),
    }
}
