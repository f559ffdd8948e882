//! Bodies of links: their shapes as machine files have them, with the meshes that are found, and which of them overlap at home.

use std::path::{Path, PathBuf};

use kinetostat_cell::spec::BodySpec;
use nalgebra::Vector3;

use super::{
    chain::{Element, in_mm, pose, times_thousand},
    notes::ImportNotes,
    read::{Link, LinkShape, ShapeKind},
    source::quoted,
    write::vector_text,
};
use crate::{
    input::{
        check::Check,
        error::{Error, Result},
        file, toml_file,
    },
    machine::Machine,
    spatial::Pose,
};

/// A link's body in a frame of the machine: shapes with their poses, mm.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LinkBody {
    name: String,
    shapes: Vec<(Pose, ShapeKind)>,
}

/// Shapes at most: a machine may have as many bodies.
const MAX_SHAPES: usize = 500;

/// Makes the bodies of links.
#[derive(Debug)]
pub(super) struct LinkBodies {
    /// The folder of the URDF.
    folder: PathBuf,
    /// Number of shapes that are used, and of all.
    count: [usize; 2],
    /// Which were left out, and why.
    left_out: Vec<String>,
}

impl LinkBodies {
    /// Begins with the URDF called `origin`.
    pub fn new(origin: &str) -> Self {
        let file = std::path::absolute(origin).unwrap_or_default();
        Self { folder: file.parent().unwrap_or(Path::new("")).into(), count: [0; 2], left_out: Vec::new() }
    }

    /// Returns the body of `link` in the frame in which the link is at `pose_here`; `None` if it has no shape that can be used.
    pub fn of(&mut self, link: &Link, pose_here: &Pose) -> Option<Element> {
        let (mut shapes, at_most) = (Vec::new(), MAX_SHAPES - self.count[0]);
        for shape in link.shapes.iter().take(at_most) {
            match self.found(link, shape, pose_here) {
                Ok(found) => shapes.push(found),
                Err(error) => self.left_out.push(error.to_string()),
            }
        }
        self.count = [self.count[0] + shapes.len(), self.count[1] + link.shapes.len()];
        (!shapes.is_empty()).then(|| Element::Body(LinkBody { name: link.name.clone(), shapes }))
    }

    /// Returns a shape with the whole path of its mesh. Fails if no machine file could have it, or its mesh is not found.
    fn found(&self, link: &Link, shape: &LinkShape, pose_here: &Pose) -> Result<(Pose, ShapeKind)> {
        let place = format!("link {}", quoted(&link.name));
        let (origin, mut kind) = shape.clone().map_err(|text| {
            let expected = "expected a box, a cylinder, a sphere, or a mesh of scale 1 or 0.001";
            Error::argument(&place, format!("{text}: {expected}"))
        })?;
        if let ShapeKind::Mesh(name, _) = &mut kind {
            let (scheme, path) = name.split_once("://").unwrap_or(("", name));
            // A package is a folder above, or beside one of these, and may be called otherwise.
            let within = path.split_once('/').map_or(path, |own| own.1);
            let places = self.folder.ancestors().flat_map(|above| [above.join(path), above.join(within)]);
            let count = if ["", "file"].contains(&scheme) { 1 } else { usize::MAX };
            let file = places.take(count).find(|file| file.is_file()).and_then(|own| own.to_str().map(String::from));
            *name = file.ok_or_else(|| Error::argument(&place, format!("{} is not found", quoted(name))))?;
        }
        let shape = (pose_here.compose(&pose(in_mm(origin.xyz), origin.rpy)), kind);
        let body = LinkBody { name: link.name.clone(), shapes: vec![shape.clone()] };
        let spec: BodySpec = toml_file::parse(&body.keys().join("\n"), &place)?;
        let check = Check::new(&place);
        check.key("name").readable(&spec.name)?;
        spec.resolve("", 0, Some(&|name| file::read(Path::new(name))), &check)?;
        Ok(shape)
    }

