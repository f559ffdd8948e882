//! What Sinumerik's words ask for: G words, names, and names with a value.

use crate::toolpath::model::gcode::{
    Dialect, Fault, Foreign, GWord, LengthUnit, Refusal, Setting, Unsupported, Vocable, Word, WorkOffset,
};

/// What a G word asks for. Those that Sinumerik shares with ISO mean the same.
pub(crate) fn g_word(word: &Word) -> Result<GWord, Refusal> {
    let number = word.whole()?;
    Ok(match number {
        0..=4 | 9 | 17..=19 | 40 | 53..=57 | 64 | 90 | 91 | 93..=95 | 97 => return GWord::of(word, Dialect::Sinumerik),
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

static SUPA: Vocable = Vocable { name: "SUPA", asks: GWord::Machine };
static TRANS: Vocable = Vocable { name: "TRANS", asks: GWord::Setting(Setting::Translation { afresh: true }) };
static ATRANS: Vocable = Vocable { name: "ATRANS", asks: GWord::Setting(Setting::Translation { afresh: false }) };
static TRAORI: Vocable = Vocable { name: TRANSFORMED, asks: GWord::TipControl };
static TRAFOOF: Vocable = Vocable { name: "TRAFOOF", asks: GWord::Passive("tool length") };
static RET: Vocable = Vocable { name: "RET", asks: GWord::End };
static END: Vocable = Vocable { name: "M", asks: GWord::End };
static OTHER: Vocable = Vocable { name: "M", asks: GWord::Auxiliary };

/// The transformation that keeps the tip in its place; it may have its number in brackets.
pub(crate) const TRANSFORMED: &str = "TRAORI";

/// What an M word asks for.
pub(crate) fn m_word(number: u32) -> &'static Vocable {
    if matches!(number, 2 | 17 | 30) { &END } else { &OTHER }
}

/// A name as it stands alone.
pub(crate) enum Name {
    /// One that is followed.
    Word(&'static Vocable),
    /// One that does not change where the tool goes.
    Passive,
}

/// What `name`, in upper case, with or without arguments behind it, asks for.
pub(crate) fn name(name: &str, has_arguments: bool) -> Result<Name, Foreign> {
    Ok(match name {
        "SUPA" => Name::Word(&SUPA),
        "TRANS" => Name::Word(&TRANS),
        "ATRANS" => Name::Word(&ATRANS),
        "RET" => Name::Word(&RET),
        TRANSFORMED => Name::Word(&TRAORI),
        "TRAFOOF" if !has_arguments => Name::Word(&TRAFOOF),
        "MSG" | "WORKPIECE" | "CYCLE832" | "SETMS" | "FGROUP" if has_arguments => Name::Passive,
        "CFC" | "CFTCP" | "CFIN" | "NORM" | "KONT" | "KONTC" | "KONTT" | "BRISK" | "SOFT" | "DRIVE" | "BRISKA"
        | "SOFTA" | "CUT2D" | "CUT2DF" | "FFWON" | "FFWOF" | "COMPON" | "COMPOF" | "COMPCAD" | "COMPCURV"
        | "COMPSURF" | "DIAMOF" | "STOPRE" | "FIFOCTRL" | "STARTFIFO" | "STOPFIFO" | "DYNNORM" | "DYNPOS"
        | "DYNROUGH" | "DYNSEMIFIN" | "DYNFINISH" | "UPATH" | "SPATH" | "RTLION" | "RTLIOF" | "ORIAXES" | "SETMS"
        | "WALIMON" | "WALIMOF"
            if !has_arguments =>
        {
            Name::Passive
        }
        _ => return Err(refused(name)),
    })
}

fn refused(name: &str) -> Foreign {
    match name {
        "ROT" | "AROT" | "ROTS" | "AROTS" | "CROTS" | "SCALE" | "ASCALE" | "MIRROR" | "AMIRROR" | "TOFRAME"
        | "TOROT" | "PAROT" => Foreign::Frame,
        "TRANSMIT" | "TRACYL" | "TRAANG" | "TRACON" | "CYCLE800" | "TCARR" | "TCOABS" | "TCOFR" | "ORIWKS"
        | "ORIMKS" | "ORIVECT" | "ORIEULER" | "ORIRPY" | "ORIVIRT1" | "ORIVIRT2" | "ORIPLANE" | "ORICURVE"
        | "ORISON" => Foreign::Kinematics,
        "CIP" | "CT" | "ASPLINE" | "BSPLINE" | "CSPLINE" | "POLY" | "INVCW" | "INVCCW" => Foreign::Motion,
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

/// A name with a value behind `=`.
pub(crate) enum Assigned {
    /// The radius of an arc.
    Radius,
    /// One that does not change where the tool goes.
    Passive,
}

/// What `NAME=` in upper case gives a value to.
pub(crate) fn assigned(name: &str) -> Result<Assigned, Foreign> {
    match name {
        "CR" => Ok(Assigned::Radius),
        "ADIS" | "ADISPOS" | "CTOL" | "OTOL" | "ATOL" | "SPOS" | "SPOSA" | "LIMS" | "ACC" | "OVR" | "VELOLIM"
        | "FGREF" | "DISC" | "FL" | "FP" => Ok(Assigned::Passive),
        "CHF" | "CHR" | "RND" | "RNDM" => Err(Foreign::Corner),
        "AP" | "RP" | "RPL" => Err(Foreign::Frame),
        "AR" | "TURN" | "ANG" | "OFFN" => Err(Foreign::Motion),
        "LEAD" | "TILT" => Err(Foreign::Kinematics),
        _ => Err(Foreign::Parameter),
    }
}

/// Whether a letter is followed by a plain number only: those that ISO has as well.
pub(crate) fn is_letter(letter: char) -> bool {
    matches!(
        letter,
        'A' | 'B' | 'C' | 'D' | 'F' | 'G' | 'H' | 'I' | 'J' | 'K' | 'M' | 'N' | 'S' | 'T' | 'X' | 'Y' | 'Z'
    )
}

/// Whether no other control has `name`, which stands in upper case and with arguments behind it or not.
pub(crate) fn is_own(called: &str, has_arguments: bool) -> bool {
    let flow = ["IF", "ELSE", "ENDIF", "GOTO", "REPEAT", "WHILE", "ENDWHILE", "REAL", "INT", "RET", "CT"];
    let is_known = name(called, has_arguments).is_ok() || !matches!(refused(called), Foreign::Call);
    called.len() > 1 && is_known && !flow.contains(&called)
}

/// Whether no other mill has a G word of this number.
pub(crate) fn is_own_g(number: &str) -> bool {
    matches!(number.parse(), Ok(70 | 71 | 153 | 500 | 505..=599 | 641..=645 | 700 | 710))
}
