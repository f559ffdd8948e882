//! Balance of the platform with condensed chains: tangent, Newton step, compliance and stability.

use nalgebra::Matrix6;

use super::{chain_system::ChainSystem, outcome::TaskError, rigid_directions::RigidDirections};
use crate::{
    lanes::{Real, pairs, solve, subtract},
    machine::DriveMotions,
    spatial::{Wrench, skew},
};

/// A 6×6 matrix by rows.
pub(super) type Square<R> = [[R; 6]; 6];

/// The nalgebra matrix of `rows`.
pub(super) fn to_matrix(rows: &Square<f64>) -> Matrix6<f64> {
    Matrix6::from_fn(|i, j| rows[i][j])
}

/// The rows of `matrix`.
pub(super) fn to_rows(matrix: &Matrix6<f64>) -> Square<f64> {
    let mut rows = [[0.0; 6]; 6];
    for (i, row) in rows.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            *entry = matrix[(i, j)];
        }
    }
    rows
}

/// The matrix that `rows` hold in `lane`.
pub(super) fn lane_matrix<R: Real>(rows: &Square<R>, lane: usize) -> Square<f64> {
    let mut matrix = [[0.0; 6]; 6];
    for (to, row) in pairs(&mut matrix, rows) {
        for (entry, number) in pairs(to, row) {
            *entry = number.lane(lane);
        }
    }
    matrix
}

/// Tangent stiffness `Σ K_i − ½ [m_i]×` of the platform from condensed chains: the change of the applied wrench per twist.
#[inline(always)]
pub(super) fn tangent<R: Real>(chains: &[ChainSystem<R>]) -> Square<R> {
    let mut tangent = [[R::zero(); 6]; 6];
    for chain in chains {
        for (i, row) in tangent.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                *entry += chain.stiffness(i, j);
            }
        }
        let [x, y, z] = chain.moment.scale(R::splat(0.5)).0;
        for (i, j, part) in [(3, 4, z), (4, 5, x), (5, 3, y)] {
            tangent[i][j] += part;
            tangent[j][i] -= part;
        }
    }
    tangent
}

/// Subtracts `½ [m]×`, m the moment of `wrench`, from the rotation block: the part of the tangent by which a dead moment is not conservative.
pub(super) fn subtract_half_moment(tangent: &mut Matrix6<f64>, wrench: Wrench) {
    let mut block = tangent.fixed_view_mut::<3, 3>(3, 3);
    block -= skew(wrench.moment) * 0.5;
}

/// Wrench (N, N·mm) that the platform's step has to balance: `imbalance` less the change of the chain wrenches with the platform held and their closure moments.
#[inline(always)]
pub(super) fn right_hand_side<R: Real>(chains: &[ChainSystem<R>], imbalance: &[R; 6]) -> [R; 6] {
    let mut right = *imbalance;
    for chain in chains {
        let (held, moment) = (chain.held_wrench(), chain.closure_moment());
        for i in 0..6 {
            right[i] -= held[i];
        }
        for i in 0..3 {
            right[3 + i] -= moment.0[i];
        }
    }
    right
}

/// Solves `tangent · dt = right` for the twist dt of P, without the slack springs of `rigid`; also returns the lanes that have a solution.
#[inline(always)]
pub(super) fn step<R: Real>(
    chains: &[ChainSystem<R>],
    rigid: &mut RigidDirections<R>,
    tangent: Square<R>,
    right: [R; 6],
) -> ([R; 6], u8) {
    let mut twist = [right];
    let regular = solve(tangent, 6, &mut twist);
    rigid.correct_step(chains, &mut twist[0]);
    (twist[0], regular)
}

/// Writes the wrench on the held platform per unit motion of each drive, from condensed chains, into `wrenches`.
#[inline(always)]
pub(super) fn drive_wrenches<R: Real>(chains: &[ChainSystem<R>], wrenches: &mut Vec<[R; 6]>) {
    wrenches.clear();
    for chain in chains {
        for drive in 0..chain.drive_count() {
            wrenches.push(chain.drive_wrench(drive));
        }
    }
}

