//! A program walked through statement by statement: each with where it leads, found anew on every walk, so that a
//! program is held as its bytes and however long it is takes little memory.

use nalgebra::Vector3;

use crate::toolpath::{
    model::{
        NumberFormat, Way, decimals_in,
        robot::{Component, Decimals, Language, RobotError, RobotFault, Statement, Target},
    },
    read::robot::{Follower, Motion, Refusal, RobotProgram, apt, krl, rapid},
};

/// What is kept of a motion.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MotionAt {
    /// The line it begins on, from 1.
    pub line: u32,
    /// The byte it begins at.
    pub start: usize,
}

/// What a reader of a program should know.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RobotNotes {
    /// Lines with motions whose end is not known, from 1: they stay as they are.
    pub not_located: Vec<usize>,
    /// Name and tip of the tool, mm in the flange, where the program says them.
    pub tool_tip_mm: Option<(String, Vector3<f64>)>,
    /// Whether some motion leads to a point that is declared elsewhere; corrected, it has its numbers in the motion.
    pub named_points: bool,
}

impl RobotProgram {
    /// Gives each motion to `visit`, in order; then what a reader should know.
    ///
    /// # Errors
    /// A statement that is not followed, and those of `visit`.
    pub(crate) fn walk<E: From<RobotError>>(
        &self,
        mut visit: impl FnMut(&Motion) -> Result<(), E>,
    ) -> Result<RobotNotes, E> {
        let mut reader = Reader::new(self);
        let mut follower = Follower::new(self.language, self.options.external_axes.len());
        let mut notes = RobotNotes::default();
        let located = |refusal: Refusal| refusal.locate(&self.name, &self.source);
        while let Some(statement) = reader.next().map_err(located)? {
            let (line, at) = (statement.line, statement.at.clone());
            let motion = follower.follow(statement).map_err(|fault| located(Refusal { line, at, fault }))?;
            if motion.way == Way::Unlocated {
                notes.not_located.push(line);
            }
            notes.named_points |= self.poses(&motion.statement).any(|(_, is_named)| is_named);
            visit(&motion)?;
        }
        notes.tool_tip_mm = reader.tool_tip_mm();
        Ok(notes)
    }

    /// Walks through the program for the first time, and keeps what is asked of all of it.
    pub(crate) fn survey(&mut self) -> Result<(), RobotError> {
        let (mut motions, mut seen) = (Vec::new(), [[0usize; 3]; 2]);
        let notes = self.walk(|motion| {
            let statement = &motion.statement;
            let seen = &mut seen[usize::from(statement.frames.unit_mm != 1.0)];
            for (target, _) in self.poses(statement) {
                for number in &target.numbers {
                    let text = String::from_utf8_lossy(&target.text[number.at.clone()]);
                    let mantissa = text.split(['e', 'E']).next().unwrap_or_default();
                    let kind = match number.component {
                        Component::Position(_) => 0,
                        Component::Rotation(_) => 1,
                        Component::External(_) => 2,
                    };
                    seen[kind] = decimals_in(mantissa).max(seen[kind]);
                }
            }
            motions
                .push(MotionAt { line: u32::try_from(statement.line).unwrap_or(u32::MAX), start: statement.at.start });
            Ok::<(), RobotError>(())
        })?;
        let most = |kind: usize| seen[0][kind].max(seen[1][kind]);
        (self.motions, self.notes) = (motions, notes);
        self.own_format = NumberFormat::seen(seen[0][0], seen[1][0]);
        self.decimals = Decimals::seen(self.language, most(1), most(2));
        Ok(())
    }

    /// The poses of a statement, and whether they are declared elsewhere.
    fn poses<'a>(&'a self, statement: &'a Statement) -> impl Iterator<Item = (&'a Target, bool)> {
        let is_named = |target: &Target| self.source.get(target.at.clone()) != Some(target.text.as_slice());
        statement.via.iter().chain(&statement.end).map(move |target| (target, is_named(target)))
    }

    pub(crate) fn refused(&self, statement: &Statement, fault: RobotFault) -> RobotError {
        Refusal { line: statement.line, at: statement.at.clone(), fault }.locate(&self.name, &self.source)
    }
}

/// Goes through a program from its first statement on.
#[derive(Debug)]
enum Reader<'a> {
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
