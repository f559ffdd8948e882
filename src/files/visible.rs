//! Names and messages from files, where they are shown: characters that a terminal or a browser would act upon are written
//! out instead.

use std::borrow::Cow;

/// Whether a character acts instead of being seen: control characters (escape sequences begin with one), line separators,
/// and those that turn the direction of reading.
fn acts(c: char) -> bool {
    let turns = matches!(c, '\u{061c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    turns || matches!(c, '\u{2028}' | '\u{2029}') || (c.is_control() && !matches!(c, '\n' | '\t'))
}

fn replaced(text: &str, shown: impl Fn(char) -> String) -> Cow<'_, str> {
    if !text.contains(acts) {
        return text.into();
    }
    text.chars().map(|c| if acts(c) { shown(c) } else { c.to_string() }).collect::<String>().into()
}

/// `text` with characters that act written as `\u{202e}`; line ends and tabs stay.
pub fn visible(text: &str) -> Cow<'_, str> {
    replaced(text, |c| c.escape_unicode().to_string())
}

/// The same for JSON that a program may read: such characters, which stand in strings only, as `\u202e`.
pub fn visible_json(json: &str) -> Cow<'_, str> {
    replaced(json, |c| format!("\\u{:04x}", u32::from(c)))
}

/// As [`visible_json`], for JSON whose strings are shown by a script: they hold the written form.
pub fn shown_json(json: &str) -> Cow<'_, str> {
    replaced(json, |c| format!("\\\\u{{{:x}}}", u32::from(c)))
}
