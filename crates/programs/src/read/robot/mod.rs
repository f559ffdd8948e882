//! Robot programs (KRL, RAPID, LS, URScript, APT): read, and followed motion by motion.

pub(crate) mod apt;
pub(crate) mod apt_circles;
pub(crate) mod apt_cycles;
pub(crate) mod expansion;
pub(crate) mod follow;
pub(crate) mod frames;
pub(crate) mod krl;
pub(crate) mod ls;
pub(crate) mod rapid;
pub(crate) mod scan;
pub(crate) mod source;
pub(crate) mod urscript;
pub(crate) mod walk;

pub(crate) use {expansion::*, follow::*, frames::*, source::*, walk::*};

use crate::model::{
    NumberFormat, PathPoint, Rewritable, SampleFault, Sampler, Sampling, Toolpath,
    robot::{Decimals, Language, RobotError, RobotFault, RobotOptions},
};

/// A robot program that has been read and followed.
#[derive(Clone, Debug)]
pub struct RobotProgram {
    pub(crate) name: String,
    pub(crate) language: Language,
    pub(crate) options: RobotOptions,
    pub(crate) source: Vec<u8>,
    /// Names and bytes of the files beside it that it needs: the `.dat` of a `.src` and `$config.dat`, or the `sysframe.va` of a `.ls`.
    pub(crate) beside: Vec<(String, Vec<u8>)>,
    /// Line and byte of each motion, in order.
    pub(crate) motions: Vec<MotionLocation>,
    pub(crate) own_format: NumberFormat,
    pub(crate) decimals: Decimals,
    pub(crate) notes: RobotNotes,
    /// Where its parts come from, if it was expanded.
    pub(crate) expansion: Option<RobotExpansion>,
}

impl RobotProgram {
    /// Most points that a path of the program may have.
    pub const MAX_POINTS: usize = Sampling::MAX_PIECES;

    /// Reads and follows a program. `name` is its file name, for messages; `beside` are names and bytes of the `.dat` of a KRL program and of
    /// `$config.dat`, or of the `sysframe.va` of a FANUC one.
    pub fn parse(
        source: impl Into<Vec<u8>>,
        name: &str,
        language: Language,
        beside: impl IntoIterator<Item = (String, Vec<u8>)>,
        options: &RobotOptions,
    ) -> Result<RobotProgram, RobotError> {
        RobotProgram::read(source.into(), name, language, beside.into_iter().collect(), options, None)
    }

    /// As [`RobotProgram::parse`]; `expansion` is what `source` was expanded from, to name lines of the program as posted, or `None` if it is that.
    pub(crate) fn read(
        source: Vec<u8>,
        name: &str,
        language: Language,
        beside: Vec<(String, Vec<u8>)>,
        options: &RobotOptions,
        expansion: Option<RobotExpansion>,
    ) -> Result<RobotProgram, RobotError> {
        let mut program = RobotProgram {
            name: name.to_owned(),
            language,
            options: options.clone(),
            source,
            beside,
            motions: Vec::new(),
            own_format: NumberFormat::default(),
            decimals: Decimals::default(),
            notes: RobotNotes::default(),
            expansion,
        };
        program.survey()?;
        Ok(program)
    }

    /// The program's name as given.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Language of the program.
    #[must_use]
    pub fn language(&self) -> Language {
        self.language
    }

    /// The program's bytes.
    #[must_use]
    pub fn source(&self) -> &[u8] {
        &self.source
    }

