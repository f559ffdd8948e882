//! Motions of RAPID: `MoveL p10,v100,z10,tool1\WObj:=wobj1;`, `MoveC`, `MoveJ`, `MoveAbsJ`.

use std::ops::Range;

use nalgebra::Isometry3;

use crate::toolpath::{
    model::{
        robot::{Component, Frames, Kind, Number, RobotFault, Statement, Target},
        shortest,
    },
    read::{
        robot::{
            Base, Tool,
            rapid::{
                Reader,
                data::{self, Type},
                lex::{self, Unit},
            },
            trimmed,
        },
        scan::Scan,
    },
};

/// Decimals of a position that an offset is added to.
const OFFSET_DECIMALS: u8 = 3;

/// Velocities that every controller has, mm/s: `v5` … `v7000`.
const SPEEDS: [u32; 25] = [
    5, 10, 20, 30, 40, 50, 60, 80, 100, 150, 200, 300, 400, 500, 600, 800, 1000, 1500, 2000, 2500, 3000, 4000, 5000,
    6000, 7000,
];

impl Reader<'_> {
    pub(crate) fn motion(&mut self, unit: &Unit) -> Result<Statement, RobotFault> {
        self.check_runs_once()?;
        let keyword = unit.at.start..unit.at.start + unit.word.len();
        let inside = keyword.end..unit.at.end - 1;
        let mut arguments = lex::arguments(&self.source[inside.clone()], inside.start);
        // MoveL \Conc, p10, …
        if self.source[arguments[0].clone()].trim_ascii_start().starts_with(b"\\") {
            arguments.remove(0);
        }
        let kind = match unit.word.as_str() {
            "MOVEL" => Kind::Line,
            "MOVEC" => Kind::Circle,
            _ => Kind::PointToPoint,
        };
        let mut statement = Statement {
            at: unit.at.clone(),
            line: unit.line,
            keyword,
            suffix: unit.at.end..unit.at.end,
            kind,
            via: None,
            end: None,
            sweep_rad: None,
            is_step: false,
            frames: Frames::default(),
            feed_mm_per_min: None,
            spindle_rev_per_min: None,
            tool: None,
        };
        if unit.word == "MOVEABSJ" {
            return Ok(statement);
        }
        let targets = if kind == Kind::Circle { 2 } else { 1 };
        if arguments.len() != targets + 3 {
            return Err(RobotFault::Form {
                expected: "point, speed, zone and tool (MoveC: point on the circle, end, speed, zone, tool)",
            });
        }
        let end = self.target(arguments[targets - 1].clone())?;
        statement.suffix = end.at.end..unit.at.end;
        statement.end = Some(end);
        if kind == Kind::Circle {
            statement.via = Some(self.target(arguments[0].clone())?);
        }
        statement.feed_mm_per_min = self.speed(arguments[targets].clone())?.map(|speed| speed * 60.0);
        let (base, tool) = self.frames(arguments[targets + 2].clone())?;
        statement.frames =
            Frames { base: self.bases.pose(Some(&base))?, tool: self.tools.rotation(Some(&tool))?, unit_mm: 1.0 };
        Ok(statement)
    }

    /// The expression of an argument, and its options: `\WObj:=w`.
    fn parts(&self, argument: Range<usize>) -> (Range<usize>, Vec<String>) {
        let text = &self.source[argument.clone()];
        let slash = lex::code(text).find(|(_, byte)| *byte == b'\\').map_or(text.len(), |(at, _)| at);
        let options = String::from_utf8_lossy(&text[slash..]).to_ascii_uppercase();
        let blank = |c: char| !c.is_ascii_whitespace();
        let options: String = options.chars().filter(|c| blank(*c)).collect();
        let options = options.split('\\').filter(|option| !option.is_empty()).map(str::to_owned).collect();
        (trimmed(self.source, argument.start..argument.start + slash), options)
    }

    fn target(&self, argument: Range<usize>) -> Result<Target, RobotFault> {
        let (at, options) = self.parts(argument);
        if !options.is_empty() {
            return Err(RobotFault::NotFollowed { what: "synchronised motions (\\ID) are", expected: "none" });
        }
        let mut scan = Scan::new(&self.source[at.clone()]);
        let mut ahead = scan;
        let (text, numbers) = match ahead.name().0.eq_ignore_ascii_case("Offs") {
            true => {
                let found = self.offset(&mut ahead)?;
                scan = ahead;
                found
            }
            false => self.pose(&mut scan)?,
        };
        if scan.is_done() { Ok(Target { at, text, numbers }) } else { Err(POINT) }
    }

    /// A target in brackets, or by its name.
    fn pose(&self, scan: &mut Scan<'_>) -> Result<(Vec<u8>, Vec<Number>), RobotFault> {
        if scan.next() == Some(b'[') {
            let rest = scan.rest();
            let mut depth = 0usize;
            let close = lex::code(rest).find(|(_, byte)| {
                depth = depth + usize::from(*byte == b'[') - usize::from(*byte == b']' && depth > 0);
                depth == 0
            });
            let end = close.map_or(rest.len(), |(at, _)| at + 1);
            scan.at += end;
            return Ok((rest[..end].to_vec(), data::target(&rest[..end])?));
        }
        let name = scan.name().0.to_ascii_uppercase();
        match name.as_str() {
            "" => return Err(POINT),
            "RELTOOL" | "OFFS" | "CROBT" | "CALCROBT" | "ORIENTZYX" => {
                return Err(RobotFault::NotFollowed {
                    what: "computed targets are",
                    expected: "a target, or Offs of one",
                });
            }
            _ => {}
        }
        if scan.takes(b'{') {
            return Err(RobotFault::NotFollowed {
                what: "arrays of targets are",
                expected: "a target with a name of its own",
            });
        }
        let known = self.data.as_ref().map_or(Ok(None), |data| data.find(self.source, Type::Target, &name))?;
        let written = known.ok_or(RobotFault::NoPoint { name, beside: String::new() })?;
        Ok((written.to_vec(), data::target(written)?))
    }

    /// What follows Offs, `(p10,1,2,3)`, as a target of its own.
    fn offset(&self, scan: &mut Scan<'_>) -> Result<(Vec<u8>, Vec<Number>), RobotFault> {
        scan.expect(b'(', "( behind Offs")?;
        let (mut written, mut numbers) = self.pose(scan)?;
        for axis in 0..3 {
            scan.expect(b',', ", and three plain numbers in Offs")?;
            let (step, _) = scan.number()?;
            let number =
                numbers.iter().position(|number| number.component == Component::Position(axis)).ok_or(POINT)?;
            let (at, value) = (numbers[number].at.clone(), numbers[number].value + step);
            let shown = shortest(value, OFFSET_DECIMALS);
            let longer = shown.len() as isize - at.len() as isize;
            written.splice(at.clone(), shown.bytes());
            for other in numbers.iter_mut().filter(|other| other.at.start > at.start) {
                other.at = other.at.start.wrapping_add_signed(longer)..other.at.end.wrapping_add_signed(longer);
            }
            numbers[number] = Number {
                at: at.start..at.start + shown.len(),
                value: shown.parse().unwrap_or(value),
                ..numbers[number].clone()
            };
        }
        scan.expect(b')', ") behind three plain numbers in Offs")?;
        Ok((written, numbers))
    }

    /// mm/s; `None` if it is not known.
    fn speed(&self, argument: Range<usize>) -> Result<Option<f64>, RobotFault> {
        let (at, options) = self.parts(argument);
        for option in &options {
            if let Some(speed) = option.strip_prefix("V:=") {
                return Ok(speed.parse().ok().filter(|speed| *speed > 0.0 && self.speeds_hold));
            }
        }
        if !options.is_empty() {
            return Err(RobotFault::NotFollowed { what: "times of motions (\\T) are", expected: "a speed" });
        }
        let text = &self.source[at];
        let speed = if text.starts_with(b"[") {
            Some(data::speed(text)?)
        } else {
            let name = String::from_utf8_lossy(text).to_ascii_uppercase();
            let declared = self.data.as_ref().and_then(|data| data.find(self.source, Type::Speed, &name).ok()?);
            let standard = name.strip_prefix('V').and_then(|speed| speed.parse().ok());
            let standard = standard.filter(|speed: &u32| SPEEDS.contains(speed)).map(f64::from);
            declared.map(data::speed).transpose()?.or(standard)
        };
        Ok(speed.filter(|speed| *speed > 0.0 && self.speeds_hold))
    }

    /// Work object and tool.
    fn frames(&self, argument: Range<usize>) -> Result<(Base, Tool), RobotFault> {
        let (at, options) = self.parts(argument);
        let mut base = Base { name: "wobj0".into(), in_world: Some(Isometry3::identity()) };
        for option in &options {
            match option.split_once(":=") {
                Some(("WOBJ", "WOBJ0")) | Some(("TLOAD", _)) => {}
                Some(("WOBJ", name)) => {
                    let in_world = self.declared(Type::WorkObject, name)?.map(data::work_object_frame).transpose()?;
                    base = Base { name: name.to_ascii_lowercase(), in_world };
                }
                _ => {
                    return Err(RobotFault::NotFollowed {
                        what: "options other than \\WObj and \\TLoad are",
                        expected: "none",
                    });
                }
            }
        }
        let name = String::from_utf8_lossy(&self.source[at]).to_ascii_uppercase();
        let in_flange = match name.as_str() {
            "TOOL0" => Some(Isometry3::identity()),
            _ => self.declared(Type::Tool, &name)?.map(data::tool_frame).transpose()?,
        };
        Ok((base, Tool { name: name.to_ascii_lowercase(), in_flange }))
    }

    fn declared(&self, kind: Type, name: &str) -> Result<Option<&[u8]>, RobotFault> {
        self.data.as_ref().map_or(Ok(None), |data| data.find(self.source, kind, name))
    }
}

const POINT: RobotFault =
    RobotFault::Form { expected: "a target: its name, Offs(…), or [[x,y,z],[q1,q2,q3,q4],[…],[…]]" };
