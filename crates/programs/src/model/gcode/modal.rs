//! The modal state of a G-code program, and the meanings of its G words.

use crate::model::{
    Plane, TurnDirection,
    gcode::{AngleChoice, Dialect, Fault, Inclination, LengthUnit, Refusal, Unsupported, Word, WorkOffset},
};

/// The motion mode in force: rapid, line, arc or cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MotionCode {
    /// G0.
    Rapid,
    /// G1.
    Line,
    /// G2, G3.
    Arc(TurnDirection),
    /// G73, G74, G76, G81 to G86, G89.
    Cycle(u32),
}

impl MotionCode {
    /// Returns the number after G.
    pub fn number(self) -> u32 {
        match self {
            MotionCode::Rapid => 0,
            MotionCode::Line => 1,
            MotionCode::Arc(TurnDirection::Clockwise) => 2,
            MotionCode::Arc(TurnDirection::CounterClockwise) => 3,
            MotionCode::Cycle(number) => number,
        }
    }
}

/// The distance mode: absolute coordinates or steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Distance {
    /// G90, G90.1.
    Absolute,
    /// G91, G91.1.
    Incremental,
}

/// The modal state in force on a line: motion, plane, units, distance modes, feed, spindle and tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ModalState {
    pub motion: Option<MotionCode>,
    pub plane: Plane,
    pub unit: LengthUnit,
    /// Meaning of X, Y, Z.
    pub distance: Distance,
    /// Meaning of I, J, K.
    pub centres: Distance,
    /// G99: cycles end at their plane R; otherwise (G98) where they began.
    pub returns_to_r_plane: bool,
    pub feed_mode: FeedMode,
    /// How many mm one unit of F is; without meaning for inverse-time feed.
    pub feed_unit_mm: f64,
    /// Whether F is in degrees where rotary axes move alone; to Haas it is in mm at a diameter that the control knows.
    pub has_degrees: bool,
    /// Whether S is in rev/min (G97), not a surface speed (G96).
    pub is_rev_per_min: bool,
    /// The number after F, converted from inches to mm unless it is inverse-time feed.
    pub feed: Option<f64>,
    /// The number after S.
    pub spindle: Option<f64>,
    /// Whether the control keeps the tip in place while rotary axes turn (G43.4).
    pub tip_control: bool,
    /// The tool in the spindle: that of the last M6, or before the first that of the last T.
    pub tool: Option<u32>,
    /// The feature the line is in, an index into [`GcodeOptions::features`](crate::gcode::GcodeOptions::features).
    pub feature: Option<u16>,
}

/// The feed mode: what F means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FeedMode {
    /// G93: one over the minutes of the block.
    InverseTime,
    /// G94.
    PerMinute,
    /// G95.
    PerRevolution,
}

impl ModalState {
    /// Returns the state in which a controller starts: G0, G17, G90, G94, G97, G98. Some start in G1, which follows the same path.
    pub fn at_start(unit: LengthUnit, centres: Distance) -> ModalState {
        ModalState {
            motion: Some(MotionCode::Rapid),
            plane: Plane::Xy,
            unit,
            distance: Distance::Absolute,
            centres,
            returns_to_r_plane: false,
            feed_mode: FeedMode::PerMinute,
            feed_unit_mm: unit.mm(),
            has_degrees: true,
            is_rev_per_min: true,
            feed: None,
            spindle: None,
            tip_control: false,
            tool: None,
            feature: None,
        }
    }

    /// Returns the spindle speed, rev/min; `None` without S, or where S is a surface speed.
    pub fn spindle_rev_per_min(&self) -> Option<f64> {
        self.spindle.filter(|_| self.is_rev_per_min)
    }

    /// Returns F per minute, in mm, or as it is in inverse time; `None` without F (and for feed per revolution, without S in rev/min).
    pub fn per_minute(&self) -> Option<f64> {
        match self.feed_mode {
            FeedMode::PerMinute | FeedMode::InverseTime => self.feed,
            FeedMode::PerRevolution => Some(self.feed? * self.spindle_rev_per_min()?),
        }
    }
}

