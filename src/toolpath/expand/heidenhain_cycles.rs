//! Heidenhain's drilling (CYCL DEF 200) and reaming (201) as moves where CYCL CALL or M99 calls them.

use std::collections::BTreeMap;

use crate::toolpath::{
    model::{NumberFormat, format_plain},
    read::{
        gcode::{
            dialect::block_numbers,
            lines::{self, Lines},
        },
        scan::Scan,
    },
};

/// Most pecks of a hole.
const MOST_PECKS: f64 = 10_000.0;

/// Parameters of the last CYCL DEF.
struct Cycle {
    /// Values of its Q parameters.
    q: BTreeMap<u32, f64>,
    is_reaming: bool,
}

/// Returns `source` with its cycles as moves, and the index of the line each line comes from; `None` without cycles or if one cannot be.
pub(crate) fn expand_cycles(source: &[u8]) -> Option<(Vec<u8>, Vec<usize>)> {
    let lines = Lines::split(source);
    let (mut out, mut origins) = (Vec::with_capacity(source.len()), Vec::new());
    let (mut cycle, mut feed, mut is_changed) = (None, None, false);
    let mut line = 0;
    while line < lines.len() {
        let content = &source[lines.content(line)];
        let ending = lines.ending_or_newline(source, line);
        let start =
            block_numbers::leading_number(content).map_or_else(|| lines::prefix_len(content), |(range, _)| range.end);
        let prefix = &content[..start];
        let code = Scan::of_line(content, start);
        let text = code.upper_text(start..code.line.len()).trim().to_owned();
        let mut write_line = |text: &[u8]| {
            out.extend_from_slice(text);
            out.extend_from_slice(ending);
            origins.push(line);
        };
        let block = |text: &str| [prefix, if prefix.is_empty() { b"" } else { b" " }, text.as_bytes()].concat();
        let words: Vec<&str> = text.split_whitespace().collect();
        let (mut last, mut calls) = (line, false);
        match words[..] {
            ["CYCL", "DEF", number, ..] if matches!(number, "200" | "201") => {
                last = definition_end(source, &lines, line);
                cycle = Some(Cycle::read(source, &lines, line..last + 1, number == "201")?);
                write_line(&block(&format!("; CYCL DEF {number}, written out where it is called")));
                is_changed = true;
            }
            ["CYCL", "CALL", ref rest @ ..] => {
                let is_m = |word: &&str| word.strip_prefix('M').is_some_and(|number| number.parse::<u32>().is_ok());
                if !rest.iter().all(is_m) {
                    return None;
                }
                if !rest.is_empty() {
                    write_line(&block(&rest.join(" ")));
                }
                calls = true;
            }
            _ => {
                if words.contains(&"M89") || (words[..].starts_with(&["TOOL", "CALL"]) && has_other_tool_axis(&words)) {
                    return None;
                }
                calls = words.contains(&"M99");
                let moved = if calls { without_m99(content, start, code.line.len())? } else { content.to_vec() };
                write_line(&moved);
                feed = feed_word(&words).or(feed);
            }
        }
        if calls {
            for text in cycle.as_ref()?.moves(feed.as_deref())? {
                write_line(&block(&text));
            }
            is_changed = true;
        }
        line = last + 1;
    }
    // The number of lines may be as it was, and that of a block then stand twice.
    is_changed.then(|| (block_numbers::renumber_blocks(b"", out), origins))
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

/// Returns the feed that a block of these `words` leaves in force, as a word; `None` if it sets none.
fn feed_word(words: &[&str]) -> Option<String> {
    let is_feed =
        |word: &&&str| word.strip_prefix('F').is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()));
    let word = words.iter().find(is_feed);
    match words.first() {
        Some(&"TOOL") => word.map(|_| "F AUTO".into()),
        _ => word.map(|word| (*word).to_owned()),
    }
}

impl Cycle {
    /// Reads the Q parameters of a CYCL DEF in the lines `range`; `None` if some are missing, unknown or no numbers.
    fn read(source: &[u8], lines: &Lines, range: std::ops::Range<usize>, is_reaming: bool) -> Option<Cycle> {
        let mut q = BTreeMap::new();
        for line in range {
            let scan = Scan::of_line(&source[lines.content(line)], 0);
            let code = scan.upper_text(0..scan.line.len());
            for (at, _) in code.match_indices('Q') {
                let Some((number, value)) = code[at + 1..].split_once('=') else { continue };
                let Ok(number) = number.trim().parse::<u32>() else { continue };
                let mut value = Scan::of_line(value.trim_start().as_bytes(), 0);
                q.insert(number, value.take_decimal().ok()??.0);
                if value.next().is_some_and(|byte| !matches!(byte, b'Q' | b'~')) {
                    return None;
                }
            }
        }
        let known: &[u32] = match is_reaming {
            true => &[200, 201, 203, 204, 206, 208, 211],
            false => &[200, 201, 202, 203, 204, 206, 210, 211, 395],
        };
        let needed: &[u32] = if is_reaming { &[200, 201, 203, 206] } else { &[200, 201, 202, 203, 206] };
        let is_known =
            q.keys().all(|number| known.contains(number)) && needed.iter().all(|number| q.contains_key(number));
        (is_known && q.get(&395).is_none_or(|depth| *depth == 0.0)).then_some(Cycle { q, is_reaming })
    }

    /// Returns blocks that drill one hole at the tool position and put `feed` back in force; `None` if a parameter is out of range.
    fn moves(&self, feed: Option<&str>) -> Option<Vec<String>> {
        let q = |number: u32| self.q.get(&number).copied().unwrap_or(0.0);
        let (set_up, depth, surface, plunge) = (q(200), -q(201), q(203), q(206));
        let (clear, bottom) = (surface + set_up, surface - depth);
        if depth <= 0.0 || set_up <= 0.0 || plunge <= 0.0 {
            return None;
        }
        let peck = if self.is_reaming { depth } else { q(202) };
        if peck <= 0.0 || depth / peck > MOST_PECKS {
            return None;
        }
        let rapid = |z: f64| format!("L Z{} R0 FMAX", signed(z));
        let fed = |z: f64, feed: f64| format!("L Z{} R0 F{}", signed(z), format_plain(feed));
        let dwell = |seconds: f64| {
            let blocks =
                ["CYCL DEF 9.0 DWELL TIME".to_owned(), format!("CYCL DEF 9.1 DWELL {}", format_plain(seconds))];
            blocks.into_iter().filter(move |_| seconds > 0.0)
        };
        let mut moves = vec![rapid(clear)];
        let pecks = (1..).map(|pecks| surface - f64::from(pecks) * peck);
        for depth_z in pecks.take_while(|depth_z| depth_z - bottom > NumberFormat::FINEST) {
            moves.extend([fed(depth_z, plunge), rapid(clear)]);
            moves.extend(dwell(q(210)));
            moves.push(rapid(depth_z + set_up));
        }
        moves.push(fed(bottom, plunge));
        moves.extend(dwell(q(211)));
        let second = surface + q(204);
        if self.is_reaming {
            moves.push(fed(clear, if q(208) > 0.0 { q(208) } else { plunge }));
            moves.extend((second > clear).then(|| rapid(second)));
        } else {
            moves.push(rapid(clear.max(second)));
        }
        moves.extend(feed.map(|feed| format!("L {feed}")));
        Some(moves)
    }
}

/// Formats a number with its sign, plus included.
fn signed(value: f64) -> String {
    let text = format_plain(value);
    if text.starts_with('-') { text } else { format!("+{text}") }
}
