//! Tools in comments of G-code, as posts write them.
//!
//! | post | comment |
//! |---|---|
//! | Autodesk Fusion 360, HSM, Inventor | `(T3 D=6. CR=3. - ZMIN=-2. - ball end mill)`, `;  #7 D=7 TAPER=118deg - ZMIN=-30.1 - drill` |
//! | the same, OpenBuilds | `(  Tool #1: Flat End Mill 2 Flutes, Diam = 6.35mm, Len = 19.05mm)` |
//! | Vectric VCarve, Aspire | `(T2 = End Mill {0.5 inches})`, `(5 = End Mill {0.2500 inch} UpDown)` |
//! | Mastercam | `( T212 \|    3. FLAT ENDMILL \| H0 )`, `( 1/16 FLAT ENDMILL TOOL - 1 DIA. OFF. - 1 LEN. - 1 DIA. - .0625)` |
//!
//! Lengths without a unit are in that of the program. FreeCAD's own posts write names of tools, `(TC: 5mm Endmill)`: no diameter.

use crate::{
    model::{
        gcode::LengthUnit,
        tool::{ToolDescription, ToolShape},
    },
    read::gcode::lines::Lines,
};

/// What posts call tools with a shape, in lower case.
const NAMES: [(ToolShape, &str); 4] = [
    (ToolShape::Flat, "flat end mill|flat endmill|end mill"),
    (ToolShape::Ball, "ball end mill|ball endmill|ball nose"),
    // A face mill without corners is flat.
    (ToolShape::BullNose, "bull nose end mill|bullnose end mill|bull endmill|radiused end mill|face mill"),
    (ToolShape::Drill, "drill|spot drill"),
];
/// What they call others.
const OTHERS: &str = "chamfer mill|slot mill|radius mill|form mill|form tool|dovetail mill|tapered mill|tapered ball nose|lollipop mill|\
                      thread mill|right hand tap|left hand tap|tap|center drill|reamer|counter bore|counter sink|boring bar|boring head|\
                      v-bit|engraving|engrave|diamond drag|probe";

/// Returns what the comments of `source` say about tools, each saying once, with the tools in their order; `unit` is that of lengths without one.
pub fn tool_comments(source: &[u8], unit: Option<LengthUnit>) -> Vec<ToolDescription> {
    let (lines, mut found) = (Lines::split(source), Vec::<ToolDescription>::new());
    for index in 0..lines.len() {
        let content = &source[lines.content(index)];
        let Some(open) = content.iter().position(|byte| matches!(byte, b'(' | b';')) else { continue };
        let is_end = |byte: &u8| content[open] == b'(' && *byte == b')';
        let Some(comment) = content[open + 1..].split(is_end).next() else { continue };
        let Some(tool) = parse(&String::from_utf8_lossy(comment), unit) else { continue };
        if !found.iter().any(|own| ToolDescription { line: None, ..own.clone() } == tool) {
            found.push(ToolDescription { line: Some(index + 1), ..tool });
        }
    }
    found
}

/// Returns the tool that a comment describes in one of the forms above; `None` for other comments.
fn parse(comment: &str, unit: Option<LengthUnit>) -> Option<ToolDescription> {
    let comment = comment.trim();
    autodesk(comment, unit)
        .or_else(|| open_builds(comment))
        .or_else(|| vectric(comment))
        .or_else(|| mastercam(comment, unit))
}

fn autodesk(comment: &str, unit: Option<LengthUnit>) -> Option<ToolDescription> {
    let (number, rest) = leading_integer(comment.strip_prefix(['T', '#'])?)?;
    // Between number and diameter some posts write a name.
    let (_, rest) = rest.split_once(" D=")?;
    let mut parts = rest.split(" - ");
    let mut words = parts.next()?.split_whitespace();
    let mm = |length: f64| unit.map(|unit| length * unit.mm());
    let diameter_mm = mm(number_alone(words.next()?)?);
    let mut tool = ToolDescription { number, diameter_mm, ..ToolDescription::default() };
    let (mut corner_mm, mut taper_deg) = (None, None);
    for word in words {
        if let Some(corner) = word.strip_prefix("CR=") {
            corner_mm = mm(number_alone(corner)?);
        } else if let Some(taper) = word.strip_prefix("TAPER=") {
            taper_deg = Some(number_alone(taper.trim_end_matches("deg"))?);
        }
    }
    tool.shape = parts.find_map(|part| type_of(part, |part, name| part == name));
    settle(&mut tool, corner_mm, taper_deg);
    Some(tool)
}

fn open_builds(comment: &str) -> Option<ToolDescription> {
    let rest = comment.strip_prefix("Tool")?.trim_start().trim_start_matches(['#', '(']);
    let (number, rest) = leading_integer(rest)?;
    let (name, size) = rest.trim_start_matches(')').strip_prefix(':')?.split_once(" Flutes, Diam = ")?;
    let (name, teeth) = name.trim().rsplit_once(' ')?;
    let (size, its_unit) = leading_number(size)?;
    let mut tool = ToolDescription {
        number,
        diameter_mm: Some(size * own_unit(its_unit)?.mm()),
        teeth: teeth.parse().ok().filter(|teeth| *teeth > 0),
        shape: type_of(name, |name, known| name == known),
        ..ToolDescription::default()
    };
    settle(&mut tool, None, None);
    Some(tool)
}

