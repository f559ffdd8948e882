//! What an answer says, in sentences.

/// The sentences, one a line, by the question that they answer.
#[derive(Debug, Clone)]
pub struct Said {
    /// What must be known with the answer.
    pub cautions: String,
    /// How far the tool is off, and where.
    pub place: String,
    /// What the single sources do.
    pub cause: String,
    /// What to command instead.
    pub remedy: String,
}

impl Said {
    /// All but what must be known with the answer.
    pub fn details(&self) -> String {
        [self.place.as_str(), &self.cause, &self.remedy].concat()
    }
}
