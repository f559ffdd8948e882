//! G-code programs of 3-axis mills: read, followed, and written back with moved points.
//!
//! What is followed is the RS-274 subset a 3-axis mill uses. Everything else is refused by name; nothing that could
//! change where the tool goes is ignored.
//!
//! | followed | meaning |
//! |---|---|
//! | G0 G1 G2 G3, G80 | rapid, line, arcs (helical too; centre by I J K or radius by R), no motion |
//! | G17 G18 G19 | plane of arcs |
//! | G20 G21 | inch, mm |
//! | G54 … G59 | work offsets, given in [`GcodeOptions`] |
//! | G90 G91, G90.1 G91.1 | absolute or incremental coordinates, and arc centres |
//! | F, S | feed per minute, spindle speed |
//! | G28 G30 G53 | copied as they are; the axes they move are unknown until a G0 gives them again |
//! | G4 G15 G40 G43 G49 G61 G61.1 G64 G69 G94 G97 G98 G99; D H M N O P Q T | copied as they are |
//! | `( )`, `;`, `%`, `/`, blank lines | copied as they are; [`BlockDelete`] says whether `/` lines count |
//!
//! Decisions, where controllers differ:
//! - Numbers without a decimal point are whole units: `X10` is 10 mm in G21.
//! - Before the first word that says otherwise: G17, G54, G90, G91.1, G94, [`GcodeOptions::unit`], no motion.
//! - Coordinates are those of the tool tip; G43 and G49 do not move the path.
//! - A tool change (M6) leaves the tool where it was. M2 and M30 end the program; words after them are refused.
//! - The unit on a line applies to the F on the same line.
//! - A rapid move is one path point, its end. Controllers need not drive it straight.

mod arc;
mod edit;
mod error;
mod interpret;
mod lex;
mod lines;
mod modal;
mod motion;
mod place;
mod request;
mod rewrite;
mod writer;

pub use error::{ArcFault, Fault, GcodeError, Unsupported};
pub use modal::LengthUnit;
pub use rewrite::{RewriteError, Rewritten};

use nalgebra::Vector3;

use interpret::{Effect, Interpreter};
use lines::{Code, Line};
use modal::MotionCode;
use motion::Motion;

use crate::toolpath::{NumberFormat, PathPoint, Sampling, Toolpath, number};

/// What a program does not say itself.
#[derive(Clone, Debug, PartialEq)]
pub struct GcodeOptions {
    /// The unit before the first G20 or G21; mm by default.
    pub unit: LengthUnit,
    /// Where the tool is before the program begins, mm in the workpiece frame; by default not known, so that the
    /// program must first go somewhere by G0.
    pub start_mm: Option<Vector3<f64>>,
    /// The zeros of G54 to G59, mm in the workpiece frame. By default G54 is the workpiece frame itself and the
    /// others are not known; a program that uses one that is not known is refused.
    pub work_offsets_mm: [Option<Vector3<f64>>; 6],
    /// What becomes of lines with a leading `/`.
    pub block_delete: BlockDelete,
}

impl Default for GcodeOptions {
    fn default() -> GcodeOptions {
        let mut work_offsets_mm = [None; 6];
        work_offsets_mm[0] = Some(Vector3::zeros());
        GcodeOptions { unit: LengthUnit::Millimetre, start_mm: None, work_offsets_mm, block_delete: BlockDelete::Run }
    }
}

/// The position of the machine's block-delete switch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum BlockDelete {
    /// Off: lines with a leading `/` run.
    #[default]
    Run,
    /// On: they are skipped, and copied as they are. The rewritten program is right with the switch on only.
    Skip,
}

/// A program that has been read and followed.
#[derive(Clone, Debug)]
pub struct Program {
    name: String,
    options: GcodeOptions,
    source: Vec<u8>,
    lines: Vec<Line>,
    /// The lines with a motion word or a motion, in order.
    blocks: Vec<Block>,
    motions: Vec<Motion>,
    own_format: NumberFormat,
}

/// A line that has to do with motion.
#[derive(Clone, Debug)]
struct Block {
    /// Index of the line, from 0.
    line: usize,
    /// The motion word on it.
    motion_word: Option<MotionCode>,
    /// Index of the motion it makes.
    motion: Option<usize>,
    /// Length of its leading blanks and block-delete mark, if it has such a mark; of the blanks otherwise.
    prefix: usize,
}

impl Program {
    /// Reads and follows a program. `name` is its file name, for messages; `source` is its bytes: comments may be in
    /// any encoding, all else is ASCII.
    ///
    /// # Errors
    /// When the program has a word that cannot be followed, or a motion that cannot be.
    pub fn parse(source: impl Into<Vec<u8>>, name: &str, options: &GcodeOptions) -> Result<Program, GcodeError> {
        let source = source.into();
        let lines = lines::split(&source);
        let mut program = Program {
            name: name.to_owned(),
            options: options.clone(),
            source,
            lines,
            blocks: Vec::new(),
            motions: Vec::new(),
            own_format: NumberFormat::default(),
        };
        program.follow()?;
        program.own_format = program.decimals_seen();
        Ok(program)
    }

