//! URScript of Universal Robots: lines of a `.script`, in m and rad.
//!
//! Followed are movel, movep, movec and movej to poses `p[x,y,z,rx,ry,rz]`, by name or in a feature (`pose_trans`), `set_tcp`, and variables
//! with plain poses and numbers. Motions that servo, follow or push, and calls of what is not in the program, are refused.

use std::{
    collections::{HashMap, HashSet},
    ops::Range,
};

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::{
    model::robot::{Component, Frames, METRE_MM, MotionKind, Number, RobotFault, RobotOptions, Statement, Target},
    read::{
        robot::{Base, Bases, LineCursor, LocatedFault, Tool, Tools, scan::check_depth, trimmed},
        scan::Scan,
    },
};

/// Default speed of motions along a path, m/s.
const SPEED_M_PER_S: f64 = 0.25;

/// A base, the pose in it of the frame in which a target stands, mm, and the number of brackets around the target.
type Place = (Base, Isometry3<f64>, usize);

/// Value of a variable.
#[derive(Clone, Debug)]
enum Value {
    /// The text of a pose in these bytes.
    Pose(Range<usize>),
    Number(f64),
    /// Unknown to the reader because of this line.
    Computed(usize),
}

/// A reader of URScript lines with the variables and modes in force.
#[derive(Debug)]
pub(crate) struct Reader<'a> {
    source: &'a [u8],
    options: &'a RobotOptions,
    lines: LineCursor<'a>,
    /// Values with the lines of the functions that set them, 0 outside of all.
    values: HashMap<&'a str, (Value, usize)>,
    /// Lines of the functions that set each name, for each time.
    setters: HashMap<&'a str, Vec<usize>>,
    /// Lines and names of the functions of the program.
    functions: Vec<(usize, &'a str)>,
    /// By name of a function, for each call of it, whether that may be skipped or repeated.
    calls: HashMap<&'a str, Vec<bool>>,
    bases: Bases<'a>,
    tools: Tools<'a>,
    tool: Option<Tool>,
    /// Keywords and lines of the open blocks.
    blocks: Vec<(&'a str, usize)>,
    /// Line of the function that has the motions; 0 outside of all.
    motion_routine: Option<usize>,
    /// Line on which the endless loop around the motions ends.
    end_line: Option<usize>,
    /// Line on which the function returns in any case.
    return_line: Option<usize>,
    /// Names in the motions of an endless loop so far.
    names_in_loop: HashSet<&'a str>,
}

impl<'a> Reader<'a> {
    /// Starts at the first line of `source`.
    pub fn new(source: &'a [u8], options: &'a RobotOptions) -> Self {
        let mut lines = LineCursor::new(source);
        let functions = std::iter::from_fn(|| Some((lines.advance()?, lines.line))).filter_map(|(at, line)| {
            let mut scan = Scan::new(&source[at]);
            matches!(scan.name().0, "def" | "thread" | "sec").then(|| (line, scan.name().0))
        });
        Self {
            source,
            options,
            functions: functions.collect(),
            lines: LineCursor::new(source),
            calls: calls(source),
            values: HashMap::new(),
            setters: setters(source),
            bases: Bases::new(options, source),
            tools: Tools::new(options),
            tool: None,
            blocks: Vec::new(),
            motion_routine: None,
            end_line: None,
            return_line: None,
            names_in_loop: HashSet::new(),
        }
    }

    /// Returns the tools that motions have used so far.
    pub fn tools(&self) -> &Tools<'a> {
        &self.tools
    }

    /// Returns the next statement that moves the tool; `None` at the end, `Err` for a statement that is not followed.
    pub fn next(&mut self) -> Result<Option<Statement>, LocatedFault> {
        while let Some(line) = self.lines.advance() {
            let length = code_bytes(&self.source[line.clone()]).find(|(_, byte)| *byte == b'#').map(|(at, _)| at);
            let code = trimmed(self.source, line.start..length.map_or(line.end, |length| line.start + length));
            let found = self.follow_line(code.clone());
            if let Some(statement) = found.map_err(|fault| LocatedFault { line: self.lines.line, at: code, fault })? {
                return Ok(Some(statement));
            }
        }
        Ok(None)
    }

    /// Follows a line of code, the bytes `code`: returns the statement if it moves the tool, or else sets modes.
    fn follow_line(&mut self, code: Range<usize>) -> Result<Option<Statement>, RobotFault> {
        let (text, line) = (&self.source[code.clone()], self.lines.line);
        let mut scan = Scan::new(text);
        let (mut word, mut at) = scan.name();
        while matches!(word, "global" | "local") {
            (word, at) = scan.name();
        }
        let kind = match word {
            "movel" | "movep" => Some(MotionKind::Line),
            "movec" => Some(MotionKind::Circle),
            "movej" => Some(MotionKind::PointToPoint),
            _ => None,
        };
        if let Some(kind) = kind {
            return self.motion(kind, code, at).map(Some);
        }
        let is_own = |name: &&str| self.is_function(name) && !FOLLOWED.contains(name);
        if let Some(name) = called_names(text).find(|name| is_motion(name) && !is_own(name)) {
            return match name {
                name if FOLLOWED.contains(&name) => Err(RobotFault::Form { expected: "a motion on a line of its own" }),
                _ => RobotFault::not_followed(
                    "motions that servo, follow, push or give way are",
                    "movel, movep, movec and movej",
                ),
            };
        }
        let is_code = !text.is_empty() && text[0] != b'$' && !matches!(word, "def" | "thread" | "sec");
        let is_called = |name: &&str| *name != "set_tcp" || word != "set_tcp";
        if is_code && let Some(name) = called_names(text).filter(is_called).find(|name| !self.is_harmless(name)) {
            return Err(RobotFault::Call { name: name.to_owned() });
        }
        match word {
            // PolyScope numbers its nodes: $ 1 "Robot Program".
            _ if text.is_empty() || text[0] == b'$' => {}
            "def" | "thread" | "sec" | "if" => self.blocks.push((word, line)),
            "while" => {
                let is_alone = self.motion_routine.is_none() && self.is_plain();
                self.blocks.push((if is_endless(&text[at.end..]) && is_alone { ENDLESS } else { word }, line));
            }
            "end" => {
                let ended = self.blocks.pop();
                if self.motion_routine.is_some() && ended.is_some_and(|(word, _)| word == ENDLESS) {
                    self.end_line = Some(line);
                }
                if ended.is_some_and(|(word, _)| matches!(word, "def" | "thread" | "sec")) {
                    self.return_line = None;
                }
            }
            "return" if self.is_plain() => self.return_line = Some(line),
            "halt" if self.is_plain() => self.end_line = Some(line),
            "elif" | "else" | "halt" | "break" | "continue" | "return" | "pass" | "join" | "kill" | "run" => {}
            "set_tcp" => self.set_tool(scan, text)?,
            "" => return Err(RobotFault::Unknown { expected: "a statement of URScript" }),
            // What it calls was looked at.
            _ if scan.takes(b'(') => {}
            _ if self.names_in_loop.contains(word) => {
                return RobotFault::not_followed(
                    "what the next pass of an endless loop finds changed is",
                    "points that stay as they are",
                );
            }
            _ => {
                let is_whole = scan.next() != Some(b'[');
                if !is_whole {
                    scan.take_while(|byte| byte != b'=');
                }
                if !scan.takes(b'=') || scan.next() == Some(b'=') {
                    return Err(RobotFault::Unknown { expected: "a statement of URScript" });
                }
                let value = trimmed(self.source, code.start + scan.at..code.end);
                let written = &self.source[value.clone()];
                let value = match plain_number(written) {
                    _ if !is_whole || !self.is_plain() => Value::Computed(line),
                    Some(number) => Value::Number(number),
                    None if pose_numbers(written).is_ok() => Value::Pose(value),
                    None => Value::Computed(line),
                };
                self.values.insert(word, (value, self.routine()));
            }
        }
        Ok(None)
    }

    /// Returns the line of the function around this line; 0 outside of all.
    fn routine(&self) -> usize {
        self.blocks.iter().rfind(|(word, _)| matches!(*word, "def" | "thread" | "sec")).map_or(0, |(_, line)| *line)
    }

    /// Returns the value of a variable, if it has one. It is that of the last line before only where no other function sets it, and this one
    /// or nothing set it again: when functions run is not known.
    fn value(&self, name: &str) -> Option<Value> {
        let (value, routine) = self.values.get(name)?;
        let setters = self.setters.get(name).map_or(&[][..], Vec::as_slice);
        let is_known =
            setters.iter().all(|setter| setter == routine) && (setters.len() == 1 || self.routine() == *routine);
        Some(if is_known { value.clone() } else { Value::Computed(self.lines.line) })
    }

    /// Whether the line is in no branch or loop, so that it runs once.
    fn is_plain(&self) -> bool {
        self.blocks.iter().all(|(word, _)| *word == "def")
    }

    /// Refuses a line in a branch, a loop or a thread; the endless loop around a program is none.
    fn check_runs_once(&self) -> Result<(), RobotFault> {
        match self.blocks.iter().find(|(word, _)| !matches!(*word, "def" | ENDLESS)) {
            Some((word, line)) => Err(RobotFault::Branch { keyword: (*word).to_owned(), line: *line }),
            None => Ok(()),
        }
    }

    /// Refuses motions in the function on the line `routine` if it is called in a branch or loop, in a thread, or more than once; the one that has
    /// calls of none is what runs.
    fn check_called_once(&self, routine: usize) -> Result<(), RobotFault> {
        let name = self.functions.iter().find(|(line, _)| *line == routine).map(|(_, name)| *name);
        match name.and_then(|name| self.calls.get(name)).map_or(&[][..], Vec::as_slice) {
            [] | [false] => Ok(()),
            _ => RobotFault::not_followed(
                "functions with motions that are called in a branch, loop or thread, or more than once, are",
                "motions that run once",
            ),
        }
    }

    /// Whether `name` is that of a function of the program.
    fn is_function(&self, name: &str) -> bool {
        self.functions.iter().any(|(_, own)| *own == name)
    }

    /// Whether `name`, before a bracket, calls what is in the program or moves nothing, or the options say so.
    fn is_harmless(&self, name: &str) -> bool {
        let is_listed = |names: &str| names.split_whitespace().any(|known| known == name);
        // All motions are in one function: one of the program that another calls moves nothing, or is the one that does.
        name.is_empty()
            || is_listed(IGNORED)
            || is_listed(VALUES)
            || IGNORED_BEGINNINGS.iter().any(|begin| name.starts_with(begin))
            || self.is_function(name)
            || self.options.keeps_call(name)
    }

    /// Follows `set_tcp(p[…])`.
    fn set_tool(&mut self, scan: Scan<'_>, text: &[u8]) -> Result<(), RobotFault> {
        self.check_runs_once()?;
        if self.motion_routine.is_some() && !self.is_plain() {
            return RobotFault::not_followed("set_tcp behind motions of an endless loop is", "set_tcp before it");
        }
        let (arguments, end) = arguments(text, scan.at)?;
        let first = trimmed(text, arguments[0].clone());
        let mut pose = Scan::new(&text[first.clone()]);
        let frame = self.take_pose(&mut pose, 1)?;
        if !pose.is_done() || end != text.len() {
            return RobotFault::not_followed("computed tools are", POSE);
        }
        let name = format!("set_tcp({})", String::from_utf8_lossy(&text[first]));
        self.tool = Some(Tool { name, in_flange: Some(frame) });
        Ok(())
    }

    /// Takes a pose, `p[…]` or the name of one; returns its range and the text that gives its numbers.
    fn take_pose_text<'t>(&self, scan: &mut Scan<'t>) -> Result<(Range<usize>, &'t [u8]), RobotFault>
    where
        'a: 't,
    {
        let (name, at) = scan.name();
        if name == "p" && scan.next() == Some(b'[') {
            let length =
                scan.rest().iter().position(|byte| *byte == b']').ok_or(RobotFault::Form { expected: POSE })?;
            scan.at += length + 1;
            return Ok((at.start..scan.at, &scan.line[at.start..scan.at]));
        }
        let is_whole = !name.is_empty() && scan.next().is_none_or(|next| matches!(next, b',' | b')'));
        match self.value(name).filter(|_| is_whole) {
            Some(Value::Pose(text)) => Ok((at, &self.source[text])),
            Some(Value::Computed(line)) => Err(RobotFault::Computed { name: name.to_owned(), line }),
            Some(Value::Number(_)) | None if is_whole => {
                Err(RobotFault::NoPoint { name: name.to_owned(), beside: String::new() })
            }
            _ => RobotFault::not_followed("computed targets and positions of joints are", POSE),
        }
    }

    /// Takes a pose that is not written back, mm: `p[…]`, the name of one, or `pose_trans` and `pose_inv` of such, behind `depth` open brackets.
    fn take_pose<'t>(&self, scan: &mut Scan<'t>, depth: usize) -> Result<Isometry3<f64>, RobotFault>
    where
        'a: 't,
    {
        check_depth(scan.line, depth)?;
        let mut ahead = *scan;
        let name = ahead.name().0;
        if !matches!(name, "pose_trans" | "pose_inv") {
            let numbers = pose_numbers(self.take_pose_text(scan)?.1)?;
            let [x, y, z, rx, ry, rz] = std::array::from_fn(|k| numbers[k].value);
            let rotation = UnitQuaternion::from_scaled_axis(Vector3::new(rx, ry, rz));
            return Ok(Isometry3::from_parts(Translation3::from(Vector3::new(x, y, z) * METRE_MM), rotation));
        }
        *scan = ahead;
        scan.expect(b'(', "( and poses")?;
        let mut pose = self.take_pose(scan, depth + 1)?;
        if name == "pose_inv" {
            pose = pose.inverse();
        } else {
            scan.expect(b',', ", and the second pose of pose_trans")?;
            pose *= self.take_pose(scan, depth + 1)?;
        }
        scan.expect(b')', ") behind the poses")?;
        Ok(pose)
    }

    /// Returns the number that `text` gives or names; `None` if it is not known.
    fn number(&self, text: &[u8]) -> Option<f64> {
        match self.value(std::str::from_utf8(text).ok()?) {
            Some(Value::Number(number)) => Some(number),
            _ => plain_number(text),
        }
    }

    /// Returns the target of the argument in the bytes `at` of the source, and where it stands: a pose, its name, or `pose_trans(feature, …)` of it,
    /// in which all around the pose stays as it is.
    fn target(&self, at: Range<usize>) -> Result<(Target, Place), RobotFault> {
        let mut at = trimmed(self.source, at);
        let mut scan = Scan::new(&self.source[at.clone()]);
        // The joints of a pose, by which PolyScope moves to it.
        let mut near = None;
        let asks_joints = scan.name().0 == "get_inverse_kin";
        if asks_joints {
            let (parts, end) = arguments(scan.line, scan.at)?;
            if !matches!(parts.len(), 1 | 2) || end != scan.line.len() {
                return Err(RobotFault::Form { expected: "get_inverse_kin(pose, qnear)" });
            }
            near = parts.get(1).map(|near| at.start + near.start..at.start + near.end);
            at = trimmed(self.source, at.start + parts[0].start..at.start + parts[0].end);
        }
        let text = &self.source[at.clone()];
        scan = Scan::new(text);
        let mut features = Vec::new();
        loop {
            let mut ahead = scan;
            if ahead.name().0 != "pose_trans" {
                break;
            }
            scan = ahead;
            scan.expect(b'(', "pose_trans(feature, pose)")?;
            let start = scan.skip_blanks().at;
            let pose = self.take_pose(&mut scan, features.len() + 1)?;
            features.push((String::from_utf8_lossy(text[start..scan.at].trim_ascii()).to_ascii_lowercase(), pose));
            scan.expect(b',', "pose_trans(feature, pose)")?;
        }
        let (own, written) = self.take_pose_text(&mut scan)?;
        for _ in &features {
            scan.expect(b')', ") behind the pose")?;
        }
        if !scan.is_done() {
            return RobotFault::not_followed("computed targets and positions of joints are", POSE);
        }
        let own = at.start + own.start..at.start + own.end;
        let mut target = Target { at: own, text: written.to_vec(), numbers: pose_numbers(written)? };
        if let Some(near) = near {
            target = with_near(self.source, target, near);
        }
        let product = |features: &[(String, Isometry3<f64>)]| {
            features.iter().fold(Isometry3::identity(), |all, (_, pose)| all * pose)
        };
        // Where the options say how the outermost feature stands, the others stand in it.
        let given = features.first().is_some_and(|(name, _)| self.options.bases.contains_key(name));
        let count = if given { 1 } else { features.len() };
        let names: Vec<&str> = features[..count].iter().map(|(name, _)| name.as_str()).collect();
        let name = if names.is_empty() { "base".to_owned() } else { names.join(" and in it ") };
        let base = Base { name, in_world: Some(product(&features[..count])) };
        Ok((target, (base, product(&features[count..]), features.len() + usize::from(asks_joints))))
    }

    /// Refuses a motion in another function than the first one, in one that may run twice, or with set_tcp elsewhere.
    fn check_routine(&mut self) -> Result<(), RobotFault> {
        let routine = self.routine();
        let is_around = |line: &usize| *line == 0 || self.blocks.iter().any(|(_, at)| at == line);
        if !self.setters.get("set_tcp").is_none_or(|lines| lines.iter().all(is_around)) {
            return RobotFault::not_followed("set_tcp in other functions than the motions is", "set_tcp before them");
        }
        if self.motion_routine != Some(routine) {
            self.check_called_once(routine)?;
        }
        let first = *self.motion_routine.get_or_insert(routine);
        if first != routine {
            return Err(RobotFault::SecondRoutine { line: routine, first });
        }
        Ok(())
    }

    /// Returns the statement of the motion in the bytes `code`, whose name is at `keyword` in them.
    fn motion(&mut self, kind: MotionKind, code: Range<usize>, keyword: Range<usize>) -> Result<Statement, RobotFault> {
        self.check_runs_once()?;
        if let Some(end) = self.end_line.or(self.return_line) {
            return Err(RobotFault::AfterEnd { end });
        }
        if self.blocks.iter().any(|(word, _)| *word == ENDLESS) {
            let text = &self.source[code.start + keyword.end..code.end];
            self.names_in_loop.extend(names_in(text));
        }
        self.check_routine()?;
        let text = &self.source[code.clone()];
        let (parts, end) = arguments(text, keyword.end)?;
        if end != text.len() {
            return Err(RobotFault::Form { expected: "nothing behind the )" });
        }
        let names = argument_names(&text[keyword.clone()]);
        let mut given: [Option<&[u8]>; 6] = [None; 6];
        let poses = if kind == MotionKind::Circle { 2 } else { 1 };
        for (k, part) in parts.iter().enumerate() {
            let (name, value) = named_argument(&text[part.clone()]);
            let k = name.map_or(Some(k), |name| names.iter().position(|known| *known == name));
            let slot = k.filter(|k| *k < names.len()).and_then(|k| given.get_mut(k)).filter(|slot| slot.is_none());
            *slot.ok_or(RobotFault::Form { expected: "the arguments of the URScript manual, each once" })? =
                Some(value);
        }
        let number = |name: &str| {
            let given = names.iter().position(|known| *known == name).and_then(|k| given[k]);
            given.map_or(Some(0.0), |text| self.number(text))
        };
        let is_cut = kind != MotionKind::PointToPoint;
        if is_cut && number("t") != Some(0.0) {
            return RobotFault::not_followed("times of motions (t) are", "a speed v");
        }
        if number("mode") != Some(0.0) {
            return RobotFault::not_followed("circles that carry the orientation along (mode=1) are", "mode=0");
        }
        let v = if given[poses + 1].is_some() { number("v") } else { Some(SPEED_M_PER_S) };
        let feed_mm_per_min = v.filter(|v| is_cut && *v > 0.0).map(|v| v * METRE_MM * 60.0);
        let blend_mm = Some(number("r").map_or(f64::INFINITY, |r| r * METRE_MM)).filter(|r| *r != 0.0);
        let at = |k: usize| parts.get(k).map(|part| code.start + part.start..code.start + part.end);
        let target = |k: usize| self.target(at(k).ok_or(RobotFault::Form { expected: POSE })?);
        let via = if poses == 2 { Some(target(0)?) } else { None };
        let end = match target(poses - 1) {
            Ok(end) => Some(end),
            // Positions of joints, or a pose that is computed.
            Err(_) if !is_cut => None,
            Err(fault) => return Err(fault),
        };
        if let (Some((_, one)), Some((_, other))) = (&via, &end)
            && one != other
        {
            return RobotFault::not_followed("circles with points in two features are", "one feature");
        }
        let frames = match &end {
            Some((_, (base, inner, _))) => Frames {
                base: self.bases.pose(Some(base))? * inner,
                tool: self.tools.rotation(self.tool.as_ref())?,
                unit_mm: METRE_MM,
            },
            None => Frames::default(),
        };
        let joints =
            at(0).filter(|_| end.is_none()).and_then(|at| joint_numbers(&self.source[trimmed(self.source, at)]));
        let joints = joints.map(|numbers| std::array::from_fn(|joint| numbers[joint].value as f32));
        let keyword = code.start + keyword.start..code.start + keyword.end;
        Ok(Statement {
            suffix: end.as_ref().map_or(code.end, |(end, _)| end.at.end)..code.end,
            via: via.map(|(via, _)| via),
            end: end.map(|(end, _)| end),
            frames,
            blend_mm,
            feed_mm_per_min,
            // A path goes on as it comes, whatever its end is near to.
            is_posture_open: is_cut,
            joints,
            ..Statement::new(code, self.lines.line, keyword, kind)
        })
    }
}

