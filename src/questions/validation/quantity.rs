//! Key figures of a path, as papers and measurement reports quote them, and how each is computed.

use nalgebra::{Vector2, Vector3};
use serde::{Deserialize, Serialize};

use super::circle_shape::{Shape, angle_deg, crossings};
use crate::{
    machine::{Machine, Motion},
    questions::path::{PathResults, PointEffect},
    simulation::{ROUNDING_MM, Source, along_path::PathPointResult},
};

/// A key figure of a path that may be quoted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Size of the cutting force at the first point.
    ForceAtStart,
    /// Moment of the load about the x axis through P at the first point.
    MomentXAtStart,
    /// Moment of the load about the y axis through P at the first point.
    MomentYAtStart,
    /// Largest displacement of the compensated point by the cutting force alone.
    DeflectionByCutting,
    /// Largest displacement of that point by the chain errors alone.
    DeflectionByChainErrors,
    /// Largest displacement of that point by all sources at once.
    DeflectionByBoth,
    /// Largest |Δρ| of any drive under all sources; of machines with one kind of drives.
    Correction,
    /// Largest |Δρ| of any prismatic drive under all sources.
    CorrectionOfPrismatic,
    /// Largest |Δρ| of any revolute drive under all sources.
    CorrectionOfRevolute,
    /// Largest force of any drive on the compensated path, under all sources; of machines with one kind of drives.
    DriveForce,
    /// Largest force of any prismatic drive on the compensated path, under all sources.
    ForceOfPrismatic,
    /// Largest torque of any revolute drive on the compensated path, under all sources.
    TorqueOfRevolute,
    /// Largest residual error after compensation.
    ResidualError,
    /// Largest size of the sum of the single-source displacements, over that of the displacement by both at once.
    SuperpositionRatio,
    /// Largest superposition error (length of a vector), over the largest displacement by both at once.
    SuperpositionError,
    /// Share of the points at which the displacement by both at once is smaller than that sum.
    ShareBelowSuperposition,
    /// Cosine of the angle between the shifts of the centres of the path displaced by both and of the commanded one.
    CosineOfCentreShifts,
    /// Angle between the longest axis of the path displaced by both and the shortest of the commanded one.
    AxesAngle,
    /// Number of times that the path displaced by the cutting force crosses the target circle.
    Crossings,
}

impl Quantity {
    /// Returns the word for the quantity in study files and tables.
    pub fn label(self) -> String {
        serde_json::to_value(self).ok().and_then(|word| Some(word.as_str()?.to_string())).unwrap_or_default()
    }

