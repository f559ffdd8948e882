//! Random programs of Sinumerik and Heidenhain: read as a second interpreter reads them, which knows nothing of the first, and
//! written back.

use std::{f64::consts::TAU, fmt::Write};

use kinetostat_programs::{
    NumberFormat, Sampling, WriteOptions,
    gcode::{Dialect, GcodeOptions, GcodeProgram},
};
use nalgebra::Vector3;
use proptest::prelude::*;

use crate::support::cases::cases;

type P = [f64; 3];

/// A move: straight, or round a centre from an angle by another.
#[derive(Clone, Debug)]
struct Move {
    start: P,
    end: P,
    round: Option<Round>,
}

#[derive(Clone, Debug)]
struct Round {
    centre: [f64; 2],
    from: f64,
    by: f64,
}

impl Move {
    fn at(&self, t: f64) -> P {
        let mut p = [0, 1, 2].map(|k| self.start[k] + t * (self.end[k] - self.start[k]));
        if let Some(Round { centre, from, by }) = &self.round {
            let radii = [self.start, self.end].map(|p| (p[0] - centre[0]).hypot(p[1] - centre[1]));
            let (radius, angle) = (radii[0] + t * (radii[1] - radii[0]), from + t * by);
            p[0] = centre[0] + radius * angle.cos();
            p[1] = centre[1] + radius * angle.sin();
        }
        p
    }
}

fn round(start: P, end: P, centre: [f64; 2], counter_clockwise: bool) -> Round {
    let angle = |p: P| (p[1] - centre[1]).atan2(p[0] - centre[0]);
    let same = (start[0] - end[0]).hypot(start[1] - end[1]) < 1e-9;
    let mut by = if same { 0.0 } else { angle(end) - angle(start) };
    while counter_clockwise && by <= 0.0 {
        by += TAU;
    }
    while !counter_clockwise && by >= 0.0 {
        by -= TAU;
    }
    Round { centre, from: angle(start), by }
}

/// The centre of the arc of the radius, the shorter arc if it is positive.
fn centre(start: P, end: P, radius: f64, counter_clockwise: bool) -> [f64; 2] {
    let (dx, dy) = (end[0] - start[0], end[1] - start[1]);
    let chord = dx.hypot(dy);
    let height = (radius * radius - chord * chord / 4.0).max(0.0).sqrt();
    let side = if counter_clockwise == (radius > 0.0) { height } else { -height };
    [(start[0] + end[0]) / 2.0 - side * dy / chord, (start[1] + end[1]) / 2.0 + side * dx / chord]
}

