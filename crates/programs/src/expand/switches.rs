//! Where a program switches cutter radius compensation (G41, G42, G40; RL, RR, R0), and by which tool or offset; it is taken out of the program.

use std::collections::BTreeMap;

use crate::{
    expand::{edit::LineEdit, heidenhain::MOTIONS, line::SourceLine},
    model::gcode::{BlockDelete, Dialect, Fault, GcodeOptions, RadiusFault, Refusal, Word},
    read::gcode::{
        LineReader, Statement, Style,
        lines::{self, Lines},
    },
};

/// What a line switches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Switch {
    /// 1 with the cutter to the left of the contour, -1 to the right, 0 with its centre on it.
    pub side: f64,
    /// Number of the D word on the line, of ISO code.
    pub offset: Option<u32>,
    /// Radius that the line gives itself (LinuxCNC's G41.1), in the unit of the program.
    pub radius: Option<f64>,
    /// Whether the tool was called by a name, so that its number is not known.
    pub is_named: bool,
}

/// What lines switch, by their index.
pub(crate) type Switches = BTreeMap<usize, Switch>;

/// A word that says which tool is in use.
#[derive(Clone, Copy, Debug, PartialEq)]
enum ToolWord {
    /// A tool, by its name or not.
    Tool { is_named: bool },
    /// Sinumerik's D.
    Edge(u32),
    /// Heidenhain's DR in TOOL CALL.
    Delta,
}

/// State of the control.
#[derive(Default)]
struct Control {
    is_on: bool,
    is_named: bool,
    edge: Option<u32>,
    has_delta: bool,
    /// First line that sets radii of tools.
    sets_radius: Option<(usize, Refusal)>,
}

/// Takes compensation out of `source`, which then is the contour alone with G40 or R0; returns what it was. `Err` gives the index of the line.
pub(crate) fn take_switches(
    source: &mut Vec<u8>,
    dialect: Dialect,
    options: &GcodeOptions,
) -> Result<Switches, (usize, Refusal)> {
    let all = Lines::split(source);
    let (mut switches, mut bytes) = (Switches::new(), Vec::with_capacity(source.len()));
    let mut reader = match dialect.is_iso() {
        true => LineReader::new(dialect),
        false => LineReader::of_contours(dialect),
    };
    let mut control = Control::default();
    for line in 0..all.len() {
        let content = &source[all.content(line)];
        let is_skipped = options.block_delete == BlockDelete::Skip && lines::is_deletable(content);
        let found = match is_skipped {
            true => None,
            false => control.follow(line, content, dialect, &mut reader).map_err(|refusal| (line, refusal))?,
        };
        let text = found.map(|(switch, text)| {
            control.is_on = switch.side != 0.0;
            switches.insert(line, switch);
            text
        });
        bytes.extend_from_slice(text.as_deref().unwrap_or(content));
        bytes.extend_from_slice(&source[all.ending(line)]);
    }
    if switches.values().all(|switch| switch.side == 0.0) {
        return Ok(Switches::new());
    }
    if let Some(refused) = control.sets_radius {
        return Err(refused);
    }
    *source = bytes;
    Ok(switches)
}

