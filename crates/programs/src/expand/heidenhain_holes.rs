//! Holes of Heidenhain's drilling cycles with Q parameters: what CYCL DEF says, and the blocks that drill one.
//!
//! The parameters and the order of moves are those of Heidenhain, *iTNC 530 User's Manual Cycle Programming* and *TNC 640 User's Manual Cycle
//! Programming*: drilling (200), reaming (201), universal drilling (203), universal pecking (205) and centering (240).

use std::collections::BTreeMap;

use crate::{expand::line::plain_number, model::NumberFormat, read::scan::Scan};

/// Most pecks of a hole.
const MAX_PECKS: usize = 10_000;

/// What a parameter should be.
pub(super) type Expected = &'static str;

/// A cycle that is followed: its number, and its parameters that must be given, may be given, and must be 0 if they are given.
struct Known {
    number: &'static str,
    needed: &'static [u32],
    other: &'static [u32],
    zero: &'static [u32],
}

const KNOWN: [Known; 5] = [
    Known { number: "200", needed: &[200, 201, 202, 203, 206], other: &[204, 210, 211], zero: &[395] },
    Known { number: "201", needed: &[200, 201, 203, 206], other: &[204, 208, 211], zero: &[] },
    Known {
        number: "203",
        needed: &[200, 201, 202, 203, 206],
        other: &[204, 205, 208, 210, 211, 212, 213, 256],
        zero: &[395],
    },
    Known {
        number: "205",
        needed: &[200, 201, 202, 203, 206],
        other: &[204, 205, 208, 211, 212, 253, 256, 257, 258, 259],
        zero: &[379, 395],
    },
    Known { number: "240", needed: &[200, 201, 203, 206], other: &[204, 211, 253, 344], zero: &[342, 343] },
];

/// The value that stands for MAX and FMAX.
const RAPID: f64 = f64::INFINITY;

/// The parameters of the last CYCL DEF.
pub(super) struct Cycle {
    known: &'static Known,
    /// Values of its Q parameters.
    q: BTreeMap<u32, f64>,
}

/// Whether the cycle `number` is followed.
pub(super) fn is_known(number: &str) -> bool {
    KNOWN.iter().any(|known| known.number == number)
}