/// Returns, by name of what is called, for each call whether it stands in a branch, loop or thread.
fn calls(source: &[u8]) -> HashMap<&str, Vec<bool>> {
    let (mut lines, mut blocks, mut found) = (LineCursor::new(source), Vec::new(), HashMap::<_, Vec<_>>::new());
    while let Some(line) = lines.advance() {
        let text = &source[line];
        let code = code_bytes(text).find(|(_, byte)| *byte == b'#').map_or(text, |(at, _)| &text[..at]);
        let (word, at) = Scan::new(code).name();
        let opens = match word {
            // The endless loop around a program is one pass.
            "while" if is_endless(&code[at.end..]) => ENDLESS,
            _ => word,
        };
        if !matches!(word, "def" | "thread" | "sec") {
            let may_skip = matches!(opens, "if" | "elif" | "while")
                || blocks.iter().any(|block| !matches!(*block, "def" | ENDLESS));
            for name in called_names(code) {
                found.entry(name).or_default().push(may_skip);
            }
        }
        match opens {
            "def" | "thread" | "sec" | "if" | "while" | ENDLESS => blocks.push(opens),
            "end" => drop(blocks.pop()),
            _ => {}
        }
    }
    found
}

/// Whether `text`, behind `while`, is the condition of an endless loop: `True:` or `(True):`.
fn is_endless(text: &[u8]) -> bool {
    let condition = text.trim_ascii().strip_suffix(b":").unwrap_or_default().trim_ascii();
    let inner = condition.strip_prefix(b"(").and_then(|inner| inner.strip_suffix(b")"));
    inner.unwrap_or(condition).trim_ascii() == b"True"
}