    /// Notes what bodies there are, and what was left out.
    pub fn note(self, notes: &mut ImportNotes) {
        let [used, all] = self.count;
        if all > 0 {
            notes.add(format!(
                "bodies: {used} of {all} shapes of <collision>, or of <visual> of links without, graded \"assumed\": cables and hoses are not among \
                 them, so they may reject a place and never clear one; set grade = \"given\" where you have measured"
            ));
        }
        if !self.left_out.is_empty() {
            let left_out = self.left_out.join("; ").replace(char::is_control, " ");
            let how = "FreeCAD, MeshLab or Blender make a closed STL file of another mesh";
            notes.add(format!("shapes left out, against which nothing is held: {left_out}; {how}"));
        }
    }
}

impl LinkBody {
    /// Returns the keys of its table.
    pub fn keys(&self) -> [String; 3] {
        let shapes = self.shapes.iter().map(|(at, kind)| shape_text(at, kind)).collect::<Vec<_>>().join(", ");
        let name = toml::Value::from(self.name.as_str());
        [format!("name = {name}"), "grade = \"assumed\"".into(), format!("shapes = [{shapes}]")]
    }
}

/// Returns a shape as machine files have it.
fn shape_text(at: &Pose, kind: &ShapeKind) -> String {
    // What is less than a millionth is rounding of turns.
    let rounded = |v: [f64; 3]| vector_text(v.map(|x| (x * 1e6).round() / 1e6));
    let along = |z: f64| rounded(at.transform(Vector3::z() * z).into());
    let placed = || format!("at_mm = {}, rotation_deg = {}", along(0.0), rounded(at.roll_pitch_yaw_deg()));
    let round = |kind: &str, half: f64, radius: f64| {
        let (from, to, radius) = (along(-half), along(half), times_thousand(radius));
        format!("{{ {kind} = {{ from_mm = {from}, to_mm = {to}, radius_mm = {radius:?} }} }}")
    };
    match kind {
        ShapeKind::Box(size) => format!("{{ box = {{ size_mm = {}, {} }} }}", vector_text(in_mm(*size)), placed()),
        ShapeKind::Cylinder(radius, length) => round("cylinder", 0.5 * times_thousand(*length), *radius),
        ShapeKind::Sphere(radius) => round("capsule", 0.0, *radius),
        ShapeKind::Mesh(file, unit) => {
            let file = toml::Value::from(file.as_str());
            format!("{{ mesh = {{ file = {file}, unit = \"{unit}\", {} }} }}", placed())
        }
    }
}

/// Takes the bodies before the first drive and behind the last one out of the chain `elements`, and returns them as tables: in O and in P.
pub(super) fn taken_out(elements: Vec<Element>) -> (Vec<Element>, String) {
    let is_drive = |element: &Element| matches!(element, Element::Drive(_));
    let first = elements.iter().position(is_drive).unwrap_or(elements.len());
    let last = elements.iter().rposition(is_drive).unwrap_or_default();
    let behind = elements[last..].iter().fold(Pose::identity(), |all, element| all.compose(&element.pose()));
    let (mut kept, mut tables, mut here) = (Vec::new(), String::new(), Pose::identity());
    for (index, element) in elements.into_iter().enumerate() {
        here = if index == last { behind.inverse() } else { here.compose(&element.pose()) };
        match element {
            Element::Body(LinkBody { name, shapes }) if index < first || index > last => {
                let shapes = shapes.into_iter().map(|(at, kind)| (here.compose(&at), kind)).collect();
                let table = if index < first { "body" } else { "platform.body" };
                tables += &format!("\n[[{table}]]\n{}\n", LinkBody { name, shapes }.keys().join("\n"));
            }
            other => kept.push(other),
        }
    }
    (kept, tables)
}

/// Returns the pairs of bodies of `machine` that overlap at home and are not joined, as `may_touch` has them.
pub(super) fn overlapping(machine: &Machine) -> Vec<String> {
    let Ok(cell) = machine.cell() else { return Vec::new() };
    let mut poses = Vec::new();
    machine.frame_poses(&machine.home, &mut poses);
    let touching = cell.separations(&poses).into_iter().filter(|own| own.distance_mm <= 0.0);
    let name = |body: usize| toml::Value::from(cell.bodies()[body].name.as_str());
    touching.map(|own| format!("[{}, {}]", name(own.pair[0]), name(own.pair[1]))).collect()
}
