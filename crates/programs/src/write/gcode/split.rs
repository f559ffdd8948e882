//! Splits a block that no single block can replace into the fewest arcs and lines that pass its corrected points.

use std::convert::Infallible;

use nalgebra::Vector3;

use crate::{
    expand::edit::{LineEdit, LineShare, is_arc_word, share_of},
    model::{
        MotionGeometry, format_shortest,
        gcode::{Arc, Centre, Dialect, Fault, FeedMode, Motion, MotionCode, PartialPosition, Word, located},
        longest_piece,
        number::format_plain,
    },
    read::gcode::{Block, motion_geometry},
    write::gcode::{CoordinateFormat, RotaryWords, Stretch, Writer, angle_tolerance_deg, centre_through, put_axis},
};

/// Of a written arc that is no full circle, start and end are apart by as many units of the last decimal: rounding must neither
/// make it one nor turn it.
const CHORD_UNITS: f64 = 10.0;

/// The block that is being split: its motion, its text and the format of its coordinates.
#[derive(Clone, Copy)]
struct Split<'a> {
    motion: &'a Motion,
    content: &'a [u8],
    format: CoordinateFormat,
}

/// One arc or line of a split block.
struct Piece {
    code: MotionCode,
    /// Numbers of axes, by axis.
    axes: Vec<(usize, String)>,
    /// Words that say where the centre is.
    centre: Vec<(char, String)>,
    turned: RotaryWords,
    /// Where the piece ends, as written.
    at: PartialPosition,
    /// Where on the piece its points lie, from 0 to 1.
    parameters: Vec<f64>,
}

