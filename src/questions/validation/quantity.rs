//! Key figures of a path, as papers and measurement reports quote them.

use nalgebra::{Vector2, Vector3};
use serde::{Deserialize, Serialize};

use super::circle_shape::{Shape, angle_deg, crossings};
use crate::{
    machine::{Machine, Motion},
    questions::path::{AtPoint, PathResults},
    simulation::{ROUNDING_MM, Source, along_path::PathAnswer},
};

/// What is quoted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Size of the cutting force at the first point.
    ForceAtStart,
    /// Moment of the load about the x axis through P at the first point.
    MomentXAtStart,
    /// Moment of the load about the y axis through P at the first point.
    MomentYAtStart,
    /// Largest displacement by the cutting force alone of the compensated point.
    DeflectionByCutting,
    /// Largest displacement by the chain errors alone.
    DeflectionByChainErrors,
    /// Largest displacement by both at once.
    DeflectionByBoth,
    /// Largest |Δρ| of any drive, both sources; of machines with one kind of drives.
    Correction,
    /// Largest |Δρ| of any slide, both sources.
    CorrectionOfSlides,
    /// Largest |Δρ| of any hinge, both sources.
    CorrectionOfHinges,
    /// Largest force of any drive on the compensated path, both sources; of machines with one kind of drives.
    DriveForce,
    /// Largest force of any slide on the compensated path, both sources.
    ForceOfSlides,
    /// Largest torque of any hinge on the compensated path, both sources.
    TorqueOfHinges,
    /// Largest error left by the compensation.
    ResidualError,
    /// Largest size of the sum of both single-source displacements, over that of the displacement by both at once.
    SuperpositionRatio,
    /// Largest superposition error of that sum, as a vector, over the largest displacement by both at once.
    SuperpositionError,
    /// Share of the points at which the displacement by both at once is the smaller one.
    ShareBelowSuperposition,
    /// Cosine of the angle between the shifts of the middles of the path moved by both and of the commanded one.
    CosineOfCentreShifts,
    /// Angle between the longest axis of the path moved by both and the shortest of the commanded one.
    AxesAngle,
    /// How often the path moved by the cutting force crosses the wanted one.
    Crossings,
}

impl Quantity {
    /// Word used in files: that of a study file.
    pub fn label(self) -> String {
        serde_json::to_value(self).ok().and_then(|word| Some(word.as_str()?.to_string())).unwrap_or_default()
    }

    /// Its unit on `machine`; "1" for pure numbers.
    pub fn unit(self, machine: &Machine) -> &'static str {
        match self {
            Quantity::ForceAtStart => "N",
            Quantity::MomentXAtStart | Quantity::MomentYAtStart => "Nmm",
            Quantity::DeflectionByCutting
            | Quantity::DeflectionByChainErrors
            | Quantity::DeflectionByBoth
            | Quantity::ResidualError => "mm",
            Quantity::Correction | Quantity::CorrectionOfSlides | Quantity::CorrectionOfHinges => {
                self.drives(machine).map_or("1", Motion::position_unit)
            }
            Quantity::DriveForce | Quantity::ForceOfSlides | Quantity::TorqueOfHinges => {
                self.drives(machine).map_or("1", Motion::force_unit)
            }
            Quantity::AxesAngle => "deg",
            _ => "1",
        }
    }

    /// The kind of drives it is the largest value of.
    fn drives(self, machine: &Machine) -> Option<Motion> {
        match self {
            Quantity::CorrectionOfSlides | Quantity::ForceOfSlides => Some(Motion::Prismatic),
            Quantity::CorrectionOfHinges | Quantity::TorqueOfHinges => Some(Motion::Revolute),
            Quantity::Correction | Quantity::DriveForce => machine.drive_kinds().next(),
            _ => None,
        }
    }

    /// Whether `machine` has it: slides and hinges have no common largest value.
    ///
    /// # Errors
    /// It has not, and what was expected.
    pub fn fits(self, machine: &Machine) -> Result<(), String> {
        let own = match self {
            Quantity::Correction => ["correction_of_slides", "correction_of_hinges"],
            _ => ["force_of_slides", "torque_of_hinges"],
        };
        match self {
            Quantity::Correction | Quantity::DriveForce if machine.has_mixed_drives() => Err(format!(
                "machine {} has slides and hinges, whose values have no common unit: expected {} or {}, got {}",
                machine.name,
                own[0],
                own[1],
                self.label()
            )),
            _ => match self.drives(machine) {
                Some(kind) if !machine.drive_kinds().any(|own| own == kind) => {
                    Err(format!("machine {} has no drive of this kind, got {}", machine.name, self.label()))
                }
                _ => Ok(()),
            },
        }
    }

    /// Whether it counts something.
    pub fn is_count(self) -> bool {
        self == Quantity::Crossings
    }

    /// Its value.
    ///
    /// # Errors
    /// The first point that could not be solved, and why; or why there is no such number.
    pub fn of(self, path: &PathResults) -> Result<f64, String> {
        solved(path)?;
        let both = &path.whole.sources[Source::All];
        Ok(match self {
            Quantity::ForceAtStart => first_load(path).map_or(0.0, |load| load.force.norm()),
            Quantity::MomentXAtStart => first_load(path).map_or(0.0, |load| load.moment.x),
            Quantity::MomentYAtStart => first_load(path).map_or(0.0, |load| load.moment.y),
            Quantity::DeflectionByCutting => largest(&moved(path, Source::Cutting)),
            Quantity::DeflectionByChainErrors => largest(&moved(path, Source::Errors)),
            Quantity::DeflectionByBoth => largest(&moved(path, Source::All)),
            Quantity::Correction | Quantity::CorrectionOfSlides | Quantity::CorrectionOfHinges => {
                let kind = self.drives(&path.study.machine).ok_or("the machine has no drives")?;
                let most = largest_of(&path.study.machine, kind, both, PathAnswer::delta_rho);
                kind.shown(most)
            }
            Quantity::DriveForce | Quantity::ForceOfSlides | Quantity::TorqueOfHinges => {
                let kind = self.drives(&path.study.machine).ok_or("the machine has no drives")?;
                largest_of(&path.study.machine, kind, both, |answer| answer.drive_forces.clone())
            }
            Quantity::ResidualError => {
                let left = both.iter().map(|at| at.answer.position_error);
                largest(&left.collect::<Vec<_>>())
            }
            Quantity::SuperpositionRatio => {
                let together = largest(&moved(path, Source::All));
                largest(&superposed(path)) / beyond_rounding(together, "both sources move nothing")?
            }
            Quantity::SuperpositionError => {
                let together = moved(path, Source::All);
                let superposition_error: Vec<_> =
                    superposed(path).iter().zip(&together).map(|(sum, at_once)| sum - at_once).collect();
                largest(&superposition_error) / beyond_rounding(largest(&together), "both sources move nothing")?
            }
            Quantity::ShareBelowSuperposition => {
                let together = moved(path, Source::All);
                let sums = superposed(path);
                let is_smaller = |(sum, both): &(&Vector3<f64>, &Vector3<f64>)| sum.norm() - both.norm() > ROUNDING_MM;
                sums.iter().zip(&together).filter(is_smaller).count() as f64 / together.len().max(1) as f64
            }
            Quantity::CosineOfCentreShifts => {
                let (wanted, moved, commanded) = shapes(path)?;
                let (a, b) = (moved.middle - wanted.middle, commanded.middle - wanted.middle);
                let sizes =
                    [a.norm(), b.norm()].map(|size| beyond_rounding(size, "the middle of a path is not shifted"));
                let [a_size, b_size] = sizes;
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
                let moved = moved(path, Source::Cutting);
                beyond_rounding(largest(&moved), "the cutting force moves nothing")?;
                let wanted = path.study.wanted();
                let middle = Shape::of(&flat(&wanted)).ok_or("the path has no points")?.middle;
                let radius = (wanted[0].xy() - middle).norm();
                let moved: Vec<_> = wanted.iter().zip(moved).map(|(p, d)| p + d).collect();
                crossings(&flat(&moved), &middle, radius) as f64
            }
        })
    }
}

