//! What a tool without compensation cuts: its deflection changes the cut, and with that the force that deflects it.

use nalgebra::Vector3;

use super::{ProgramJob, part};
use crate::{
    compensation::Method, input::error::Result, process::stock::LEAST_WAY, simulation::along_path::PathPointResult,
    work::Work,
};

/// The tool without compensation where its deflection and the force of what it cuts there agree.
#[derive(Debug, Clone)]
pub struct DeflectedCut {
    /// Point of the largest error among those that count, and its size, mm.
    pub largest: (usize, f64),
    /// The same for the force of the programmed cut, mm.
    pub programmed_mm: f64,
    /// How often the stock was cut.
    pub rounds: usize,
    /// Largest distance by which deflection and force still disagree, mm.
    pub left_mm: f64,
    /// Share of the points at which they agree.
    pub agreed: f64,
}

/// Most points of a program for which it is computed.
pub const MAX_POINTS: usize = 20_000;
const MAX_ROUNDS: usize = 8;
/// They agree within this share of the largest error, or this distance, mm.
const AGREED: f64 = 0.01;
const LEAST_MM: f64 = 1e-3;
/// Where the tool enters and leaves, a cut may come and go from round to round.
const ENOUGH: f64 = 0.95;
/// Relaxation of the first round and bounds of those of the next.
const FIRST_RELAXATION: f64 = 0.7;
const RELAXATIONS: [f64; 2] = [0.1, 1.0];

impl DeflectedCut {
    /// Whether deflection and force agree at nearly all points.
    #[must_use]
    pub fn has_converged(&self) -> bool {
        self.agreed >= ENOUGH
    }
}

impl ProgramJob {
    /// Returns where the tool is without compensation in the cut that it makes there, by a fixed point that is relaxed at each point by Aitken's Δ². It begins with the `errors` in the programmed
    /// cut, base axes, mm, none where that is not looked at. `None` there, where the machine has no equilibrium, and where nothing bends by as much as is looked at.
    ///
    /// # Errors
    /// Of `work`; a tool that bends too far.
    pub(super) fn deflected_cut(&self, errors: Vec<Option<Vector3<f64>>>, work: &Work) -> Result<Option<DeflectedCut>> {
        let turn = self.process.placement.place(&self.machine).workpiece().rotation;
        let all_known = |errors: Vec<Option<Vector3<f64>>>| -> Option<Vec<Vector3<f64>>> {
            errors.into_iter().map(|own| own.map(|own| turn.tr_mul(&own))).collect()
        };
        let Some(mut errors) = all_known(errors) else { return Ok(None) };
        let programmed_mm = self.largest(&errors).1;
        if programmed_mm <= LEAST_MM {
            return Ok(None);
        }
        let mut job = self.clone();
        let mut shifts = vec![Vector3::zeros(); errors.len()];
        let mut relaxations = vec![FIRST_RELAXATION; errors.len()];
        let (mut before, mut rounds) = (None::<Vec<Vector3<f64>>>, 0);
        loop {
            let residual: Vec<Vector3<f64>> = errors.iter().zip(&shifts).map(|(error, shift)| error - shift).collect();
            let largest = self.largest(&errors);
            let most_mm = LEAST_MM.max(AGREED * largest.1);
            let counted = || residual.iter().enumerate().filter(|own| self.is_counted(own.0));
            let agreed = counted().filter(|own| own.1.norm() <= most_mm).count() as f64 / counted().count() as f64;
            let found = DeflectedCut { largest, programmed_mm, rounds, left_mm: self.largest(&residual).1, agreed };
            if agreed == 1.0 || rounds == MAX_ROUNDS {
                return Ok(Some(found));
            }
            for (relaxation, (before, now)) in relaxations.iter_mut().zip(before.iter().flatten().zip(&residual)) {
                *relaxation = (*relaxation * aitken(before, now)).clamp(RELAXATIONS[0], RELAXATIONS[1]);
            }
            let moved = shifts.iter_mut().zip(relaxations.iter().zip(&residual));
            moved.for_each(|(shift, (relaxation, own))| *shift += *relaxation * own);
            self.join(&mut shifts);
            before = Some(residual);
            let Some(path) = self.process.cut_shifted(&self.path, &shifts, &self.name)? else { return Ok(None) };
            // It goes through the same poses under other loads.
            job.tasks = part::stored_tasks(&job.process, &path, &job.name)?;
            job.path = path;
            let mut next = Vec::with_capacity(errors.len());
            job.pass_by(Method::None, &|| {}, |_, results| {
                next.extend(results.iter().map(PathPointResult::solved_error));
                work.check()
            })?;
            let Some(next) = all_known(next) else { return Ok(None) };
            (errors, rounds) = (next, rounds + 1);
        }
    }

    /// Returns the point with the largest of `vectors` among those that count, and its size.
    fn largest(&self, vectors: &[Vector3<f64>]) -> (usize, f64) {
        let counted = vectors.iter().enumerate().filter(|(k, _)| self.is_counted(*k));
        counted.map(|(k, own)| (k, own.norm())).fold((0, 0.0), |most, own| if own.1 > most.1 { own } else { most })
    }

    /// Shifts points of the path that are one place as one.
    fn join(&self, shifts: &mut [Vector3<f64>]) {
        let points = self.path.points();
        for k in 1..shifts.len() {
            if (points[k].position_mm - points[k - 1].position_mm).norm() < LEAST_WAY {
                shifts[k] = shifts[k - 1];
            }
        }
    }
}

/// Returns the factor of Aitken's Δ² for the relaxation that has led from one residual to the next.
fn aitken(before: &Vector3<f64>, now: &Vector3<f64>) -> f64 {
    let step = now - before;
    if step.norm_squared() > 0.0 { -before.dot(&step) / step.norm_squared() } else { 1.0 }
}
