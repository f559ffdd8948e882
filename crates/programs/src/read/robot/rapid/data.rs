//! Data of a RAPID module: targets, tools, work objects and speeds, declared or written in place.

use std::{
    collections::{BTreeSet, HashMap},
    ops::Range,
};

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};

use crate::{
    model::robot::{Component, Number, RobotFault},
    read::{
        robot::{
            LocatedFault,
            rapid::{
                calls,
                lex::{CodeUnit, CodeUnits, one_line_statement},
            },
            trimmed,
        },
        scan::Scan,
    },
};

/// External axes at or above this are not in use (RAPID writes 9E9).
const NOT_USED: f64 = 9e8;

/// Value of a declared name.
#[derive(Clone, Debug)]
enum Value {
    /// The text in these bytes, of this type, in the routines whose heads stand on these lines; 0 is the module.
    Written(DataType, Range<usize>, Vec<usize>),
    /// Unknown to the reader because of this line.
    Computed(usize),
}

/// RAPID types of data that motions use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum DataType {
    Target,
    Tool,
    WorkObject,
    Speed,
    Joints,
}

/// Declarations of a module.
#[derive(Debug, Default)]
pub(crate) struct ModuleData {
    /// By name in upper case.
    values: HashMap<String, Value>,
    /// Names of procedures in upper case.
    pub procedures: Vec<String>,
    /// Names of functions in upper case.
    pub functions: Vec<String>,
    /// Names of routines in upper case that may change what they are given.
    by_reference: BTreeSet<String>,
    /// Line of the head of the routine that is read; 0 outside.
    routine: usize,
}

impl ModuleData {
    /// Reads all declarations of `source`.
    pub fn read(source: &[u8]) -> Result<ModuleData, LocatedFault> {
        let mut data = ModuleData { by_reference: calls::by_reference(source)?, ..ModuleData::default() };
        let mut units = CodeUnits::new(source);
        while let Some(unit) = units.next()? {
            data.add(source, &unit);
        }
        Ok(data)
    }

    /// Adds what `unit` declares, or marks what it assigns as computed.
    fn add(&mut self, source: &[u8], unit: &CodeUnit) {
        let mut scan = Scan::new(&source[unit.at.clone()]);
        let mut word = scan.name().0.to_ascii_uppercase();
        if !unit.is_statement {
            if word == "LOCAL" {
                word = scan.name().0.to_ascii_uppercase();
            }
            match word.as_str() {
                "PROC" => self.procedures.push(scan.name().0.to_ascii_uppercase()),
                "FUNC" => self.functions.extend(calls::name_in(&source[unit.at.clone()])),
                _ => {}
            }
            match word.as_str() {
                "PROC" | "FUNC" | "TRAP" => self.routine = unit.line,
                "ENDPROC" | "ENDFUNC" | "ENDTRAP" => self.routine = 0,
                _ => {}
            }
            return;
        }
        let text = &source[unit.at.clone()];
        if word == "IF" {
            // IF in IF is left to what reads the statement.
            let is_alone = |start: &usize| !Scan::new(&text[*start..]).name().0.eq_ignore_ascii_case("IF");
            match one_line_statement(text).filter(is_alone) {
                Some(start) => self.add(source, &CodeUnit { at: unit.at.start + start..unit.at.end, ..unit.clone() }),
                None => {
                    self.values.extend(calls::names(text).into_iter().map(|name| (name, Value::Computed(unit.line))))
                }
            }
            return;
        }
        // What a routine may change of what it is given.
        if !self.by_reference.is_empty() && !matches!(word.as_str(), "CONST" | "PERS" | "VAR") {
            let (changing, given): (Vec<_>, Vec<_>) =
                calls::names(text).into_iter().partition(|name| self.by_reference.contains(name));
            if !changing.is_empty() {
                let given = given.into_iter().filter(|name| !super::is_motion(name));
                self.values.extend(given.map(|name| (name, Value::Computed(unit.line))));
            }
        }
        while matches!(word.as_str(), "LOCAL" | "TASK") {
            word = scan.name().0.to_ascii_uppercase();
        }
        let is_declared = matches!(word.as_str(), "CONST" | "PERS" | "VAR");
        let kind = if is_declared { scan.name().0.to_ascii_uppercase() } else { String::new() };
        let name = if is_declared { scan.name().0.to_ascii_uppercase() } else { word };
        let kind = match kind.as_str() {
            "ROBTARGET" => Some(DataType::Target),
            "TOOLDATA" => Some(DataType::Tool),
            "WOBJDATA" => Some(DataType::WorkObject),
            "SPEEDDATA" => Some(DataType::Speed),
            "JOINTTARGET" => Some(DataType::Joints),
            _ => None,
        };
        let is_whole = scan.takes(b':') && scan.takes(b'=');
        let value = trimmed(source, unit.at.start + scan.at..unit.at.end - 1);
        let routine = self.routine;
        let before = self.values.get_mut(&name);
        let entry = match (kind, before) {
            // Another one of this name: routines have data of their own.
            (Some(kind), Some(Value::Written(other, text, routines)))
                if *other == kind && source[text.clone()] == source[value.clone()] =>
            {
                routines.push(routine);
                return;
            }
            (Some(kind), None) if is_whole && source[value.clone()].starts_with(b"[") => {
                Value::Written(kind, value, vec![routine])
            }
            (Some(_), _) => Value::Computed(unit.line),
            // An assignment to it or to a part of it.
            (None, Some(_)) if !is_declared && is_assignment(&source[unit.at.clone()]) => Value::Computed(unit.line),
            (None, None) if !is_declared && is_assignment(&source[unit.at.clone()]) => Value::Computed(unit.line),
            _ => return,
        };
        self.values.insert(name, entry);
    }