    fn follow(&mut self) -> Result<(), GcodeError> {
        let options = self.options.clone();
        let mut interpreter = Interpreter::new(&options);
        let mut percents = 0;
        for line in 0..self.lines.len() {
            let content = self.content(line);
            if options.block_delete == BlockDelete::Skip && lines::is_deletable(content) {
                continue;
            }
            let located = |refusal: error::Refusal| refusal.locate(&self.name, line + 1, content);
            match lines::code(content).map_err(located)? {
                Code::Percent => percents += 1,
                Code::Words { text, prefix } => {
                    let words = lex::words(&text).map_err(located)?;
                    let effect = interpreter.line(line + 1, words).map_err(located)?;
                    self.keep(line, prefix, effect);
                }
            }
            // What follows the second % is not part of the program.
            if percents == 2 {
                break;
            }
        }
        Ok(())
    }

    fn keep(&mut self, line: usize, prefix: usize, effect: Effect) {
        if effect.motion_word.is_none() && effect.motion.is_none() {
            return;
        }
        let motion = effect.motion.map(|motion| {
            self.motions.push(motion);
            self.motions.len() - 1
        });
        self.blocks.push(Block { line, motion_word: effect.motion_word, motion, prefix });
    }

    /// The program's name as given.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The program's bytes.
    #[must_use]
    pub fn source(&self) -> &[u8] {
        &self.source
    }

    /// How many motion blocks the program has; [`PointSource::segment`](crate::toolpath::PointSource) counts them.
    #[must_use]
    pub fn motion_count(&self) -> usize {
        self.motions.len()
    }

    /// The line, from 1, of a motion block.
    #[must_use]
    pub fn line_of(&self, segment: usize) -> Option<usize> {
        self.motions.get(segment).map(|motion| motion.line)
    }

    /// The bytes of the line of a motion block, without its ending.
    #[must_use]
    pub fn content_of(&self, segment: usize) -> Option<&[u8]> {
        self.line_of(segment).map(|line| self.content(line - 1))
    }

    /// The decimals this program itself writes its coordinates with, at most; at least 3 for mm and 4 for inch.
    #[must_use]
    pub fn own_format(&self) -> NumberFormat {
        self.own_format
    }

    /// The path of the program in the workpiece frame: the ends of the pieces its motions are split into. The start
    /// of the program is no point of the path, for no word of the program leads there.
    ///
    /// # Errors
    /// When the path would have more than [`Sampling::MAX_POINTS`] points, or an arc leaves the range of coordinates.
    pub fn toolpath(&self, sampling: Sampling) -> Result<Toolpath, GcodeError> {
        self.sample(|_, motion| motion.pieces(sampling))
    }

    /// The path with each motion split into as many pieces as `pieces` says.
    fn sample(&self, pieces: impl Fn(usize, &Motion) -> Option<usize>) -> Result<Toolpath, GcodeError> {
        let mut points: Vec<PathPoint> = Vec::new();
        for (segment, motion) in self.motions.iter().enumerate() {
            let count = pieces(segment, motion);
            let first = points.len();
            match count.filter(|count| first + count <= Sampling::MAX_POINTS) {
                Some(count) => motion.sample(segment, count, &mut points),
                None => return Err(self.refused(segment, Fault::TooManyPoints)),
            }
            // The ends of an arc are within the range; what lies between need not be.
            if points[first..].iter().any(|point| point.position_mm.amax() > Fault::MAX_COORDINATE_MM) {
                return Err(self.refused(segment, Fault::TooFar));
            }
        }
        Ok(Toolpath::assemble(points))
    }

    fn refused(&self, segment: usize, fault: Fault) -> GcodeError {
        let line = self.line_of(segment).unwrap_or(1);
        let span = self.motions[segment].span.clone();
        error::Refusal::new(span, fault).locate(&self.name, line, self.content(line - 1))
    }

    /// The bytes of line `index` (from 0), without its ending.
    fn content(&self, index: usize) -> &[u8] {
        &self.source[self.lines[index].content.clone()]
    }

    fn decimals_seen(&self) -> NumberFormat {
        let (mut mm, mut inch) = (0, 0);
        for block in &self.blocks {
            let Some(motion) = block.motion.map(|index| &self.motions[index]) else {
                continue;
            };
            let content = self.content(block.line);
            let seen = match motion.modal.unit {
                LengthUnit::Millimetre => &mut mm,
                LengthUnit::Inch => &mut inch,
            };
            for word in motion.words.iter().filter(|word| matches!(word.letter, 'X' | 'Y' | 'Z')) {
                let text = String::from_utf8_lossy(&content[word.span.clone()]);
                *seen = number::decimals_in(&text).max(*seen);
            }
        }
        NumberFormat::seen(mm, inch)
    }
}
