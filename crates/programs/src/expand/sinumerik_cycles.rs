//! Sinumerik's drilling cycles as moves: once, after each block (MCALL), or in a row or on a circle (HOLES1, HOLES2).

use crate::{
    expand::{
        check_length,
        cycles::WithoutCycles,
        line::long_number,
        sinumerik_holes::{Expected, Hole, InForce, pattern},
    },
    model::gcode::{BlockDelete, Distance, Foreign, GcodeOptions, LengthUnit, Refusal, Word},
    read::{
        gcode::{
            Statement,
            dialect::sinumerik,
            lines::{self, Lines},
        },
        scan::Scan,
    },
};

/// What a line means for cycles.
enum Line {
    /// A hole here.
    Hole(Hole),
    /// A hole after each block that moves from now on, or none any more.
    ModalState(Option<Hole>),
    /// The hole in force at these points of the plane.
    Pattern(Vec<[f64; 2]>),
    Other,
}

/// State of the control that cycles depend on.
#[derive(Default)]
struct State {
    modal: Option<Hole>,
    in_force: InForce,
    is_in_other_plane: bool,
    /// Whether CIP or CT is in force, which a cycle ends.
    is_on_contour: bool,
    /// Whether coordinates are steps (G91).
    steps: bool,
    /// Where the tool is in the plane, in the coordinates of the program, as far as known.
    at: [Option<f64>; 2],
}

/// Returns `source` with its cycles as moves, and the index of the line each line comes from; `None` without cycles. `Err` gives the index of
/// the line with a cycle that cannot be.
pub(crate) fn expand_cycles(source: &[u8], options: &GcodeOptions) -> Result<Option<WithoutCycles>, (usize, Refusal)> {
    let lines = Lines::split(source);
    let (mut out, mut origins) = (Vec::with_capacity(source.len()), Vec::new());
    let (mut state, mut is_changed) = (State::default(), false);
    state.in_force.is_in_inches = options.unit == Some(LengthUnit::Inch);
    for line in 0..lines.len() {
        let content = &source[lines.content(line)];
        check_length(out.len(), String::new).map_err(|fault| (line, Refusal::new(0..content.len(), fault)))?;
        let ending = lines.ending_or_newline(source, line);
        let mut write_line = |text: &[u8]| {
            out.extend_from_slice(text);
            out.extend_from_slice(ending);
            origins.push(line);
        };
        if options.block_delete == BlockDelete::Skip && lines::is_deletable(content) {
            write_line(content);
            continue;
        }
        let refuse = |expected: Expected| (line, refuse(content, expected));
        let meaning = parse_line(content, state.at).map_err(|refusal| (line, refusal))?;
        let (mut hole, mut places) = (None, vec![None]);
        match &meaning {
            Line::Other => {
                write_line(content);
                if state.follow(&line_words(content)).map_err(refuse)? {
                    hole.clone_from(&state.modal);
                }
            }
            Line::Hole(called) => hole = Some(called.clone()),
            Line::Pattern(points) => {
                hole = Some(state.modal.clone().ok_or_else(|| refuse("MCALL with a drilling cycle before it"))?);
                places = points.iter().copied().map(Some).collect();
            }
            Line::ModalState(_) if lines::is_deletable(content) => {
                return Err(refuse("MCALL without /, as the holes behind it would be drilled with and without it"));
            }
            Line::ModalState(modal) => {
                state.modal.clone_from(modal);
                is_changed = true;
            }
        }
        if !matches!(meaning, Line::Other) {
            let comment = &content[Scan::of_line(content, 0).line.len()..];
            if !comment.is_empty() {
                write_line(comment);
            }
        }
        let Some(hole) = hole else { continue };
        if state.is_in_other_plane {
            return Err(refuse("G17"));
        }
        if state.is_on_contour || state.in_force.motion.is_none() {
            return Err(refuse("G0, G1, G2 or G3 before it, which is in force again behind it"));
        }
        let prefix = &content[..lines::prefix_len(content)];
        let moves = hole.moves(state.in_force).map_err(refuse)?;
        // A tap that is written for this one hole stays.
        if matches!(meaning, Line::Hole(_)) && *moves.concat().as_bytes() == content[statement(content).at..] {
            write_line(content);
            continue;
        }
        is_changed = true;
        for place in places {
            if let Some([x, y]) = place {
                let over = format!("G0 X=AC({}) Y=AC({})", long_number(b'X', x), long_number(b'X', y));
                write_line(&[prefix, over.as_bytes()].concat());
                state.at = [Some(x), Some(y)];
            }
            moves.iter().for_each(|text| write_line(&[prefix, text.as_bytes()].concat()));
        }
    }
    Ok(is_changed.then_some((out, origins)))
}

/// Returns the refusal of the statement in the line `content`.
fn refuse(content: &[u8], expected: Expected) -> Refusal {
    let scan = statement(content);
    scan.refuse_all(scan.at, Foreign::CycleValue { expected })
}

/// Returns a cursor at the statement of a line, behind its block number.
fn statement(content: &[u8]) -> Scan<'_> {
    let mut scan = Scan::of_line(content, lines::prefix_len(content));
    if matches!(scan.next(), Some(b'N' | b'n')) {
        let mut number = scan;
        number.at += 1;
        if !number.take_while(|byte| byte.is_ascii_digit()).is_empty() {
            scan = number;
        }
    }
    scan.next();
    scan
}

