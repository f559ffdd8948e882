//! G-code programs, read and followed.

pub(crate) mod blocks;
pub(crate) mod cycle;
pub(crate) mod dialect;
pub(crate) mod follow;
pub(crate) mod interpret;
pub(crate) mod lex;
pub(crate) mod lines;
pub(crate) mod offsets;
pub(crate) mod request;
pub(crate) mod settings;
pub(crate) mod style;
pub(crate) mod turn;
pub(crate) mod walk;
pub(crate) mod written_out;

pub(crate) use {
    cycle::*, dialect::*, follow::*, interpret::*, offsets::*, request::*, settings::*, style::*, walk::*,
    written_out::*,
};

use crate::toolpath::{
    model::{
        NoPoints, NumberFormat, PathPoint, Sampler, Sampling, Toolpath,
        gcode::{Dialect, Fault, GcodeError, GcodeOptions, Motion, Notes, Refusal, RotaryColumn, rotary},
        program,
    },
    read::gcode::lines::Lines,
};

/// A program that has been read and followed. It is held as its bytes: what a line does is found anew whenever the program
/// is walked through.
#[derive(Clone, Debug)]
pub struct Program {
    pub(crate) name: String,
    pub(crate) options: GcodeOptions,
    pub(crate) dialect: Dialect,
    pub(crate) source: Vec<u8>,
    pub(crate) lines: Lines,
    /// Where its motions are, in order.
    pub(crate) motions: Vec<MotionAt>,
    /// Of each line that sets a centre of arcs, the first motion behind it that is an arc about it.
    pub(crate) arcs_of_poles: Vec<Option<usize>>,
    pub(crate) own_format: NumberFormat,
    /// How its author writes words.
    pub(crate) style: Style,
    pub(crate) notes: Notes,
    /// Of a program written out, where its lines come from.
    pub(crate) written_out: Option<WrittenOut>,
}

impl Program {
    /// The most points that may be asked for of the path of a program.
    pub const MAX_POINTS: usize = Sampling::MAX_PIECES;

    /// Reads and follows a program. `name` is its file name, for messages; `source` is its bytes: comments may be in
    /// any encoding, all else is ASCII.
    ///
    /// # Errors
    /// When the program has a word that cannot be followed, or a motion that cannot be.
    pub fn parse(source: impl Into<Vec<u8>>, name: &str, options: &GcodeOptions) -> Result<Program, GcodeError> {
        Program::parse_or_give_back(source.into(), name, options).map_err(|refused| refused.0)
    }

    /// As [`Program::parse`]; with the refusal come the bytes.
    pub(crate) fn parse_or_give_back(
        source: Vec<u8>,
        name: &str,
        options: &GcodeOptions,
    ) -> Result<Program, Box<(GcodeError, Vec<u8>)>> {
        let dialect = match dialect::chosen(&source, name, options.dialect) {
            Ok(dialect) => dialect,
            Err(refused) => return Err(Box::new((refused, source))),
        };
        let lines = Lines::of(&source);
        let mut program = Program {
            name: name.to_owned(),
            options: GcodeOptions { dialect: Some(dialect), ..options.clone() },
            dialect,
            source,
            lines,
            motions: Vec::new(),
            arcs_of_poles: Vec::new(),
            own_format: NumberFormat::default(),
            style: Style::plain(dialect),
            notes: Notes::default(),
            written_out: None,
        };
        match program.survey() {
            Ok(()) => Ok(program),
            Err(refused) => Err(Box::new((refused, program.source))),
        }
    }

    /// The program's name as given.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The program's bytes.
    #[must_use]
    pub fn source(&self) -> &[u8] {
        &self.source
    }

    /// The program's bytes, to keep.
    #[must_use]
    pub fn into_source(self) -> Vec<u8> {
        self.source
    }

    /// The bytes of its file: other ones than [`Program::source`] if it was written out.
    pub(crate) fn file_bytes(&self) -> &[u8] {
        self.written_out.as_ref().map_or(&self.source, WrittenOut::file_bytes)
    }

    /// The dialect it was read as, what was taken for granted, and which lines stay as they are.
    #[must_use]
    pub fn notes(&self) -> &Notes {
        &self.notes
    }

    /// Whether a motion is a hole of a cycle.
    #[must_use]
    pub fn is_hole(&self, segment: usize) -> bool {
        self.motions.get(segment).is_some_and(|motion| motion.is_hole)
    }

    /// How many motion blocks the program has; [`PointSource::segment`](crate::toolpath::PointSource) counts them.
    #[must_use]
    pub fn motion_count(&self) -> usize {
        self.motions.len()
    }

    /// The line, from 1, of a motion block.
    #[must_use]
    pub fn line_of(&self, segment: usize) -> Option<usize> {
        let line = self.motions.get(segment).map(|motion| motion.line);
        line.map(|line| self.written_out.as_ref().map_or(line, |written_out| written_out.line_of(line)))
    }

    /// The number of the file that a motion block stands in: 0 is the program's own, then come [`Program::called_files`].
    #[must_use]
    pub fn file_of(&self, segment: usize) -> usize {
        let line = self.motions.get(segment).map(|motion| motion.line);
        line.zip(self.written_out.as_ref()).map_or(0, |(line, written_out)| written_out.file_of(line))
    }

