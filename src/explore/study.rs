//! Study files of a workpiece's place or a map: read for a page, with the same keys and checks as [`crate::questions::Study`] has
//! but without those of other questions; written for a path that has none, and with one place more.

use std::{
    cell::{Cell, RefCell},
    collections::BTreeMap,
    path::Path,
};

use nalgebra::Vector3;
use serde::Deserialize;
use toml::{Table, Value};

use super::{Explorer, STUDY, Scene, place::site_from_shown};
use crate::{
    input::{
        Folder,
        check::Check,
        error::{Error, Result},
        toml_file,
    },
    machine::{ChainError, Machine},
    process::{
        PathReference,
        file::TOLERANCE_MM,
        uncertainty::{UncertaintyTable, spec::UncertaintySpec},
    },
    questions::{
        Overrides, Question, StudyContext, StudyFiles,
        map::{WorkspaceMapStudy, spec::WorkspaceMapSpec},
        placement::{PlacementStudy, reference_position, spec::PlacementStudySpec},
        resolve,
        spec::{self, Header, ProcessRef, SCHEMA},
    },
};

/// A study file as written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    schema: u32,
    question: String,
    machine: String,
    branch: Option<String>,
    #[serde(default)]
    locked: BTreeMap<String, f64>,
    process: Option<ProcessRef>,
    uncertainty: Option<UncertaintySpec>,
    placement: Option<PlacementStudySpec>,
    workspace_map: Option<WorkspaceMapSpec>,
}

/// A study that pages can explore.
pub(super) enum PageStudy {
    /// A placement study: where the workpiece should stand.
    Placement(Box<PlacementStudy>),
    /// A map: how far the tool moves over the workspace.
    Map(Box<WorkspaceMapStudy>),
}

impl PageStudy {
    /// Returns the errors of the machine's chains; of a placement those of its first feature.
    pub(super) fn errors(&self) -> &[ChainError] {
        match self {
            PageStudy::Placement(study) => study.features.first().map_or(&[], |job| &job.tracked.errors),
            PageStudy::Map(study) => &study.load_case.errors,
        }
    }
}

/// A study as read: its machine without the tool of a process, the checked study, and the table `[uncertainty]` of study or process.
pub(super) type Read = (Machine, PageStudy, Option<UncertaintyTable>);

/// Reads the study `text`, whose files are in `folder`.
///
/// # Errors
/// As [`crate::questions::Study::from_toml`].
pub(super) fn read(text: &str, folder: &Folder, overrides: &Overrides) -> Result<Read> {
    let written: Written = spec::parse(text, STUDY)?;
    let Written { schema, question, machine, branch, locked, process, uncertainty, placement, workspace_map } = written;
    let header = Header { schema, question, machine, branch, locked, process, uncertainty: None };
    let check = Check::new(STUDY);
    let (machine, _) = resolve::resolve_header(&header, folder, overrides, &check)?;
    let given = |check: Check, name: &'static str| StudyContext {
        machine: machine.clone(),
        folder,
        overrides,
        check,
        name,
        header: &header,
        is_process_read: Cell::new(false),
        // All but the tool pulled by hand is computed with nominal numbers.
        is_uncertainty_read: Cell::new(true),
        uncertainty_of_process: RefCell::default(),
    };
    let (study, of_process) = match (placement, workspace_map) {
        (Some(spec), None) => {
            let given = given(check.key("placement"), PlacementStudy::NAME);
            let (study, table) = resolve_question::<PlacementStudy>(&spec, given)?;
            (PageStudy::Placement(Box::new(study)), table)
        }
        (None, Some(spec)) => {
            let (study, table) = resolve_question(&spec, given(check.key("workspace_map"), WorkspaceMapStudy::NAME))?;
            (PageStudy::Map(Box::new(study)), table)
        }
        _ => return check.fail("expected one table, placement or workspace_map".into()),
    };
    let of_study = match &uncertainty {
        Some(spec) => Some(UncertaintyTable::read(spec, folder, check.key("uncertainty"))?.0),
        None => None,
    };
    Ok((machine, study, of_study.or(of_process)))
}

/// Reads the placement study `text`, as [`read`]; a map is an error.
pub(super) fn read_placement(text: &str, folder: &Folder, overrides: &Overrides) -> Result<PlacementStudy> {
    match read(text, folder, overrides)?.1 {
        PageStudy::Placement(study) => Ok(*study),
        PageStudy::Map(_) => Check::new(STUDY).key("placement").fail("missing".into()),
    }
}