    /// Names and bytes of the `.dat` of a KRL program and of `$config.dat`, or of the `sysframe.va` of a FANUC one.
    pub fn beside(&self) -> impl Iterator<Item = (&str, &[u8])> {
        self.beside.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice()))
    }

    /// Notes for a reader: what was assumed, and motions that stay as they are.
    #[must_use]
    pub fn notes(&self) -> &RobotNotes {
        &self.notes
    }

    /// Whether the program says how the arm stands, and that is followed.
    #[must_use]
    pub fn says_postures(&self) -> bool {
        self.notes.configured_line.is_some() && !self.options.ignores_configuration
    }

    /// Number of motions; [`PointSource::segment`](crate::PointSource) is an index into them.
    #[must_use]
    pub fn motion_count(&self) -> usize {
        self.motions.len()
    }

    /// Line, from 1, on which motion `segment` begins; `None` if there is no such motion.
    #[must_use]
    pub fn line_of(&self, segment: usize) -> Option<usize> {
        self.motions.get(segment).map(|motion| motion.line as usize)
    }

    /// Whether motion `segment` is a hole of a drilling cycle.
    #[must_use]
    pub fn is_hole(&self, segment: usize) -> bool {
        self.motions.get(segment).is_some_and(|motion| motion.is_hole)
    }

    /// Returns the bytes of the line of motion `segment` from the motion on, without the line ending; `None` if there is no such motion.
    #[must_use]
    pub fn content_of(&self, segment: usize) -> Option<&[u8]> {
        let rest = &self.source[self.motions.get(segment)?.start..];
        let length = rest.iter().position(|byte| matches!(byte, b'\r' | b'\n')).unwrap_or(rest.len());
        Some(&rest[..length])
    }

    /// Most decimals of the positions in the program; at least 3 for mm and 4 for inch.
    #[must_use]
    pub fn own_format(&self) -> NumberFormat {
        self.own_format
    }

    /// Returns the path in the workpiece frame W: the ends of the pieces into which `sampling` splits the motions. `Err` if it would have
    /// more than [`Sampling::MAX_POINTS`] points, or a circle leaves the range of coordinates.
    pub fn toolpath(&self, sampling: Sampling) -> Result<Toolpath, RobotError> {
        self.toolpath_up_to(sampling, Sampling::MAX_POINTS)
    }

    /// Returns the path as [`RobotProgram::toolpath`] does, with at most `most` points (up to [`RobotProgram::MAX_POINTS`]), else `Err`.
    pub fn toolpath_up_to(&self, sampling: Sampling, most: usize) -> Result<Toolpath, RobotError> {
        let mut points = Vec::with_capacity(self.motions.len().min(most));
        let parameters = |_, motion: &Motion| Some(motion.parameters(motion.piece_count(sampling)?));
        self.sample(most, parameters, |point| points.push(*point))?;
        Ok(Toolpath::assemble(points).with_external_axes(&self.options.external_axes))
    }

    /// Passes the points of each motion at its `parameters` (0 to 1) to `take`, at most `most` in all; an unknown tangent is zero. Fails for more
    /// points, and where `parameters` returns `None`.
    pub(crate) fn sample(
        &self,
        most: usize,
        mut parameters: impl FnMut(usize, &Motion) -> Option<Vec<f64>>,
        take: impl FnMut(&PathPoint),
    ) -> Result<(), RobotError> {
        let mut sampler = Sampler::new(most, take);
        self.walk(|motion| {
            let add = |segment, parameters: &[f64], length_mm, points: &mut Vec<PathPoint>| {
                motion.sample(segment, parameters, length_mm, points);
            };
            let done = sampler.sample_motion(|segment| parameters(segment, motion), add);
            let fault = |why| match why {
                SampleFault::TooMany => RobotFault::TooManyPoints { most },
                SampleFault::TooFar => RobotFault::TooFar,
            };
            done.map_err(|why| self.error_at(&motion.statement, fault(why)))
        })?;
        Ok(())
    }
}

impl Rewritable for RobotProgram {
    type Error = RobotError;
    type Reading = (String, Language, Vec<(String, Vec<u8>)>, RobotOptions);

    /// Reads a written program with the name and options of the original.
    fn read_written(bytes: Vec<u8>, reading: &Self::Reading) -> Result<Self, RobotError> {
        let (name, language, beside, options) = reading;
        RobotProgram::parse(bytes, name, *language, beside.clone(), options)
    }

    /// Passes the points of each motion, at the parameters that `parameters` returns for its index, to `take`; fails where it returns `None`.
    fn points_at(
        &self,
        mut parameters: impl FnMut(usize) -> Option<Vec<f64>>,
        take: impl FnMut(&PathPoint),
    ) -> Result<(), RobotError> {
        self.sample(RobotProgram::MAX_POINTS, |segment, _| parameters(segment), take)
    }

    /// Returns the names of the external axes that the options give.
    fn external_axes(&self) -> Vec<String> {
        self.options.external_axes.clone()
    }
}
