//! Sinumerik's drilling cycles CYCLE81 and CYCLE82 as moves, once, after each block (MCALL) or on a circle (HOLES2).

use crate::toolpath::{
    expand::line::long_number,
    model::{format_plain, gcode::Word},
    read::{
        gcode::{
            Statement,
            dialect::sinumerik,
            lines::{self, Lines},
        },
        scan::Scan,
    },
};

/// A hole at the tool position; heights are absolute coordinates in the unit of the program.
#[derive(Clone)]
struct Hole {
    retract: f64,
    clear: f64,
    bottom: f64,
    dwell_s: f64,
}

/// Most holes of a pattern.
const MOST_HOLES: f64 = 10_000.0;

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

/// Returns `source` with its cycles as moves, and the index of the line each line comes from; `None` without cycles or if one cannot be.
pub(crate) fn expand_cycles(source: &[u8]) -> Option<(Vec<u8>, Vec<usize>)> {
    let lines = Lines::split(source);
    let (mut out, mut origins) = (Vec::with_capacity(source.len()), Vec::new());
    let (mut modal, mut motion, mut is_changed, mut is_across) = (None, None, false, false);
    for line in 0..lines.len() {
        let content = &source[lines.content(line)];
        let ending = lines.ending_or_newline(source, line);
        let mut write_line = |text: &[u8]| {
            out.extend_from_slice(text);
            out.extend_from_slice(ending);
            origins.push(line);
        };
        let meaning = parse_line(content)?;
        let (mut hole, mut places) = (None, vec![None]);
        match &meaning {
            Line::Other => {
                write_line(content);
                let words = line_words(content);
                is_across |= words.iter().any(|word| is_g(word, &[18.0, 19.0]));
                motion =
                    words.iter().rev().find(|word| is_g(word, &[0.0, 1.0, 2.0, 3.0])).map(|word| word.value).or(motion);
                let moves =
                    words.iter().any(|word| matches!(word.letter, 'X' | 'Y' | 'Z' | 'A' | 'B' | 'C' | 'a' | 'p'));
                let leaves = words.iter().any(|word| is_g(word, &[74.0, 75.0]));
                // Coordinates that may be no motion of the tool to where it drills.
                let is_other = |word: &Word| {
                    (word.meaning.is_some() && word.letter == 'G')
                        || is_g(word, &[4.0, 53.0, 110.0, 111.0, 112.0, 153.0])
                        || matches!(word.letter, 'A' | 'B' | 'C' | 'w')
                };
                if modal.is_some() && (leaves || (moves && words.iter().any(is_other))) {
                    return None;
                }
                if moves {
                    hole.clone_from(&modal);
                }
            }
            Line::Hole(called) => hole = Some(called.clone()),
            Line::Pattern(points) => {
                hole = Some(modal.clone()?);
                places = points.iter().copied().map(Some).collect();
            }
            Line::ModalState(state) => {
                modal.clone_from(state);
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
        if is_across {
            return None;
        }
        is_changed = true;
        let prefix = &content[..lines::prefix_len(content)];
        for place in places {
            let over = place.map(|[x, y]| format!("G0 X=AC({}) Y=AC({})", long_number(b'X', x), long_number(b'X', y)));
            let moves = over.into_iter().chain(hole.moves(motion));
            moves.for_each(|text| write_line(&[prefix, text.as_bytes()].concat()));
        }
    }
    is_changed.then_some((out, origins))
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

/// Returns what a line means for cycles; `None` for a cycle that cannot be expanded.
fn parse_line(content: &[u8]) -> Option<Line> {
    let mut scan = Scan::of_line(content, lines::prefix_len(content));
    if matches!(scan.next(), Some(b'N' | b'n')) {
        let mut number = scan;
        number.at += 1;
        if !number.take_while(|byte| byte.is_ascii_digit()).is_empty() {
            scan = number;
        }
    }
    scan.next();
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
    match first.as_str() {
        "" if is_modal && scan.peek().is_none() => Some(Line::ModalState(None)),
        "CYCLE81" | "CYCLE82" => {
            let hole = Hole::parse(&first, &scan.upper_text(scan.at..scan.line.len()))?;
            Some(if is_modal { Line::ModalState(Some(hole)) } else { Line::Hole(hole) })
        }
        _ if is_modal => None,
        "HOLES2" => Some(Line::Pattern(circle(&scan.upper_text(scan.at..scan.line.len()))?)),
        _ => Some(Line::Other),
    }
}

/// Parses numbers in brackets; `None` for those that are left out, or if there is anything else.
fn numbers(arguments: &str) -> Option<Vec<Option<f64>>> {
    let inner = arguments.trim().strip_prefix('(')?.strip_suffix(')')?;
    let value = |text: &str| match text.trim() {
        "" => Some(None),
        text => text.parse::<f64>().ok().filter(|value| value.is_finite()).map(Some),
    };
    inner.split(',').map(value).collect()
}

/// Returns the points of HOLES2 by its arguments `(CPA, CPO, RAD, STA1, INDA, NUM)`: centre, radius, angle of the first, angle from one to the
/// next (0: evenly all around), and their number.
fn circle(arguments: &str) -> Option<Vec<[f64; 2]>> {
    let values: Option<Vec<f64>> = numbers(arguments)?.into_iter().collect();
    let [x, y, radius, first, step, count] = values?[..] else { return None };
    let is_count = count.fract() == 0.0 && (1.0..=MOST_HOLES).contains(&count) && radius > 0.0;
    let step = if step == 0.0 { 360.0 / count } else { step };
    let point = |number: u32| {
        let (sin, cos) = libm::sincos((first + f64::from(number) * step).to_radians());
        [x + radius * cos, y + radius * sin]
    };
    is_count.then(|| (0..count as u32).map(point).collect())
}

impl Hole {
    /// Parses the arguments `(RTP, RFP, SDIS, DP, DPR)` of cycle `name`, for CYCLE82 with DTB behind them; `None` if they are no hole.
    fn parse(name: &str, arguments: &str) -> Option<Hole> {
        let values = numbers(arguments)?;
        let most = if name == "CYCLE82" { 6 } else { 5 };
        if values.iter().skip(most).any(Option::is_some) {
            return None;
        }
        let value = |at: usize| values.get(at).copied().flatten();
        let (retract, reference, distance) = (value(0)?, value(1)?, value(2).unwrap_or(0.0).abs());
        let clear = reference + distance;
        // With both, the one from the reference plane counts.
        let bottom = value(4).map(|depth| reference - depth.abs()).or(value(3))?;
        let dwell_s = value(5).unwrap_or(0.0);
        (retract >= clear && bottom < reference && dwell_s >= 0.0).then_some(Hole { retract, clear, bottom, dwell_s })
    }

    /// Returns the lines that drill the hole, and put `motion`, the number of the G word in force, back in force.
    fn moves(&self, motion: Option<f64>) -> Vec<String> {
        let goes = |g: u32, z: f64| format!("G{g} Z=AC({})", format_plain(z));
        let mut moves = vec![goes(0, self.clear), goes(1, self.bottom)];
        moves.extend((self.dwell_s > 0.0).then(|| format!("G4 F{}", format_plain(self.dwell_s))));
        moves.push(goes(0, self.retract));
        moves.extend(motion.filter(|motion| *motion != 0.0).map(|motion| format!("G{motion}")));
        moves
    }
}
