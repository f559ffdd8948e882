//! The private module `kinetostat._kinetostat`: arrays in, arrays out. What readers of Python see is in `kinetostat/`, which checks shapes
//! and names what comes out.
//!
//! Lengths are in mm, forces in N, moments in N·mm, angles in rad, poses of P in O, as in the library.

mod arrays;
mod build;
mod error;
mod machine;
mod parameters;
mod parts;
mod poses;
mod predicted;
mod program;
mod settle;
mod study;
mod tables;
mod uncertain;
mod waiting;

/// The engine of the package; see `kinetostat`.
#[pyo3::pymodule]
mod _kinetostat {
    #[pymodule_export]
    use crate::error::Error;
    #[pymodule_export]
    use crate::machine::{Machine, machine_names};
    #[pymodule_export]
    use crate::parts::{KeptParts, compute_part, merge_parts, part_head, study_pieces};
    #[pymodule_export]
    use crate::predicted::{predict_by_machine, predict_by_study};
    #[pymodule_export]
    use crate::program::{Process, Program};
    #[pymodule_export]
    use crate::study::{as_toml, run_study};
    #[pymodule_export]
    use crate::tables::read_table;
    #[pymodule_export]
    use crate::uncertain::Uncertainty;

    /// The version of the program whose engine this is.
    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
