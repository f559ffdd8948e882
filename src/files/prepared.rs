//! A folder for results that is gone again if there are none.

use std::path::{Path, PathBuf};

use super::prepare;
use crate::input::error::Result;

/// The folders that had to be made for results. Those that are still empty when this goes out of scope are removed.
#[derive(Debug)]
pub struct PreparedFolder {
    /// The innermost first.
    made: Vec<PathBuf>,
}

impl PreparedFolder {
    /// Makes `folder`, as [`prepare`] does.
    ///
    /// # Errors
    /// As [`prepare`].
    pub fn new(folder: &Path) -> Result<Self> {
        let missing = folder.ancestors().take_while(|part| !part.as_os_str().is_empty() && !part.exists());
        let prepared = Self { made: missing.map(Path::to_path_buf).collect() };
        prepare(folder)?;
        Ok(prepared)
    }
}

impl Drop for PreparedFolder {
    fn drop(&mut self) {
        // One that holds something cannot be removed, and neither can those around it.
        let _ = self.made.iter().try_for_each(std::fs::remove_dir);
    }
}
