//! Meanings of Sinumerik's words: G words, names, and names with a value.

use crate::model::gcode::{
    AngleChoice, Dialect, Fault, Foreign, ForeignWord, GWord, Inclination, LengthUnit, MotionCode, Refusal, Setting,
    Unsupported, Word, WorkOffset,
};

/// Returns the meaning of a G word, for those shared with ISO that of ISO; `Err` if it is not followed.
pub(crate) fn g_word(word: &Word) -> Result<GWord, Refusal> {
    let number = word.whole_number()?;
    Ok(match number {
        0..=4 | 9 | 17..=19 | 40 | 53..=57 | 64 | 90 | 91 | 93..=95 | 97 => {
            return GWord::parse(word, Dialect::Sinumerik);
        }
        60 | 641..=645 => GWord::PathControl,
        70 => GWord::UnitOfCoordinates(LengthUnit::Inch),
        71 => GWord::UnitOfCoordinates(LengthUnit::Millimetre),
        74 | 75 => GWord::Home,
        153 => GWord::Machine,
        290 => GWord::Passive("language"),
        450 | 451 => GWord::Passive("corners"),
        460..=462 => GWord::Passive("approach"),
        500 | 505..=599 => GWord::WorkOffset(WorkOffset::settable(number)),
        601..=603 => GWord::Passive("exact stop criterion"),
        700 => GWord::Unit(LengthUnit::Inch),
        710 => GWord::Unit(LengthUnit::Millimetre),
        971 => GWord::CountsTurns(true),
        41 | 42 => return Err(word.refuse(Fault::Foreign(Foreign::Compensation { off: "G40" }))),
        5 | 7 | 33..=35 | 63 | 147 | 148 | 247 | 248 | 331 | 332 | 347 | 348 => {
            return Err(word.refuse(Fault::Foreign(Foreign::Motion)));
        }
        58 | 59 | 110..=112 => return Err(word.refuse(Fault::Foreign(Foreign::Frame))),
        _ => return Err(word.refuse(Fault::Unsupported(Unsupported::UnknownG))),
    })
}

static SUPA: ForeignWord = ForeignWord { name: "SUPA", meaning: GWord::Machine };
static TRANS: ForeignWord =
    ForeignWord { name: "TRANS", meaning: GWord::Setting(Setting::Translation { afresh: true }) };
static ATRANS: ForeignWord =
    ForeignWord { name: "ATRANS", meaning: GWord::Setting(Setting::Translation { afresh: false }) };
static TRAORI: ForeignWord = ForeignWord { name: TRANSFORMED, meaning: GWord::TipControl };
static TRAFOOF: ForeignWord = ForeignWord { name: "TRAFOOF", meaning: GWord::Passive("tool length") };
/// CYCLE800() and CYCLE800(…, "0", …), which may retract.
pub(crate) static SWIVEL_OFF: ForeignWord = ForeignWord { name: "CYCLE800", meaning: GWord::Passive("rotation") };
pub(crate) static RETRACTS: ForeignWord = ForeignWord { name: "CYCLE800", meaning: GWord::Home };
/// Tapping for one hole; what it does is over with its line.
pub(crate) static TAP: ForeignWord = ForeignWord { name: "CYCLE84", meaning: GWord::Motion(MotionCode::Cycle(84)) };
pub(crate) static HIGHER: ForeignWord =
    ForeignWord { name: "_DIR", meaning: GWord::Align(AngleChoice::Direction { is_higher: true }) };
pub(crate) static LOWER: ForeignWord =
    ForeignWord { name: "_DIR", meaning: GWord::Align(AngleChoice::Direction { is_higher: false }) };
static SWIVELS: [ForeignWord; 6] = [
    swivel_about([0, 1, 2]),
    swivel_about([0, 2, 1]),
    swivel_about([1, 0, 2]),
    swivel_about([1, 2, 0]),
    swivel_about([2, 0, 1]),
    swivel_about([2, 1, 0]),
];

const fn swivel_about(axes: [usize; 3]) -> ForeignWord {
    ForeignWord { name: "CYCLE800", meaning: GWord::Setting(Setting::Incline(Inclination::AxisByAxis(axes))) }
}

/// `_MODE` of CYCLE800 by the solid angle: `_A` about z, `_B` about the new y (Siemens, *SINUMERIK 828D Operating Manual*, Swivel plane).
pub(crate) const SOLID_ANGLE: f64 = 64.0;
/// That of the same turns axis by axis: about z, y and x.
const BY_Z_AND_Y: f64 = 27.0;

