//! Puts the written statements of an expanded program back where they stand in the program with its procedures, branches and loops.
//!
//! A statement that runs several times can be written once if the same was written of it each time. The program found so is expanded again:
//! it must give what was written, byte by byte.

use std::collections::BTreeMap;

use crate::{
    expand::robot::expand,
    model::Rewritten,
    read::robot::{RobotExpansion, RobotProgram},
    write::gcode::fold::{Calls, FoldFailure, FoldFault},
};

impl RobotProgram {
    /// Puts `rewritten` back into the program with its calls, or says why not; `None` if it has none or need not keep them.
    #[must_use]
    pub fn folded_calls(&self, rewritten: &Rewritten<RobotProgram>) -> Option<Calls> {
        let expansion = self.expansion.as_ref().filter(|expansion| expansion.keeps_calls)?;
        let fold = self.fold(expansion, rewritten);
        Some(fold.unwrap_or_else(|(at, how)| {
            Calls::WrittenOut(FoldFailure { file: None, line: expansion.posted_line(at), how })
        }))
    }

    /// Returns the program with the statements of `rewritten` in place; fails with the byte of the first that cannot be put back, and why.
    fn fold(
        &self,
        expansion: &RobotExpansion,
        rewritten: &Rewritten<RobotProgram>,
    ) -> Result<Calls, (usize, FoldFault)> {
        let mut changes: BTreeMap<[usize; 2], (bool, &[u8])> = BTreeMap::new();
        for (chunk, ends) in expansion.chunks.iter().zip(rewritten.line_ends.chunks(2)) {
            let (Some(now), Some(was)) = (rewritten.bytes().get(ends[0]..ends[1]), self.source.get(chunk.at.clone()))
            else {
                return Err((chunk.origin.start, FoldFault::OutOfPlace));
            };
            if !chunk.is_run {
                continue;
            }
            let change = (now != was, if now == was { &expansion.source[chunk.origin.clone()] } else { now });
            let key = [chunk.origin.start, chunk.origin.end];
            if *changes.entry(key).or_insert(change) != change {
                return Err((chunk.origin.start, FoldFault::FromRunToRun));
            }
        }
        let (mut program, mut copied) = (Vec::with_capacity(rewritten.bytes().len()), 0);
        for ([start, end], (is_changed, text)) in changes {
            if !is_changed {
                continue;
            }
            if start < copied {
                return Err((start, FoldFault::OutOfPlace));
            }
            program.extend_from_slice(&expansion.source[copied..start]);
            program.extend_from_slice(text);
            copied = end;
        }
        program.extend_from_slice(&expansion.source[copied..]);
        match expand(&program, self.language, &self.beside) {
            Ok(rerun) if statements(&rerun.bytes).eq(statements(rewritten.bytes())) => {
                Ok(Calls::Stay { program, beside: Vec::new() })
            }
            _ => Err((0, FoldFault::OutOfPlace)),
        }
    }
}

/// Iterates over the lines of an expanded program, without blanks before them and the comments that say what it is.
fn statements(bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    let lines = bytes.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii);
    lines.filter(|line| !line.is_empty() && !line[1..].starts_with(b" written out by kinetostat"))
}
