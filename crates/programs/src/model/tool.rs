//! Tools as the comments of a program, or a process file, describe them.

use serde::Deserialize;

/// The shape of a tool that cuts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ToolShape {
    /// End mill with sharp corners.
    Flat,
    /// Ball end mill.
    Ball,
    /// End mill with round corners.
    BullNose,
    /// Twist drill, or another tool that drills by its point.
    Drill,
}

impl ToolShape {
    /// Returns what a tool of the shape is called.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Flat => "flat end mill",
            Self::Ball => "ball end mill",
            Self::BullNose => "bull-nose end mill",
            Self::Drill => "drill",
        }
    }
}

/// What is said about a tool; `None` is not said.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ToolDescription {
    /// Number of the tool.
    pub number: u32,
    /// Line of the comment in its program, from 1; `None` in a process file.
    pub line: Option<usize>,
    /// Its shape, or the name of a tool that has none of them.
    pub shape: Option<Result<ToolShape, &'static str>>,
    /// Diameter, mm.
    pub diameter_mm: Option<f64>,
    /// Radius of the corner, mm.
    pub corner_radius_mm: Option<f64>,
    /// Angle of the point, degrees.
    pub point_angle_deg: Option<f64>,
    /// Number of teeth.
    pub teeth: Option<u32>,
}

/// How far two descriptions of a length may differ by rounding, mm; angles by as many degrees.
const SAME_MM: f64 = 0.01;

impl ToolDescription {
    /// Adds what `other` says about the same tool; `Err` with the name of what the two say differently.
    pub fn merge(&mut self, other: &ToolDescription) -> Result<(), &'static str> {
        if self.shape.zip(other.shape).is_some_and(|(a, b)| a != b) {
            return Err("shape");
        }
        if self.teeth.zip(other.teeth).is_some_and(|(a, b)| a != b) {
            return Err("number of teeth");
        }
        for (own, other, name) in [
            (&mut self.diameter_mm, other.diameter_mm, "diameter"),
            (&mut self.corner_radius_mm, other.corner_radius_mm, "corner radius"),
            (&mut self.point_angle_deg, other.point_angle_deg, "point angle"),
        ] {
            if own.zip(other).is_some_and(|(a, b)| (a - b).abs() > SAME_MM) {
                return Err(name);
            }
            *own = own.or(other);
        }
        (self.shape, self.teeth) = (self.shape.or(other.shape), self.teeth.or(other.teeth));
        Ok(())
    }

    /// Whether it has the corner or the point of another shape than `shape`, at the diameter given; so a comment may say that does not name a
    /// shape which is known.
    pub fn is_of_other_shape_than(&self, shape: ToolShape, diameter_mm: f64) -> bool {
        let corner_mm = self.corner_radius_mm.unwrap_or_default();
        match shape {
            ToolShape::Drill => false,
            _ if self.point_angle_deg.is_some_and(|angle| angle != 0.0) => true,
            ToolShape::Flat => corner_mm > SAME_MM,
            ToolShape::Ball => corner_mm > 0.0 && (corner_mm - diameter_mm / 2.0).abs() > SAME_MM,
            ToolShape::BullNose => false,
        }
    }

    /// Says the tool, and where this stands: "by the comment on line 3 a ball end mill of 6 mm".
    pub fn text(&self) -> String {
        let place = match self.line {
            Some(line) => format!("the comment on line {line}"),
            None => format!("tools.{}", self.number),
        };
        let mm = |length: f64| (length * 1e4).round() / 1e4;
        let name = self.shape.map_or("tool", |shape| shape.map_or_else(|name| name, ToolShape::name));
        let mut words = format!("by {place} a {name}");
        words += &self.diameter_mm.map_or(String::new(), |own| format!(" of {} mm", mm(own)));
        words += &self.corner_radius_mm.map_or(String::new(), |own| format!(" with corners of {} mm", mm(own)));
        words += &self.point_angle_deg.map_or(String::new(), |own| format!(" with a point of {own}°"));
        words + &self.teeth.map_or(String::new(), |own| format!(" with {own} teeth"))
    }
}
