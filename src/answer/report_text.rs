//! The results of a question in sentences.

/// Sentences, a line each, by what they are about.
#[derive(Debug, Clone)]
pub struct ReportText {
    /// What a reader must know before the results.
    pub cautions: String,
    /// How large the error of the tool is, and where.
    pub place: String,
    /// Effect of each single source.
    pub cause: String,
    /// What to command to compensate it.
    pub remedy: String,
}

impl ReportText {
    /// Returns all sentences of the report but the cautions.
    pub fn details(&self) -> String {
        [self.place.as_str(), &self.cause, &self.remedy].concat()
    }
}