/// Writes the twist of P per unit motion of each drive under constant load, from condensed chains, into `twists`.
#[inline(always)]
pub(super) fn drive_twists<R: Real>(
    chains: &[ChainSystem<R>],
    rigid: &mut RigidDirections<R>,
    tangent: &Square<R>,
    compliance: &Square<R>,
    twists: &mut Vec<[R; 6]>,
) {
    drive_wrenches(chains, twists);
    if !rigid.is_empty() {
        return rigid.drive_twists(chains, tangent, twists);
    }
    for column in twists {
        let wrench = *column;
        for (entry, row) in pairs(column.iter_mut(), compliance) {
            *entry = -dot(row, &wrench);
        }
    }
}

/// Scalar product of two rows of six.
#[inline(always)]
pub(super) fn dot<R: Real>(a: &[R; 6], b: &[R; 6]) -> R {
    let mut sum = R::zero();
    for i in 0..6 {
        sum += a[i] * b[i];
    }
    sum
}

/// Error of as many task coordinates as the drives may move, and its derivative by the twist of P.
#[derive(Debug, Clone, Copy)]
pub(super) struct SquareTask<R> {
    pub count: usize,
    pub error: [R; 6],
    pub slope: Square<R>,
    /// How the drives move with the coordinates of a command; without it each moves by itself.
    pub command: Option<DriveMotions<R>>,
}

impl SquareTask<f64> {
    /// The error of `task` as rows of `count` coordinates; `None` unless it has so many.
    pub fn new(task: &TaskError, count: usize) -> Option<Self> {
        let square = || Self { count, error: task.error.into(), slope: to_rows(&task.slope), command: None };
        (task.count == count).then(square)
    }
}

/// The step in which the drives move as well, by `drive_step`, so that the task error vanishes to first order: `P dt + D dρ = right`,
/// `S dt = −e`, and with a command `dρ = fixed + C ds`. Returns the twist dt of P, ds (or dρ) and the lanes in which there is a step.
#[inline(always)]
pub(super) fn step_to_task<R: Real>(
    chains: &[ChainSystem<R>],
    rigid: &mut RigidDirections<R>,
    tangent: Square<R>,
    right: [R; 6],
    drive_wrenches: &[[R; 6]],
    task: &SquareTask<R>,
    drive_step: &mut [R],
) -> ([R; 6], [R; 6], u8) {
    let (count, drives) = (task.count, drive_wrenches.len());
    // Twist with the drives held, then twist per motion of each drive.
    let mut twists = [right; 7];
    twists[1..=drives].copy_from_slice(drive_wrenches);
    let regular = solve(tangent, 6, &mut twists[..=drives]);
    rigid.correct_task_twists(chains, &mut twists[..=drives]);
    let mut response = [[R::zero(); 6]; 6];
    let mut motions = [[R::zero(); 6]];
    for row in 0..count {
        let mut by_drive = [R::zero(); 6];
        for (drive, entry) in by_drive[..drives].iter_mut().enumerate() {
            *entry = dot(&task.slope[row], &twists[1 + drive]);
        }
        motions[0][row] = dot(&task.slope[row], &twists[0]) + task.error[row];
        let Some(command) = &task.command else {
            response[row] = by_drive;
            continue;
        };
        let parts = pairs(&command.fixed[..drives], &command.per_coordinate[..drives]);
        for (&by, (&fixed, per_coordinate)) in pairs(&by_drive[..drives], parts) {
            motions[0][row] -= by * fixed;
            for (entry, &motion) in pairs(response[row].iter_mut(), per_coordinate) {
                *entry += by * motion;
            }
        }
    }
    let controllable = solve(response, count, &mut motions);
    let mut step = twists[0];
    for (drive, motion) in drive_step.iter_mut().enumerate() {
        *motion = match &task.command {
            None => motions[0][drive],
            Some(command) => {
                let mut motion = command.fixed[drive];
                for (&share, &coordinate) in pairs(&command.per_coordinate[drive][..count], &motions[0][..count]) {
                    motion += share * coordinate;
                }
                motion
            }
        };
        subtract(&mut step, *motion, &twists[1 + drive]);
    }
    rigid.combine_task_slacks(drive_step);
    (step, motions[0], regular & controllable)
}