    /// Returns the text of the datum `name` (upper case) of type `kind` in the routine whose head stands on the line `routine`; `None` if it is not declared
    /// there, `Err` if it is computed.
    pub fn find<'a>(
        &self,
        source: &'a [u8],
        kind: DataType,
        name: &str,
        routine: usize,
    ) -> Result<Option<&'a [u8]>, RobotFault> {
        match self.values.get(name) {
            Some(Value::Written(written, at, routines))
                if *written == kind && routines.iter().any(|line| [0, routine].contains(line)) =>
            {
                Ok(Some(&source[at.clone()]))
            }
            Some(Value::Computed(line)) => Err(RobotFault::Computed { name: name.to_owned(), line: *line }),
            _ => Ok(None),
        }
    }
}

/// Whether `:=` stands in `text` outside strings and comments.
fn is_assignment(text: &[u8]) -> bool {
    super::lex::code_bytes(text).any(|(at, byte)| byte == b':' && text.get(at + 1) == Some(&b'='))
}

/// Takes `[a, b, …]` of `N` plain numbers, and returns each with its range.
fn parse_numbers<const N: usize>(scan: &mut Scan<'_>) -> Result<[(f64, Range<usize>); N], RobotFault> {
    scan.expect(b'[', "[ and plain numbers")?;
    let mut found = std::array::from_fn(|_| (0.0, 0..0));
    for (entry, number) in found.iter_mut().enumerate() {
        if entry > 0 {
            scan.expect(b',', ", behind a plain number")?;
        }
        *number = scan.number()?;
    }
    scan.expect(b']', "] behind plain numbers")?;
    Ok(found)
}

/// Parses `[[x,y,z],[q1,q2,q3,q4],[cf1,cf4,cf6,cfx],[six external axes]]`; returns the numbers with their ranges in `text`.
pub(crate) fn parse_target(text: &[u8]) -> Result<Vec<Number>, RobotFault> {
    let mut scan = Scan::new(text);
    scan.expect(b'[', "[[x,y,z],[q1,q2,q3,q4],[cf1,cf4,cf6,cfx],[six external axes]]")?;
    let position = parse_numbers::<3>(&mut scan)?;
    scan.expect(b',', ", and [q1,q2,q3,q4]")?;
    let rotation = parse_numbers::<4>(&mut scan)?;
    scan.expect(b',', ", and [cf1,cf4,cf6,cfx]")?;
    let arm = parse_numbers::<4>(&mut scan)?;
    scan.expect(b',', ", and [six external axes]")?;
    let external = parse_numbers::<6>(&mut scan)?;
    scan.expect(b']', "]")?;
    if !scan.is_done() {
        return Err(RobotFault::Form { expected: "nothing behind the target" });
    }
    let named = |component: fn(usize) -> Component| {
        move |(entry, (value, at))| Number { component: component(entry), at, value }
    };
    let used = external.into_iter().enumerate().filter(|(_, (value, _))| value.abs() < NOT_USED);
    let position = position.into_iter().enumerate().map(named(Component::Position));
    let rotation = rotation.into_iter().enumerate().map(named(Component::Rotation));
    let arm = arm.into_iter().enumerate().map(named(Component::Arm));
    Ok(position.chain(rotation).chain(arm).chain(used.map(named(Component::External))).collect())
}

