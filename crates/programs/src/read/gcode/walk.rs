//! Walks through a G-code program line by line. Each walk reads its bytes anew, so that long programs take little memory.

use crate::{
    model::{
        MotionGeometry, NumberFormat,
        gcode::{BlockDelete, Centre, Fault, GcodeError, LengthUnit, Motion, MotionCode, Notes, Refusal, Word},
        number,
    },
    read::gcode::{
        Effect, GcodeProgram, Interpreter, LineReader, ObservedStyle, Pole, Statement, Style, ZeroSetting, lines,
    },
};

/// A line that moves the tool or sets a zero or centre.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    /// Index of the line, from 0.
    pub line: usize,
    /// Motion word on the line.
    pub motion_word: Option<MotionCode>,
    /// Motions it makes: one, or the holes of a cycle.
    pub motions: Vec<Motion>,
    /// Zero that it sets by the tool position.
    pub zero_setting: Option<ZeroSetting>,
    /// Centre of arcs that it sets.
    pub pole: Option<Pole>,
    /// Motion in force and words, if its move is not followed (G53, SUPA, a rotary axis alone).
    pub kept_move: Option<(MotionCode, Vec<Word>)>,
    /// Length of what new lines of the block begin with too: blanks, block-delete mark, in Heidenhain's dialect the number.
    pub prefix: usize,
}

/// Line of a motion, and whether it is a hole.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MotionLocation {
    /// The line it is on, from 1.
    pub line: usize,
    pub is_hole: bool,
}

/// Most motions that are held at once.
const MAX_HELD: usize = 1_000_000;

/// Most decimals of the coordinates so far, in mm and in inch.
#[derive(Default)]
struct MostDecimals([usize; 2]);

impl MostDecimals {
    /// Counts the decimals of the coordinates of `motion` in the line `content`.
    fn add(&mut self, motion: &Motion, content: &[u8]) {
        let seen = &mut self.0[usize::from(motion.modal.unit == LengthUnit::Inch)];
        for word in motion.words.iter().filter(|word| matches!(word.letter, 'X' | 'Y' | 'Z' | 'R')) {
            *seen = number::decimals_in(&String::from_utf8_lossy(&content[word.number()])).max(*seen);
        }
    }
}

/// For each centre that a line sets, the first arc about it.
#[derive(Default)]
struct PoleArcs {
    arcs: Vec<Option<usize>>,
    /// Centres since the last arc about any.
    waiting: Vec<Pole>,
}

impl PoleArcs {
    /// Adds the next block, whose motions have the indices from `first` on: finds the centres whose first arc it has.
    fn add(&mut self, block: &Block, first: usize) {
        let is_about = |(_, motion): &(usize, &Motion)| matches!(motion.centre, Some(Centre::Pole(_)));
        if let Some((index, motion)) = (first..).zip(&block.motions).find(is_about) {
            let from = self.arcs.len() - self.waiting.len();
            for (arc, pole) in self.arcs[from..].iter_mut().zip(self.waiting.drain(..)) {
                *arc = pole.is_centre_of(motion).then_some(index);
            }
        }
        if let Some(pole) = &block.pole {
            self.arcs.push(None);
            self.waiting.push(pole.clone());
        }
    }
}

impl GcodeProgram {
    /// Returns all blocks of the program at once. `Err` for a line that cannot be followed.
    pub(crate) fn all_blocks(&self) -> Result<Vec<Block>, GcodeError> {
        let mut blocks = Vec::new();
        let mut motions = 0;
        self.walk(|block| {
            motions += block.motions.len();
            if let Some(last) = block.motions.last().filter(|_| motions > MAX_HELD) {
                return Err(self.error_at(last, Fault::TooMany { what: "motions", count: motions, most: MAX_HELD }));
            }
            blocks.push(block.clone());
            Ok::<(), GcodeError>(())
        })?;
        Ok(blocks)
    }

    /// Passes each block to `visit`, in order, and returns the notes. `Err` from `visit`, or for a line that cannot be followed.
    pub(crate) fn walk<E: From<GcodeError>>(&self, mut visit: impl FnMut(&Block) -> Result<(), E>) -> Result<Notes, E> {
        self.walk_words(|_, _| (), |block, ()| block.map_or(Ok(()), &mut visit))
    }

