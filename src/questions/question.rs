//! The trait that every question implements, what it is given when it is asked, and the macro that lists the questions.

use std::{
    cell::{Cell, RefCell},
    io::ErrorKind,
};

use serde::{Deserialize, Serialize, de::DeserializeOwned};

#[cfg(feature = "report")]
use crate::page::PageKind;
use crate::{
    FOR_PAGES,
    input::{
        Folder, Inputs,
        check::Check,
        error::{Error, Result},
    },
    machine::{Branch, ChainError, Machine},
    process::{
        GammaChoice, Process,
        uncertainty::{self, CutBy, Uncertainty, UncertaintyTable},
    },
    questions::{
        StudyKind,
        spec::{Header, ProcessRef},
    },
    work::Work,
};

/// A question: a checked study that can be run.
pub trait Question: Sized {
    /// The question's table in a study file, as written.
    type Spec: DeserializeOwned + 'static;
    /// Display settings for its figures and pages, as far as the study file gives any.
    type Shown: Clone + std::fmt::Debug;
    /// Name of a study of this kind in sentences, with its article.
    const NAME: &str;
    /// The study folder that `kinetostat new` writes.
    const TEMPLATE: Template;
    /// Names of its first tables: files in their places are refused before anything is computed.
    const TABLES: &[&str];

    /// Checks the question's table `spec` and reads the files that it names. `Err` for values that make no sense, or an unreadable file.
    fn resolve(spec: &Self::Spec, context: &StudyContext<'_>) -> Result<Resolved<Self>>;

    /// Returns how many items the study computes, and the plural noun for them.
    fn items(&self) -> (usize, &'static str);

    /// Returns the number of grid points of its map, if it has one that can be written as an image.
    fn image_points(&self) -> Option<usize> {
        None
    }

    /// Returns how many pieces can be computed independently, of the first round where it goes in rounds; 0 if it is not divided.
    fn pieces(&self) -> usize {
        0
    }

    /// Returns whether later pieces depend on the results of all earlier ones.
    fn goes_in_rounds(&self) -> bool {
        false
    }

    /// Computes the pieces and keeps them in `work`, without a report. `Err` if `work` was stopped or a piece could not be kept.
    fn compute(&self, _work: &Work) -> Result<()> {
        Ok(())
    }
}

/// A question whose results are written to a folder as a report.
#[cfg(feature = "report")]
pub trait Answered: Question {
    /// What pages do with its results beyond what their description says.
    const PAGE: PageKind = PageKind::PLAIN;

    /// Computes the study and makes its report: tables, figures and page. `Err` if the work of `run` was stopped, or files of streamed
    /// tables cannot be written.
    fn answer(&self, shown: &Self::Shown, run: &crate::answer::Run<'_>) -> Result<crate::answer::Output>;
}

/// A study folder to start from.
#[derive(Debug, Clone, Copy)]
pub struct Template {
    /// Name of the template on the command line.
    pub name: &'static str,
    /// What the study asks, in one line.
    pub about: &'static str,
    /// Names and texts of its files, in which `{{ }}` stands for what a machine has, and for what stands there without one.
    pub files: &'static [(&'static str, &'static str)],
}

/// A checked study with the display settings of its report and its inputs.
#[derive(Debug, Clone)]
pub struct Resolved<Q: Question> {
    /// The checked study.
    pub study: Q,
    /// The display settings of its report.
    pub shown: Q::Shown,
    /// Its input files except study and machine, and the settings of the command line.
    pub inputs: Inputs,
}

/// Settings that replace those of a study file for one run.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Overrides {
    /// Grid points per axis of a map.
    pub grid: Option<[usize; 3]>,
    /// Points along a circle.
    pub points: Option<usize>,
    /// The branch of inverse kinematics of an arm.
    pub branch: Option<Branch>,
    /// Choice of γ, the rotation about the tool axis, for a path.
    pub redundancy: Option<GammaChoice>,
    /// Values of machine parameters by name; chain errors are not among them.
    pub parameters: Vec<(String, f64)>,
}

impl Overrides {
    /// Refuses the override of points along a path: a study of the kind `name` has none. `Err` if it is given.
    pub fn refuse_points(&self, name: &str) -> Result<()> {
        self.refuse("points", format!("{name} has no points along a path, but a grid"))
    }

    /// Refuses the override of the grid: a study of the kind `name` has none. `Err` if it is given.
    pub fn refuse_grid(&self, name: &str) -> Result<()> {
        self.refuse("grid", format!("{name} has no grid, but points along a path"))
    }

    /// Refuses overrides of points and grid: a study of the kind `name` has measurements instead. `Err` if one is given.
    pub fn refuse_beside_measurements(&self, name: &str) -> Result<()> {
        ["points", "grid"].iter().try_for_each(|key| self.refuse(key, format!("{name} has measurements, and no {key}")))
    }

    /// Returns an error with `problem` if the override called `name`, "points" or "grid", is given.
    fn refuse(&self, name: &str, problem: String) -> Result<()> {
        let is_given = if name == "grid" { self.grid.is_some() } else { self.points.is_some() };
        if is_given { Self::location(name).fail(problem) } else { Ok(()) }
    }

    /// Word that stands for the overrides in errors, before their own name.
    pub const ORIGIN: &str = "settings";

    /// Returns the location of the override `name`, for error messages.
    pub(crate) fn location(name: &str) -> Check {
        Check::new(Self::ORIGIN).key(name)
    }
}

/// Everything a question is given besides its own table.
#[derive(Debug)]
pub struct StudyContext<'a> {
    /// The nominal machine.
    pub machine: Machine,
    /// The folder against which the study's file names are resolved.
    pub folder: &'a Folder,
    /// Settings that replace those of the study for this run.
    pub overrides: &'a Overrides,
    /// Location of the question's table, for error messages.
    pub check: Check,
    /// Name of a study of this kind in sentences.
    pub name: &'static str,
    pub(crate) header: &'a Header,
    /// Whether the question has read the process of the study.
    pub(crate) is_process_read: Cell<bool>,
    /// Whether the question has read what is uncertain.
    pub(crate) is_uncertainty_read: Cell<bool>,
    /// The table `[uncertainty]` of a process that was read last.
    pub(crate) uncertainty_of_process: RefCell<Option<UncertaintyTable>>,
}

impl StudyContext<'_> {
    /// Returns the process in `file`, which the key `process` of `check` names, or without a file that of the study; its inputs hold the
    /// files read. `Err` if there is none, it makes no sense, or it searches for γ.
    pub fn process(&self, file: Option<&str>, check: &Check) -> Result<Process> {
        let process = self.process_with_gamma(file, check)?;
        self.refuse_gamma_search(&process, file)?;
        Ok(process)
    }

