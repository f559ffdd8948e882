//! Suggestions for misspelt names in errors.

/// Most names that an error lists.
const MAX_LISTED: usize = 10;

/// Returns the first ten of `all` names, joined with commas, and how many more there are.
pub fn listed(all: impl IntoIterator<Item = impl ToString>) -> String {
    listed_up_to(MAX_LISTED, all.into_iter().map(|name| name.to_string()))
}

/// Returns the first `most` of `all`, joined with commas, and how many more there are: "a, b and 3 more".
pub fn listed_up_to(most: usize, all: impl Iterator<Item = String>) -> String {
    let all: Vec<String> = all.collect();
    let more = match all.len().saturating_sub(most) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    format!("{}{more}", all[..all.len().min(most)].join(", "))
}

/// Most names that are suggested.
const MAX_SUGGESTED: usize = 4;

/// Returns up to four suggestions for `name`: names that continue it after a dot, or else those nearest by edit distance.
pub fn nearest<'a>(name: &str, names: &'a [String]) -> Vec<&'a str> {
    let below = names.iter().filter(|other| other.strip_prefix(name).is_some_and(|rest| rest.starts_with('.')));
    let below: Vec<&str> = below.take(MAX_SUGGESTED).map(String::as_str).collect();
    if !below.is_empty() {
        return below;
    }
    let most = 2 + name.chars().count() / 3;
    let mut near: Vec<(usize, &str)> = names.iter().map(|other| (edit_distance(name, other), other.as_str())).collect();
    near.retain(|(edit_distance, _)| *edit_distance <= most);
    near.sort_by_key(|(edit_distance, _)| *edit_distance);
    near.into_iter().take(MAX_SUGGESTED).map(|(_, other)| other).collect()
}

/// Returns the edit distance: the fewest letters to insert, delete or replace that turn `one` into `other`.
pub fn edit_distance(one: &str, other: &str) -> usize {
    let other: Vec<char> = other.chars().collect();
    let mut row: Vec<usize> = (0..=other.len()).collect();
    for (i, letter) in one.chars().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for (j, &other_letter) in other.iter().enumerate() {
            let replaced = diagonal + usize::from(other_letter != letter);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[other.len()]
}
