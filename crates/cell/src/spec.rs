//! Bodies as files have them: raw, units in the keys, unknown keys refused; and made of that.

use std::path::Path;

use kinetostat_input::{check::Check, error::Result, tables};
use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use crate::{Body, BodyFault, BodyGrade, Mesh, Shape, pieces_of_mesh, read_stl, shape::Piece};

tables! {
    /// A body: shapes that move with a frame, for what must not touch what.
    #[derive(PartialEq, Serialize)]
    pub struct BodySpec {
        /// Its name in answers.
        pub name: String,
        /// How well it is known: "given" (measured or drawn), "enclosing" or "assumed"; assumed if not given.
        #[serde(default)]
        pub grade: BodyGrade,
        /// Its shapes, in the frame.
        pub shapes: Vec<ShapeSpec>,
    }

    /// A capsule or a cylinder, from one end of its axis to the other.
    #[derive(PartialEq, Serialize)]
    pub struct RoundShapeSpec {
        /// One end of its axis.
        pub from_mm: [f64; 3],
        /// The other end.
        pub to_mm: [f64; 3],
        /// Its radius.
        pub radius_mm: f64,
    }

    /// A box.
    #[derive(PartialEq, Serialize)]
    pub struct BoxShapeSpec {
        /// Its lengths along its own axes.
        pub size_mm: [f64; 3],
        /// Its centre; the origin if not given.
        #[serde(default)]
        pub at_mm: [f64; 3],
        /// Roll, pitch, yaw about the fixed x, y, z axes of the frame; 0 if not given.
        #[serde(default)]
        pub rotation_deg: [f64; 3],
    }

    /// The convex hull of points.
    #[derive(PartialEq, Serialize)]
    pub struct HullSpec {
        /// The points, four or more that are not in a plane.
        pub points_mm: Vec<[f64; 3]>,
    }

    /// A closed surface in an STL file, of which convex pieces are made that enclose it.
    #[derive(PartialEq, Serialize)]
    pub struct MeshSpec {
        /// The file, from the folder of the file that names it.
        pub file: String,
        /// Unit of its numbers: "mm", "m" or "inch", required where all are within a ball of radius 10; mm if not given.
        pub unit: Option<MeshUnit>,
        /// Where its origin is; the origin of the frame if not given.
        #[serde(default)]
        pub at_mm: [f64; 3],
        /// Roll, pitch, yaw about the fixed x, y, z axes of the frame; 0 if not given.
        #[serde(default)]
        pub rotation_deg: [f64; 3],
        /// Convex pieces at most; 12 if not given.
        pub pieces: Option<usize>,
    }
}

/// A shape: a table with exactly one of these keys.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ShapeSpec {
    /// All places within a radius of a line; a ball where both ends are one.
    Capsule(RoundShapeSpec),
    /// A cylinder with flat ends.
    Cylinder(RoundShapeSpec),
    /// A box.
    Box(BoxShapeSpec),
    /// The convex hull of points.
    Hull(HullSpec),
    /// A surface in an STL file.
    Mesh(MeshSpec),
}

/// Unit of a mesh.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum MeshUnit {
    /// Millimetre.
    #[default]
    Mm,
    /// Metre.
    M,
    /// 25.4 mm.
    Inch,
}

impl MeshUnit {
    fn mm(self) -> f64 {
        match self {
            MeshUnit::Mm => 1.0,
            MeshUnit::M => 1000.0,
            MeshUnit::Inch => 25.4,
        }
    }
}

/// Pieces of a mesh, if not given; and at most.
const PIECES: usize = 12;
const MAX_PIECES: usize = 64;
/// Points of a hull and shapes of a body at most.
const MAX_POINTS: usize = 10_000;
const MAX_SHAPES: usize = 1000;
/// A body within a ball of this radius is one in a wrong unit, mm.
const SMALLEST_MM: f64 = 1.0;
/// And one that is in no ball of this radius.
const LARGEST_MM: f64 = 1e6;
/// A mesh within a ball of this radius must name its unit, mm.
const SMALLEST_WITHOUT_UNIT_MM: f64 = 10.0;

/// Returns the bytes of a file that a mesh names.
pub type ReadMesh<'a> = &'a dyn Fn(&str) -> Result<Vec<u8>>;

