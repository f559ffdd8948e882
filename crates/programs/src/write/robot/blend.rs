//! What stands behind poses of split motions: their blends, which must end before those of the points beside them begin.

use std::borrow::Cow;

use crate::{
    model::robot::{Language, METRE_MM, MotionKind, Statement},
    read::{
        robot::{
            krl::{WithPart, with_parts},
            rapid::{split_arguments, zone_of},
            trimmed,
            urscript::{argument_names, arguments, named_argument},
        },
        scan::Scan,
    },
    write::robot::Writer,
};

/// The blend at the end of a motion in URScript as it is written.
#[derive(Debug)]
pub(crate) struct LastBlend {
    statement: Statement,
    /// Its radius, if another than that of the statement.
    radius_mm: Option<f64>,
    is_line: bool,
}

impl<'a> Writer<'a> {
    /// Returns what stands behind the pose at the end of a split motion, whose last piece has this length: in URScript with a blend that does
    /// not meet that of the point before, which the controller does not allow; others limit it themselves.
    pub(crate) fn end_suffix(&mut self, statement: &Statement, length_mm: f64, is_line: bool) -> Cow<'a, [u8]> {
        if statement.spline.is_some() {
            return spline_suffix(self.source, statement, is_line);
        }
        if self.format.language != Language::UrScript {
            return Cow::Borrowed(&self.source[statement.suffix.clone()]);
        }
        let most = SHARE * length_mm;
        let radius_mm = statement.blend_mm.filter(|own| *own > most).map(|_| most);
        self.last_blend = Some(LastBlend { statement: statement.clone(), radius_mm, is_line });
        script_suffix(self.source, statement, radius_mm, is_line)
    }

    /// Keeps the blend of a motion that is written as one statement in mind.
    pub(crate) fn keep_blend(&mut self, statement: &Statement) {
        let is_given = self.format.language == Language::UrScript && statement.blend_mm.is_some();
        self.last_blend = is_given.then(|| LastBlend { statement: statement.clone(), radius_mm: None, is_line: false });
    }

    /// Makes the blend of the motion before smaller where it would meet that of the point at which a split motion, which begins at byte `start`
    /// of the source and up to which all is written, has its first piece of this length.
    pub(crate) fn shorten_blend_before(&mut self, start: usize, length_mm: f64) {
        let Some(LastBlend { statement, radius_mm, is_line }) = self.last_blend.take() else { return };
        let most = SHARE * length_mm;
        if radius_mm.or(statement.blend_mm).is_some_and(|radius| radius > most) {
            let end = self.out.len() - (start - statement.at.end);
            let length = script_suffix(self.source, &statement, radius_mm, is_line).len();
            let suffix = script_suffix(self.source, &statement, Some(most), is_line).into_owned();
            self.out.splice(end - length..end, suffix);
        }
    }
}

/// Share of the distance to the next point up to which a blend may reach: those of both may not meet.
const SHARE: f64 = 0.45;
/// Blend at points that are put in where the motion has none, mm.
const SMALL_MM: f64 = 1.0;

/// Returns what stands behind the last pose of `statement`, with a blend for a point that is put in and has its nearer neighbour in
/// the distance `room_mm`. KUKA's controller begins to approximate at half the distance to a neighbour at the earliest, and CNT of FANUC is a
/// share of the speed: these need none of it.
pub(crate) fn suffix_between<'a>(
    language: Language,
    source: &'a [u8],
    statement: &Statement,
    room_mm: f64,
    is_line: bool,
) -> Cow<'a, [u8]> {
    if let Some(spline) = &statement.spline {
        let suffix = spline_suffix(source, statement, is_line);
        return match spline.block.is_some() || is_approximated(&suffix) {
            true => suffix,
            false => Cow::Owned([&suffix, &b" C_SPL"[..]].concat()),
        };
    }
    let suffix = &source[statement.suffix.clone()];
    let text = String::from_utf8_lossy(suffix).to_ascii_uppercase();
    match language {
        Language::Krl if !text.contains("C_") => Cow::Owned([suffix, b" C_DIS"].concat()),
        Language::Ls => match text.find("FINE") {
            Some(at) => Cow::Owned([&suffix[..at], b"CNT100", &suffix[at + 4..]].concat()),
            None => Cow::Borrowed(suffix),
        },
        Language::Rapid => {
            let zone = split_arguments(suffix, 0).get(2).map(|zone| trimmed(suffix, zone.clone()));
            match (zone, radius_mm(statement, room_mm)) {
                (Some(zone), Some(radius)) => {
                    Cow::Owned([&suffix[..zone.start], zone_of(radius).as_bytes(), &suffix[zone.end..]].concat())
                }
                _ => Cow::Borrowed(suffix),
            }
        }
        Language::UrScript => script_suffix(source, statement, radius_mm(statement, room_mm), is_line),
        _ => Cow::Borrowed(suffix),
    }
}

