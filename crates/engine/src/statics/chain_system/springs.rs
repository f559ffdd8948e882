//! Springs on the coordinates of a route: drives, links, parallelograms, sprung joints.

use super::ChainSystem;
use crate::{
    lanes::{Real, sin_cos},
    machine::{Chain, SpringLaw},
};

impl<R: Real> ChainSystem<R> {
    /// Adds forces and stiffness of drives, links, parallelograms and sprung joints to the system.
    #[inline(always)]
    pub(super) fn fill_springs(&mut self, chain: &Chain, coordinates: &[R]) {
        let rhs = self.rhs_column();
        for index in 0..self.springs.len() {
            let spring = &chain.springs[self.springs[index]];
            let (first, start) = (spring.start, self.rows[spring.start]);
            match &spring.law {
                SpringLaw::Drive(stiffness) => {
                    *self.matrix.at(start, start) += R::splat(*stiffness);
                    *self.matrix.at(start, rhs) += R::splat(*stiffness) * coordinates[first];
                }
                SpringLaw::Link(stiffness) => {
                    for index in 0..36 {
                        let (i, j) = (index / 6, index % 6);
                        let k = stiffness[(i, j)];
                        if k == 0.0 {
                            continue;
                        }
                        *self.matrix.at(start + i, rhs) += R::splat(k) * coordinates[first + j];
                        if j >= i {
                            *self.matrix.at(start + i, start + j) += R::splat(k);
                        }
                    }
                }
                SpringLaw::Parallelogram { passive, terms } => {
                    self.fill_parallelogram(
                        &coordinates[first..first + 5],
                        start,
                        coordinates[*passive],
                        *passive,
                        terms,
                    );
                }
            }
        }
        for &j in &self.joints {
            let (joint, coordinate) = (&chain.passive[j], chain.passive_coordinate(j));
            let row = self.rows[coordinate];
            let (stiffness, neutral) = (R::splat(joint.stiffness), R::splat(joint.neutral));
            *self.matrix.at(row, row) += stiffness;
            *self.matrix.at(row, rhs) += stiffness * (coordinates[coordinate] - neutral);
        }
    }

    /// Adds a parallelogram's spring `U = ½ θᵀ K(q) θ`, the first of `theta` at row `start` and `q` the passive coordinate `passive`.
    #[inline(always)]
    fn fill_parallelogram(
        &mut self,
        theta: &[R],
        start: usize,
        q: R,
        passive: usize,
        [mean, cosine, sine]: &[nalgebra::SMatrix<f64, 5, 5>; 3],
    ) {
        let (rhs, row_q) = (self.rhs_column(), self.row(passive));
        let (s, c) = sin_cos(q + q);
        let (mut slope_force, mut curvature_force) = (R::zero(), R::zero());
        for i in 0..5 {
            let (mut force, mut slope, mut swing_force) = (R::zero(), R::zero(), R::zero());
            for j in 0..5 {
                let (mean, cosine, sine) = (mean[(i, j)], cosine[(i, j)], sine[(i, j)]);
                if mean == 0.0 && cosine == 0.0 && sine == 0.0 {
                    continue;
                }
                let (mean, cosine, sine) = (R::splat(mean), R::splat(cosine), R::splat(sine));
                let swing = cosine * c + sine * s;
                let stiffness = mean + swing;
                force += stiffness * theta[j];
                slope += (sine * c - cosine * s) * theta[j];
                swing_force += swing * theta[j];
                if j >= i {
                    *self.matrix.at(start + i, start + j) += stiffness;
                }
            }
            slope += slope;
            *self.matrix.at(start + i, rhs) += force;
            *self.matrix.at(start + i, row_q) += slope;
            slope_force += slope * theta[i];
            curvature_force -= swing_force * theta[i];
        }
        *self.matrix.at(row_q, rhs) += R::splat(0.5) * slope_force;
        *self.matrix.at(row_q, row_q) += R::splat(2.0) * curvature_force;
    }
}
