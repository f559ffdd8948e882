//! Counts, numbers and lists as sentences show them.

/// Returns the text with true minus signs instead of all hyphens.
pub(crate) fn typographic(text: &str) -> String {
    text.replace('-', "\u{2212}")
}

/// Returns the text with true minus signs instead of hyphens before numbers; hyphens within names stay.
pub fn with_minus_signs(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    let mut characters = text.chars().peekable();
    let mut before = ' ';
    while let Some(c) = characters.next() {
        let is_sign = c == '-' && !before.is_alphanumeric() && characters.peek().is_some_and(char::is_ascii_digit);
        shown.push(if is_sign { '\u{2212}' } else { c });
        before = c;
    }
    shown
}

/// Returns a number followed by its unit: "1.5 mm", "90°", "11".
pub(crate) fn with_unit(number: &str, unit: &str) -> String {
    match unit {
        "" | "°" => format!("{number}{unit}"),
        unit => format!("{number} {unit}"),
    }
}

/// Returns a count with its noun: "1 point", "2 points".
pub fn counted(count: usize, noun: &str) -> String {
    if count == 1 { format!("1 {noun}") } else { format!("{count} {noun}s") }
}

/// Returns a position as text, to a tenth of a millimetre, hundredths where they are exact: "(1.0, 2.35, 3.0) mm".
pub fn position(x_mm: f64, y_mm: f64, z_mm: f64) -> String {
    let [x, y, z] = [x_mm, y_mm, z_mm].map(|v| {
        let is_exact = |scale: f64| (scale * v - (scale * v).round()).abs() < 1e-6;
        let decimals = if is_exact(100.0) && !is_exact(10.0) { 2 } else { 1 };
        match format!("{v:.decimals$}") {
            text if text == "-0.0" => "0.0".into(),
            text => text,
        }
    });
    typographic(&format!("({x}, {y}, {z}) mm"))
}

/// Formats a length, not negative, in mm with `decimals` decimals, or in µm with two digits if it is below 10^(1 − `decimals`) mm. Only 0 shows
/// as "0 mm".
pub fn millimetres(length_mm: f64, decimals: i32) -> String {
    match length_mm {
        0.0 => "0 mm".into(),
        length if length < NANOMETRE => "less than 0.001 µm".into(),
        length if length < 10f64.powi(1 - decimals) => {
            let decimals = (1.0 - libm::log10(1e3 * length).floor()).max(0.0) as usize;
            format!("{:.decimals$} µm", 1e3 * length)
        }
        length => format!("{length:.*} mm", decimals as usize),
    }
}

/// Formats a length like [`millimetres`], shorter for tables.
pub fn millimetres_in_table(length_mm: f64, decimals: i32) -> String {
    millimetres(length_mm, decimals).replace("less than", "<")
}

/// One nanometre in mm.
const NANOMETRE: f64 = 1e-6;

/// Returns a rate with two digits: "0.1 per second", "11,000 per second".
pub fn per_second(rate: f64) -> String {
    if rate < 10.0 {
        return format!("{rate:.1} per second");
    }
    let step = libm::pow(10.0, libm::log10(rate).floor() - 1.0);
    let digits = (((rate / step).round() * step) as u64).to_string();
    let groups: Vec<_> = digits.as_bytes().rchunks(3).rev().map(String::from_utf8_lossy).collect();
    format!("{} per second", groups.join(","))
}

/// Returns a share in percent: "0 %" and "100 %" mean exactly none and all.
pub fn percent(share: f64) -> String {
    match 100.0 * share {
        0.0 => "0 %".into(),
        100.0 => "100 %".into(),
        least if least < 0.1 => "less than 0.1 %".into(),
        most if most > 99.9 => "more than 99.9 %".into(),
        part if (10.0..90.0).contains(&part) => format!("{part:.0} %"),
        part => format!("{part:.1} %"),
    }
}

/// Returns the sentence that `what` cannot be run by `machine` where it is placed, as so many of its points are outside the workspace box.
pub fn cannot_be_run(what: &str, outside: u64, points: u64, machine: &str) -> String {
    format!(
        "As placed, {what} cannot be run: {outside} of {points} points are outside the workspace box of {machine}. "
    )
}

/// Formats a probability, a share of so many `draws`: that none of them, or each, does something does not make it impossible or certain.
pub fn probability(share: f64, draws: usize) -> String {
    let unseen = 2.0 / draws as f64;
    percent(share.clamp(unseen, 1.0 - unseen))
}

/// Returns `words` with its first letter in upper case.
pub(crate) fn capitalised(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Returns `words` with its first letter in lower case, but for one that is a name, such as that of a result.
pub(crate) fn uncapitalised(words: &str) -> String {
    let mut letters = words.chars();
    if words.chars().nth(1) == Some(' ') {
        return words.into();
    }
    letters.next().map_or_else(String::new, |first| first.to_lowercase().chain(letters).collect())
}

/// Joins words to a list: "a", "a and b", "a, b and c".
pub fn join_text(words: &[&str]) -> String {
    match words {
        [] => String::new(),
        [one] => (*one).into(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

pub use crate::input::names::listed_up_to;

/// Returns `number` formatted with `words`, or a dash where there is none.
pub fn or_dash<T>(number: Option<T>, words: impl FnOnce(T) -> String) -> String {
    number.map_or_else(|| "–".into(), words)
}

/// Rounds an angle in degrees to 1e-9, which removes the rounding of a conversion to radians and back.
pub(crate) fn tidy_degrees(degrees: f64) -> f64 {
    (degrees * 1e9).round() / 1e9
}
