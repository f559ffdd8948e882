//! A program in a file, whatever its format: read, followed, written back.

use std::path::Path;

use nalgebra::Vector3;

#[cfg(not(target_family = "wasm"))]
use crate::toolpath::{
    NumberFormat,
    robot::{Language, RobotProgram},
};
use crate::{
    input::{Folder, Inputs, error::Result},
    process::file::Process,
    simulation::blocks::{Blocks, BlocksBeforeAfter},
    toolpath::{
        self, Orientation, PathPoint, Sampling, Toolpath,
        gcode::{Beside, Calls, Expand, Fault, Program},
        polyline::Polyline,
    },
};

/// A program as it was read.
#[derive(Debug, Clone)]
pub enum ProgramFile {
    /// Points in a CSV file.
    Polyline(Polyline),
    /// A G-code program.
    Gcode(Box<Program>),
    /// A program of a robot, or an APT program. Pages get it as points.
    #[cfg(not(target_family = "wasm"))]
    Robot(Box<RobotProgram>),
}

impl ProgramFile {
    /// Reads `file`: a polyline if its name ends in `.csv`, a program of a robot or an APT program if [`Language::of`]
    /// knows its name, G-code otherwise, written out first where `process` says so. What it calls is sought beside it,
    /// and the `.dat` of a `.src`.
    ///
    /// # Errors
    /// A file that cannot be read or is not of the expected form.
    pub fn read(file: &Path, process: &Process) -> Result<Self> {
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        match file.parent() {
            Some(folder) if file.ends_with(&name) => Self::in_folder(&Folder::from(folder), &name, process),
            _ => Self::parse(crate::input::file::read(file)?, file, process),
        }
    }

    /// The same of the file called `name` in `folder`.
    ///
    /// # Errors
    /// As [`ProgramFile::read`].
    pub fn in_folder(folder: &Folder, name: &str, process: &Process) -> Result<Self> {
        let around = folder.of(name);
        let beside = |name: &str| around.has(name).then(|| around.bytes(name).ok()).flatten();
        let program = Self::parse_beside(folder.bytes(name)?, &folder.path(name), process, &beside)?;
        // Pages get it as it was written out.
        if let Some(written_out) = program.written_out() {
            folder.note(name, written_out);
        }
        #[cfg(not(target_family = "wasm"))]
        if folder.is_noting() && program.is_noted_as_points(process) {
            folder.note(name, &points_of(&program, process)?);
        }
        Ok(program)
    }

    /// The program that `bytes` of a `file` are, as [`ProgramFile::read`], with nothing beside it.
    ///
    /// # Errors
    /// Bytes that are not of the expected form.
    pub fn parse(bytes: Vec<u8>, file: &Path, process: &Process) -> Result<Self> {
        Self::parse_beside(bytes, file, process, &|_| None)
    }

    fn parse_beside(bytes: Vec<u8>, file: &Path, process: &Process, beside: &Beside<'_>) -> Result<Self> {
        let (name, options) = (file.display().to_string(), &process.gcode);
        if is_csv(file) || bytes.starts_with(POINTS) {
            return Ok(ProgramFile::Polyline(Polyline::read(bytes, &name)?));
        }
        #[cfg(not(target_family = "wasm"))]
        if let Some(language) = Language::of(file, &bytes) {
            let data = Self::data_beside(&file.file_name().unwrap_or_default().to_string_lossy());
            let found = if language == Language::Krl { beside(&data) } else { None };
            let found = found.map(|bytes| (data, bytes));
            let program = RobotProgram::parse(bytes, &name, language, found, &process.robot_program)?;
            check_tool(&program, process)?;
            return Ok(ProgramFile::Robot(Box::new(program)));
        }
        // What pages have was written out before.
        let expand = if cfg!(target_family = "wasm") { Expand::Never } else { options.expand };
        let program = match expand {
            Expand::Never => Program::parse(bytes, &name, options),
            Expand::Always => Program::parse_expanded(bytes, &name, options, beside),
            Expand::WhereNeeded => Program::parse_or_give_back(bytes, &name, options).or_else(|given_back| {
                let (refused, bytes) = *given_back;
                if !refused.fault.is_met_by_expanding() {
                    return Err(refused);
                }
                let written_out = Program::parse_with_calls(bytes, &name, options, beside);
                written_out.map_err(|fault| if fault.fault == Fault::NotWrittenOut { refused } else { fault })
            }),
        };
        Ok(ProgramFile::Gcode(Box::new(program?)))
    }