/// Takes `[[x,y,z],[q1,q2,q3,q4]]`, mm and a quaternion, which must have unit length; returns the pose.
fn parse_pose(scan: &mut Scan<'_>) -> Result<Isometry3<f64>, RobotFault> {
    scan.expect(b'[', "[[x,y,z],[q1,q2,q3,q4]]")?;
    let [x, y, z] = parse_numbers::<3>(scan)?.map(|(value, _)| value);
    scan.expect(b',', ", and [q1,q2,q3,q4]")?;
    let [w, i, j, k] = parse_numbers::<4>(scan)?.map(|(value, _)| value);
    scan.expect(b']', "] behind a pose")?;
    let quaternion = Quaternion::new(w, i, j, k);
    let length = quaternion.norm();
    if (length - 1.0).abs() > 1e-2 {
        return Err(RobotFault::NotUnit { what: "quaternion", length });
    }
    let at = Vector3::new(x, y, z);
    Ok(Isometry3::from_parts(Translation3::from(at), UnitQuaternion::from_quaternion(quaternion)))
}

/// Takes TRUE or FALSE.
fn parse_bool(scan: &mut Scan<'_>) -> Result<bool, RobotFault> {
    match scan.name().0.to_ascii_uppercase().as_str() {
        "TRUE" => Ok(true),
        "FALSE" => Ok(false),
        _ => Err(RobotFault::Form { expected: "TRUE or FALSE" }),
    }
}

/// Parses tool data `[TRUE,[[x,y,z],[q1,q2,q3,q4]],…]`; returns the frame of the tool in the flange or, if it has to stand (FALSE), in the base, mm.
pub(crate) fn tool_frame(text: &[u8], stands: bool) -> Result<Isometry3<f64>, RobotFault> {
    let mut scan = Scan::new(text);
    scan.expect(b'[', "[TRUE,[[x,y,z],[q1,q2,q3,q4]],…]")?;
    match (parse_bool(&mut scan)?, stands) {
        (false, false) => return Err(STANDS),
        (true, true) => return Err(HELD),
        _ => {}
    }
    scan.expect(b',', ", and the frame of the tool")?;
    parse_pose(&mut scan)
}

/// A tool or part that is held where the process says otherwise.
const STANDS: RobotFault = RobotFault::NotFollowed {
    what: "tools that stand (robhold FALSE) are, unless the process says so,",
    expected: "a tool that the robot holds, or stationary = true, tip_mm and axis in [tool] of the process",
};
pub(crate) const HELD: RobotFault = RobotFault::NotFollowed {
    what: "tools that the robot holds are, as the process says that the tool is stationary,",
    expected: "a tool with robhold FALSE",
};

/// Parses a work object `[FALSE,TRUE,"",[user frame],[object frame]]`: its frame in the world or, if the robot has to hold it (TRUE), in the
/// flange, mm.
pub(crate) fn work_object_frame(text: &[u8], is_to_be_held: bool) -> Result<Isometry3<f64>, RobotFault> {
    let mut scan = Scan::new(text);
    scan.expect(b'[', "[FALSE,TRUE,\"\",[user frame],[object frame]]")?;
    let is_held = parse_bool(&mut scan)?;
    scan.expect(b',', ",")?;
    let is_fixed = parse_bool(&mut scan)?;
    if is_held != is_to_be_held || !is_fixed {
        let expected = match is_to_be_held {
            true => "one that the robot holds, as the tool is stationary (robhold TRUE, ufprog TRUE)",
            false => {
                "one that stands still (robhold FALSE, ufprog TRUE), or stationary = true in [tool] of the process"
            }
        };
        return RobotFault::not_followed("other work objects are", expected);
    }
    scan.expect(b',', ", and the name of a unit")?;
    scan.expect(b'"', "\"\"")?;
    scan.expect(b'"', "\"\", no mechanical unit")?;
    scan.expect(b',', ", and the user frame")?;
    let user = parse_pose(&mut scan)?;
    scan.expect(b',', ", and the object frame")?;
    Ok(user * parse_pose(&mut scan)?)
}

/// Parses a joint target `[[a1,…,a6],[six external axes]]`: the angles, rad.
pub(crate) fn parse_joints(text: &[u8]) -> Result<[f32; 6], RobotFault> {
    let mut scan = Scan::new(text);
    scan.expect(b'[', "[[six axes],[six external axes]]")?;
    Ok(parse_numbers::<6>(&mut scan)?.map(|(degrees, _)| degrees.to_radians() as f32))
}

/// Parses speed data `[v_tcp,v_ori,v_leax,v_reax]`: velocity of the tip, mm/s.
pub(crate) fn parse_speed(text: &[u8]) -> Result<f64, RobotFault> {
    let mut scan = Scan::new(text);
    Ok(parse_numbers::<4>(&mut scan)?[0].0)
}
