//! Shared by the integration tests.

pub mod arm;
pub mod balance;
#[path = "../../../crates/engine/tests/it/cases.rs"]
pub mod cases;
pub mod command;
pub mod engine;
pub mod golden;
pub mod machines;
pub mod placement;
pub mod planar;
#[path = "../../../crates/programs/tests/it/support/programs.rs"]
pub mod programs;
pub mod random_machine;
pub mod results;
pub mod robot_data;
pub mod uncertain;

use kinetostat::{
    process::cutting::{CuttingLaw, LoadError, PathLoad},
    toolpath::Toolpath,
};
use serde_json::Value;

/// Reference states of `machine`; the test fails if they are missing.
pub fn reference(machine: &str) -> Value {
    let file = format!("{}/tests/reference/{machine}.json", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&file).unwrap_or_else(|e| panic!("reference file {file} is missing: {e}"));
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("reference file {file} is broken: {e}"))
}

/// The load at each point of `path`, which `law` must suit.
pub fn path_loads(law: &CuttingLaw, path: &Toolpath) -> Result<Vec<PathLoad>, LoadError> {
    law.check(path)?;
    path.points().iter().map(|point| law.load(point)).collect()
}

/// How close two arrays must be.
#[derive(Debug, Clone, Copy)]
pub enum Within {
    /// Largest difference.
    Absolute(f64),
    /// Largest difference over the largest reference entry.
    RelativeToLargest(f64),
    /// 6×6 by rows: each entry's difference over the geometric mean of the diagonal entries of its row and column.
    Stiffness(f64),
}

impl Within {
    pub fn check(self, what: &str, got: &[f64], expected: &[f64]) {
        assert_eq!(got.len(), expected.len(), "{what}: number of values");
        let largest = expected.iter().fold(0.0f64, |most, v| most.max(v.abs()));
        for (index, (g, e)) in got.iter().zip(expected).enumerate() {
            let (allowed, scale) = match self {
                Within::Absolute(allowed) => (allowed, 1.0),
                Within::RelativeToLargest(allowed) => (allowed, largest),
                Within::Stiffness(allowed) => {
                    let diagonal = |i: usize| expected[7 * i].abs();
                    (allowed, (diagonal(index / 6) * diagonal(index % 6)).sqrt())
                }
            };
            let difference = (g - e).abs() / scale;
            assert!(
                difference <= allowed,
                "{what}[{index}]: {g} differs from {e} by {difference:e}, allowed {allowed:e}"
            );
        }
    }
}
