//! Errors of the library as exceptions with the same messages.

use pyo3::{PyErr, create_exception, exceptions::PyException};

create_exception!(
    kinetostat,
    Error,
    PyException,
    "Wrong input, or a file that cannot be read or written; the message names the file, key or line, the value and what was expected."
);

/// `error` as an exception.
pub fn raised(error: kinetostat::Error) -> PyErr {
    Error::new_err(error.to_string())
}

/// The exception that `what` is `problem`.
pub fn refused(what: &str, problem: &str) -> PyErr {
    Error::new_err(format!("{what}: {problem}"))
}
