//! Calls in RAPID: functions, which stand where values do, and compute or ask without moving the tool; and procedures that nothing calls.

use std::collections::{BTreeMap, BTreeSet};

use super::{
    is_motion,
    lex::{CodeUnits, code_bytes, one_line_statement},
};
use crate::read::{robot::LocatedFault, scan::Scan};

/// Functions of the language and its options, and words before brackets that are none.
const KNOWN: &str = "\
    AND OR XOR NOT DIV MOD IF ELSEIF WHILE TO FROM STEP RETURN CASE THEN DO \
    ABS ABSDNUM ACOS ACOSDNUM AINPUT AOUTPUT ARGNAME ASIN ASINDNUM ATAN ATAN2 ATAN2DNUM ATANDNUM BITAND BITANDDNUM BITCHECK BITCHECKDNUM \
    BITLSH BITLSHDNUM BITNEG BITNEGDNUM BITOR BITORDNUM BITRSH BITRSHDNUM BITXOR BITXORDNUM BYTETOSTR CALCJOINTT CALCROBT CALCROTAXFRAMEZ \
    CALCROTAXISFRAME CAMGETEXPOSURE CAMGETLOADEDJOB CAMGETNAME CAMGETPARAMETER CAMNUMBEROFRESULTS CDATE CJOINTT CLKREAD CORRREAD COS COSDNUM \
    CPOS CROBT CROSSPROD CSPEEDOVERRIDE CTASKNAME CTIME CTOOL CWOBJ DECTOHEX DEFACCFRAME DEFDFRAME DEFFRAME DIM DINPUT DISTANCE DNUMTONUM \
    DNUMTOSTR DOTPROD DOUTPUT EGMGETSTATE EULERZYX EVENTTYPE EXECHANDLER EXECLEVEL EXP FILESIZE FILETIME FILETIMEDNUM FSSIZE FSSIZEDNUM \
    GETAXISDISTANCE GETAXISMOVETIME GETJOINTDATA GETMAXNUMBEROFCYCLICBOOL GETMECUNITNAME GETMODALPAYLOADMODE GETMOTORTORQUE GETNEXTCYCLICBOOL \
    GETNEXTMECHUNIT GETNEXTSYM GETNUMBEROFCYCLICBOOL GETSERVICEINFO GETSIGNALORIGIN GETSYSINFO GETTASKNAME GETTIME GETTSPSTATUS \
    GETUASSIGNALORIGIN GETUASUSERNAME GINPUT GINPUTDNUM GOUTPUT GOUTPUTDNUM HEXTODEC INDINPOS INDSPEED IOUNITSTATE ISBRAKECHECKACTIVE \
    ISCOLLFREE ISCYCLICBOOL ISFILE ISLEADTHROUGH ISMECHUNITACTIVE ISPERS ISSTOPMOVEACT ISSTOPSTATEEVENT ISSYNCMOVEON ISSYSID ISVAR MAX \
    MAXEXTLINEARSPEED MAXEXTREORIENTSPEED MAXROBREORIENTSPEED MAXROBSPEED MIN MIRPOS MODEXIST MODTIME MODTIMEDNUM MOTIONPLANNERNO \
    NONMOTIONMODE NORIENT NORMALIZE NUMTODNUM NUMTOSTR OFFS OPMODE ORIENTZYX ORIGINALTYPE OROBT PARIDPOSVALID PARIDROBVALID PATHLENGTHGET \
    PATHLEVEL PATHRECVALIDBWD PATHRECVALIDFWD PFRESTART POSEINV POSEMULT POSEVECT POW POWDNUM PPMOVEDINMANMODE PRESENT PROCERRRECOVERY \
    PROGMEMFREE QUAD QUADDNUM RANDOM RAWBYTESLEN READBIN READDIR READMOTOR READNUM READSTR READSTRBIN READVAR RELTOOL REMAININGRETRIES \
    RMQGETSLOTNAME ROBNAME ROBOS ROUND ROUNDDNUM RUNMODE SAFETYCONTROLLERGETCHECKSUM SAFETYCONTROLLERGETOPMODEPINCODE \
    SAFETYCONTROLLERGETSWVERSION SIN SINDNUM SOCKETGETSTATUS SOCKETPEEK SQRT SQRTDNUM STCALCFORCE STCALCTORQUE STISCALIB STISCLOSED STISINDGUN \
    STISOPEN STISSERVOTOOL STRDIGCALC STRDIGCMP STRFIND STRFORMAT STRLEN STRMAP STRMATCH STRMEMB STRORDER STRPART STRTOBYTE STRTOVAL TAN \
    TANDNUM TASKINSYNC TASKISACTIVE TASKISEXECUTING TASKRUNMEC TASKRUNROB TESTANDSET TESTDI TESTSIGNREAD TEXTGET TEXTTABFREETOUSE TEXTTABGET \
    TOOLMASS TOOLTCPGET TRIGGDATAVALID TRUNC TRUNCDNUM TYPE UIALPHAENTRY UICLIENTEXIST UIDNUMENTRY UIDNUMTUNE UILISTVIEW UIMESSAGEBOX \
    UINUMENTRY UINUMTUNE VALIDIO VALTOSTR VECTMAGN";

