//! Main result for a terminal: sentence, numbers and cautions.

use anstyle::{AnsiColor, Style};
use kinetostat::{
    files::visible,
    page::headline::{Headline, KeyNumber, State},
};

const BOLD: Style = Style::new().bold();
const WARNING: Style = AnsiColor::Yellow.on_default();
const FAINT: Style = Style::new().dimmed();

/// Largest width of lines, in characters.
const WIDEST: usize = 96;

/// Returns the main result with styles as escape sequences. `took` is the computing time in words.
pub fn result_text(headline: &Headline, took: &str) -> String {
    let solved = if headline.unsolved.is_some() { "" } else { ", all points solved" };
    let basis = format!("Computed from {}{solved}, in {took}.", headline.basis);
    headline_text(headline) + &paragraph(&basis, "", FAINT, textwrap::termwidth().min(WIDEST))
}

/// Returns the first screen with styles as escape sequences.
pub fn headline_text(headline: &Headline) -> String {
    let width = textwrap::termwidth().min(WIDEST);
    let mut text = String::new();
    if let Some(verdict) = &headline.verdict {
        let marks: String = headline.marks.iter().map(|mark| format!(" [{mark}]")).collect();
        let line = format!("{} {}{marks}", verdict.state.sign(), verdict.words);
        text += &paragraph(&line, "", style_of(verdict.state), width);
    }
    if !headline.causes.is_empty() {
        let causes: Vec<String> = headline.causes.iter().map(|own| own.text()).collect();
        text += &paragraph(&causes.join("  "), "", Style::new(), width);
    }
    if let Some(unsolved) = &headline.unsolved {
        text += &paragraph(&format!("{unsolved} What follows rests on the rest."), "", WARNING, width);
    }
    text += &paragraph(&headline.sentence, "", BOLD, width);
    text.push('\n');
    let column = headline.numbers.iter().map(|number| number.shown().chars().count()).max().unwrap_or(0);
    for number in &headline.numbers {
        text += &key_number(number, column, width);
    }
    if !headline.numbers.is_empty() {
        text.push('\n');
    }
    if let Some(next) = &headline.next {
        text += &paragraph(&format!("Next: {next}"), "  ", BOLD, width);
        text.push('\n');
    }
    for caution in &headline.cautions {
        text += &paragraph(caution, "  ", Style::new(), width);
    }
    text
}

/// Returns the colour of a verdict.
fn style_of(state: State) -> Style {
    let colour = match state {
        State::Good => AnsiColor::Green,
        State::Partly => AnsiColor::Yellow,
        State::Bad => AnsiColor::Red,
        State::Open | State::NotDecided => return BOLD,
    };
    colour.on_default().bold()
}

/// Returns sentences, one per line, wrapped to the width of the terminal.
pub fn sentences(text: &str) -> String {
    let width = textwrap::termwidth().min(WIDEST);
    text.lines().map(|line| paragraph(line, "", Style::new(), width)).collect()
}

/// Returns a number with its label, right-aligned in a column `column` characters wide.
fn key_number(number: &KeyNumber, column: usize, width: usize) -> String {
    let indent = " ".repeat(column + 5);
    let shown = visible(&number.shown()).into_owned();
    let padding = " ".repeat(column - number.shown().chars().count());
    let lines = [number.what.as_str(), &number.against].into_iter().filter(|line| !line.is_empty());
    let wrapped: Vec<String> = lines.map(|line| paragraph(line, &indent, Style::new(), width)).collect();
    let label = wrapped.concat();
    format!("  {padding}{BOLD}{shown}{BOLD:#}   {}", label.trim_start_matches(' '))
}

/// Returns `text` in lines of at most `width` characters that begin with `indent`.
fn paragraph(text: &str, indent: &str, style: Style, width: usize) -> String {
    let options = textwrap::Options::new(width).initial_indent(indent).subsequent_indent(indent);
    // A number stays with its percent sign.
    let text = text.replace(" %", "\u{a0}%");
    let lines = textwrap::wrap(&text, options);
    lines.iter().map(|line| format!("{style}{}{style:#}\n", visible(&line.replace('\u{a0}', " ")))).collect()
}
