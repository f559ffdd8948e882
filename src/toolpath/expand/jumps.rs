//! Where the flow of a program goes on: labels and the ends of loops, branches and subprograms.

use crate::toolpath::expand::line::SourceLine;

/// A file as lines.
#[derive(Debug)]
pub(crate) struct Source {
    pub lines: Vec<SourceLine>,
    pub endings: Vec<Vec<u8>>,
}

impl Source {
    /// The first line from `from` on that has this O name and one of these keywords.
    pub fn o_after(&self, from: usize, name: &str, keywords: &[&str]) -> Option<usize> {
        (from..self.lines.len()).find(|line| self.is_o(*line, name, keywords))
    }

    /// The last line before `before` that has this O name and one of these keywords.
    pub fn o_before(&self, before: usize, name: &str, keywords: &[&str]) -> Option<usize> {
        (0..before).rev().find(|line| self.is_o(*line, name, keywords))
    }

    fn is_o(&self, line: usize, name: &str, keywords: &[&str]) -> bool {
        let line = &self.lines[line];
        line.o_name.as_deref() == Some(name) && keywords.contains(&line.keyword())
    }

    /// The line that begins program O`name`.
    pub fn program(&self, name: &str) -> Option<usize> {
        self.lines.iter().position(|line| line.o_name.as_deref() == Some(name) && line.keyword().is_empty())
    }

    /// The line N`number` of the program that `from` is in; otherwise that of the file.
    pub fn label(&self, from: usize, number: u32) -> Option<usize> {
        let is_label = |line: &usize| self.lines[*line].n_number == Some(number);
        let begin = (0..=from).rev().find(|line| self.lines[*line].begins_program()).unwrap_or(0);
        let end = (from + 1..self.lines.len()).find(|line| self.lines[*line].begins_program());
        (begin..end.unwrap_or(self.lines.len())).find(is_label).or_else(|| (0..self.lines.len()).find(is_label))
    }

    /// The `END number` after `from`.
    pub fn end_after(&self, from: usize, number: u32) -> Option<usize> {
        (from + 1..self.lines.len()).find(|line| end_number(&self.lines[*line]) == Some(number))
    }

    /// The `DO number` before `from`.
    pub fn do_before(&self, from: usize, number: u32) -> Option<usize> {
        (0..from).rev().find(|line| do_number(&self.lines[*line]) == Some(number))
    }
}

/// The number of Fanuc's `END 1`.
pub(crate) fn end_number(line: &SourceLine) -> Option<u32> {
    let number = line.rest().strip_prefix("END")?;
    number.trim().parse().ok().filter(|_| line.o_name.is_none())
}

/// The number of Fanuc's `WHILE [ … ] DO 1` or `DO 1`.
pub(crate) fn do_number(line: &SourceLine) -> Option<u32> {
    let (_, number) = line.rest().rsplit_once("DO")?;
    number.trim().parse().ok().filter(|_| line.o_name.is_none())
}