impl BodySpec {
    /// The files of its meshes, as they are named.
    pub fn mesh_files(&self) -> impl Iterator<Item = &str> {
        self.shapes.iter().filter_map(|shape| match shape {
            ShapeSpec::Mesh(mesh) => Some(mesh.file.as_str()),
            _ => None,
        })
    }

    /// Makes the body on frame number `frame`, named `name`. Without `read` meshes are left out, unread, and `None` is returned if nothing
    /// else is left.
    ///
    /// # Errors
    /// A shape has no volume, a number that is none, or a size that is that of another unit; a mesh cannot be read, is open or inside out.
    pub fn resolve(&self, name: &str, frame: usize, read: Option<ReadMesh<'_>>, check: &Check) -> Result<Option<Body>> {
        let check_shapes = check.key("shapes");
        if self.shapes.is_empty() || self.shapes.len() > MAX_SHAPES {
            return check_shapes.fail(format!("expected 1 to {MAX_SHAPES} shapes, got {}", self.shapes.len()));
        }
        let mut shapes = Vec::new();
        for (index, shape) in self.shapes.iter().enumerate() {
            shapes.extend(shape.resolve(read, &check_shapes.item(index))?);
        }
        match Body::new(name, frame, self.grade, &shapes) {
            Ok(body) => Ok(Some(body)),
            Err(BodyFault::NoShape) => Ok(None),
            Err(fault) => check.fail(fault.to_string()),
        }
    }
}

impl ShapeSpec {
    /// Makes convex shapes of it; none of a mesh without `read`.
    fn resolve(&self, read: Option<ReadMesh<'_>>, check: &Check) -> Result<Vec<Shape>> {
        let (check, shape) = match self {
            ShapeSpec::Capsule(round) => {
                let check = check.key("capsule");
                let (ends_mm, radius_mm) = round.resolve(&check)?;
                (check, Shape::Capsule { ends_mm, radius_mm })
            }
            ShapeSpec::Cylinder(round) => {
                let check = check.key("cylinder");
                let (ends_mm, radius_mm) = round.resolve(&check)?;
                (check, Shape::Cylinder { ends_mm, radius_mm })
            }
            ShapeSpec::Box(cuboid) => {
                let check = check.key("box");
                let pose = pose_of(cuboid.at_mm, cuboid.rotation_deg, &check)?;
                let size = check.key("size_mm");
                let lengths = cuboid.size_mm.iter().enumerate().map(|(axis, own)| size.item(axis).length(*own));
                let lengths: Vec<f64> = lengths.collect::<Result<_>>()?;
                (check, Shape::Cuboid { pose, size_mm: Vector3::from_row_slice(&lengths) })
            }
            ShapeSpec::Hull(hull) => {
                let check = check.key("hull");
                let points = check.key("points_mm");
                if hull.points_mm.len() > MAX_POINTS {
                    return points.fail(format!("expected at most {MAX_POINTS} points, got {}", hull.points_mm.len()));
                }
                let own = hull.points_mm.iter().enumerate();
                let own = own.map(|(index, own)| Ok(Point3::from(points.item(index).position(*own)?)));
                (check, Shape::Hull { points_mm: own.collect::<Result<_>>()? })
            }
            ShapeSpec::Mesh(mesh) => return mesh.resolve(read, &check.key("mesh")),
        };
        let piece = Piece::new(&shape).or_else(|fault| check.fail(fault.to_string()))?;
        check_size(piece.ball.1, "", &check)?;
        Ok(vec![shape])
    }
}

impl RoundShapeSpec {
    /// Checks ends and radius, mm.
    fn resolve(&self, check: &Check) -> Result<([Point3<f64>; 2], f64)> {
        let ends = [check.key("from_mm").position(self.from_mm)?, check.key("to_mm").position(self.to_mm)?];
        Ok((ends.map(Point3::from), check.key("radius_mm").length(self.radius_mm)?))
    }
}

/// Returns the pose at `at_mm`, turned by roll, pitch and yaw.
fn pose_of(at_mm: [f64; 3], rotation_deg: [f64; 3], check: &Check) -> Result<Isometry3<f64>> {
    let at = check.key("at_mm").position(at_mm)?;
    let [roll, pitch, yaw] = check.key("rotation_deg").finite(rotation_deg)?.map(f64::to_radians).into();
    Ok(Isometry3::from_parts(at.into(), UnitQuaternion::from_euler_angles(roll, pitch, yaw)))
}

