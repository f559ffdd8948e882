//! The surface that a path leaves of its stock, and how far that of the tool as it really went is from it.

use kinetostat_removal::{Cutter, Field, Patch, RemovalError};
use nalgebra::{Matrix3, Vector2, Vector3};
use rayon::prelude::*;

use crate::{
    input::error::{Error, Result},
    process::{
        CutPath, PlacedWorkpiece,
        stock::{StockRemoval, is_rapid, is_unknown_way},
    },
    toolpath::Toolpath,
};

/// The surface that a path leaves of its stock, in patches.
#[derive(Debug, Clone, PartialEq)]
pub struct MachinedSurface {
    /// Axes in which its patches are, as rows in W: z to the spindle.
    pub axes: Matrix3<f64>,
    /// Its patches: those of the envelope of the path as programmed, tagged by the index of the point whose move made them.
    pub patches: Vec<Patch>,
    /// Of each course of the tool, how far its surface is beyond each patch along the normal, mm: positive where material is left. `None` on the sides of the stock, and
    /// where the position of the tool is not known.
    pub deviations: Vec<Vec<Option<f64>>>,
    /// Of each course, the index of the point whose move made the surface there; `None` on the sides of the stock and where a program before has made it.
    pub makers: Vec<Vec<Option<u32>>>,
    /// How far it is from the part, where that is given.
    pub against_part: Option<AgainstPart>,
    /// Size of patches, mm: what is narrower may not be seen.
    pub patch_mm: f64,
    /// Whether that is more than half the radius of the smallest tool.
    pub is_coarse: bool,
}

/// How far points of the surface are from the nearest of the part, mm: positive outside of it.
#[derive(Debug, Clone, PartialEq)]
pub struct AgainstPart {
    /// Name of the part's file.
    pub name: String,
    /// Of each patch as programmed, and as each course leaves it. `None` where that is not known, and on the skin of the stock, but for where a course goes below it.
    pub surfaces: Vec<Vec<Option<f64>>>,
    /// Patches of all the stock to the spindle that no move reaches, and how far the part is below them.
    pub not_reached: Vec<(Patch, f64)>,
}

/// How a tool goes along a path: at each point how far its tip is off (W, mm; `None` where that is not known) and how it is rotated (rotation vector in W, rad).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Course<'a> {
    pub errors_mm: &'a [Option<Vector3<f64>>],
    pub rotations: &'a [Vector3<f64>],
}

/// Less is rounding where nothing was to be cut, mm.
pub const GOUGE_MM: f64 = 1e-3;

/// A surface that is left: how far it is beyond each patch, mm, and the points whose moves make it there.
pub(crate) type Left = (Vec<Option<f64>>, Vec<Option<u32>>);
/// Factor of the force on the way to a point.
type FactorAt<'a> = dyn Fn(usize) -> f64 + Sync + 'a;

/// Patches over the plan of what is cut: what a picture shows; and most of them, for small tools.
const PATCHES: f64 = 40_000.0;
const MAX_PATCHES: f64 = 160_000.0;
/// Tag of what programs before have cut.
const EARLIER: u32 = u32::MAX;
/// No point of the surface is farther off than the tool is from its path, but for rounding, as a share and in mm.
const REACH: f64 = 1.001;
const LEAST_REACH_MM: f64 = 1e-5;

