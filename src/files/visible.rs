//! Texts from files made safe to show: characters that a terminal or a browser would act upon are written out.

use std::borrow::Cow;

/// Returns whether a character acts instead of being shown: control characters (escape sequences begin with one), line separators, and
/// those that change the direction of reading.
fn is_active(c: char) -> bool {
    let turns = matches!(c, '\u{061c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    turns || matches!(c, '\u{2028}' | '\u{2029}') || (c.is_control() && !matches!(c, '\n' | '\t'))
}

/// Returns `text` with each active character replaced by what `shown` returns for it.
fn replace_active(text: &str, shown: impl Fn(char) -> String) -> Cow<'_, str> {
    if !text.contains(is_active) {
        return text.into();
    }
    text.chars().map(|c| if is_active(c) { shown(c) } else { c.to_string() }).collect::<String>().into()
}

/// Returns `text` with active characters written as `\u{202e}`; line ends and tabs stay.
pub fn visible(text: &str) -> Cow<'_, str> {
    replace_active(text, |c| c.escape_unicode().to_string())
}

/// Returns JSON for programs, with active characters, which occur only in strings, escaped as `\u202e`.
pub fn visible_json(json: &str) -> Cow<'_, str> {
    replace_active(json, |c| format!("\\u{:04x}", u32::from(c)))
}

/// Returns JSON whose strings a script shows, with active characters written out in them.
pub fn display_json(json: &str) -> Cow<'_, str> {
    replace_active(json, |c| format!("\\\\u{{{:x}}}", u32::from(c)))
}
