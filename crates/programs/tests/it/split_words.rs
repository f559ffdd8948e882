//! What becomes of each word of a line that becomes several: all letters of all dialects.

use kinetostat_programs::{
    NumberFormat, Sampling, WriteOptions,
    gcode::{Dialect, GcodeOptions, GcodeProgram, Rotary, RotaryAxis, RotarySide},
};
use nalgebra::Vector3;

/// Where a word of the line belongs.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    /// By the length of the lines: its number grows along them.
    Grows,
    First,
    Last,
    /// Nowhere: refused, with its letter.
    Refused,
}

use Place::{First, Grows, Last, Refused};

/// The place of each letter, with the reason. A letter that a dialect refuses where it reads it is refused, too.
fn place(letter: char) -> (Place, &'static str) {
    match letter {
        'A' | 'B' | 'C' => (Grows, "rotary axes move with the tool (ISO 6983-1, table 2)"),
        'D' | 'H' => (First, "offsets of the tool hold from the beginning of the block"),
        'E' | 'U' | 'V' | 'W' => (Refused, "second feed, extruder or secondary axis: it would move on one line alone"),
        'F' | 'S' => (First, "feed and speed are modal"),
        'G' => (Last, "G9: exact stop at the end of the block, not modal"),
        'I' | 'J' | 'K' | 'R' => (Refused, "words of arcs, and of none of a line"),
        'L' | 'P' | 'Q' => (Refused, "parameters of a word that the line has not"),
        'M' => (Last, "M5: the spindle stops behind the motion"),
        'N' | 'O' => (First, "numbers of blocks and programs name the first line"),
        'T' => (First, "the tool is made ready before the motion"),
        _ => unreachable!(),
    }
}

/// The lines that the motion to X10 has become, with `words` on it, or why it is refused.
fn written(dialect: Dialect, words: &str) -> Result<Vec<String>, String> {
    let source = match dialect {
        Dialect::Heidenhain => format!(
            "BEGIN PGM P MM\nTOOL CALL 1 Z S9000\nL X+0 Y+0 Z+0 A+0 B+0 C+0 R0 FMAX\nL X+1 F100\nL X+11 {words}\nL X+12\nEND PGM P MM\n"
        ),
        _ => format!("G90 G21\nG0 X0 Y0 Z0 A0 B0 C0\nG1 X1 F100\nG1 X11 {words}\nG1 X12\nM30\n")
            .replace("G21", if dialect == Dialect::Sinumerik { "G71" } else { "G21" }),
    };
    // X, Y and Z are those of the tip, so that all is shared out evenly.
    let axis =
        |letter, about| RotaryAxis { letter, about, turns: RotarySide::Tool, through_mm: None, travel_deg: None };
    let axes = vec![axis('C', Vector3::z()), axis('B', Vector3::y()), axis('A', Vector3::x())];
    let rotary = Rotary { axes, always_of_tip: true };
    let options = GcodeOptions { dialect: Some(dialect), rotary, ..GcodeOptions::default() };
    let program = GcodeProgram::parse(source, "p.nc", &options).map_err(|refused| refused.to_string())?;
    let path = program.toolpath(Sampling::new(0.01, 2.5).unwrap()).unwrap();
    let goals: Vec<_> = path.positions_mm().iter().map(|p| p + Vector3::y() * (p.x * 0.7).sin()).collect();
    let rewritten = program
        .rewrite(&path, &goals, WriteOptions::with_decimals(NumberFormat::new(3, 4).unwrap()))
        .map_err(|refused| refused.to_string())?;
    let text = String::from_utf8(rewritten.bytes().to_vec()).unwrap();
    let lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let is_at = |line: &String, x: &str| {
        line.split(['X', 'Y', ' ']).any(|number| number.trim_start_matches('+').starts_with(x))
    };
    let first = lines.iter().position(|line| is_at(line, "3.5")).unwrap_or_else(|| panic!("{text}"));
    let last = lines.iter().position(|line| is_at(line, "11")).unwrap_or_else(|| panic!("{text}"));
    assert!(last > first, "{text}");
    Ok(lines[first..=last].to_vec())
}

/// Numbers of the words `letter` by line.
fn numbers(lines: &[String], letter: char) -> Vec<Option<f64>> {
    let number = |line: &String| {
        let behind = line.split(' ').filter_map(|word| word.strip_prefix(letter));
        let number = |text: &str| text.trim_start_matches(['+', '=']).parse::<f64>().ok();
        // G1 is on each line.
        behind.filter_map(number).find(|number| letter != 'G' || *number == 9.0)
    };
    lines.iter().map(number).collect()
}

const DIALECTS: [Dialect; 6] =
    [Dialect::Iso, Dialect::Fanuc, Dialect::Haas, Dialect::LinuxCnc, Dialect::Sinumerik, Dialect::Heidenhain];

