//! Heidenhain's PLANE: the kinds of planes, and whether and how the tool turns.
//!
//! What the parameters mean is said by Heidenhain, *iTNC 530 User's Manual*, The PLANE function (SPATIAL, EULER, VECTOR, POINTS, RELATIV, AXIAL).

use nalgebra::Vector3;

use crate::{
    model::gcode::{
        AngleChoice, Fault, Foreign, ForeignWord, GWord, Inclination, InclinedFault, Refusal, Setting, Word,
    },
    read::{
        gcode::dialect::{heidenhain::g_word, heidenhain_words},
        scan::Scan,
    },
};

static SPATIAL: ForeignWord = kind("PLANE SPATIAL", Inclination::Spatial);
static EULER: ForeignWord = kind("PLANE EULER", Inclination::Euler);
static VECTOR: ForeignWord = kind("PLANE VECTOR", Inclination::Vectors);
static POINTS: ForeignWord = kind("PLANE POINTS", Inclination::Vectors);
static RELATIVE: ForeignWord = kind("PLANE RELATIV", Inclination::Relative);
static AXIAL: ForeignWord = kind("PLANE AXIAL", Inclination::Axial);
/// PLANE RESET.
pub(crate) static OFF: ForeignWord = ForeignWord { name: "PLANE RESET", meaning: GWord::Passive("rotation") };
static TO_ZERO: ForeignWord = ForeignWord { name: "PLANE RESET TURN", meaning: GWord::Align(AngleChoice::Zero) };
static TO_GIVEN: ForeignWord = turn("TURN", AngleChoice::Given);
static GIVEN: ForeignWord = stay(AngleChoice::Given);
/// By the shorter way, SEQ+ and SEQ-, each without and with TABLE ROT.
static TURNS: [[ForeignWord; 2]; 3] = [
    [turn("TURN", shorter(false)), turn("TURN", shorter(true))],
    [turn("SEQ+", by_sign(true, false)), turn("SEQ+", by_sign(true, true))],
    [turn("SEQ-", by_sign(false, false)), turn("SEQ-", by_sign(false, true))],
];
/// The same with STAY.
static STAYS: [[ForeignWord; 2]; 3] = [
    [stay(shorter(false)), stay(shorter(true))],
    [stay(by_sign(true, false)), stay(by_sign(true, true))],
    [stay(by_sign(false, false)), stay(by_sign(false, true))],
];

const fn kind(name: &'static str, inclination: Inclination) -> ForeignWord {
    ForeignWord { name, meaning: GWord::Setting(Setting::Incline(inclination)) }
}

const fn turn(name: &'static str, choice: AngleChoice) -> ForeignWord {
    ForeignWord { name, meaning: GWord::Align(choice) }
}

const fn stay(choice: AngleChoice) -> ForeignWord {
    ForeignWord { name: "STAY", meaning: GWord::FindAngles(choice) }
}

const fn shorter(turns_table: bool) -> AngleChoice {
    AngleChoice::Shorter { turns_table }
}

const fn by_sign(is_positive: bool, turns_table: bool) -> AngleChoice {
    AngleChoice::Sign { is_positive, turns_table }
}

/// Most parameters of a kind.
const MOST: usize = 9;
/// Letters of the words that the parameters become.
const LETTERS: [char; 6] = ['I', 'J', 'K', 'P', 'L', 'R'];
/// Vectors whose cosine is greater are at no right angle; programs have few decimals (0.02 degrees).
const RIGHT_ANGLE: f64 = 3.5e-4;
/// Points whose directions have a smaller sine between them are on one line.
const ON_A_LINE: f64 = 1e-6;

/// A kind of PLANE: its word, the names of its parameters, and which of them it needs.
struct Kind {
    word: &'static ForeignWord,
    names: &'static [&'static str],
    needs: &'static str,
}

impl Kind {
    /// Returns the kind called `name`; `None` if it is not followed.
    fn find(name: &str) -> Option<Kind> {
        const SPACE: &[&str] = &["SPA", "SPB", "SPC"];
        let (word, names, needs): (_, &[&str], _) = match name {
            "SPATIAL" => (&SPATIAL, SPACE, "SPA, SPB and SPC"),
            "RELATIV" | "RELATIVE" => (&RELATIVE, SPACE, "one of SPA, SPB and SPC"),
            "EULER" => (&EULER, &["EULPR", "EULNU", "EULROT"], "EULPR, EULNU and EULROT"),
            "AXIAL" => (&AXIAL, &["A", "B", "C"], "A, B or C"),
            "VECTOR" => {
                (&VECTOR, &["BX", "BY", "BZ", "NX", "NY", "NZ"], "BX, BY and BZ at a right angle to NX, NY and NZ")
            }
            "POINTS" => {
                (&POINTS, &["P1X", "P1Y", "P1Z", "P2X", "P2Y", "P2Z", "P3X", "P3Y", "P3Z"], "three points on no line")
            }
            "RESET" => (&OFF, &[], ""),
            _ => return None,
        };
        Some(Kind { word, names, needs })
    }

