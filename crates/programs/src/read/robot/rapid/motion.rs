//! Motions of RAPID: `MoveL p10,v100,z10,tool1\WObj:=wobj1;`, `MoveC`, `MoveJ`, `MoveAbsJ`.

use std::ops::Range;

use nalgebra::Isometry3;

use crate::{
    model::{
        format_shortest,
        robot::{Component, Frames, MotionKind, Number, RobotFault, Statement, Target},
    },
    read::{
        robot::{
            Base, Tool, check_index,
            rapid::{
                Reader,
                data::{self, DataType},
                lex::{self, CodeUnit},
            },
            trimmed,
        },
        scan::Scan,
    },
};

/// Decimals of a position with an added offset.
const OFFSET_DECIMALS: u8 = 3;

/// Predefined velocities, mm/s: `v5` … `v7000`.
const SPEEDS: [u32; 25] = [
    5, 10, 20, 30, 40, 50, 60, 80, 100, 150, 200, 300, 400, 500, 600, 800, 1000, 1500, 2000, 2500, 3000, 4000, 5000,
    6000, 7000,
];

/// Radii of the zones `z0` (0.3 mm), `z1`, `z5`, … `z200`, mm.
const ZONES: [f64; 14] = [0.3, 1.0, 5.0, 10.0, 15.0, 20.0, 30.0, 40.0, 50.0, 60.0, 80.0, 100.0, 150.0, 200.0];

