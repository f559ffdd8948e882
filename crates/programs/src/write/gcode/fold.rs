//! Puts the written lines of an expanded program back into the files with calls that they come from.
//!
//! A line that runs more than once can be written once if the same was written of it each time. What was computed for it stays
//! computed only if nothing of it has changed. The files found so are run again: they must give what was written, byte by byte.

use std::{borrow::Cow, collections::BTreeMap};

use thiserror::Error;

use crate::{
    expand::{line::SourceLine, run::Run},
    model::{Rewritten, gcode::Dialect},
    read::gcode::{
        CalledFile, Expansion, GcodeProgram, Origin,
        dialect::block_numbers,
        lines::{self, Lines},
    },
};

/// What becomes of the calls of a program that is written back: they stay, or it stays expanded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Calls {
    /// They stay.
    Stay {
        /// The program's own file.
        program: Vec<u8>,
        /// The called files beside it.
        beside: Vec<CalledFile>,
    },
    /// The program stays expanded, for this reason.
    WrittenOut(FoldFailure),
}

/// The reason why a program cannot be written with its calls, at the first line concerned.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{}line {line} {how}", file_prefix(file.as_deref()))]
pub struct FoldFailure {
    /// The file, if it is not the program's own.
    pub file: Option<String>,
    /// The line, from 1.
    pub line: usize,
    /// What prevents it.
    pub how: FoldFault,
}

/// What prevents an expanded line from being put back into its source line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum FoldFault {
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

/// Returns the beginning of a message about a line: the file's name and a blank, or nothing.
fn file_prefix(file: Option<&str>) -> String {
    file.map_or_else(String::new, |file| format!("{file} "))
}

/// What a source line becomes in the written program: unchanged, or another text.
enum Change<'a> {
    Itself,
    Text { was: Cow<'a, [u8]>, text: Cow<'a, [u8]> },
}

impl GcodeProgram {
    /// Puts `rewritten` back into the program's files with calls, or says why not; `None` if it has no calls or need not keep them.
    #[must_use]
    pub fn folded_calls(&self, rewritten: &Rewritten<GcodeProgram>) -> Option<Calls> {
        let expansion = self.expansion.as_ref().filter(|expansion| expansion.keeps_calls)?;
        let fold = self.fold(expansion, rewritten);
        Some(fold.unwrap_or_else(|(at, how)| Calls::WrittenOut(expansion.failure(at, how))))
    }

    /// Returns the program's files with the lines of `rewritten` in place; fails with the first line that cannot be put back, and why.
    fn fold(&self, expansion: &Expansion, rewritten: &Rewritten<GcodeProgram>) -> Result<Calls, (Origin, FoldFault)> {
        let mut changes: BTreeMap<Origin, Change<'_>> = BTreeMap::new();
        let mut run = Vec::with_capacity(rewritten.bytes().len());
        let mut first = 0;
        for (line, (origin, end)) in expansion.origins.iter().zip(&rewritten.line_ends).enumerate() {
            let text = numberless(&rewritten.bytes()[first..*end], self.dialect);
            first = *end;
            if line == expansion.header {
                continue;
            }
            run.extend_from_slice(&text);
            let was = &self.source[self.lines.content(line).start..self.lines.ending(line).end];
            let was = numberless(was, self.dialect);
            // The second % stands for the end, whatever line that is.
            if lines::first_byte(&was) == Some(b'%') {
                continue;
            }
            let now = if text == was { Change::Itself } else { Change::Text { was, text } };
            let is_same = match (changes.get(origin), &now) {
                (None, _) | (Some(Change::Itself), Change::Itself) => true,
                (Some(Change::Text { was: was_before, text: before }), Change::Text { was, text }) => {
                    was_before == was && before == text
                }
                _ => false,
            };
            if !is_same {
                return Err((*origin, FoldFault::FromRunToRun));
            }
            changes.insert(*origin, now);
        }
        let program = apply(0, expansion.file_bytes(), &changes, self.dialect)?;
        let mut beside = Vec::with_capacity(expansion.files.len());
        for (file, source) in expansion.files.iter().enumerate().skip(1) {
            beside.push(CalledFile {
                name: source.name.clone(),
                bytes: apply(file, &source.bytes, &changes, self.dialect)?,
            });
        }
        let bytes_of = |name: &str| beside.iter().find(|file| file.name == name).map(|file| file.bytes.clone());
        let rerun = Run::new(program.clone(), &self.name, &self.options, &bytes_of).run_to_end();
        match rerun {
            Ok((rerun, _)) if numberless(&rerun, self.dialect) == run => Ok(Calls::Stay { program, beside }),
            Ok((rerun, _)) => Err((expansion.first_difference(&rerun, &run), FoldFault::OutOfPlace)),
            Err(_) => Err((Origin::default(), FoldFault::OutOfPlace)),
        }
    }
}