fn vectric(comment: &str) -> Option<ToolDescription> {
    let (number, rest) = leading_integer(comment.strip_prefix('T').unwrap_or(comment))?;
    let (name, size) = rest.trim_start().strip_prefix('=')?.split_once('{')?;
    let mut words = size.split_once('}')?.0.split_whitespace();
    // A V-bit has an angle before its size, or instead of it.
    let mut diameter_mm = None;
    while let Some((size, rest)) = words.next().and_then(leading_number) {
        let its_unit = if rest.is_empty() { words.next().unwrap_or_default() } else { rest };
        if !its_unit.starts_with("deg") {
            diameter_mm = own_unit(its_unit).map(|unit| size * unit.mm());
        }
    }
    let mut tool = ToolDescription { number, diameter_mm, ..ToolDescription::default() };
    tool.shape = type_of(name, |name, known| name == known);
    settle(&mut tool, None, None);
    Some(tool)
}

fn mastercam(comment: &str, unit: Option<LengthUnit>) -> Option<ToolDescription> {
    let (number, name, size) = match comment.split_once("TOOL - ") {
        Some((name, rest)) if rest.contains("DIA. OFF.") => {
            (leading_integer(rest)?.0, name.trim(), number_alone(rest.rsplit_once(" DIA. - ")?.1)?)
        }
        _ => {
            let (number, rest) = leading_integer(comment.strip_prefix('T')?)?;
            let name = rest.trim_start().strip_prefix('|')?.split_once('|')?.0.trim();
            (number, name, leading_fraction(name)?.0)
        }
    };
    let typed = leading_fraction(name).map_or(name, |(_, rest)| rest);
    let shape = type_of(typed, |own, known| {
        own.strip_prefix(known).is_some_and(|rest| !rest.starts_with(char::is_alphabetic))
    })?;
    let diameter_mm = unit.map(|unit| size * unit.mm());
    let mut tool = ToolDescription { number, diameter_mm, shape: Some(shape), ..ToolDescription::default() };
    settle(&mut tool, None, None);
    Some(tool)
}

/// Gives `tool` the corner or the point that its shape has, both where its shape is not said; a mill with a taper has none of the shapes, and one without a
/// corner is flat.
fn settle(tool: &mut ToolDescription, corner_mm: Option<f64>, taper_deg: Option<f64>) {
    match tool.shape {
        Some(Ok(ToolShape::Drill)) => tool.point_angle_deg = taper_deg,
        Some(Ok(_)) if taper_deg.is_some_and(|taper| taper != 0.0) => tool.shape = Some(Err("tapered mill")),
        Some(Ok(ToolShape::Flat | ToolShape::BullNose)) => match corner_mm {
            Some(0.0) => tool.shape = Some(Ok(ToolShape::Flat)),
            Some(corner) => {
                (tool.shape, tool.corner_radius_mm) = (Some(Ok(ToolShape::BullNose)), Some(corner));
            }
            None => {}
        },
        Some(_) => {}
        None => (tool.corner_radius_mm, tool.point_angle_deg) = (corner_mm, taper_deg),
    }
}

/// Returns the shape of a tool with a name that `matches` one of those above, both in lower case.
fn type_of(name: &str, matches: impl Fn(&str, &str) -> bool) -> Option<Result<ToolShape, &'static str>> {
    let name = name.trim().to_lowercase();
    let is_one = |known: &&str| matches(&name, known);
    let shape = NAMES.iter().find(|(_, known)| known.split('|').any(|known| is_one(&known)));
    shape.map(|(shape, _)| Ok(*shape)).or_else(|| OTHERS.split('|').find(is_one).map(Err))
}

/// Returns the unit that the text behind a length begins with; `None` if neither mm nor inches.
fn own_unit(text: &str) -> Option<LengthUnit> {
    match &text[..text.bytes().take_while(u8::is_ascii_alphabetic).count()] {
        "mm" => Some(LengthUnit::Millimetre),
        "in" | "inch" | "inches" => Some(LengthUnit::Inch),
        "" if text.starts_with('"') => Some(LengthUnit::Inch),
        _ => None,
    }
}

/// Splits digits from the start of `text`; `None` without any, or for too large a number.
fn leading_integer(text: &str) -> Option<(u32, &str)> {
    let end = text.bytes().take_while(u8::is_ascii_digit).count();
    Some((text[..end].parse().ok()?, &text[end..]))
}

/// Splits a decimal number, positive or zero, from the start of `text`; `None` without one.
fn leading_number(text: &str) -> Option<(f64, &str)> {
    let text = text.trim_start_matches('+');
    let end = text.bytes().take_while(|byte| byte.is_ascii_digit() || *byte == b'.').count();
    Some((text[..end].parse().ok()?, &text[end..]))
}

/// Returns the decimal number that `text` is, nothing more; `None` for other text, such as `10,5`.
fn number_alone(text: &str) -> Option<f64> {
    leading_number(text.trim()).filter(|(_, rest)| rest.is_empty()).map(|(number, _)| number)
}

/// Splits a decimal number or a fraction (`1/2`) from the start of `text`, and the blanks behind it; `None` without one, or where it divides by 0.
fn leading_fraction(text: &str) -> Option<(f64, &str)> {
    let (number, rest) = leading_number(text)?;
    let Some((divisor, rest)) = rest.strip_prefix('/').and_then(leading_number) else {
        return Some((number, rest.trim_start()));
    };
    (divisor > 0.0).then(|| (number / divisor, rest.trim_start()))
}
