//! Weight of the masses on a route.
//!
//! The masses behind an elementary motion move with it: of their velocities, weighted by mass, it makes `V_j = M v_j + ω_j × S` (S: their first
//! moment about the end). Weight does the work `−V_j·g` on it, and its part in the wrench-weighted Hessian is `ω_k · (V_j × g)` for k before or
//! at j, symmetric as weights keep their directions. `L_j = V_j × g` is also the moment that the motion gives to what carries the whole route.

use super::ChainSystem;
use crate::{
    lanes::{Real, Vec3},
    machine::Route,
};

/// A mass on a route, or the masses of a loop, and the number of elementary motions before it.
#[derive(Debug, Clone, Copy)]
pub(super) struct HungMass {
    moves_before: usize,
    source: MassRef,
}

/// Reference to a mass of a route, or to a loop with masses.
#[derive(Debug, Clone, Copy)]
enum MassRef {
    /// The mass of this index.
    Mass(usize),
    /// The masses of the loop of this index.
    Loop(usize),
}

/// Masses of a route and of its loops, the farthest from its base first.
pub(super) fn hung_masses(route: &Route, moves_before: &[usize]) -> Vec<HungMass> {
    let masses = route
        .masses
        .iter()
        .enumerate()
        .map(|(i, mass)| HungMass { moves_before: moves_before[mass.frame], source: MassRef::Mass(i) });
    let loops = route.loops.iter().enumerate().filter(|(_, inner)| inner.route.has_mass());
    let loops = loops.map(|(i, inner)| HungMass { moves_before: moves_before[inner.from], source: MassRef::Loop(i) });
    let mut all: Vec<HungMass> = masses.chain(loops).collect();
    all.sort_by_key(|hung| std::cmp::Reverse(hung.moves_before));
    all
}

impl<R: Real> ChainSystem<R> {
    /// Adds the weight of the masses, summed from the end of the route on, to the right-hand side and to the levers. The loops must be filled.
    #[inline(always)]
    pub(super) fn add_weight(&mut self, route: &Route, gravity: Vec3<R>) {
        let rhs = self.rhs_column();
        let (mut mass, mut moment) = (0.0, Vec3::zero());
        let mut next = 0;
        for j in (0..self.screws.len()).rev() {
            while next < self.hung_masses.len() && self.hung_masses[next].moves_before > j {
                self.add_mass(route, self.hung_masses[next].source, &mut mass, &mut moment);
                next += 1;
            }
            let (coordinate, twist) = self.screws[j];
            let mut carried = twist.linear.scale(R::splat(mass));
            if self.is_rotation[coordinate] {
                carried += twist.angular.cross(moment - self.end.scale(R::splat(mass)));
            }
            let row = self.rows[coordinate];
            *self.matrix.at(row, rhs) -= carried.dot(gravity);
            let lever = carried.cross(gravity);
            self.levers[j] = lever;
            if self.turn_count > 0 {
                for i in 0..3 {
                    let column = rhs + 1 + self.drives.len() + i;
                    *self.matrix.at(row, column) -= lever.0[i];
                }
            }
        }
        for k in next..self.hung_masses.len() {
            self.add_mass(route, self.hung_masses[k].source, &mut mass, &mut moment);
        }
        (self.mass, self.moment_of_mass) = (mass, moment);
    }

    /// Adds the mass (kg) and first moment about O (kg·mm) of `source` to the sums `mass` and `moment`.
    #[inline(always)]
    fn add_mass(&self, route: &Route, source: MassRef, mass: &mut f64, moment: &mut Vec3<R>) {
        match source {
            MassRef::Mass(i) => {
                let part = &route.masses[i];
                *mass += part.kilograms;
                *moment += self.frames[part.frame].transform(&part.at).scale(R::splat(part.kilograms));
            }
            MassRef::Loop(i) => {
                let part = &self.loops[i].system;
                *mass += part.mass;
                *moment += part.moment_of_mass;
            }
        }
    }
}