impl Writer<'_> {
    /// Writes the block as a sequence of arcs and lines that pass the points of `stretch`.
    pub(crate) fn write_split(&mut self, block: &Block, motion: &Motion, format: CoordinateFormat, stretch: Stretch) {
        let content = self.program.content(block.line);
        if let Some(word) = motion.words.iter().find(|word| share_of(word, &motion.words) == LineShare::Axis) {
            let refusal = word.refuse(Fault::MovesWithTool { letter: word.letter });
            self.refused.get_or_insert((motion.line, refusal));
        }
        let splitting = Split { motion, content, format };
        let count = stretch.points.len();
        let mut edit = LineEdit::new(content, &motion.words, self.style);
        let style = edit.style();
        let piece = self.longest_piece(splitting, stretch, true);
        let mut left = stretch.after_points(piece.parameters.len());
        let is_inverse = self.needs_inverse_time(motion);
        let share = |piece: &Piece| count as f64 / piece.parameters.len() as f64;
        let feed_for = |piece: &Piece| inverse_time_feed(motion, share(piece), is_inverse);
        let at_end = remove_end_words(&mut edit, motion, piece.code, !left.points.is_empty());
        if block.motion_word.is_some() || self.motion_word != Some(piece.code) {
            edit.set_motion(piece.code);
        }
        set_feed(&mut edit, feed_for(&piece));
        if is_inverse {
            self.begin_inverse_time(block, motion, &mut edit);
        }
        piece.axes.iter().for_each(|(axis, number)| put_axis(&mut edit, *axis, number));
        piece.turned.words.iter().for_each(|(letter, number)| edit.set_rotary(*letter, number));
        piece.centre.iter().for_each(|(letter, number)| edit.set_arc_word(*letter, number));
        self.out.extend(edit.render());
        self.record_piece(block, motion, &piece, left.points.is_empty());
        let next_line = Split { format: format.for_new_line(&motion.modal), ..splitting };
        while !left.points.is_empty() {
            let piece = self.longest_piece(next_line, left, false);
            left = left.after_points(piece.parameters.len());
            let differs = self.motion_word != Some(piece.code);
            let begin = style.line_prefix().or_else(|| differs.then(|| style.motion(piece.code)));
            let mut words: Vec<String> = begin.into_iter().collect();
            words.extend(piece.axes.iter().map(|(axis, number)| style.axis(*axis, number)));
            words.extend(piece.turned.words.iter().map(|(letter, number)| style.coordinate(*letter, number)));
            words.extend(piece.centre.iter().map(|(letter, number)| style.word(*letter, number)));
            words.extend(feed_for(&piece).map(|feed| style.word('F', &feed)));
            if left.points.is_empty() {
                // Directly behind a number an E would read as an exponent.
                let is_joined = |word: &str| style.separator().is_empty() && word.starts_with(['E', 'e']);
                words.extend(at_end.iter().map(|word| if is_joined(word) { format!(" {word}") } else { word.clone() }));
            }
            self.out.extend_from_slice(&content[..block.prefix]);
            self.out.extend_from_slice(words.join(style.separator()).as_bytes());
            self.record_piece(block, motion, &piece, left.points.is_empty());
        }
        if is_inverse {
            self.end_inverse_time(block, motion);
        }
    }

    /// Whether F would mean another thing where `motion`, of rotary axes alone, is corrected, since X, Y and Z then move as well: to some controls F is theirs then.
    pub(crate) fn needs_inverse_time(&self, motion: &Motion) -> bool {
        matches!(self.style.dialect, Dialect::Iso | Dialect::LinuxCnc)
            && !matches!((motion.modal.feed_mode, motion.code), (FeedMode::InverseTime, _) | (_, MotionCode::Rapid))
            && motion.turned_alone_deg().is_some()
            && motion.minutes(0.0).is_some()
    }

    /// Begins inverse time on a line of its own, and removes the words of the block (`edit`) that would end it at once.
    pub(crate) fn begin_inverse_time(&mut self, block: &Block, motion: &Motion, edit: &mut LineEdit) {
        let is_mode = |word: &Word| word.letter == 'G' && matches!(word.tenths(), Some(930 | 940 | 950));
        for (index, _) in motion.words.iter().enumerate().filter(|(_, word)| is_mode(word)) {
            edit.remove(index);
        }
        self.add_line(block, &self.style.word('G', "93"));
    }

    /// Ends inverse time on a line of its own, with the feed that was in force.
    pub(crate) fn end_inverse_time(&mut self, block: &Block, motion: &Motion) {
        let mode = if motion.modal.feed_mode == FeedMode::PerRevolution { "95" } else { "94" };
        let feed = motion.modal.feed.map_or(0.0, |feed| feed / motion.modal.feed_unit_mm);
        let words = [self.style.word('G', mode), self.style.word('F', &format_plain(feed))];
        self.add_line(block, &words.join(" "));
    }

    /// Writes a line of its own beside those of `block`.
    fn add_line(&mut self, block: &Block, text: &str) {
        self.out.extend_from_slice(&self.program.content(block.line)[..block.prefix]);
        self.out.extend_from_slice(text.as_bytes());
        self.end_line(block, false);
    }

    /// Updates the written position, angles and parameters after a piece of a split block, and ends its line.
    fn record_piece(&mut self, block: &Block, motion: &Motion, piece: &Piece, is_last: bool) {
        self.motion_word = Some(piece.code);
        self.tracked = piece.at;
        self.rotary_angles = [motion.turning.to, piece.turned.to];
        self.record_points(&piece.parameters);
        self.end_line(block, is_last);
    }

    /// Returns the piece that passes the most of the first points of `left`; a line to the first point always passes one.
    fn longest_piece(&self, splitting: Split, left: Stretch, is_first: bool) -> Piece {
        let most = if self.writing.tolerance_mm > 0.0 { left.points.len() } else { 1 };
        let attempt =
            |count: usize| self.fit_piece(splitting, left.first_points(count), [is_first, count == left.points.len()]);
        if is_first && let Some(piece) = attempt(most) {
            return piece;
        }
        let best = attempt(1).unwrap_or_else(|| {
            let lines = [is_first, left.points.len() == 1];
            let (axes, at) = self.axis_numbers(splitting, &left.corrected[0], lines);
            let turned = self.rotary_words(splitting, left.first_points(1), lines);
            Piece { code: MotionCode::Line, axes, centre: Vec::new(), turned, at, parameters: vec![1.0] }
        });
        let Ok(longest) = longest_piece(best, most, |count| Ok::<_, Infallible>(attempt(count)));
        longest
    }

    /// Returns one arc or line through all points of `stretch`, if there is one; `lines`: whether it is the block's first and its last.
    fn fit_piece(&self, splitting: Split, stretch: Stretch, lines: [bool; 2]) -> Option<Piece> {
        let Split { motion, format, .. } = splitting;
        let (axes, at) = self.axis_numbers(splitting, stretch.corrected.last()?, lines);
        let (start, end) = (located(self.tracked)?, located(at)?);
        let turned = self.rotary_words(splitting, stretch, lines);
        let passes = |candidate: &MotionGeometry| {
            let parameters = stretch.parameters(candidate, self.tolerance(format))?;
            let between = [&self.rotary_angles[1], &turned.to];
            stretch.has_angles_at(&parameters, between, angle_tolerance_deg(&motion.turning)).then_some(parameters)
        };
        if self.writing.tolerance_mm > 0.0
            && let Some((candidate, centre)) = self.fit_arc(motion, format, stretch, [start, end])
            && let Some(parameters) = passes(&candidate)
        {
            return Some(Piece { code: motion.code, axes, centre, turned, at, parameters });
        }
        let parameters = passes(&MotionGeometry::Line(start, end))?;
        Some(Piece { code: MotionCode::Line, axes, centre: Vec::new(), turned, at, parameters })
    }

    /// Returns the words that turn the rotary axes to the corrected angles at the last point of `stretch`; `lines`: whether first and last.
    fn rotary_words(&self, Split { motion, content, .. }: Split, stretch: Stretch, lines: [bool; 2]) -> RotaryWords {
        let parameter = stretch.points.last().map_or(1.0, |point| point.source.parameter);
        let corrected = stretch.angles.and_then(|angles| angles.last()).copied();
        self.rotary_words_to(motion, content, &corrected.unwrap_or_else(|| motion.turning.at(parameter)), lines)
    }

    /// Fits an arc of the program's plane and direction between these ends (mm) to `stretch`; returns it with the words for its centre. `None` where
    /// the motion is no arc with a centre of its own, no circle is determined, or the arc cannot be written safely.
    fn fit_arc(
        &self,
        motion: &Motion,
        format: CoordinateFormat,
        stretch: Stretch,
        [start, end]: [Vector3<f64>; 2],
    ) -> Option<(MotionGeometry, Vec<(char, String)>)> {
        let MotionCode::Arc(turn) = motion.code else { return None };
        if !self.style.dialect.is_iso() {
            return None;
        }
        if !self.writing.helical_arcs && motion.would_be_helical(&start, &end) {
            return None;
        }
        let plane = motion.modal.plane;
        let [first, second, _] = plane.axes();
        let chord = libm::hypot(end[first] - start[first], end[second] - start[second]);
        if chord > 0.0 && chord < CHORD_UNITS * format.unit_mm() {
            return None;
        }
        let at = centre_through(plane, &start, &end, stretch.goals().map(|goal| goal.position))?;
        let fitted = Arc::new(plane, turn, start, end, Centre::At(at), motion.modal.unit).ok()?;
        let is_long = fitted.sweep_rad().abs() > std::f64::consts::PI;
        let (centre, words) = format.write_centre(motion, &start, at, is_long)?;
        Some((motion_geometry(motion.code, motion.modal, start, end, Some(centre)).ok()?, words))
    }

    /// Returns the axis numbers that lead to `goal` (mm in W) and the position they reach; the first line keeps a number for each word it
    /// has. Where a word of the block already leads there, on the first line or the last, it keeps its text.
    fn axis_numbers(
        &self,
        Split { motion, content, format }: Split,
        goal: &Vector3<f64>,
        [first, last]: [bool; 2],
    ) -> (Vec<(usize, String)>, PartialPosition) {
        let (mut numbers, mut reached) = (Vec::new(), self.tracked);
        for axis in 0..3 {
            let word = motion.words.iter().find(|word| word.letter == ['X', 'Y', 'Z'][axis]);
            let here = self.tracked[axis];
            let unchanged = word.filter(|_| first || last).and_then(|word| {
                let at = format
                    .unchanged_coordinate(&motion.words, self.tracked, axis)
                    .filter(|at| format.is_same(*at, goal[axis]))?;
                Some((String::from_utf8_lossy(&content[word.number()]).into_owned(), at))
            });
            match unchanged {
                Some((number, at)) if first || here != Some(at) => {
                    reached[axis] = Some(at);
                    numbers.push((axis, number));
                }
                _ if (first && word.is_some()) || here.is_none_or(|at| !format.is_same(at, goal[axis])) => {
                    let written = format.new_word(axis, here, goal[axis]);
                    reached[axis] = written.at;
                    numbers.extend(written.number.map(|number| (axis, number)));
                }
                _ => {}
            }
        }
        if numbers.is_empty() {
            // A block without a coordinate would be no block; this one repeats the point it is at.
            let at = reached[0].unwrap_or(goal.x);
            numbers.extend(format.new_word(0, Some(at), at).number.map(|number| (0, number)));
        }
        (numbers, reached)
    }
}

