//! Heidenhain's drilling cycles with Q parameters as moves where CYCL CALL or M99 calls them.

use crate::{
    expand::{
        check_length,
        cycles::WithoutCycles,
        heidenhain::MOTIONS,
        heidenhain_holes::{Cycle, Expected, is_known},
    },
    model::gcode::{BlockDelete, Foreign, Refusal},
    read::{
        gcode::{
            dialect::block_numbers,
            lines::{self, Lines},
        },
        scan::Scan,
    },
};

/// The cycle that a call runs, and the line of its CYCL DEF.
type Defined = Option<(usize, Cycle)>;

/// Returns `source` with its cycles as moves, and the index of the line each line comes from; `None` without cycles. `Err` gives the index of
/// the line with a cycle that cannot be.
pub(crate) fn expand_cycles(source: &[u8], skips: BlockDelete) -> Result<Option<WithoutCycles>, (usize, Refusal)> {
    let lines = Lines::split(source);
    let (mut out, mut origins) = (Vec::with_capacity(source.len()), Vec::new());
    let (mut cycle, mut feed, mut is_changed, mut is_across): (Defined, _, _, _) = (None, None, false, false);
    let refuse = |line: usize, expected: Expected| {
        let (_, code) = code_of(&source[lines.content(line)]);
        (line, code.refuse_all(code.at, Foreign::CycleValue { expected }))
    };
    let mut line = 0;
    while line < lines.len() {
        let content = &source[lines.content(line)];
        check_length(out.len(), String::new).map_err(|fault| (line, Refusal::new(0..content.len(), fault)))?;
        let ending = lines.ending_or_newline(source, line);
        let (prefix, code) = code_of(content);
        let text = code.upper_text(code.at..code.line.len()).trim().to_owned();
        let mut write_line = |text: &[u8]| {
            out.extend_from_slice(text);
            out.extend_from_slice(ending);
            origins.push(line);
        };
        let block = |text: &str| [prefix, if prefix.is_empty() { b"" } else { b" " }, text.as_bytes()].concat();
        let words: Vec<&str> = text.split_whitespace().collect();
        let (mut last, mut calls) = (line, false);
        match words[..] {
            _ if skips == BlockDelete::Skip && lines::is_deletable(content) => write_line(content),
            // Headings are for people.
            ["*", ..] => write_line(content),
            _ if cycle.is_some() && is_call(&words) && words.iter().any(acts_at_end) => {
                return Err(refuse(
                    line,
                    "M0, M1, M2, M5, M9 and M30 in a block of their own, behind that of the call",
                ));
            }
            ["CYCL", "DEF", number, ..] if is_known(number) => {
                last = definition_end(source, &lines, line);
                let definition = (line..=last).map(|line| &source[lines.content(line)]);
                cycle = Some((line, Cycle::read(number, definition).map_err(|expected| refuse(line, expected))?));
                write_line(&block(&format!("; CYCL DEF {number}, written out where it is called")));
                is_changed = true;
            }
            ["CYCL", "DEF", "206" | "207" | "209", ..] => return Err(refuse(line, TAPPING)),
            ["CYCL", "CALL", ref rest @ ..] if cycle.is_some() && rest.iter().all(is_m_word) => {
                if !rest.is_empty() {
                    write_line(&block(&rest.join(" ")));
                }
                calls = true;
            }
            _ => {
                if matches!(words[..], ["CYCL", "DEF", number, ..] if number.starts_with('2') && number != "247") {
                    // It is not followed, and refused when it is read.
                    cycle = None;
                }
                if words[..].starts_with(&["TOOL", "CALL"]) {
                    is_across = has_other_tool_axis(&words) || (is_across && !words.contains(&"Z"));
                }
                calls = cycle.is_some() && is_call(&words);
                let moved = if calls { without_m99(content, code.at, code.line.len()) } else { None };
                write_line(moved.as_deref().unwrap_or(content));
                feed = feed_behind(&words, feed);
            }
        }
        if let Some((definition, cycle)) = cycle.as_ref().filter(|_| calls) {
            if is_across {
                return Err(refuse(line, "a tool along Z"));
            }
            let blocks = cycle.moves(feed.as_deref()).map_err(|expected| refuse(*definition, expected))?;
            blocks.iter().for_each(|text| write_line(&block(text)));
            is_changed = true;
        }
        line = last + 1;
    }
    // The number of lines may be as it was, and that of a block then stand twice.
    Ok(is_changed.then(|| (block_numbers::renumber_blocks(b"", out), origins)))
}

