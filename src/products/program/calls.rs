//! What becomes of the subprograms that a program calls when it is written.

use super::Written;
use crate::{input::error::Result, toolpath::gcode::CalledFile};

/// What becomes of the calls, loops and jumps of a program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum WrittenCalls {
    /// It has none, or it was to be written out.
    None,
    /// They stay.
    Stay {
        /// The files that it calls beside it, as they are to be.
        beside: Vec<CalledFile>,
        /// The program if they did not.
        written_out: Vec<u8>,
    },
    /// The program is written out.
    WrittenOut {
        /// Why, in words.
        because: String,
    },
}

impl Written {
    /// Writes the program out after all unless every file that it calls beside it may be there as it is to be, as `may` says: an error
    /// tells why not.
    pub fn call_beside_only_if(&mut self, may: impl Fn(&CalledFile) -> Result<()>) {
        let WrittenCalls::Stay { beside, written_out } = &mut self.calls else { return };
        if let Some(error) = beside.iter().find_map(|file| may(file).err()) {
            self.bytes = std::mem::take(written_out);
            self.calls =
                WrittenCalls::WrittenOut { because: format!("what it calls cannot be written beside it: {error}") };
        }
    }

    /// The files that it calls beside it, as they are to be there.
    pub fn called(&self) -> &[CalledFile] {
        match &self.calls {
            WrittenCalls::Stay { beside, .. } => beside,
            _ => &[],
        }
    }
}
