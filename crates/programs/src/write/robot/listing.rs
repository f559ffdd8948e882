//! Writes FANUC listings: the positions of `/POS`, which stand apart from the motions, and the numbers of lines.

use std::{collections::HashMap, ops::Range};

use crate::{
    read::{
        robot::{
            LineCursor, line_ending,
            ls::{code_start, positions, section},
        },
        scan::Scan,
    },
    write::robot::WrittenPose,
};

/// Positions of a listing as they are written, and the number of its lines.
#[derive(Debug)]
pub(crate) struct Listing {
    /// Bytes of each position between its braces, and how often the program names it.
    positions: HashMap<u32, (Range<usize>, usize)>,
    /// New texts of positions that change in their places.
    changed: Vec<(Range<usize>, Vec<u8>)>,
    /// Text of the positions that are added.
    added: Vec<u8>,
    /// Largest number of a position.
    last: u32,
    ending: &'static [u8],
    pub added_lines: usize,
}

/// Returns the number at the start of `name`, which is what stands behind the bracket of a position such as `P[12]`; `None` without one.
fn number_in(name: &[u8]) -> Option<u32> {
    Some(Scan::new(name).number().ok()?.0 as u32)
}

impl Listing {
    /// Finds the positions of `source` and counts where the program names them.
    pub fn new(source: &[u8]) -> Self {
        let mut positions: HashMap<_, _> = positions(source).map(|(number, at)| (number, (at, 0))).collect();
        let program = &source[..section(source, b"/POS").unwrap_or(source.len())];
        for (at, _) in program.windows(2).enumerate().filter(|(_, pair)| pair == b"P[") {
            let named = number_in(&program[at + 2..]).and_then(|number| positions.get_mut(&number));
            named.into_iter().for_each(|(_, count)| *count += 1);
        }
        let last = positions.keys().copied().max().unwrap_or(0);
        Self { positions, changed: Vec::new(), added: Vec::new(), last, ending: line_ending(source), added_lines: 0 }
    }

    /// Puts `pose` into the position called `name` if `is_own` and nothing else uses it, or into a new one; returns the name.
    pub fn place(&mut self, name: &[u8], pose: &WrittenPose, is_own: bool) -> Vec<u8> {
        let number = name.iter().position(|byte| *byte == b'[').and_then(|open| number_in(&name[open + 1..]));
        match number.and_then(|number| self.positions.get(&number)) {
            Some(_) if is_own && !pose.is_changed => return name.to_vec(),
            Some((at, 1)) if is_own => {
                self.changed.push((at.clone(), pose.text.clone()));
                return name.to_vec();
            }
            _ => {}
        }
        self.last = self.last.saturating_add(1);
        let name = format!("P[{}]", self.last).into_bytes();
        for part in [&name, &b"{"[..], &pose.text, b"};", self.ending] {
            self.added.extend_from_slice(part);
        }
        name
    }

    /// Returns what stands on the line before byte `at`: the line's number and a colon.
    pub fn prefix<'a>(&self, source: &'a [u8], at: usize) -> &'a [u8] {
        let start = source[..at].iter().rposition(|byte| matches!(byte, b'\r' | b'\n')).map_or(0, |end| end + 1);
        &source[start..at]
    }

    /// Appends the rest of `source` from byte `copied` on to `out`, with the positions as they are now, and numbers all lines anew if some
    /// were added.
    pub fn finish(mut self, source: &[u8], mut copied: usize, out: &mut Vec<u8>) {
        let end = section(source, b"/END").unwrap_or(source.len());
        self.changed.push((end..end, self.added));
        self.changed.sort_by_key(|(at, _)| at.start);
        for (at, text) in self.changed {
            out.extend_from_slice(&source[copied..at.start]);
            out.extend_from_slice(&text);
            copied = at.end;
        }
        out.extend_from_slice(&source[copied..]);
        if self.added_lines > 0 {
            *out = renumbered(out, self.added_lines);
        }
    }
}

/// Returns a listing with `added_lines` more in its LINE_COUNT, and the numbers of its lines counted on from the first.
fn renumbered(source: &[u8], added_lines: usize) -> Vec<u8> {
    let mut out = Vec::with_capacity(source.len() + added_lines);
    let (mut lines, mut copied, mut last, mut is_in_program) = (LineCursor::new(source), 0, None, false);
    while let Some(line) = lines.advance() {
        let text = &source[line.clone()];
        if text.starts_with(b"/") {
            is_in_program = text.starts_with(b"/MN");
        }
        let (behind, count) = match text.strip_prefix(b"LINE_COUNT") {
            Some(rest) => (rest.iter().position(u8::is_ascii_digit).map(|at| line.end - rest.len() + at), added_lines),
            None if is_in_program && code_start(source, line.clone()).is_some_and(|(_, has_number)| has_number) => {
                (Some(line.start), 0)
            }
            None => (None, 0),
        };
        let Some(start) = behind else { continue };
        let digits = text[start - line.start..].iter().position(|b| !b.is_ascii_digit() && !b.is_ascii_whitespace());
        let field = start..digits.map_or(line.end, |length| start + length);
        let number: Option<usize> = String::from_utf8_lossy(&source[field.clone()]).trim().parse().ok();
        let number = match (last, number) {
            (_, Some(number)) if count > 0 => number + count,
            (Some(last), _) => last + 1,
            (None, Some(first)) => first,
            _ => continue,
        };
        if is_in_program {
            last = Some(number);
        }
        out.extend_from_slice(&source[copied..field.start]);
        out.extend_from_slice(format!("{number:>width$}", width = field.len()).as_bytes());
        copied = field.end;
    }
    out.extend_from_slice(&source[copied..]);
    out
}