/// The moves of a program of either dialect as `statement` below writes it: words parted by blanks.
fn moves(text: &str) -> Vec<Move> {
    let (mut at, mut zero, mut pole) = ([0.0; 3], [0.0; 3], [0.0; 2]);
    let (mut inch, mut steps, mut code) = (1.0, false, 0);
    let mut moves = Vec::new();
    for line in text.lines() {
        let mut words: Vec<&str> = line.split(';').next().unwrap().split_whitespace().collect();
        if words.first().is_some_and(|word| word.trim_start_matches('N').parse::<u32>().is_ok()) {
            words.remove(0);
        }
        let Some(verb) = words.first().copied() else { continue };
        let is_own_line = ["TRANS", "ATRANS"].contains(&verb) || line.contains("CYCL DEF 7.");
        match verb {
            "BEGIN" => inch = if line.ends_with("INCH") { 25.4 } else { 1.0 },
            "TRANS" => zero = [0.0; 3],
            "L" => code = 1,
            "C" | "CR" => code = if line.contains("DR+") { 3 } else { 2 },
            _ => {}
        }
        let (mut end, mut middle, mut radius, mut moving) = (at, [None; 2], None, false);
        for word in &words {
            let plain = word.replace("=", "").replace("(", "").replace(")", "").replace(",", ".");
            let letters: String = plain.chars().take_while(char::is_ascii_alphabetic).collect();
            let (Ok(value), false) = (plain[letters.len()..].parse::<f64>(), letters.is_empty()) else { continue };
            let (axis, mark) = match letters.as_str() {
                "G" => {
                    match value as u32 {
                        90 => steps = false,
                        91 => steps = true,
                        70 | 700 => inch = 25.4,
                        71 | 710 => inch = 1.0,
                        number @ 0..=3 => code = number,
                        _ => {}
                    }
                    continue;
                }
                "CR" | "R" if value != 0.0 => {
                    radius = Some(value * inch);
                    continue;
                }
                _ => match letters.strip_prefix('I').filter(|rest| "XYZ".contains(*rest) && !rest.is_empty()) {
                    Some(rest) => (rest.to_owned(), "IC"),
                    None => (letters[..1].to_owned(), &letters[1..]),
                },
            };
            let value = value * inch;
            match "XYZ".find(&axis) {
                Some(k) if is_own_line => {
                    zero[k] = value + if verb == "ATRANS" || mark == "IC" { zero[k] } else { 0.0 }
                }
                Some(k) => {
                    let is_step = mark == "IC" || (steps && mark != "AC");
                    end[k] = if is_step { at[k] + value } else { value + zero[k] };
                    moving = true;
                }
                None if axis == "I" || axis == "J" => {
                    let k = usize::from(axis == "J");
                    middle[k] = Some(if mark == "AC" { value + zero[k] } else { at[k] + value });
                    moving = true;
                }
                None => {}
            }
        }
        if verb == "CC" {
            pole = [end[0], end[1]];
            continue;
        }
        if is_own_line || !moving || ["BLK", "TOOL", "CYCL"].contains(&verb) {
            continue;
        }
        let is_rapid = line.contains("FMAX");
        let is_round = code >= 2 && !is_rapid;
        let middle = match radius {
            Some(radius) if is_round => centre(at, end, radius, code == 3),
            _ if verb == "C" => pole,
            _ => [middle[0].unwrap_or(at[0]), middle[1].unwrap_or(at[1])],
        };
        let round = is_round.then(|| round(at, end, middle, code == 3));
        moves.push(Move { start: at, end, round });
        at = end;
    }
    moves
}

/// About a centre, from an angle at which the tool already is.
#[derive(Clone, Debug)]
struct Arc {
    radius: f64,
    from: f64,
    by: f64,
    rise: f64,
    counter_clockwise: bool,
    how: u8,
}

/// A line of a random program, before it is written in a dialect.
#[derive(Clone, Debug)]
enum Step {
    Line { to: [Option<f64>; 3], steps: [bool; 3], rapid: bool, feed: Option<u32> },
    Arc(Arc),
    Shift { by: [Option<f64>; 3], adds: bool },
    Other(u8),
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![(-50i32..50).prop_map(f64::from), (-500_000i32..500_000).prop_map(|n| f64::from(n) / 1e4)]
}

fn step() -> impl Strategy<Value = Step> {
    let option = || prop::option::of(number());
    let line = ([option(), option(), option()], any::<[bool; 3]>(), any::<bool>(), prop::option::of(1u32..2000))
        .prop_map(|(to, steps, rapid, feed)| Step::Line { to, steps, rapid, feed });
    let arc = (0.5..40.0f64, 0.0..TAU, 0.05..6.0f64, -3i32..4, any::<bool>(), 0u8..6).prop_map(
        |(radius, from, by, rise, counter_clockwise, how)| {
            Step::Arc(Arc { radius, from, by, rise: f64::from(rise.max(0)), counter_clockwise, how })
        },
    );
    let shift = ([option(), option(), option()], any::<bool>()).prop_map(|(by, adds)| Step::Shift { by, adds });
    prop_oneof![5 => line, 4 => arc, 1 => shift, 2 => (0u8..5).prop_map(Step::Other)]
}

/// A random program; places are those that the words written so far lead to.
struct Text {
    dialect: Dialect,
    text: String,
    at: P,
    zero: P,
    /// Axes that were not named since TRANS, along which Sinumerik's steps are refused.
    has_new_zero: [bool; 3],
    numbered: Option<u32>,
    comma: bool,
}