impl Cycle {
    /// Reads the Q parameters of the cycle `number` in the lines of its CYCL DEF.
    pub fn read<'a>(number: &str, lines: impl Iterator<Item = &'a [u8]>) -> Result<Cycle, Expected> {
        let known = KNOWN.iter().find(|known| known.number == number).ok_or("one of the cycles that are followed")?;
        let mut q = BTreeMap::new();
        for line in lines {
            let scan = Scan::of_line(line, 0);
            let code = scan.upper_text(0..scan.line.len());
            for (at, _) in code.match_indices('Q') {
                let Some((number, value)) = code[at + 1..].split_once('=') else { continue };
                let Ok(number) = number.trim().parse::<u32>() else { continue };
                let mut value = Scan::of_line(value.trim_start().as_bytes(), 0);
                let word = value.take_letters();
                let given = match word.as_str() {
                    "" => value.take_decimal().ok().flatten().map(|(given, _)| given),
                    "MAX" | "FMAX" if number == 208 => Some(RAPID),
                    _ => None,
                };
                let is_alone = value.next().is_none_or(|byte| matches!(byte, b'Q' | b'~'));
                q.insert(number, given.filter(|_| is_alone).ok_or("numbers behind Q200= and the like, MAX for Q208")?);
            }
        }
        if !known.needed.iter().all(|number| q.contains_key(number)) {
            return Err("Q200, Q201, Q203 and Q206, and Q202 of a cycle with pecks");
        }
        let is_of_cycle = |number: &u32| [known.needed, known.other, known.zero].iter().any(|of| of.contains(number));
        if !q.keys().all(is_of_cycle) {
            return Err("only the parameters of this cycle that are followed");
        }
        if known.zero.iter().any(|number| q.get(number).is_some_and(|value| *value != 0.0)) {
            return Err("a depth of the tool's tip from the surface on: Q395, Q379, Q343 and Q342 of 0");
        }
        Ok(Cycle { known, q })
    }

    fn value(&self, number: u32) -> f64 {
        self.q.get(&number).copied().unwrap_or(0.0)
    }

    /// Returns blocks that drill one hole at the tool position and put `feed` back in force.
    pub fn moves(&self, feed: Option<&str>) -> Result<Vec<String>, Expected> {
        let q = |number: u32| self.value(number);
        let (set_up, depth, surface, plunge) = (q(200), -q(201), q(203), q(206));
        if depth <= 0.0 || set_up <= 0.0 || plunge <= 0.0 {
            return Err("a depth Q201 below 0, and Q200 and Q206 above 0");
        }
        let (clear, bottom) = (surface + set_up, surface - depth);
        let back = match q(208) {
            feed if feed < 0.0 => return Err("Q208 not below 0"),
            0.0 if self.known.number == "205" && !self.q.contains_key(&208) => RAPID,
            0.0 => plunge,
            feed => feed,
        };
        let mut blocks = vec![fed(clear, RAPID)];
        if matches!(self.known.number, "200" | "203" | "205") {
            for (peck, leaves) in self.pecks(depth)? {
                let at = surface - peck;
                blocks.push(fed(at, plunge));
                match leaves {
                    Leaves::ToBreak => {
                        blocks.push(fed(clear.min(at + q(256)), if back == RAPID { plunge } else { back }))
                    }
                    Leaves::ToClear => {
                        blocks.push(fed(clear, if self.known.number == "203" { back } else { RAPID }));
                        blocks.extend(dwell(q(210)));
                        let above = if self.known.number == "205" { q(258) } else { set_up };
                        let above = clear.min(at + above);
                        blocks.extend((clear - above > NumberFormat::FINEST).then(|| fed(above, RAPID)));
                    }
                }
            }
        }
        blocks.push(fed(bottom, plunge));
        blocks.extend(dwell(q(211)));
        let second = clear.max(surface + q(204));
        match self.known.number {
            "200" | "240" => blocks.push(fed(second, RAPID)),
            _ => {
                blocks.push(fed(clear, back));
                blocks.extend((second > clear).then(|| fed(second, RAPID)));
            }
        }
        blocks.extend(feed.map(|feed| format!("L {feed}")));
        Ok(blocks)
    }

    /// Returns the depths below the surface at which the tool stops on its way to `depth`, and why.
    fn pecks(&self, depth: f64) -> Result<Vec<(f64, Leaves)>, Expected> {
        let q = |number: u32| self.value(number);
        let (mut peck, less, least, lift) = (q(202), q(212), q(205), q(256));
        if peck <= 0.0 || less < 0.0 || (less > 0.0 && !(0.0 < least && least <= peck)) {
            return Err("Q202 above 0, and Q205 above 0 and not above Q202 if Q212 makes pecks shorter");
        }
        let (breaks, every) = (q(213), q(257));
        if breaks < 0.0 || breaks.fract() != 0.0 || every < 0.0 || ((breaks > 0.0 || every > 0.0) && lift <= 0.0) {
            return Err("a whole number Q213, Q257 not below 0, and Q256 above 0 to break chips");
        }
        if self.known.number == "205" && (q(258) <= 0.0 || q(259) != q(258)) {
            return Err("Q258 above 0, and Q259 the same");
        }
        let (mut stops, mut at, mut broken) = (Vec::new(), 0.0, 0.0);
        for number in 1.. {
            let before = at;
            // Equal pecks do not add up.
            at = if less == 0.0 { f64::from(number) * peck } else { before + peck };
            let end = at.min(depth);
            let count =
                if every > 0.0 { ((end - before - NumberFormat::FINEST) / every).floor().max(0.0) } else { 0.0 };
            if stops.len() as f64 + count >= MAX_PECKS as f64 {
                return Err("no more than 10000 pecks");
            }
            stops.extend((1..=count as u32).map(|number| (before + f64::from(number) * every, Leaves::ToBreak)));
            if depth - at <= NumberFormat::FINEST {
                break;
            }
            let leaves = if broken < breaks { Leaves::ToBreak } else { Leaves::ToClear };
            broken = if broken < breaks { broken + 1.0 } else { 0.0 };
            stops.push((at, leaves));
            peck = (peck - less).max(least.min(peck));
        }
        Ok(stops)
    }
}

/// Why the tool stops in a hole.
#[derive(Clone, Copy)]
enum Leaves {
    /// To break the chip.
    ToBreak,
    /// To go out of the hole.
    ToClear,
}

/// Returns a line along the tool axis at a feed.
fn fed(z: f64, feed: f64) -> String {
    let feed = if feed == RAPID { "MAX".to_owned() } else { plain_number(feed) };
    format!("L Z{} R0 F{feed}", signed(z))
}

/// Returns the blocks of a dwell; none without one.
fn dwell(seconds: f64) -> impl Iterator<Item = String> {
    let blocks = ["CYCL DEF 9.0 DWELL TIME".to_owned(), format!("CYCL DEF 9.1 DWELL {}", plain_number(seconds))];
    blocks.into_iter().filter(move |_| seconds > 0.0)
}

/// Formats a number with its sign, plus included.
fn signed(value: f64) -> String {
    let text = plain_number(value);
    if text.starts_with('-') { text } else { format!("+{text}") }
}