    /// Refuses a process, from `file` or the study, that searches for the redundancy angle γ.
    fn refuse_gamma_search(&self, process: &Process, file: Option<&str>) -> Result<()> {
        if !process.redundancy.is_sought() {
            return Ok(());
        }
        let place = match self.overrides.redundancy {
            Some(_) => Overrides::location("redundancy"),
            None => self.process_location(file).key("redundancy.gamma"),
        };
        place.fail(format!(
            "is {}: in {} the tool stands as programmed; only path studies and compensate seek γ",
            process.redundancy.gamma.label(),
            self.name
        ))
    }

    /// Returns the process as [`StudyContext::process`] does, for a question that can search for the redundancy angle γ.
    pub(crate) fn process_with_gamma(&self, file: Option<&str>, check: &Check) -> Result<Process> {
        let mut process = self.process_as_written(file, check)?;
        if let Some(redundancy) = self.overrides.redundancy {
            process.redundancy.gamma = redundancy;
        }
        Ok(process)
    }

    /// Returns the process in `own_file`, or else that of the study, without the overrides. `Err` if there is none.
    fn process_as_written(&self, own_file: Option<&str>, check: &Check) -> Result<Process> {
        let top = self.check.root().key("process");
        self.is_process_read.set(self.is_process_read.get() || own_file.is_none());
        let process = match (own_file, &self.header.process) {
            (Some(file), _) => self.process_file(file, &check.key("process")),
            (None, Some(ProcessRef::File(file))) => self.process_file(file, &top),
            (None, Some(ProcessRef::Tables(spec))) => Process::from_tables(spec, &top, self.folder, &self.machine),
            (None, None) => top.fail("missing: expected the name of a process file, or its tables".into()),
        }?
        .as_programmed("a study")?;
        if process.uncertainty.is_some() {
            self.uncertainty_of_process.replace(process.uncertainty.clone());
        }
        Ok(process)
    }

    /// Reads the process file `file` in the study's folder. `Err` at `check` if there is no such file.
    fn process_file(&self, file: &str, check: &Check) -> Result<Process> {
        match Process::in_folder(self.folder, file, &self.machine, check) {
            Err(Error::Read { source, .. }) if source.kind() == ErrorKind::NotFound => {
                check.fail(format!("\"{file}\" is not a file in the study's folder"))
            }
            found => found,
        }
    }

