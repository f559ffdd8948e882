//! G-code programs: read, and followed motion by motion.

pub(crate) mod blocks;
pub(crate) mod cycle;
pub(crate) mod dialect;
pub(crate) mod follow;
pub(crate) mod incline;
pub(crate) mod interpret;
pub(crate) mod lex;
pub(crate) mod lines;
pub(crate) mod offsets;
pub(crate) mod request;
pub(crate) mod settings;
pub(crate) mod style;
pub(crate) mod tool_comments;
pub(crate) mod turn;
pub(crate) mod walk;
pub(crate) mod written_out;

pub(crate) use {
    cycle::*, dialect::*, follow::*, interpret::*, offsets::*, request::*, settings::*, style::*, walk::*,
    written_out::*,
};

use crate::{
    model::{
        NumberFormat, PathPoint, Rewritable, SampleFault, Sampler, Sampling, Toolpath,
        gcode::{Dialect, Fault, GcodeError, GcodeOptions, LengthUnit, Motion, Notes, Refusal, RotaryColumn, rotary},
    },
    read::gcode::lines::Lines,
};

/// A G-code program that has been read and followed. It is held as its bytes: each walk through it reads the lines anew.
#[derive(Clone, Debug)]
pub struct GcodeProgram {
    pub(crate) name: String,
    pub(crate) options: GcodeOptions,
    pub(crate) dialect: Dialect,
    pub(crate) source: Vec<u8>,
    pub(crate) lines: Lines,
    /// Line of each motion, in order.
    pub(crate) motions: Vec<MotionLocation>,
    /// For each line that sets a centre of arcs (CC), the index of the first motion that is an arc about it.
    pub(crate) pole_arcs: Vec<Option<usize>>,
    pub(crate) own_format: NumberFormat,
    /// How its author writes words.
    pub(crate) style: Style,
    pub(crate) notes: Notes,
    /// Where its lines come from, if it was expanded.
    pub(crate) expansion: Option<Expansion>,
}

impl GcodeProgram {
    /// Most points that a path of the program may have.
    pub const MAX_POINTS: usize = Sampling::MAX_PIECES;

    /// Reads and follows a program. `name` is its file name, for messages; in `source`, comments may have any encoding, all else is ASCII.
    /// `Err` for a word or motion that cannot be followed.
    pub fn parse(source: impl Into<Vec<u8>>, name: &str, options: &GcodeOptions) -> Result<GcodeProgram, GcodeError> {
        GcodeProgram::parse_or_give_back(source.into(), name, options).map_err(|refused| refused.0)
    }

