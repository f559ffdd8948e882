//! Study files of a workpiece's place or a map: read for a page, with the same keys and checks as [`crate::questions::Study`] has
//! but without those of other questions; written for a path that has none, and with one place more.

use std::{cell::Cell, collections::BTreeMap, path::Path};

use nalgebra::Vector3;
use serde::Deserialize;
use toml::{Table, Value};

use super::{Explorer, STUDY, Scene, place::site};
use crate::{
    input::{
        Folder,
        check::Check,
        error::{Error, Result},
        toml_file,
    },
    machine::Machine,
    process::{PathReference, file::TOLERANCE_MM},
    questions::{
        Given, Overrides, Question, StudyFiles,
        map::{WorkspaceMapStudy, spec::WorkspaceMapSpec},
        placement::{PlacementStudy, at_point, spec::PlacementStudySpec},
        resolve,
        spec::{self, Header, ProcessRef, SCHEMA},
    },
};

/// A study as written.
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
    placement: Option<PlacementStudySpec>,
    workspace_map: Option<WorkspaceMapSpec>,
}

/// What a page can ask.
pub(super) enum Asked {
    /// Where the workpiece should stand.
    Placement(Box<PlacementStudy>),
    /// How far the tool moves.
    Map(Box<WorkspaceMapStudy>),
}

/// The study `text`, whose files are in `folder`, and its machine without the tool of a process.
///
/// # Errors
/// As [`crate::questions::Study::from_toml`].
pub(super) fn read(text: &str, folder: &Folder, overrides: &Overrides) -> Result<(Machine, Asked)> {
    let written: Written = spec::parse(text, STUDY)?;
    let Written { schema, question, machine, branch, locked, process, placement, workspace_map } = written;
    let header = Header { schema, question, machine, branch, locked, process };
    let check = Check::new(STUDY);
    let (machine, _) = resolve::header(&header, folder, overrides, &check)?;
    let given = |check: Check, name: &'static str| Given {
        machine: machine.clone(),
        folder,
        overrides,
        check,
        name,
        header: &header,
        asked_process: Cell::new(false),
    };
    let asked = match (placement, workspace_map) {
        (Some(spec), None) => {
            let study = resolved::<PlacementStudy>(&spec, given(check.key("placement"), PlacementStudy::NAME))?;
            Asked::Placement(Box::new(study))
        }
        (None, Some(spec)) => {
            let study = resolved(&spec, given(check.key("workspace_map"), WorkspaceMapStudy::NAME))?;
            Asked::Map(Box::new(study))
        }
        _ => return check.fail("expected one table, placement or workspace_map".into()),
    };
    Ok((machine, asked))
}

/// The placement study `text`, as [`read`].
///
/// # Errors
/// As [`read`], and of a map.
pub(super) fn read_placement(text: &str, folder: &Folder, overrides: &Overrides) -> Result<PlacementStudy> {
    match read(text, folder, overrides)?.1 {
        Asked::Placement(study) => Ok(*study),
        Asked::Map(_) => Check::new(STUDY).key("placement").fail("missing".into()),
    }
}

fn resolved<Q: Question>(spec: &Q::Spec, given: Given<'_>) -> Result<Q> {
    let resolved = Q::resolve(spec, &given)?;
    given.refuse_unused()?;
    Ok(resolved.study)
}

/// The machine of a scene without a study.
///
/// # Errors
/// There is no such machine, or its file is not of the expected form.
pub(super) fn machine(scene: &Scene, folder: &Folder, overrides: &Overrides) -> Result<Machine> {
    let header = Header {
        schema: SCHEMA,
        question: "explored".into(),
        machine: scene.machine.clone(),
        branch: None,
        locked: BTreeMap::new(),
        process: None,
    };
    Ok(resolve::header(&header, folder, overrides, &Check::new(STUDY))?.0)
}

/// A program and the process by which it is cut, as files.
#[derive(Debug, Clone, Copy)]
pub struct ProgramAtProcess<'a> {
    /// A built-in machine, or a machine file.
    pub machine: &'a str,
    /// A process file.
    pub process: &'a Path,
    /// A polyline or a G-code program.
    pub program: &'a Path,
    /// How far the tool may be from its path, mm; as its process says if not given, or else 0.1.
    pub tolerance_mm: Option<f64>,
}

impl Scene {
    /// A program on a machine: where the process puts it, or else with its middle where the tool is at home.
    ///
    /// # Errors
    /// Files that cannot be read or are not of the expected form.
    #[cfg(feature = "report")]
    pub fn of_program(asked: &ProgramAtProcess<'_>) -> Result<Self> {
        let name = |path: &Path| path.to_string_lossy().replace('\\', "/");
        let head = table([("machine", asked.machine.to_string()), ("process", name(asked.process))]);
        let mut feature = table([("file", name(asked.program))]);
        feature.extend(asked.tolerance_mm.map(|tolerance_mm| (TOLERANCE.to_string(), tolerance_mm.into())));
        let stem = asked.program.file_stem().map_or_else(|| "path".into(), |stem| stem.to_string_lossy().into_owned());
        feature.insert("name".into(), stem.into());
        let folder = Folder::from(Path::new("")).noting();
        let text = placement(head, feature, &folder)?;
        Self::of_text(&text, &folder.noted())
    }
}

