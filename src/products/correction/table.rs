//! The correction table: polynomial coefficients at the nodes of a grid, interpolated linearly along each axis.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::{
    CorrectionQuestion,
    loaded::{LoadedMachine, map_places},
};
use crate::{
    input::error::Result,
    machine::{Configuration, Machine},
    questions::Overrides,
    simulation::Machines,
    spatial::Grid,
    work::Work,
};

/// Most nodes of a table.
pub(super) const MAX_NODES: usize = 40_000;

/// Drive corrections over positions of P, for any force up to the largest one.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CorrectionTable {
    /// Nodes: positions of P in O, mm.
    pub grid: Grid,
    /// Terms in the force.
    pub terms: ForceTerms,
    /// Number of drives.
    pub drives: usize,
    /// Coefficients, node after node (x fastest), drive after drive, term after term: mm or rad per power of N.
    pub values: Vec<f64>,
}

impl CorrectionTable {
    /// Computes the table of `question` with `counts` nodes along x, y and z; an error if a node has no correction, or of `work`.
    pub(super) fn new(
        question: &CorrectionQuestion,
        machines: &Machines,
        counts: [usize; 3],
        terms: ForceTerms,
        work: &Work,
    ) -> Result<Self> {
        let [min, max] = question.corners;
        let grid = Grid::new(min, max, counts);
        let nodes = map_places(question, machines, grid.len(), work, |loaded, index| {
            let at = loaded.nominal_at(grid.position(index))?;
            terms.fit(loaded, &at, question.largest_force_N)
        })?;
        Ok(Self { grid, terms, drives: question.machine.drive_count(), values: nodes.concat() })
    }

    /// Returns the table without quadratic terms.
    pub(super) fn without_quadratic_terms(&self) -> Self {
        if self.terms != ForceTerms::Quadratic {
            return self.clone();
        }
        let kept = ForceTerms::Linear.count();
        let values = self.values.chunks(self.terms.count()).flat_map(|all| all[..kept].iter().copied()).collect();
        Self { grid: self.grid.clone(), terms: ForceTerms::Linear, drives: self.drives, values }
    }

    /// Returns the interpolated coefficients at `position` (P in O, mm), drive after drive; outside the box, those at its nearest point.
    pub fn coefficients_at(&self, position: Vector3<f64>) -> Vec<f64> {
        let sides = [0, 1, 2].map(|axis| {
            let ([low, high], share) = bracket(&self.grid.axes[axis], position[axis]);
            [(low, 1.0 - share), (high, share)]
        });
        let width = self.drives * self.terms.count();
        let mut sum = vec![0.0; width];
        for corner in 0..8 {
            let chosen = |axis: usize| sides[axis][corner >> axis & 1];
            let weight: f64 = (0..3).map(|axis| chosen(axis).1).product();
            if weight == 0.0 {
                continue;
            }
            let node = self.grid.index([0, 1, 2].map(|axis| chosen(axis).0));
            for (sum, value) in sum.iter_mut().zip(&self.values[node * width..]) {
                *sum += weight * value;
            }
        }
        sum
    }

    /// Returns Δρ of each drive, mm or rad, with P at `position` (O, mm) under a force on the tool tip (O axes, N).
    pub fn correction(&self, position: Vector3<f64>, force: Vector3<f64>) -> Vec<f64> {
        let terms = self.terms.values(force);
        let of_drive = |coefficients: &[f64]| coefficients.iter().zip(&terms).map(|(c, term)| c * term).sum();
        self.coefficients_at(position).chunks(self.terms.count()).map(of_drive).collect()
    }
}

/// Returns the indices of the nodes on both sides of `value` and the weight of the second; beyond the ends, the last node has all weight.
pub(super) fn bracket(nodes: &[f64], value: f64) -> ([usize; 2], f64) {
    let last = nodes.len() - 1;
    if last == 0 {
        return ([0, 0], 0.0);
    }
    let low = nodes.partition_point(|node| *node <= value).clamp(1, last) - 1;
    ([low, low + 1], ((value - nodes[low]) / (nodes[low + 1] - nodes[low])).clamp(0.0, 1.0))
}

/// Returns the box of a table, P in O, mm: `custom` or the machine's workspace, with uncontrolled coordinates as at home. An error if the
/// box is reversed or leaves out home along an uncontrolled axis.
pub(super) fn corners(machine: &Machine, custom: Option<[Vector3<f64>; 2]>) -> Result<[Vector3<f64>; 2]> {
    let [min, max] = custom.unwrap_or([machine.workspace.min, machine.workspace.max]);
    let check = Overrides::location("box");
    if let Some(axis) = (0..3).find(|&axis| min[axis] > max[axis]) {
        let name = ["x", "y", "z"][axis];
        return check.fail(format!("must begin below its end, got {} to {} mm along {name}", min[axis], max[axis]));
    }
    let home = machine.home.pose.translation;
    for axis in machine.uncontrolled_axes() {
        if custom.is_some() && !(min[axis]..=max[axis]).contains(&home[axis]) {
            let name = ["x", "y", "z"][axis];
            return check.fail(format!(
                "the drives do not control {name}, which stands at {} mm; got {} to {} mm",
                home[axis], min[axis], max[axis]
            ));
        }
    }
    Ok([machine.controllable_position(min), machine.controllable_position(max)])
}