impl Text {
    fn block(&mut self, words: &[String]) {
        if let Some(number) = &mut self.numbered {
            let mark = if self.dialect == Dialect::Sinumerik { "N" } else { "" };
            write!(self.text, "{mark}{number} ").unwrap();
            *number += 1;
        }
        self.text += &words.join(" ");
        self.text += "\n";
    }

    fn number(&self, value: f64) -> (String, f64) {
        let text = format!("{value:.4}");
        let value = text.parse().unwrap();
        let plus = if self.dialect == Dialect::Heidenhain && !text.starts_with('-') { "+" } else { "" };
        (format!("{plus}{}", if self.comma { text.replace('.', ",") } else { text }), value)
    }

    /// A coordinate that leads to `goal`, as a step or not; where the tool is then is kept.
    fn coordinate(&mut self, axis: usize, goal: f64, as_step: bool) -> String {
        let letter = ["X", "Y", "Z"][axis];
        let is_new = std::mem::take(&mut self.has_new_zero[axis]) && self.dialect == Dialect::Sinumerik;
        let as_step = as_step && !is_new;
        let base = if as_step { self.at[axis] } else { self.zero[axis] };
        let (text, value) = self.number(goal - base);
        self.at[axis] = base + value;
        match (self.dialect, as_step) {
            (Dialect::Heidenhain, true) => format!("I{letter}{text}"),
            (Dialect::Heidenhain, false) => format!("{letter}{text}"),
            (_, true) => format!("{letter}=IC({text})"),
            (_, false) if axis == 1 => format!("{letter}={text}"),
            (_, false) => format!("{letter}{text}"),
        }
    }

    fn arc(&mut self, arc: &Arc) {
        let heidenhain = self.dialect == Dialect::Heidenhain;
        let Arc { radius, from, by, rise, counter_clockwise, how } = *arc;
        let start = self.at;
        let sign = if counter_clockwise { 1.0 } else { -1.0 };
        let middle = [start[0] - radius * from.cos(), start[1] - radius * from.sin()];
        let to = from + sign * by;
        let goal = [middle[0] + radius * to.cos(), middle[1] + radius * to.sin(), start[2] + rise];
        // Near half a turn and a whole one, the centre by radius is not well defined.
        let by_radius = how < 2 && (by - TAU / 2.0).abs() > 0.3 && by < 5.5 && by > 0.3;
        let as_steps = how % 2 == 1;
        let mut words = vec![match (heidenhain, by_radius) {
            (true, true) => "CR".to_owned(),
            (true, false) => "C".to_owned(),
            (false, _) => format!("G{}", if counter_clockwise { 3 } else { 2 }),
        }];
        if heidenhain && !by_radius {
            let centre = [self.coordinate(0, middle[0], as_steps), self.coordinate(1, middle[1], as_steps)];
            self.at = start;
            self.block(&["CC".to_owned(), centre[0].clone(), centre[1].clone()]);
        }
        let mut centres = Vec::new();
        if !heidenhain && !by_radius {
            for (k, letter) in ["I", "J"].into_iter().enumerate() {
                let from = if how < 4 { start[k] } else { self.zero[k] };
                let (text, _) = self.number(middle[k] - from);
                centres.push(if how < 4 { format!("{letter}{text}") } else { format!("{letter}=AC({text})") });
            }
        }
        words.push(self.coordinate(0, goal[0], as_steps));
        words.push(self.coordinate(1, goal[1], how == 3));
        if rise > 0.0 {
            words.push(self.coordinate(2, goal[2], false));
        }
        words.append(&mut centres);
        if by_radius {
            let (text, _) = self.number(if by > TAU / 2.0 { -radius } else { radius });
            words.push(if heidenhain { format!("R{text}") } else { format!("CR={text}") });
        }
        words.extend(heidenhain.then(|| format!("DR{}", if counter_clockwise { "+" } else { "-" })));
        words.push("F300".into());
        self.block(&words);
    }