/// Returns the lines of the functions that set each name, as a variable or as an argument, or call `set_tcp`; 0 outside of all.
fn setters(source: &[u8]) -> HashMap<&str, Vec<usize>> {
    let (mut lines, mut blocks, mut found) = (LineCursor::new(source), Vec::new(), HashMap::<_, Vec<usize>>::new());
    while let Some(line) = lines.advance() {
        let mut scan = Scan::new(&source[line]);
        let mut word = scan.name().0;
        while matches!(word, "global" | "local") {
            word = scan.name().0;
        }
        let outer = blocks.last().copied().unwrap_or(0);
        match word {
            "def" | "thread" | "sec" => {
                blocks.push(lines.line);
                scan.name();
                while scan.takes(b'(') || scan.takes(b',') {
                    found.entry(scan.name().0).or_default().push(lines.line);
                    scan.take_while(|byte| !matches!(byte, b',' | b')'));
                }
            }
            "if" | "while" => blocks.push(outer),
            "set_tcp" => found.entry(word).or_default().push(outer),
            "end" => drop(blocks.pop()),
            "" => {}
            _ => {
                if scan.next() == Some(b'[') {
                    scan.take_while(|byte| byte != b'=');
                }
                if scan.takes(b'=') && scan.peek() != Some(b'=') {
                    found.entry(word).or_default().push(outer);
                }
            }
        }
    }
    found
}

