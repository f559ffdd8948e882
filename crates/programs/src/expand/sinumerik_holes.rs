//! Holes and patterns of holes of Sinumerik: the values in brackets, and the moves that drill one.
//!
//! The values and the order of moves are those of Siemens, *SINUMERIK 840D/840Di/810D Programming Guide Cycles*, drilling cycles and drilling
//! patterns. Values that only later versions have must be left out or say what the earlier ones do.

use crate::{expand::line::plain_number, model::NumberFormat};

/// Most holes of a pattern, and most pecks of a hole.
const MOST: f64 = 10_000.0;

/// What a value should be.
pub(super) type Expected = &'static str;

/// A hole at the tool position; heights are absolute coordinates in the unit of the program.
#[derive(Clone)]
pub(super) struct Hole {
    retract: f64,
    clear: f64,
    reference: f64,
    bottom: f64,
    dwell_s: f64,
    way: Way,
}

/// How the tool goes down and comes back.
#[derive(Clone)]
enum Way {
    /// Down at the feed in force, out rapidly.
    Drilled,
    /// Down and out at feeds; without a number at the one in force.
    Fed([Option<f64>; 2]),
    Pecked(Pecks),
    /// With the spindle in step, which no move says: by the cycle itself, its name and what is behind its heights.
    Tapped([String; 2]),
}

/// Pecks of deep hole drilling (CYCLE83).
#[derive(Clone)]
struct Pecks {
    /// Depths below the reference plane, the last one that of the hole.
    depths: Vec<f64>,
    /// Factor of the feed of the first peck.
    factor: f64,
    /// Whether the tool leaves the hole between pecks (VARI=1).
    clears: bool,
    /// How far it goes up to break chips, and how far above the last depth the feed begins again.
    lift: Option<f64>,
    gap: Option<f64>,
    /// Dwells at the depth and at the top, between pecks.
    dwells_s: [f64; 2],
}

/// The state of a program where a hole is drilled.
#[derive(Clone, Copy, Default)]
pub(super) struct InForce {
    /// Number of the G word of motion.
    pub motion: Option<f64>,
    pub feed: Option<f64>,
    pub is_in_inches: bool,
}

/// Parses the values in brackets; `None` stands for one that is left out.
fn values(arguments: &str) -> Result<Vec<Option<f64>>, Expected> {
    let inner = arguments.trim().strip_prefix('(').and_then(|rest| rest.strip_suffix(')'));
    let value = |text: &str| match text.trim() {
        "" => Some(None),
        text => text.parse::<f64>().ok().filter(|value| value.is_finite()).map(Some),
    };
    inner.and_then(|inner| inner.split(',').map(value).collect()).ok_or("numbers in brackets")
}

/// Checks that the values behind the first `own` are those of later versions that change nothing: zeros, and 1 (G17) for _DMODE.
fn check_later_values(values: &[Option<f64>], own: usize, display: usize) -> Result<(), Expected> {
    let is_plain = |(at, value): (usize, &Option<f64>)| match value {
        Some(1.0) => at == display,
        value => value.unwrap_or(0.0) == 0.0,
    };
    if values.iter().enumerate().skip(own).all(is_plain) {
        Ok(())
    } else {
        Err("values of the older form alone; those behind them 0 or left out, _DMODE 0 or 1")
    }
}

impl Hole {
    /// Parses the values of the cycle `name`.
    pub fn parse(name: &str, arguments: &str) -> Result<Hole, Expected> {
        let mut values = values(arguments)?;
        let own = match name {
            "CYCLE83" => 17,
            "CYCLE84" => 18,
            "CYCLE840" => 12,
            "CYCLE85" => 8,
            _ => 6,
        };
        // _AMODE may say whether the depth is absolute, and that dwells are in seconds.
        let mode = values.get_mut(own + 2).filter(|_| matches!(name, "CYCLE81" | "CYCLE82"));
        let mode = mode.map_or(0.0, |mode| mode.take().unwrap_or(0.0));
        check_later_values(&values, own, own + 1)?;
        let given = |at: usize| values.get(at).copied().flatten().filter(|_| at < own);
        let retract = given(0).ok_or("RTP, the first value")?;
        let reference = given(1).ok_or("RFP, the second value")?;
        let clear = reference + given(2).unwrap_or(0.0).abs();
        // A depth of 0 below RFP is one that is left out; of both, the one below RFP counts.
        let below = given(4).filter(|depth| *depth != 0.0).map(|depth| reference - depth.abs());
        let bottom = match (mode, given(3), below) {
            (0.0, at, below) => below.or(at),
            (1.0 | 11.0, None, below) => below,
            (2.0 | 12.0, at, None) => at,
            _ => return Err("an _AMODE of the depth that is given, and dwell in seconds"),
        };
        let bottom = bottom.filter(|bottom| *bottom < reference).ok_or("a depth below RFP: DP absolute, or DPR")?;
        if retract < clear {
            return Err("RTP not below RFP + SDIS");
        }
        let seconds = |at: usize| match given(at).unwrap_or(0.0) {
            dwell if dwell >= 0.0 => Ok(dwell),
            _ => Err("dwell in seconds, not in turns"),
        };
        let (mut dwell_s, mut way) = (seconds(if name == "CYCLE83" { 8 } else { 5 })?, Way::Drilled);
        match name {
            "CYCLE83" => {
                let between_s = [dwell_s, seconds(9)?];
                dwell_s = given(15).filter(|dwell| *dwell != 0.0).map_or(Ok(dwell_s), |_| seconds(15))?;
                way = Way::Pecked(Pecks::parse(&given, [reference, reference - bottom], between_s)?);
            }
            "CYCLE85" => {
                let feeds = [given(6), given(7)];
                if feeds.iter().any(|feed| feed.is_none_or(|feed| feed <= 0.0)) {
                    return Err("FFR and RFF, feeds in and out");
                }
                way = Way::Fed(feeds);
            }
            "CYCLE89" => way = Way::Fed([None; 2]),
            "CYCLE84" | "CYCLE840" => {
                if !matches!(given(if name == "CYCLE84" { 12 } else { 11 }).unwrap_or(3.0), 0.0 | 3.0) {
                    return Err("_AXN of 0 or 3, the axis of the tool");
                }
                let behind = arguments.match_indices(',').nth(4);
                let behind = behind.map_or(")".to_owned(), |(at, _)| format!(",{}", arguments[at..].trim_end()));
                way = Way::Tapped([name.to_owned(), behind]);
            }
            _ => {}
        }
        Ok(Hole { retract, clear, reference, bottom, dwell_s, way })
    }