/// Why tapping is not followed.
const TAPPING: Expected =
    "tapping in a program of its own: the spindle turns with the tap, which moves that are written out do not say";

/// Returns what stands before the code of a block, its number included, and a cursor at its code.
fn code_of(content: &[u8]) -> (&[u8], Scan<'_>) {
    let number = block_numbers::leading_number(content);
    let start = number.map_or_else(|| lines::prefix_len(content), |(range, _)| range.end);
    let mut code = Scan::of_line(content, start);
    code.next();
    (&content[..start], code)
}

/// Whether a block of these `words` calls a cycle.
fn is_call(words: &[&str]) -> bool {
    words.contains(&"M99") || words.starts_with(&["CYCL", "CALL"])
}

/// Whether `word` is an M function that acts behind the motion of its block.
fn acts_at_end(word: &&str) -> bool {
    let number = word.strip_prefix('M').and_then(|number| number.parse::<u32>().ok());
    number.is_some_and(|number| matches!(number, 0 | 1 | 2 | 5 | 9 | 30))
}

/// Whether `word` is an M function with its number.
fn is_m_word(word: &&str) -> bool {
    word.strip_prefix('M').is_some_and(|number| number.parse::<u32>().is_ok())
}

/// Index of the last line of the CYCL DEF that begins in `line`: `~` continues it, and so does a line that begins with Q.
fn definition_end(source: &[u8], lines: &Lines, line: usize) -> usize {
    let is_open = |line: usize| source[lines.content(line)].trim_ascii_end().ends_with(b"~");
    let is_value = |line: usize| source[lines.content(line)].trim_ascii_start().first() == Some(&b'Q');
    (line..lines.len()).take_while(|next| *next == line || is_open(next - 1) || is_value(*next)).last().unwrap_or(line)
}

/// Returns the line `content` without its word M99, which stands between the bytes `start` and `end`; `None` if it is not found.
fn without_m99(content: &[u8], start: usize, end: usize) -> Option<Vec<u8>> {
    let at = (start..end.checked_sub(2)?).find(|at| {
        content[*at..*at + 3].eq_ignore_ascii_case(b"M99")
            && content[..*at].last().is_some_and(|byte| lines::is_blank(*byte))
            && content.get(*at + 3).is_none_or(|byte| !byte.is_ascii_alphanumeric())
    })?;
    let before = content[..at].trim_ascii_end();
    Some([before, &content[at + 3..]].concat())
}

/// Whether a TOOL CALL of these `words` names another tool axis than Z.
fn has_other_tool_axis(words: &[&str]) -> bool {
    words.iter().any(|word| matches!(*word, "X" | "Y" | "U" | "V" | "W"))
}

/// Returns the feed that a block of these `words` leaves in force, as a word, where it was `before`; `None`: no feed yet. F of other blocks than
/// motions belongs to them alone.
fn feed_behind(words: &[&str], before: Option<String>) -> Option<String> {
    let is_motion = words.first().is_some_and(|word| MOTIONS.contains(word));
    let is_number = |text: &str| text.starts_with(|first: char| first.is_ascii_digit() || first == '+');
    let given = words.iter().enumerate().filter(|(_, word)| word.starts_with('F')).find_map(|(at, word)| {
        let apart = words.get(at + 1).copied().unwrap_or_default();
        match &word[1..] {
            "" if is_number(apart) => Some(format!("F{apart}")),
            "" if apart == "AUTO" => Some("F AUTO".into()),
            "AUTO" => Some("F AUTO".into()),
            number => is_number(number).then(|| (*word).into()),
        }
    });
    match words.first() {
        Some(&"TOOL") => given.map(|_| "F AUTO".into()).or(before),
        // F behind M128 is that of its turns.
        _ if is_motion && !words.contains(&"M128") => given.or(before),
        _ => before,
    }
}