/// Motions that are followed.
const FOLLOWED: [&str; 4] = ["movel", "movep", "movec", "movej"];

/// Keyword of an endless loop around the motions, each pass of which is the same.
const ENDLESS: &str = "while True";

const POSE: &str = "p[x,y,z,rx,ry,rz] in plain numbers, its name, or pose_trans(feature, pose)";

/// Returns the names of the arguments of a motion, in the order of the URScript manual.
pub(crate) fn argument_names(keyword: &[u8]) -> &'static [&'static str] {
    match keyword {
        b"movec" => &["pose_via", "pose_to", "a", "v", "r", "mode"],
        b"movep" => &["pose", "a", "v", "r"],
        b"movej" => &["q", "a", "v", "t", "r"],
        _ => &["pose", "a", "v", "t", "r"],
    }
}

/// Splits `a=1.2` into name and value; a value alone has no name.
pub(crate) fn named_argument(text: &[u8]) -> (Option<&str>, &[u8]) {
    let mut scan = Scan::new(text);
    let (name, _) = scan.name();
    match !name.is_empty() && scan.takes(b'=') {
        true => (Some(name), scan.rest().trim_ascii()),
        false => (None, text.trim_ascii()),
    }
}

/// Returns the ranges of the arguments in the parentheses of `text` that open behind byte `from`, and where these close.
pub(crate) fn arguments(text: &[u8], from: usize) -> Result<(Vec<Range<usize>>, usize), RobotFault> {
    let (mut depth, mut start, mut parts) = (0usize, 0, Vec::new());
    for (at, byte) in code_bytes(text).filter(|(at, _)| *at >= from) {
        match byte {
            b'(' | b'[' => {
                depth += 1;
                if depth == 1 {
                    start = at + 1;
                }
            }
            b')' | b']' => {
                depth = depth.saturating_sub(1);
                if depth == 0 {
                    parts.push(start..at);
                    return Ok((parts, at + 1));
                }
            }
            b',' if depth == 1 => {
                parts.push(start..at);
                start = at + 1;
            }
            _ => {}
        }
    }
    Err(RobotFault::Form { expected: "( and ) on the same line" })
}

