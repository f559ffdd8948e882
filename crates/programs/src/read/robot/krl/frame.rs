//! Values in braces: `{X 1.5, Y 2, Z 3, A 0, B 90, C 0, E1 10}`, `{A1 0, A2 -90, …}`, `{TOOL_NO 1, BASE_NO 2, …}`.

use std::ops::Range;

use nalgebra::Isometry3;

use crate::{
    model::robot::{Component, Number, RobotFault, Target, rotation_of_abc},
    read::{robot::trimmed, scan::Scan},
};

/// Takes the next braces with all within them, and returns their range in `bytes`.
pub(crate) fn brace_span(scan: &mut Scan<'_>, bytes: &[u8]) -> Result<Range<usize>, RobotFault> {
    let start = scan.skip_blanks().at;
    let mut depth = 0usize;
    for (at, byte) in bytes.iter().enumerate().skip(start) {
        match byte {
            b'{' => depth += 1,
            b'}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth == 0 {
            scan.at = at + 1;
            return if at > start { Ok(start..at + 1) } else { Err(RobotFault::Form { expected: "{" }) };
        }
    }
    Err(RobotFault::Form { expected: "} on the same line" })
}

/// Value of a point: a pose, or joint positions.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    Pose(Vec<Number>),
    Joints([f32; 6]),
}

/// Parses a point in braces; numbers have their ranges in `text`.
pub(crate) fn parse_point(text: &[u8]) -> Result<Value, RobotFault> {
    let (mut numbers, mut joints) = (Vec::new(), None::<[f32; 6]>);
    for_all(text, |name, scan| {
        let name = name.to_ascii_uppercase();
        if matches!(name.as_str(), "S" | "T") {
            let start = scan.skip_blanks().at;
            skip_value(scan)?;
            let at = trimmed(text, start..scan.at);
            // What is computed says nothing here.
            let number = status_number(&text[at.clone()]).map(f64::from);
            let component = Component::Arm(usize::from(name == "T"));
            numbers.extend(number.map(|value| Number { component, at, value }));
            return Ok(());
        }
        let (value, at) = scan.number()?;
        let index = |letter: char, most: usize| {
            let index = name.strip_prefix(letter)?.parse::<usize>().ok()?.checked_sub(1)?;
            (index < most).then_some(index)
        };
        let axis = |names: [&str; 3]| names.iter().position(|known| *known == name);
        let component = if let Some(axis) = axis(["X", "Y", "Z"]) {
            Component::Position(axis)
        } else if let Some(angle) = axis(["A", "B", "C"]) {
            Component::Rotation(angle)
        } else if let Some(axis) = index('E', 6) {
            Component::External(axis)
        } else if let Some(axis) = index('A', 6) {
            joints.get_or_insert([0.0; 6])[axis] = value.to_radians() as f32;
            return Ok(());
        } else {
            return Err(RobotFault::Form { expected: "X Y Z A B C S T E1 … E6, or A1 … A6" });
        };
        if numbers.iter().any(|number: &Number| number.component == component) {
            return Err(RobotFault::Form { expected: "each component once" });
        }
        numbers.push(Number { component, at, value });
        Ok(())
    })?;
    let is_of_pose = |number: &Number| matches!(number.component, Component::Position(_) | Component::Rotation(_));
    match (joints, numbers.iter().any(is_of_pose)) {
        (Some(_), true) => Err(RobotFault::Form { expected: "a pose or positions of joints, not both" }),
        (Some(joints), false) => Ok(Value::Joints(joints)),
        (None, _) => Ok(Value::Pose(numbers)),
    }
}

/// Parses a status or a turn, which may be binary: `'B110'`; `None` for other text, and above 255.
fn status_number(text: &[u8]) -> Option<u8> {
    let text = std::str::from_utf8(text).ok()?;
    match text.strip_prefix('\'').and_then(|rest| rest.strip_suffix('\'')) {
        Some(digits) => u8::from_str_radix(digits.strip_prefix(['B', 'b'])?, 2).ok(),
        None => text.parse().ok(),
    }
}

/// Parses a frame in braces, which must have all of X, Y, Z (mm), A, B, C (degrees).
pub(crate) fn parse_frame(text: &[u8]) -> Result<Isometry3<f64>, RobotFault> {
    let expected = RobotFault::Form { expected: "numbers for X, Y, Z, A, B and C" };
    let Value::Pose(numbers) = parse_point(text)? else { return Err(expected) };
    let target = Target { at: 0..0, text: Vec::new(), numbers };
    let all = |component: fn(usize) -> Component| -> Option<[f64; 3]> {
        Some([target.number(component(0))?, target.number(component(1))?, target.number(component(2))?])
    };
    let (Some([x, y, z]), Some(abc)) = (all(Component::Position), all(Component::Rotation)) else {
        return Err(expected);
    };
    Ok(Isometry3::from_parts(nalgebra::Translation3::new(x, y, z), rotation_of_abc(abc)))
}

/// Parses the numbers of tool and base in `{TOOL_NO 1, BASE_NO 2, IPO_FRAME #BASE}`.
pub(crate) fn frame_numbers(text: &[u8]) -> Result<[Option<usize>; 2], RobotFault> {
    let mut found = [None; 2];
    for_all(text, |name, scan| {
        let which = ["TOOL_NO", "BASE_NO"].iter().position(|known| name.eq_ignore_ascii_case(known));
        let Some(which) = which else {
            let start = scan.skip_blanks().at;
            skip_value(scan)?;
            let value = &text[start..scan.at];
            if name.eq_ignore_ascii_case("IPO_FRAME") && !value.trim_ascii().eq_ignore_ascii_case(b"#BASE") {
                return Err(super::FIXED_TOOL);
            }
            return Ok(());
        };
        let (value, _) = scan.number()?;
        found[which] = Some(value).filter(|value| *value >= 0.0 && value.fract() == 0.0).map(|value| value as usize);
        Ok(())
    })?;
    Ok(found)
}

/// Passes each name in the braces `text` to `take`, which reads its value from the cursor.
fn for_all(text: &[u8], mut take: impl FnMut(&str, &mut Scan<'_>) -> Result<(), RobotFault>) -> Result<(), RobotFault> {
    let mut scan = Scan::new(text);
    scan.expect(b'{', "{")?;
    // The type may be named: {E6POS: X 1, …}.
    let mut ahead = scan;
    if !ahead.name().0.is_empty() && ahead.takes(b':') {
        scan = ahead;
    }
    if scan.takes(b'}') {
        return Ok(());
    }
    loop {
        let (name, _) = scan.name();
        if name.is_empty() {
            return Err(RobotFault::Form { expected: "a name and a number, such as X 10.5" });
        }
        if scan.takes(b'[') {
            scan.expect(b']', "]")?;
        }
        take(name, &mut scan)?;
        if scan.takes(b'}') {
            return Ok(());
        }
        scan.expect(b',', ", or } behind a plain number")?;
    }
}

/// Skips a value up to the next comma or brace; strings and nested braces count as one.
fn skip_value(scan: &mut Scan<'_>) -> Result<(), RobotFault> {
    let (mut depth, mut in_text) = (0usize, false);
    while let Some(byte) = scan.peek() {
        match byte {
            b'"' => in_text = !in_text,
            b'{' if !in_text => depth += 1,
            b',' | b'}' if depth == 0 && !in_text => return Ok(()),
            b'}' if !in_text => depth -= 1,
            _ => {}
        }
        scan.at += 1;
    }
    Err(RobotFault::Form { expected: "} on the same line" })
}
