//! A process file, checked: where the workpiece stands, what force the cut makes, what the real machine differs by and
//! what compensation may do.

pub mod chain_errors;
mod force;
pub(crate) mod force_spec;
mod resolve;
#[cfg(not(target_family = "wasm"))]
mod robot;
#[cfg(not(target_family = "wasm"))]
mod rotary;
pub(crate) mod spec;
mod tool_force;
#[cfg(not(target_family = "wasm"))]
mod redundancy;

use crate::{
    compensation::{ErrorNorm, Target},
    input::{
        Folder, Inputs,
        check::Check,
        error::{Error, Result},
    },
    machine::{ChainError, Machine},
    process::{
        CuttingRule, PathReference, Placement,
        cutting::{CuttingLaw, LoadError, OwnForces, PathLoad},
        file::spec::ProcessSpec,
        not_followed::not_followed,
    },
    toolpath::{
        FormatError, NumberFormat, PathPoint, Sampling, Toolpath,
        gcode::{GcodeOptions, Writing},
    },
};

/// A checked process for one machine.
#[derive(Debug, Clone)]
pub struct Process {
    /// The machine it is for, with the tool of the process.
    pub machine: Machine,
    /// Whether the tool is another than the machine file's.
    pub has_own_tool: bool,
    /// How far the tool may be from where it should be, mm, if the file says it.
    pub tolerance_mm: Option<f64>,
    /// Where the workpiece stands, and whose positions the path gives.
    pub placement: Placement,
    /// Whether the file gives the origin of the workpiece; if not, it is that of the base frame.
    pub is_placed: bool,
    /// The cutting force along the path, where tool and feature have none of their own.
    pub cutting: CuttingLaw,
    /// Cutting forces of single tools and features.
    pub own_forces: OwnForces,
    /// Which moves cut.
    pub cutting_rule: CuttingRule,
    /// Errors of each chain of the machine, in its order.
    pub errors: Vec<ChainError>,
    /// How finely arcs and long lines of a program are split.
    pub sampling: Sampling,
    /// What bounds the corrections.
    pub limits: CorrectionLimits,
    /// What compensation puts right.
    pub target: Target,
    /// Along a program, the length behind a corner over which the cutting force goes over from one move to the next, mm; at 0 it
    /// jumps.
    pub corner_mm: f64,
    /// How the turn about the tool's axis is chosen. Pages are small, and have no threads to seek it on.
    #[cfg(not(target_family = "wasm"))]
    pub redundancy: crate::process::RedundancySettings,
    /// What a G-code program does not say itself.
    pub gcode: GcodeOptions,
    /// What a program of a robot or an APT program does not say itself.
    #[cfg(not(target_family = "wasm"))]
    pub robot_program: crate::toolpath::robot::RobotOptions,
    /// How written coordinates are rounded.
    pub decimals: Decimals,
    /// How far from corrected points the arcs and lines may pass that a block of G-code is written as, mm.
    pub write_tolerance_mm: f64,
    /// Whether a flat arc may be written as a helical one.
    pub helical_arcs: bool,
    /// Tables that only a toolpath has a use for and that say something.
    pub of_paths: Vec<&'static str>,
    /// What its keys begin with in the file that they stand in: nothing in a process file, `process.` in a study.
    pub key_prefix: &'static str,
    /// What decides it.
    pub inputs: Inputs,
}

/// Keys that have another name now, in process files and in studies.
pub(crate) const RENAMED: [(&str, &str); 3] =
    [("tool_turn", "redundancy"), ("process.tool_turn", "process.redundancy"), ("redundancy.redundancy", "gamma")];

/// How far the tool may be from its path if neither its process nor a command says it, mm.
pub const TOLERANCE_MM: f64 = 0.1;

/// How far from corrected points a program may be written if neither its process nor its tolerance asks for less, mm: five units of
/// the last decimal that programs usually have.
pub const WRITE_TOLERANCE_MM: f64 = 0.005;

/// The length behind a corner over which the cutting force turns, if a process does not give it, mm: about twice of what the
/// machines here deflect by at most, so that a corrected program does not step back there.
pub const CORNER_MM: f64 = 2.0;