/// Checks the table of a question, and that no part of the study is unused; returns the question's study, and the table `[uncertainty]` of its process.
fn resolve_question<Q: Question>(spec: &Q::Spec, context: StudyContext<'_>) -> Result<(Q, Option<UncertaintyTable>)> {
    let resolved = Q::resolve(spec, &context)?;
    context.refuse_unused()?;
    Ok((resolved.study, context.uncertainty_of_process.into_inner()))
}

/// Returns the machine of a scene without a study.
pub(super) fn machine(scene: &Scene, folder: &Folder, overrides: &Overrides) -> Result<Machine> {
    let header = Header {
        schema: SCHEMA,
        question: "explored".into(),
        machine: scene.machine.clone(),
        branch: None,
        locked: BTreeMap::new(),
        process: None,
        uncertainty: None,
    };
    Ok(resolve::resolve_header(&header, folder, overrides, &Check::new(STUDY))?.0)
}

/// A program and its process, as files.
#[derive(Debug, Clone, Copy)]
pub struct ProgramAtProcess<'a> {
    /// Name of a built-in machine, or a machine file.
    pub machine: &'a str,
    /// A process file.
    pub process: &'a Path,
    /// A polyline or a G-code program.
    pub program: &'a Path,
    /// Tolerance of the path, mm; if not given that of the process, or else 0.1.
    pub tolerance_mm: Option<f64>,
}

impl Scene {
    /// Creates a scene of a program on a machine, placed as the process says, or else with its middle at the tool's home position.
    ///
    /// # Errors
    /// Files that cannot be read or are not of the expected form.
    #[cfg(feature = "report")]
    pub fn from_program(asked: &ProgramAtProcess<'_>) -> Result<Self> {
        let name = |path: &Path| path.to_string_lossy().replace('\\', "/");
        let head = table([("machine", asked.machine.to_string()), ("process", name(asked.process))]);
        let mut feature = table([("file", name(asked.program))]);
        feature.extend(asked.tolerance_mm.map(|tolerance_mm| (TOLERANCE.to_string(), tolerance_mm.into())));
        let stem = asked.program.file_stem().map_or_else(|| "path".into(), |stem| stem.to_string_lossy().into_owned());
        feature.insert("name".into(), stem.into());
        let folder = Folder::from(Path::new("")).recording();
        let text = placement_toml(head, feature, &folder)?;
        Self::from_text(&text, &folder.recorded())
    }
}

/// Returns a placement study for the workpiece of a path study; an error if the workpiece cannot be placed elsewhere.
pub(super) fn placement_from_path(files: &StudyFiles) -> Result<String> {
    let mut head: Table = toml_file::parse(&files.text, STUDY)?;
    let check = Check::new(STUDY).key("path");
    let Some(Value::Table(path)) = head.remove("path") else { return check.fail("missing".into()) };
    let common = path.into_iter().filter(|(key, _)| ["circle", "file", "process"].contains(&key.as_str()));
    let mut feature: Table = common.collect();
    if !feature.contains_key("circle") && !feature.contains_key("file") {
        return check.fail("is a line: expected a circle or a program, whose workpiece can be put elsewhere".into());
    }
    feature.insert("name".into(), "path".into());
    let named = files.named.iter().map(|(name, bytes)| (name.clone(), bytes.clone()));
    placement_toml(head, feature, &Folder::in_memory(named))
}

/// Returns the text of a placement study for one `feature`, with the common keys `head`; without a tolerance, it gets the default.
fn placement_toml(mut head: Table, mut feature: Table, folder: &Folder) -> Result<String> {
    if !feature.contains_key(TOLERANCE) && !process_has_tolerance(&head, &feature, folder)? {
        feature.insert(TOLERANCE.into(), TOLERANCE_MM.into());
    }
    head.entry("schema").or_insert_with(|| i64::from(SCHEMA).into());
    head.insert("question".into(), "Where should this workpiece stand?".into());
    let placement_with = |bounds: Table, fixed: Table, candidate: Option<Table>| {
        let mut placement = table::<Value, _>([
            ("feature", Value::Array(vec![feature.clone().into()])),
            ("bounds", bounds.into()),
            ("fixed", fixed.into()),
            ("objective", table([("weights", table([("worst_deflection", 1.0)]))]).into()),
            ("search", table([("grid", table([("x", 5), ("y", 5), ("yaw", 4)]))]).into()),
        ]);
        placement.extend(candidate.map(|candidate| ("candidate".to_string(), Value::Array(vec![candidate.into()]))));
        let mut document = head.clone();
        document.insert("placement".into(), placement.into());
        to_toml(&document)
    };
    // What the process says of the place is known once the study has been read.
    let ranges =
        |[x, y]: [[f64; 2]; 2]| table([("x_mm", x.to_vec()), ("y_mm", y.to_vec()), ("yaw_deg", vec![-180.0, 180.0])]);
    let draft = placement_with(ranges([[-1.0, 1.0]; 2]), table([("z_mm", 0.0)]), None)?;
    let study = read_placement(&draft, folder, &Overrides::default())?;
    let (start, bounds) = (first_position(&study), ranges(search_ranges(&study)));
    let candidate = study.candidates.is_empty().then(|| {
        let mut candidate = table([("origin_mm", start.as_slice().to_vec())]);
        candidate.insert("name".into(), "in the middle".into());
        candidate
    });
    placement_with(bounds, table([("z_mm", start.z)]), candidate)
}

