//! The weight of what hangs on a route.
//!
//! The masses behind an elementary motion move with it: of their velocities, weighted by mass, it makes
//! `V_j = M v_j + ω_j × S` (S: their first moment about the end). Weight does the work `−V_j·g` on it, and its part in the
//! wrench-weighted Hessian is `ω_k · (V_j × g)` for k before or at j, symmetric as weights keep their directions. `L_j = V_j × g`
//! is also the moment that the motion gives to what carries the whole route.

use super::ChainSystem;
use crate::{
    lanes::{Real, Vec3},
    machine::Route,
};

/// What has weight behind some of the elementary motions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hung {
    moves_before: usize,
    load: Load,
}

#[derive(Debug, Clone, Copy)]
enum Load {
    /// The mass of this index.
    Mass(usize),
    /// The masses of the loop of this index.
    Loop(usize),
}

/// The loads of a route, the farthest from its base first.
pub(super) fn hung(route: &Route, moves_before: &[usize]) -> Vec<Hung> {
    let masses = route
        .masses
        .iter()
        .enumerate()
        .map(|(i, mass)| Hung { moves_before: moves_before[mass.frame], load: Load::Mass(i) });
    let loops = route.loops.iter().enumerate().filter(|(_, inner)| inner.route.has_mass());
    let loops = loops.map(|(i, inner)| Hung { moves_before: moves_before[inner.from], load: Load::Loop(i) });
    let mut all: Vec<Hung> = masses.chain(loops).collect();
    all.sort_by_key(|hung| std::cmp::Reverse(hung.moves_before));
    all
}

impl<R: Real> ChainSystem<R> {
    /// Sums up the masses from the end of the route on; takes their weight into the right-hand side and into the levers. The
    /// loops are filled.
    #[inline(always)]
    pub(super) fn weigh(&mut self, route: &Route, gravity: Vec3<R>) {
        let rhs = self.rhs_column();
        let (mut mass, mut moment) = (0.0, Vec3::zero());
        let mut next = 0;
        for j in (0..self.screws.len()).rev() {
            while next < self.hung.len() && self.hung[next].moves_before > j {
                self.add_load(route, self.hung[next].load, &mut mass, &mut moment);
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
        for k in next..self.hung.len() {
            self.add_load(route, self.hung[k].load, &mut mass, &mut moment);
        }
        (self.mass, self.moment_of_mass) = (mass, moment);
    }

    /// Adds a load to a sum of masses, kg, and their first moment about O, kg·mm.
    #[inline(always)]
    fn add_load(&self, route: &Route, load: Load, mass: &mut f64, moment: &mut Vec3<R>) {
        match load {
            Load::Mass(i) => {
                let own = &route.masses[i];
                *mass += own.kilograms;
                *moment += self.frames[own.frame].place(&own.at).scale(R::splat(own.kilograms));
            }
            Load::Loop(i) => {
                let own = &self.loops[i].system;
                *mass += own.mass;
                *moment += own.moment_of_mass;
            }
        }
    }
}