impl Control {
    /// Follows a line; returns what it switches, and the line without that.
    fn follow(
        &mut self,
        line: usize,
        content: &[u8],
        dialect: Dialect,
        reader: &mut LineReader,
    ) -> Result<Option<(Switch, Vec<u8>)>, Refusal> {
        let refuse =
            |at: usize, fault: RadiusFault| Refusal::new(at..(at + 2).min(content.len()), Fault::Radius(fault));
        if !dialect.is_iso() {
            let code = SourceLine::of(content, dialect).code;
            let tool_words = if dialect == Dialect::Heidenhain { tool_call(&code) } else { tool_words(&code) };
            for (at, word) in tool_words {
                match word {
                    ToolWord::Edge(edge) if self.is_on && self.edge.unwrap_or(1) == edge => {}
                    ToolWord::Tool { .. } | ToolWord::Edge(_) if self.is_on => {
                        return Err(refuse(at, RadiusFault::Changed));
                    }
                    ToolWord::Tool { is_named } => (self.is_named, self.edge, self.has_delta) = (is_named, None, false),
                    ToolWord::Edge(edge) => self.edge = Some(edge),
                    ToolWord::Delta => self.has_delta = true,
                }
            }
            if dialect == Dialect::Heidenhain {
                let words: Vec<&str> = code.split_whitespace().skip_while(|word| is_block_number(word)).collect();
                let is_radius = |word: &&str| word.strip_prefix('R').is_some_and(is_number_start);
                let has_radius = words.iter().any(is_radius);
                if words.starts_with(&["TOOL", "DEF"]) && has_radius {
                    self.sets_radius.get_or_insert((line, refuse(0, RadiusFault::SetByProgram)));
                }
                let Some((at, side)) = conversational_switch(&code) else { return Ok(None) };
                self.check(side).map_err(|fault| refuse(at, fault))?;
                let text = [&content[..at], b"R0", &content[at + 2..]].concat();
                let switch = Switch { side, offset: None, radius: None, is_named: self.is_named };
                return Ok(Some((switch, text)));
            }
        }
        // What cannot be read is refused later.
        let Ok(Statement::Words { words, .. }) = reader.parse_line(content) else { return Ok(None) };
        if dialect.is_iso() && sets_radius(&words) {
            let refusal = words[0].refuse(Fault::Radius(RadiusFault::SetByProgram));
            self.sets_radius.get_or_insert((line, refusal));
        }
        let Some((index, mut switch)) = coded_switch(&words, dialect) else { return Ok(None) };
        let at = words[index].span.start;
        self.check(switch.side).map_err(|fault| refuse(at, fault))?;
        if words.iter().filter(|word| word.letter == 'D').count() > 1 {
            return Err(refuse(at, RadiusFault::Changed));
        }
        switch.is_named = self.is_named;
        let mut edit = LineEdit::new(content, &words, Style::plain(dialect));
        edit.replace(index, "G40".into());
        if let Some(index) = edit.find(|word| word.letter == 'D' && dialect.is_iso() && switch.side != 0.0) {
            edit.remove(index);
        }
        Ok(Some((switch, edit.render())))
    }

    /// Refuses to switch compensation on to this side with a tool whose radius is another one than the process file's.
    fn check(&self, side: f64) -> Result<(), RadiusFault> {
        match self.edge {
            _ if side == 0.0 => Ok(()),
            _ if self.has_delta => Err(RadiusFault::Delta),
            Some(edge) if edge != 1 => Err(RadiusFault::Edge),
            _ => Ok(()),
        }
    }
}

/// Whether a line sets lengths or radii of tools (G10 with R).
fn sets_radius(words: &[Word]) -> bool {
    let find = |letter: char| words.iter().find(|word| word.letter == letter);
    let is_data = words.iter().any(|word| word.letter == 'G' && word.tenths() == Some(100));
    let is_of_tools = find('L').is_none_or(|word| [1.0, 10.0, 11.0, 12.0, 13.0].contains(&word.value));
    is_data && is_of_tools && find('R').is_some()
}

/// Returns where the G word of compensation stands among `words`, and what it switches; `None` without one, or without the D of G41.1 and G42.1.
fn coded_switch(words: &[Word], dialect: Dialect) -> Option<(usize, Switch)> {
    let d = words.iter().find(|word| word.letter == 'D');
    words.iter().enumerate().filter(|(_, word)| word.letter == 'G').find_map(|(at, word)| {
        let diameter = || d.map(|word| word.value / 2.0);
        let (side, radius) = match word.tenths()? {
            400 => (0.0, None),
            410 => (1.0, None),
            420 => (-1.0, None),
            411 if dialect == Dialect::LinuxCnc => (1.0, Some(diameter()?)),
            421 if dialect == Dialect::LinuxCnc => (-1.0, Some(diameter()?)),
            _ => return None,
        };
        let offset = d.and_then(|word| word.whole_number().ok()).filter(|_| dialect.is_iso() && radius.is_none());
        Some((at, Switch { side, offset, radius, is_named: false }))
    })
}