/// Returns the nodes along x, y and z, or an error; three equal numbers apply to the axes along which the box has extent.
pub(super) fn check_counts(question: &CorrectionQuestion, counts: [usize; 3]) -> Result<[usize; 3]> {
    let axes: Vec<usize> = question.axes().collect();
    let is_for_all = counts[0] == counts[1] && counts[1] == counts[2];
    let counts = [0, 1, 2].map(|axis| if is_for_all && !axes.contains(&axis) { 1 } else { counts[axis] });
    let check = Overrides::location("grid");
    for axis in 0..3 {
        let (name, least) = (["x", "y", "z"][axis], if axes.contains(&axis) { 2 } else { 1 });
        let is_right = if least == 1 { counts[axis] == 1 } else { counts[axis] >= 2 };
        if !is_right {
            let expected = if least == 1 { "exactly 1, as the box has no length there" } else { "at least 2" };
            return check.fail(format!("nodes along {name} must be {expected}, got {}", counts[axis]));
        }
    }
    match counts.iter().try_fold(1usize, |product, &n| product.checked_mul(n)) {
        Some(total) if total <= MAX_NODES => Ok(counts),
        _ => check.fail(format!("at most {MAX_NODES} nodes, got {counts:?}")),
    }
}

/// Terms of the polynomial in the force F, N.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ForceTerms {
    /// 1, without force.
    Constant,
    /// 1, F_x, F_y, F_z.
    Linear,
    /// The linear terms and F_x², F_y², F_z², F_x F_y, F_x F_z, F_y F_z.
    Quadratic,
}

/// Axes of the mixed quadratic terms.
const MIXED: [[usize; 2]; 3] = [[0, 1], [0, 2], [1, 2]];

impl ForceTerms {
    /// Returns the column name of each term and the power n of the force in it: its coefficient is per Nⁿ.
    pub fn names_and_powers(self) -> &'static [(&'static str, u8)] {
        const ALL: [(&str, u8); 10] = [
            ("1", 0),
            ("Fx", 1),
            ("Fy", 1),
            ("Fz", 1),
            ("Fx_Fx", 2),
            ("Fy_Fy", 2),
            ("Fz_Fz", 2),
            ("Fx_Fy", 2),
            ("Fx_Fz", 2),
            ("Fy_Fz", 2),
        ];
        &ALL[..self.count()]
    }

    /// Returns the number of terms.
    pub fn count(self) -> usize {
        match self {
            ForceTerms::Constant => 1,
            ForceTerms::Linear => 4,
            ForceTerms::Quadratic => 10,
        }
    }

    /// Returns the value of each term at a force, N, in the order of [`ForceTerms::names_and_powers`]; zeros beyond [`ForceTerms::count`].
    pub fn values(self, f: Vector3<f64>) -> [f64; 10] {
        let mut values = [1.0, f.x, f.y, f.z, f.x * f.x, f.y * f.y, f.z * f.z, f.x * f.y, f.x * f.z, f.y * f.z];
        values[self.count()..].fill(0.0);
        values
    }

    /// Returns the coefficients at a configuration, drive after drive: the exact correction without force, and central differences over
    /// forces of the size `largest` N, so that the odd (with quadratic terms also the even) part is exact along each axis and midway
    /// between two. An error if there is no correction under one of these forces.
    pub(super) fn fit(self, loaded: &mut LoadedMachine<'_>, at: &Configuration, largest: f64) -> Result<Vec<f64>> {
        let zero = loaded.exact_correction(at, Vector3::zeros())?;
        let mut coefficients = vec![0.0; zero.len() * self.count()];
        let mut pair = |force: Vector3<f64>| -> Result<_> {
            Ok([loaded.exact_correction(at, force)?, loaded.exact_correction(at, -force)?])
        };
        let (mut odd, mut even) = (Vec::new(), Vec::new());
        for axis in 0..if self == ForceTerms::Constant { 0 } else { 3 } {
            let [plus, minus] = pair(Vector3::ith(axis, largest))?;
            odd.push(plus.iter().zip(&minus).map(|(p, m)| (p - m) / (2.0 * largest)).collect::<Vec<f64>>());
            even.push(curvature(&zero, [&plus, &minus], largest));
        }
        let mut mixed = Vec::new();
        for [i, j] in if self == ForceTerms::Quadratic { &MIXED[..] } else { &[] } {
            let force = (Vector3::ith(*i, largest) + Vector3::ith(*j, largest)) / 2f64.sqrt();
            let [plus, minus] = pair(force)?;
            let along = curvature(&zero, [&plus, &minus], largest);
            mixed
                .push(along.iter().enumerate().map(|(d, c)| 2.0 * c - even[*i][d] - even[*j][d]).collect::<Vec<f64>>());
        }
        for (drive, row) in coefficients.chunks_mut(self.count()).enumerate() {
            let all = [odd.as_slice(), if self == ForceTerms::Quadratic { &even } else { &[] }, &mixed];
            let of_drive = all.into_iter().flatten().map(|term| term[drive]);
            row.iter_mut().zip(std::iter::once(zero[drive]).chain(of_drive)).for_each(|(c, value)| *c = value);
        }
        Ok(coefficients)
    }
}

/// Returns half the second derivative of the correction along a force of the size `largest`, from those of the force, its opposite and no force.
fn curvature(zero: &[f64], [plus, minus]: [&[f64]; 2], largest: f64) -> Vec<f64> {
    let sums = plus.iter().zip(minus).map(|(p, m)| 0.5 * (p + m));
    sums.zip(zero).map(|(mean, at_zero)| (mean - at_zero) / (largest * largest)).collect()
}