/// Returns the inverse-time feed (G93) of a piece that takes one `share`th of the block's time; `None` in other feed modes, unless it `is_inverse` as written.
pub(crate) fn inverse_time_feed(motion: &Motion, share: f64, is_inverse: bool) -> Option<String> {
    let own = motion.modal.feed.filter(|_| motion.modal.feed_mode == FeedMode::InverseTime);
    let feed = if is_inverse { motion.minutes(0.0).map(|minutes| 1.0 / minutes) } else { own };
    feed.map(|feed| format_shortest(feed * share, 1))
}

/// Sets the number after F on the line, in its word or in a new one.
pub(crate) fn set_feed(edit: &mut LineEdit, feed: Option<String>) {
    match (feed, edit.find(|word| word.letter == 'F')) {
        (Some(feed), Some(index)) => edit.set_number(index, &feed),
        (Some(feed), None) => edit.add_last('F', &feed),
        (None, _) => {}
    }
}

/// Removes arc words from a line motion (`code`) and, if `others_follow`, the words that act at the end of the block, which are returned.
fn remove_end_words(edit: &mut LineEdit, motion: &Motion, code: MotionCode, others_follow: bool) -> Vec<String> {
    let mut at_end = Vec::new();
    for (index, word) in motion.words.iter().enumerate() {
        if is_arc_word(word) && code == MotionCode::Line {
            edit.remove(index);
        } else if others_follow && share_of(word, &motion.words) == LineShare::Last {
            at_end.extend(edit.remove(index));
        }
    }
    at_end
}