    /// Whether pages, which do not follow it, get its points: all of it that counts is then in them.
    #[cfg(not(target_family = "wasm"))]
    fn is_noted_as_points(&self, process: &Process) -> bool {
        match self {
            ProgramFile::Polyline(_) => false,
            ProgramFile::Gcode(program) => {
                program.is_turned() && !process.gcode.rotary.is_empty() && process.own_forces.is_empty()
            }
            ProgramFile::Robot(_) => true,
        }
    }

    /// What results along it depend on: its file, called `name`, and what it was written out as, for what it calls beside it counts.
    pub fn inputs(&self, name: &str) -> Inputs {
        let bytes = match self {
            ProgramFile::Polyline(polyline) => polyline.source(),
            ProgramFile::Gcode(program) => program.file_bytes(),
            #[cfg(not(target_family = "wasm"))]
            ProgramFile::Robot(program) => program.source(),
        };
        let texts = [(name, Some(bytes)), (name, self.written_out())];
        let texts = texts.into_iter().filter_map(|(name, bytes)| Some((name, bytes?))).chain(self.beside());
        let inputs = texts.map(|(name, bytes)| Inputs::of(name, String::from_utf8_lossy(bytes)));
        inputs.fold(Inputs::default(), Inputs::and)
    }

    /// The program written out, if it was.
    fn written_out(&self) -> Option<&[u8]> {
        match self {
            ProgramFile::Gcode(program) if program.notes().written_out.is_some() => Some(program.source()),
            _ => None,
        }
    }

    /// The name of the `.dat` that the file called `name` has beside it if it is a KRL program.
    pub(crate) fn data_beside(name: &str) -> String {
        Path::new(name).with_extension("dat").to_string_lossy().into_owned()
    }

    /// Name and bytes of the `.dat` beside it, if it is a KRL program and has one.
    pub(crate) fn beside(&self) -> Option<(&str, &[u8])> {
        match self {
            #[cfg(not(target_family = "wasm"))]
            ProgramFile::Robot(program) => program.beside(),
            _ => None,
        }
    }

    /// Its points in the workpiece frame; lines and arcs are split as `sampling` says.
    ///
    /// # Errors
    /// Too many points, or a program that cannot be followed.
    pub fn toolpath(&self, sampling: Sampling) -> Result<Toolpath> {
        match self {
            ProgramFile::Polyline(polyline) => Ok(polyline.sampled(sampling)?),
            ProgramFile::Gcode(program) => Ok(program.toolpath(sampling)?),
            #[cfg(not(target_family = "wasm"))]
            ProgramFile::Robot(program) => Ok(program.toolpath(sampling)?),
        }
    }

    /// As [`ProgramFile::toolpath`], of a program that may have [`Program::MAX_POINTS`] points.
    ///
    /// # Errors
    /// As [`ProgramFile::toolpath`].
    pub fn long_toolpath(&self, sampling: Sampling) -> Result<Toolpath> {
        match self {
            ProgramFile::Polyline(_) => self.toolpath(sampling),
            ProgramFile::Gcode(program) => Ok(program.toolpath_up_to(sampling, Program::MAX_POINTS)?),
            #[cfg(not(target_family = "wasm"))]
            ProgramFile::Robot(program) => Ok(program.toolpath_up_to(sampling, Program::MAX_POINTS)?),
        }
    }

    /// Line of the file that a point's move stands in, from 1, where it is known.
    pub fn line_of(&self, segment: usize) -> Option<usize> {
        match self {
            ProgramFile::Polyline(polyline) => polyline.line_of(segment),
            ProgramFile::Gcode(program) => program.line_of(segment),
            #[cfg(not(target_family = "wasm"))]
            ProgramFile::Robot(program) => program.line_of(segment),
        }
    }

