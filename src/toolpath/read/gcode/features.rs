//! Where a feature of a program begins: at a line with its text.

/// Index of the longest of `texts` that `line` has, upper or lower case, not within a longer word or number.
pub(crate) fn begun(texts: &[String], line: &[u8]) -> Option<u16> {
    let found = (0..).zip(texts).filter(|(_, text)| has(line, text.as_bytes()));
    found.max_by_key(|(_, text)| text.len()).map(|(index, _)| index)
}

fn has(line: &[u8], text: &[u8]) -> bool {
    if text.is_empty() || text.len() > line.len() {
        return false;
    }
    let continues = |inner: u8, outer: Option<&u8>| {
        inner.is_ascii_alphanumeric() && outer.is_some_and(|outer| outer.is_ascii_alphanumeric())
    };
    (0..=line.len() - text.len()).any(|start| {
        let end = start + text.len();
        let before = start.checked_sub(1).and_then(|at| line.get(at));
        line[start..end].eq_ignore_ascii_case(text)
            && !continues(text[0], before)
            && !continues(text[text.len() - 1], line.get(end))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_text_counts_and_no_part_of_a_word_does() {
        let texts = ["pocket 1", "Pocket 1 finish", "N20"].map(String::from);
        let of = |line: &str| begun(&texts, line.as_bytes());
        assert_eq!(of("(POCKET 1)"), Some(0));
        assert_eq!(of("; pocket 1 FINISH, 3 mm"), Some(1));
        assert_eq!(of("(POCKET 12)"), None);
        assert_eq!(of("N200 G0 X1"), None);
        assert_eq!(of("N20G0X1"), None);
        assert_eq!(of("N20 G0 X1"), Some(2));
        assert_eq!(begun(&[String::new()], b"G0"), None);
    }
}