    fn step(&mut self, step: &Step) {
        let heidenhain = self.dialect == Dialect::Heidenhain;
        match step {
            Step::Line { to, steps, rapid, feed } => {
                let mut words = vec![if heidenhain { "L".into() } else { format!("G{}", u8::from(!rapid)) }];
                for axis in 0..3 {
                    if let Some(to) = to[axis] {
                        words.push(self.coordinate(axis, to, steps[axis]));
                    }
                }
                words.extend(feed.map(|feed| format!("F{feed}")));
                words.extend((heidenhain && *rapid).then(|| "FMAX".to_owned()));
                self.block(&words);
            }
            Step::Arc(arc) => self.arc(arc),
            Step::Shift { by, adds } if heidenhain => {
                for axis in 0..3 {
                    let Some(by) = by[axis] else { continue };
                    let (text, value) = self.number(by);
                    let (mark, before) = if *adds { ("I", self.zero[axis]) } else { ("", 0.0) };
                    self.zero[axis] = before + value;
                    self.block(&[format!("CYCL DEF 7.{} {mark}{}{text}", axis + 1, ["X", "Y", "Z"][axis])]);
                }
            }
            Step::Shift { by, adds } => {
                let mut words = vec![if *adds { "ATRANS".to_owned() } else { "TRANS".to_owned() }];
                self.zero = if *adds { self.zero } else { [0.0; 3] };
                self.has_new_zero = [true; 3];
                for axis in 0..3 {
                    let Some(by) = by[axis] else { continue };
                    let (text, value) = self.number(by);
                    self.zero[axis] += value;
                    words.push(format!("{}={text}", ["X", "Y", "Z"][axis]));
                }
                self.block(&words);
            }
            Step::Other(which) => {
                let texts = match heidenhain {
                    true => ["M8", "; X+5", "LBL 7", "L R0 FMAX M9", "TOOL CALL 3 Z S900 F50"],
                    false => ["M8", "; X=5", "MSG(\"X=5\")", "S1=900 M1=3 ADIS=0.1", "T=\"X5\" D1"],
                };
                self.block(&[texts[usize::from(*which)].to_owned()]);
            }
        }
    }
}

fn program(dialect: Dialect) -> impl Strategy<Value = String> {
    let kind = (any::<bool>(), any::<bool>(), any::<bool>());
    (kind, prop::collection::vec(step(), 1..14)).prop_map(move |((inch, numbered, comma), steps)| {
        let heidenhain = dialect == Dialect::Heidenhain;
        let (numbered, comma) = (numbered.then_some(0), comma && heidenhain);
        let has_new_zero = [false; 3];
        let mut text =
            Text { dialect, text: String::new(), at: [0.0; 3], zero: [0.0; 3], has_new_zero, numbered, comma };
        text.block(&[match heidenhain {
            true => format!("BEGIN PGM A {}", if inch { "INCH" } else { "MM" }),
            false => format!("{} G90 G17 G40 G54 G601 CFTCP", if inch { "G700" } else { "G710" }),
        }]);
        let start = Step::Line { to: [Some(1.0), Some(2.0), Some(3.0)], steps: [false; 3], rapid: true, feed: None };
        text.step(&start);
        steps.iter().for_each(|step| text.step(step));
        text.text
    })
}

fn bent(p: &Vector3<f64>) -> Vector3<f64> {
    p + Vector3::new((0.3 * p.y).sin(), (0.2 * p.x).cos(), (p.x + p.z).sin()) * 0.2
}

fn shifted(p: &Vector3<f64>) -> Vector3<f64> {
    p + Vector3::new(0.012_345, -0.31, 0.2)
}

fn near(a: &Vector3<f64>, b: P, tolerance: f64) -> bool {
    (a - Vector3::from(b)).amax() <= tolerance
}

/// One unit of the last of four decimals of an inch, and what sums of them lose.
const LAST_PLACE_MM: f64 = 2.55e-3;

