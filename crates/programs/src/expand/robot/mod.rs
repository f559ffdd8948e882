//! Expansion of RAPID modules and KRL programs: procedures, branches and loops are followed, and targets computed, so that all motions stand in
//! one procedure.
//!
//! What moves nothing stays as it stands. Data of the module (of KRL the `.dat`) and of its first procedure keep their names; those of a
//! procedure that is followed get their values.

mod calls;
mod expression;
mod flow;
mod functions;
mod krl;
mod routine;
mod run;
mod statements;
mod syntax;
mod value;

use std::collections::BTreeSet;

use crate::{
    model::robot::{Language, RobotError, RobotOptions},
    read::robot::{
        Chunk, LocatedFault, RobotExpansion, RobotProgram,
        krl::{check_program, points::is_config},
        line_ending,
    },
};

impl RobotProgram {
    /// Expands a RAPID module or a KRL program (procedures, branches, loops, computed targets) and reads the result as
    /// [`RobotProgram::parse`] does. With `keeps_calls`, they stay where they can when it is rewritten ([`RobotProgram::folded_calls`]). `Err`,
    /// with the line in the original, for what cannot be followed.
    pub fn parse_expanded(
        source: impl Into<Vec<u8>>,
        name: &str,
        language: Language,
        beside: impl IntoIterator<Item = (String, Vec<u8>)>,
        options: &RobotOptions,
        keeps_calls: bool,
    ) -> Result<RobotProgram, RobotError> {
        let (source, beside): (Vec<u8>, Vec<_>) = (source.into(), beside.into_iter().collect());
        if language == Language::Krl {
            let own = beside.iter().filter(|(name, _)| !is_config(name)).map(|(name, data)| (name.as_str(), data));
            for (name, text) in own.chain([(name, &source)]) {
                check_program(text, options).map_err(|refusal| refusal.locate(name, text))?;
            }
        }
        let expanded = expand(&source, language, &beside).map_err(|refusal| refusal.locate(name, &source))?;
        let Expanded { bytes, chunks, lines } = expanded;
        let expansion = RobotExpansion::new(source, chunks, lines, keeps_calls);
        RobotProgram::read(bytes, name, language, beside, options, Some(expansion))
    }
}

/// An expanded module.
pub(crate) struct Expanded {
    pub bytes: Vec<u8>,
    /// Where its parts come from.
    chunks: Vec<Chunk>,
    /// Numbers of lines of the module as posted, and of the expanded one.
    lines: [usize; 2],
}

/// Expands the module `source` with the data `beside` it.
pub(crate) fn expand(
    source: &[u8],
    language: Language,
    beside: &[(String, Vec<u8>)],
) -> Result<Expanded, LocatedFault> {
    // The data stand behind the program; those of all programs first, as its own count.
    let (of_all, own): (Vec<_>, Vec<_>) = beside.iter().partition(|(name, _)| is_config(name));
    let joined = |files: Vec<&(String, Vec<u8>)>| -> Vec<u8> {
        files.into_iter().flat_map(|(_, data)| [b"\n", &data[..]].concat()).collect()
    };
    let (of_all, own) = (joined(of_all), joined(own));
    let own_data = source.len() + of_all.len();
    let text = [source, &of_all, &own].concat();
    let module = routine::Module::read(&text, source.len(), own_data, language)?;
    let entry = module.entry(&text)?;
    let mut run = run::Run::new(&text, &module);
    run.run_entry(&entry)?;
    let (mut written, chunks) = (run.out, run.chunks);
    // The rest of the procedure's first line, and the beginning of its last.
    let ending = line_ending(source);
    let mut copied = Copied { source, out: Vec::new(), chunks: Vec::new() };
    // What nothing calls stays.
    let named: BTreeSet<String> = (module.uncalled.iter())
        .filter_map(|name| module.routines.get(name))
        .flat_map(|routine| syntax::names_of(&source[routine.inside.clone()], language))
        .collect();
    let is_run = |name: &str| name == entry.name || !module.uncalled.contains(name) && !named.contains(name);
    let mut routines: Vec<_> =
        module.routines.values().filter(|routine| routine.moves && is_run(&routine.name)).collect();
    routines.sort_by_key(|routine| routine.head.at.start);
    let mut from = module.head_end;
    copied.copy(0..from);
    let header_at = copied.out.len();
    for routine in routines {
        if routine.name == entry.name {
            copied.copy(from..routine.inside.start);
            copied.out.extend_from_slice(ending);
            let shift = copied.out.len();
            let moved =
                chunks.iter().map(|chunk| Chunk { at: chunk.at.start + shift..chunk.at.end + shift, ..chunk.clone() });
            copied.chunks.extend(moved);
            copied.out.append(&mut written);
            from = line_start(source, routine.inside.end);
        } else {
            copied.copy(from..line_start(source, routine.head.at.start));
            from = line_end(source, routine.end);
        }
    }
    copied.copy(from..source.len());
    let Copied { mut out, mut chunks, .. } = copied;
    let lines = [source, &out[..]].map(|bytes| bytes.iter().filter(|byte| **byte == b'\n').count());
    let lines = [lines[0], lines[1] + 1];
    let mut header = if header_at > 0 { ending.to_vec() } else { Vec::new() };
    header.push(syntax::comment_mark(language));
    header.extend(format!(" written out by kinetostat: {} lines for {}", lines[1], lines[0]).bytes());
    header.extend_from_slice(if header_at > 0 { b"" } else { ending });
    let length = header.len();
    out.splice(header_at..header_at, header);
    for chunk in chunks.iter_mut().filter(|chunk| chunk.at.start >= header_at) {
        chunk.at = chunk.at.start + length..chunk.at.end + length;
    }
    Ok(Expanded { bytes: out, chunks, lines })
}

/// What of a source is copied.
struct Copied<'a> {
    source: &'a [u8],
    out: Vec<u8>,
    chunks: Vec<Chunk>,
}

impl Copied<'_> {
    /// Copies the bytes `origin`.
    fn copy(&mut self, origin: std::ops::Range<usize>) {
        let start = self.out.len();
        self.out.extend_from_slice(&self.source[origin.clone()]);
        self.chunks.push(Chunk { at: start..self.out.len(), origin, is_run: false });
    }
}

/// Returns where the next line begins, if nothing stands behind byte `at` on its line; else `at`.
fn line_end(source: &[u8], at: usize) -> usize {
    let blanks = source[at..].iter().take_while(|byte| matches!(byte, b' ' | b'\t')).count();
    match &source[at + blanks..] {
        [b'\r', b'\n', ..] => at + blanks + 2,
        [b'\r' | b'\n', ..] => at + blanks + 1,
        _ => at,
    }
}

/// Returns where the line of byte `at` begins, if only blanks stand before it; else `at`.
fn line_start(source: &[u8], at: usize) -> usize {
    let (blanks, is_first) = crate::read::robot::indent(source, at);
    if is_first { at - blanks.len() } else { at }
}
