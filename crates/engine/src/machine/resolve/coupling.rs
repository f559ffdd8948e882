//! Coupling of the coordinates that a pendant shows with the joints of the drives, from a machine file as written.

use nalgebra::DMatrix;

use super::TO_RAD;
use crate::{
    input::{check::Check, error::Result, names::listed},
    machine::{Chain, Coupling, Motion, spec::ShownSpec},
};

/// A map from joints to shown coordinates is singular below this determinant, its rows being of length 1.
const SINGULAR: f64 = 1e-9;

/// What a pendant shows for a drive, as written in the machine file.
pub(super) struct ShownCoordinate {
    /// Index of the drive, and what stands before the names of the drives of its design.
    pub drive: usize,
    pub prefix: String,
    pub spec: ShownSpec,
    /// Its place in the file.
    pub check: Check,
}

/// Coupling of a chain's drives: the inverse of what `shown` says of each, if any. Drives are named as in their design or the chain.
pub(super) fn resolve_coupling(chain: &Chain, shown: &[ShownCoordinate]) -> Result<Option<Box<Coupling>>> {
    let Some(ShownCoordinate { check: first, .. }) = shown.first() else { return Ok(None) };
    let count = chain.drives.len();
    let mut by_joints: DMatrix<f64> = DMatrix::identity(count, count);
    let mut offsets = vec![0.0; count];
    for ShownCoordinate { drive, prefix, spec, check } in shown {
        let motion = chain.drives[*drive].motion;
        by_joints.row_mut(*drive).fill(0.0);
        for (name, &factor) in &spec.of {
            let check = check.key(&format!("of.{name}"));
            let of_name = |name: &str| chain.drives.iter().position(|other| other.name == name);
            let Some(joint) = of_name(&format!("{prefix}{name}")).or_else(|| of_name(name)) else {
                let known = listed(chain.drives.iter().map(|drive| &drive.name));
                return check.fail(format!("no drive of this chain has this name; there are: {known}"));
            };
            if chain.drives[joint].motion != motion {
                let word = |motion| if motion == Motion::Prismatic { "prismatic joint" } else { "revolute joint" };
                let (other, kind) = (word(chain.drives[joint].motion), word(motion));
                return check.fail(format!("is a {other}, the drive itself a {kind}: expected drives of one kind"));
            }
            by_joints[(*drive, joint)] = check.finite_scalar(factor)?;
        }
        offsets[*drive] = match (motion, spec.offset_deg, spec.offset_mm) {
            (_, None, None) => 0.0,
            (Motion::Revolute, Some(offset), None) => check.key("offset_deg").finite_scalar(offset)? * TO_RAD,
            (Motion::Prismatic, None, Some(offset)) => check.key("offset_mm").finite_scalar(offset)?,
            (Motion::Revolute, ..) => {
                return check.key("offset_mm").fail("the drive is a revolute joint: give offset_deg".into());
            }
            (Motion::Prismatic, ..) => {
                return check.key("offset_deg").fail("the drive is a prismatic joint: give offset_mm".into());
            }
        };
    }
    let lengths: f64 = by_joints.row_iter().map(|row| row.norm()).product();
    let per_shown = match by_joints.clone().try_inverse() {
        Some(inverse) if by_joints.determinant().abs() > SINGULAR * lengths => inverse,
        _ => return first.fail("what the drives show must determine where their joints stand, and does not".into()),
    };
    let offset = -(&per_shown * nalgebra::DVector::from_vec(offsets));
    Ok(Some(Box::new(Coupling { per_shown, offset: offset.as_slice().to_vec() })))
}
