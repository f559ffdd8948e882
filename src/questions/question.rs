//! What a question is to the list of questions, and what it is given when it is asked.

use std::{cell::Cell, io::ErrorKind};

use serde::{Deserialize, Serialize, de::DeserializeOwned};

use crate::{
    input::{
        Folder, Inputs,
        check::Check,
        error::{Error, Result},
    },
    machine::{Branch, Machine},
    process::{Process, GammaChoice},
    questions::spec::{Header, ProcessRef},
    work::Work,
};

/// A question: a checked study that can be run.
pub trait Question: Sized {
    /// Its table in a study file.
    type Spec: DeserializeOwned;
    /// What its pictures and pages show, where the study file says so.
    type Shown: Clone + std::fmt::Debug;
    /// What a study of it is called in sentences.
    const NAME: &str;
    /// What `kinetostat new` writes for it.
    const TEMPLATE: Template;
    /// Its first tables: what must not be in their places is told before anything is computed.
    const TABLES: &[&str];

    /// Checks what a study file says.
    ///
    /// # Errors
    /// Values that make no sense, and files that cannot be read.
    fn resolve(spec: &Self::Spec, given: &Given<'_>) -> Result<Resolved<Self>>;

    /// How many items it computes, and what they are called.
    fn items(&self) -> (usize, &'static str);

    /// Points of its map over the workspace, if it has one that can be an image.
    fn image_points(&self) -> Option<usize> {
        None
    }

    /// How many pieces are computed that do not need one another: those of its first round, where they go in rounds. None where it is over
    /// before it would be divided.
    fn pieces(&self) -> usize {
        0
    }

    /// Whether what is computed next depends on what all pieces before have found.
    fn goes_in_rounds(&self) -> bool {
        false
    }

    /// Computes the pieces without making anything of them.
    ///
    /// # Errors
    /// Of the work.
    fn compute(&self, _work: &Work) -> Result<()> {
        Ok(())
    }
}

/// A question that leaves an answer in a folder.
#[cfg(feature = "report")]
pub trait Answered: Question {
    /// Computes it and makes what it leaves.
    ///
    /// # Errors
    /// Of the work; files that cannot be written.
    fn answer(&self, shown: &Self::Shown, run: &crate::answer::Run<'_>) -> Result<crate::answer::Output>;
}

/// A study folder to start from.
#[derive(Debug, Clone, Copy)]
pub struct Template {
    /// What it is called on the command line.
    pub name: &'static str,
    /// What the study asks, in a line.
    pub about: &'static str,
    /// Names and contents of its files.
    pub files: &'static [(&'static str, &'static str)],
}

/// A checked study with what its pictures show and what it was made from.
#[derive(Debug, Clone)]
pub struct Resolved<Q: Question> {
    /// The study.
    pub study: Q,
    /// What its pictures show.
    pub shown: Q::Shown,
    /// The files it was made from, but the study and the machine, and what the command line set.
    pub inputs: Inputs,
}

/// What is changed in a study for one run.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Overrides {
    /// Grid points per axis of a map.
    pub grid: Option<[usize; 3]>,
    /// Points along a circle.
    pub points: Option<usize>,
    /// The branch on which an arm is to stand.
    pub branch: Option<Branch>,
    /// Which turn about the tool's axis a path has.
    pub redundancy: Option<GammaChoice>,
    /// Other numbers of the machine than its file has, by name; errors of chains are not among them.
    pub parameters: Vec<(String, f64)>,
}

impl Overrides {
    /// Refuses points along a path for a study of the kind `name`.
    ///
    /// # Errors
    /// They are given.
    pub fn refuse_points(&self, name: &str) -> Result<()> {
        self.refuse("points", format!("{name} has no points along a path, but a grid"))
    }

    /// Refuses a grid for a study of the kind `name`.
    ///
    /// # Errors
    /// It is given.
    pub fn refuse_grid(&self, name: &str) -> Result<()> {
        self.refuse("grid", format!("{name} has no grid, but points along a path"))
    }

    /// Refuses both for a study of the kind `name`, which has measurements instead.
    ///
    /// # Errors
    /// One is given.
    pub fn refuse_beside_measurements(&self, name: &str) -> Result<()> {
        ["points", "grid"].iter().try_for_each(|own| self.refuse(own, format!("{name} has measurements, and no {own}")))
    }

    fn refuse(&self, own: &str, problem: String) -> Result<()> {
        let is_given = if own == "grid" { self.grid.is_some() } else { self.points.is_some() };
        if is_given { Self::place(own).fail(problem) } else { Ok(()) }
    }

    /// What names overrides in errors, before their own name.
    pub const ORIGIN: &str = "settings";

    /// The place of the override called `name`.
    pub(crate) fn place(name: &str) -> Check {
        Check::new(Self::ORIGIN).key(name)
    }
}

/// What a question is given besides its own table.
#[derive(Debug)]
pub struct Given<'a> {
    /// The nominal machine.
    pub machine: Machine,
    /// Where the files are that the study names.
    pub folder: &'a Folder,
    /// What is changed for one run.
    pub overrides: &'a Overrides,
    /// The place of the question's table.
    pub check: Check,
    /// What a study of this kind is called in sentences.
    pub name: &'static str,
    pub(crate) header: &'a Header,
    /// Whether the question has asked for the process of the study.
    pub(crate) asked_process: Cell<bool>,
}

impl Given<'_> {
    /// The process of the study, or `own`, one that is named at the key `process` of `check`. Its inputs hold the files it
    /// comes from.
    ///
    /// # Errors
    /// No process, or one that makes no sense.
    pub fn process(&self, own: Option<&str>, check: &Check) -> Result<Process> {
        let process = self.turned_process(own, check)?;
        #[cfg(not(target_family = "wasm"))]
        self.refuse_turn(&process, own)?;
        Ok(process)
    }

