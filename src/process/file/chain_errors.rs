//! Geometric errors of chains in process and study files, as written and checked.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::{
    input::{check::Check, error::Result, names::listed},
    machine::{ChainError, Machine},
    spatial::Twist,
};

/// The geometric errors of one chain, as written.
#[derive(Debug, Clone, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ChainErrorSpec {
    /// Name of the chain.
    pub chain: String,
    /// Turn of the whole chain about the axis of its first drive.
    pub turn_about_drive_axis_deg: Option<f64>,
    /// Displacement of the chain's first frame, in its axes.
    pub base_translation_mm: Option<[f64; 3]>,
    /// Rotation vector of the chain's first frame, in its axes.
    pub base_rotation_deg: Option<[f64; 3]>,
    /// Displacement of the chain's last frame, in its axes.
    pub end_translation_mm: Option<[f64; 3]>,
    /// Rotation vector of the chain's last frame, in its axes.
    pub end_rotation_deg: Option<[f64; 3]>,
    /// Zero-point errors of the chain's drives, in the order of the drives: mm for prismatic joints, degrees for revolute joints.
    pub drive_offsets_mm_or_deg: Option<Vec<f64>>,
}

impl ChainErrorSpec {
    /// Whether no error is given, not even a zero one.
    pub fn gives_no_error(&self) -> bool {
        let vectors =
            [self.base_translation_mm, self.base_rotation_deg, self.end_translation_mm, self.end_rotation_deg];
        self.turn_about_drive_axis_deg.is_none()
            && self.drive_offsets_mm_or_deg.is_none()
            && vectors.iter().all(Option::is_none)
    }
}

/// Checks chain errors; returns one for each chain of the machine, in its order (mm and rad), zero for chains that are not named.
pub(crate) fn chain_errors(specs: &[ChainErrorSpec], machine: &Machine, check: &Check) -> Result<Vec<ChainError>> {
    let mut errors = vec![ChainError::default(); machine.chains.len()];
    for (i, spec) in specs.iter().enumerate() {
        let check = check.key(&format!("chain_error[{i}]"));
        check.key("chain").unique(&spec.chain, specs[..i].iter().map(|s| s.chain.as_str()))?;
        let Some(index) = machine.chain_index(&spec.chain) else {
            check.key("chain").misfit(unknown_chain(machine, &spec.chain), ())?;
            continue;
        };
        errors[index] = chain_error(spec, machine, index, &check)?;
    }
    Ok(errors)
}

/// Returns the message that no chain of `machine` is called `name`, with the names that there are.
pub(crate) fn unknown_chain(machine: &Machine, name: &str) -> String {
    let known = listed(machine.chains.iter().map(|chain| &chain.name));
    format!("no chain is called \"{name}\"; there are: {known}")
}

/// Checks the errors of the chain with index `index`; converts them to mm and rad. Fails if none is given, or two exclude each other.
fn chain_error(spec: &ChainErrorSpec, machine: &Machine, index: usize, check: &Check) -> Result<ChainError> {
    if spec.gives_no_error() {
        return check.fail(
            "names no error: expected turn_about_drive_axis_deg, base_translation_mm, base_rotation_deg, end_translation_mm, \
             end_rotation_deg or drive_offsets_mm_or_deg"
                .into(),
        );
    }
    let vector = |key: &str, given: Option<[f64; 3]>| check.key(key).finite(given.unwrap_or_default());
    let radians = |key: &str, given| -> Result<Vector3<f64>> { Ok(vector(key, given)?.map(f64::to_radians)) };
    let turn = spec.turn_about_drive_axis_deg.unwrap_or(0.0);
    let turn = check.key("turn_about_drive_axis_deg").finite_scalar(turn)?.to_radians();
    let base_rotation = radians("base_rotation_deg", spec.base_rotation_deg)?;
    let end_rotation = radians("end_rotation_deg", spec.end_rotation_deg)?;
    for (key, angle) in [
        ("turn_about_drive_axis_deg", turn),
        ("base_rotation_deg", base_rotation.norm()),
        ("end_rotation_deg", end_rotation.norm()),
    ] {
        if let Some(problem) = ChainError::rotation_problem(angle) {
            return check.key(key).fail(problem);
        }
    }
    let chain = &machine.chains[index];
    let mut error = ChainError::turn_about_drive_axis(chain, turn);
    if turn != 0.0 && base_rotation != Vector3::zeros() {
        return check.fail("give turn_about_drive_axis_deg or base_rotation_deg, not both".into());
    }
    error.base.linear = vector("base_translation_mm", spec.base_translation_mm)?;
    error.base.angular += base_rotation;
    error.end = Twist { linear: vector("end_translation_mm", spec.end_translation_mm)?, angular: end_rotation };
    let check_offsets = check.key("drive_offsets_mm_or_deg");
    let offsets = spec.drive_offsets_mm_or_deg.as_deref().unwrap_or_default();
    if !offsets.is_empty() && offsets.len() != chain.drives.len() {
        let (expected, found) = (chain.drives.len(), offsets.len());
        let problem = format!("must have one entry per drive of the chain, which is {expected}, got {found}");
        check_offsets.misfit(problem, ())?;
    }
    for (drive, &offset) in chain.drives.iter().zip(offsets) {
        let offset = check_offsets.finite_scalar(offset)?;
        error.drive_offsets.push(drive.motion.from_shown(offset));
    }
    Ok(error)
}
