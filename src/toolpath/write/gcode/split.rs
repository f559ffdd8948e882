//! Blocks that one block does not replace: written as the fewest arcs and lines that pass their points.

use std::convert::Infallible;

use nalgebra::Vector3;

use crate::toolpath::{
    expand::edit::{LineEdit, acts_at_end, is_arc_word, takes_parameters},
    model::{
        Way,
        gcode::{Arc, Centre, FeedMode, Known, Motion, MotionCode, located},
        longest, shortest,
    },
    read::gcode::{Block, route},
    write::gcode::{Place, Stretch, Turned, Writer, allowed_deg, centre_through, put_axis},
};

/// Of a written arc that is no full circle, start and end are apart by as many units of the last decimal: rounding must neither
/// make it one nor turn it.
const CHORD_UNITS: f64 = 10.0;

/// A block that is being split.
#[derive(Clone, Copy)]
struct Splitting<'a> {
    motion: &'a Motion,
    content: &'a [u8],
    place: Place,
}

/// The next part of a block.
struct Piece {
    code: MotionCode,
    /// Numbers of axes, by axis.
    axes: Vec<(usize, String)>,
    /// Words that say where the centre is.
    centre: Vec<(char, String)>,
    turned: Turned,
    /// Where it leads.
    at: Known,
    /// Where on it its points lie.
    places: Vec<f64>,
}