    /// Refuses a process that seeks the turn about the tool's axis.
    #[cfg(not(target_family = "wasm"))]
    fn refuse_turn(&self, process: &Process, own: Option<&str>) -> Result<()> {
        if !process.redundancy.is_sought() {
            return Ok(());
        }
        let place = match self.overrides.redundancy {
            Some(_) => Overrides::place("redundancy"),
            None => self.process_place(own).key("redundancy.gamma"),
        };
        place.fail(format!(
            "is {}: in {} the tool stands as programmed; only path studies and compensate seek γ",
            process.redundancy.gamma.label(),
            self.name
        ))
    }

    /// As [`Given::process`], of a question that seeks the turn about the tool's axis where the process says so.
    ///
    /// # Errors
    /// As [`Given::process`], but for that.
    pub(crate) fn turned_process(&self, own: Option<&str>, check: &Check) -> Result<Process> {
        #[cfg_attr(target_family = "wasm", allow(unused_mut, reason = "the process of pages seeks no γ"))]
        let mut process = self.process_as_written(own, check)?;
        #[cfg(not(target_family = "wasm"))]
        if let Some(redundancy) = self.overrides.redundancy {
            process.redundancy.gamma = redundancy;
        }
        Ok(process)
    }

    fn process_as_written(&self, own: Option<&str>, check: &Check) -> Result<Process> {
        let top = self.check.root().key("process");
        self.asked_process.set(self.asked_process.get() || own.is_none());
        match (own, &self.header.process) {
            (Some(file), _) => self.process_file(file, &check.key("process")),
            (None, Some(ProcessRef::File(file))) => self.process_file(file, &top),
            (None, Some(ProcessRef::Tables(spec))) => Process::from_tables(spec, &top, self.folder, &self.machine),
            (None, None) => top.fail("missing: expected the name of a process file, or its tables".into()),
        }
    }

    fn process_file(&self, file: &str, check: &Check) -> Result<Process> {
        match Process::in_folder(self.folder, file, &self.machine) {
            Err(Error::Read { source, .. }) if source.kind() == ErrorKind::NotFound => {
                check.fail(format!("\"{file}\" is not a file in the study's folder"))
            }
            found => found,
        }
    }

    /// Refuses a machine with a workpiece carrier; `why` goes on after "which".
    pub(crate) fn refuse_carrier(&self, why: &str) -> Result<()> {
        let Some(carrier) = &self.machine.carrier else { return Ok(()) };
        self.check.root().key("machine").fail(format!(
            "the workpiece carrier {} of machine {} bends as well, which {why}: expected a machine without [workpiece_carrier]",
            carrier.name, self.machine.name
        ))
    }

    /// Refuses what stands in the file beside the question's own table and was not asked for.
    pub(crate) fn refuse_unused(&self) -> Result<()> {
        if self.header.process.is_some() && !self.asked_process.get() {
            let problem = format!("has no effect: nothing in {} takes it", self.name);
            return self.check.root().key("process").fail(problem);
        }
        Ok(())
    }

    /// The place of the process that [`Given::process`] gives for `own`.
    pub(crate) fn process_place(&self, own: Option<&str>) -> Check {
        match (own, &self.header.process) {
            (Some(file), _) => self.place_of(file),
            (None, Some(ProcessRef::File(file))) => self.place_of(file),
            (None, _) => self.check.root().key("process"),
        }
    }

