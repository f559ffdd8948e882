//! Canned cycles of ISO programs as moves: up, to the hole, down with pecks and dwell, and back.
//!
//! A series of holes stays as it is if a cycle of it is none of G73, G81, G82, G83, G85 and G89 (others stop, reverse or orient the spindle, which no move
//! does), if a hole starts at an unknown position, with inverse time feed (G93), with I or J, or with a move between that is kept.

use crate::{
    expand::{
        check_length,
        edit::{LineEdit, acts_at_end},
        run::MAX_STEPS,
    },
    model::{
        Hole, MotionGeometry, NumberFormat, format_shortest,
        gcode::{Distance, Fault, FeedMode, GcodeError, MacroFault, Motion, MotionCode, Refusal, Word},
    },
    read::gcode::{Block, GcodeProgram},
};

/// Most pecks of a hole.
const MAX_PECKS: f64 = 10_000.0;

/// Bytes of a program without cycles, and the line, from 0, that each of its lines comes from.
pub(crate) type WithoutCycles = (Vec<u8>, Vec<usize>);

/// P and Q, which stay in force for the holes that follow.
#[derive(Default)]
struct HoleParameters {
    /// Number after P as written, and the cycle it was given with.
    dwell: Option<(String, u32)>,
    /// The peck, mm, and whether it is written with a decimal point.
    peck_mm: Option<(f64, bool)>,
}

/// A move of a cycle; heights are in W, mm.
enum Move {
    Rapid(f64),
    /// To X and Y of the hole, as written on the line of the cycle.
    Over,
    Feed(f64),
    Dwell(String),
}

impl GcodeProgram {
    /// Returns the program with its cycles as moves; `None` if no cycle can be expanded. `Err` for a peck that does not lead down.
    pub(crate) fn without_cycles(&self) -> Result<Option<WithoutCycles>, GcodeError> {
        let blocks = self.all_blocks()?;
        let expandable = expandable_cycle_blocks(&blocks);
        if expandable.is_empty() {
            return Ok(None);
        }
        let (mut bytes, mut origins) = (Vec::new(), Vec::new());
        let mut parameters = HoleParameters::default();
        let mut blocks = blocks.iter().enumerate().peekable();
        let mut is_behind_cycle = false;
        for index in 0..self.lines.len() {
            let ending = self.lines.ending_or_newline(&self.source, index);
            let block = blocks.next_if(|(_, block)| block.line == index);
            let expanded = block.filter(|(number, _)| expandable.contains(number));
            let lines = match expanded {
                Some((_, block)) => self
                    .cycle_lines(block, &mut parameters)
                    .map_err(|refusal| refusal.locate(&self.name, index + 1, self.content(index)))?,
                None => vec![
                    block
                        .filter(|_| is_behind_cycle)
                        .map_or_else(|| self.content(index).to_vec(), |(_, block)| self.line_with_motion(block)),
                ],
            };
            if block.is_some_and(|(_, block)| !block.motions.is_empty()) {
                is_behind_cycle = expanded.is_some();
            }
            for line in lines {
                bytes.extend(line);
                bytes.extend_from_slice(ending);
                origins.push(index);
            }
            check_length(bytes.len(), String::new)
                .map_err(|fault| Refusal::new(0..0, fault).locate(&self.name, index + 1, self.content(index)))?;
        }
        Ok(Some((bytes, origins)))
    }

    /// Returns the line of a block behind a cycle with its motion word added, as the moves of the cycle have left another motion in force.
    pub(crate) fn line_with_motion(&self, block: &Block) -> Vec<u8> {
        let content = self.content(block.line);
        let kept_move = block.kept_move.as_ref().map(|(code, words)| (*code, words));
        let Some((code, words)) = block.motions.first().map(|first| (first.code, &first.words)).or(kept_move) else {
            return content.to_vec();
        };
        let mut edit = LineEdit::new(content, words, self.style);
        if block.motion_word.is_none() {
            edit.add_motion(code);
        }
        edit.render()
    }

