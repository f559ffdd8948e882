//! The process file as written, with units in the keys; unknown keys are refused. Checked by [`crate::process::Process`].

use std::collections::BTreeMap;

use serde::Deserialize;

use super::{
    chain_errors::ChainErrorSpec,
    force_spec::ForceSpec,
    tables::{
        cell::CellSpec,
        feed::FeedSpec,
        redundancy::RedundancySpec,
        robot::RobotSpec,
        rotary::RotaryList,
        stock::{StockSpec, ToolSpec},
    },
};
use crate::{
    compensation::{ErrorNorm, Target},
    machine::OtherToolSpec,
    process::{PathReference, uncertainty::spec::UncertaintySpec},
    toolpath::gcode::{ArcCentres, BlockDelete, Dialect, LengthUnit, RotarySide},
};

/// A process file as written.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProcessSpec {
    /// Version of the file format, 1, in a file; not in a study that holds these tables.
    pub schema: Option<u32>,
    /// Tolerance of the tool's position; results are then judged by it.
    pub tolerance_mm: Option<f64>,
    /// Width of the zone of ISO 1101 in which it may be, in place of `tolerance_mm`: half of it to either side.
    pub tolerance_zone_mm: Option<f64>,
    /// Placement of the workpiece; at the machine's base frame if not given.
    #[serde(default)]
    pub placement: PlacementSpec,
    /// A tool that replaces that of the machine file.
    pub tool: Option<OtherToolSpec>,
    /// The cutting force; none if not given.
    #[serde(default)]
    pub force: ForceSpec,
    /// Cutting forces of single tools, by tool number; that of `force` where a tool has none.
    #[serde(default)]
    pub force_of_tool: BTreeMap<String, ForceSpec>,
    /// Cutting forces of features of a program, by a text in the line that begins them.
    #[serde(default)]
    pub force_of_feature: BTreeMap<String, ForceSpec>,
    /// Which moves cut; every move but rapid ones if not given.
    #[serde(default)]
    pub cutting: CuttingRuleSpec,
    /// Manufacturing and assembly errors; chains not named are nominal.
    #[serde(default)]
    pub chain_error: Vec<ChainErrorSpec>,
    /// What is not known exactly; all inputs are exact if not given.
    pub uncertainty: Option<UncertaintySpec>,
    /// What the verdict is about, and bounds of what is not computed.
    #[serde(default)]
    pub verdict: crate::process::VerdictSpec,
    /// How far the machine is from the temperature at which the workpiece was located.
    pub temperature: Option<crate::process::TemperatureSpec>,
    /// How finely arcs and long lines are split.
    #[serde(default)]
    pub sampling: SamplingSpec,
    /// Limits of corrections and drive forces; none if not given.
    #[serde(default)]
    pub limits: LimitsSpec,
    /// Natural frequencies of machine, tool and part, by which it is said whether the mean force over a turn is right.
    #[serde(default, rename = "natural_frequencies_Hz")]
    pub natural_frequencies_hz: Vec<f64>,
    /// What limits the feed of a program; as programmed if not given.
    pub feed: Option<FeedSpec>,
    /// What is compensated.
    #[serde(default)]
    pub compensate: CompensateTable,
    /// How the redundancy angle γ is chosen.
    #[serde(default)]
    pub redundancy: RedundancySpec,
    /// What a G-code program does not say itself.
    #[serde(default)]
    pub gcode: GcodeSpec,
    /// What stands around the workpiece or moves with it; bodies are not looked at if not given.
    pub cell: Option<CellSpec>,
    /// What is cut, from which the engagement follows; as the cutting forces say if not given.
    pub stock: Option<StockSpec>,
    /// Tools that cut the stock, by number.
    #[serde(default)]
    pub tools: BTreeMap<String, ToolSpec>,
    /// What a program of a robot or an APT program does not say itself. Pages get such programs as points.
    #[serde(default)]
    pub robot_program: RobotSpec,
}

impl ProcessSpec {
    /// Returns the names of the given tables that only apply to toolpaths.
    pub(crate) fn path_only_tables(&self) -> Vec<&'static str> {
        let given = [
            ("placement", self.placement != PlacementSpec::default()),
            ("force_of_tool", !self.force_of_tool.is_empty()),
            ("force_of_feature", !self.force_of_feature.is_empty()),
            ("cutting", self.cutting != CuttingRuleSpec::default()),
            ("sampling", self.sampling != SamplingSpec::default()),
            ("limits", self.limits != LimitsSpec::default()),
            ("feed", self.feed.is_some()),
            ("redundancy", self.redundancy != RedundancySpec::default()),
            ("gcode", self.gcode != GcodeSpec::default()),
            ("cell", self.cell.is_some()),
            ("stock", self.stock.is_some()),
            ("robot_program", self.robot_program != RobotSpec::default()),
        ];
        given.iter().filter(|(_, says_something)| *says_something).map(|(name, _)| *name).collect()
    }
}

/// The table `placement`: pose of the workpiece frame W in the base frame O.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlacementSpec {
    /// Origin of W in O; that of O if not given, which results then say.
    pub origin_mm: Option<[f64; 3]>,
    /// Roll, pitch and yaw of W: `R_OW = R_z(yaw) R_y(pitch) R_x(roll)`. The tool tilts with the workpiece, so roll and pitch
    /// need a machine that controls these rotations.
    #[serde(default)]
    pub roll_deg: f64,
    /// See `roll_deg`.
    #[serde(default)]
    pub pitch_deg: f64,
    /// Angle from the x axis of O to that of W about z.
    #[serde(default)]
    pub yaw_deg: f64,
    /// The point whose positions the path gives.
    #[serde(default)]
    pub reference: PathReference,
}