#[test]
fn each_letter_of_a_split_line_has_its_place() {
    let mut followed = 0;
    for dialect in DIALECTS {
        for letter in ('A'..='W').filter(|letter| !('X'..='Z').contains(letter)) {
            let (place, why) = place(letter);
            let sign = if dialect == Dialect::Heidenhain && "ABCDEHIJKLNOPQTUVW".contains(letter) { "+" } else { "" };
            let value = if letter == 'G' { 9 } else { 5 };
            let lines = match written(dialect, &format!("{letter}{sign}{value}")) {
                Ok(lines) => lines,
                Err(refused) => {
                    assert!(refused.contains(letter), "{dialect:?} {letter}: {refused}");
                    continue;
                }
            };
            followed += 1;
            let found = numbers(&lines, letter);
            let (at, count) = (found.iter().position(Option::is_some), found.iter().flatten().count());
            let is_right = match place {
                Grows => {
                    // Shared out by length: X goes from 1 to 11.
                    let x = numbers(&lines, 'X');
                    let share = |k: usize| x[k].map(|x| (x - 1.0) / 10.0 * 5.0);
                    (0..lines.len()).all(|k| found[k].zip(share(k)).is_some_and(|(a, b)| (a - b).abs() < 2e-3))
                }
                First => at == Some(0) && count == 1,
                Last => at == Some(lines.len() - 1) && count == 1,
                Refused => false,
            };
            assert!(is_right, "{dialect:?} {letter}: {place:?}, as {why}\n{}", lines.join("\n"));
        }
    }
    assert!(followed > 50, "{followed}");
}

#[test]
fn words_with_more_than_a_letter_have_their_places() {
    for (words, place) in [
        ("C1=5", None),
        ("X1=5", None),
        ("E1=5", None),
        ("CX=5", None),
        ("Q1=5", None),
        ("U=5", None),
        ("POS[U]=5", None),
        ("FA[C]=5", None),
        ("M1=5", Some(Last)),
        ("M1=3", Some(First)),
        ("S1=500", Some(First)),
        ("S2=500", Some(First)),
        ("SPOS=5", Some(First)),
        ("C=DC(5)", Some(Grows)),
    ] {
        let name: String = words.chars().take_while(|byte| byte.is_ascii_alphanumeric()).collect();
        match (written(Dialect::Sinumerik, words), place) {
            (Err(refused), None) => assert!(refused.contains(&name), "{refused}"),
            (Ok(lines), Some(Grows)) => assert!(lines.iter().all(|line| line.contains('C')), "{lines:?}"),
            (Ok(lines), Some(place)) => {
                let found: Vec<usize> = (0..lines.len()).filter(|k| lines[*k].contains(words)).collect();
                assert_eq!(found, [if place == First { 0 } else { lines.len() - 1 }], "{words} {lines:?}");
            }
            (written, place) => panic!("{words}: {written:?} {place:?}"),
        }
    }
    // Parameters go with their word: LinuxCNC's M67 sets an output with the motion.
    let lines = written(Dialect::LinuxCnc, "M67 E1 Q5").unwrap();
    assert!(lines[0].contains("M67 E1 Q5") && lines[1..].iter().all(|line| !line.contains(['E', 'Q'])), "{lines:?}");
}

#[test]
fn an_axis_of_another_name_is_refused_by_it() {
    let refused = written(Dialect::Iso, "E30").unwrap_err();
    assert!(refused.starts_with("p.nc:4:8: `E30`: an axis that moves with the tool, or an extruder"), "{refused}");
    // On a line that stays one, it moves as it did.
    let source = "G90 G21\nG0 X0 Y0 Z0\nG1 X10 E30 F100\nM30\n";
    let program = GcodeProgram::parse(source, "p.nc", &GcodeOptions::default()).unwrap();
    let path = program.toolpath(Sampling::default()).unwrap();
    let goals: Vec<_> = path.positions_mm().iter().map(|p| p + Vector3::y()).collect();
    let written =
        program.rewrite(&path, &goals, WriteOptions::with_decimals(NumberFormat::new(3, 4).unwrap())).unwrap();
    assert!(String::from_utf8_lossy(written.bytes()).contains("G0 X0 Y1.000 Z0\nG1 X10 E30 F100\n"));
    // Nor does it wait behind a corner that the control cuts.
    for words in ["E30", "A30", "M5"] {
        let source = format!("G90 G21\nG0 X0 Y0 Z0\nG1 X10 {words} F100 ,R1\nY10\nM30\n");
        let refused = GcodeProgram::parse_expanded(source, "p.nc", &GcodeOptions::default(), &|_| None).unwrap_err();
        assert!(refused.to_string().contains(words), "{refused}");
    }
}