    /// The names of the files beside the program that it calls.
    pub fn called_files(&self) -> impl Iterator<Item = &str> {
        self.written_out.iter().flat_map(WrittenOut::called_files)
    }

    /// The bytes of the line of a motion block, without its ending.
    #[must_use]
    pub fn content_of(&self, segment: usize) -> Option<&[u8]> {
        self.motions.get(segment).map(|motion| self.content(motion.line - 1))
    }

    /// The decimals this program itself writes its coordinates with, at most; at least 3 for mm and 4 for inch.
    #[must_use]
    pub fn own_format(&self) -> NumberFormat {
        self.own_format
    }

    /// The path of the program in the workpiece frame: the ends of the pieces its motions are split into. The start
    /// of the program is no point of the path, for no word of the program leads there.
    ///
    /// # Errors
    /// When the path would have more than [`Sampling::MAX_POINTS`] points, or an arc leaves the range of coordinates.
    pub fn toolpath(&self, sampling: Sampling) -> Result<Toolpath, GcodeError> {
        self.toolpath_up_to(sampling, Sampling::MAX_POINTS)
    }

    /// As [`Program::toolpath`], of at most `most` points, up to [`Program::MAX_POINTS`].
    ///
    /// # Errors
    /// When the path would have more points, or an arc leaves the range of coordinates.
    pub fn toolpath_up_to(&self, sampling: Sampling, most: usize) -> Result<Toolpath, GcodeError> {
        let mut points = Vec::with_capacity(self.motions.len());
        let parameters = |_, motion: &Motion| Some(motion.parameters(motion.pieces(sampling, &self.options.rotary)?));
        self.sample(most, parameters, |point| points.push(*point))?;
        Ok(Toolpath::assemble(points).with_external_axes(&program::Program::external_axes(self)))
    }

    /// The rotary axes that its path tells where to stand.
    pub(crate) fn told(&self) -> &[RotaryColumn] {
        let columns = &self.options.rotary_columns;
        let is_told = self.notes.names_rotary || columns.iter().any(|column| column.is_given);
        if is_told { columns } else { &[] }
    }

    /// Whether its path says how the tool stands.
    #[cfg(not(target_family = "wasm"))]
    pub(crate) fn is_turned(&self) -> bool {
        !self.told().is_empty() || !self.turns_by_drives()
    }

    /// Whether all rotary axes, if there are any, are drives of the machine: how the tool stands is then theirs.
    fn turns_by_drives(&self) -> bool {
        self.options.rotary.axes.len() == self.options.rotary_columns.len()
    }

    /// The points of the path, at most `most`, those of each motion where `parameters` says; a tangent that is not known is
    /// zero.
    pub(crate) fn sample(
        &self,
        most: usize,
        mut parameters: impl FnMut(usize, &Motion) -> Option<Vec<f64>>,
        take: impl FnMut(&PathPoint),
    ) -> Result<(), GcodeError> {
        let mut sampler = Sampler::new(most, take);
        self.walk(|block| {
            for motion in &block.motions {
                let add = |segment, own: &[f64], length_mm, points: &mut Vec<PathPoint>| {
                    motion.sample(segment, own, length_mm, &self.options.rotary, points);
                    self.tell_drives(motion, points);
                };
                let done = sampler.motion(|segment| parameters(segment, motion), add);
                done.map_err(|why| {
                    self.refused(
                        motion,
                        match why {
                            NoPoints::TooMany => Fault::TooManyPoints { most },
                            NoPoints::TooFar => Fault::TooFar,
                        },
                    )
                })?;
            }
            Ok(())
        })?;
        Ok(())
    }

    /// Has the `points` of `motion` say where the drives stand that are rotary axes.
    fn tell_drives(&self, motion: &Motion, points: &mut [PathPoint]) {
        let (told, turns_by_drives) = (self.told(), self.turns_by_drives());
        for point in points {
            let angles = motion.turning.at(point.source.parameter);
            for (axis, stands) in told.iter().zip(&mut point.external) {
                *stands = angles[rotary::index(axis.letter)];
            }
            point.orientation = point.orientation.filter(|_| !turns_by_drives);
        }
    }

    pub(crate) fn refused(&self, motion: &Motion, fault: Fault) -> GcodeError {
        let (line, span) = (motion.line, motion.span.clone());
        let refused = Refusal::new(span, fault).locate(&self.name, line, self.content(line - 1));
        let refused = refused.read_as(self.dialect);
        self.written_out.as_ref().map_or(refused.clone(), |written_out| written_out.located(refused))
    }

    /// The bytes of line `index` (from 0), without its ending.
    pub(crate) fn content(&self, index: usize) -> &[u8] {
        &self.source[self.lines.content(index)]
    }
}

impl program::Program for Program {
    type Error = GcodeError;
    type Reading = (String, GcodeOptions);

    fn read_written(bytes: Vec<u8>, (name, options): &Self::Reading) -> Result<Self, GcodeError> {
        Program::parse(bytes, name, options)
    }

    fn points_at(
        &self,
        mut places: impl FnMut(usize) -> Option<Vec<f64>>,
        take: impl FnMut(&PathPoint),
    ) -> Result<(), GcodeError> {
        self.sample(Program::MAX_POINTS, |segment, _| places(segment), take)
    }

    fn external_axes(&self) -> Vec<String> {
        self.told().iter().map(|told| told.column.clone()).collect()
    }
}