    /// Returns the numbers of the words I, J, K, P, L and R by those of the parameters; `None` if they give no plane.
    fn numbers(&self, given: [Option<f64>; MOST]) -> Option<[Option<f64>; 6]> {
        let count = given.iter().flatten().count();
        let vector = |from: usize| Vector3::from_fn(|axis, _| given[from + axis].unwrap_or_default());
        let along = |x: Vector3<f64>, z: Vector3<f64>| [x.x, x.y, x.z, z.x, z.y, z.z].map(Some);
        let is_complete = match self.word.meaning {
            GWord::Setting(Setting::Incline(Inclination::Relative)) => count == 1,
            GWord::Setting(Setting::Incline(Inclination::Axial)) => count > 0,
            _ => count == self.names.len(),
        };
        match self.names.len() {
            _ if !is_complete => None,
            6 => {
                let (x, z) = (vector(0).try_normalize(0.0)?, vector(3).try_normalize(0.0)?);
                (x.dot(&z).abs() <= RIGHT_ANGLE).then(|| along(x, z))
            }
            MOST => {
                let x = (vector(3) - vector(0)).try_normalize(0.0)?;
                let z = x.cross(&(vector(6) - vector(0)).try_normalize(0.0)?);
                (z.norm() > ON_A_LINE).then(|| along(x, z))
            }
            _ => Some(std::array::from_fn(|index| given[index])),
        }
    }
}

/// Returns the words of PLANE of the kind `second`, whose parameters are at the cursor; `Err` for kinds and parameters that are not followed.
pub(crate) fn plane_words(mut scan: Scan, second: &str, start: usize) -> Result<Vec<Word>, Refusal> {
    let refuse = |scan: &Scan, expected| Err(scan.refuse_all(start, Fault::Inclined(InclinedFault::Form { expected })));
    let span = start..scan.at;
    let Some(kind) = Kind::find(second) else {
        return refuse(&scan, "PLANE SPATIAL, EULER, VECTOR, POINTS, RELATIV, AXIAL or RESET");
    };
    let mut given = [None; MOST];
    let (mut turns, mut sign, mut turns_table) = (None, 0, false);
    while scan.next().is_some() {
        let at = scan.at;
        let name = take_name(&mut scan);
        if let Some(index) = kind.names.iter().position(|own| *own == name) {
            let word = heidenhain_words::coordinate_word(&mut scan, LETTERS[0], None, at)?;
            if given[index].replace(word.value).is_some() {
                return Err(word.refuse(Fault::Foreign(Foreign::Twice)));
            }
            continue;
        }
        match name.as_str() {
            "TURN" | "MOVE" if turns.is_none() => turns = Some(true),
            "STAY" if turns.is_none() => turns = Some(false),
            "SEQ" | "SYM" if scan.takes(b'+') => sign = 1,
            "SEQ" | "SYM" if scan.takes(b'-') => sign = 2,
            "FMAX" | "FAUTO" => {}
            "MB" if scan.next().is_some_and(|byte| byte.is_ascii_alphabetic()) => {
                scan.take_letters();
            }
            // How fast and how far away it turns.
            "F" | "MB" | "DIST" | "ABST" if scan.next().is_some() => {
                scan.take_decimal()?.map(drop).ok_or_else(|| scan.refuse(at, Foreign::NoNumber))?;
            }
            "COORD" if scan.next().is_some() && scan.take_letters() == "ROT" => {}
            "TABLE" if scan.next().is_some() && scan.take_letters() == "ROT" => turns_table = true,
            _ => {
                return refuse(
                    &scan,
                    "its own parameters with numbers, TURN, MOVE or STAY, F, SEQ+ or SEQ-, TABLE ROT or COORD ROT",
                );
            }
        }
    }
    let Some(turns) = turns else { return refuse(&scan, "TURN, MOVE or STAY, which say whether the tool turns") };
    let Some(numbers) = kind.numbers(given) else { return refuse(&scan, kind.needs) };
    let mut words = vec![g_word(kind.word, span.clone())];
    let letters = LETTERS.into_iter().zip(numbers);
    words.extend(letters.filter_map(|(letter, number)| Some(Word::plain(letter, number?, span.clone()))));
    let turn = match (second, turns) {
        ("RESET", true) => &TO_ZERO,
        ("RESET", false) => return Ok(words),
        // To given angles there is no other way.
        ("AXIAL", true) => &TO_GIVEN,
        ("AXIAL", false) => &GIVEN,
        (_, true) => &TURNS[sign][usize::from(turns_table)],
        (_, false) => &STAYS[sign][usize::from(turns_table)],
    };
    words.push(g_word(turn, span));
    Ok(words)
}

/// Takes a name: letters, and those of a coordinate of a point (`P1X`).
fn take_name(scan: &mut Scan) -> String {
    let mut name = scan.take_letters();
    if name == "P" {
        let digits = scan.take_while(|byte| byte.is_ascii_digit());
        name += &scan.upper_text(digits);
        name += &scan.take_letters();
    }
    name
}
