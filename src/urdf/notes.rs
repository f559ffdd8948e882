//! The notes of an import: what was not used and what was assumed.

use super::source::quoted_list;

/// The notes of an import, a sentence each.
#[derive(Debug, Default)]
pub(super) struct ImportNotes(Vec<String>);

impl ImportNotes {
    /// Adds a note.
    pub fn add(&mut self, note: String) {
        self.0.push(note);
    }

    /// Adds a note before all others.
    pub fn add_first(&mut self, note: String) {
        self.0.insert(0, note);
    }

    /// Adds a note that says `what` about the things called `names`, if there are any.
    pub fn add_names<'a>(&mut self, what: &str, names: impl IntoIterator<Item = &'a str>) {
        let names = quoted_list(names);
        if !names.is_empty() {
            self.add(format!("{what}: {names}"));
        }
    }

    /// Returns all notes.
    pub fn into_vec(self) -> Vec<String> {
        self.0
    }
}