    /// Returns the lines of moves that replace the cycle in `block`, without line endings; updates the `parameters` in force.
    fn cycle_lines(&self, block: &Block, parameters: &mut HoleParameters) -> Result<Vec<Vec<u8>>, Refusal> {
        let content = self.content(block.line);
        let Some(first) = block.motions.first() else { return Ok(vec![content.to_vec()]) };
        parameters.update(content, first);
        let mut edit = LineEdit::new(content, &first.words, self.style);
        let style = edit.style();
        let over: Vec<String> = first
            .words
            .iter()
            .filter(|word| matches!(word.letter, 'X' | 'Y'))
            .map(|word| String::from_utf8_lossy(&content[word.span.clone()]).into_owned())
            .collect();
        let mut lines = Vec::new();
        for motion in &block.motions {
            let MotionGeometry::Hole(hole) = &motion.geometry else { continue };
            if lines.len() > MAX_STEPS {
                return Err(Refusal::new(0..content.len(), Fault::Macro(MacroFault::TooManySteps { most: MAX_STEPS })));
            }
            let mut height = hole.start.z;
            for step in parameters.moves(motion, hole, !over.is_empty())? {
                let mut words = match &step {
                    Move::Dwell(seconds) => vec![style.word('G', "4"), style.word('P', seconds)],
                    Move::Feed(_) => vec![style.motion(MotionCode::Line)],
                    Move::Rapid(_) | Move::Over => vec![style.motion(MotionCode::Rapid)],
                };
                match step {
                    Move::Over => words.extend(over.iter().cloned()),
                    Move::Rapid(to) | Move::Feed(to) => {
                        words.push(style.word('Z', &z_number(motion, height, to)));
                        height = to;
                    }
                    Move::Dwell(_) => {}
                }
                lines.push(words.join(style.separator()));
            }
        }
        let anchor = edit.find(is_cycle_word);
        let mut at_end = Vec::new();
        for (index, word) in first.words.iter().enumerate() {
            if is_cycle_word(word) {
                edit.remove(index);
            } else if lines.len() > 1 && acts_at_end(word) {
                at_end.extend(edit.remove(index));
            }
        }
        let mut lines = lines.into_iter();
        if let (Some(index), Some(line)) = (anchor, lines.next()) {
            edit.replace(index, line);
        }
        let mut written = vec![edit.render()];
        written.extend(lines.map(|line| [&content[..block.prefix], line.as_bytes()].concat()));
        if let Some(last) = written.last_mut().filter(|_| !at_end.is_empty()) {
            last.extend_from_slice(style.separator().as_bytes());
            last.extend_from_slice(at_end.join(style.separator()).as_bytes());
        }
        Ok(written)
    }
}

/// Returns the ascending indices of the blocks of series of holes that can be expanded. A series are the cycle blocks that no other motion parts; it can be
/// expanded if each is G73, G81, G82, G83, G85 or G89 at a known position, without inverse time feed, I or J, or a move that is kept.
fn expandable_cycle_blocks(blocks: &[Block]) -> Vec<usize> {
    let mut series: Vec<Vec<usize>> = Vec::new();
    let mut is_open = false;
    for (number, block) in blocks.iter().enumerate() {
        let motions = &block.motions;
        let Some(Motion { code: MotionCode::Cycle(_), .. }) = motions.first() else {
            is_open &= motions.is_empty() && block.motion_word.is_none();
            if let (Some((MotionCode::Cycle(_), _)), Some(current)) = (&block.kept_move, series.last_mut()) {
                current.push(number);
            }
            continue;
        };
        let begins =
            motions.iter().any(|motion| matches!(motion.geometry, MotionGeometry::Hole(hole) if hole.is_first));
        let has_holes = |block: &usize| blocks[*block].motions.iter().any(is_hole);
        match series.last_mut() {
            Some(current) if is_open && !(begins && current.iter().any(has_holes)) => current.push(number),
            _ => series.push(vec![number]),
        }
        is_open = true;
    }
    let is_expandable = |block: &usize| {
        // Behind moves no cycle is in force for a move that is kept.
        blocks[*block].kept_move.is_none()
            && blocks[*block].motions.iter().all(|motion| {
                !motion.is_unlocated()
                    && matches!(motion.code, MotionCode::Cycle(73 | 81 | 82 | 83 | 85 | 89))
                    && motion.modal.feed_mode != FeedMode::InverseTime
                    && !motion.words.iter().any(|word| matches!(word.letter, 'I' | 'J'))
            })
    };
    series.into_iter().filter(|blocks| blocks.iter().all(is_expandable)).flatten().collect()
}

