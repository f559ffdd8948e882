//! Arcs of APT: CIRCLE before the GOTO of its end, and CATIA's INDIRV with TLON,GOFWD.
//!
//! What the axis of CIRCLE means, its writers do not agree on. SolidWorks CAM (`x,y,z,i,j,k`) and Creo (`x,y,z,i,j,k,r`) turn right-handed
//! about it; NX (`x,y,z,i,j,k,r,t,f,d,e`) gives it "assuming a clockwise direction" (NX, CLSF Manager, CIRCLE), so left-handed.

use std::ops::Range;

use nalgebra::Vector3;

use crate::{
    model::robot::{AptCircle, CircleTurn, Component, MotionKind, Number, RobotFault, Statement, Target},
    read::{robot::apt::Reader, scan::Scan},
};

/// A number with its bytes in a record.
type Numeral = (f64, Range<usize>);

impl Reader<'_> {
    /// Reads the record CIRCLE at the bytes `at`, whose words `minor` begin at byte `minor_at`.
    pub(crate) fn circle_record(
        &self,
        at: Range<usize>,
        minor: &[u8],
        minor_at: usize,
    ) -> Result<AptCircle, RobotFault> {
        let (mut scan, mut numbers) = (Scan::new(minor), Vec::new());
        while numbers.is_empty() || scan.takes(b',') {
            if numbers.len() == 11 {
                return RobotFault::not_followed("helices of several turns (TIMES) are", "an arc for each turn");
            }
            numbers.push(scan.number()?);
        }
        let sense = match numbers.len() {
            _ if !scan.is_done() => None,
            6 => Some(1.0),
            7 if self.is_creo => Some(1.0),
            11 => Some(-1.0),
            _ => None,
        };
        let sense = sense.ok_or(RobotFault::Form {
            expected: "x,y,z,i,j,k (SolidWorks CAM), x,y,z,i,j,k,r behind a header of Pro/CLfile (Creo), or x,y,z,i,j,k,r,t,f,d,e (NX)",
        })?;
        let axis = Vector3::new(numbers[3].0, numbers[4].0, numbers[5].0) * sense;
        let axis = axis.try_normalize(1e-6).ok_or(RobotFault::Form { expected: "an axis i,j,k of length 1" })?;
        let (record, turn) = (self.target(&numbers[..3], numbers.get(6), minor_at), CircleTurn::About(axis));
        Ok(AptCircle { record, turn, leading: at.start..self.end_of_line(at.end) })
    }

    /// Returns the motion TLON,GOFWD on line `line`, at the bytes `at` with the text `code`: on `(CIRCLE/x,y,z,r)` or
    /// `(CYLNDR/x,y,z,i,j,k,r)` to the last point of the surface behind `ON` (CATIA V5, circular interpolation in APT output).
    pub(crate) fn circular_motion(
        &mut self,
        at: Range<usize>,
        line: usize,
        code: &[u8],
    ) -> Result<Statement, RobotFault> {
        let expected = RobotFault::Form {
            expected: "TLON,GOFWD/(CIRCLE/x,y,z,r),ON,(LINE/…) or (CYLNDR/x,y,z,i,j,k,r),ON,(PLANE/…) behind INDIRV, outside of cycles and RAPID",
        };
        let Some((direction, leading)) = self.direction.take() else { return Err(expected) };
        let text: String = String::from_utf8_lossy(code).to_ascii_uppercase().split_whitespace().collect();
        let Some((surface, behind)) = text.split_once("),ON,") else { return Err(expected) };
        let (is_second, behind) = behind.strip_prefix("2,INTOF,").map_or((false, behind), |behind| (true, behind));
        let given = match surface {
            _ if self.is_rapid || self.cycle.is_some() => return Err(expected),
            _ if surface.starts_with("TLON,GOFWD/(CIRCLE/") && behind.starts_with("(LINE/") => 4,
            _ if surface.starts_with("TLON,GOFWD/(CYLNDR/") && behind.starts_with("(PLANE/PERPTO,") => 7,
            _ => return Err(expected),
        };
        let numbers = numbers_in(code)?;
        // Two points at least end the motion; before them stands the 2 of INTOF.
        let Some(last) = numbers.len().checked_sub(3).filter(|last| *last >= given + 3 + usize::from(is_second)) else {
            return Err(expected);
        };
        let end = self.target(&numbers[last..], None, at.start);
        let record = self.target(&numbers[..3], numbers.get(given - 1), at.start);
        let turn = CircleTurn::Towards { direction, is_second };
        let keyword = at.start..at.start;
        let mut statement = self.statement(at, line, keyword, MotionKind::Circle);
        let leading = leading.start..self.end_of_line(leading.end);
        statement.apt.circle = Some(AptCircle { record, turn, leading });
        Ok(Statement { end: Some(end), ..statement })
    }

    /// Returns the text of three `coordinates`, whose record begins at byte `start` of the source, as a target, with a `radius` behind them.
    fn target(&self, coordinates: &[Numeral], radius: Option<&Numeral>, start: usize) -> Target {
        let components = (0..3).map(Component::Position).chain([Component::Radius]);
        let numerals = coordinates.iter().chain(radius);
        let first = coordinates[0].1.start;
        let number = |(component, (value, at)): (Component, &Numeral)| Number {
            component,
            at: at.start - first..at.end - first,
            value: *value,
        };
        let numbers: Vec<Number> = components.zip(numerals).map(number).collect();
        let end = numbers.last().map_or(0, |number| number.at.end);
        let at = start + first..start + first + end;
        Target { text: self.source[at.clone()].to_vec(), at, numbers }
    }

    /// Returns where the line that holds byte `at` ends, with its line ending.
    fn end_of_line(&self, at: usize) -> usize {
        let rest = &self.source[at..];
        match rest.iter().position(|byte| matches!(byte, b'\r' | b'\n')) {
            Some(length) => at + length + if rest[length..].starts_with(b"\r\n") { 2 } else { 1 },
            None => self.source.len(),
        }
    }
}

/// Returns the numbers of a record that stand behind `(`, `/` or `,`. `Err` for one that is not plain.
fn numbers_in(code: &[u8]) -> Result<Vec<Numeral>, RobotFault> {
    let mut numbers = Vec::new();
    let mut scan = Scan::new(code);
    while scan.peek().is_some() {
        let is_before = matches!(scan.peek(), Some(b'(' | b'/' | b','));
        scan.at += 1;
        if is_before && scan.next().is_some_and(|byte| byte.is_ascii_digit() || matches!(byte, b'.' | b'+' | b'-')) {
            numbers.push(scan.number()?);
        }
    }
    Ok(numbers)
}
