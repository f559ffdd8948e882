//! Functions that KRL programs call where a value stands.

use super::{
    code_range,
    spline::{check_in_block, is_of_inline_forms},
};
use crate::{
    model::robot::{RobotFault, RobotOptions},
    read::robot::{LineCursor, LocatedFault},
};

/// Words that stand before brackets and call nothing, and functions of KRL that change nothing.
const HARMLESS: &str = "AND OR EXOR NOT B_AND B_OR B_EXOR B_NOT FOR SEC TO STEP IF WHILE UNTIL SWITCH CASE RETURN THEN PULSE \
                        SIN COS TAN ASIN ACOS ATAN ATAN2 ABS SQRT INV_POS VARSTATE STRLEN STRDECLLEN STRCOMP FORWARD INVERSE EK EB LK";
/// Words of statements whose brackets hold no calls, or whose calls are looked at elsewhere.
const ELSEWHERE: &str = "DEF DEFFCT GLOBAL EXT EXTP EXTFCT EXTFCTP SIGNAL INTERRUPT TRIGGER BAS";

/// Refuses functions in a statement where values stand, as they may move the tool or change data.
pub(crate) fn check_functions(code: &[u8], options: &RobotOptions) -> Result<(), RobotFault> {
    let is_kept = |name: &String| is_word_of(HARMLESS, name) || is_of_inline_forms(name) || options.keeps_call(name);
    match called_in(code).iter().all(is_kept) {
        true => Ok(()),
        false => RobotFault::not_followed(
            "functions that may do more than compute are",
            "their names in calls_kept of [robot_program], if they do not",
        ),
    }
}

/// Refuses what the expansion of a program does not follow: functions, records of its own, and other statements within SPLINE than segments.
pub(crate) fn check_program(source: &[u8], options: &RobotOptions) -> Result<(), LocatedFault> {
    let (mut lines, mut in_block) = (LineCursor::new(source), false);
    while let Some(line) = lines.advance() {
        let code = code_range(source, line);
        let text = String::from_utf8_lossy(&source[code.clone()]).to_ascii_uppercase();
        let words: Vec<&str> = text.split_whitespace().take(2).collect();
        let checked = match words[..] {
            [first, ..] if first.starts_with('&') => Ok(()),
            ["STRUC", ..] | ["GLOBAL", "STRUC"] => {
                RobotFault::not_followed("records of the program (STRUC) are", "numbers, positions and frames")
            }
            [word, ..] => {
                let word =
                    &word[..word.bytes().take_while(|byte| byte.is_ascii_alphanumeric() || *byte == b'_').count()];
                let in_place = check_in_block(word, in_block);
                in_block = match word {
                    "SPLINE" => true,
                    "ENDSPLINE" => false,
                    _ => in_block,
                };
                in_place.and_then(|()| check_functions(&source[code.clone()], options))
            }
            [] => Ok(()),
        };
        checked.map_err(|fault| LocatedFault { line: lines.line, at: code, fault })?;
    }
    Ok(())
}

fn is_word_of(words: &str, name: &str) -> bool {
    words.split_whitespace().any(|word| word == name)
}

/// Returns the names (in capitals) before brackets in a statement, but for the procedure that it calls.
fn called_in(code: &[u8]) -> Vec<String> {
    let (mut found, mut name, mut in_text, mut is_over, mut count) = (Vec::new(), String::new(), false, false, 0);
    for byte in code.iter().copied() {
        in_text ^= byte == b'"';
        match byte {
            _ if in_text => name.clear(),
            b'(' if !name.is_empty() => {
                // The first word is a procedure that is called, which is looked at elsewhere.
                if count > 1 || is_word_of("IF WHILE UNTIL SWITCH RETURN", &name) {
                    found.push(std::mem::take(&mut name));
                }
                name.clear();
            }
            b' ' | b'\t' => is_over = true,
            _ if byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'$') || byte >= 0x80 => {
                if is_over || name.is_empty() {
                    name.clear();
                    count += 1;
                }
                is_over = false;
                name.push(byte.to_ascii_uppercase() as char);
                if count == 1
                    && is_word_of(ELSEWHERE, &name)
                    && code.get(name.len()).is_none_or(|next| !next.is_ascii_alphanumeric() && *next != b'_')
                {
                    return Vec::new();
                }
            }
            _ => {
                name.clear();
                is_over = false;
            }
        }
    }
    found
}