/// Iterates over the bytes of a line outside strings, with their indices.
fn code_bytes(text: &[u8]) -> impl Iterator<Item = (usize, u8)> {
    let mut quote = None;
    text.iter().copied().enumerate().filter(move |(_, byte)| {
        let is_quote = matches!(byte, b'"' | b'\'');
        if is_quote && quote.is_none_or(|open| open == *byte) {
            quote = if quote.is_some() { None } else { Some(*byte) };
            return false;
        }
        quote.is_none()
    })
}

/// Iterates over the names before parentheses in `text`.
fn called_names(text: &[u8]) -> impl Iterator<Item = &str> {
    code_bytes(text).filter(|(_, byte)| *byte == b'(').map(|(at, _)| Scan::name_before(&text[..at]))
}

/// Whether the function `name` of the language moves the robot, or lets it be moved.
fn is_motion(name: &str) -> bool {
    const MOTIONS: [&str; 13] = [
        "move",
        "servo",
        "speed",
        "force_mode",
        "teach_mode",
        "freedrive_mode",
        "path_offset",
        "track_conveyor",
        "conveyor",
        "jog",
        "screw_driving",
        "optimove",
        "direct_torque",
    ];
    MOTIONS.iter().any(|begin| name.starts_with(begin))
}

/// Returns `target` with the list of joint positions in the bytes `near`, if they are plain numbers: qnear of get_inverse_kin.
fn with_near(source: &[u8], mut target: Target, near: Range<usize>) -> Target {
    let near = trimmed(source, near);
    if let Some(numbers) = joint_numbers(&source[near.clone()]) {
        let shift = target.text.len() + near.start - target.at.end;
        target.text.extend_from_slice(&source[target.at.end..near.end]);
        target.at.end = near.end;
        let shifted = |number: Number| Number { at: number.at.start + shift..number.at.end + shift, ..number };
        target.numbers.extend(numbers.into_iter().map(shifted));
    }
    target
}