/// The meaning of a G word. Words that select a state which this module assumes anyway, or that do not change
/// where the tool goes, are [`GWord::Passive`] and stay in the program as they are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum GWord {
    Motion(MotionCode),
    /// G80.
    CancelMotion,
    Plane(Plane),
    Unit(LengthUnit),
    /// The unit of coordinates alone, not that of the feed.
    UnitOfCoordinates(LengthUnit),
    Distance(Distance),
    Centres(Distance),
    /// G54 to G59.3, and G54.1, whose P says which.
    WorkOffset(Option<WorkOffset>),
    /// A preset of Heidenhain's table, whose number the word has.
    Preset,
    Feed(FeedMode),
    /// G97, or G96.
    CountsTurns(bool),
    /// G99, or G98.
    ReturnsToClear(bool),
    /// Words whose coordinates set something and command no motion.
    Setting(Setting),
    /// G5, G5.1, G8, G187: smoothing; they carry P, Q, E or R, and no coordinates.
    Smoothing,
    /// G4.
    Dwell,
    /// G28, G30, G28.2; G28.1 and G30.1 but of LinuxCNC.
    Home,
    /// G15, which with H selects a work offset of Okuma's.
    PolarOff,
    /// G53.
    Machine,
    /// Away from the workpiece along the tool, to a place that the program does not say.
    Retract,
    /// The feed of the tool's call or table, which the program does not say.
    FeedOfTool,
    /// G43.4: X, Y and Z are those of the tip, whatever rotary axes do.
    TipControl,
    /// M129: no longer, once the line has run.
    TipControlEnds,
    /// Turns the tool along z of the inclined plane (G53.1), once the line's plane is in force.
    Align(AngleChoice),
    /// Finds those angles and turns nothing (PLANE with STAY).
    FindAngles(AngleChoice),
    /// The end of the program.
    End,
    /// Other words for the machine, any number of them on a line.
    Auxiliary,
    /// G61, G64: they may carry a P.
    PathControl,
    /// Those that only need their group, which no other word of the line may share: tool length (G43, G44, G49), radius
    /// compensation off (G40), exact stop (G9), scaling, mirroring, macros and rotation off (G50, G50.1, G67, G69).
    Passive(&'static str),
}

/// What a word sets by its coordinates: a zero, a length, an origin or a pole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Setting {
    /// G10.
    Data,
    /// G52.
    Local,
    /// G92.
    Origin,
    /// G92.1, G92.2: the origin of G92 no longer counts; kept for G92.3 if so.
    OriginOff { keeps: bool },
    /// G92.3.
    OriginOn,
    /// G43.1: a tool length.
    Length,
    /// G28.1, G30.1: where the machine stands is kept for G28 and G30.
    Stored,
    /// The zero moves on from that of the work offset: to the coordinates, those left out to 0 if it is set `afresh`, or by them.
    Translation { afresh: bool },
    /// The centre of arcs that follow.
    Pole,
    /// An inclined plane (G68.2).
    Incline(Inclination),
}

/// A word of a dialect other than ISO that stands for a G word: its name and its meaning.
#[derive(Debug, PartialEq)]
pub(crate) struct ForeignWord {
    pub name: &'static str,
    pub meaning: GWord,
}

impl GWord {
    /// Returns the meaning of `word`, a G word, or why it is refused.
    pub fn parse(word: &Word, dialect: Dialect) -> Result<GWord, Refusal> {
        let tenths = word.tenths().ok_or_else(|| word.refuse(Fault::Unsupported(Unsupported::UnknownG)))?;
        // Kept there, an axis stands; to Fanuc and Mach it is where axes go.
        if matches!(tenths, 281 | 301) && dialect != Dialect::LinuxCnc {
            return Ok(GWord::Home);
        }
        if matches!(tenths, 531 | 682) && matches!(dialect, Dialect::Iso | Dialect::Fanuc) {
            return Ok(match tenths {
                531 => GWord::Align(AngleChoice::Least),
                _ => GWord::Setting(Setting::Incline(Inclination::Euler)),
            });
        }
        GWord::from_tenths(tenths).ok_or_else(|| word.refuse(Fault::Unsupported(unsupported_reason(tenths))))
    }