/// Returns CYCLE800 by its `_MODE`: axis by axis about the axes that bits 0 and 1, 2 and 3, 4 and 5 name (1 is X), or by the solid angle; `None`
/// for others.
pub(crate) fn swivel(mode: f64) -> Option<&'static ForeignWord> {
    let mode = if mode == SOLID_ANGLE { BY_Z_AND_Y } else { mode };
    if mode.fract() != 0.0 || !(0.0..64.0).contains(&mode) {
        return None;
    }
    let bits = mode as usize;
    let axes = [bits & 3, bits >> 2 & 3, bits >> 4 & 3].map(|axis| axis.checked_sub(1));
    let [Some(a), Some(b), Some(c)] = axes else { return None };
    let wanted = GWord::Setting(Setting::Incline(Inclination::AxisByAxis([a, b, c])));
    SWIVELS.iter().find(|swivel| swivel.meaning == wanted)
}

static RET: ForeignWord = ForeignWord { name: "RET", meaning: GWord::End };
static END: ForeignWord = ForeignWord { name: "M", meaning: GWord::End };
pub(crate) static OTHER: ForeignWord = ForeignWord { name: "M", meaning: GWord::Auxiliary };

/// The transformation that keeps the tip in place (TCP); its number may stand in brackets.
pub(crate) const TRANSFORMED: &str = "TRAORI";

/// Returns the meaning of the M word with this number.
pub(crate) fn m_word(number: u32) -> &'static ForeignWord {
    if matches!(number, 2 | 17 | 30) { &END } else { &OTHER }
}