    /// Returns the lines that drill the hole and put motion and feed back in force.
    pub fn moves(&self, in_force: InForce) -> Result<Vec<String>, Expected> {
        if let Way::Tapped([name, behind]) = &self.way {
            let [retract, clear, bottom] = [self.retract, self.clear, self.bottom].map(plain_number);
            return Ok(vec![format!("{name}({retract},{clear},,{bottom}{behind}")]);
        }
        let mut moves = Moves { lines: Vec::new(), feed: None };
        moves.go(0, self.clear);
        match &self.way {
            Way::Drilled => {
                moves.go(1, self.bottom);
                moves.dwell(self.dwell_s);
            }
            Way::Fed([down, up]) => {
                moves.feed = *down;
                moves.go(1, self.bottom);
                moves.dwell(self.dwell_s);
                moves.feed = *up;
                moves.go(1, self.clear);
                moves.feed = in_force.feed.filter(|_| up.is_some());
            }
            Way::Pecked(pecks) => self.peck(pecks, in_force, &mut moves)?,
            Way::Tapped(..) => {}
        }
        moves.go(0, self.retract);
        moves.lines.extend(in_force.motion.filter(|motion| *motion != 0.0).map(|motion| format!("G{motion}")));
        Ok(moves.lines)
    }

    /// Drills in pecks.
    fn peck(&self, pecks: &Pecks, in_force: InForce, moves: &mut Moves) -> Result<(), Expected> {
        let mm = if in_force.is_in_inches { 1.0 / 25.4 } else { 1.0 };
        if pecks.factor != 1.0 {
            let feed = in_force.feed.ok_or("a feed before it, of which FRF is a share")?;
            moves.feed = Some(feed * pecks.factor);
        }
        let Some((last, before)) = pecks.depths.split_last() else { return Ok(()) };
        for (peck, depth) in before.iter().enumerate() {
            let at = self.reference - depth;
            moves.go(1, at);
            if peck == 0 && pecks.factor != 1.0 {
                moves.feed = in_force.feed;
            }
            moves.dwell(pecks.dwells_s[0]);
            if !pecks.clears {
                moves.go(1, self.clear.min(at + pecks.lift.unwrap_or(mm)));
                continue;
            }
            moves.go(0, self.clear);
            moves.dwell(pecks.dwells_s[1]);
            let above = at + pecks.gap.unwrap_or_else(|| mm * (depth / mm / 50.0).clamp(0.6, 7.0));
            if self.clear - above > NumberFormat::FINEST {
                moves.go(0, above);
            }
        }
        moves.go(1, self.reference - last);
        if before.is_empty() && pecks.factor != 1.0 {
            moves.feed = in_force.feed;
        }
        moves.dwell(self.dwell_s);
        Ok(())
    }
}

