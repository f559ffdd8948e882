//! Walks through a robot program motion by motion. Each walk reads its bytes anew, so that long programs take little memory.

use nalgebra::Vector3;

use crate::{
    model::{
        MotionGeometry, NumberFormat, decimals_in,
        robot::{
            ArmData, Component, Decimals, INCH_MM, Language, METRE_DECIMALS, METRE_MM, MotionKind, RobotError,
            RobotFault, Statement, Target,
        },
    },
    read::robot::{Follower, LocatedFault, Motion, RobotProgram, Tools, apt, krl, ls, rapid, urscript},
};

/// Line and byte at which a motion begins.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MotionLocation {
    /// Line, from 1.
    pub line: u32,
    /// Index of its first byte.
    pub start: usize,
    pub is_hole: bool,
}

/// Notes on a program for its reader.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RobotNotes {
    /// Lines, from 1, of motions whose end is unknown: they stay as they are.
    pub unlocated_lines: Vec<usize>,
    /// Name of the tool and its tip in the flange, mm, where the program gives them.
    pub tool_tip_mm: Option<(String, Vector3<f64>)>,
    /// Name of the tool, where neither the program nor the options give its rotation: that of the flange is taken.
    pub assumed_tool: Option<String>,
    /// Numbers, from 1, of external axes that stand somewhere and have no name, and where, mm or degrees.
    pub unnamed_axes: Vec<(usize, f64)>,
    /// Procedures with motions that nothing calls: they stay as they are.
    pub uncalled: Vec<String>,
    /// Whether some motion leads to a point declared elsewhere; corrected, it has its numbers in the motion.
    pub named_points: bool,
    /// Lines, from 1, of segments of splines (SPL): they lead through their points, on a path between them that is not known.
    pub spline_lines: Vec<usize>,
    /// The first line, from 1, that says something of the posture of the arm which acts.
    pub configured_line: Option<usize>,
    /// Lines, from 1, of motions from point to point, and of the first motion, at which nothing says which posture the arm takes.
    pub open_posture_lines: Vec<usize>,
    /// Whether data of the posture do not act on paths: `ConfL\\Off`, Wjnt, or qnear of a movel.
    pub leaves_paths_open: bool,
    /// Whether SLIN or SCIRC stand in blocks of SPLINE.
    pub lines_in_splines: bool,
    /// Numbers of lines of the program and of its expansion, if it was expanded.
    pub written_out: Option<[usize; 2]>,
}

impl RobotProgram {
    /// Passes each motion to `visit`, in order, and returns the notes. `Err` from `visit`, or for a statement that is not followed.
    pub(crate) fn walk<E: From<RobotError>>(
        &self,
        mut visit: impl FnMut(&Motion) -> Result<(), E>,
    ) -> Result<RobotNotes, E> {
        let mut reader = Reader::new(self);
        let mut follower = Follower::new(self.language, &self.options);
        let mut notes = RobotNotes::default();
        let located = |refusal: LocatedFault| self.locate(refusal);
        // A spline waits for the motion behind it.
        let mut waiting: Option<Motion> = None;
        while let Some(statement) = reader.next().map_err(located)? {
            let (line, at) = (statement.line, statement.at.clone());
            let motion = follower.follow(statement).map_err(|fault| located(LocatedFault { line, at, fault }))?;
            let is_spline = motion.statement.kind == MotionKind::Spline;
            if is_spline || motion.geometry == MotionGeometry::Unlocated {
                let expansion = self.expansion.as_ref();
                let line = expansion.map_or(line, |expansion| expansion.line_of(motion.statement.at.start));
                if is_spline { &mut notes.spline_lines } else { &mut notes.unlocated_lines }.push(line);
            }
            notes.lines_in_splines |=
                !is_spline && motion.statement.spline.is_some_and(|spline| spline.block.is_some());
            self.note_posture(&motion, &mut notes);
            notes.named_points |= self.targets(&motion.statement).any(|(_, is_named)| is_named);
            if let Some(mut spline) = waiting.take() {
                spline.set_spline_tangent(Some(&motion));
                visit(&spline)?;
            }
            if is_spline {
                waiting = Some(motion);
            } else {
                visit(&motion)?;
            }
        }
        if let Some(spline) = waiting {
            visit(&spline)?;
        }
        notes.tool_tip_mm = reader.tools().and_then(Tools::tip_mm);
        notes.uncalled = reader.left_out().to_vec();
        notes.unnamed_axes = follower.unnamed_axes().collect();
        notes.assumed_tool = reader.tools().and_then(Tools::assumed_rotation).map(str::to_owned);
        Ok(notes)
    }

    /// Adds to `notes` what `motion` says of the posture of the arm, or that it says nothing.
    fn note_posture(&self, motion: &Motion, notes: &mut RobotNotes) {
        let statement = &motion.statement;
        let Some(target) = statement.end.as_ref().filter(|_| self.language != Language::Apt && motion.end.is_some())
        else {
            return;
        };
        let line = self.expansion.as_ref().map_or(statement.line, |expansion| expansion.line_of(statement.at.start));
        let is_said = ArmData::of_target(self.language, target).is_some();
        notes.configured_line = notes.configured_line.or((is_said && !statement.is_posture_open).then_some(line));
        let is_free = statement.kind == MotionKind::PointToPoint || motion.start.is_none();
        if is_free && motion.arm.is_none() {
            notes.open_posture_lines.push(line);
        }
        notes.leaves_paths_open |= !is_free && is_said && statement.is_posture_open;
    }