impl Writer<'_> {
    /// Writes the block as arcs and lines.
    pub(crate) fn split(&mut self, block: &Block, motion: &Motion, place: Place, stretch: Stretch) {
        let content = self.program.content(block.line);
        let splitting = Splitting { motion, content, place };
        let count = stretch.points.len();
        let mut edit = LineEdit::new(content, &motion.words, self.style);
        let style = edit.style();
        let piece = self.longest(splitting, stretch, true);
        let mut left = stretch.behind(piece.places.len());
        let feed_for = |piece: &Piece| feed_of(motion, count as f64 / piece.places.len() as f64);
        let at_end = set_aside(&mut edit, motion, piece.code, !left.points.is_empty());
        if block.motion_word.is_some() || self.motion_word != Some(piece.code) {
            edit.set_motion(piece.code);
        }
        if let (Some(feed), Some(index)) = (feed_for(&piece), edit.find(|word| word.letter == 'F')) {
            edit.set_number(index, &feed);
        }
        piece.axes.iter().for_each(|(axis, number)| put_axis(&mut edit, *axis, number));
        piece.turned.words.iter().for_each(|(letter, number)| edit.put_turn(*letter, number));
        piece.centre.iter().for_each(|(letter, number)| edit.put_arc(*letter, number));
        self.out.extend(edit.render());
        self.wrote(block, motion, &piece, left.points.is_empty());
        let next_line = Splitting { place: place.on_new_line(&motion.modal), ..splitting };
        while !left.points.is_empty() {
            let piece = self.longest(next_line, left, false);
            left = left.behind(piece.places.len());
            let differs = self.motion_word != Some(piece.code);
            let begin = style.next_line().or_else(|| differs.then(|| style.motion(piece.code)));
            let mut words: Vec<String> = begin.into_iter().collect();
            words.extend(piece.axes.iter().map(|(axis, number)| style.axis(*axis, number)));
            words.extend(piece.turned.words.iter().map(|(letter, number)| style.coordinate(*letter, number)));
            words.extend(piece.centre.iter().map(|(letter, number)| style.word(*letter, number)));
            words.extend(feed_for(&piece).map(|feed| style.word('F', &feed)));
            if left.points.is_empty() {
                words.extend_from_slice(&at_end);
            }
            self.out.extend_from_slice(&content[..block.prefix]);
            self.out.extend_from_slice(words.join(style.separator()).as_bytes());
            self.wrote(block, motion, &piece, left.points.is_empty());
        }
    }

    fn wrote(&mut self, block: &Block, motion: &Motion, piece: &Piece, is_last: bool) {
        self.motion_word = Some(piece.code);
        self.tracked = piece.at;
        self.stands = [motion.turning.to, piece.turned.to];
        self.stands_for(&piece.places);
        self.end_line(block, is_last);
    }

    /// The piece that passes most of the first points of `left`: all of a block, or the longest. A line to the first point always does.
    fn longest(&self, splitting: Splitting, left: Stretch, is_first: bool) -> Piece {
        let most = if self.writing.tolerance_mm > 0.0 { left.points.len() } else { 1 };
        let attempt = |count: usize| self.piece(splitting, left.first(count), [is_first, count == left.points.len()]);
        if is_first && let Some(piece) = attempt(most) {
            return piece;
        }
        let best = attempt(1).unwrap_or_else(|| {
            let lines = [is_first, left.points.len() == 1];
            let (axes, at) = self.step(splitting, &left.corrected[0], lines);
            let turned = self.turned(splitting, left.first(1), lines);
            Piece { code: MotionCode::Line, axes, centre: Vec::new(), turned, at, places: vec![1.0] }
        });
        let Ok(longest) = longest(best, most, |count| Ok::<_, Infallible>(attempt(count)));
        longest
    }

    /// One block through all points of `stretch`, if there is one; `[first, last]`: on which lines of the program's block.
    fn piece(&self, splitting: Splitting, stretch: Stretch, lines: [bool; 2]) -> Option<Piece> {
        let Splitting { motion, place, .. } = splitting;
        let (axes, at) = self.step(splitting, stretch.corrected.last()?, lines);
        let (start, end) = (located(self.tracked)?, located(at)?);
        let turned = self.turned(splitting, stretch, lines);
        let passes = |candidate: &Way| {
            let places = stretch.places(candidate, self.allowed(place))?;
            let between = [&self.stands[1], &turned.to];
            stretch.is_turned(&places, between, allowed_deg(&motion.turning)).then_some(places)
        };
        if self.writing.tolerance_mm > 0.0
            && let Some((candidate, centre)) = self.arc(motion, place, stretch, [start, end])
            && let Some(places) = passes(&candidate)
        {
            return Some(Piece { code: motion.code, axes, centre, turned, at, places });
        }
        let places = passes(&Way::Line(start, end))?;
        Some(Piece { code: MotionCode::Line, axes, centre: Vec::new(), turned, at, places })
    }

    /// What turns the rotary axes to where they should stand at the last point of `stretch`.
    fn turned(&self, Splitting { motion, content, .. }: Splitting, stretch: Stretch, lines: [bool; 2]) -> Turned {
        let parameter = stretch.points.last().map_or(1.0, |point| point.source.parameter);
        let corrected = stretch.angles.and_then(|angles| angles.last()).copied();
        self.turn_to(motion, content, &corrected.unwrap_or_else(|| motion.turning.at(parameter)), lines)
    }

    /// The arc of the program's kind between these ends that fits `stretch` best, and the words for its centre.
    fn arc(
        &self,
        motion: &Motion,
        place: Place,
        stretch: Stretch,
        [start, end]: [Vector3<f64>; 2],
    ) -> Option<(Way, Vec<(char, String)>)> {
        let MotionCode::Arc(turn) = motion.code else { return None };
        if !self.style.dialect.is_iso() {
            return None;
        }
        if !self.writing.helical_arcs && motion.makes_helix(&start, &end) {
            return None;
        }
        let plane = motion.modal.plane;
        let [first, second, _] = plane.axes();
        let chord = (end[first] - start[first]).hypot(end[second] - start[second]);
        if chord > 0.0 && chord < CHORD_UNITS * place.unit_mm() {
            return None;
        }
        let at = centre_through(plane, &start, &end, stretch.goals().map(|goal| goal.position))?;
        let fitted = Arc::new(plane, turn, start, end, Centre::At(at)).ok()?;
        let is_long = fitted.sweep_rad().abs() > std::f64::consts::PI;
        let (centre, words) = place.write_centre(motion, &start, at, is_long)?;
        Some((route(motion.code, motion.modal, start, end, Some(centre)).ok()?, words))
    }

    /// The numbers that lead to `goal`, by axis, and where they lead; on the block's first line, also those its own words ask for.
    /// Where a word of the block leads there as it is, on the first line or the last, it keeps its text.
    fn step(
        &self,
        Splitting { motion, content, place }: Splitting,
        goal: &Vector3<f64>,
        [first, last]: [bool; 2],
    ) -> (Vec<(usize, String)>, Known) {
        let (mut numbers, mut reached) = (Vec::new(), self.tracked);
        for axis in 0..3 {
            let word = motion.words.iter().find(|word| word.letter == ['X', 'Y', 'Z'][axis]);
            let here = self.tracked[axis];
            let own = word.filter(|_| first || last).and_then(|word| {
                let at = place.as_it_is(&motion.words, self.tracked, axis).filter(|at| place.same(*at, goal[axis]))?;
                Some((String::from_utf8_lossy(&content[word.number()]).into_owned(), at))
            });
            match own {
                Some((number, at)) if first || here != Some(at) => {
                    reached[axis] = Some(at);
                    numbers.push((axis, number));
                }
                _ if (first && word.is_some()) || here.is_none_or(|at| !place.same(at, goal[axis])) => {
                    let written = place.write(axis, here, goal[axis]);
                    reached[axis] = written.at;
                    numbers.extend(written.number.map(|number| (axis, number)));
                }
                _ => {}
            }
        }
        if numbers.is_empty() {
            // A block without a coordinate would be no block; this one repeats the point it is at.
            let at = reached[0].unwrap_or(goal.x);
            numbers.extend(place.write(0, Some(at), at).number.map(|number| (0, number)));
        }
        (numbers, reached)
    }
}

/// Where F is one over the time of a block: that of a part that takes one `share`th of it.
fn feed_of(motion: &Motion, share: f64) -> Option<String> {
    let feed = motion.modal.feed.filter(|_| motion.modal.feed_mode == FeedMode::InverseTime);
    feed.map(|feed| shortest(feed * share, 1))
}

/// Takes off the first line what a line does not have (the words of arcs) and, if others follow it, what acts at the end of the block,
/// which is returned.
fn set_aside(edit: &mut LineEdit, motion: &Motion, code: MotionCode, others_follow: bool) -> Vec<String> {
    let mut at_end = Vec::new();
    let parameters_at_end = motion.words.iter().filter(|word| takes_parameters(word)).all(acts_at_end);
    for (index, word) in motion.words.iter().enumerate() {
        let moves = acts_at_end(word) || (parameters_at_end && matches!(word.letter, 'E' | 'P' | 'Q'));
        if is_arc_word(word) && code == MotionCode::Line {
            edit.remove(index);
        } else if others_follow && moves {
            at_end.extend(edit.remove(index));
        }
    }
    at_end
}