    /// Passes each line of words to `visit` with its block, if it is one, as [`GcodeProgram::walk`] does, and with what `look` has found in its words; that gets the index of the line, too.
    pub(crate) fn walk_words<T, E: From<GcodeError>>(
        &self,
        look: impl Fn(usize, &[Word]) -> T,
        mut visit: impl FnMut(Option<&Block>, T) -> Result<(), E>,
    ) -> Result<Notes, E> {
        let mut interpreter = Interpreter::new(&self.options, self.dialect);
        let mut reader = LineReader::new(self.dialect);
        let mut percents = 0;
        for line in 0..self.lines.len() {
            let content = self.content(line);
            if self.options.block_delete == BlockDelete::Skip && lines::is_deletable(content) {
                continue;
            }
            let located = |refusal: Refusal| refusal.locate(&self.name, line + 1, content).with_dialect(self.dialect);
            let statement = reader.parse_line(content);
            // Behind the end, text need not be code.
            if interpreter.has_ended() && !matches!(statement, Ok(Statement::Words { .. })) {
                continue;
            }
            if let Some(feature) = feature_on_line(&self.options.features, content) {
                interpreter.begin_feature(feature);
            }
            match statement.map_err(located)? {
                Statement::Percent => percents += 1,
                Statement::Command { moves } => interpreter.forget_position(line + 1, [moves; 3]),
                Statement::Words { words, prefix } => {
                    let found = look(line, &words);
                    let effect = interpreter.follow_line(line + 1, words).map_err(located)?;
                    let has_effect = effect != Effect::default();
                    let Effect { motion_word, motions, zero_setting, pole, kept_move } = effect;
                    let block = Block { line, motion_word, motions, zero_setting, pole, kept_move, prefix };
                    visit(has_effect.then_some(&block), found)?;
                }
            }
            if percents == 2 {
                interpreter.set_end(line + 1);
            }
        }
        Ok(interpreter.notes)
    }

    /// Walks through the program for the first time: sets its motions, centres, decimals, style and notes.
    pub(crate) fn survey(&mut self) -> Result<(), GcodeError> {
        let (mut motions, mut decimals, mut style) = (Vec::new(), MostDecimals::default(), ObservedStyle::default());
        let (mut poles, mut feed_normals) = (PoleArcs::default(), [false; 3]);
        let notes = self.walk(|block| {
            if let Some(motion) = block.motions.first() {
                let content = self.content(block.line);
                decimals.add(motion, content);
                style = style.observe_line(content, &motion.words);
            }
            poles.add(block, motions.len());
            for motion in block.motions.iter().filter(|motion| motion.code != MotionCode::Rapid) {
                feed_normals[motion.modal.plane.axes()[2]] = true;
            }
            let at = |motion: &Motion| MotionLocation {
                line: motion.line,
                is_hole: matches!(motion.geometry, MotionGeometry::Hole(_)),
            };
            motions.extend(block.motions.iter().map(at));
            match block.motions.last() {
                Some(last) if motions.len() > GcodeProgram::MAX_POINTS => {
                    let (count, most) = (motions.len(), GcodeProgram::MAX_POINTS);
                    Err(self.error_at(last, Fault::TooMany { what: "motions", count, most }))
                }
                _ => Ok(()),
            }
        })?;
        let [mm, inch] = decimals.0;
        (self.motions, self.notes) = (motions, Notes { feed_normals, ..notes });
        (self.own_format, self.style) = (NumberFormat::of_source(mm, inch), style.or(Style::plain(self.dialect)));
        self.pole_arcs = poles.arcs;
        Ok(())
    }
}

/// Returns the index of the longest of `texts` that `line` contains, in any case and not within a longer word or number; `None` if it contains none.
fn feature_on_line(texts: &[String], line: &[u8]) -> Option<u16> {
    let found = (0..).zip(texts).filter(|(_, text)| contains_text(line, text.as_bytes()));
    found.max_by_key(|(_, text)| text.len()).map(|(index, _)| index)
}

/// Whether `line` contains `text`, in any case and not within a longer word or number.
fn contains_text(line: &[u8], text: &[u8]) -> bool {
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
