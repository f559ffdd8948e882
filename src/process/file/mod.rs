//! The process file, checked: placement of the workpiece, cutting force, errors of the actual machine, and limits of compensation.

pub mod chain_errors;
mod cutter;
mod force;
pub(crate) mod force_spec;
mod resolve;
pub(crate) mod spec;
#[cfg_attr(target_family = "wasm", path = "no_tables.rs")]
pub(crate) mod tables;
mod tool_force;

pub use cutter::Cutter;
pub use tables::cell::ProcessCell;
#[cfg(not(target_family = "wasm"))]
pub use tables::cell::{CellBodySpec, CellFrame, CellSpec, RapidMove};

use crate::{
    FOR_PAGES,
    compensation::{ErrorNorm, Target},
    input::{
        Folder, Inputs,
        check::Check,
        error::{Error, Result},
    },
    machine::{ChainError, Machine},
    process::{
        CutPath, CuttingRule, PathReference, Placement, VerdictTable,
        cutting::{CuttingLaw, LoadError, OwnForces, PathLoad},
        file::spec::ProcessSpec,
        not_followed::first_unreachable,
        stock::StockRemoval,
        uncertainty::{self, CutBy, ForceSpread, UncertaintyTable},
    },
    toolpath::{FormatError, NumberFormat, PathPoint, Sampling, Toolpath, WriteOptions, gcode::GcodeOptions},
};

/// A process checked for one machine: placement, cutting forces, chain errors, limits, and how programs are read and written.
#[derive(Debug, Clone)]
pub struct Process {
    /// The machine of the process, with the tool of the process.
    pub machine: Machine,
    /// Whether the process gives a tool other than that of the machine file.
    pub has_own_tool: bool,
    /// Where the tip of a stationary tool is in the base, mm, and its key; the machine is seen from the part that it holds then.
    pub stationary_tip: Option<(nalgebra::Vector3<f64>, Check)>,
    /// Tolerance of the tool's position, mm, if the file gives it.
    pub tolerance_mm: Option<f64>,
    /// The placement of the workpiece, and the point whose positions the path gives.
    pub placement: Placement,
    /// Whether the file gives the origin of the workpiece; otherwise it is that of the base frame or carrier.
    pub is_placed: bool,
    /// The cutting force along the path, where tool and feature have no force of their own.
    pub cutting: CuttingLaw,
    /// Cutting forces specific to single tools and features.
    pub own_forces: OwnForces,
    /// What is cut, from which the engagement follows; `None`: as the cutting forces say.
    pub stock: Option<StockRemoval>,
    /// What stands around the workpiece or moves with it; `None`: bodies are not looked at.
    pub cell: Option<std::sync::Arc<ProcessCell>>,
    /// The rule that decides which moves cut.
    pub cutting_rule: CuttingRule,
    /// Errors of each chain of the machine, in its order.
    pub errors: Vec<ChainError>,
    /// What is not known exactly; `None` where all inputs are taken as exact, and on pages, which compute with nominal numbers.
    pub uncertainty: Option<UncertaintyTable>,
    /// What the verdict is about, and bounds of what is not computed.
    pub verdict: VerdictTable,
    /// How finely arcs and long lines of a program are split.
    pub sampling: Sampling,
    /// Limits of corrections and drive forces.
    pub limits: CorrectionLimits,
    /// Natural frequencies of machine, tool and part, Hz.
    pub natural_frequencies_hz: Vec<f64>,
    /// What limits the feed of a program; `None`: the feed is as programmed.
    pub feed: Option<crate::process::feed::FeedLimits>,
    /// What is compensated: position or full pose.
    pub target: Target,
    /// Along a program, the length after a corner over which the cutting force is blended from one move to the next, mm; at 0 it jumps.
    pub corner_mm: f64,
    /// How the redundancy angle γ is chosen.
    pub redundancy: crate::process::RedundancySettings,
    /// What a G-code program does not say itself.
    pub gcode: GcodeOptions,
    /// What a program of a robot or an APT program does not say itself.
    pub robot_program: crate::toolpath::robot::RobotOptions,
    /// How written coordinates are rounded.
    pub decimals: Decimals,
    /// How far from corrected points the arcs and lines may pass that a block of G-code is written as, mm.
    pub write_tolerance_mm: f64,
    /// Whether a flat arc may be written as a helical one.
    pub helical_arcs: bool,
    /// Tables given in the file that only apply to toolpaths.
    pub path_only_tables: Vec<&'static str>,
    /// Prefix of the process's keys in their file: empty in a process file, `process.` in a study.
    pub key_prefix: &'static str,
    /// The texts of the files that define the process.
    pub inputs: Inputs,
}

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
    /// The error norm to minimise where limits bind.
    pub objective: ErrorNorm,
    /// Most that a compensated program may leave its path by where the cutting force is absent, mm.
    pub unloaded_gouge_mm: Option<f64>,
}