    /// Returns the unit of the quantity on `machine`; "1" for pure numbers.
    pub fn unit(self, machine: &Machine) -> &'static str {
        match self {
            Quantity::ForceAtStart => "N",
            Quantity::MomentXAtStart | Quantity::MomentYAtStart => "Nmm",
            Quantity::DeflectionByCutting
            | Quantity::DeflectionByChainErrors
            | Quantity::DeflectionByBoth
            | Quantity::ResidualError => "mm",
            Quantity::Correction | Quantity::CorrectionOfPrismatic | Quantity::CorrectionOfRevolute => {
                self.drive_kind(machine).map_or("1", Motion::position_unit)
            }
            Quantity::DriveForce | Quantity::ForceOfPrismatic | Quantity::TorqueOfRevolute => {
                self.drive_kind(machine).map_or("1", Motion::force_unit)
            }
            Quantity::AxesAngle => "deg",
            _ => "1",
        }
    }

    /// Returns the kind of drives of which the quantity is the largest value; `None` where it is not of drives.
    fn drive_kind(self, machine: &Machine) -> Option<Motion> {
        match self {
            Quantity::CorrectionOfPrismatic | Quantity::ForceOfPrismatic => Some(Motion::Prismatic),
            Quantity::CorrectionOfRevolute | Quantity::TorqueOfRevolute => Some(Motion::Revolute),
            Quantity::Correction | Quantity::DriveForce => machine.drive_kinds().next(),
            _ => None,
        }
    }

    /// Checks that `machine` has this quantity: such drives, and drives of one kind only where the quantity needs one unit.
    ///
    /// # Errors
    /// It does not, and which quantity was expected.
    pub fn check_machine(self, machine: &Machine) -> Result<(), String> {
        let alternatives = match self {
            Quantity::Correction => ["correction_of_prismatic", "correction_of_revolute"],
            _ => ["force_of_prismatic", "torque_of_revolute"],
        };
        match self {
            Quantity::Correction | Quantity::DriveForce if machine.has_mixed_drives() => Err(format!(
                "machine {} has prismatic and revolute joints, whose values have no common unit: expected {} or {}, got {}",
                machine.name,
                alternatives[0],
                alternatives[1],
                self.label()
            )),
            _ => match self.drive_kind(machine) {
                Some(kind) if !machine.drive_kinds().any(|has| has == kind) => {
                    Err(format!("machine {} has no drive of this kind, got {}", machine.name, self.label()))
                }
                _ => Ok(()),
            },
        }
    }

    /// Whether the quantity is a count.
    pub fn is_count(self) -> bool {
        self == Quantity::Crossings
    }

    /// Returns the value of the quantity on a path, in its unit. `Err` names the first point that could not be solved, or says why there is
    /// no such value.
    pub fn of(self, path: &PathResults) -> Result<f64, String> {
        check_solved(path)?;
        let by_all = &path.whole.sources[Source::All];
        Ok(match self {
            Quantity::ForceAtStart => first_load(path).map_or(0.0, |load| load.force.norm()),
            Quantity::MomentXAtStart => first_load(path).map_or(0.0, |load| load.moment.x),
            Quantity::MomentYAtStart => first_load(path).map_or(0.0, |load| load.moment.y),
            Quantity::DeflectionByCutting => max_norm(&displacements(path, Source::Cutting)),
            Quantity::DeflectionByChainErrors => max_norm(&displacements(path, Source::Geometry)),
            Quantity::DeflectionByBoth => max_norm(&displacements(path, Source::All)),
            Quantity::Correction | Quantity::CorrectionOfPrismatic | Quantity::CorrectionOfRevolute => {
                let kind = self.drive_kind(&path.study.machine).ok_or("the machine has no drives")?;
                let most = largest_of(&path.study.machine, kind, by_all, PathPointResult::delta_rho);
                kind.to_shown(most)
            }
            Quantity::DriveForce | Quantity::ForceOfPrismatic | Quantity::TorqueOfRevolute => {
                let kind = self.drive_kind(&path.study.machine).ok_or("the machine has no drives")?;
                largest_of(&path.study.machine, kind, by_all, |answer| answer.drive_forces.clone())
            }
            Quantity::ResidualError => {
                let residuals = by_all.iter().map(|at| at.answer.position_error);
                max_norm(&residuals.collect::<Vec<_>>())
            }
            Quantity::SuperpositionRatio => {
                let together = max_norm(&displacements(path, Source::All));
                max_norm(&summed_displacements(path)) / beyond_rounding(together, "both sources move nothing")?
            }
            Quantity::SuperpositionError => {
                let together = displacements(path, Source::All);
                let superposition_error: Vec<_> =
                    summed_displacements(path).iter().zip(&together).map(|(sum, at_once)| sum - at_once).collect();
                max_norm(&superposition_error) / beyond_rounding(max_norm(&together), "both sources move nothing")?
            }
            Quantity::ShareBelowSuperposition => {
                let together = displacements(path, Source::All);
                let sums = summed_displacements(path);
                let is_smaller = |(sum, both): &(&Vector3<f64>, &Vector3<f64>)| sum.norm() - both.norm() > ROUNDING_MM;
                sums.iter().zip(&together).filter(is_smaller).count() as f64 / together.len().max(1) as f64
            }
            Quantity::CosineOfCentreShifts => {
                let (wanted, moved, commanded) = shapes(path)?;
                let (a, b) = (moved.centre - wanted.centre, commanded.centre - wanted.centre);
                let at_rest = "the centre of the displaced or of the commanded path does not move, so that its shift has no direction";
                let [a_size, b_size] = [a.norm(), b.norm()].map(|size| beyond_rounding(size, at_rest));
                a.dot(&b) / (a_size? * b_size?)
            }
            Quantity::AxesAngle => {
                let (_, moved, commanded) = shapes(path)?;
                if moved.is_round || commanded.is_round {
                    return Err("a path is round, no axis is the longest".into());
                }
                angle_deg(&moved.longest, &commanded.shortest)
            }
            Quantity::Crossings => {
                let moved = displacements(path, Source::Cutting);
                beyond_rounding(max_norm(&moved), "the cutting force moves nothing")?;
                let wanted = path.study.wanted_positions();
                let centre = Shape::of(&xy_points(&wanted)).ok_or("the path has no points")?.centre;
                let radius = (wanted[0].xy() - centre).norm();
                let moved: Vec<_> = wanted.iter().zip(moved).map(|(p, d)| p + d).collect();
                crossings(&xy_points(&moved), &centre, radius) as f64
            }
        })
    }
}