/// Whether a word of Heidenhain's is the number of its block.
fn is_block_number(word: &str) -> bool {
    word.bytes().all(|byte| byte.is_ascii_digit())
}

/// Whether a number with or without a sign begins `text`.
fn is_number_start(text: &str) -> bool {
    text.trim_start_matches(['+', '-']).starts_with(|c: char| c.is_ascii_digit())
}

/// Returns which tool a TOOL CALL of Heidenhain's calls, and DR; nothing for one that changes the speed alone.
fn tool_call(code: &str) -> Vec<(usize, ToolWord)> {
    let mut words = code.split_whitespace().skip_while(|word| is_block_number(word));
    if (words.next(), words.next()) != (Some("TOOL"), Some("CALL")) {
        return Vec::new();
    }
    let at = code.find("TOOL").unwrap_or_default();
    let mut found = Vec::new();
    let what = words.next().unwrap_or_default();
    match what.bytes().next() {
        Some(b'0'..=b'9') => found.push((at, ToolWord::Tool { is_named: false })),
        Some(b'"' | b'Q') => found.push((at, ToolWord::Tool { is_named: true })),
        _ => {}
    }
    let deltas = code.split_whitespace().filter_map(|word| word.strip_prefix("DR"));
    let has_delta = deltas.map(|value| value.replace(',', ".").parse::<f64>()).any(|value| value != Ok(0.0));
    found.extend(has_delta.then_some((at, ToolWord::Delta)));
    found
}

/// Returns the T and D words of a line of Sinumerik's.
fn tool_words(code: &str) -> Vec<(usize, ToolWord)> {
    let bytes = code.as_bytes();
    let (mut found, mut is_quoted) = (Vec::new(), false);
    for at in 0..bytes.len() {
        is_quoted ^= bytes[at] == b'"';
        let begins = at == 0 || !(bytes[at - 1].is_ascii_alphabetic() || matches!(bytes[at - 1], b'_' | b'$'));
        if is_quoted || !begins || !matches!(bytes[at], b'T' | b'D') {
            continue;
        }
        let rest = &code[at + 1..];
        let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
        let behind = rest[digits..].trim_start();
        let value = behind.strip_prefix('=').map(str::trim_start);
        let number = |text: &str| {
            let count = text.bytes().take_while(u8::is_ascii_digit).count();
            text[..count].parse::<u32>().ok()
        };
        // T1=5 is the tool of another spindle, D1=5 no word.
        let given = match (digits, value) {
            (0, Some(value)) => number(value),
            (_, None) => number(rest),
            (_, Some(_)) => None,
        };
        match (bytes[at], given, value) {
            (b'D', Some(edge), _) => found.push((at, ToolWord::Edge(edge))),
            (b'T', Some(_), _) => found.push((at, ToolWord::Tool { is_named: false })),
            (b'T', None, Some(_)) => found.push((at, ToolWord::Tool { is_named: true })),
            _ => {}
        }
    }
    found
}

/// Returns where RL, RR or R0 stands in a line of Heidenhain's, and the side (1 left, −1 right, 0 none); `None` without one, and in lines without a
/// motion.
fn conversational_switch(code: &str) -> Option<(usize, f64)> {
    let verb = code.split_whitespace().map(|word| word.trim_start_matches('/')).find(|word| !is_block_number(word))?;
    let is_free = |byte: Option<&u8>| byte.is_none_or(|byte| !byte.is_ascii_alphanumeric() && !b".,".contains(byte));
    let moves = MOTIONS.contains(&verb);
    [("RL", 1.0), ("RR", -1.0), ("R0", 0.0)].into_iter().find_map(|(text, side)| {
        let bytes = code.as_bytes();
        let mut ends = code.match_indices(text).map(|(at, _)| at);
        let at =
            ends.find(|at| is_free(bytes.get(at + 2)) && is_free(at.checked_sub(1).and_then(|at| bytes.get(at))))?;
        moves.then_some((at, side))
    })
}
