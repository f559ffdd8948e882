//! What the map says, gathered point by point.

use crate::{
    files::StatusCount,
    questions::superposition::{
        DeparturePoint, SuperpositionStudy,
        departure::{Followed, Sum, Worst},
        safe::LargestFactor,
    },
    simulation::status_of,
};

/// What departures are ranked by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Measure {
    /// Largest departure over φ, mm.
    Size,
    /// That over the largest displacement.
    Relative,
    /// Largest departure over the displacement at the same φ.
    Ratio,
}

impl Measure {
    fn of(self, worst: &Worst) -> Option<f64> {
        match self {
            Measure::Size => Some(worst.departure_mm),
            Measure::Relative => worst.relative(),
            Measure::Ratio => worst.ratio,
        }
    }
}

/// The largest value seen, and where it was seen first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Found {
    pub value: f64,
    pub position_mm: [f64; 3],
    pub worst: Worst,
}

/// How far the load may grow at a grid point.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Load {
    pub factor: f64,
    pub position_mm: [f64; 3],
    pub largest: LargestFactor,
}

/// What the map says, gathered point by point: memory does not grow with the grid.
#[derive(Debug, Clone, Default)]
pub struct Summary {
    /// By sum, followed point and measure.
    largest: [[[Option<Found>; 3]; 2]; 2],
    /// Points that keep within the tolerance up to the smallest and to the largest factor on the load.
    loads: Option<[Load; 2]>,
    pub(super) points: usize,
    pub(super) solved: usize,
    /// Points at which the equilibrium ends before the departure reaches the tolerance.
    pub(super) ended: usize,
    /// Shares of the box that were solved, and that keep within the tolerance.
    solved_share: f64,
    safe_share: f64,
    statuses: Vec<StatusCount>,
}

impl Summary {
    /// Takes the next point of the map of `study`, in grid order, into account.
    pub fn add(&mut self, study: &SuperpositionStudy, point: &DeparturePoint) {
        StatusCount::add(&mut self.statuses, status_of(&point.departures));
        if let Ok(departures) = &point.departures {
            self.solved += 1;
            // Each grid point stands for the cell around it.
            let volume = study.grid.cell_share(self.points);
            self.solved_share += volume;
            if departures.superposed_tool_mm() < study.tolerance {
                self.safe_share += volume;
            }
            for (sum, by_followed) in Sum::ALL.into_iter().zip(&mut self.largest) {
                for (followed, found) in Followed::ALL.into_iter().zip(by_followed) {
                    if let Ok(worst) = departures.worst(sum, followed) {
                        see(found, point.position_mm, worst);
                    }
                }
            }
        }
        self.ended += usize::from(matches!(point.largest_load, LargestFactor::NoEquilibrium(..)));
        if let Some(factor) = point.largest_load.factor() {
            self.see_load(factor, point);
        }
        self.points += 1;
    }

    fn see_load(&mut self, factor: f64, point: &DeparturePoint) {
        let here = || Load { factor, position_mm: point.position_mm, largest: point.largest_load.clone() };
        let [least, most] = self.loads.get_or_insert_with(|| [here(), here()]);
        if factor < least.factor {
            *least = here();
        }
        if factor > most.factor {
            *most = here();
        }
    }

    /// Rows of the map per status.
    pub fn statuses(&self) -> &[StatusCount] {
        &self.statuses
    }

    /// Where the departure of `sum` at `followed` is largest.
    pub(super) fn largest(&self, sum: Sum, followed: Followed, measure: Measure) -> Option<&Found> {
        self.largest[sum as usize][followed as usize][measure as usize].as_ref()
    }

    /// The smallest and the largest factor on the load.
    pub(super) fn loads(&self) -> Option<&[Load; 2]> {
        self.loads.as_ref()
    }

    /// Share of the solved part of the box in which superposition keeps within the tolerance; `None` where nothing was
    /// solved.
    pub fn safe_share(&self) -> Option<f64> {
        (self.solved_share > 0.0).then(|| self.safe_share / self.solved_share)
    }
}

fn see(found: &mut [Option<Found>; 3], position_mm: [f64; 3], worst: &Worst) {
    for (measure, found) in [Measure::Size, Measure::Relative, Measure::Ratio].into_iter().zip(found) {
        if let Some(value) = measure.of(worst)
            && found.is_none_or(|found| value > found.value)
        {
            *found = Some(Found { value, position_mm, worst: *worst });
        }
    }
}