impl CorrectionLimits {
    /// Whether any limit is given.
    pub fn is_limited(&self) -> bool {
        self.correction_mm.is_some() || self.correction_change_mm.is_some() || self.force_N.is_some()
    }
}

/// Numbers of decimals of written coordinates; `None` keeps those of the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Decimals {
    /// Decimals of coordinates in mm.
    pub mm: Option<u8>,
    /// Decimals of coordinates in inches.
    pub inch: Option<u8>,
}

impl Decimals {
    /// Returns the format in which a program or polyline whose own format is `original` is written; never fails for a checked [`Process`].
    pub fn format(self, original: NumberFormat) -> std::result::Result<NumberFormat, FormatError> {
        NumberFormat::new(self.mm.unwrap_or(original.mm_decimals()), self.inch.unwrap_or(original.inch_decimals()))
    }
}

impl Process {
    /// Returns the options to write a program that was read in the format `original`. Fails as [`Decimals::format`] does.
    pub fn write_options(&self, original: NumberFormat) -> std::result::Result<WriteOptions, FormatError> {
        Ok(WriteOptions {
            format: self.decimals.format(original)?,
            tolerance_mm: self.write_tolerance_mm,
            helical_arcs: self.helical_arcs,
        })
    }

    /// Returns `path` with its cutting points marked by the file's cutting rule, or as it cuts the stock; `origin` names the path in errors. Fails when no move that
    /// may cut does, or the machine cannot reach an orientation of the path.
    pub fn mark_cutting(&self, path: Toolpath, origin: &str) -> Result<CutPath> {
        self.mark_cutting_and_tell(path, origin, &mut || ())
    }

    /// As [`Process::mark_cutting`]; calls `done` for each point up to which stock is cut.
    ///
    /// # Errors
    /// As there.
    pub fn mark_cutting_and_tell(&self, path: Toolpath, origin: &str, done: &mut dyn FnMut()) -> Result<CutPath> {
        if let Some((point, why)) = first_unreachable(&self.machine, &self.placement, &path) {
            let problem = format!("move {} {why}", point.source.segment + 1);
            return Err(Error::Argument { argument: origin.into(), problem });
        }
        let cuts = |path: &Toolpath| path.points().iter().any(|point| point.cutting);
        let feeds = path.points().iter().any(|point| point.cutting && point.feed_mm_per_min.is_some());
        if self.cutting_rule.max_feed_mm_per_min.is_some() && cuts(&path) && !feeds {
            let problem =
                format!("{origin} has no feeds to compare with it: remove the key, or use below_z_mm or above_z_mm");
            return Err(Error::argument(format!("{}cutting.max_feed_mm_per_min", self.key_prefix), problem));
        }
        let (may_cut, path) = (cuts(&path), self.cutting_rule.apply(path));
        if may_cut && !cuts(&path) {
            let problem = format!("nothing of {origin} is cut: what cuts is {}", self.cutting_rule.text());
            return Err(Error::Argument { argument: format!("{}cutting", self.key_prefix), problem });
        }
        if let Some(stock) = &self.stock {
            let law = |point: &PathPoint| self.own_forces.law_at(point).unwrap_or(&self.cutting);
            return stock.cut(path, &self.machine, &self.placement, law, origin, done);
        }
        Ok(path.into())
    }

    /// Returns `path`, which has cut the stock, with the loads of what its tool cuts at `shifts` from its points (W, mm); `None` without stock. Errors of the stock.
    pub(crate) fn cut_shifted(
        &self,
        path: &Toolpath,
        shifts: &[nalgebra::Vector3<f64>],
        origin: &str,
    ) -> Result<Option<CutPath>> {
        let law = |point: &PathPoint| self.own_forces.law_at(point).unwrap_or(&self.cutting);
        let placed = self.placement.place(&self.machine);
        let cut = |stock: &StockRemoval| stock.cut_shifted(path, &placed, shifts, law, origin);
        self.stock.as_ref().map(cut).transpose()
    }