fn agrees(source: &str, dialect: Dialect) -> Result<(), TestCaseError> {
    let options = GcodeOptions { dialect: Some(dialect), ..GcodeOptions::default() };
    let program =
        GcodeProgram::parse(source, "any", &options).map_err(|e| TestCaseError::fail(format!("{e}\n{source}")))?;
    let path = program.toolpath(Sampling::new(0.05, 10.0).unwrap()).unwrap();
    let own = moves(source);
    prop_assert_eq!(program.motion_count(), own.len(), "{}", source);
    for point in path.points() {
        // From nowhere known, the way is not known either.
        let here = own[point.source.segment].at(point.source.parameter);
        let tolerance = if own[point.source.segment].round.is_some() { 1e-6 } else { 1e-9 };
        prop_assert!(near(&point.position_mm, here, tolerance), "{:?} {:?}\n{}", point, here, source);
    }
    let nominal = path.positions_mm();
    let format = NumberFormat::new(4, 4).unwrap();
    let same = program.rewrite(&path, &nominal, WriteOptions::with_decimals(format)).unwrap();
    prop_assert_eq!(same.bytes(), source.as_bytes());
    for correct in [bent, shifted] {
        let goals: Vec<_> = nominal.iter().map(correct).collect();
        let written = program.rewrite(&path, &goals, WriteOptions::with_decimals(format)).unwrap();
        let text = String::from_utf8_lossy(written.bytes()).into_owned();
        let back = written.read_back().map_err(|e| TestCaseError::fail(format!("{e}\n{source}\n{text}")))?;
        for (here, goal) in back.positions_mm().iter().zip(&goals) {
            prop_assert!((here - goal).amax() <= LAST_PLACE_MM, "{:?} {:?}\n{}\n{}", here, goal, source, text);
        }
        // The other interpreter comes through the goals as well, in their order, with the end of each of its moves.
        let mut rest = goals.iter();
        for own in moves(&text) {
            prop_assert!(rest.any(|goal| near(goal, own.end, LAST_PLACE_MM)), "{:?}\n{}\n{}", own, source, text);
        }
        let last = moves(&text).last().map(|own| own.end);
        prop_assert!(goals.last().zip(last).is_some_and(|(goal, end)| near(goal, end, LAST_PLACE_MM)));
        if dialect == Dialect::Heidenhain {
            let number = |line: &str| line.split(' ').next().and_then(|word| word.parse::<u32>().ok());
            let numbers: Vec<u32> = text.lines().filter_map(number).collect();
            prop_assert!(numbers.windows(2).all(|pair| pair[0] < pair[1]), "{}", text);
        }
    }
    Ok(())
}

/// Bytes that are read or refused; what is read is written back as it is.
fn is_read_or_refused(source: &[u8], dialect: Dialect) -> Result<(), TestCaseError> {
    let options = GcodeOptions { dialect: Some(dialect), ..GcodeOptions::default() };
    let Ok(program) = GcodeProgram::parse(source, "any", &options) else { return Ok(()) };
    let Ok(path) = program.toolpath(Sampling::new(0.5, 1e6).unwrap()) else { return Ok(()) };
    let same = program.rewrite(&path, &path.positions_mm(), WriteOptions::default()).unwrap();
    prop_assert_eq!(same.bytes(), source);
    let goals: Vec<_> = path.positions_mm().iter().map(bent).collect();
    if goals.iter().all(|p| p.amax() < 999_999.0) {
        let written = program.rewrite(&path, &goals, WriteOptions::default()).unwrap();
        let text = String::from_utf8_lossy(written.bytes()).into_owned();
        let back = written.read_back().map_err(|e| TestCaseError::fail(format!("{e}\n{text}")))?;
        for (here, goal) in back.positions_mm().iter().zip(&goals) {
            prop_assert!((here - goal).amax() <= 2.6e-4, "{:?} {:?}\n{}", here, goal, text);
        }
    }
    Ok(())
}

fn any_block(words: &'static [&'static str]) -> impl Strategy<Value = String> {
    let number = prop_oneof![
        (-30i32..30).prop_map(|n| n.to_string()),
        (-3000i32..3000).prop_map(|n| format!("{:+.3}", f64::from(n) / 77.0)),
        Just(String::new()),
    ];
    let word = (prop::sample::select(words), number).prop_map(|(word, number)| format!("{word}{number}"));
    let ending = prop::sample::select(vec!["\n", "\r\n", "\n", ""]);
    (prop::collection::vec(word, 0..6), prop::sample::select(vec!["", " ", " "]), ending)
        .prop_map(|(words, separator, ending)| words.join(separator) + ending)
}

