//! A program walked through line by line: each block with its motions, found anew on every walk, so that a program is held
//! as its bytes and however long it is takes little memory.

use crate::toolpath::{
    model::{
        NumberFormat, Way,
        gcode::{BlockDelete, Centre, GcodeError, LengthUnit, Motion, MotionCode, Notes, Refusal},
        number,
    },
    read::gcode::{Effect, Interpreter, Language, OriginAt, Pole, Program, ShownStyle, Statement, Style, lines},
};

/// A line that has to do with motion.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    /// Index of the line, from 0.
    pub line: usize,
    /// The motion word on it.
    pub motion_word: Option<MotionCode>,
    /// The motions it makes: one, or the holes of a cycle.
    pub motions: Vec<Motion>,
    /// The zero it sets by where the tool is.
    pub origin_at: Option<OriginAt>,
    /// The centre of arcs that it sets.
    pub pole: Option<Pole>,
    /// Length of what new lines of it begin with as well: blanks and block-delete mark, in Heidenhain's dialect the number.
    pub prefix: usize,
}

/// What is kept of a motion.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MotionAt {
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
            *seen = number::decimals_in(&String::from_utf8_lossy(&content[word.number()])).max(*seen);
        }
    }
}

/// Which arcs go about the centres that lines of their own set.
#[derive(Default)]
struct ArcsOfPoles {
    arcs: Vec<Option<usize>>,
    /// Those of the centres seen since the last arc about any.
    waiting: Vec<Pole>,
}

impl ArcsOfPoles {
    /// Takes the next block, whose motions have the indices from `first` on.
    fn see(&mut self, block: &Block, first: usize) {
        let is_about = |(_, motion): &(usize, &Motion)| matches!(motion.centre, Some(Centre::Pole(_)));
        if let Some((index, motion)) = (first..).zip(&block.motions).find(is_about) {
            let from = self.arcs.len() - self.waiting.len();
            for (arc, pole) in self.arcs[from..].iter_mut().zip(self.waiting.drain(..)) {
                *arc = pole.is_of(motion).then_some(index);
            }
        }
        if let Some(pole) = &block.pole {
            self.arcs.push(None);
            self.waiting.push(pole.clone());
        }
    }
}

impl Program {
    /// All its blocks, for what looks at several at once.
    pub(crate) fn all_blocks(&self) -> Result<Vec<Block>, GcodeError> {
        let mut blocks = Vec::new();
        self.walk(|block| {
            blocks.push(block.clone());
            Ok::<(), GcodeError>(())
        })?;
        Ok(blocks)
    }

    /// Gives each block to `visit`, in order; then what a reader should know.
    ///
    /// # Errors
    /// A line that cannot be followed, and those of `visit`.
    pub(crate) fn walk<E: From<GcodeError>>(&self, mut visit: impl FnMut(&Block) -> Result<(), E>) -> Result<Notes, E> {
        let mut interpreter = Interpreter::new(&self.options, self.dialect);
        let mut language = Language::new(self.dialect);
        let mut percents = 0;
        for line in 0..self.lines.len() {
            let content = self.content(line);
            if self.options.block_delete == BlockDelete::Skip && lines::is_deletable(content) {
                continue;
            }
            let located = |refusal: Refusal| refusal.locate(&self.name, line + 1, content).read_as(self.dialect);
            let statement = language.statement(content);
            // Behind the end, text need not be code.
            if interpreter.has_ended() && !matches!(statement, Ok(Statement::Words { .. })) {
                continue;
            }
            if let Some(feature) = feature_begun(&self.options.features, content) {
                interpreter.begin_feature(feature);
            }
            match statement.map_err(located)? {
                Statement::Percent => percents += 1,
                Statement::Command { moves } => interpreter.lose(line + 1, [moves; 3]),
                Statement::Words { words, prefix } => {
                    let effect = interpreter.line(line + 1, words).map_err(located)?;
                    if effect != Effect::default() {
                        let Effect { motion_word, motions, origin_at, pole } = effect;
                        visit(&Block { line, motion_word, motions, origin_at, pole, prefix })?;
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
    pub(crate) fn survey(&mut self) -> Result<(), GcodeError> {
        let (mut motions, mut decimals, mut style) = (Vec::new(), DecimalsSeen::default(), ShownStyle::default());
        let mut poles = ArcsOfPoles::default();
        let notes = self.walk(|block| {
            if let Some(motion) = block.motions.first() {
                let content = self.content(block.line);
                decimals.see(motion, content);
                style = style.or_on_line(content, &motion.words);
            }
            poles.see(block, motions.len());
            let at = |motion: &Motion| MotionAt { line: motion.line, is_hole: matches!(motion.geometry, Way::Hole(_)) };
            motions.extend(block.motions.iter().map(at));
            Ok::<(), GcodeError>(())
        })?;
        let [mm, inch] = decimals.0;
        (self.motions, self.notes) = (motions, notes);
        (self.own_format, self.style) = (NumberFormat::seen(mm, inch), style.over(Style::plain(self.dialect)));
        self.arcs_of_poles = poles.arcs;
        Ok(())
    }
}

/// Index of the longest of `texts` that `line` has, upper or lower case, not within a longer word or number.
fn feature_begun(texts: &[String], line: &[u8]) -> Option<u16> {
    let found = (0..).zip(texts).filter(|(_, text)| has_text(line, text.as_bytes()));
    found.max_by_key(|(_, text)| text.len()).map(|(index, _)| index)
}

fn has_text(line: &[u8], text: &[u8]) -> bool {
    if text.is_empty() || text.len() > line.len() {
        return false;
    }
    let continues = |inner: u8, outer: Option<&u8>| {
        inner.is_ascii_alphanumeric() && outer.is_some_and(|outer| outer.is_ascii_alphanumeric())
    };
    (0..=line.len() - text.len()).any(|start| {
        let end = start + text.len();
        let before = start.checked_sub(1).and_then(|at| line.get(at));
        line[start..end].eq_ignore_ascii_case(text)
            && !continues(text[0], before)
            && !continues(text[text.len() - 1], line.get(end))
    })
}