impl Expansion {
    /// Creates the failure that the source line `at` cannot be put back, because of `how`.
    fn failure(&self, at: Origin, how: FoldFault) -> FoldFailure {
        FoldFailure { file: self.called_name(at).map(str::to_owned), line: at.line + 1, how }
    }

    /// Returns the source line of the first line in which `rerun`, the folded program run again, differs from `run`, what was written.
    fn first_difference(&self, rerun: &[u8], run: &[u8]) -> Origin {
        let same = rerun.iter().zip(run).take_while(|(rerun, run)| rerun == run).count();
        let line = run[..same].iter().filter(|byte| **byte == b'\n').count();
        self.origin(line + 1 + usize::from(line >= self.header))
    }
}

/// Returns the bytes of the file with number `file`, with its lines replaced as `changes` says; fails at a line that is computed.
fn apply(
    file: usize,
    bytes: &[u8],
    changes: &BTreeMap<Origin, Change<'_>>,
    dialect: Dialect,
) -> Result<Vec<u8>, (Origin, FoldFault)> {
    let lines = Lines::split(bytes);
    let mut out = Vec::with_capacity(bytes.len());
    for line in 0..lines.len() {
        let (content, ending) = (&bytes[lines.content(line)], &bytes[lines.ending(line)]);
        let at = Origin { file, line };
        let Some(Change::Text { was, text }) = changes.get(&at) else {
            out.extend_from_slice(content);
            out.extend_from_slice(ending);
            continue;
        };
        let was = &was[..Lines::split(was).content(0).end];
        let bare = numberless(content, dialect);
        let call = if *was == *bare { None } else { Some(call_words(content, was).ok_or((at, FoldFault::Computed))?) };
        // All lines of a block get its number, and are counted on below.
        let number = &content[..content.len() - bare.len()];
        let lines_of = Lines::split(text);
        for line in 0..lines_of.len() {
            out.extend_from_slice(number);
            out.extend_from_slice(&text[lines_of.content(line).start..lines_of.ending(line).end]);
        }
        if let Some(call) = call {
            out.extend_from_slice(call.as_bytes());
            out.extend_from_slice(if ending.is_empty() { b"\n" } else { ending });
        }
        if ending.is_empty() && out.ends_with(b"\n") {
            out.pop();
        }
    }
    Ok(dialect.renumbered(bytes, out))
}

/// Returns lines without the numbers that blocks of Heidenhain's begin with.
fn numberless(bytes: &[u8], dialect: Dialect) -> Cow<'_, [u8]> {
    if dialect != Dialect::Heidenhain {
        return Cow::Borrowed(bytes);
    }
    let lines = Lines::split(bytes);
    let text = (0..lines.len()).flat_map(|line| {
        let content = &bytes[lines.content(line)];
        let number = block_numbers::leading_number(content).filter(|(range, _)| range.start == 0);
        [&content[number.map_or(0, |(range, _)| range.end)..], &bytes[lines.ending(line)]]
    });
    Cow::Owned(text.flatten().copied().collect())
}

/// Returns the words of the line `content` that call a subprogram or return from one; `None` unless `rest` is all else that is on the line.
fn call_words(content: &[u8], rest: &[u8]) -> Option<String> {
    let line = SourceLine::new(content);
    if line.code.contains(['#', '[']) || !line.has_word(b'M', &[97.0, 98.0, 99.0, 198.0]) {
        return None;
    }
    let words = line.words(&crate::expand::variables::Variables::default()).ok()?;
    let is_of_call = |letter: char, value: Option<f64>| match letter {
        'P' | 'L' => true,
        'M' => matches!(value, Some(97.0 | 98.0 | 99.0 | 198.0)),
        _ => false,
    };
    let call_words: Vec<_> = words.into_iter().filter(|word| is_of_call(word.letter, word.value)).collect();
    let is_rest = line.without_words(&call_words).is_some_and(|without| without.bytes == rest);
    let texts: Vec<_> = call_words.iter().map(|word| String::from_utf8_lossy(&content[word.span.clone()])).collect();
    is_rest.then(|| texts.join(" "))
}