impl StockRemoval {
    /// Returns the surface that `path` leaves of the stock, and how far the surfaces are from it that are left by a tool on these `courses`. Moves are cut as the tip goes from point to point: a
    /// gouge by an earlier pass stays. Rotation moves the surface where it is made, to first order; a flat end that is tilted cuts a floor with its lowest edge.
    ///
    /// # Errors
    /// As [`StockRemoval::cut`]; a field too large.
    pub(crate) fn machined(
        &self,
        path: &CutPath,
        placed: &PlacedWorkpiece,
        courses: &[Course<'_>],
        origin: &str,
    ) -> Result<MachinedSurface> {
        let refused = |error: RemovalError| Error::argument(origin, error.to_string());
        let axes = self.axes_along(path, placed);
        let nominal = self.cut_along(path, &axes, |_| Some(Vector3::zeros()), origin)?;
        let (plan, patch_mm, is_coarse) = self.looked_at(&nominal, path, &axes);
        let mut patches = nominal.patches(plan, patch_mm).map_err(refused)?;
        let skin = match &self.part {
            Some(_) => {
                let (plan, patch_mm) = Self::whole_plan(&nominal);
                nominal.patches(plan, patch_mm).map_err(refused)?
            }
            None => Vec::new(),
        };
        drop(nominal);
        let found = courses.iter().map(|course| self.deviations(path, &axes, &patches, *course, &|_| 1.0, origin));
        let (deviations, makers): (Vec<_>, _) = found.collect::<Result<Vec<_>>>()?.into_iter().unzip();
        patches.iter_mut().for_each(|patch| patch.tag = patch.tag.filter(|tag| *tag != EARLIER));
        let mut surface =
            MachinedSurface { axes, patches, deviations, makers, against_part: None, patch_mm, is_coarse };
        surface.against_part = self.part.as_ref().map(|part| {
            let programmed = vec![Some(0.0); surface.patches.len()];
            let all = [&programmed].into_iter().chain(&surface.deviations);
            let surfaces = all.filter_map(|own| self.against_part(&surface, own)).collect();
            let skin = skin.into_par_iter().filter(|patch| patch.tag.is_none() && patch.normal.z > 0.0);
            let above = |patch: Patch| {
                let above = part.surface.distance_mm(&axes.tr_mul(&patch.position));
                (above > 0.0).then_some((patch, above))
            };
            AgainstPart { name: part.name.clone(), surfaces, not_reached: skin.filter_map(above).collect() }
        });
        Ok(surface)
    }

    /// Returns how far from the part patches are that are off the programmed surface by these `deviations`, as in [`AgainstPart`]; `None` if no part is given.
    pub(crate) fn against_part(
        &self,
        surface: &MachinedSurface,
        deviations: &[Option<f64>],
    ) -> Option<Vec<Option<f64>>> {
        let part = self.part.as_ref()?;
        let of = |(patch, deviation): (&Patch, &Option<f64>)| {
            // What no move of the program makes is as it was.
            let deviation = if patch.tag.is_some() { (*deviation)? } else { deviation.unwrap_or(0.0) };
            let at = surface.axes.tr_mul(&(patch.position + deviation * patch.normal));
            let distance = part.surface.distance_mm(&at);
            // That is not to be cut by it, but may be missing by programs before.
            (patch.tag.is_some() || (patch.normal.z > 0.0 && distance < -GOUGE_MM)).then_some(distance)
        };
        Some(surface.patches.par_iter().zip(deviations).map(of).collect())
    }

    /// Returns how far the surface that a tool leaves on `course` is beyond each of `patches`, and what made it, as in [`MachinedSurface`]; tools bend, and are rotated, by `factor`
    /// times the nominal one where they make it.
    ///
    /// # Errors
    /// As [`StockRemoval::machined`].
    pub(crate) fn deviations(
        &self,
        path: &CutPath,
        axes: &Matrix3<f64>,
        patches: &[Patch],
        course: Course<'_>,
        factor: &FactorAt<'_>,
        origin: &str,
    ) -> Result<Left> {
        let Course { errors_mm, rotations } = course;
        let field = self.cut_along(path, axes, |k| errors_mm[k], origin)?;
        let tools = self.tools_of(path);
        let largest = errors_mm.iter().flatten().fold(0.0, |most: f64, own| most.max(own.norm()));
        let reach_mm = REACH * largest + LEAST_REACH_MM;
        let is_known = |k: usize| errors_mm[k].is_some() && (k == 0 || errors_mm[k - 1].is_some());
        let of = |patch: &Patch| {
            let is_looked_at = match patch.tag {
                Some(EARLIER) => true,
                Some(tag) => is_known(tag as usize),
                // The sides of the stock stay, and are not all on its surface here.
                None => patch.normal.z > 0.0,
            };
            if !is_looked_at {
                return (None, None);
            }
            let deviation = field.deviation(&patch.position, &patch.normal, reach_mm);
            let own = patch.tag.filter(|tag| *tag != EARLIER);
            let maker = field.made_by(&deviation).or(own).filter(|tag| *tag != EARLIER);
            let beyond = own.map_or(0.0, |tag| {
                let (tag, tool) = (tag as usize, &tools[&path.points()[tag as usize].tool]);
                let by_rotation =
                    tool.as_ref().map_or(0.0, |tool| by_rotation(path, tag, rotations, axes, patch, &tool.cutter));
                factor(tag) * (beyond_aimed(path, tag, axes, patch) + by_rotation)
            });
            (Some(deviation.mm + beyond), maker)
        };
        Ok(patches.par_iter().map(of).unzip())
    }

    /// Returns the rectangle of the plan of all the stock, and how large patches are that show it.
    fn whole_plan(field: &Field) -> ([Vector2<f64>; 2], f64) {
        let (low, high) = field.stock().bounds();
        let size = (high - low).xy();
        ([low.xy(), high.xy()], (size.x * size.y / PATCHES).sqrt().max(f64::MIN_POSITIVE))
    }

    /// Returns the rectangle of the plan about what `path` cuts, how large patches may be there, mm, and whether that is coarse for its smallest tool.
    fn looked_at(&self, field: &Field, path: &Toolpath, axes: &Matrix3<f64>) -> ([Vector2<f64>; 2], f64, bool) {
        let tools = self.tools_of(path);
        let (mut low, mut high) = (Vector2::repeat(f64::INFINITY), Vector2::repeat(f64::NEG_INFINITY));
        let mut smallest_mm = f64::INFINITY;
        for pair in path.points().windows(2).filter(|pair| !is_rapid(&pair[1])) {
            let Ok(tool) = &tools[&pair[1].tool] else { continue };
            let radius = tool.cutter.radius_mm();
            smallest_mm = smallest_mm.min(radius);
            for at in pair.iter().map(|point| (axes * point.position_mm).xy()) {
                (low, high) = (low.inf(&at.add_scalar(-1.5 * radius)), high.sup(&at.add_scalar(1.5 * radius)));
            }
        }
        let (first, last) = field.stock().bounds();
        let size = (last.xy().inf(&high) - first.xy().sup(&low)).map(|own| own.max(0.0));
        let finest = (size.x * size.y / MAX_PATCHES).sqrt();
        let wanted = (size.x * size.y / PATCHES).sqrt().min(0.5 * smallest_mm);
        ([low, high], wanted.max(finest).max(f64::MIN_POSITIVE), finest > 0.5 * smallest_mm)
    }

    /// Returns what is left of the stock by a tool that is at `shift` from each point of the path (W, mm), by its feed moves; those from or to a
    /// point without one (`None`) are left out. Moves are tagged by the index of their point; of programs before [`EARLIER`].
    fn cut_along(
        &self,
        path: &Toolpath,
        axes: &Matrix3<f64>,
        shift: impl Fn(usize) -> Option<Vector3<f64>>,
        origin: &str,
    ) -> Result<Field> {
        let mut field = self.field(axes, path)?;
        for (origin, path) in self.earlier.iter() {
            self.cut_moves(&mut field, path, origin, axes, |_| Some(Vector3::zeros()), |_| EARLIER)?;
        }
        self.cut_moves(&mut field, path, origin, axes, shift, |k| k as u32)?;
        Ok(field)
    }

    fn cut_moves(
        &self,
        field: &mut Field,
        path: &Toolpath,
        origin: &str,
        axes: &Matrix3<f64>,
        shift: impl Fn(usize) -> Option<Vector3<f64>>,
        tag: impl Fn(usize) -> u32,
    ) -> Result<()> {
        let refused = |problem: String| Error::argument(origin, problem);
        let (tools, points) = (self.tools_of(path), path.points());
        for k in 1..points.len() {
            let (from, to) = (&points[k - 1], &points[k]);
            if is_rapid(to) || is_unknown_way(from, to) {
                continue;
            }
            let Some((start, end)) = shift(k - 1).zip(shift(k)) else { continue };
            let tool = tools[&to.tool].as_ref().map_err(|problem| refused(problem.clone()))?;
            let [start, end] = [from.position_mm + start, to.position_mm + end].map(|at| axes * at);
            field.cut(&tool.cutter, &start, &end, tag(k)).map_err(|error| refused(error.to_string()))?;
        }
        Ok(())
    }
}

/// Returns how far the rotation of the tool moves the surface along its normal where the move to point `tag` makes it, mm: positive where material is left.
fn by_rotation(
    path: &Toolpath,
    tag: usize,
    rotations: &[Vector3<f64>],
    axes: &Matrix3<f64>,
    patch: &Patch,
    cutter: &Cutter,
) -> f64 {
    let before = tag.saturating_sub(1);
    let [from, to] = [before, tag].map(|k| axes * path.points()[k].position_mm);
    let way = to - from;
    let share = if way.xy() == Vector2::zeros() {
        1.0
    } else {
        (patch.position - from).xy().dot(&way.xy()) / way.xy().norm_squared()
    };
    let share = share.clamp(0.0, 1.0);
    let rotation = axes * rotations[before].lerp(&rotations[tag], share);
    let arm = patch.position - (from + share * way);
    let moved = patch.normal.dot(&rotation.cross(&arm));
    let is_floor = patch.normal.z == 1.0 && cutter.height_mm(arm.xy().norm()) == 0.0;
    if !is_floor {
        return moved;
    }
    // The end goes over the place along a chord, the ends of which are off it the most.
    let flat = cutter.radius_mm() - cutter.nose_height_mm();
    let chord = (flat * flat - arm.xy().norm_squared()).max(0.0).sqrt();
    let along =
        Vector3::new(way.x, way.y, 0.0).try_normalize(f64::EPSILON).map_or(0.0, |along| rotation.cross(&along).z.abs());
    moved - along * chord
}

/// Returns how much farther than the bend that the program aims at the tool bends along the normal of a wall where its move `tag` makes it, mm.
fn beyond_aimed(path: &CutPath, tag: usize, axes: &Matrix3<f64>, patch: &Patch) -> f64 {
    let bend = path.engagements().get(tag).and_then(|own| own.bend.as_ref());
    let Some(bend) = bend.filter(|_| patch.normal.z == 0.0) else { return 0.0 };
    let tip = (axes * path.points()[tag].position_mm).z;
    let along_normal = (axes * bend.left).dot(&patch.normal);
    // The normal points out of the material: to the right from a wall on the left.
    let of_wall = bend.at(along_normal < 0.0, patch.position.z - tip);
    of_wall.map_or(0.0, |own| own * along_normal - (axes * bend.aimed_mm).dot(&patch.normal))
}
