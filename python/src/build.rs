//! Which build of this module computes: another one does not take over what it left unfinished.

use pyo3::{prelude::*, sync::PyOnceLock};

use crate::error::refused;

/// The version and the very build of this module.
pub fn build(py: Python<'_>) -> PyResult<&str> {
    static BUILD: PyOnceLock<String> = PyOnceLock::new();
    let found = BUILD.get_or_try_init(py, || {
        let file: String = py.import("kinetostat._kinetostat")?.getattr("__file__")?.extract()?;
        let bytes = std::fs::read(&file).map_err(|fault| refused(&file, &format!("cannot be read: {fault}")))?;
        let hash = crc32fast::hash(&bytes);
        Ok::<_, PyErr>(format!("version {} for Python (build {hash:08x})", env!("CARGO_PKG_VERSION")))
    })?;
    Ok(found)
}
