//! What the importer has to say: what was not used, what was assumed.

use super::source::list;

/// One sentence each.
#[derive(Debug, Default)]
pub(super) struct Notes(Vec<String>);

impl Notes {
    /// One more.
    pub fn add(&mut self, note: String) {
        self.0.push(note);
    }

    /// The same about several things, if there are any.
    pub fn names<'a>(&mut self, what: &str, names: impl IntoIterator<Item = &'a str>) {
        let names = list(names);
        if !names.is_empty() {
            self.add(format!("{what}: {names}"));
        }
    }

    /// All of them.
    pub fn into_vec(self) -> Vec<String> {
        self.0
    }
}