    /// Walks through the program for the first time: sets its motions, decimals and notes.
    pub(crate) fn survey(&mut self) -> Result<(), RobotError> {
        let (mut motions, mut decimals) = (Vec::new(), [[0usize; 3]; 2]);
        let notes = self.walk(|motion| {
            let statement = &motion.statement;
            let unit_mm = statement.frames.unit_mm;
            // Decimals of metres are counted as those of millimetres.
            let shift = if unit_mm == METRE_MM { METRE_DECIMALS.into() } else { 0 };
            let decimals = &mut decimals[usize::from(unit_mm == INCH_MM)];
            for (target, _) in self.targets(statement) {
                for number in &target.numbers {
                    if let Component::Arm(_) = number.component {
                        continue;
                    }
                    let text = String::from_utf8_lossy(&target.text[number.at.clone()]);
                    let mantissa = text.split(['e', 'E']).next().unwrap_or_default();
                    let kind = match number.component {
                        Component::Position(_) | Component::Radius => 0,
                        Component::Rotation(_) => 1,
                        Component::External(_) | Component::Arm(_) => 2,
                    };
                    let shift = if kind == 0 { shift } else { 0 };
                    decimals[kind] = decimals_in(mantissa).saturating_sub(shift).max(decimals[kind]);
                }
            }
            let expansion = self.expansion.as_ref();
            let line = expansion.map_or(statement.line, |expansion| expansion.line_of(statement.at.start));
            motions.push(MotionLocation {
                line: u32::try_from(line).unwrap_or(u32::MAX),
                start: statement.at.start,
                is_hole: statement.apt.drilling.is_some(),
            });
            let (count, most) = (motions.len(), RobotProgram::MAX_POINTS);
            match count > most {
                true => Err(self.error_at(statement, RobotFault::TooManyMotions { count, most })),
                false => Ok(()),
            }
        })?;
        let most = |kind: usize| decimals[0][kind].max(decimals[1][kind]);
        (self.motions, self.notes) = (motions, notes);
        self.notes.written_out = self.expansion.as_ref().map(|expansion| expansion.lines);
        self.own_format = NumberFormat::of_source(decimals[0][0], decimals[1][0]);
        self.decimals = Decimals::of_source(self.language, most(1), most(2));
        Ok(())
    }

    /// Iterates over the targets of a statement, each with whether it is declared elsewhere.
    fn targets<'a>(&'a self, statement: &'a Statement) -> impl Iterator<Item = (&'a Target, bool)> {
        let is_named = |target: &Target| self.source.get(target.at.clone()) != Some(target.text.as_slice());
        statement.via.iter().chain(&statement.end).map(move |target| (target, is_named(target)))
    }

    /// Returns the error that `fault` is at `statement`.
    pub(crate) fn error_at(&self, statement: &Statement, fault: RobotFault) -> RobotError {
        self.locate(LocatedFault { line: statement.line, at: statement.at.clone(), fault })
    }
}

/// A reader of the program's language, from its first statement on.
#[derive(Debug)]
enum Reader<'a> {
    Krl(Box<krl::Reader<'a>>),
    Rapid(Box<rapid::Reader<'a>>),
    Ls(Box<ls::Reader<'a>>),
    UrScript(Box<urscript::Reader<'a>>),
    Apt(Box<apt::Reader<'a>>),
}

impl<'a> Reader<'a> {
    /// Starts at the first statement of `program`.
    pub fn new(program: &'a RobotProgram) -> Self {
        let (source, options) = (&program.source, &program.options);
        match program.language {
            Language::Krl => Reader::Krl(Box::new(krl::Reader::new(source, &program.beside, options))),
            Language::Rapid => Reader::Rapid(Box::new(rapid::Reader::new(source, options))),
            Language::Ls => {
                let system_frames = program.beside().map(|(_, bytes)| bytes).next();
                Reader::Ls(Box::new(ls::Reader::new(source, system_frames, options)))
            }
            Language::UrScript => Reader::UrScript(Box::new(urscript::Reader::new(source, options))),
            Language::Apt => Reader::Apt(Box::new(apt::Reader::new(source, options))),
        }
    }

    /// Returns the next statement that moves the tool; `None` at the end, `Err` for a statement that is not followed.
    pub fn next(&mut self) -> Result<Option<Statement>, LocatedFault> {
        match self {
            Reader::Krl(reader) => reader.next(),
            Reader::Rapid(reader) => reader.next(),
            Reader::Ls(reader) => reader.next(),
            Reader::UrScript(reader) => reader.next(),
            Reader::Apt(reader) => reader.next(),
        }
    }

    /// Returns the procedures with motions that nothing calls, so far.
    pub fn left_out(&self) -> &[String] {
        match self {
            Reader::Rapid(reader) => &reader.left_out,
            _ => &[],
        }
    }

    /// Returns the tools that motions used so far; `None` for a language that names none.
    pub fn tools(&self) -> Option<&Tools<'_>> {
        match self {
            Reader::Krl(reader) => Some(reader.tools()),
            Reader::Rapid(reader) => Some(reader.tools()),
            Reader::Ls(reader) => Some(reader.tools()),
            Reader::UrScript(reader) => Some(reader.tools()),
            Reader::Apt(_) => None,
        }
    }
}
