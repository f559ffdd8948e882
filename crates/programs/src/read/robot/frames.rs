//! Bases and tools of robot programs: the pose of a base in the workpiece frame W, and the rotation of the tool.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use crate::model::robot::{RobotFault, RobotOptions};

/// A base or work object that a program names.
#[derive(Clone, Debug, PartialEq)]
pub struct Base {
    /// Name in lower case.
    pub name: String,
    /// Its pose in the world frame of the controller, mm, if the program gives it.
    pub in_world: Option<Isometry3<f64>>,
}

/// Poses of bases in the workpiece frame W.
#[derive(Debug)]
pub struct Bases<'a> {
    options: &'a RobotOptions,
    /// `X_WO` of the controller's world frame.
    world: Option<Isometry3<f64>>,
    /// The base of the first motion.
    first: Option<Base>,
    source: &'a [u8],
}

impl<'a> Bases<'a> {
    /// Starts before the first motion of the program `source`.
    #[must_use]
    pub fn new(options: &'a RobotOptions, source: &'a [u8]) -> Self {
        // Of a part that is held, frames are in the flange.
        let world = options.bases.get(RobotOptions::WORLD).copied();
        Self { options, world: world.or(options.is_tool_stationary.then(Isometry3::identity)), first: None, source }
    }

    /// Whether the program names one of the bases that the options give, as a whole name: "base" is not in "base_data".
    fn names_given(&self) -> bool {
        let source = self.source;
        let continues_name =
            |at: Option<&u8>| at.is_some_and(|byte| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'$'));
        let is_named = |name: &String| {
            // Listings say UFRAME_NUM=1.
            name.starts_with("uframe[")
                || source.windows(name.len().max(1)).enumerate().any(|(at, text)| {
                    let (before, behind) =
                        (at.checked_sub(1).and_then(|at| source.get(at)), source.get(at + name.len()));
                    text.eq_ignore_ascii_case(name.as_bytes()) && !continues_name(before) && !continues_name(behind)
                })
        };
        self.options.bases.keys().filter(|name| *name != RobotOptions::WORLD).any(is_named)
    }

    /// Returns the pose `X_WB` (mm) of the base of a motion (`None`: unnamed); the first is W if nothing else is given. `Err` if unknown.
    pub fn pose(&mut self, base: Option<&Base>) -> Result<Isometry3<f64>, RobotFault> {
        let unnamed = Base { name: String::new(), in_world: None };
        let base = base.unwrap_or(&unnamed);
        let given = self.options.bases.get(&base.name).copied();
        let is_first = self.first.get_or_insert_with(|| base.clone()) == base;
        let is_open = self.options.bases.is_empty() || base.name.is_empty();
        // Looked for where it decides: once, as the world is known behind an explicit base.
        let nothing_given = || is_open || base.in_world.is_some() && !self.names_given();
        let by_world = || Some(self.world? * base.in_world?);
        let pose = given
            .or_else(by_world)
            .or_else(|| (is_first && !self.options.is_tool_stationary && nothing_given()).then(Isometry3::identity))
            .ok_or_else(|| RobotFault::NoBase { name: shown_name(&base.name) })?;
        if self.world.is_none() {
            self.world = base.in_world.map(|in_world| pose * in_world.inverse());
        }
        Ok(pose)
    }
}

/// Returns the name of a base for messages.
fn shown_name(name: &str) -> String {
    if name.is_empty() { "the base before any is named".into() } else { name.into() }
}

/// A tool that a program names.
#[derive(Clone, Debug, PartialEq)]
pub struct Tool {
    /// Name in lower case.
    pub name: String,
    /// Its frame in the flange, mm, if the program gives it.
    pub in_flange: Option<Isometry3<f64>>,
}

/// Rotations of tools, and the tool tip that the program gives.
#[derive(Debug)]
pub struct Tools<'a> {
    options: &'a RobotOptions,
    first: Option<Tool>,
    /// Whether a motion was made before any tool was named.
    is_unnamed: bool,
}

impl<'a> Tools<'a> {
    /// Starts before the first motion.
    #[must_use]
    pub fn new(options: &'a RobotOptions) -> Self {
        Self { options, first: None, is_unnamed: false }
    }

    /// Returns `R_PN` of the tool of a motion (`None`: no tool is named yet). `Err` if its tip is not that of the first tool.
    pub fn rotation(&mut self, tool: Option<&Tool>) -> Result<UnitQuaternion<f64>, RobotFault> {
        let given_rotation = self.options.tool_rotation.unwrap_or_default();
        let Some(tool) = tool else {
            self.is_unnamed = true;
            return Ok(given_rotation);
        };
        let first = self.first.get_or_insert_with(|| tool.clone());
        let tip = |tool: &Tool| tool.in_flange.map(|frame| frame.translation.vector);
        let is_same = match (tip(first), tip(tool)) {
            (Some(a), Some(b)) => (a - b).amax() <= SAME_MM,
            _ => first == tool,
        };
        match is_same {
            true => Ok(tool.in_flange.map_or(given_rotation, |frame| frame.rotation)),
            false => Err(RobotFault::SecondTool { name: tool.name.clone(), before: first.name.clone() }),
        }
    }

    /// Returns the name of the first tool if nothing gives its rotation, so that the flange's is taken, "the tool" where motions have none; else
    /// `None`.
    #[must_use]
    pub fn assumed_rotation(&self) -> Option<&str> {
        let unknown = self.first.as_ref().filter(|tool| tool.in_flange.is_none()).map(|tool| tool.name.as_str());
        unknown.or(self.is_unnamed.then_some("the tool")).filter(|_| self.options.tool_rotation.is_none())
    }

    /// Returns the name of the first tool and its tip in the flange, mm; `None` without a tool, or where the program does not give its frame.
    #[must_use]
    pub fn tip_mm(&self) -> Option<(String, Vector3<f64>)> {
        let tool = self.first.as_ref()?;
        Some((tool.name.clone(), tool.in_flange?.translation.vector))
    }
}

/// Refuses the name of a base or tool with an index between `open` and `close` that is computed: it may be another each time.
pub(crate) fn check_index(name: &str, open: char, close: char) -> Result<(), RobotFault> {
    let index = name.split_once(open).map_or("", |(_, rest)| rest.split(close).next().unwrap_or_default());
    match index.bytes().all(|byte| byte.is_ascii_digit() || byte == b' ') {
        true => Ok(()),
        false => RobotFault::not_followed("bases and tools whose index is computed are", "the index as a number"),
    }
}

/// Tips that differ by less are the same, mm.
const SAME_MM: f64 = 1e-6;
