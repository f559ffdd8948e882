//! Block numbers of Heidenhain's programs, which must rise.

use std::ops::Range;

use crate::read::gcode::lines::{self, Lines};

/// Returns `written` with rising block numbers: the lines that a block was split into begin with its number, and are counted on with all
/// that follow. A program of as many lines as `source` stays as it is.
pub(crate) fn renumber_blocks(source: &[u8], written: Vec<u8>) -> Vec<u8> {
    let lines = Lines::split(&written);
    if lines.len() == Lines::split(source).len() {
        return written;
    }
    let mut out = Vec::with_capacity(written.len() + lines.len());
    let (mut last, mut added) = (None, 0);
    for line in 0..lines.len() {
        let content = &written[lines.content(line)];
        match leading_number(content) {
            Some((range, number)) => {
                added += last.map_or(0, |last: u64| (last + 1).saturating_sub(number + added));
                last = Some(number + added);
                out.extend_from_slice(&content[..range.start]);
                out.extend_from_slice((number + added).to_string().as_bytes());
                out.extend_from_slice(&content[range.end..]);
            }
            None => out.extend_from_slice(content),
        }
        out.extend_from_slice(&written[lines.ending(line)]);
    }
    out
}

/// Returns the range and value of the number that a block begins with; `None` if it has none.
pub(crate) fn leading_number(content: &[u8]) -> Option<(Range<usize>, u64)> {
    let blanks = |from: usize| from + content[from..].iter().take_while(|byte| lines::is_blank(**byte)).count();
    let start = lines::blank_len(content);
    let start = if content.get(start) == Some(&b'/') { blanks(start + 1) } else { start };
    let length = content[start..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    let ends = content.get(start + length).is_none_or(|byte| lines::is_blank(*byte) || *byte == b'/');
    let digits = str::from_utf8(&content[start..start + length]).ok()?;
    let number = digits.parse().ok().filter(|number| *number < u64::from(u32::MAX))?;
    ends.then_some((start..start + length, number))
}