    fn place_of(&self, file: &str) -> Check {
        Check::new(&self.folder.path(file).display().to_string())
    }
}

/// The list of questions: from one line each, the modules, the tables of a study file and the kinds of studies.
macro_rules! questions {
    ($($(#[$gate:meta])* $key:ident: $kind:ident($folder:ident::$study:ident),)*) => {
        $($(#[$gate])* pub mod $folder;)*

        /// What a study computes, with what its pictures show.
        #[derive(Debug, Clone)]
        pub enum StudyKind {
            $($(#[$gate])*
            #[doc = concat!("[`", stringify!($folder), "`]: the study, and what its pictures show.")]
            $kind(Box<$folder::$study>, <$folder::$study as Question>::Shown),)*
        }

        /// A study file.
        #[derive(Debug, Clone, serde::Deserialize)]
        #[serde(deny_unknown_fields)]
        pub(crate) struct StudySpec {
            schema: u32,
            question: String,
            machine: String,
            branch: Option<String>,
            #[serde(default)]
            locked: std::collections::BTreeMap<String, f64>,
            process: Option<spec::ProcessRef>,
            $($(#[$gate])* $key: Option<<$folder::$study as Question>::Spec>,)*
        }

        impl StudySpec {
            /// The keys of a study of any kind, and the table of the one question that it asks.
            fn split(self, check: &Check) -> Result<(spec::Header, Asked)> {
                let header = spec::Header {
                    schema: self.schema,
                    question: self.question,
                    machine: self.machine,
                    branch: self.branch,
                    locked: self.locked,
                    process: self.process,
                };
                let mut asked = Vec::new();
                $($(#[$gate])* asked.extend(self.$key.map(|table| Asked::$kind(Box::new(table))));)*
                match asked.pop() {
                    Some(one) if asked.is_empty() => Ok((header, one)),
                    _ => {
                        let keys = [$($(#[$gate])* stringify!($key)),*];
                        check.key(keys[0]).fail(format!("give exactly one of {}", keys.join(", ")))
                    }
                }
            }
        }

        /// The table of a question.
        enum Asked {
            $($(#[$gate])* $kind(Box<<$folder::$study as Question>::Spec>),)*
        }

        impl Asked {
            fn resolve(&self, given: question::Given<'_>) -> Result<(StudyKind, Inputs)> {
                match self {
                    $($(#[$gate])* Asked::$kind(table) => {
                        let (check, name) = (given.check.key(stringify!($key)), <$folder::$study>::NAME);
                        let given = Given { check, name, ..given };
                        let Resolved { study, shown, inputs } = <$folder::$study>::resolve(table, &given)?;
                        given.refuse_unused()?;
                        Ok((StudyKind::$kind(Box::new(study), shown), inputs))
                    })*
                }
            }
        }

        /// Study folders to start from, one for each question.
        pub const TEMPLATES: &[Template] = &[$($(#[$gate])* <$folder::$study as Question>::TEMPLATE),*];

        impl StudyKind {
            /// How many items it computes, and what they are called.
            pub fn items(&self) -> (usize, &'static str) {
                match self { $($(#[$gate])* StudyKind::$kind(study, _) => study.items(),)* }
            }

            /// Points of its map over the workspace, if it has one that can be an image.
            pub fn image_points(&self) -> Option<usize> {
                match self { $($(#[$gate])* StudyKind::$kind(study, _) => study.image_points(),)* }
            }

            /// How many pieces it computes that do not need one another: those of its first round, if it goes in rounds.
            pub fn pieces(&self) -> usize {
                match self { $($(#[$gate])* StudyKind::$kind(study, _) => study.pieces(),)* }
            }

            /// Whether what it computes next depends on what all pieces before have found.
            pub fn goes_in_rounds(&self) -> bool {
                match self { $($(#[$gate])* StudyKind::$kind(study, _) => study.goes_in_rounds(),)* }
            }

            #[cfg(feature = "report")]
            pub(crate) fn compute(&self, work: &crate::work::Work) -> Result<()> {
                match self { $($(#[$gate])* StudyKind::$kind(study, _) => study.compute(work),)* }
            }

            /// Its first tables.
            pub fn tables(&self) -> &'static [&'static str] {
                match self { $($(#[$gate])* StudyKind::$kind(..) => <$folder::$study>::TABLES,)* }
            }

            #[cfg(feature = "report")]
            pub(crate) fn answer(&self, run: &crate::answer::Run<'_>) -> Result<crate::answer::Output> {
                match self { $($(#[$gate])* StudyKind::$kind(study, shown) => question::Answered::answer(&**study, shown, run),)* }
            }
        }
    };
}
pub(super) use questions;