/// Returns what stands behind the last pose of a spline motion of KRL; for a line in place of a circle if `is_line`, without what WITH says of
/// circles.
fn spline_suffix<'a>(source: &'a [u8], statement: &Statement, is_line: bool) -> Cow<'a, [u8]> {
    let own = &source[statement.suffix.clone()];
    let mut scan = Scan::new(own);
    let is_of_circle = |part: &WithPart<'_>| part.name.starts_with("$CIRC_");
    let parts = with_parts(&mut scan).unwrap_or_default();
    if !is_line || statement.kind != MotionKind::Circle || !parts.iter().any(is_of_circle) {
        return Cow::Borrowed(own);
    }
    let kept: Vec<&[u8]> = parts.iter().filter(|part| !is_of_circle(part)).map(|part| &own[part.at.clone()]).collect();
    let with: &[u8] = if kept.is_empty() { b"" } else { b" WITH " };
    let rest = scan.rest().trim_ascii();
    let blank: &[u8] = if rest.is_empty() { b"" } else { b" " };
    Cow::Owned([with, &kept.join(&b", "[..]), blank, rest].concat())
}

/// Whether an approximation ends `suffix`, behind WITH and its parts.
fn is_approximated(suffix: &[u8]) -> bool {
    let mut scan = Scan::new(suffix);
    with_parts(&mut scan).is_ok() && !scan.is_done()
}

/// Returns the radius for a point that has its nearer neighbour in the distance `room_mm`; `None` if that of the statement fits.
fn radius_mm(statement: &Statement, room_mm: f64) -> Option<f64> {
    let most = SHARE * room_mm;
    match statement.blend_mm {
        Some(own) if own <= most => None,
        Some(own) if own.is_finite() => Some(most),
        _ => Some(most.min(SMALL_MM)),
    }
}

/// Returns what stands behind the last pose of a motion in URScript, with `radius_mm` if it is given; for a movel in place of a movec if `is_line`.
fn script_suffix<'a>(source: &'a [u8], statement: &Statement, radius_mm: Option<f64>, is_line: bool) -> Cow<'a, [u8]> {
    let (text, keyword) = (&source[statement.at.clone()], &source[statement.keyword.clone()]);
    let own = &source[statement.suffix.clone()];
    let names = argument_names(keyword);
    let poses = if statement.kind == MotionKind::Circle { 2 } else { 1 };
    let Ok((parts, _)) = arguments(text, keyword.len()) else { return Cow::Borrowed(own) };
    let is_line = is_line && statement.kind == MotionKind::Circle;
    if parts.len() < poses || (radius_mm.is_none() && !is_line) {
        return Cow::Borrowed(own);
    }
    let mut out = text[statement.suffix.start - statement.at.start..parts[poses - 1].end].to_vec();
    let radius = radius_mm.map(|mm| format!("{:.7}", (mm / METRE_MM * 1e7).floor() / 1e7));
    let mut missing = radius.as_deref();
    for (k, part) in parts.iter().enumerate().skip(poses) {
        let part = &text[part.clone()];
        let (given, value) = named_argument(part);
        let name = given.or(names.get(k).copied()).unwrap_or_default();
        let value = if name == "r" { missing.take().map_or(value, str::as_bytes) } else { value };
        let old = named_argument(part).1;
        match is_line {
            true if name == "mode" => {}
            true => out.extend_from_slice(&[b", ", name.as_bytes(), b"=", value].concat()),
            false => {
                let body = part.trim_ascii_end();
                out.extend_from_slice(&[b",", &body[..body.len() - old.len()], value, &part[body.len()..]].concat());
            }
        }
    }
    if let Some(radius) = missing {
        out.extend_from_slice(&[b", r=", radius.as_bytes()].concat());
    }
    out.push(b')');
    Cow::Owned(out)
}