/// The table `cutting`: which moves that are not rapid cut; see [`crate::process::CuttingRule`].
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CuttingRuleSpec {
    /// Highest z in W at which the tool cuts.
    pub below_z_mm: Option<f64>,
    /// Lowest z in W at which the tool cuts.
    pub above_z_mm: Option<f64>,
    /// Fastest feed at which the tool cuts.
    pub max_feed_mm_per_min: Option<f64>,
}

/// The table `sampling`: how finely arcs and long lines are split.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SamplingSpec {
    /// Largest distance of an arc from its chord; 0.001 if not given.
    pub chordal_tolerance_mm: Option<f64>,
    /// The longest piece; 1 if not given.
    pub max_segment_mm: Option<f64>,
    /// The largest rotation of the tool along a piece; 2 if not given.
    pub max_turn_deg: Option<f64>,
}

/// An item of `[[gcode.rotary]]`: a rotary axis of the control.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RotarySpec {
    /// A, B or C.
    pub letter: char,
    /// Direction of the axis with all axes at 0, about which it turns right-handed; W axes.
    pub about: [f64; 3],
    /// What the axis turns: tool or workpiece.
    pub turns: RotarySide,
    /// A point of the axis: of a table in W, of a head from the tip of the tool.
    pub through_mm: Option<[f64; 3]>,
    /// Least and greatest angle of the axis, degrees.
    pub travel_deg: Option<[f64; 2]>,
}

/// What becomes of contours in cutter radius compensation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CutterCompensation {
    /// They become the path of the tool centre.
    Off,
}

/// When X, Y and Z are coordinates of the tip while A, B and C turn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RotaryTip {
    /// After G43.4 or its like.
    #[default]
    AsProgrammed,
    /// Whatever the program says.
    Always,
}

/// The table `limits`: limits of corrections and drive forces.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LimitsSpec {
    /// Most |Δρ| of a drive.
    pub max_correction_mm: Option<f64>,
    /// Most change of Δρ between neighbouring points.
    pub max_correction_change_mm: Option<f64>,
    /// Most force of a drive.
    #[serde(rename = "force_limit_N")]
    pub force_limit: Option<f64>,
    /// The error norm to minimise where the limits bind.
    #[serde(default)]
    pub objective: ErrorNorm,
    /// Most that a compensated program may leave its path by where the cutting force is absent.
    pub unloaded_gouge_mm: Option<f64>,
}

/// The table `compensate`: what is compensated, and force blending at corners.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CompensateTable {
    /// What is brought onto the path: position or full pose.
    #[serde(default)]
    pub target: Target,
    /// Along a program, the length after a corner over which the cutting force is blended from one move to the next; 2 if not given.
    pub corner_mm: Option<f64>,
}

/// The table `gcode`: what a G-code program does not say itself, and how it is written.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GcodeSpec {
    /// The dialect of programs; what their text shows if not given.
    pub dialect: Option<Dialect>,
    /// Zero of G54 in W; W itself if not given, unless the program begins with another.
    pub g54_mm: Option<[f64; 3]>,
    /// Zero of G55 in W; not known if not given, like those that follow.
    pub g55_mm: Option<[f64; 3]>,
    /// Zero of G56 in W.
    pub g56_mm: Option<[f64; 3]>,
    /// Zero of G57 in W.
    pub g57_mm: Option<[f64; 3]>,
    /// Zero of G58 in W.
    pub g58_mm: Option<[f64; 3]>,
    /// Zero of G59 in W.
    pub g59_mm: Option<[f64; 3]>,
    /// Zeros of the others in W, by name: `G59.1`, `G54.1 P7`.
    #[serde(default)]
    pub offsets_mm: BTreeMap<String, [f64; 3]>,
    /// Position of the tool before the program begins, W; unknown if not given.
    pub start_mm: Option<[f64; 3]>,
    /// The unit before the first G20 or G21; mm if not given.
    pub unit: Option<LengthUnit>,
    /// Whether lines with a leading `/` run or are skipped.
    #[serde(default)]
    pub block_delete: BlockDelete,
    /// The reference of I, J and K before the first G90.1 or G91.1.
    #[serde(default)]
    pub arc_centres: ArcCentres,
    /// The rotary axes A, B and C, from the base of the machine outwards; none if not given.
    #[serde(default)]
    pub rotary: RotaryList,
    /// How the tool stands in programs without A, B and C, from its tip to the spindle, W; along the normal of their plane if not given.
    pub tool_axis: Option<[f64; 3]>,
    /// When X, Y and Z are coordinates of the tip while A, B and C turn.
    #[serde(default)]
    pub rotary_tip: RotaryTip,
    /// Whether programs are expanded into their moves before they are read; if not given, only those that cannot be read otherwise.
    pub expand: Option<bool>,
    /// Numbers of programs that are called and move nothing.
    #[serde(default)]
    pub calls_kept: Vec<u32>,
    /// Whether contours in cutter radius compensation are written as the path of the tool centre.
    pub cutter_compensation: Option<CutterCompensation>,
    /// Radii of cutters for it, mm, by name: `D1`, `T3`.
    #[serde(default)]
    pub cutter_radius_mm: BTreeMap<String, f64>,
    /// Decimals of coordinates written in mm; those of the program if not given.
    pub decimals_mm: Option<u8>,
    /// Decimals of coordinates written in inches; those of the program if not given.
    pub decimals_inch: Option<u8>,
    /// How far from corrected points written arcs and lines may pass; 0.005, or a tenth of `tolerance_mm` if that is less.
    pub write_tolerance_mm: Option<f64>,
    /// Whether a flat arc may be written as a helical one; true if not given.
    pub helical_arcs: Option<bool>,
}