/// Label of what a machine does not control.
pub const NOT_CONTROLLED: &str = "not controlled by this machine";

/// Limits of corrections and drive forces; `None` is no limit.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[allow(non_snake_case, reason = "the unit is N, not n")]
pub struct CorrectionLimits {
    /// Most |Δρ| of a drive, mm.
    pub correction_mm: Option<f64>,
    /// Most change of Δρ of a drive between neighbouring points, mm.
    pub correction_change_mm: Option<f64>,
    /// Most force of a drive, N.
    pub force_N: Option<f64>,
    /// What is made small where limits bind.
    pub objective: ErrorNorm,
}

impl CorrectionLimits {
    /// Whether any limit is given.
    pub fn is_limited(&self) -> bool {
        self.correction_mm.is_some() || self.correction_change_mm.is_some() || self.force_N.is_some()
    }
}

/// Decimals of written coordinates; `None` leaves those of the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Decimals {
    /// Of coordinates in mm.
    pub mm: Option<u8>,
    /// Of coordinates in inches.
    pub inch: Option<u8>,
}

impl Decimals {
    /// The format to write a program or polyline with whose own format is `own`.
    ///
    /// # Errors
    /// When there are no such decimals; never for those of a checked [`Process`].
    pub fn format(self, own: NumberFormat) -> std::result::Result<NumberFormat, FormatError> {
        NumberFormat::new(self.mm.unwrap_or(own.mm_decimals()), self.inch.unwrap_or(own.inch_decimals()))
    }
}

impl Process {
    /// How a program is written whose own decimals are `own`.
    ///
    /// # Errors
    /// As [`Decimals::format`].
    pub fn writing(&self, own: NumberFormat) -> std::result::Result<Writing, FormatError> {
        let helical_arcs = self.helical_arcs;
        Ok(Writing { helical_arcs, ..Writing::within(self.write_tolerance_mm, self.decimals.format(own)?) })
    }

    /// `path` with what cuts marked as the file says; `origin` names the path in errors.
    ///
    /// # Errors
    /// Nothing of a path with moves that may cut does, or the path turns the tool as the machine cannot.
    pub fn with_cuts(&self, path: Toolpath, origin: &str) -> Result<Toolpath> {
        if let Some((point, why)) = not_followed(&self.machine, &self.placement, &path) {
            let problem = format!("move {} {why}", point.source.segment + 1);
            return Err(Error::Argument { argument: origin.into(), problem });
        }
        let cuts = |path: &Toolpath| path.points().iter().any(|point| point.cutting);
        let feeds = path.points().iter().any(|point| point.cutting && point.feed_mm_per_min.is_some());
        if self.cutting_rule.max_feed_mm_per_min.is_some() && cuts(&path) && !feeds {
            let problem =
                format!("{origin} has no feeds to hold against it: leave it out, or use below_z_mm or above_z_mm");
            return Err(Error::Argument {
                argument: format!("{}cutting.max_feed_mm_per_min", self.key_prefix),
                problem,
            });
        }
        let (may_cut, path) = (cuts(&path), self.cutting_rule.apply(path));
        if may_cut && !cuts(&path) {
            let problem = format!("nothing of {origin} is cut: what cuts is {}", self.cutting_rule.words());
            return Err(Error::Argument { argument: format!("{}cutting", self.key_prefix), problem });
        }
        Ok(path)
    }

    /// The load at every point of `path`, in order.
    ///
    /// # Errors
    /// As [`OwnForces::check`] and [`CuttingLaw::load`].
    pub fn loads(&self, path: &Toolpath) -> std::result::Result<Vec<PathLoad>, LoadError> {
        self.own_forces.check(&self.cutting, path)?;
        path.points().iter().map(|point| self.load(point)).collect()
    }

    /// Whether there is a load at every point of `path`, for which [`Process::load`] may then be asked.
    ///
    /// # Errors
    /// As [`Process::loads`].
    pub fn check_loads(&self, path: &Toolpath) -> std::result::Result<(), LoadError> {
        self.own_forces.check(&self.cutting, path)?;
        path.points().iter().try_for_each(|point| self.load(point).map(drop))
    }