impl State {
    /// Follows the words of a line that is no cycle, and returns whether a hole in force is drilled behind it. `Err` where that is not known.
    fn follow(&mut self, words: &[Word]) -> Result<bool, Expected> {
        let last_g = |numbers: &[f64]| words.iter().rev().find(|word| is_g(word, numbers)).map(|word| word.value);
        self.is_in_other_plane = last_g(&[17.0, 18.0, 19.0]).map_or(self.is_in_other_plane, |plane| plane != 17.0);
        let on_contour = |word: &Word| matches!(word.letter, 'u' | 'v');
        let motion = words.iter().rfind(|word| is_g(word, &[0.0, 1.0, 2.0, 3.0]) || on_contour(word));
        self.is_on_contour = motion.map_or(self.is_on_contour, on_contour);
        self.steps = last_g(&[90.0, 91.0]).map_or(self.steps, |distance| distance == 91.0);
        let in_force = &mut self.in_force;
        in_force.motion = last_g(&[0.0, 1.0, 2.0, 3.0]).or(in_force.motion);
        in_force.is_in_inches =
            last_g(&[70.0, 71.0, 700.0, 710.0]).map_or(in_force.is_in_inches, |unit| matches!(unit, 70.0 | 700.0));
        if last_g(&[4.0]).is_none() {
            let feed = words.iter().find(|word| word.letter == 'F').map(|word| word.value);
            in_force.feed = feed.or(in_force.feed);
        }
        let moves = words.iter().any(|word| matches!(word.letter, 'X' | 'Y' | 'Z' | 'A' | 'B' | 'C' | 'a' | 'p'));
        let leaves = words.iter().any(|word| is_g(word, &[74.0, 75.0]));
        // Coordinates that may be no motion of the tool to where it drills.
        let is_other = |word: &Word| {
            (word.meaning.is_some() && word.letter == 'G')
                || is_g(word, &[4.0, 53.0, 110.0, 111.0, 112.0, 153.0])
                || matches!(word.letter, 'A' | 'B' | 'C' | 'w')
        };
        if self.modal.is_some() && (leaves || (moves && words.iter().any(is_other))) {
            return Err("MCALL alone before it, as it may be no motion to a hole");
        }
        self.place(words);
        Ok(moves)
    }

    /// Follows where the tool is in the plane.
    fn place(&mut self, words: &[Word]) {
        let is_elsewhere = |word: &Word| {
            (word.letter == 'G' && word.meaning.is_some())
                || word.letter == 'w'
                || is_g(word, &[53.0, 74.0, 75.0, 110.0, 111.0, 112.0, 153.0])
        };
        let is_zero = |value: f64| (54.0..=59.0).contains(&value) || (500.0..=599.0).contains(&value);
        let is_unknown = |word: &Word| {
            matches!(word.letter, 'a' | 'p')
                || is_g(word, &[70.0, 71.0, 700.0, 710.0])
                || (word.letter == 'G' && is_zero(word.value))
        };
        let leads_elsewhere = words.iter().any(is_elsewhere);
        if leads_elsewhere || words.iter().any(is_unknown) {
            self.at = [None; 2];
        }
        for word in words.iter().filter(|_| !leads_elsewhere) {
            let Some(axis) = ['X', 'Y'].iter().position(|letter| *letter == word.letter) else { continue };
            let is_step = word.distance.map_or(self.steps, |distance| distance == Distance::Incremental);
            self.at[axis] = if is_step { self.at[axis].map(|at| at + word.value) } else { Some(word.value) };
        }
    }
}

/// Returns the words of a line; none if it cannot be read, which is reported when the expanded program is read.
fn line_words(content: &[u8]) -> Vec<Word> {
    match sinumerik::parse_line(content, true) {
        Ok(Statement::Words { words, .. }) => words,
        _ => Vec::new(),
    }
}

/// Whether `word` is a G word with one of the numbers `values`.
fn is_g(word: &Word, values: &[f64]) -> bool {
    word.letter == 'G' && word.meaning.is_none() && values.contains(&word.value)
}

/// Returns what a line means for cycles; `at`: where the tool is in the plane. `Err` for a cycle that cannot be expanded.
fn parse_line(content: &[u8], at: [Option<f64>; 2]) -> Result<Line, Refusal> {
    let begin = statement(content);
    let mut scan = begin;
    let name = |scan: &mut Scan| {
        let range = scan.take_while(|byte| byte.is_ascii_alphanumeric() || byte == b'_');
        scan.upper_text(range)
    };
    let mut first = name(&mut scan);
    let is_modal = first == "MCALL";
    if is_modal {
        scan.next();
        first = name(&mut scan);
    }
    let arguments = scan.upper_text(scan.at..scan.line.len());
    let refuse = |expected| refuse(content, expected);
    match first.as_str() {
        "" if is_modal && scan.peek().is_none() => Ok(Line::ModalState(None)),
        "CYCLE81" | "CYCLE82" | "CYCLE83" | "CYCLE84" | "CYCLE840" | "CYCLE85" | "CYCLE89" => {
            let hole = Hole::parse(&first, &arguments).map_err(refuse)?;
            Ok(if is_modal { Line::ModalState(Some(hole)) } else { Line::Hole(hole) })
        }
        _ if is_modal => Err(begin.refuse_all(begin.at, Foreign::Cycle)),
        "HOLES1" | "HOLES2" => Ok(Line::Pattern(pattern(&first, &arguments, at).map_err(refuse)?)),
        _ => Ok(Line::Other),
    }
}