impl Pecks {
    /// Reads what CYCLE83 says of its pecks, for a hole of the depth `total` below `reference`.
    fn parse(
        given: &dyn Fn(usize) -> Option<f64>,
        [reference, total]: [f64; 2],
        dwells_s: [f64; 2],
    ) -> Result<Pecks, Expected> {
        let first = given(6).filter(|depth| *depth != 0.0).map(f64::abs);
        let first = first.or(given(5).map(|at| reference - at)).filter(|first| *first > 0.0);
        let first = first.ok_or("a first depth below RFP: FDEP absolute, or FDPR")?;
        let less = given(7).unwrap_or(0.0);
        let least = given(13).unwrap_or(0.0);
        let (factor, removal) = (given(10).unwrap_or(1.0), given(11).unwrap_or(0.0));
        if less < 0.0 || (less > 0.0 && least != 0.0) {
            return Err("DAM as a length, and _MDEP only without it");
        }
        if !(0.001..=1.0).contains(&factor) {
            return Err("FRF from 0.001 to 1");
        }
        if !(removal == 0.0 || removal == 1.0) || !matches!(given(12).unwrap_or(3.0), 0.0 | 3.0) {
            return Err("VARI of 0 or 1, and _AXN of 0 or 3, the axis of the tool");
        }
        let length = |at: usize| given(at).filter(|length| *length > 0.0);
        if [14, 16].into_iter().filter_map(given).any(|length| length < 0.0) {
            return Err("_VRT and _DIS1 not below 0");
        }
        let depths = pecks(total, first, less).ok_or("no more than 10000 pecks")?;
        Ok(Pecks { depths, factor, clears: removal == 1.0, lift: length(14), gap: length(16), dwells_s })
    }
}

/// Returns the depths of the pecks of a hole. Each is `less` shorter than the one before, but not below `less`; the last is `less`, or equal
/// to the one before it. Without `less` all are as the `first`, but for the last two, which are equal. `None` for too many.
fn pecks(total: f64, first: f64, less: f64) -> Option<Vec<f64>> {
    let (mut at, mut peck) = (first.min(total), first);
    let mut depths = vec![at];
    while total - at > NumberFormat::FINEST {
        peck = (peck - less).max(less);
        let left = total - at;
        let behind = left - peck;
        at = if behind <= NumberFormat::FINEST {
            total
        } else if behind >= if less > 0.0 { less } else { peck } - NumberFormat::FINEST {
            at + peck
        } else if less > 0.0 && left > 2.0 * less {
            total - less
        } else {
            at + left / 2.0
        };
        depths.push(at);
        if depths.len() as f64 > MOST {
            return None;
        }
    }
    Some(depths)
}

/// Lines of moves, and the feed that the next one puts in force.
struct Moves {
    lines: Vec<String>,
    feed: Option<f64>,
}

impl Moves {
    fn go(&mut self, g: u32, z: f64) {
        let feed = self.feed.take().map_or(String::new(), |feed| format!(" F={}", plain_number(feed)));
        self.lines.push(format!("G{g} Z=AC({}){feed}", plain_number(z)));
    }

    fn dwell(&mut self, seconds: f64) {
        self.lines.extend((seconds > 0.0).then(|| format!("G4 F{}", plain_number(seconds))));
    }
}

/// Returns the points of the pattern `name`, a row (HOLES1) or a circle (HOLES2); `at`: where the tool is in the plane, as far as known.
pub(super) fn pattern(name: &str, arguments: &str, at: [Option<f64>; 2]) -> Result<Vec<[f64; 2]>, Expected> {
    let values = values(arguments)?;
    check_later_values(&values, 6, 10)?;
    let given = |at: usize| values.get(at).copied().flatten();
    let (Some(x), Some(y), Some(count)) = (given(0), given(1), given(5)) else {
        return Err("a point and a number of holes");
    };
    if count.fract() != 0.0 || !(1.0..=MOST).contains(&count) {
        return Err("1 to 10000 holes");
    }
    let (start, step) = (given(if name == "HOLES1" { 2 } else { 3 }).unwrap_or(0.0), given(4).unwrap_or(0.0));
    let holes = 0..count as u32;
    if name == "HOLES1" {
        let (sin, cos) = libm::sincos(start.to_radians());
        let first = given(3).unwrap_or(0.0).abs();
        let along = |hole: u32| first + f64::from(hole) * step.abs();
        let points: Vec<[f64; 2]> = holes.map(|hole| [x + along(hole) * cos, y + along(hole) * sin]).collect();
        let is_near = |[a, b]: [f64; 2]| {
            let distance = |point: &[f64; 2]| libm::hypot(point[0] - a, point[1] - b);
            points.first().zip(points.last()).is_some_and(|(first, last)| distance(first) <= distance(last) + 1e-9)
        };
        let is_sure = points.len() == 1 || at[0].zip(at[1]).is_some_and(|(a, b)| is_near([a, b]));
        // The control may begin at the nearer end.
        return if is_sure { Ok(points) } else { Err("X and Y before it, nearer to its first hole than to its last") };
    }
    let radius = given(2).map_or(0.0, f64::abs);
    let step = if step == 0.0 { 360.0 / count } else { step };
    if radius == 0.0 || step.abs() * (count - 1.0) >= 360.0 {
        return Err("a radius, and holes that are not more than once around");
    }
    let point = |hole: u32| {
        let (sin, cos) = libm::sincos((start + f64::from(hole) * step).to_radians());
        [x + radius * cos, y + radius * sin]
    };
    Ok(holes.map(point).collect())
}