impl HoleParameters {
    /// Sets P and Q by the words of `motion`, whose line is `content`; the first hole of a series resets them.
    fn update(&mut self, content: &[u8], motion: &Motion) {
        if matches!(motion.geometry, MotionGeometry::Hole(Hole { is_first: true, .. })) {
            *self = HoleParameters::default();
        }
        let word = |letter| motion.words.iter().find(|word| word.letter == letter);
        let text =
            |word: &Word| String::from_utf8_lossy(&content[word.span.start + 1..word.span.end]).trim().to_owned();
        self.dwell = word('P').map(|word| (text(word), motion.code.number())).or(self.dwell.take());
        let peck = |word: &Word| (word.value * motion.modal.unit.mm(), text(word).contains('.'));
        self.peck_mm = word('Q').map(peck).or(self.peck_mm);
    }

    /// Returns the moves that drill `hole`; `has_xy` says whether the line of `motion` gives X or Y. `Err` for an invalid peck.
    fn moves(&self, motion: &Motion, hole: &Hole, has_xy: bool) -> Result<Vec<Move>, Refusal> {
        let (clear, bottom) = (hole.clear.z, hole.bottom.z);
        let mut moves = Vec::new();
        if hole.over.z > hole.start.z {
            moves.push(Move::Rapid(hole.over.z));
        }
        if has_xy {
            moves.push(Move::Over);
        }
        if hole.over.z > clear {
            moves.push(Move::Rapid(clear));
        }
        let MotionCode::Cycle(code) = motion.code else { return Ok(moves) };
        if let (73 | 83, Some((peck, has_point))) = (code, self.peck_mm) {
            check_peck(motion, peck, has_point, clear - bottom)?;
            // What is left of the hole's depth is measured by how many pecks are done: they do not add up.
            for depth in (1..)
                .map(|pecks| clear - f64::from(pecks) * peck)
                .take_while(|depth| depth - bottom > NumberFormat::FINEST)
            {
                let above = depth + CLEARANCE_MM;
                moves.push(Move::Feed(depth));
                if code == 83 || above > clear {
                    moves.push(Move::Rapid(clear));
                }
                if above < clear {
                    moves.push(Move::Rapid(above));
                }
            }
        }
        moves.push(Move::Feed(bottom));
        match &self.dwell {
            Some((dwell, cycle)) if matches!(code, 82 | 89) || (matches!(code, 73 | 83) && *cycle == code) => {
                moves.push(Move::Dwell(dwell.clone()));
            }
            _ => {}
        }
        match code {
            85 | 89 => {
                moves.push(Move::Feed(clear));
                moves.extend((hole.back.z > clear).then_some(Move::Rapid(hole.back.z)));
            }
            _ => moves.push(Move::Rapid(hole.back.z)),
        }
        Ok(moves)
    }
}

/// Refuses a peck (mm) that does not lead down, makes too many, or that some controls read in thousandths: above `depth`, without a point.
fn check_peck(motion: &Motion, peck: f64, has_point: bool, depth: f64) -> Result<(), Refusal> {
    let word = motion.words.iter().find(|word| word.letter == 'Q');
    let span = word.map_or(motion.span.clone(), |word| word.span.clone());
    if peck <= 0.0 || depth / peck > MAX_PECKS || (peck > depth && !has_point) {
        return Err(Refusal::new(span, Fault::Peck { depth_mm: depth }));
    }
    Ok(())
}

/// Height above the last depth at which the feed begins again, mm: 0.01 inch, as in LinuxCNC.
const CLEARANCE_MM: f64 = 0.254;

/// Returns the number of the Z word, in the unit and distance mode of `motion`, that leads from height `from` to `to` (mm in W).
fn z_number(motion: &Motion, from: f64, to: f64) -> String {
    let zero = match motion.modal.distance {
        Distance::Absolute => motion.origin.z,
        Distance::Incremental => from,
    };
    format_shortest((to - zero) / motion.modal.unit.mm(), 1)
}

/// Whether `motion` drills a hole whose heights are known.
fn is_hole(motion: &Motion) -> bool {
    matches!(motion.geometry, MotionGeometry::Hole(_))
}

/// Whether `word` is the G word of a cycle that can be expanded, a coordinate, or a word that only a cycle uses.
fn is_cycle_word(word: &Word) -> bool {
    let code = || word.tenths().is_some_and(|tenths| matches!(tenths, 730 | 810 | 820 | 830 | 850 | 890));
    matches!(word.letter, 'X' | 'Y' | 'Z' | 'R' | 'P' | 'Q' | 'L' | 'K') || (word.letter == 'G' && code())
}
