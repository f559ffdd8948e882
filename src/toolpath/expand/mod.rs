//! A program written out as the motion it makes: calls, loops and jumps followed, expressions evaluated, before anything is
//! interpreted; then cycles as the moves that they are. What depends on the state of the machine is refused.

use crate::toolpath::{
    model::gcode::{Dialect, GcodeError, GcodeOptions},
    read::gcode::{Program, WrittenOut, dialect},
};

mod calls;
mod cycles;
pub(crate) mod edit;
mod expression;
mod flow;
mod heidenhain_cycles;
mod jumps;
pub(crate) mod line;
mod modes;
pub(crate) mod run;
mod sinumerik_cycles;
pub(crate) mod variables;

/// Gives the bytes of a file beside the program, if there is one of this name.
pub type Beside<'a> = dyn Fn(&str) -> Option<Vec<u8>> + 'a;

impl Program {
    /// Writes the program out as the motion it makes (calls, loops, jumps and expressions followed, cycles as moves), then
    /// reads that as [`Program::parse`] does. A comment at its top says so. Lines in messages are those of the files they come from;
    /// `beside` gives the files beside the program that it may call.
    ///
    /// # Errors
    /// What cannot be evaluated, and as [`Program::parse`].
    pub fn parse_expanded(
        source: impl Into<Vec<u8>>,
        name: &str,
        options: &GcodeOptions,
        beside: &Beside<'_>,
    ) -> Result<Program, GcodeError> {
        Program::parse_written_out(source.into(), name, options, beside, false)
    }

    /// Follows calls, loops, jumps and expressions as [`Program::parse_expanded`] does, but leaves cycles as they are, and gives what
    /// is rewritten its calls back where it can ([`Program::calls_of`]).
    ///
    /// # Errors
    /// As [`Program::parse_expanded`].
    pub fn parse_with_calls(
        source: impl Into<Vec<u8>>,
        name: &str,
        options: &GcodeOptions,
        beside: &Beside<'_>,
    ) -> Result<Program, GcodeError> {
        Program::parse_written_out(source.into(), name, options, beside, true)
    }

    fn parse_written_out(
        source: Vec<u8>,
        name: &str,
        options: &GcodeOptions,
        beside: &Beside<'_>,
        keeps_calls: bool,
    ) -> Result<Program, GcodeError> {
        let dialect = options.dialect.unwrap_or_else(|| Dialect::of(&source));
        let options = &GcodeOptions { dialect: Some(dialect), ..options.clone() };
        let (mut bytes, mut written_out) = match dialect {
            _ if dialect.is_iso() => run::Run::new(source, name, options, beside).all()?,
            _ => {
                let Some((bytes, lines)) = dialect.without_cycles(&source) else {
                    return Err(dialect::not_written_out(&source, name, dialect));
                };
                (bytes, WrittenOut::of_lines(name, source, &lines))
            }
        };
        if !dialect.is_iso() {
            // Moves have taken the place of its cycles.
        } else if keeps_calls {
            written_out.keeps_calls = true;
        } else {
            let program = Program::parse(bytes, name, options).map_err(|fault| written_out.located(fault))?;
            let without_cycles = program.without_cycles().map_err(|fault| written_out.located(fault))?;
            bytes = without_cycles.map_or(program.source, |(moves, lines)| {
                written_out.compose_origins(&lines);
                moves
            });
        }
        written_out.sign(&mut bytes, dialect);
        let mut program = Program::parse(bytes, name, options).map_err(|fault| written_out.located(fault))?;
        for line in &mut program.notes.not_located {
            *line = written_out.line_of(*line);
        }
        if let Some((_, line)) = &mut program.notes.unit_taken {
            *line = written_out.line_of(*line);
        }
        program.notes.written_out = Some([written_out.lines, written_out.origins.len()]);
        program.written_out = Some(written_out);
        Ok(program)
    }
}

impl Dialect {
    /// A program that is not ISO code with its drilling cycles written out as moves, and the line, from 0, that each of its lines comes from;
    /// `None` where there are none, or some that cannot be.
    pub(crate) fn without_cycles(self, source: &[u8]) -> Option<(Vec<u8>, Vec<usize>)> {
        match self {
            Dialect::Iso | Dialect::Fanuc | Dialect::Haas | Dialect::LinuxCnc => None,
            Dialect::Sinumerik => sinumerik_cycles::written_out(source),
            Dialect::Heidenhain => heidenhain_cycles::written_out(source),
        }
    }
}