/// Parses `[q1,q2,q3,q4,q5,q6]`, rad; `None` if `text` is anything else.
fn joint_numbers(text: &[u8]) -> Option<Vec<Number>> {
    let (mut scan, mut numbers) = (Scan::new(text), Vec::with_capacity(6));
    scan.expect(b'[', "[").ok()?;
    for joint in 0..6 {
        if joint > 0 {
            scan.expect(b',', ",").ok()?;
        }
        let (value, at) = scan.number().ok()?;
        numbers.push(Number { component: Component::Arm(joint), at, value });
    }
    (scan.takes(b']') && scan.is_done()).then_some(numbers)
}

/// Parses a plain number; `None` if `text` is anything else.
fn plain_number(text: &[u8]) -> Option<f64> {
    let mut scan = Scan::new(text);
    let (number, _) = scan.number().ok()?;
    scan.is_done().then_some(number)
}

/// Parses `p[x,y,z,rx,ry,rz]`; returns the numbers with their ranges in `text`.
fn pose_numbers(text: &[u8]) -> Result<Vec<Number>, RobotFault> {
    let (mut scan, mut numbers) = (Scan::new(text), Vec::with_capacity(6));
    let is_pose = scan.name().0 == "p";
    scan.expect(if is_pose { b'[' } else { b'p' }, POSE)?;
    for k in 0..6 {
        if k > 0 {
            scan.expect(b',', POSE)?;
        }
        let (value, at) = scan.number()?;
        let component = if k < 3 { Component::Position(k) } else { Component::Rotation(k - 3) };
        numbers.push(Number { component, at, value });
    }
    scan.expect(b']', POSE)?;
    if scan.is_done() { Ok(numbers) } else { Err(RobotFault::Form { expected: POSE }) }
}