    /// Returns the process itself if it has no table `[uncertainty]`; `name` says in the error who computes with exact inputs only.
    ///
    /// # Errors
    /// It has a table `[uncertainty]`.
    pub fn exact_for(self, name: &str) -> Result<Self> {
        self.uncertainty.as_ref().map_or(Ok(()), |table| uncertainty::refuse(&table.check, name)).map(|()| self)
    }

    /// Returns the process itself if it has nothing that only compensate follows; `name` says in the error what does not.
    ///
    /// # Errors
    /// It has a table `[feed]`, or a stationary tool.
    pub fn as_programmed(self, name: &str) -> Result<Self> {
        if let Some(limits) = &self.feed {
            return limits.check.fail(format!(
                "is not for {name}, which leaves feeds as programmed: only compensate changes those of a G-code program"
            ));
        }
        if let Some((_, check)) = &self.stationary_tip {
            return check.fail(format!("is not for {name}: only compensate follows a stationary tool"));
        }
        Ok(self)
    }

    /// Computes the load at every point of `path`, in order. Fails like [`OwnForces::check`] and [`CuttingLaw::load`].
    pub fn loads(&self, path: &Toolpath) -> std::result::Result<Vec<PathLoad>, LoadError> {
        self.own_forces.check(&self.cutting, path)?;
        path.points().iter().map(|point| self.load(point)).collect()
    }

    /// Checks that the load at every point of `path` can be computed by [`Process::load`]. Fails as [`Process::loads`] does.
    pub fn check_loads(&self, path: &Toolpath) -> std::result::Result<(), LoadError> {
        self.own_forces.check(&self.cutting, path)?;
        path.points().iter().try_for_each(|point| self.load(point).map(drop))
    }

    /// Computes the load on the tool at `point`, by the law of its feature, its tool or the process. Fails as [`CuttingLaw::load`] does.
    pub fn load(&self, point: &PathPoint) -> std::result::Result<PathLoad, LoadError> {
        self.own_forces.law_at(point).unwrap_or(&self.cutting).load(point)
    }

    /// Returns the process with one component of each of its forces, by its index, as [`CuttingLaw::with_only`] does; `None` where one of them is no sum of components.
    #[must_use]
    pub fn with_only(&self, component: usize) -> Option<Self> {
        // Pages compute with nominal numbers.
        if FOR_PAGES {
            return None;
        }
        let (cutting, own_forces) = (self.cutting.with_only(component)?, self.own_forces.with_only(component)?);
        Some(Self { cutting, own_forces, ..self.clone() })
    }

    /// Returns the loads of the components of the force at every point of `path`, which has loads ([`Process::loads`]); `None` where one is no sum of components, or none is
    /// `varied` by itself.
    #[must_use]
    pub fn component_loads(
        &self,
        path: &Toolpath,
        varied: &ForceSpread,
    ) -> Option<[Vec<PathLoad>; ForceSpread::COMPONENTS.len()]> {
        let of = |component: usize| -> Option<Vec<PathLoad>> {
            let process = self.with_only(component)?;
            path.points().iter().map(|point| process.load(point).ok()).collect()
        };
        if !varied.has_components() {
            return None;
        }
        Some([of(0)?, of(1)?, of(2)?])
    }

