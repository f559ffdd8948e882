//! G-code programs of 3-axis mills: read, followed, and written back with moved points.
//!
//! What is followed of ISO code is the RS-274 subset a 3-axis mill uses; of other dialects ([`Dialect`]) it is in the user
//! guide. Everything else is refused by name; nothing that could change where the tool goes is ignored.
//!
//! | followed | meaning |
//! |---|---|
//! | G0 G1 G2 G3 | rapid, line, arcs (helical too; centre by I J K or radius by R) |
//! | G73 G74 G76 G81 … G86 G89, G98 G99, G80 | cycles, where they end, no cycle |
//! | G17 G18 G19 | plane of arcs |
//! | G20 G21 | inch, mm |
//! | G54 … G59.3, G54.1 P, G110 … G129, G15 H, G10 L2 L20, G52, G92 … G92.3 | zeros of the coordinates, see [`GcodeOptions::work_offsets_mm`] |
//! | G90 G91, G90.1 G91.1 | absolute or incremental coordinates, and arc centres |
//! | F with G93 G94 G95, S with G96 G97 | feed, spindle speed |
//! | A B C | must keep one value; U V W must be 0 |
//! | G28 G28.2 G30 G53; `$H` `$J` | copied as they are; the axes they move are unknown until a G0 or G1 gives them again |
//! | other G, D E H M N O P Q T words that do not move the tip; `$` `?` `!` `~` lines | copied as they are |
//! | `( )`, `;`, `%`, `/`, blank lines | copied as they are; [`BlockDelete`] says whether `/` lines count |
//!
//! Decisions, where controllers differ:
//! - Numbers without a decimal point are whole units: `X10` is 10 mm in G21.
//! - Before the first word that says otherwise: G0, G17, G54, G90, G91.1, G94, G97, G98, [`GcodeOptions::unit`].
//! - Coordinates are those of the tool tip; G43 and G49 do not move the path.
//! - A tool change (M6) leaves the tool where it was, and puts the tool of the last T into the spindle; before the first M6,
//!   that of the last T is there. M2, M30 and the second % end the program; motions after them are refused.
//! - The unit on a line applies to the F on the same line.
//! - A rapid move is one path point, its end. Controllers need not drive it straight.
//! - Where the tool is is not known until G0 and G1 have given X, Y and Z: motions before stay as they are ([`Notes`]).

mod arc;
mod blocks;
mod check;
mod cycle;
mod dialect;
mod edit;
mod error;
mod expand;
mod features;
mod fit;
mod follow;
mod interpret;
mod lex;
mod lines;
mod macro_fault;
mod modal;
mod motion;
mod notes;
mod offsets;
mod options;
mod place;
mod pole;
mod refused;
mod request;
mod rewrite;
mod settings;
mod split;
mod unit;
mod write_holes;
mod writer;
mod writing;

pub use blocks::Move;
pub use dialect::{Dialect, Foreign};
pub use error::{ArcFault, Fault, GcodeError, MacroFault, Unsupported};
pub use expand::Beside;
pub use notes::Notes;
pub use offsets::WorkOffset;
pub use options::{ArcCentres, BlockDelete, GcodeOptions};
pub use rewrite::{RewriteError, Rewritten};
pub use unit::LengthUnit;
pub use writing::Writing;

use std::ops::Range;

use dialect::{Language, Statement};
use expand::WrittenOut;
use interpret::{Effect, Interpreter, OriginAt};
use lines::Line;
use modal::MotionCode;
use motion::Motion;
use pole::Pole;

use crate::toolpath::{NumberFormat, PathPoint, Sampling, Toolpath};

/// A program that has been read and followed.
#[derive(Clone, Debug)]
pub struct Program {
    name: String,
    options: GcodeOptions,
    dialect: Dialect,
    source: Vec<u8>,
    lines: Vec<Line>,
    /// The lines with a motion word or a motion, in order.
    blocks: Vec<Block>,
    motions: Vec<Motion>,
    own_format: NumberFormat,
    notes: Notes,
    /// Of a program written out, where its lines come from.
    written_out: Option<WrittenOut>,
}