    /// Returns the meaning of the G word whose number in tenths this is; `None` if it is not supported.
    fn from_tenths(tenths: u32) -> Option<GWord> {
        Some(match tenths {
            0 => GWord::Motion(MotionCode::Rapid),
            10 => GWord::Motion(MotionCode::Line),
            20 => GWord::Motion(MotionCode::Arc(TurnDirection::Clockwise)),
            30 => GWord::Motion(MotionCode::Arc(TurnDirection::CounterClockwise)),
            40 => GWord::Dwell,
            150 => GWord::PolarOff,
            170 => GWord::Plane(Plane::Xy),
            180 => GWord::Plane(Plane::Zx),
            190 => GWord::Plane(Plane::Yz),
            200 => GWord::Unit(LengthUnit::Inch),
            210 => GWord::Unit(LengthUnit::Millimetre),
            50 | 51 | 80 | 1870 => GWord::Smoothing,
            90 => GWord::Passive("exact stop"),
            100 => GWord::Setting(Setting::Data),
            280 | 282 | 300 => GWord::Home,
            281 | 301 => GWord::Setting(Setting::Stored),
            400 => GWord::Passive("radius compensation"),
            430 | 440 | 490 => GWord::Passive("tool length"),
            434 => GWord::TipControl,
            431 => GWord::Setting(Setting::Length),
            500 => GWord::Passive("scaling"),
            501 => GWord::Passive("mirroring"),
            520 => GWord::Setting(Setting::Local),
            530 => GWord::Machine,
            541 | 1540 => GWord::WorkOffset(None),
            // G112 and G113 are polar coordinates to Fanuc.
            540..=593 | 1100 | 1110 | 1140..=1290 => GWord::WorkOffset(Some(WorkOffset::from_g_tenths(tenths)?)),
            610 | 611 | 640 => GWord::PathControl,
            670 => GWord::Passive("macro"),
            690 | 691 => GWord::Passive("rotation"),
            920 => GWord::Setting(Setting::Origin),
            921 | 922 => GWord::Setting(Setting::OriginOff { keeps: tenths == 922 }),
            923 => GWord::Setting(Setting::OriginOn),
            800 => GWord::CancelMotion,
            900 => GWord::Distance(Distance::Absolute),
            910 => GWord::Distance(Distance::Incremental),
            901 => GWord::Centres(Distance::Absolute),
            911 => GWord::Centres(Distance::Incremental),
            930 => GWord::Feed(FeedMode::InverseTime),
            940 => GWord::Feed(FeedMode::PerMinute),
            950 => GWord::Feed(FeedMode::PerRevolution),
            960 | 970 => GWord::CountsTurns(tenths == 970),
            730 | 740 | 760 | 810 | 820 | 830 | 840 | 850 | 860 | 890 => GWord::Motion(MotionCode::Cycle(tenths / 10)),
            980 | 990 => GWord::ReturnsToClear(tenths == 990),
            _ => return None,
        })
    }

    /// Whether P and Q on the line may belong to this G word.
    pub fn takes_p(&self) -> bool {
        matches!(
            self,
            GWord::Dwell | GWord::PathControl | GWord::WorkOffset(None) | GWord::Setting(Setting::Incline(_))
        )
    }

    /// Returns the word's modal group; a line has at most one word of each.
    pub fn modal_group(self) -> &'static str {
        match self {
            GWord::Motion(_) => "motion",
            // A safety line has it beside G0.
            GWord::CancelMotion => "end of cycles",
            GWord::Plane(_) => "plane",
            GWord::Unit(_) | GWord::UnitOfCoordinates(_) => "unit",
            GWord::Distance(_) => "distance",
            GWord::Centres(_) => "centres",
            GWord::WorkOffset(_) | GWord::Preset => "work offset",
            GWord::FeedOfTool => "feed",
            GWord::Feed(_) => "feed mode",
            GWord::CountsTurns(_) => "spindle mode",
            GWord::Dwell | GWord::Home | GWord::Machine | GWord::Retract | GWord::Setting(_) => "once",
            GWord::ReturnsToClear(_) => "return level",
            GWord::Smoothing => "smoothing",
            GWord::PathControl => "path control",
            GWord::End | GWord::Auxiliary => "auxiliary",
            GWord::PolarOff => "polar",
            GWord::TipControl | GWord::TipControlEnds => "tool length",
            GWord::Align(_) | GWord::FindAngles(_) => "alignment",
            GWord::Passive(group) => group,
        }
    }
}

/// Numbers of the G words of moves that a touch ends: skip (Fanuc, Haas, Mach), measuring of workpieces and tools (Haas, Fanuc), probing
/// (LinuxCNC, Grbl). G38 alone is another motion.
pub(crate) const ENDED_BY_TOUCH: [f64; 11] = [31.0, 31.1, 31.2, 31.3, 31.4, 36.0, 37.0, 38.2, 38.3, 38.4, 38.5];

/// Returns why the G word whose number in tenths this is is not followed.
fn unsupported_reason(tenths: u32) -> Unsupported {
    match tenths {
        _ if ENDED_BY_TOUCH.contains(&(f64::from(tenths) / 10.0)) => Unsupported::Touch,
        410..=429 => Unsupported::CutterCompensation,
        730..=769 | 810..=899 => Unsupported::CannedCycle,
        435 => Unsupported::ToolVector,
        160 | 510..=519 | 680..=689 => Unsupported::Transform,
        650..=669 => Unsupported::Subprogram,
        52..=69 | 330..=339 | 380..=389 => Unsupported::Motion,
        _ => Unsupported::UnknownG,
    }
}
