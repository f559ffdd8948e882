//! The readers of languages behind one name.

use nalgebra::Vector3;

use crate::toolpath::{
    model::robot::{language::Language, statement::Statement},
    read::robot::{RobotProgram, apt, krl, rapid, source::Refusal},
};

/// Goes through a program from its first statement on.
#[derive(Debug)]
pub(crate) enum Reader<'a> {
    Krl(Box<krl::Reader<'a>>),
    Rapid(Box<rapid::Reader<'a>>),
    Apt(Box<apt::Reader<'a>>),
}

impl<'a> Reader<'a> {
    pub fn new(program: &'a RobotProgram) -> Self {
        let (source, options) = (&program.source, &program.options);
        match program.language {
            Language::Krl => Reader::Krl(Box::new(krl::Reader::new(source, program.beside(), options))),
            Language::Rapid => Reader::Rapid(Box::new(rapid::Reader::new(source, options))),
            Language::Apt => Reader::Apt(Box::new(apt::Reader::new(source, options))),
        }
    }

    /// The next statement that moves the tool.
    pub fn next(&mut self) -> Result<Option<Statement>, Refusal> {
        match self {
            Reader::Krl(reader) => reader.next(),
            Reader::Rapid(reader) => reader.next(),
            Reader::Apt(reader) => reader.next(),
        }
    }

    /// Name and tip (mm, in the flange) of the tool that motions used so far, if the program says where it is.
    pub fn tool_tip_mm(&self) -> Option<(String, Vector3<f64>)> {
        match self {
            Reader::Krl(reader) => reader.tools().tip_mm(),
            Reader::Rapid(reader) => reader.tools().tip_mm(),
            Reader::Apt(_) => None,
        }
    }
}
