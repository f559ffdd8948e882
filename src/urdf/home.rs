//! The home posture of an imported chain: neither singular nor at the end of a travel.

use nalgebra::{DMatrix, Vector3};

use super::chain::{Drive, Element};
use crate::{
    machine::Motion,
    spatial::{Pose, Twist},
};

/// The home posture: drive positions, mm or degrees, and the pose of the tip.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Home {
    pub drives: Vec<f64>,
    pub pose: Pose,
    /// Number of postures that it was chosen from.
    pub chosen_from: usize,
}

/// Postures tried beside zero and the middles of travel.
const BENT: usize = 512;
/// How far revolute joints are bent, degrees.
const BENDS: [f64; 11] = [0.0, 0.0, 0.0, 30.0, -30.0, 45.0, -45.0, 60.0, -60.0, 90.0, -90.0];
/// Postures that are this share as even as the best are even enough.
const ENOUGH: f64 = 0.8;
/// This share of a travel at either end is kept free.
const MARGIN: f64 = 0.05;
/// A singular value below this fraction of the largest is zero.
const RANK_TOLERANCE: f64 = 1e-9;

/// Chooses, among the postures in which the drives move the tip about as evenly as they can, the one that is bent least;
/// `length` (mm) relates rotations to translations.
pub(super) fn choose_home(elements: &[Element], length: f64) -> Home {
    let drives: Vec<&Drive> = drives(elements).collect();
    let (centres, candidates) = home_candidates(&drives);
    let bend = |posture: &Vec<f64>| -> f64 {
        let from = |centres: &Vec<f64>| centres.iter().zip(posture).map(|(a, b)| (a - b).abs()).sum();
        centres.iter().map(from).fold(f64::INFINITY, f64::min)
    };
    let evenness = evenness(elements, &candidates, length);
    let best = evenness.iter().copied().fold(0.0, f64::max);
    let even = (0..candidates.len()).filter(|&index| evenness[index] >= ENOUGH * best);
    let chosen = even.min_by(|&a, &b| bend(&candidates[a]).total_cmp(&bend(&candidates[b]))).unwrap_or(0);
    let drives = candidates[chosen].clone();
    Home { pose: tip_kinematics(elements, &drives).0, drives, chosen_from: candidates.len() }
}

/// Iterates over the drives among the elements.
pub(super) fn drives(elements: &[Element]) -> impl Iterator<Item = &Drive> {
    elements.iter().filter_map(|element| match element {
        Element::Drive(drive) => Some(drive),
        _ => None,
    })
}

/// Returns the two central postures (zero, and the middles of travel), and these with bent postures about them: drive positions, mm or
/// degrees. The first drive is not bent, as it moves the whole arm.
fn home_candidates(drives: &[&Drive]) -> ([Vec<f64>; 2], Vec<Vec<f64>>) {
    let middle: Vec<f64> = drives.iter().map(|drive| middle_of_travel(drive)).collect();
    let zero: Vec<f64> = drives.iter().zip(&middle).map(|(drive, &middle)| safe_value(drive, 0.0, middle)).collect();
    let mut postures = vec![zero.clone(), middle.clone()];
    let mut random = RandomNumbers(1);
    for number in 0..BENT {
        let about = if number % 2 == 0 { &zero } else { &middle };
        let bent = drives.iter().zip(about).enumerate().map(|(index, (drive, &value))| {
            let bend = BENDS[random.below(BENDS.len())];
            if index == 0 || drive.motion == Motion::Prismatic { value } else { safe_value(drive, value + bend, value) }
        });
        postures.push(bent.collect());
    }
    ([zero, middle], postures)
}

/// Returns the middle of the travel in round numbers, mm or degrees; 0 without travel.
fn middle_of_travel(drive: &Drive) -> f64 {
    let Some([low, high]) = drive.travel else { return 0.0 };
    let middle = 0.5 * (low + high);
    safe_value(drive, middle.round() + 0.0, middle)
}

/// Returns `value` if it is not near the ends of the travel, otherwise `instead`.
fn safe_value(drive: &Drive, value: f64, instead: f64) -> f64 {
    let Some([low, high]) = drive.travel else { return value };
    let margin = MARGIN * (high - low);
    if (low + margin..=high - margin).contains(&value) { value } else { instead }
}

/// Returns the pose of the tip (mm) at these drive positions (mm, degrees), and the twist of the tip for each drive, per mm or rad.
fn tip_kinematics(elements: &[Element], drives: &[f64]) -> (Pose, Vec<Twist>) {
    let mut at = Pose::identity();
    let mut twists = Vec::new();
    let mut values = drives.iter();
    for element in elements {
        let Element::Drive(drive) = element else {
            at = at.compose(&element.pose());
            continue;
        };
        let value = values.next().copied().unwrap_or_default();
        let axis: Vector3<f64> = at.rotation.column(drive.axis.index()).into();
        match drive.motion {
            Motion::Prismatic => {
                twists.push(Twist { linear: axis, angular: Vector3::zeros() });
                at.translate_along(drive.axis, value);
            }
            Motion::Revolute => {
                twists.push(Twist { linear: at.translation.cross(&axis), angular: axis });
                at.rotate_about(drive.axis, value.to_radians());
            }
        }
    }
    for twist in &mut twists {
        twist.linear += twist.angular.cross(&at.translation);
    }
    (at, twists)
}

/// Returns for each posture how evenly the drives move the tip: the smallest over the largest singular value (of as many as the rank
/// allows), of translations alone or of whole motions, whichever is less.
fn evenness(elements: &[Element], postures: &[Vec<f64>], length: f64) -> Vec<f64> {
    let values = |rows: usize| -> Vec<Vec<f64>> {
        postures.iter().map(|posture| singular_values(elements, posture, length, rows)).collect()
    };
    let [translations, motions] = [values(3), values(6)].map(|values| {
        let rank = |values: &Vec<f64>| values.iter().filter(|&&value| value > RANK_TOLERANCE * values[0]).count();
        let most = values.iter().map(rank).max().unwrap_or(0);
        let ratio =
            move |values: &Vec<f64>| if most == 0 || values[0] == 0.0 { 1.0 } else { values[most - 1] / values[0] };
        values.iter().map(ratio).collect::<Vec<f64>>()
    });
    translations.into_iter().zip(motions).map(|(translation, motion)| translation.min(motion)).collect()
}

/// Returns the singular values of the first `rows` rows of the tip's Jacobian, largest first, with rotations in mm at `length`.
fn singular_values(elements: &[Element], drives: &[f64], length: f64, rows: usize) -> Vec<f64> {
    let twists = tip_kinematics(elements, drives).1;
    let column = |twist: &Twist| {
        let unit = if twist.angular == Vector3::zeros() { 1.0 } else { 1.0 / length };
        let mut column = twist.to_vector() * unit;
        column.fixed_rows_mut::<3>(3).scale_mut(length);
        column
    };
    let columns: Vec<_> = twists.iter().map(column).collect();
    let values = DMatrix::from_fn(rows, columns.len(), |i, j| columns[j][i]).singular_values();
    let mut values: Vec<f64> = values.iter().copied().collect();
    values.sort_by(|a, b| b.total_cmp(a));
    values
}

/// A reproducible generator of pseudo-random numbers.
struct RandomNumbers(u64);

impl RandomNumbers {
    /// Returns the next number, from 0 to `count` − 1.
    fn below(&mut self, count: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        usize::try_from(self.0 >> 33).unwrap_or_default() % count
    }
}