/// A line that has to do with motion.
#[derive(Clone, Debug)]
struct Block {
    /// Index of the line, from 0.
    line: usize,
    /// The motion word on it.
    motion_word: Option<MotionCode>,
    /// Indices of the motions it makes: one, or the holes of a cycle.
    motions: Range<usize>,
    /// The zero it sets by where the tool is.
    origin_at: Option<OriginAt>,
    /// The centre of arcs that it sets.
    pole: Option<Pole>,
    /// Length of what new lines of it begin with as well: blanks and block-delete mark, in Heidenhain's dialect the number.
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
        let dialect = options.dialect.unwrap_or_else(|| Dialect::of(&source));
        let mut program = Program {
            name: name.to_owned(),
            options: GcodeOptions { dialect: Some(dialect), ..options.clone() },
            dialect,
            source,
            lines,
            blocks: Vec::new(),
            motions: Vec::new(),
            own_format: NumberFormat::default(),
            notes: Notes::default(),
            written_out: None,
        };
        program.follow()?;
        program.own_format = program.decimals_seen();
        Ok(program)
    }

    fn follow(&mut self) -> Result<(), GcodeError> {
        let options = self.options.clone();
        let mut interpreter = Interpreter::new(&options, self.dialect);
        let mut language = Language::new(self.dialect);
        let mut percents = 0;
        for line in 0..self.lines.len() {
            let content = self.content(line);
            if options.block_delete == BlockDelete::Skip && lines::is_deletable(content) {
                continue;
            }
            let located = |refusal: error::Refusal| refusal.locate(&self.name, line + 1, content).read_as(self.dialect);
            let statement = language.statement(content);
            // Behind the end, text need not be code.
            if interpreter.has_ended() && !matches!(statement, Ok(Statement::Words { .. })) {
                continue;
            }
            if let Some(feature) = features::begun(&options.features, content) {
                interpreter.begin_feature(feature);
            }
            match statement.map_err(located)? {
                Statement::Percent => percents += 1,
                Statement::Command { moves } => interpreter.lose(line + 1, [moves; 3]),
                Statement::Words { words, prefix } => {
                    let effect = interpreter.line(line + 1, words).map_err(located)?;
                    self.keep(line, prefix, effect);
                }
            }
            if percents == 2 {
                interpreter.end_in(line + 1);
            }
        }
        self.notes = interpreter.notes;
        Ok(())
    }

    fn keep(&mut self, line: usize, prefix: usize, effect: Effect) {
        if effect == Effect::default() {
            return;
        }
        let first = self.motions.len();
        self.motions.extend(effect.motions);
        let motions = first..self.motions.len();
        let Effect { motion_word, origin_at, pole, .. } = effect;
        self.blocks.push(Block { line, motion_word, motions, origin_at, pole, prefix });
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

    /// The dialect it was read as, what was taken for granted, and which lines stay as they are.
    #[must_use]
    pub fn notes(&self) -> &Notes {
        &self.notes
    }

    /// Whether a motion is a hole of a cycle.
    #[must_use]
    pub fn is_hole(&self, segment: usize) -> bool {
        self.motions.get(segment).is_some_and(|motion| matches!(motion.geometry, motion::Geometry::Hole(_)))
    }

    /// How many motion blocks the program has; [`PointSource::segment`](crate::toolpath::PointSource) counts them.
    #[must_use]
    pub fn motion_count(&self) -> usize {
        self.motions.len()
    }

    /// The line, from 1, of a motion block.
    #[must_use]
    pub fn line_of(&self, segment: usize) -> Option<usize> {
        let line = self.motions.get(segment).map(|motion| motion.line);
        line.map(|line| self.written_out.as_ref().map_or(line, |written_out| written_out.line_of(line)))
    }

    /// The bytes of the line of a motion block, without its ending.
    #[must_use]
    pub fn content_of(&self, segment: usize) -> Option<&[u8]> {
        self.motions.get(segment).map(|motion| self.content(motion.line - 1))
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
        self.sample(|_, motion| Some(motion.parameters(motion.pieces(sampling)?)))
    }

    /// The path with the points of each motion where `parameters` says.
    fn sample(&self, mut parameters: impl FnMut(usize, &Motion) -> Option<Vec<f64>>) -> Result<Toolpath, GcodeError> {
        let mut points: Vec<PathPoint> = Vec::new();
        for (segment, motion) in self.motions.iter().enumerate() {
            let first = points.len();
            match parameters(segment, motion).filter(|own| first + own.len() <= Sampling::MAX_POINTS) {
                Some(own) => motion.sample(segment, &own, &mut points),
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
        let Motion { line, span, .. } = &self.motions[segment];
        let refused = error::Refusal::new(span.clone(), fault).locate(&self.name, *line, self.content(line - 1));
        let refused = refused.read_as(self.dialect);
        self.written_out.as_ref().map_or(refused.clone(), |written_out| written_out.located(refused))
    }

    /// The bytes of line `index` (from 0), without its ending.
    fn content(&self, index: usize) -> &[u8] {
        &self.source[self.lines[index].content.clone()]
    }
}