/// Iterates over the names in `text`, but for those of arguments.
fn names_in(text: &[u8]) -> impl Iterator<Item = &str> {
    let mut scan = Scan::new(text);
    std::iter::from_fn(move || {
        loop {
            scan.take_while(|byte| !(byte.is_ascii_alphabetic() || byte == b'_'));
            let (name, _) = scan.name();
            if name.is_empty() {
                return None;
            }
            if scan.next() != Some(b'=') {
                return Some(name);
            }
        }
    })
}

/// Words before brackets that are no functions, and functions that compute or ask.
const VALUES: &str = "if elif while return and or not xor in True False \
    abs acos asin atan atan2 binary_list_to_integer ceil cos d2r floor force integer_to_binary_list interpolate_pose inv \
    length log make_list norm normalize point_dist pose_add pose_dist pose_inv pose_sub pose_trans pow powerof r2d random rotvec2rpy rpy2rotvec \
    sin size sqrt tan tool_contact transpose wrench_trans zeros to_num to_str str_at str_cat str_empty str_find str_len str_sub \
    append clear extend insert pop remove get_list_length time encoder_get_tick_count assert p struct";

/// Functions that neither move the robot nor change what a motion means.
const IGNORED: &str = "end_force_mode end_freedrive_mode end_teach_mode enable_external_ft_sensor encoder_enable_pulse_decode \
    encoder_enable_set_tick_count encoder_set_tick_count write_port_bit write_port_register set_safety_mode_transition_hardness sleep sync textmsg varmsg popup halt enter_critical exit_critical stopl stopj reset_world_model zero_ftsensor protective_stop";
const IGNORED_BEGINNINGS: [&str; 37] = [
    "get_actual_",
    "get_target_",
    "get_tcp_",
    "get_digital_",
    "get_analog_",
    "get_standard_",
    "get_configurable_",
    "get_tool_digital",
    "get_tool_analog",
    "get_tool_current",
    "get_tool_accelerometer",
    "get_joint_",
    "get_forward_kin",
    "get_inverse_kin",
    "get_steptime",
    "get_euromap",
    "get_flag",
    "get_controller_temp",
    "read_",
    "is_steady",
    "set_digital",
    "set_standard",
    "set_configurable",
    "set_tool_",
    "set_analog",
    "set_payload",
    "set_target_payload",
    "set_gravity",
    "set_flag",
    "set_input_actions",
    "set_runstate",
    "write_output",
    "socket_",
    "modbus_",
    "rtde_",
    "rpc_",
    "request_",
];