/// The study of the place of a path study's workpiece.
///
/// # Errors
/// A path that no such study can have.
pub(super) fn placement_of_path(files: &StudyFiles) -> Result<String> {
    let mut head: Table = toml_file::parse(&files.text, STUDY)?;
    let check = Check::new(STUDY).key("path");
    let Some(Value::Table(path)) = head.remove("path") else { return check.fail("missing".into()) };
    let kept = path.into_iter().filter(|(key, _)| ["circle", "file", "process"].contains(&key.as_str()));
    let mut feature: Table = kept.collect();
    if !feature.contains_key("circle") && !feature.contains_key("file") {
        return check.fail("is a line: expected a circle or a program, whose workpiece can be put elsewhere".into());
    }
    feature.insert("name".into(), "path".into());
    let named = files.named.iter().map(|(name, bytes)| (name.clone(), bytes.clone()));
    placement(head, feature, &Folder::in_memory(named))
}

/// A placement study with the keys `head` that all studies have, for one feature.
fn placement(mut head: Table, mut feature: Table, folder: &Folder) -> Result<String> {
    if !feature.contains_key(TOLERANCE) && !process_has_tolerance(&head, &feature, folder)? {
        feature.insert(TOLERANCE.into(), TOLERANCE_MM.into());
    }
    head.entry("schema").or_insert_with(|| i64::from(SCHEMA).into());
    head.insert("question".into(), "Where should this workpiece stand?".into());
    let with = |bounds: Table, fixed: Table, candidate: Option<Table>| {
        let mut placement = table::<Value, _>([
            ("feature", Value::Array(vec![feature.clone().into()])),
            ("bounds", bounds.into()),
            ("fixed", fixed.into()),
            ("objective", table([("weights", table([("worst_deflection", 1.0)]))]).into()),
            ("search", table([("grid", table([("x", 5), ("y", 5), ("yaw", 4)]))]).into()),
        ]);
        placement.extend(candidate.map(|candidate| ("candidate".to_string(), Value::Array(vec![candidate.into()]))));
        let mut whole = head.clone();
        whole.insert("placement".into(), placement.into());
        written(&whole)
    };
    // What the process says of the place is known once the study has been read.
    let within =
        |[x, y]: [[f64; 2]; 2]| table([("x_mm", x.to_vec()), ("y_mm", y.to_vec()), ("yaw_deg", vec![-180.0, 180.0])]);
    let draft = with(within([[-1.0, 1.0]; 2]), table([("z_mm", 0.0)]), None)?;
    let study = read_placement(&draft, folder, &Overrides::default())?;
    let (start, bounds) = (start(&study), within(ranges(&study)));
    let candidate = study.candidates.is_empty().then(|| {
        let mut candidate = table([("origin_mm", start.as_slice().to_vec())]);
        candidate.insert("name".into(), "in the middle".into());
        candidate
    });
    with(bounds, table([("z_mm", start.z)]), candidate)
}

const TOLERANCE: &str = "tolerance_mm";

/// Whether the process of `feature`, or else that of the study with the keys `head`, says how far the tool may be from its path.
fn process_has_tolerance(head: &Table, feature: &Table, folder: &Folder) -> Result<bool> {
    Ok(match feature.get("process").or(head.get("process")) {
        Some(Value::String(file)) => toml_file::parse::<Table>(&folder.text(file)?, file)?.contains_key(TOLERANCE),
        Some(Value::Table(process)) => process.contains_key(TOLERANCE),
        _ => false,
    })
}

fn table<V: Into<Value>, const N: usize>(entries: [(&str, V); N]) -> Table {
    entries.into_iter().map(|(key, value)| (key.to_string(), value.into())).collect()
}

pub(super) fn written(table: &Table) -> Result<String> {
    toml::to_string(table).map_err(|fault| Error::argument(STUDY, fault.to_string()))
}

/// Where the workpiece stands first, mm.
fn start(study: &PlacementStudy) -> Vector3<f64> {
    let middle = 0.5 * (study.extent.min + study.extent.max);
    let today = study.candidates.first().map(|candidate| candidate.site.position_mm());
    let of_machine = |machine: &Machine, reference: PathReference| {
        let home = at_point(machine, reference, machine.home.pose.translation);
        match &machine.carrier {
            Some(carrier) => carrier.home.pose.inverse().transform(home),
            None => home,
        }
    };
    let round = |v: f64| v.round() + 0.0;
    today.unwrap_or_else(|| (of_machine(&study.machine, study.features[0].feature.reference) - middle).map(round))
}

/// Where x and y may be sought: as far to either side of the first place as the workspace box is wide.
fn ranges(study: &PlacementStudy) -> [[f64; 2]; 2] {
    let start = start(study);
    let size = study.machine.workspace.max - study.machine.workspace.min;
    [0, 1]
        .map(|axis| [start[axis] - 0.5 * size[axis].max(1.0), start[axis] + 0.5 * size[axis].max(1.0)].map(f64::round))
}

impl Explorer {
    /// The study file with one candidate more: the workpiece at `place` (x, y, z in mm, yaw, pitch and roll in degrees).
    ///
    /// # Errors
    /// There is no workpiece, or it cannot be turned so.
    pub fn study_file(&self, place: [f64; 6]) -> Result<String> {
        self.workpiece()?;
        let [x, y, z, yaw, pitch, roll] = site(place)?.shown();
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
