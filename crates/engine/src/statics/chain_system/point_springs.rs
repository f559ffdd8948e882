//! Springs between two points of a route.
//!
//! With `d` from one point to the other, `u = d/|d|` and tension T, only the elementary motions between the two points do
//! work on it: `T u·a_j`, a_j the velocity that motion j gives to the farther point. The second derivative is
//! `k (u·a_j)(u·a_k) + T/|d| (a_j·a_k − (u·a_j)(u·a_k)) + T u·(ω_k × a_j)` for k before or at j.
//!
//! With `T = k |d| + T₀`, where T₀ is the tension that would be left at length zero, all of it but T₀ is linear in `d`: a
//! spring without T₀ is as regular where its ends meet as elsewhere.

use super::ChainSystem;
use crate::{
    lanes::{Real, Vec3},
    machine::{Anchor, Route},
};

impl<R: Real> ChainSystem<R> {
    /// Adds forces and stiffness of the springs between points to the system.
    #[inline(always)]
    pub(super) fn fill_point_springs(&mut self, route: &Route) {
        let rhs = self.rhs_column();
        for spring in &route.point_springs {
            let (near, first) = self.locate_anchor(&spring.from);
            let (far, last) = self.locate_anchor(&spring.to);
            let way = far - near;
            let stiffness = R::splat(spring.stiffness);
            let tension = spring.tension_at_zero_length();
            let (mut across, mut direction) = (stiffness, Vec3::zero());
            if tension != 0.0 {
                let per_length = R::splat(1.0) / way.norm();
                across += R::splat(tension) * per_length;
                direction = way.scale(per_length);
            }
            let pull = way.scale(across);
            for j in first..last {
                let velocity_j = self.velocity_at(j, far);
                let along_j = direction.dot(velocity_j);
                let row_j = self.rows[self.screws[j].0];
                *self.matrix.at(row_j, rhs) += pull.dot(velocity_j);
                for k in first..=j {
                    let (coordinate, twist) = self.screws[k];
                    let velocity_k = self.velocity_at(k, far);
                    let mut value = (stiffness - across) * along_j * direction.dot(velocity_k)
                        + across * velocity_j.dot(velocity_k);
                    if self.is_rotation[coordinate] {
                        value += pull.dot(twist.angular.cross(velocity_j));
                    }
                    self.add_second_derivative(j, k, value);
                }
            }
        }
    }

    /// Position of an anchor in O (mm), and the number of elementary motions before it.
    #[inline(always)]
    fn locate_anchor(&self, anchor: &Anchor) -> (Vec3<R>, usize) {
        match anchor.frame {
            Some(frame) => (self.frames[frame].transform(&anchor.at), self.moves_before[frame]),
            None => (Vec3::splat(&anchor.at), 0),
        }
    }

    /// Velocity that elementary motion `j` gives to the point at `place` in O (mm).
    #[inline(always)]
    pub(super) fn velocity_at(&self, j: usize, place: Vec3<R>) -> Vec3<R> {
        let (coordinate, twist) = self.screws[j];
        if self.is_rotation[coordinate] { twist.linear + twist.angular.cross(place - self.end) } else { twist.linear }
    }

    /// Adds the second derivative by the elementary motions `j` and `k`, k before or at j, to the entry of their coordinates.
    #[inline(always)]
    pub(super) fn add_second_derivative(&mut self, j: usize, k: usize, value: R) {
        let (row_j, row_k) = (self.rows[self.screws[j].0], self.rows[self.screws[k].0]);
        // A coordinate that drives two motions (parallelogram) meets itself twice, from either side.
        let twice = row_j == row_k && k != j;
        *self.matrix.at(row_k.min(row_j), row_k.max(row_j)) += if twice { value + value } else { value };
    }
}