    /// The number of the file that this line is in: 0 is the program's own, then come [`ProgramFile::called_files`].
    pub fn file_of(&self, segment: usize) -> usize {
        match self {
            ProgramFile::Polyline(_) => 0,
            ProgramFile::Gcode(program) => program.file_of(segment),
            #[cfg(not(target_family = "wasm"))]
            ProgramFile::Robot(_) => 0,
        }
    }

    /// The names of the files beside the program that it calls.
    pub fn called_files(&self) -> Vec<String> {
        match self {
            ProgramFile::Polyline(_) => Vec::new(),
            ProgramFile::Gcode(program) => program.called_files().map(String::from).collect(),
            #[cfg(not(target_family = "wasm"))]
            ProgramFile::Robot(_) => Vec::new(),
        }
    }

    /// The line in words: "line 7", or "O100.nc line 7" of a file that the program calls.
    pub fn place_of(&self, segment: usize) -> Option<String> {
        let line = self.line_of(segment)?;
        Some(place_in_words(&self.called_files(), self.file_of(segment), line))
    }

    /// Whether a point's move is a hole of a cycle.
    pub fn is_hole(&self, segment: usize) -> bool {
        match self {
            ProgramFile::Gcode(program) => program.is_hole(segment),
            _ => false,
        }
    }

    /// What stands in that line; a byte that is no letter of UTF-8 is shown as such.
    pub fn text_of(&self, segment: usize) -> Option<String> {
        let bytes = match self {
            ProgramFile::Polyline(polyline) => polyline.content_of(segment)?,
            ProgramFile::Gcode(program) => program.content_of(segment)?,
            #[cfg(not(target_family = "wasm"))]
            ProgramFile::Robot(program) => program.content_of(segment)?,
        };
        Some(String::from_utf8_lossy(bytes).trim().to_string())
    }

    /// The same program through `positions` (workpiece frame, mm, one per point of `path`), the tool turned to `orientations` if they
    /// are given, written as `process` says, and what reading it gives.
    ///
    /// # Errors
    /// Positions that are no positions, or a written program that does not read back.
    pub fn rewritten(
        &self,
        path: &Toolpath,
        positions: &[Vector3<f64>],
        orientations: Option<&[Orientation]>,
        process: &Process,
    ) -> Result<Rewritten> {
        let is_turned = orientations.is_some();
        match self {
            ProgramFile::Polyline(polyline) => {
                let format = process.decimals.format(polyline.own_format())?;
                let rewritten = polyline.rewrite_turned(path, positions, orientations, format)?;
                let back = Sent::back(&rewritten, &rewritten.read()?, path.len(), is_turned)?;
                Ok(Rewritten { bytes: rewritten.into_bytes(), back, blocks: None, calls: None })
            }
            ProgramFile::Gcode(program) => {
                let writing = process.writing(program.own_format())?;
                let mut rewritten = program.rewrite_turned(path, positions, orientations, writing)?;
                let calls = program.calls_of(&rewritten);
                let written = rewritten.take_and_read()?;
                let back = Sent::back(&rewritten, &written, path.len(), is_turned)?;
                drop(rewritten);
                let blocks = BlocksBeforeAfter { before: Blocks::of(program)?, after: Blocks::of(&written)? };
                Ok(Rewritten { bytes: written.into_source(), back, blocks: Some(blocks), calls })
            }
            #[cfg(not(target_family = "wasm"))]
            ProgramFile::Robot(program) => {
                let writing = process.writing(program.own_format())?;
                let rewritten = program.rewrite(path, positions, orientations, writing)?;
                let back = Sent::back(&rewritten, &rewritten.read()?, path.len(), is_turned)?;
                Ok(Rewritten { bytes: rewritten.into_bytes(), back, blocks: None, calls: None })
            }
        }
    }
}

/// Where a program sends the tool, point after point.
#[derive(Debug, Clone)]
pub struct Sent {
    /// Positions in the workpiece frame, mm.
    pub positions: Vec<Vector3<f64>>,
    /// How the tool stands, if that is corrected.
    pub orientations: Option<Vec<Orientation>>,
}