/// Checks that all points are solved under every source; `Err` names the first that is not, and why.
fn check_solved(path: &PathResults) -> Result<(), String> {
    for (source, along) in path.whole.sources.iter() {
        for (k, at) in along.iter().enumerate() {
            for status in [&at.plain.status, &at.answer.status] {
                if !status.is_success() {
                    let reason = status.reason(&path.study.machine);
                    return Err(format!("{}, point {k}: {reason}", source.label()));
                }
            }
        }
    }
    Ok(())
}

/// Returns `size`, mm, if it is more than rounding; else `Err(otherwise)`.
fn beyond_rounding(size: f64, otherwise: &str) -> Result<f64, String> {
    if size > ROUNDING_MM { Ok(size) } else { Err(otherwise.into()) }
}

/// Returns the load, a wrench at P, at the first point of the path; `None` without points.
fn first_load(path: &PathResults) -> Option<&crate::spatial::Wrench> {
    path.study.tasks.first().map(|task| &task.load)
}

/// Returns the largest length of `vectors`; 0 if there are none.
fn max_norm(vectors: &[Vector3<f64>]) -> f64 {
    vectors.iter().fold(0.0, |largest, vector| largest.max(vector.norm()))
}

/// Returns the displacement of the compensated point by `source`, without compensation, at each point, O, mm.
fn displacements(path: &PathResults, source: Source) -> Vec<Vector3<f64>> {
    path.whole.sources[source].iter().map(|at| at.plain.position_error).collect()
}

/// Returns the sum of the displacements by the single sources at each point, O, mm.
fn summed_displacements(path: &PathResults) -> Vec<Vector3<f64>> {
    let mut sum = vec![Vector3::zeros(); path.study.tasks.len()];
    for source in Source::parts(&path.study.machine) {
        sum.iter_mut().zip(displacements(path, *source)).for_each(|(sum, displacement)| *sum += displacement);
    }
    sum
}

/// Returns the largest absolute value over the path `along` and the drives of one `kind`; `values` returns one of each drive at a point.
fn largest_of(
    machine: &Machine,
    kind: Motion,
    along: &[PointEffect],
    values: impl Fn(&PathPointResult) -> Vec<f64>,
) -> f64 {
    along.iter().fold(0.0, |largest: f64, effect| {
        let of_kind = machine.drives().zip(values(&effect.answer)).filter(|((_, drive), _)| drive.motion == kind);
        of_kind.fold(largest, |largest, (_, value)| largest.max(value.abs()))
    })
}

/// Returns the x and y coordinates of points.
fn xy_points(points: &[Vector3<f64>]) -> Vec<Vector2<f64>> {
    points.iter().map(|p| p.xy()).collect()
}

/// Returns the shapes of the target path, of the path displaced by both sources, and of the commanded one.
fn shapes(path: &PathResults) -> Result<(Shape, Shape, Shape), String> {
    let wanted = path.study.wanted_positions();
    let moved: Vec<_> = wanted.iter().zip(displacements(path, Source::All)).map(|(p, d)| p + d).collect();
    let commanded: Option<Vec<_>> =
        wanted.iter().enumerate().map(|(k, point)| Some(point + path.whole.command_shift(&path.study, k)?)).collect();
    let shape = |points: &[Vector3<f64>]| Shape::of(&xy_points(points)).ok_or("the path has no points");
    Ok((shape(&wanted)?, shape(&moved)?, shape(&commanded.ok_or("a point has no commanded pose")?)?))
}