const SINUMERIK: &[&str] = &[
    "X", "Y=", "Z", "X=IC(", "Y=AC(", ")", "I", "J=", "K", "I=AC(", "CR=", "G", "G0", "G1", "G2", "G3", "G91", "G90",
    "G18", "G17", "G70", "G710", "F", "F=", "S1=", "M", "M9", "N", "TRANS", "ATRANS", "SUPA", "G54", "G505", "T=\"A\"",
    "MSG(\"", "\")", "(", ";", "/", "%", "ADIS=", "A", "R1=", "L", "G4", "LBL:", "EX",
];

const HEIDENHAIN: &[&str] = &[
    "L ",
    "L ",
    "C ",
    "CR ",
    "CC ",
    "CC",
    "X",
    "Y",
    "Z",
    "IX",
    "IY+",
    "IZ",
    "DR+",
    "DR-",
    "R",
    "R0",
    "F",
    "FMAX",
    "F AUTO",
    "M",
    "M91",
    "M140 MB MAX",
    "M136",
    "M30",
    "CYCL DEF 7.1 X",
    "CYCL DEF 7.2 IY",
    "CYCL DEF 247 ~",
    "Q339=",
    "TOOL CALL",
    "TOOL CALL 1 Y S",
    "BEGIN PGM A INCH",
    "END PGM A MM",
    "LBL ",
    "; ",
    "* -",
    "~",
    "/",
    "A",
    ",5",
    "12 ",
    "BLK FORM",
];

proptest! {
    #![proptest_config(cases(192))]

    #[test]
    fn sinumerik_leads_where_a_second_interpreter_says(source in program(Dialect::Sinumerik)) {
        agrees(&source, Dialect::Sinumerik)?;
    }

    #[test]
    fn heidenhain_leads_where_a_second_interpreter_says(source in program(Dialect::Heidenhain)) {
        agrees(&source, Dialect::Heidenhain)?;
    }

    #[test]
    fn any_bytes_are_read_or_refused(source in prop::collection::vec(any::<u8>(), 0..300), heidenhain in any::<bool>()) {
        is_read_or_refused(&source, if heidenhain { Dialect::Heidenhain } else { Dialect::Sinumerik })?;
    }

    #[test]
    fn random_lines_of_sinumerik_are_read_or_refused(lines in prop::collection::vec(any_block(SINUMERIK), 1..8)) {
        is_read_or_refused(("G0 X0 Y0 Z0 F100\n".to_owned() + &lines.concat()).as_bytes(), Dialect::Sinumerik)?;
    }

    #[test]
    fn random_blocks_of_heidenhain_are_read_or_refused(blocks in prop::collection::vec(any_block(HEIDENHAIN), 1..8)) {
        let begin = "BEGIN PGM A MM\nL X+0 Y+0 Z+0 FMAX\nCC X+5 Y+0\n";
        is_read_or_refused((begin.to_owned() + &blocks.concat()).as_bytes(), Dialect::Heidenhain)?;
    }

    #[test]
    fn mutated_programs_are_read_or_refused(
        which in any::<prop::sample::Index>(),
        heidenhain in any::<bool>(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0..3u8), 1..6),
    ) {
        let (folder, dialect) = match heidenhain {
            true => ("tests/dialects/heidenhain", Dialect::Heidenhain),
            false => ("tests/dialects/sinumerik", Dialect::Sinumerik),
        };
        let files = crate::support::programs::programs_in(folder);
        let mut source = files[which.index(files.len())].1.clone();
        for (at, byte, kind) in changes {
            let at = at.index(source.len());
            match kind {
                0 => source[at] = byte,
                1 => source.insert(at, b"0123456789.-+=XYIJCLF \n~;("[usize::from(byte) % 26]),
                _ => drop(source.remove(at)),
            }
        }
        is_read_or_refused(&source, dialect)?;
    }
}