/// Returns whether `pairs` name two bodies, in whichever order.
#[must_use]
pub fn may_touch(pairs: &[[String; 2]], [a, b]: [&str; 2]) -> bool {
    pairs.iter().any(|[one, other]| [one.as_str(), other] == [a, b] || [one.as_str(), other] == [b, a])
}

/// Checks that each pair names two bodies, which `is_name` knows; `names` lists them.
///
/// # Errors
/// A pair that does not, by its place.
pub fn check_pairs(pairs: &[[String; 2]], names: &str, is_name: impl Fn(&String) -> bool, check: &Check) -> Result<()> {
    for (index, pair) in pairs.iter().enumerate() {
        let check = check.key("may_touch").item(index);
        if pair[0] == pair[1] {
            return check.fail(format!("is \"{}\" twice: expected two bodies", pair[0]));
        }
        if let Some(name) = pair.iter().find(|name| !is_name(name)) {
            return check.fail(format!("no body is called \"{name}\"; there are: {names}"));
        }
    }
    Ok(())
}

/// Checks that what has a ball of `radius` mm around it is not given in another unit; `how` says how to name the unit.
fn check_size(radius: f64, how: &str, check: &Check) -> Result<()> {
    match radius {
        _ if radius < SMALLEST_MM => check
            .fail(format!("fits into a ball of {radius:.3} mm radius: expected millimetres; is it in metres?{how}")),
        _ if radius > LARGEST_MM => {
            check.fail(format!("needs a ball of {radius:.0} mm radius: expected millimetres{how}"))
        }
        _ => Ok(()),
    }
}

impl MeshSpec {
    /// Reads the file and makes convex pieces of it; none without `read`.
    fn resolve(&self, read: Option<ReadMesh<'_>>, check: &Check) -> Result<Vec<Shape>> {
        let pose = pose_of(self.at_mm, self.rotation_deg, check)?;
        let pieces = self.pieces.unwrap_or(PIECES);
        if !(1..=MAX_PIECES).contains(&pieces) {
            return check.key("pieces").fail(format!("expected 1 to {MAX_PIECES}, got {pieces}"));
        }
        let check_file = check.key("file");
        let ending = Path::new(&self.file).extension().map(|own| own.to_string_lossy().to_lowercase());
        match ending.as_deref() {
            Some("stl") => {}
            Some("step" | "stp" | "iges" | "igs") => {
                let problem = "is a CAD model: expected an STL file; export one from the CAD system, or with FreeCAD: open it, select the part, File, \
                               Export, STL Mesh";
                return check_file.fail(problem.into());
            }
            _ => return check_file.fail(format!("expected an STL file, got \"{}\"", self.file)),
        }
        let Some(read) = read else { return Ok(Vec::new()) };
        let fault = |problem: String| check_file.fail(format!("{} {problem}", self.file));
        let bytes = match read(&self.file) {
            Ok(bytes) => bytes,
            Err(error) => return check_file.fail(error.to_string()),
        };
        let Mesh { vertices, triangles } = match read_stl(bytes) {
            Ok(mesh) => mesh,
            Err(problem) => return fault(problem),
        };
        let vertices: Vec<Point3<f64>> =
            vertices.iter().map(|own| pose * (own * self.unit.unwrap_or_default().mm())).collect();
        let corners: Vec<[Point3<f64>; 3]> =
            triangles.iter().map(|own| own.map(|index| vertices[index as usize])).collect();
        let shapes = pieces_of_mesh(&corners, pieces).or_else(|problem| fault(problem.to_string()))?;
        let (low, high) =
            vertices.iter().fold((vertices[0], vertices[0]), |(low, high), own| (low.inf(own), high.sup(own)));
        let radius = 0.5 * (high - low).norm();
        match self.unit {
            // What stands in a cell is rarely so small, and in metres often of these numbers.
            None if radius < SMALLEST_WITHOUT_UNIT_MM => {
                let problem = format!(
                    "has numbers within a ball of radius {radius:.3}: are they metres, or millimetres? unit = \"m\", \"mm\" or \"inch\" says so"
                );
                return check_file.fail(problem);
            }
            None => check_size(radius, "; unit = \"m\" or \"inch\" says so", &check_file)?,
            Some(_) => check_size(radius, "", &check_file)?,
        }
        Ok(shapes)
    }
}