/// The first point that one of the sources leaves without an answer.
fn solved(path: &PathResults) -> Result<(), String> {
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

/// `size`, mm, if it is more than rounding.
fn beyond_rounding(size: f64, otherwise: &str) -> Result<f64, String> {
    if size > ROUNDING_MM { Ok(size) } else { Err(otherwise.into()) }
}

fn first_load(path: &PathResults) -> Option<&crate::spatial::Wrench> {
    path.study.tasks.first().map(|task| &task.load)
}

fn largest(vectors: &[Vector3<f64>]) -> f64 {
    vectors.iter().fold(0.0, |most, vector| most.max(vector.norm()))
}

fn moved(path: &PathResults, source: Source) -> Vec<Vector3<f64>> {
    path.whole.sources[source].iter().map(|at| at.plain.position_error).collect()
}

fn superposed(path: &PathResults) -> Vec<Vector3<f64>> {
    let mut sum = vec![Vector3::zeros(); path.study.tasks.len()];
    for source in Source::parts(&path.study.machine) {
        sum.iter_mut().zip(moved(path, *source)).for_each(|(sum, own)| *sum += own);
    }
    sum
}

/// Largest size of a value that each drive has, over the path and the drives of one kind.
fn largest_of(machine: &Machine, kind: Motion, along: &[AtPoint], values: impl Fn(&PathAnswer) -> Vec<f64>) -> f64 {
    along.iter().fold(0.0, |most: f64, at| {
        let own = machine.drives().zip(values(&at.answer)).filter(|((_, drive), _)| drive.motion == kind);
        own.fold(most, |most, (_, value)| most.max(value.abs()))
    })
}

fn flat(points: &[Vector3<f64>]) -> Vec<Vector2<f64>> {
    points.iter().map(|p| p.xy()).collect()
}

/// Shapes of the wanted path, of the path moved by both sources, and of the commanded one.
fn shapes(path: &PathResults) -> Result<(Shape, Shape, Shape), String> {
    let wanted = path.study.wanted();
    let moved: Vec<_> = wanted.iter().zip(moved(path, Source::All)).map(|(p, d)| p + d).collect();
    let commanded: Option<Vec<_>> =
        wanted.iter().enumerate().map(|(k, point)| Some(point + path.whole.command_shift(&path.study, k)?)).collect();
    let shape = |points: &[Vector3<f64>]| Shape::of(&flat(points)).ok_or("the path has no points");
    Ok((shape(&wanted)?, shape(&moved)?, shape(&commanded.ok_or("a point has no commanded pose")?)?))
}
