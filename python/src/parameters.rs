//! Deflections as a function of named numbers of the machine.

use std::sync::atomic::{AtomicBool, Ordering};

use kinetostat::{Error, Machine, Result, simulation::Machines};
use rayon::prelude::*;

use crate::{
    poses::Asked,
    settle::{Commanded, settle},
};

/// What is wanted of sets of parameters.
pub struct Sets<'a> {
    /// Names of the columns.
    pub names: &'a [String],
    /// Values, a row for each machine, in the units of parameters.
    pub values: &'a [f64],
    /// Whether a row that makes no machine is one without an answer, not an error.
    pub skips_no_machine: bool,
}

/// The displacement of the tool tip in O, mm, at all cases of `asked` of the machine with each set of parameters: `[sets, cases, 3]`, NaN
/// where there is none.
///
/// # Errors
/// A set that makes no machine, with its row; [`Error::Stopped`] once `stop` is set.
pub fn deflections(machine: &Machine, sets: &Sets<'_>, asked: &Asked, stop: &AtomicBool) -> Result<Vec<f64>> {
    let (columns, width) = (sets.names.len(), 3 * asked.len());
    let commanded = Commanded::uncompensated(false, false);
    let mut found = vec![f64::NAN; sets.values.len() / columns.max(1) * width];
    let rows = found.par_chunks_mut(width.max(1)).zip(sets.values.par_chunks(columns.max(1)));
    rows.enumerate().try_for_each(|(row, (found, values))| {
        if stop.load(Ordering::Relaxed) {
            return Err(Error::Stopped);
        }
        let set: Vec<(&str, f64)> = sets.names.iter().map(String::as_str).zip(values.iter().copied()).collect();
        let machines = machine.with_parameters(&set).and_then(|own| machines_of(&own));
        match machines {
            Ok(machines) => {
                found.copy_from_slice(&settle(&machines, asked, None, commanded, stop)?.deflection);
                Ok(())
            }
            Err(_) if sets.skips_no_machine => Ok(()),
            Err(error) => {
                Err(Error::Argument { argument: format!("parameters, row {row}"), problem: error.to_string() })
            }
        }
    })?;
    Ok(found)
}

/// `machine`, commanded without the errors that are among its parameters.
///
/// # Errors
/// As [`Machines::new`].
pub fn machines_of(machine: &Machine) -> Result<Machines> {
    let errors = machine.parameter_errors();
    match errors.is_empty() {
        true => Machines::new(machine, &errors),
        false => Machines::new(&machine.nominal()?, &errors),
    }
}
