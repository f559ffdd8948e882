//! Names that are nearly what was written, for errors.

/// So many names are told at most.
const TOLD: usize = 4;

/// Those of `names` that begin with `name` up to a dot, or else those with which it is easily confused, the nearest first.
pub fn nearest<'a>(name: &str, names: &'a [String]) -> Vec<&'a str> {
    let below = names.iter().filter(|other| other.strip_prefix(name).is_some_and(|rest| rest.starts_with('.')));
    let below: Vec<&str> = below.take(TOLD).map(String::as_str).collect();
    if !below.is_empty() {
        return below;
    }
    let most = 2 + name.chars().count() / 3;
    let mut near: Vec<(usize, &str)> = names.iter().map(|other| (edits(name, other), other.as_str())).collect();
    near.retain(|(edits, _)| *edits <= most);
    near.sort_by_key(|(edits, _)| *edits);
    near.into_iter().take(TOLD).map(|(_, other)| other).collect()
}

/// Fewest letters put in, taken out or replaced that make one name of the other.
pub fn edits(one: &str, other: &str) -> usize {
    let other: Vec<char> = other.chars().collect();
    let mut row: Vec<usize> = (0..=other.len()).collect();
    for (i, letter) in one.chars().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for (j, &own) in other.iter().enumerate() {
            let replaced = diagonal + usize::from(own != letter);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[other.len()]
}
