//! Calls that stay calls: what was written of a program that was written out, back in the lines that it comes from.
//!
//! A line that runs more than once can be written once if the same was written of it each time. What was computed for it stays
//! computed only if nothing of it has changed. The files found so are run again: they must give what was written, byte by byte.

use std::collections::BTreeMap;

use thiserror::Error;

use crate::toolpath::{
    expand::{line::SourceLine, run::Run},
    read::gcode::{
        CalledFile, Origin, Program, WrittenOut,
        lines::{self, Lines},
    },
    write::gcode::Rewritten,
};

/// A program with calls and what becomes of them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Calls {
    /// They stay.
    Stay {
        /// The program's own file.
        program: Vec<u8>,
        /// Those that it calls beside it.
        beside: Vec<CalledFile>,
    },
    /// They are written out.
    WrittenOut(Differs),
}

/// Why a program cannot be written with its calls: the first line at which that shows.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{}line {line} {how}", in_file(file.as_deref()))]
pub struct Differs {
    /// The file, if it is not the program's own.
    pub file: Option<String>,
    /// The line, from 1.
    pub line: usize,
    /// What is the matter with it.
    pub how: How,
}

/// What is the matter with a line that was written out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum How {
    /// It runs several times, and is written differently.
    #[error("runs several times, each with other corrections")]
    FromRunToRun,
    /// It is computed from variables, and is to be corrected.
    #[error("is computed, and cannot be both that and corrected")]
    Computed,
    /// With it in its place the program would run differently.
    #[error("would run differently if it were corrected where it stands")]
    OutOfPlace,
}

/// The beginning of a place in a file.
fn in_file(file: Option<&str>) -> String {
    file.map_or_else(String::new, |file| format!("{file} "))
}

/// What a line of a source has become.
enum Became<'a> {
    Itself,
    Text { was: &'a [u8], text: &'a [u8] },
}

impl Program {
    /// `rewritten` of this program with its calls; `None` if it has none, or was to be written out.
    #[must_use]
    pub fn calls_of(&self, rewritten: &Rewritten) -> Option<Calls> {
        let written_out = self.written_out.as_ref().filter(|written_out| written_out.keeps_calls)?;
        let folded = self.folded(written_out, rewritten);
        Some(folded.unwrap_or_else(|(at, how)| Calls::WrittenOut(written_out.differs(at, how))))
    }

    fn folded(&self, written_out: &WrittenOut, rewritten: &Rewritten) -> Result<Calls, (Origin, How)> {
        let mut became: BTreeMap<Origin, Became<'_>> = BTreeMap::new();
        let mut run = Vec::with_capacity(rewritten.bytes().len());
        let mut first = 0;
        for (line, (origin, end)) in written_out.origins.iter().zip(&rewritten.line_ends).enumerate() {
            let text = &rewritten.bytes()[first..*end];
            first = *end;
            if line == written_out.header {
                continue;
            }
            run.extend_from_slice(text);
            let was = &self.source[self.lines.content(line).start..self.lines.ending(line).end];
            // The second % stands for the end, whatever line that is.
            if lines::first(was) == Some(b'%') {
                continue;
            }
            let now = if text == was { Became::Itself } else { Became::Text { was, text } };
            let is_same = match (became.get(origin), &now) {
                (None, _) | (Some(Became::Itself), Became::Itself) => true,
                (Some(Became::Text { was: was_before, text: before }), Became::Text { was, text }) => {
                    was_before == was && before == text
                }
                _ => false,
            };
            if !is_same {
                return Err((*origin, How::FromRunToRun));
            }
            became.insert(*origin, now);
        }
        let program = refilled(0, written_out.file_bytes(), &became)?;
        let mut beside = Vec::with_capacity(written_out.files.len());
        for (file, source) in written_out.files.iter().enumerate().skip(1) {
            beside.push(CalledFile { name: source.name.clone(), bytes: refilled(file, &source.bytes, &became)? });
        }
        let bytes_of = |name: &str| beside.iter().find(|file| file.name == name).map(|file| file.bytes.clone());
        let again = Run::new(program.clone(), &self.name, &self.options, &bytes_of).all();
        match again {
            Ok((again, _)) if again == run => Ok(Calls::Stay { program, beside }),
            Ok((again, _)) => Err((written_out.first_difference(&again, &run), How::OutOfPlace)),
            Err(_) => Err((Origin::default(), How::OutOfPlace)),
        }
    }
}

impl WrittenOut {
    fn differs(&self, at: Origin, how: How) -> Differs {
        Differs { file: self.called(at).map(str::to_owned), line: at.line + 1, how }
    }

    /// Where the first line comes from in which a program, run again, is another than it was.
    fn first_difference(&self, again: &[u8], run: &[u8]) -> Origin {
        let same = again.iter().zip(run).take_while(|(again, run)| again == run).count();
        let line = run[..same].iter().filter(|byte| **byte == b'\n').count();
        self.origin(line + 1 + usize::from(line >= self.header))
    }
}

/// The bytes of file number `file` with its lines as they `became`.
fn refilled(file: usize, bytes: &[u8], became: &BTreeMap<Origin, Became<'_>>) -> Result<Vec<u8>, (Origin, How)> {
    let lines = Lines::of(bytes);
    let mut out = Vec::with_capacity(bytes.len());
    for line in 0..lines.len() {
        let (content, ending) = (&bytes[lines.content(line)], &bytes[lines.ending(line)]);
        let at = Origin { file, line };
        let Some(Became::Text { was, text }) = became.get(&at) else {
            out.extend_from_slice(content);
            out.extend_from_slice(ending);
            continue;
        };
        let was = &was[..Lines::of(was).content(0).end];
        let call = if was == content { None } else { Some(call_of(content, was).ok_or((at, How::Computed))?) };
        out.extend_from_slice(text);
        if let Some(call) = call {
            out.extend_from_slice(call.as_bytes());
            out.extend_from_slice(if ending.is_empty() { b"\n" } else { ending });
        }
        if ending.is_empty() && out.ends_with(b"\n") {
            out.pop();
        }
    }
    Ok(out)
}

/// The words of a line that call a subprogram or go back from one, if it has them and `rest` is what else is on it.
fn call_of(content: &[u8], rest: &[u8]) -> Option<String> {
    let line = SourceLine::new(content);
    if line.code.contains(['#', '[']) || !line.has(b'M', &[97.0, 98.0, 99.0, 198.0]) {
        return None;
    }
    let words = line.words(&crate::toolpath::expand::variables::Variables::default()).ok()?;
    let of_call = |letter: char, value: Option<f64>| match letter {
        'P' | 'L' => true,
        'M' => matches!(value, Some(97.0 | 98.0 | 99.0 | 198.0)),
        _ => false,
    };
    let own: Vec<_> = words.into_iter().filter(|word| of_call(word.letter, word.value)).collect();
    let is_rest = line.without(&own).is_some_and(|without| without.bytes == rest);
    let texts: Vec<_> = own.iter().map(|word| String::from_utf8_lossy(&content[word.span.clone()])).collect();
    is_rest.then(|| texts.join(" "))
}