    /// Refuses a machine with a workpiece carrier; `why` completes the sentence after "which".
    pub(crate) fn refuse_carrier(&self, why: &str) -> Result<()> {
        let Some(carrier) = &self.machine.carrier else { return Ok(()) };
        let problem = format!(
            "machine {} has an elastic workpiece carrier ({}), which {why}: expected one without [workpiece_carrier]",
            self.machine.name, carrier.name
        );
        self.check.root().key("machine").misfit(problem, ())
    }

    /// Returns the uncertain inputs that the study or the table `of_process` gives, for `machine` with chain `errors` of its process and a path
    /// that is `cut` with a force or without, by these tools (none: no path), and the files read for it; `None` if there are none, and on pages. `Err` if both give some, one does not fit, or a file cannot be read.
    pub(crate) fn uncertainty(
        &self,
        of_process: Option<&UncertaintyTable>,
        machine: &Machine,
        errors: &[ChainError],
        cut: &CutBy<'_>,
    ) -> Result<(Option<Uncertainty>, Inputs)> {
        self.is_uncertainty_read.set(true);
        let check = self.check.root().key("uncertainty");
        if FOR_PAGES {
            return Ok((None, Inputs::default()));
        }
        let of_study = self
            .header
            .uncertainty
            .as_ref()
            .map(|spec| UncertaintyTable::read(spec, self.folder, check.clone()))
            .transpose()?;
        let (of_study, read) = of_study.unzip();
        let table = match (&of_study, of_process) {
            (Some(_), Some(of_process)) => {
                let other = of_process.check.location();
                return check.fail(format!("is also given by {other}: expected it in one of them"));
            }
            (of_study, of_process) => of_study.as_ref().or(of_process),
        };
        let resolved = table.map(|table| table.of_path(machine, errors, cut)).transpose()?;
        Ok((resolved, read.unwrap_or_default()))
    }

    /// Returns the location, for error messages, of the table `[uncertainty]` of the process that was read last, or else of the study's.
    pub(crate) fn uncertainty_location(&self) -> Check {
        let of_study = || self.check.root().key("uncertainty");
        self.uncertainty_of_process.borrow().as_ref().map_or_else(of_study, |table| table.check.clone())
    }

    /// Refuses a process, or a table `[uncertainty]` of study or process, that the question never read.
    pub(crate) fn refuse_unused(&self) -> Result<()> {
        let of_study = self.header.uncertainty.as_ref().map(|_| self.check.root().key("uncertainty"));
        let of_process = || self.uncertainty_of_process.borrow().as_ref().map(|table| table.check.clone());
        if let (false, Some(check)) = (self.is_uncertainty_read.get(), of_study.or_else(of_process)) {
            return uncertainty::refuse(&check, self.name);
        }
        if self.header.process.is_some() && !self.is_process_read.get() {
            let problem = format!("has no effect: nothing in {} takes it", self.name);
            return self.check.root().key("process").fail(problem);
        }
        Ok(())
    }

    /// Returns the location, for error messages, of the process in `own_file`, or else of that of the study.
    pub(crate) fn process_location(&self, own_file: Option<&str>) -> Check {
        match (own_file, &self.header.process) {
            (Some(file), _) => self.file_location(file),
            (None, Some(ProcessRef::File(file))) => self.file_location(file),
            (None, _) => self.check.root().key("process"),
        }
    }

    /// Returns the path of `file` in the study's folder as a location for error messages.
    fn file_location(&self, file: &str) -> Check {
        self.check.other_file(&self.folder.path(file).display().to_string())
    }
}

/// The check of the table of the one question that a study asks; returns the study and its inputs.
pub(super) type AskedTable = Box<dyn Fn(StudyContext<'_>) -> Result<(StudyKind, Inputs)>>;

/// Returns the check of the table `spec` under `key` by its question, of which `kind` is a study.
pub(super) fn asked<Q: Question + 'static>(
    key: &'static str,
    spec: Q::Spec,
    kind: fn(Box<Q>, Q::Shown) -> StudyKind,
) -> AskedTable {
    Box::new(move |context| {
        let context = StudyContext { check: context.check.key(key), name: Q::NAME, ..context };
        let Resolved { study, shown, inputs } = Q::resolve(&spec, &context)?;
        context.refuse_unused()?;
        Ok((kind(Box::new(study), shown), inputs))
    })
}

