//! Lines that jumps, loops and calls lead to.

use crate::expand::line::SourceLine;

/// A file as lines and their endings.
#[derive(Debug)]
pub(crate) struct SourceFile {
    pub lines: Vec<SourceLine>,
    pub endings: Vec<Vec<u8>>,
}

impl SourceFile {
    /// Index of the first line from `from` on with the O name `name` and one of `keywords`; `None` if there is none.
    pub fn next_o_line(&self, from: usize, name: &str, keywords: &[&str]) -> Option<usize> {
        (from..self.lines.len()).find(|line| self.has_o_word(*line, name, keywords))
    }

    /// Index of the last line before `before` with the O name `name` and one of `keywords`; `None` if there is none.
    pub fn last_o_line(&self, before: usize, name: &str, keywords: &[&str]) -> Option<usize> {
        (0..before).rev().find(|line| self.has_o_word(*line, name, keywords))
    }

    /// Whether the line with index `line` has the O name `name` and one of `keywords`.
    fn has_o_word(&self, line: usize, name: &str, keywords: &[&str]) -> bool {
        let line = &self.lines[line];
        line.o_name.as_deref() == Some(name) && keywords.contains(&line.keyword())
    }

    /// Index of the line that begins program O`name`; `None` if there is none.
    pub fn program_line(&self, name: &str) -> Option<usize> {
        self.lines.iter().position(|line| line.o_name.as_deref() == Some(name) && line.keyword().is_empty())
    }

    /// Index of line N`number` in the program around the line with index `from`, or else in the whole file; `None` if there is none.
    pub fn label_at(&self, from: usize, number: u32) -> Option<usize> {
        let is_label = |line: &usize| self.lines[*line].n_number == Some(number);
        let begin = (0..=from).rev().find(|line| self.lines[*line].begins_program()).unwrap_or(0);
        let end = (from + 1..self.lines.len()).find(|line| self.lines[*line].begins_program());
        (begin..end.unwrap_or(self.lines.len())).find(is_label).or_else(|| (0..self.lines.len()).find(is_label))
    }

    /// Index of the line that Sinumerik's jump from the line `from` leads to: forwards (GOTOF), backwards (GOTOB), or forwards and then from the
    /// beginning of the program; `None` if there is none.
    pub fn jump_target(&self, from: usize, word: &str, target: &str) -> Option<usize> {
        let number = target.strip_prefix('N').and_then(|number| number.parse::<u32>().ok());
        let is_target = |line: &usize| {
            let line = &self.lines[*line];
            line.label.as_deref() == Some(target) || (number.is_some() && line.n_number == number)
        };
        let is_begin = |line: &usize| self.lines[*line].o_name.is_some();
        let begin = (0..=from).rev().find(is_begin).unwrap_or(0);
        let end = (from + 1..self.lines.len()).find(is_begin).unwrap_or(self.lines.len());
        match word {
            "GOTOB" => (begin..=from).rev().find(is_target),
            "GOTOF" => (from + 1..end).find(is_target),
            _ => (from + 1..end).chain(begin..=from).find(is_target),
        }
    }

    /// Index of the next line after `from` with one of `words` that ends or divides the block in which it is, not one within it; `None` if there is
    /// none.
    pub fn block_end(&self, from: usize, words: &[&str]) -> Option<usize> {
        let mut depth = 0i32;
        (from + 1..self.lines.len()).find(|line| {
            let line = &self.lines[*line];
            let found = depth == 0 && words.contains(&line.first_word());
            depth += line.block_change();
            found
        })
    }

    /// Index of the last line before `from` with `word` that begins the block which the line `from` ends; `None` if there is none.
    pub fn block_begin(&self, from: usize, word: &str) -> Option<usize> {
        let mut depth = 0i32;
        (0..from).rev().find(|line| {
            let line = &self.lines[*line];
            let found = depth == 0 && line.first_word() == word && line.block_change() > 0;
            depth += line.block_change();
            found
        })
    }

    /// Index of the next `END number` after `from`; `None` if there is none.
    pub fn find_end_after(&self, from: usize, number: u32) -> Option<usize> {
        (from + 1..self.lines.len()).find(|line| end_number(&self.lines[*line]) == Some(number))
    }

    /// Index of the last `DO number` before `from`; `None` if there is none.
    pub fn find_do_before(&self, from: usize, number: u32) -> Option<usize> {
        (0..from).rev().find(|line| do_number(&self.lines[*line]) == Some(number))
    }
}

/// Number of Fanuc's `END 1`; `None` for other lines.
pub(crate) fn end_number(line: &SourceLine) -> Option<u32> {
    let number = line.rest().strip_prefix("END")?;
    number.trim().parse().ok().filter(|_| line.o_name.is_none())
}

/// Number of Fanuc's `WHILE [ … ] DO 1` or `DO 1`; `None` for other lines.
pub(crate) fn do_number(line: &SourceLine) -> Option<u32> {
    let (_, number) = line.rest().rsplit_once("DO")?;
    number.trim().parse().ok().filter(|_| line.o_name.is_none())
}
