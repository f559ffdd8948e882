//! A program walked through line by line: each block with its motions, found anew on every walk, so that a program is held
//! as its bytes and however long it is takes little memory.

use crate::toolpath::{
    NumberFormat,
    gcode::{
        BlockDelete, GcodeError, LengthUnit, Notes, Program,
        edit::{ShownStyle, Style},
        error::Refusal,
        interpret::{Effect, Interpreter, OriginAt},
        lex,
        lines::{self, Code},
        modal::MotionCode,
        motion::{Geometry, Motion},
    },
    number,
};

/// A line that has to do with motion.
#[derive(Debug)]
pub(super) struct Block {
    /// Index of the line, from 0.
    pub line: usize,
    /// The motion word on it.
    pub motion_word: Option<MotionCode>,
    /// The motions it makes: one, or the holes of a cycle.
    pub motions: Vec<Motion>,
    /// The zero it sets by where the tool is.
    pub origin_at: Option<OriginAt>,
    /// Length of its leading blanks and block-delete mark, if it has such a mark; of the blanks otherwise.
    pub prefix: usize,
}

/// What is kept of a motion.
#[derive(Clone, Copy, Debug)]
pub(super) struct MotionAt {
    /// The line it is on, from 1.
    pub line: usize,
    pub is_hole: bool,
}

/// Decimals of the coordinates seen so far, mm and inch.
#[derive(Default)]
struct DecimalsSeen([usize; 2]);

impl DecimalsSeen {
    fn see(&mut self, motion: &Motion, content: &[u8]) {
        let seen = &mut self.0[usize::from(motion.modal.unit == LengthUnit::Inch)];
        for word in motion.words.iter().filter(|word| matches!(word.letter, 'X' | 'Y' | 'Z' | 'R')) {
            *seen = number::decimals_in(&String::from_utf8_lossy(&content[word.span.clone()])).max(*seen);
        }
    }
}

impl Program {
    /// Gives each block to `visit`, in order; then what a reader should know.
    ///
    /// # Errors
    /// A line that cannot be followed, and those of `visit`.
    pub(super) fn walk<E: From<GcodeError>>(&self, mut visit: impl FnMut(&Block) -> Result<(), E>) -> Result<Notes, E> {
        let mut interpreter = Interpreter::new(&self.options);
        let mut percents = 0;
        for line in 0..self.lines.len() {
            let content = self.content(line);
            if self.options.block_delete == BlockDelete::Skip && lines::is_deletable(content) {
                continue;
            }
            let located = |refusal: Refusal| refusal.locate(&self.name, line + 1, content);
            let code = lines::code(content);
            // Behind the end, text need not be code.
            if interpreter.has_ended() && !matches!(&code, Ok(Code::Words { text, .. }) if lex::words(text).is_ok()) {
                continue;
            }
            match code.map_err(located)? {
                Code::Percent => percents += 1,
                Code::Command { moves } => interpreter.lose(line + 1, [moves; 3]),
                Code::Words { text, prefix } => {
                    let words = lex::words(&text).map_err(located)?;
                    let effect = interpreter.line(line + 1, words).map_err(located)?;
                    if effect != Effect::default() {
                        let Effect { motion_word, motions, origin_at } = effect;
                        visit(&Block { line, motion_word, motions, origin_at, prefix })?;
                    }
                }
            }
            if percents == 2 {
                interpreter.end_in(line + 1);
            }
        }
        Ok(interpreter.notes)
    }

    /// Walks through the program for the first time, and keeps what is asked of all of it.
    pub(super) fn survey(&mut self) -> Result<(), GcodeError> {
        let (mut motions, mut decimals, mut style) = (Vec::new(), DecimalsSeen::default(), ShownStyle::default());
        let notes = self.walk(|block| {
            if let Some(motion) = block.motions.first() {
                let content = self.content(block.line);
                decimals.see(motion, content);
                style = style.or_on_line(content, &motion.words);
            }
            let at =
                |motion: &Motion| MotionAt { line: motion.line, is_hole: matches!(motion.geometry, Geometry::Hole(_)) };
            motions.extend(block.motions.iter().map(at));
            Ok::<(), GcodeError>(())
        })?;
        let [mm, inch] = decimals.0;
        (self.motions, self.notes) = (motions, notes);
        (self.own_format, self.style) = (NumberFormat::seen(mm, inch), style.over(Style::PLAIN));
        Ok(())
    }
}