/// Completes the two types that list the questions, and makes of each line the module, the table in a study file and what is asked of a study.
macro_rules! questions {
    (
        $(#[$of_kinds:meta])*
        pub enum StudyKind {
            $($(#[$gate:meta])* $key:ident: $kind:ident($folder:ident::$study:ident),)*
        }

        $(#[$of_spec:meta])*
        pub(crate) struct StudySpec {
            $($fields:tt)*
        }
    ) => {
        $($(#[$gate])* pub mod $folder;)*

        $(#[$of_kinds])*
        pub enum StudyKind {
            $($(#[$gate])*
            #[doc = concat!("[`", stringify!($folder), "`]: the study, and what its pictures show.")]
            $kind(Box<$folder::$study>, <$folder::$study as Question>::Shown),)*
        }

        $(#[$of_spec])*
        pub(crate) struct StudySpec {
            $($fields)*
            $($(#[$gate])* $key: Option<<$folder::$study as Question>::Spec>,)*
        }

        impl StudySpec {
            /// Separates the keys of every study from the table of the one question asked. `Err` unless exactly one is asked.
            fn split(self, check: &Check) -> Result<(spec::Header, question::AskedTable)> {
                let header = spec::Header {
                    schema: self.schema,
                    question: self.question,
                    machine: self.machine,
                    branch: self.branch,
                    locked: self.locked,
                    process: self.process,
                    uncertainty: self.uncertainty,
                };
                let mut tables = Vec::new();
                $($(#[$gate])*
                tables.extend(self.$key.map(|table| question::asked(stringify!($key), table, StudyKind::$kind)));)*
                match tables.pop() {
                    Some(table) if tables.is_empty() => Ok((header, table)),
                    _ => {
                        let keys = [$($(#[$gate])* stringify!($key)),*];
                        check.key(keys[0]).fail(format!("give exactly one of {}", keys.join(", ")))
                    }
                }
            }
        }

        /// Study folders to start from, one for each question.
        pub const TEMPLATES: &[Template] = &[$($(#[$gate])* <$folder::$study as Question>::TEMPLATE),*];

        /// Returns what pages do with results of a `kind`, as their description calls it.
        #[cfg(feature = "report")]
        pub fn page_kind(kind: &str) -> crate::page::PageKind {
            let own = [$($(#[$gate])* (stringify!($key), <$folder::$study as Answered>::PAGE)),*];
            own.into_iter().find(|(name, _)| *name == kind).map_or(crate::page::PageKind::PLAIN, |(_, own)| own)
        }

        impl StudyKind {
            /// Returns how many items the study computes, and the plural noun for them.
            pub fn items(&self) -> (usize, &'static str) {
                match self { $($(#[$gate])* StudyKind::$kind(study, _) => study.items(),)* }
            }

            /// Returns the number of grid points of its map, if it has one that can be written as an image.
            pub fn image_points(&self) -> Option<usize> {
                match self { $($(#[$gate])* StudyKind::$kind(study, _) => study.image_points(),)* }
            }

            /// Returns how many pieces can be computed independently: those of the first round, if it goes in rounds.
            pub fn pieces(&self) -> usize {
                match self { $($(#[$gate])* StudyKind::$kind(study, _) => study.pieces(),)* }
            }

            /// Returns whether later pieces depend on the results of all earlier ones.
            pub fn goes_in_rounds(&self) -> bool {
                match self { $($(#[$gate])* StudyKind::$kind(study, _) => study.goes_in_rounds(),)* }
            }

            /// Computes the pieces and keeps them in `work`, without a report.
            #[cfg(feature = "report")]
            pub(crate) fn compute(&self, work: &crate::work::Work) -> Result<()> {
                match self { $($(#[$gate])* StudyKind::$kind(study, _) => study.compute(work),)* }
            }

            /// Returns the file stems of the tables that the study writes in any case.
            pub fn tables(&self) -> &'static [&'static str] {
                match self { $($(#[$gate])* StudyKind::$kind(..) => <$folder::$study>::TABLES,)* }
            }

            /// Computes the study and makes its report.
            #[cfg(feature = "report")]
            pub(crate) fn answer(&self, run: &crate::answer::Run<'_>) -> Result<crate::answer::Output> {
                match self { $($(#[$gate])* StudyKind::$kind(study, shown) => question::Answered::answer(&**study, shown, run),)* }
            }
        }
    };
}
pub(super) use questions;