    /// Reads a program as [`GcodeProgram::parse`] does; an error comes with the bytes.
    pub(crate) fn parse_or_give_back(
        source: Vec<u8>,
        name: &str,
        options: &GcodeOptions,
    ) -> Result<GcodeProgram, Box<(GcodeError, Vec<u8>)>> {
        let dialect = match dialect::resolve_dialect(&source, name, options.dialect) {
            Ok(dialect) => dialect,
            Err(refused) => return Err(Box::new((refused, source))),
        };
        let lines = Lines::split(&source);
        if lines.len() > GcodeProgram::MAX_POINTS {
            let fault = Fault::TooMany { what: "lines", count: lines.len(), most: GcodeProgram::MAX_POINTS };
            return Err(Box::new((Refusal::new(0..0, fault).locate(name, 1, b"").with_dialect(dialect), source)));
        }
        let mut program = GcodeProgram {
            name: name.to_owned(),
            options: GcodeOptions { dialect: Some(dialect), ..options.clone() },
            dialect,
            source,
            lines,
            motions: Vec::new(),
            pole_arcs: Vec::new(),
            own_format: NumberFormat::default(),
            style: Style::plain(dialect),
            notes: Notes::default(),
            expansion: None,
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

    /// Takes the program's bytes.
    #[must_use]
    pub fn into_source(self) -> Vec<u8> {
        self.source
    }

    /// Bytes of its file, which differ from [`GcodeProgram::source`] if it was expanded.
    pub fn file_bytes(&self) -> &[u8] {
        self.expansion.as_ref().map_or(&self.source, Expansion::file_bytes)
    }

    /// Notes for a reader: dialect, assumptions, and lines that stay as they are.
    #[must_use]
    pub fn notes(&self) -> &Notes {
        &self.notes
    }

    /// Whether motion `segment` is a hole of a cycle.
    #[must_use]
    pub fn is_hole(&self, segment: usize) -> bool {
        self.motions.get(segment).is_some_and(|motion| motion.is_hole)
    }

    /// Number of motions; [`PointSource::segment`](crate::PointSource) is an index into them.
    #[must_use]
    pub fn motion_count(&self) -> usize {
        self.motions.len()
    }

    /// Line, from 1, of motion `segment` in the file it comes from; `None` if there is no such motion.
    #[must_use]
    pub fn line_of(&self, segment: usize) -> Option<usize> {
        let line = self.motions.get(segment).map(|motion| motion.line);
        line.map(|line| self.expansion.as_ref().map_or(line, |expansion| expansion.line_of(line)))
    }

    /// Number of the file that motion `segment` comes from: 0 is the program's own, then come [`GcodeProgram::called_files`].
    #[must_use]
    pub fn file_of(&self, segment: usize) -> usize {
        let line = self.motions.get(segment).map(|motion| motion.line);
        line.zip(self.expansion.as_ref()).map_or(0, |(line, expansion)| expansion.file_of(line))
    }

    /// Names of the files beside the program that it calls.
    pub fn called_files(&self) -> impl Iterator<Item = &str> {
        self.expansion.iter().flat_map(Expansion::called_files)
    }

    /// Bytes of the line of motion `segment`, without its ending; `None` if there is no such motion.
    #[must_use]
    pub fn content_of(&self, segment: usize) -> Option<&[u8]> {
        self.motions.get(segment).map(|motion| self.content(motion.line - 1))
    }

    /// Most decimals of the coordinates in the program; at least 3 for mm and 4 for inch.
    #[must_use]
    pub fn own_format(&self) -> NumberFormat {
        self.own_format
    }

    /// Returns the path in the workpiece frame W: the ends of the pieces into which `sampling` splits the motions, without the program's
    /// start. `Err` if it would have more than [`Sampling::MAX_POINTS`] points, or an arc leaves the range of coordinates.
    pub fn toolpath(&self, sampling: Sampling) -> Result<Toolpath, GcodeError> {
        self.toolpath_up_to(sampling, Sampling::MAX_POINTS)
    }

    /// Returns the path as [`GcodeProgram::toolpath`] does, with at most `most` points (up to [`GcodeProgram::MAX_POINTS`]); `Err` if it has more.
    pub fn toolpath_up_to(&self, sampling: Sampling, most: usize) -> Result<Toolpath, GcodeError> {
        let mut points = Vec::with_capacity(self.motions.len().min(most));
        // Of moves in mm and in inches, whether there are any.
        let mut units = [false; 2];
        let parameters = |_, motion: &Motion| {
            units[usize::from(motion.modal.unit == LengthUnit::Inch)] = true;
            Some(motion.parameters(motion.pieces(sampling, &self.options.rotary)?))
        };
        self.sample(most, parameters, |point| points.push(*point))?;
        let led = self.rotary_columns(true).iter().map(|axis| axis.column.clone()).collect();
        let path = Toolpath::assemble(points).with_external_axes(&Rewritable::external_axes(self)).with_led_axes(led);
        if cfg!(target_family = "wasm") || !self.options.tool_comments {
            return Ok(path);
        }
        let unit = match units {
            [_, false] => Some(LengthUnit::Millimetre),
            [false, true] => Some(LengthUnit::Inch),
            // Comments do not say in which they are.
            [true, true] => None,
        };
        Ok(path.with_tools(tool_comments::tool_comments(self.file_bytes(), unit)))
    }

    /// Returns the rotary drives whose positions the path commands; none if the program names no rotary axis.
    pub fn commanded_rotary(&self) -> &[RotaryColumn] {
        let columns = self.rotary_columns(false);
        let is_given = self.notes.names_rotary_axes || columns.iter().any(|column| column.is_given);
        if is_given { columns } else { &[] }
    }

    /// Returns the rotary drives that the path leads, or else those that it commands where it commands any.
    fn rotary_columns(&self, is_led: bool) -> &[RotaryColumn] {
        let columns = &self.options.rotary_columns;
        let (commanded, led) = columns.split_at(columns.partition_point(|column| !column.is_led));
        if is_led { led } else { commanded }
    }

    /// Whether the path commands rotary drives or orientations of the tool.
    pub fn has_orientations(&self) -> bool {
        !self.commanded_rotary().is_empty() || !self.has_only_drive_axes()
    }

    /// Whether all rotary axes, if any, are drives of the machine, so that points need no orientation.
    fn has_only_drive_axes(&self) -> bool {
        self.options.rotary.axes.len() == self.rotary_columns(false).len()
    }

    /// Passes the points of each motion at its `parameters` (0 to 1) to `take`, at most `most` in all; an unknown tangent is zero. Fails for more
    /// points, and where `parameters` returns `None`.
    pub(crate) fn sample(
        &self,
        most: usize,
        mut parameters: impl FnMut(usize, &Motion) -> Option<Vec<f64>>,
        take: impl FnMut(&PathPoint),
    ) -> Result<(), GcodeError> {
        let mut sampler = Sampler::new(most, take);
        self.walk(|block| {
            for motion in &block.motions {
                let add = |segment, parameters: &[f64], length_mm, points: &mut Vec<PathPoint>| {
                    motion.sample(segment, parameters, length_mm, &self.options.rotary, points);
                    self.set_external_axes(motion, points);
                };
                let done = sampler.sample_motion(|segment| parameters(segment, motion), add);
                let fault = |why| match why {
                    SampleFault::TooMany => Fault::TooManyPoints { most },
                    SampleFault::TooFar => Fault::TooFar,
                };
                done.map_err(|why| self.error_at(motion, fault(why)))?;
            }
            Ok(())
        })?;
        Ok(())
    }

    /// Sets the positions of rotary drives (degrees) in the `points` of `motion`, and drops orientations if all axes are drives.
    fn set_external_axes(&self, motion: &Motion, points: &mut [PathPoint]) {
        let (axes, has_only_drive_axes) = (self.commanded_rotary(), self.has_only_drive_axes());
        let led = self.rotary_columns(true);
        for point in points {
            let angles = motion.turning.at(point.source.parameter);
            for (axis, position) in axes.iter().chain(led).zip(&mut point.external) {
                *position = angles[rotary::axis_index(axis.letter)];
            }
            point.orientation = point.orientation.filter(|_| !has_only_drive_axes);
        }
    }

    /// Returns the error that `fault` is at `motion`, in the file that its line comes from.
    pub(crate) fn error_at(&self, motion: &Motion, fault: Fault) -> GcodeError {
        self.refused(motion.line, Refusal::new(motion.span.clone(), fault))
    }

    /// Returns the error that `refusal` is on line `line` (from 1), in the file that it comes from.
    pub(crate) fn refused(&self, line: usize, refusal: Refusal) -> GcodeError {
        let refused = refusal.locate(&self.name, line, self.content(line - 1));
        let refused = refused.with_dialect(self.dialect);
        self.expansion.as_ref().map_or(refused.clone(), |expansion| expansion.relocate(refused))
    }

    /// Returns the bytes of line `index` (from 0), without its ending.
    pub(crate) fn content(&self, index: usize) -> &[u8] {
        &self.source[self.lines.content(index)]
    }
}

impl Rewritable for GcodeProgram {
    type Error = GcodeError;
    type Reading = (String, GcodeOptions);

    /// Reads a written program with the name and options of the original.
    fn read_written(bytes: Vec<u8>, (name, options): &Self::Reading) -> Result<Self, GcodeError> {
        GcodeProgram::parse(bytes, name, options)
    }

    /// Passes the points of each motion, at the parameters that `parameters` returns for its index, to `take`; fails where it returns `None`.
    fn points_at(
        &self,
        mut parameters: impl FnMut(usize) -> Option<Vec<f64>>,
        take: impl FnMut(&PathPoint),
    ) -> Result<(), GcodeError> {
        self.sample(GcodeProgram::MAX_POINTS, |segment, _| parameters(segment), take)
    }

    /// Returns the path columns of the rotary drives that the program commands.
    fn external_axes(&self) -> Vec<String> {
        self.commanded_rotary().iter().map(|axis| axis.column.clone()).collect()
    }
}
