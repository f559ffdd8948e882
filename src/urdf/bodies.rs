//! Bodies of links: their shapes as machine files have them, with the meshes that are found, and which of them overlap at home.

use std::path::{Path, PathBuf};

use kinetostat_cell::{
    BodyGrade,
    spec::{BodySpec, BoxShapeSpec, MeshSpec, ShapeSpec},
};

use super::{
    chain::{Element, in_mm, pose},
    read::Link,
    source::quoted,
};
use crate::{
    input::{check::Check, error::Result, file},
    machine::Machine,
    spatial::Pose,
};

/// What a shape may be.
const EXPECTED: &str = "expected a box, a cylinder, a sphere, or a mesh of scale 1 or 0.001";

/// Shapes of all links at most.
const MAX_SHAPES: usize = 500;
/// Radius of a ball around the largest shape of a link, mm: beyond any robot.
const LARGEST_MM: f64 = 10_000.0;

/// Makes the bodies of links.
#[derive(Debug, Default)]
pub(super) struct LinkBodies {
    /// The whole path of the URDF.
    pub urdf: PathBuf,
    /// Bodies in O and in P, a line each.
    pub ends: [String; 2],
    /// Number of shapes that are used, and of all.
    pub count: [usize; 2],
    /// Which were left out, and why.
    pub left_out: Vec<String>,
}

impl LinkBodies {
    /// Adds the body of `link`, whose frame is at `at` in O or P, which `end` says, or in the chain: then it is returned. A link without usable shapes has none.
    pub fn add(&mut self, link: &Link, at: &Pose, end: Option<usize>) -> Option<Element> {
        let check = Check::new(&format!("link {}", quoted(&link.name)));
        let body = |shapes| BodySpec { name: link.name.clone(), grade: BodyGrade::Assumed, shapes };
        let (mut shapes, before) = (Vec::new(), self.count[0]);
        let room = MAX_SHAPES - before;
        if link.shapes.len() > room {
            let problem =
                format!("link {}: {} shapes beyond {MAX_SHAPES} in all", quoted(&link.name), link.shapes.len() - room);
            self.left_out.push(problem);
        }
        for shape in link.shapes.iter().take(room) {
            let own = shape.clone().or_else(|text| check.key("shapes").fail(format!("{text}: {EXPECTED}")));
            let own = own.and_then(|(origin, shape)| {
                let shape = self.placed(shape, &at.compose(&pose(in_mm(origin.xyz), origin.rpy)), &check)?;
                check.key("name").readable(&link.name)?;
                let read = |name: &str| file::read(Path::new(name));
                let ball = body(vec![shape.clone()]).resolve(&link.name, 0, Some(&read), &check)?.map(|own| own.ball());
                match ball {
                    Some((_, radius)) if radius > LARGEST_MM => {
                        let problem = format!("{:.0} m across: are the numbers of its file millimetres? scale=\"0.001 0.001 0.001\" says so", 2e-3 * radius);
                        check.key("shapes").fail(problem)
                    }
                    _ => Ok(shape),
                }
            });
            own.map_or_else(|error| self.left_out.push(error.to_string()), |shape| shapes.push(shape));
        }
        self.count = [before + shapes.len(), self.count[1] + link.shapes.len()];
        let text = toml::Value::try_from(body(shapes)).ok().filter(|_| self.count[0] > before)?.to_string();
        let Some(end) = end else { return Some(Element::Body(text)) };
        self.ends[end] += &format!("  {text},\n");
        None
    }

    /// Returns a shape whose own frame is at `at`, with the whole path of its mesh, which must be there.
    fn placed(&self, mut shape: ShapeSpec, at: &Pose, check: &Check) -> Result<ShapeSpec> {
        // What is less than a millionth is rounding of turns.
        let rounded = |own: [f64; 3]| own.map(|x| (x * 1e6).round() / 1e6 + 0.0);
        match &mut shape {
            ShapeSpec::Capsule(own) | ShapeSpec::Cylinder(own) => {
                let moved = |end: [f64; 3]| rounded(at.transform(end.into()).into());
                (own.from_mm, own.to_mm) = (moved(own.from_mm), moved(own.to_mm));
            }
            ShapeSpec::Box(BoxShapeSpec { at_mm, rotation_deg, .. })
            | ShapeSpec::Mesh(MeshSpec { at_mm, rotation_deg, .. }) => {
                (*at_mm, *rotation_deg) = (rounded(at.translation.into()), rounded(at.roll_pitch_yaw_deg()));
            }
            ShapeSpec::Hull(_) => {}
        }
        if let ShapeSpec::Mesh(MeshSpec { file, .. }) = &mut shape {
            let (scheme, path) = file.split_once("://").unwrap_or(("", file));
            // A package is a folder above, or beside one of these, and may be called otherwise.
            let within = path.split_once('/').map_or(path, |own| own.1);
            let above = || self.urdf.ancestors().skip(1);
            let places = above().map(|above| above.join(path)).chain(above().map(|above| above.join(within)));
            let count = if ["", "file"].contains(&scheme) { 1 } else { usize::MAX };
            let found = places.take(count).find(|file| file.is_file()).and_then(|own| own.to_str().map(String::from));
            *file = found.map_or_else(|| check.key("mesh").fail(format!("{} is not found", quoted(file))), Ok)?;
        }
        Ok(shape)
    }

    /// Notes what bodies there are and what was left out, and returns the keys of those in O and in P.
    pub fn finish(self, notes: &mut Vec<String>) -> [String; 2] {
        let [used, all] = self.count;
        if all > 0 {
            notes.push(format!(
                "bodies: {used} of {all} shapes of <collision>, or of <visual> of links without, graded \"assumed\": cables and hoses are not among \
                 them, so they may reject a place and never clear one; set grade = \"given\" where you have measured"
            ));
        }
        if !self.left_out.is_empty() {
            let left_out = self.left_out.join("; ").replace(char::is_control, " ");
            notes.push(format!("shapes left out, against which nothing is held: {left_out}; FreeCAD, MeshLab or Blender make closed STL files of other meshes"));
        }
        self.ends.map(|list| if list.is_empty() { list } else { format!("body = [\n{list}]\n") })
    }
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
