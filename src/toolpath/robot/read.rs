//! The readers of languages behind one name.

use nalgebra::Vector3;

use super::{RobotProgram, frames::Tools, krl, language::Language, source::Refusal, statement::Statement};

/// Goes through a program from its first statement on.
#[derive(Debug)]
pub(super) enum Reader<'a> {
    Krl(Box<krl::Reader<'a>>),
}

impl<'a> Reader<'a> {
    pub fn new(program: &'a RobotProgram) -> Self {
        let beside = program.beside.as_ref().map(|(name, bytes)| (name.as_str(), bytes.as_slice()));
        match program.language {
            _ => Reader::Krl(Box::new(krl::Reader::new(&program.source, beside, &program.options))),
        }
    }

    /// The next statement that moves the tool.
    pub fn next(&mut self) -> Result<Option<Statement>, Refusal> {
        match self {
            Reader::Krl(reader) => reader.next(),
        }
    }

    /// Name and tip (mm, in the flange) of the tool that motions used so far, if the program says where it is.
    pub fn tool_tip_mm(&self) -> Option<(String, Vector3<f64>)> {
        match self {
            Reader::Krl(reader) => reader.tools().tip_mm(),
        }
    }
}