impl Reader<'_> {
    /// Returns the statement of MoveL, MoveC, MoveJ or MoveAbsJ with its poses, frames and feed; `Err` if it is not followed.
    pub(crate) fn motion(&mut self, unit: &CodeUnit) -> Result<Statement, RobotFault> {
        self.check_runs_once()?;
        let keyword = unit.at.start..unit.at.start + unit.word.len();
        let inside = keyword.end..unit.at.end - 1;
        let mut arguments = lex::split_arguments(&self.source[inside.clone()], inside.start);
        // MoveL \Conc, p10, …
        if self.source[arguments[0].clone()].trim_ascii_start().starts_with(b"\\") {
            arguments.remove(0);
        }
        let kind = match unit.word.as_str() {
            "MOVEL" => MotionKind::Line,
            "MOVEC" => MotionKind::Circle,
            _ => MotionKind::PointToPoint,
        };
        let mut statement = Statement::new(unit.at.clone(), unit.line, keyword, kind);
        statement.is_posture_open = self.is_posture_open[usize::from(kind == MotionKind::PointToPoint)];
        if unit.word == "MOVEABSJ" {
            statement.joints = self.joints(arguments[0].clone());
            return Ok(statement);
        }
        let targets = if kind == MotionKind::Circle { 2 } else { 1 };
        if arguments.len() != targets + 3 {
            return Err(RobotFault::Form {
                expected: "point, speed, zone and tool (MoveC: point on the circle, end, speed, zone, tool)",
            });
        }
        let end = self.target(arguments[targets - 1].clone())?;
        statement.suffix = end.at.end..unit.at.end;
        statement.end = Some(end);
        if kind == MotionKind::Circle {
            statement.via = Some(self.target(arguments[0].clone())?);
        }
        statement.feed_mm_per_min = self.speed_mm_per_s(arguments[targets].clone())?.map(|speed| speed * 60.0);
        statement.blend_mm = self.blend_mm(arguments[targets + 1].clone());
        let (base, tool) = self.base_and_tool(arguments[targets + 2].clone())?;
        statement.frames =
            Frames { base: self.bases.pose(Some(&base))?, tool: self.tools.rotation(Some(&tool))?, unit_mm: 1.0 };
        Ok(statement)
    }

    /// Returns the range of the expression of an argument, and its options in upper case without blanks: `WOBJ:=W`.
    fn expression_and_options(&self, argument: Range<usize>) -> (Range<usize>, Vec<String>) {
        let text = &self.source[argument.clone()];
        let slash = lex::option_start(text);
        let options = String::from_utf8_lossy(&text[slash..]).to_ascii_uppercase();
        let blank = |c: char| !c.is_ascii_whitespace();
        let options: String = options.chars().filter(|c| blank(*c)).collect();
        let options = options.split('\\').filter(|option| !option.is_empty()).map(str::to_owned).collect();
        (trimmed(self.source, argument.start..argument.start + slash), options)
    }

    /// Returns the target of an argument: in brackets, by name, or Offs of one.
    fn target(&self, argument: Range<usize>) -> Result<Target, RobotFault> {
        let (at, options) = self.expression_and_options(argument);
        if !options.is_empty() {
            return RobotFault::not_followed("synchronised motions (\\ID) are", "none");
        }
        let mut scan = Scan::new(&self.source[at.clone()]);
        let mut ahead = scan;
        let (text, numbers) = match ahead.name().0.eq_ignore_ascii_case("Offs") {
            true => {
                let found = self.offset_target(&mut ahead)?;
                scan = ahead;
                found
            }
            false => self.target_value(&mut scan)?,
        };
        if scan.is_done() { Ok(Target { at, text, numbers }) } else { Err(POINT) }
    }

    /// Takes a target in brackets or by name; returns its text, and its numbers with their ranges in it.
    fn target_value(&self, scan: &mut Scan<'_>) -> Result<(Vec<u8>, Vec<Number>), RobotFault> {
        if scan.next() == Some(b'[') {
            let rest = scan.rest();
            let mut depth = 0usize;
            let close = lex::code_bytes(rest).find(|(_, byte)| {
                depth = depth + usize::from(*byte == b'[') - usize::from(*byte == b']' && depth > 0);
                depth == 0
            });
            let end = close.map_or(rest.len(), |(at, _)| at + 1);
            scan.at += end;
            return Ok((rest[..end].to_vec(), data::parse_target(&rest[..end])?));
        }
        let name = scan.name().0.to_ascii_uppercase();
        match name.as_str() {
            "" => return Err(POINT),
            "RELTOOL" | "OFFS" | "CROBT" | "CALCROBT" | "ORIENTZYX" => {
                return RobotFault::not_followed("computed targets are", "a target, or Offs of one");
            }
            _ => {}
        }
        if scan.takes(b'{') {
            return RobotFault::not_followed("arrays of targets are", "a target with a name of its own");
        }
        let known = self
            .data
            .as_ref()
            .map_or(Ok(None), |data| data.find(self.source, DataType::Target, &name, self.routine.0))?;
        let written = known.ok_or(RobotFault::NoPoint { name, beside: String::new() })?;
        Ok((written.to_vec(), data::parse_target(written)?))
    }

    /// Takes `(p10,1,2,3)` behind Offs; returns the text and numbers of the target with the offset added.
    fn offset_target(&self, scan: &mut Scan<'_>) -> Result<(Vec<u8>, Vec<Number>), RobotFault> {
        scan.expect(b'(', "( behind Offs")?;
        let (mut written, mut numbers) = self.target_value(scan)?;
        for axis in 0..3 {
            scan.expect(b',', ", and three plain numbers in Offs")?;
            let (step, _) = scan.number()?;
            let number =
                numbers.iter().position(|number| number.component == Component::Position(axis)).ok_or(POINT)?;
            let (at, value) = (numbers[number].at.clone(), numbers[number].value + step);
            let text = format_shortest(value, OFFSET_DECIMALS);
            let growth = text.len() as isize - at.len() as isize;
            written.splice(at.clone(), text.bytes());
            for other in numbers.iter_mut().filter(|other| other.at.start > at.start) {
                other.at = other.at.start.wrapping_add_signed(growth)..other.at.end.wrapping_add_signed(growth);
            }
            numbers[number] = Number {
                at: at.start..at.start + text.len(),
                value: text.parse().unwrap_or(value),
                ..numbers[number].clone()
            };
        }
        scan.expect(b')', ") behind three plain numbers in Offs")?;
        Ok((written, numbers))
    }

    /// Returns the angles of a joint target, rad, in brackets or by name; `None` if the module does not give them.
    fn joints(&self, argument: Range<usize>) -> Option<[f32; 6]> {
        let (at, _) = self.expression_and_options(argument);
        let text = &self.source[at];
        let name = String::from_utf8_lossy(text).to_ascii_uppercase();
        let text = if text.starts_with(b"[") { Some(text) } else { self.datum(DataType::Joints, &name).ok()? };
        data::parse_joints(text?).ok()
    }

    /// Returns the velocity of the tip that an argument gives, mm/s; `None` if it is unknown.
    fn speed_mm_per_s(&self, argument: Range<usize>) -> Result<Option<f64>, RobotFault> {
        let (at, options) = self.expression_and_options(argument);
        for option in &options {
            if let Some(speed) = option.strip_prefix("V:=") {
                return Ok(speed.parse().ok().filter(|speed| *speed > 0.0 && self.is_speed_unscaled));
            }
        }
        if !options.is_empty() {
            return RobotFault::not_followed("times of motions (\\T) are", "a speed");
        }
        let text = &self.source[at];
        let speed = if text.starts_with(b"[") {
            Some(data::parse_speed(text)?)
        } else {
            let name = String::from_utf8_lossy(text).to_ascii_uppercase();
            let declared = self
                .data
                .as_ref()
                .and_then(|data| data.find(self.source, DataType::Speed, &name, self.routine.0).ok()?);
            let standard = name.strip_prefix('V').and_then(|speed| speed.parse().ok());
            let standard = standard.filter(|speed: &u32| SPEEDS.contains(speed)).map(f64::from);
            declared.map(data::parse_speed).transpose()?.or(standard)
        };
        Ok(speed.filter(|speed| *speed > 0.0 && self.is_speed_unscaled))
    }

    /// Returns the radius of the zone that an argument gives, mm; infinite if unknown, `None` for a stop at the point.
    fn blend_mm(&self, argument: Range<usize>) -> Option<f64> {
        let (at, options) = self.expression_and_options(argument);
        let given = options.iter().find_map(|option| option.strip_prefix("Z:=")?.parse().ok());
        given.or_else(|| zone_radius_mm(&String::from_utf8_lossy(&self.source[at]).to_ascii_uppercase()))
    }

    /// Returns the work object and the tool that the last argument of a motion names.
    fn base_and_tool(&self, argument: Range<usize>) -> Result<(Base, Tool), RobotFault> {
        let (at, options) = self.expression_and_options(argument);
        let stands = self.options.is_tool_stationary;
        let mut base = Base { name: "wobj0".into(), in_world: Some(Isometry3::identity()) };
        for option in &options {
            match option.split_once(":=") {
                Some(("WOBJ", "WOBJ0")) | Some(("TLOAD", _)) => {}
                Some(("WOBJ", name)) => {
                    check_index(name, '{', '}')?;
                    let datum = self.datum(DataType::WorkObject, name)?;
                    let in_world = datum.map(|text| data::work_object_frame(text, stands)).transpose()?;
                    base = Base { name: name.to_ascii_lowercase(), in_world };
                }
                _ => {
                    return RobotFault::not_followed("options other than \\WObj and \\TLoad are", "none");
                }
            }
        }
        let name = String::from_utf8_lossy(&self.source[at]).to_ascii_uppercase();
        check_index(&name, '{', '}')?;
        if stands && base.name == "wobj0" {
            return RobotFault::not_followed(
                "motions in wobj0 with a stationary tool are",
                "a work object that the robot holds",
            );
        }
        let in_flange = match name.as_str() {
            "TOOL0" if stands => return Err(data::HELD),
            "TOOL0" => Some(Isometry3::identity()),
            _ => self.datum(DataType::Tool, &name)?.map(|text| data::tool_frame(text, stands)).transpose()?,
        };
        if stands && in_flange.is_none() {
            return RobotFault::not_followed(
                "tools that stand and are not declared in the module are",
                "a tooldata with its numbers",
            );
        }
        Ok((base, Tool { name: name.to_ascii_lowercase(), in_flange }))
    }

    /// Returns the text of the datum `name` of type `kind`, if the module declares it.
    fn datum(&self, kind: DataType, name: &str) -> Result<Option<&[u8]>, RobotFault> {
        self.data.as_ref().map_or(Ok(None), |data| data.find(self.source, kind, name, self.routine.0))
    }
}