    /// The load at a point of a path.
    ///
    /// # Errors
    /// As [`CuttingLaw::load`].
    pub fn load(&self, point: &PathPoint) -> std::result::Result<PathLoad, LoadError> {
        self.own_forces.at(point).unwrap_or(&self.cutting).load(point)
    }

    /// Where the workpiece stands, what is cut, and what of its paths the machine does not control, as labels and words.
    pub fn facts(&self) -> Vec<(&'static str, String)> {
        let mut facts = vec![("workpiece", self.place_words()), ("counts as cutting", self.cutting_rule.words())];
        facts.extend((!self.own_forces.is_empty()).then(|| ("cutting force", self.own_forces.words())));
        facts.extend(self.has_own_tool.then(|| ("tool", self.machine.tool_words())));
        facts.extend(self.machine.uncontrolled_words().map(|words| (NOT_CONTROLLED, words)));
        facts
    }

    /// What of [`Process::facts`] nobody may have meant: where the workpiece stands if the file does not say it, and what of
    /// its paths the machine does not control.
    pub fn assumed(&self) -> Vec<(&'static str, String)> {
        let mut assumed = Vec::new();
        assumed.extend((!self.is_placed).then(|| ("workpiece", self.place_words())));
        assumed.extend(self.machine.uncontrolled_words().map(|words| (NOT_CONTROLLED, words)));
        assumed
    }

    /// Where the workpiece stands: in the base of the machine, or on its carrier.
    pub fn place_words(&self) -> String {
        let Placement { origin_mm, roll_pitch_yaw, reference } = &self.placement;
        let place = self.machine.carrier.as_ref().map_or("base", |carrier| &carrier.name);
        let mut words = format!("origin at ({}, {}, {}) mm of the {place}", origin_mm.x, origin_mm.y, origin_mm.z);
        if !self.is_placed {
            words += ", assumed: the process gives no placement.origin_mm";
        }
        for (name, angle) in ["roll", "pitch", "yaw"].iter().zip(roll_pitch_yaw.iter()).filter(|(_, a)| **a != 0.0) {
            words += &format!(", {name} {}°", (angle.to_degrees() * 1e9).round() / 1e9);
        }
        words
            + match reference {
                PathReference::ToolTip => "; path of the tool tip",
                PathReference::PlatformPoint => "; path of the platform point P",
            }
    }

    /// Reads and checks the process file `file` for `machine`.
    ///
    /// # Errors
    /// A file that cannot be read, is not of the expected form, or holds values that make no sense.
    pub fn open(file: &std::path::Path, machine: &Machine) -> Result<Process> {
        let text = crate::input::toml_file::read(file)?;
        let folder = file.parent().map(std::path::Path::to_path_buf).unwrap_or_default();
        Self::from_toml(&text, &file.display().to_string(), folder, machine)
    }

    /// Reads and checks the process file called `name` in `folder` for `machine`.
    ///
    /// # Errors
    /// As [`Process::from_toml`], or a file that cannot be read.
    pub fn in_folder(folder: &Folder, name: &str, machine: &Machine) -> Result<Process> {
        let text = folder.text(name)?;
        Self::from_toml(&text, &folder.path(name).display().to_string(), folder.of(name), machine)
    }

    /// Checks a process given as TOML text. `origin` names it in errors; a wrench table is sought relative to `folder`.
    ///
    /// # Errors
    /// A text that is not of the expected form, or holds values that make no sense.
    pub fn from_toml(text: &str, origin: &str, folder: impl Into<Folder>, machine: &Machine) -> Result<Process> {
        let spec: ProcessSpec = crate::input::toml_file::parse_renamed(text, origin, &RENAMED)?;
        let mut process = resolve::file(&spec, &Check::new(origin), &folder.into(), machine)?;
        process.inputs = Inputs::of_file(origin, text).and(process.inputs);
        Ok(process)
    }

    /// Checks tables that stand at `check` of another file, whose text is not among the process's inputs.
    pub(crate) fn from_tables(
        spec: &ProcessSpec,
        check: &Check,
        folder: &Folder,
        machine: &Machine,
    ) -> Result<Process> {
        resolve::tables(spec, check, folder, machine)
    }
}