impl Sent {
    /// None of so many points; `is_turned`: with orientations.
    pub(crate) fn new(points: usize, is_turned: bool) -> Self {
        Self { positions: Vec::with_capacity(points), orientations: is_turned.then(|| Vec::with_capacity(points)) }
    }

    /// Where `written`, as it was read, passes the `points` of the path.
    fn back<P: toolpath::Program>(
        rewritten: &toolpath::Rewritten<P>,
        written: &P,
        points: usize,
        is_turned: bool,
    ) -> std::result::Result<Self, P::Error> {
        let mut sent = Self::new(points, is_turned);
        rewritten.each_of(written, |point| sent.add(point))?;
        Ok(sent)
    }

    /// Adds where `point` is and how the tool stands there.
    pub(crate) fn add(&mut self, point: &PathPoint) {
        self.positions.push(point.position_mm);
        if let (Some(orientations), Some(orientation)) = (&mut self.orientations, point.orientation) {
            orientations.push(orientation);
        }
    }
}

/// A program that has been written and read.
#[derive(Debug, Clone)]
pub struct Rewritten {
    /// Its bytes.
    pub bytes: Vec<u8>,
    /// Where it passes each point, rounding included.
    pub back: Sent,
    /// What its blocks and those of the program as it was ask of a control; `None` for all but G-code.
    pub blocks: Option<BlocksBeforeAfter>,
    /// What becomes of its calls, if it has any; `bytes` are written out.
    pub calls: Option<Calls>,
}

/// `line` of the file of this number, where the files that a program calls are `called`.
pub(crate) fn place_in_words(called: &[String], file: usize, line: usize) -> String {
    match file.checked_sub(1).and_then(|file| called.get(file)) {
        Some(file) => format!("{file} line {line}"),
        None => format!("line {line}"),
    }
}

fn is_csv(file: &Path) -> bool {
    file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("csv"))
}

/// How the points begin that stand for a program of a robot in what pages have.
const POINTS: &[u8] = b"x_mm,y_mm,z_mm";

/// Tips that differ by less are the same, mm.
#[cfg(not(target_family = "wasm"))]
const SAME_TIP_MM: f64 = 0.01;

/// A tool that `program` defines must be that of the machine.
#[cfg(not(target_family = "wasm"))]
fn check_tool(program: &RobotProgram, process: &Process) -> Result<()> {
    let Some((tool, tip)) = &program.notes().tool_tip_mm else { return Ok(()) };
    let own = process.machine.tool_tip;
    if (tip - own).amax() <= SAME_TIP_MM {
        return Ok(());
    }
    let [[x, y, z], [u, v, w]] = [<[f64; 3]>::from(*tip), own.into()];
    let problem = format!(
        "tool {tool} has its tip at ({x}, {y}, {z}) mm of the flange, machine {} at ({u}, {v}, {w}) mm (platform.tool_tip_mm, or \
         tip_mm of [tool] in the process): expected the same",
        process.machine.name
    );
    Err(crate::input::error::Error::Argument { argument: program.name().into(), problem })
}

/// The points of the path of a program as a polyline.
#[cfg(not(target_family = "wasm"))]
fn points_of(program: &ProgramFile, process: &Process) -> Result<Vec<u8>> {
    let path = program.toolpath(process.sampling)?;
    let decimals = NumberFormat::new(NumberFormat::MAX_DECIMALS, NumberFormat::default().inch_decimals())?;
    // A column is there if all points have it; where nothing is cut, the feed does not matter.
    let feed = path.points().iter().find_map(|point| point.feed_mm_per_min);
    let with_feed = path.points().iter().map(|point| PathPoint {
        feed_mm_per_min: point.feed_mm_per_min.or(feed.filter(|_| !point.cutting)),
        ..*point
    });
    let path = Toolpath::assemble(with_feed.collect()).with_external_axes(path.external_axes());
    Ok(crate::toolpath::polyline::write(&path, &path.positions_mm(), decimals)?)
}