/// Meaning of a name that stands alone.
pub(crate) enum Name {
    /// A word that is followed.
    Word(&'static ForeignWord),
    /// A name that does not change where the tool goes.
    Passive,
    /// A word of a contour: its letter (`Word::OF_CONTOURS`) and number, and why it is refused where contours are not written out.
    OfContour(char, f64, Foreign),
}

/// Returns the meaning of `name` (upper case), with or without arguments behind it; `Err` if it is not followed.
pub(crate) fn plain_name(name: &str, has_arguments: bool) -> Result<Name, Foreign> {
    Ok(match name {
        "SUPA" => Name::Word(&SUPA),
        "TRANS" => Name::Word(&TRANS),
        "ATRANS" => Name::Word(&ATRANS),
        "RET" => Name::Word(&RET),
        TRANSFORMED => Name::Word(&TRAORI),
        "TRAFOOF" if !has_arguments => Name::Word(&TRAFOOF),
        "MSG" | "WORKPIECE" | "CYCLE832" | "SETMS" | "FGROUP" if has_arguments => Name::Passive,
        "FNORM" | "CFC" | "CFTCP" | "CFIN" | "NORM" | "KONT" | "KONTC" | "KONTT" | "BRISK" | "SOFT" | "DRIVE"
        | "BRISKA" | "SOFTA" | "CUT2D" | "CUT2DF" | "FFWON" | "FFWOF" | "COMPON" | "COMPOF" | "COMPCAD"
        | "COMPCURV" | "COMPSURF" | "DIAMOF" | "STOPRE" | "FIFOCTRL" | "STARTFIFO" | "STOPFIFO" | "DYNNORM"
        | "DYNPOS" | "DYNROUGH" | "DYNSEMIFIN" | "DYNFINISH" | "UPATH" | "SPATH" | "RTLION" | "RTLIOF" | "ORIAXES"
        | "SETMS" | "WALIMON" | "WALIMOF"
            if !has_arguments =>
        {
            Name::Passive
        }
        "CIP" => Name::OfContour('v', 0.0, Foreign::Motion),
        "CT" => Name::OfContour('u', 0.0, Foreign::Motion),
        "ROT" => Name::OfContour('w', 0.0, Foreign::Frame),
        "AROT" => Name::OfContour('w', 1.0, Foreign::Frame),
        "SCALE" => Name::OfContour('w', 2.0, Foreign::Frame),
        "ASCALE" => Name::OfContour('w', 3.0, Foreign::Frame),
        _ => return Err(refusal_of_name(name)),
    })
}

/// Returns why `name`, which is not followed, is refused.
fn refusal_of_name(name: &str) -> Foreign {
    match name {
        "ROTS" | "AROTS" | "CROTS" | "MIRROR" | "AMIRROR" | "TOFRAME" | "TOROT" | "PAROT" => Foreign::Frame,
        "TRANSMIT" | "TRACYL" | "TRAANG" | "TRACON" | "CYCLE800" | "TCARR" | "TCOABS" | "TCOFR" | "ORIWKS"
        | "ORIMKS" | "ORIVECT" | "ORIEULER" | "ORIRPY" | "ORIVIRT1" | "ORIVIRT2" | "ORIPLANE" | "ORICURVE"
        | "ORISON" => Foreign::Kinematics,
        "ASPLINE" | "BSPLINE" | "CSPLINE" | "POLY" | "INVCW" | "INVCCW" => Foreign::Motion,
        "IF" | "ELSE" | "ENDIF" | "GOTO" | "GOTOF" | "GOTOB" | "GOTOC" | "GOTOS" | "LOOP" | "ENDLOOP" | "FOR"
        | "ENDFOR" | "WHILE" | "ENDWHILE" | "REPEAT" | "REPEATB" | "UNTIL" | "CASE" => Foreign::Flow,
        "DEF" | "DEFINE" | "REDEF" | "STRING" | "REAL" | "INT" | "BOOL" => Foreign::Parameter,
        "MCALL" => Foreign::Cycle,
        _ if ["CYCLE", "HOLES", "POCKET", "SLOT", "LONGHOLE"].iter().any(|cycle| name.starts_with(cycle)) => {
            Foreign::Cycle
        }
        _ => Foreign::Call,
    }
}

/// Meaning of a name with a value behind `=`.
pub(crate) enum Assigned {
    /// The radius of an arc.
    Radius,
    /// A value that does not change where the tool goes.
    Passive,
    /// A word of a contour: its letter (`Word::OF_CONTOURS`), and why it is refused where contours are not written out.
    OfContour(char, Foreign),
}

/// Returns the meaning of `NAME=`, in upper case; `Err` if it is not followed.
pub(crate) fn assigned_name(name: &str) -> Result<Assigned, Foreign> {
    match name {
        "CR" => Ok(Assigned::Radius),
        "ADIS" | "ADISPOS" | "CTOL" | "OTOL" | "ATOL" | "SPOS" | "SPOSA" | "LIMS" | "ACC" | "OVR" | "VELOLIM"
        | "FGREF" | "DISC" | "FL" | "FP" => Ok(Assigned::Passive),
        "CHF" => Ok(Assigned::OfContour('c', Foreign::Corner)),
        "CHR" => Ok(Assigned::OfContour('h', Foreign::Corner)),
        "RND" => Ok(Assigned::OfContour('f', Foreign::Corner)),
        "RNDM" => Ok(Assigned::OfContour('m', Foreign::Corner)),
        "AP" => Ok(Assigned::OfContour('a', Foreign::Frame)),
        "RP" => Ok(Assigned::OfContour('p', Foreign::Frame)),
        "RPL" => Ok(Assigned::OfContour('l', Foreign::Frame)),
        "TURN" => Ok(Assigned::OfContour('t', Foreign::Motion)),
        "FRC" | "FRCM" => Err(Foreign::Corner),
        "AR" | "ANG" | "OFFN" => Err(Foreign::Motion),
        "LEAD" | "TILT" => Err(Foreign::Kinematics),
        _ => Err(Foreign::Parameter),
    }
}

/// Whether `letter` is an address with a plain number, as in ISO.
pub(crate) fn is_address(letter: char) -> bool {
    matches!(
        letter,
        'A' | 'B' | 'C' | 'D' | 'F' | 'G' | 'H' | 'I' | 'J' | 'K' | 'M' | 'N' | 'S' | 'T' | 'X' | 'Y' | 'Z'
    )
}

/// Whether only Sinumerik has the name `name` (upper case, with arguments or not).
pub(crate) fn is_sinumerik_name(name: &str, has_arguments: bool) -> bool {
    let flow = ["IF", "ELSE", "ENDIF", "GOTO", "REPEAT", "WHILE", "ENDWHILE", "REAL", "INT", "RET", "CT"];
    let is_known = plain_name(name, has_arguments).is_ok() || !matches!(refusal_of_name(name), Foreign::Call);
    name.len() > 1 && is_known && !flow.contains(&name)
}

/// Whether, among mills, only Sinumerik has the G word of this number.
pub(crate) fn is_sinumerik_g(number: &str) -> bool {
    matches!(number.parse(), Ok(70 | 71 | 153 | 500 | 505..=599 | 641..=645 | 700 | 710))
}