    /// Returns what uncertain inputs have to know of the force where the tools with these numbers cut.
    pub fn cut_by<'a>(&self, tools: &'a [Option<u32>]) -> CutBy<'a> {
        let has_force = self.has_force();
        CutBy { has_force, has_components: has_force && self.with_only(0).is_some(), tools }
    }

    /// Returns label and words for placement, cutting moves, tool-specific forces, tool, and coordinates that the machine does not control.
    pub fn facts(&self) -> Vec<(&'static str, String)> {
        let mut facts = vec![("workpiece", self.placement_text()), ("counts as cutting", self.cutting_text())];
        facts.extend((!self.own_forces.is_empty()).then(|| ("cutting force", self.own_forces.text())));
        let tool_text = || match &self.stationary_tip {
            Some((tip, _)) => format!("{}. {STANDS}", self.machine.tool_words_at(*tip, "base")),
            None => self.machine.tool_text(),
        };
        facts.extend(self.has_own_tool.then(|| ("tool", tool_text())));
        facts.extend(self.machine.uncontrolled_text().map(|text| (NOT_CONTROLLED, text)));
        facts
    }

    /// Returns whether the file gives a cutting force.
    pub fn has_force(&self) -> bool {
        self.cutting != CuttingLaw::None || !self.own_forces.is_empty()
    }

    /// Returns in words what counts as cutting.
    pub fn cutting_text(&self) -> String {
        if self.stock.is_some() {
            return "every move but rapid ones, with the force of what it touches of the stock".into();
        }
        self.cutting_rule.text()
    }

    /// Returns label and words for what may not be intended: an assumed placement, and coordinates that the machine does not control.
    pub fn assumed(&self) -> Vec<(&'static str, String)> {
        let mut assumed = Vec::new();
        assumed.extend((!self.is_placed).then(|| ("workpiece", self.placement_text())));
        assumed.extend(self.machine.uncontrolled_text().map(|text| (NOT_CONTROLLED, text)));
        assumed
    }

    /// Describes the placement of the workpiece in the base of the machine or on its carrier.
    pub fn placement_text(&self) -> String {
        let Placement { origin_mm, roll_pitch_yaw, reference } = &self.placement;
        let place = self.machine.carrier.as_ref().map_or("base", |carrier| &carrier.name);
        let mut text = format!("origin at ({}, {}, {}) mm of the {place}", origin_mm.x, origin_mm.y, origin_mm.z);
        if !self.is_placed {
            text += ", assumed: the process gives no placement.origin_mm";
        }
        for (name, angle) in ["roll", "pitch", "yaw"].iter().zip(roll_pitch_yaw.iter()).filter(|(_, a)| **a != 0.0) {
            text += &format!(", {name} {}°", (angle.to_degrees() * 1e9).round() / 1e9);
        }
        text + match reference {
            PathReference::ToolTip => "; path of the tool tip",
            PathReference::PlatformPoint => "; path of the platform point P",
        }
    }

    /// Reads and checks the process file `file` for `machine`. Fails like [`Process::from_toml`], or if the file cannot be read.
    pub fn open(file: &std::path::Path, machine: &Machine) -> Result<Process> {
        let text = crate::input::toml_file::read(file)?;
        let folder = file.parent().map(std::path::Path::to_path_buf).unwrap_or_default();
        Self::from_toml(&text, &file.display().to_string(), folder, machine)
    }

    /// Reads and checks the process file called `name` in `folder` for `machine`; fails as [`Process::from_toml`] and if it cannot be read.
    /// What does not fit the machine is collected with the misfits of `check`, if that collects any.
    pub fn in_folder(folder: &Folder, name: &str, machine: &Machine, check: &Check) -> Result<Process> {
        let text = folder.text(name)?;
        Self::checked(&text, &check.other_file(&folder.path(name).display().to_string()), &folder.of(name), machine)
    }

    /// Parses and checks a process given as TOML text; `origin` names it in errors, and wrench tables are relative to `folder`.
    /// Fails if the text is not of the expected form or holds values that make no sense.
    pub fn from_toml(text: &str, origin: &str, folder: impl Into<Folder>, machine: &Machine) -> Result<Process> {
        let check = Check::collecting(origin);
        let found = Self::checked(text, &check, &folder.into(), machine);
        let found =
            check.with_misfits(found, &format!("machine {}", machine.name), |file| (file == origin).then_some(text));
        let mut process = found?;
        // Before anything is computed; the machine of a program may have other drives locked, and its tools are known with it.
        if let Some(table) = &mut process.uncertainty {
            table.check = table.check.at_once();
        }
        if let Some(table) = process.uncertainty.as_ref().filter(|_| !FOR_PAGES) {
            let cut = CutBy { has_force: true, ..process.cut_by(&[Some(0)]) };
            table.of_path(&process.machine, &process.errors, &cut)?;
        }
        Ok(process)
    }

    /// Parses and checks the process file `text`; `check` names it in errors, and files that it names are in `folder`.
    fn checked(text: &str, check: &Check, folder: &Folder, machine: &Machine) -> Result<Process> {
        let origin = check.origin();
        let spec: ProcessSpec = crate::input::toml_file::parse(text, origin)?;
        let mut process = resolve::file(&spec, check, folder, machine)?;
        process.inputs = Inputs::of_file(origin, text).and(process.inputs);
        Ok(process)
    }
}

/// What a stationary tool makes of the names of frames.
const STANDS: &str = "It stands, and the machine holds the part: \"base\" is its flange or platform here, P the tip, and nothing has weight";