/// Fault of an argument that is no target.
const POINT: RobotFault =
    RobotFault::Form { expected: "a target: its name, Offs(…), or [[x,y,z],[q1,q2,q3,q4],[…],[…]]" };

/// Returns the radius of a zone, mm, of its `text` in capitals: infinite if it is declared elsewhere, `None` for fine.
fn zone_radius_mm(text: &str) -> Option<f64> {
    let known = match text.strip_prefix("[FALSE,") {
        _ if text == "FINE" || text.starts_with("[TRUE") => return None,
        Some(rest) => rest.split(',').next().and_then(|radius| radius.trim().parse().ok()),
        None => ZONES.into_iter().find(|radius| text == format!("Z{}", radius.trunc())),
    };
    known.or(Some(f64::INFINITY))
}

/// Returns the zone with a radius of at most `radius_mm`: predefined where one is, or with its numbers.
pub(crate) fn zone_of(radius_mm: f64) -> String {
    match ZONES.into_iter().rfind(|zone| *zone <= radius_mm) {
        Some(radius) => format!("z{}", radius.trunc()),
        None => {
            let [whole, tenth] = [radius_mm, radius_mm / 10.0].map(|r| format!("{:.4}", (r * 1e4).floor() / 1e4));
            format!("[FALSE,{whole},{whole},{whole},{tenth},{whole},{tenth}]")
        }
    }
}
