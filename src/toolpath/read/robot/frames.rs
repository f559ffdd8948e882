//! Bases and tools in force: where a base stands in the workpiece frame, and how the tool is turned.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use crate::toolpath::model::robot::{RobotFault, RobotOptions};

/// A base or work object as a program names it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Base {
    /// Small letters.
    pub name: String,
    /// Where it stands in the world of the controller, mm, if the program says it.
    pub in_world: Option<Isometry3<f64>>,
}

/// Where bases stand in the workpiece frame W.
#[derive(Debug)]
pub(crate) struct Bases<'a> {
    options: &'a RobotOptions,
    /// `X_WO` of the world.
    world: Option<Isometry3<f64>>,
    /// The base of the first motion.
    first: Option<Base>,
}

impl<'a> Bases<'a> {
    pub fn new(options: &'a RobotOptions) -> Self {
        Self { options, world: options.bases.get(RobotOptions::WORLD).copied(), first: None }
    }

    /// `X_WB` of the base a motion uses; `None` is what is in force where the program names none, W itself. Where
    /// nothing else is said, the base of the first motion is W.
    pub fn pose(&mut self, base: Option<&Base>) -> Result<Isometry3<f64>, RobotFault> {
        let unnamed = Base { name: String::new(), in_world: None };
        let base = base.unwrap_or(&unnamed);
        let given = self.options.bases.get(&base.name).copied();
        let is_first = self.first.get_or_insert_with(|| base.clone()) == base;
        let nothing_given = self.options.bases.is_empty() || base.name.is_empty();
        let by_world = || Some(self.world? * base.in_world?);
        let pose = given
            .or_else(by_world)
            .or_else(|| (is_first && nothing_given).then(Isometry3::identity))
            .ok_or_else(|| RobotFault::NoBase { name: words(&base.name) })?;
        if self.world.is_none() {
            self.world = base.in_world.map(|in_world| pose * in_world.inverse());
        }
        Ok(pose)
    }
}

fn words(name: &str) -> String {
    if name.is_empty() { "the base before any is named".into() } else { name.into() }
}

/// A tool as a program names it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tool {
    /// Small letters.
    pub name: String,
    /// Its frame in the flange, mm, if the program says it.
    pub in_flange: Option<Isometry3<f64>>,
}

/// How the tool is turned, and where programs say its tip is.
#[derive(Debug)]
pub(crate) struct Tools<'a> {
    options: &'a RobotOptions,
    first: Option<Tool>,
}

impl<'a> Tools<'a> {
    pub fn new(options: &'a RobotOptions) -> Self {
        Self { options, first: None }
    }

    /// `R_PN` of the tool a motion uses; `None` is what is in force where the program names none.
    pub fn rotation(&mut self, tool: Option<&Tool>) -> Result<UnitQuaternion<f64>, RobotFault> {
        let own = self.options.tool_rotation;
        let Some(tool) = tool else { return Ok(own) };
        let first = self.first.get_or_insert_with(|| tool.clone());
        let tip = |tool: &Tool| tool.in_flange.map(|frame| frame.translation.vector);
        let is_same = match (tip(first), tip(tool)) {
            (Some(a), Some(b)) => (a - b).amax() <= SAME_MM,
            _ => first == tool,
        };
        match is_same {
            true => Ok(tool.in_flange.map_or(own, |frame| frame.rotation)),
            false => Err(RobotFault::SecondTool { name: tool.name.clone(), before: first.name.clone() }),
        }
    }

    /// The tip of the tool in the flange, mm, if the program says it.
    pub fn tip_mm(&self) -> Option<(String, Vector3<f64>)> {
        let tool = self.first.as_ref()?;
        Some((tool.name.clone(), tool.in_flange?.translation.vector))
    }
}

/// Tips that differ by less are the same.
const SAME_MM: f64 = 1e-6;

#[cfg(test)]
mod tests {
    use super::*;

    fn base(name: &str, x: Option<f64>) -> Base {
        Base { name: name.into(), in_world: x.map(|x| Isometry3::translation(x, 0.0, 0.0)) }
    }

    #[test]
    fn the_first_base_is_the_workpiece_and_others_stand_to_it() {
        let mut options = RobotOptions::default();
        let mut bases = Bases::new(&options);
        assert_eq!(bases.pose(Some(&base("a", Some(100.0)))).unwrap(), Isometry3::identity());
        assert_eq!(bases.pose(Some(&base("b", Some(130.0)))).unwrap(), Isometry3::translation(30.0, 0.0, 0.0));
        assert!(bases.pose(Some(&base("c", None))).is_err());
        assert!(bases.pose(None).is_err());
        let mut bases = Bases::new(&options);
        assert_eq!(bases.pose(Some(&base("a", None))).unwrap(), Isometry3::identity());
        // The same name is another base once it is said where it is.
        assert!(bases.pose(Some(&base("a", Some(1.0)))).is_err());
        options.bases.insert("b".into(), Isometry3::translation(5.0, 0.0, 0.0));
        let mut bases = Bases::new(&options);
        assert!(bases.pose(Some(&base("a", Some(1.0)))).is_err());
        assert_eq!(bases.pose(Some(&base("b", Some(3.0)))).unwrap(), Isometry3::translation(5.0, 0.0, 0.0));
        assert_eq!(bases.pose(Some(&base("a", Some(1.0)))).unwrap(), Isometry3::translation(3.0, 0.0, 0.0));
    }

    #[test]
    fn a_second_tool_is_refused_unless_its_tip_is_the_same() {
        let options = RobotOptions::default();
        let mut tools = Tools::new(&options);
        let tool =
            |name: &str, x: f64| Tool { name: name.into(), in_flange: Some(Isometry3::translation(x, 0.0, 0.0)) };
        assert!(tools.rotation(Some(&tool("t1", 1.0))).is_ok() && tools.rotation(Some(&tool("t2", 1.0))).is_ok());
        assert_eq!(
            tools.rotation(Some(&tool("t3", 2.0))).unwrap_err().to_string(),
            "uses t3 after t1; expected one tool, or tools whose orientation the program gives and whose tips are the same"
        );
        assert_eq!(tools.tip_mm().unwrap().1.x, 1.0);
    }
}