/// Key of the tolerance.
const TOLERANCE: &str = "tolerance_mm";

/// Returns whether the process of `feature`, or else that of the study with the keys `head`, gives a tolerance.
fn process_has_tolerance(head: &Table, feature: &Table, folder: &Folder) -> Result<bool> {
    Ok(match feature.get("process").or(head.get("process")) {
        Some(Value::String(file)) => toml_file::parse::<Table>(&folder.text(file)?, file)?.contains_key(TOLERANCE),
        Some(Value::Table(process)) => process.contains_key(TOLERANCE),
        _ => false,
    })
}

/// Returns a TOML table of these entries.
fn table<V: Into<Value>, const N: usize>(entries: [(&str, V); N]) -> Table {
    entries.into_iter().map(|(key, value)| (key.to_string(), value.into())).collect()
}

/// Returns the text of a TOML table.
pub(super) fn to_toml(table: &Table) -> Result<String> {
    toml::to_string(table).map_err(|fault| Error::argument(STUDY, fault.to_string()))
}

/// Returns the first place of the workpiece's origin, mm: the first candidate, or its middle at the tool's home position.
fn first_position(study: &PlacementStudy) -> Vector3<f64> {
    let middle = 0.5 * (study.extent.min + study.extent.max);
    let today = study.candidates.first().map(|candidate| candidate.site.position_mm());
    let home_position = |machine: &Machine, reference: PathReference| {
        let home = reference_position(machine, reference, machine.home.pose.translation);
        match &machine.carrier {
            Some(carrier) => carrier.home.pose.inverse().transform(home),
            None => home,
        }
    };
    let round = |v: f64| v.round() + 0.0;
    today.unwrap_or_else(|| (home_position(&study.machine, study.features[0].feature.reference) - middle).map(round))
}

/// Returns the ranges of x and y to search, mm: the width of the workspace box around the first place.
fn search_ranges(study: &PlacementStudy) -> [[f64; 2]; 2] {
    let start = first_position(study);
    let size = study.machine.workspace.max - study.machine.workspace.min;
    [0, 1]
        .map(|axis| [start[axis] - 0.5 * size[axis].max(1.0), start[axis] + 0.5 * size[axis].max(1.0)].map(f64::round))
}

impl Explorer {
    /// Returns the study file with one candidate more: the workpiece at `place` (x, y, z in mm, yaw, pitch and roll in degrees).
    ///
    /// # Errors
    /// There is no workpiece, or it cannot be placed so.
    pub fn study_file(&self, place: [f64; 6]) -> Result<String> {
        self.workpiece()?;
        let [x, y, z, yaw, pitch, roll] = site_from_shown(place)?.shown();
        let text = self.scene.study.as_deref().unwrap_or_default();
        let mut names = (1..).map(|number| format!("by hand {number}"));
        let name = names.find(|name| !text.contains(name)).unwrap_or_default();
        let origin = format!("origin_mm = [{x:?}, {y:?}, {z:?}]");
        let angles = format!("yaw_deg = {yaw:?}\npitch_deg = {pitch:?}\nroll_deg = {roll:?}");
        let set = |(name, value): &(String, f64)| format!("# with {name} = {value:?} of the machine\n");
        let set: String = self.overrides.parameters.iter().map(set).collect();
        let text =
            format!("{}\n\n{set}[[placement.candidate]]\nname = \"{name}\"\n{origin}\n{angles}\n", text.trim_end());
        read_placement(&text, &self.scene.folder(), &self.overrides)?;
        Ok(text)
    }
}