/// Whether the function `name`, in capitals, is one of the language.
pub(super) fn is_known(name: &str) -> bool {
    KNOWN.split_whitespace().any(|known| known == name)
}

/// Returns the name in capitals that a head such as `LOCAL FUNC num depth(num n)` declares; `None` without one.
pub(super) fn name_in(head: &[u8]) -> Option<String> {
    let before = head.split(|byte| *byte == b'(').next()?;
    let name = before.split(u8::is_ascii_whitespace).rfind(|word| !word.is_empty())?;
    let (name, _) = Scan::new(name).name();
    (!name.is_empty()).then(|| name.to_ascii_uppercase())
}

/// Returns the procedures with their names in capitals that `main` does not lead to; none without a `main` that moves the tool or leads to what does, or where names
/// of procedures are computed.
pub(crate) fn uncalled(source: &[u8]) -> Result<BTreeSet<String>, LocatedFault> {
    // By routine, what it names; traps run when something happens.
    let (mut named, mut reached) = (BTreeMap::<String, BTreeSet<String>>::new(), vec!["MAIN".to_owned()]);
    let (mut units, mut routine, mut moving) = (CodeUnits::new(source), String::new(), BTreeSet::new());
    while let Some(unit) = units.next()? {
        let text = &source[unit.at.clone()];
        let mut scan = Scan::new(text);
        let mut word = scan.name().0.to_ascii_uppercase();
        if word == "LOCAL" {
            word = scan.name().0.to_ascii_uppercase();
        }
        match word.as_str() {
            "PROC" | "FUNC" | "TRAP" if !unit.is_statement => {
                routine = match word.as_str() {
                    "FUNC" => name_in(text).unwrap_or_default(),
                    _ => scan.name().0.to_ascii_uppercase(),
                };
                named.entry(routine.clone()).or_default();
                reached.extend((word == "TRAP").then(|| routine.clone()));
            }
            _ if text.starts_with(b"%") && !routine.is_empty() => return Ok(BTreeSet::new()),
            _ => {
                let names = names(text);
                if names.iter().any(|name| name == "CALLBYVAR") {
                    return Ok(BTreeSet::new());
                }
                let moves = |start: usize| is_motion(&Scan::new(&text[start..]).name().0.to_ascii_uppercase());
                if is_motion(&word) || word == "IF" && one_line_statement(text).is_none_or(moves) {
                    moving.insert(routine.clone());
                }
                named.entry(routine.clone()).or_default().extend(names);
            }
        }
    }
    // What stands outside of routines.
    reached.extend(named.remove("").into_iter().flatten());
    if !named.contains_key("MAIN") {
        return Ok(BTreeSet::new());
    }
    let mut moves = false;
    while let Some(next) = reached.pop() {
        moves |= moving.contains(&next);
        reached.extend(named.remove(&next).into_iter().flatten());
    }
    Ok(if moves { named.into_keys().collect() } else { BTreeSet::new() })
}

/// Returns the names in `text`, in capitals.
pub(crate) fn names(text: &[u8]) -> Vec<String> {
    let code: Vec<u8> = code_bytes(text).map(|(_, byte)| byte.to_ascii_uppercase()).collect();
    code.split(|byte| !(byte.is_ascii_alphanumeric() || *byte == b'_'))
        .filter(|word| !word.is_empty())
        .map(|word| String::from_utf8_lossy(word).into_owned())
        .collect()
}

/// Returns the names in capitals of routines that have parameters by reference (VAR, INOUT, PERS, REF).
pub(super) fn by_reference(source: &[u8]) -> Result<BTreeSet<String>, LocatedFault> {
    let (mut units, mut found) = (CodeUnits::new(source), BTreeSet::new());
    while let Some(unit) = units.next()? {
        let text = &source[unit.at.clone()];
        let mut heads = names(text).into_iter().skip_while(|word| word == "LOCAL");
        let kind = heads.next().unwrap_or_default();
        if unit.is_statement || !matches!(kind.as_str(), "PROC" | "FUNC") {
            continue;
        }
        if heads.any(|word| matches!(word.as_str(), "VAR" | "INOUT" | "PERS" | "REF")) {
            found.extend(name_in(text));
        }
    }
    Ok(found)
}

/// Whether code stands behind a head of a routine, `PROC main()`, or behind `TEST value` on its line.
pub(crate) fn has_code_behind(text: &[u8], word: &str) -> bool {
    let code: Vec<u8> = code_bytes(text).map(|(_, byte)| byte).collect();
    match word {
        "TEST" => code.contains(&b':'),
        "TRAP" => names(&code).len() > 2,
        _ => {
            code.iter().rposition(|byte| *byte == b')').is_some_and(|at| !code[at + 1..].trim_ascii().is_empty())
                || code.contains(&b';')
        }
    }
}