/// Lanes in which the symmetric part of `tangent` is clearly positive definite: no pivot near zero, rotations taken at `scale` mm. A free
/// motion leaves a pivot that is all rounding, and may leave a diagonal entry that is.
#[inline(always)]
pub(super) fn plainly_definite<R: Real>(tangent: &Square<R>, scale: f64) -> u8 {
    definite_beyond(tangent, scale, 1e-6)
}

/// Lanes in which each pivot of the symmetric part of `tangent`, rotations taken at `scale` mm, exceeds `share` of its largest diagonal entry.
#[inline(always)]
pub(super) fn definite_beyond<R: Real>(tangent: &Square<R>, scale: f64, share: f64) -> u8 {
    let half = R::splat(0.5);
    let scales = [1.0, 1.0 / scale, 1.0 / (scale * scale)];
    let mut upper = *tangent;
    for (i, row) in upper.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            let turns = usize::from(i >= 3) + usize::from(j >= 3);
            *entry = (tangent[i][j] + tangent[j][i]) * half * R::splat(scales[turns]);
        }
    }
    let mut largest = R::zero();
    for (i, row) in upper.iter().enumerate() {
        largest = largest.larger(row[i].abs());
    }
    let least = largest * R::splat(share);
    let mut definite = R::ALL;
    for k in 0..6 {
        let pivot_row = upper[k];
        definite &= R::mask_to_bits(pivot_row[k].greater(least));
        let inverse = R::splat(1.0) / pivot_row[k];
        for (i, row) in upper.iter_mut().enumerate().skip(k + 1) {
            let factor = pivot_row[i] * inverse;
            subtract(&mut row[i..], factor, &pivot_row[i..]);
        }
    }
    definite
}

/// Compliance of the platform without the slack springs of `rigid`, and the lanes in which it has one.
#[inline(always)]
pub(super) fn compliance<R: Real>(rigid: &mut RigidDirections<R>, tangent: Square<R>) -> (Square<R>, u8) {
    let (mut compliance, regular) = inverse(tangent);
    rigid.correct_compliance(&mut compliance);
    (compliance, regular)
}

/// Stiffness from a compliance whose symmetric part is not negative; `None` where it is rigid in some direction. `scale` in
/// mm makes rotations comparable, and `soft` in mm/N is a compliance that springs of the machine have.
pub(super) fn stiffness(compliance: &Square<f64>, scale: f64, soft: f64) -> Option<Square<f64>> {
    let lever = |i: usize| if i < 3 { 1.0 } else { scale };
    let mut remaining: Square<f64> = std::array::from_fn(|i| {
        std::array::from_fn(|j| 0.5 * (compliance[i][j] + compliance[j][i]) * lever(i) * lever(j))
    });
    // Largest pivots first, so that none is left where only rounding is.
    let mut largest = soft;
    let mut done = [false; 6];
    for _ in 0..6 {
        let open = (0..6).filter(|&i| !done[i]);
        let k = open.max_by(|&a, &b| remaining[a][a].total_cmp(&remaining[b][b]))?;
        let pivot_row = remaining[k];
        largest = largest.max(pivot_row[k]);
        if pivot_row[k].is_nan() || pivot_row[k] <= RIGID * largest {
            return None;
        }
        done[k] = true;
        for (row, is_done) in remaining.iter_mut().zip(done) {
            let factor = row[k] / pivot_row[k];
            for (entry, value) in row.iter_mut().zip(pivot_row).filter(|_| !is_done) {
                *entry -= factor * value;
            }
        }
    }
    let (stiffness, regular) = inverse(*compliance);
    (regular == 1).then_some(stiffness)
}

/// A pivot of a compliance below this fraction of the largest is that of a rigid direction.
const RIGID: f64 = 1e-12;

/// Inverse of `matrix`, and the lanes in which the matrix is regular.
#[inline(always)]
fn inverse<R: Real>(matrix: Square<R>) -> (Square<R>, u8) {
    let mut columns = [[R::zero(); 6]; 6];
    for (i, column) in columns.iter_mut().enumerate() {
        column[i] = R::splat(1.0);
    }
    let regular = solve(matrix, 6, &mut columns);
    let mut rows = columns;
    for (i, row) in rows.iter_mut().enumerate() {
        for (entry, column) in pairs(row.iter_mut(), &columns) {
            *entry = column[i];
        }
    }
    (rows, regular)
}
