//! What a scene says of itself in an answer: setting, cautions, the views and captions of its maps.

use nalgebra::Vector3;

use crate::{
    answer::cautions,
    files::words::{counted, signed, typographic},
    machine::{ChainError, Machine, NamedPoint, ToolAxisSource},
    page::{Column, Description, Explorer, Fact, Group, MachineDescription, Mark, Quantity, Shape, error_facts},
    process::MillingForce,
    simulation::Scene,
    spatial::Grid,
};

impl Scene {
    /// What must be known with an answer over `positions` of P (O, mm), each of which is a `noun`, and which has `not_used` these tables of a process.
    pub(crate) fn cautions(
        &self,
        not_used: &[&str],
        noun: &str,
        positions: impl Iterator<Item = Vector3<f64>>,
    ) -> String {
        cautions::not_used(not_used) + &cautions::of_machine(&self.machine, &self.errors, noun, positions)
    }

    /// The setting: machine and force, what is the question's `own`, and errors.
    pub(crate) fn facts(&self, own: impl IntoIterator<Item = Fact>) -> Vec<Fact> {
        let MillingForce { radial, tangential, axial, .. } = self.force;
        let forces = format!("{radial} N radial, {tangential} N tangential, {axial} N axial");
        let acting =
            [Fact::new("cutting force", typographic(&forces)), Fact::new("tool axis", tool_axis_fact(&self.machine))];
        facts_of(&self.machine, &self.errors, acting.into_iter().chain(own))
    }

    /// The fact that the worst of all tool angles counts; `label` is what it calls them.
    pub(crate) fn angles_fact(&self, label: &str) -> Fact {
        Fact::new(label, format!("{} over a turn; the worst counts", self.phis.len()))
    }

    /// A result of `kind`, the positions in which are of `what`.
    pub(crate) fn description(&self, kind: &str, what: &str) -> Description {
        Description {
            terms: vec![Fact::new("Positions", format!("of {what}, from the origin of the machine's base"))],
            ..Description::new(kind, MachineDescription::new(&self.machine))
        }
    }

    /// A view of a `table` over a grid.
    pub(crate) fn view(&self, title: &str, table: &str, group: Option<Group>, quantities: Vec<Quantity>) -> Explorer {
        grid_view(&self.machine, (title, table), group, quantities)
    }

    /// The cutting force as captions of pictures have it.
    pub(crate) fn force_words(&self) -> String {
        let MillingForce { radial, tangential, axial, .. } = self.force;
        signed(&format!("force {radial} / {tangential} / {axial} N (radial / tangential / axial)"))
    }

    /// Under what it is the worst, as captions have it.
    pub(crate) fn worst_words(&self) -> String {
        format!("worst of {}, {}", counted(self.phis.len(), "tool angle"), self.force_words())
    }
}

/// The setting of any answer: `machine`, what is the question's `own`, locked drives, and `errors`.
pub(crate) fn facts_of(machine: &Machine, errors: &[ChainError], own: impl IntoIterator<Item = Fact>) -> Vec<Fact> {
    let mut facts = vec![Fact::new("machine", machine.title.clone())];
    facts.extend(own);
    facts.extend(locked_fact(machine));
    facts.extend(error_facts(machine, errors));
    facts
}

/// Where the drives stand that serve no task: locked, or commanded by the path.
pub(crate) fn locked_fact(machine: &Machine) -> Option<Fact> {
    machine.locked_words().map(|words| Fact::new("locked or external axes", words))
}

/// A view of a table over a grid of positions of P: its title, and the file of the table.
pub(crate) fn grid_view(
    machine: &Machine,
    (title, table): (&str, &str),
    group: Option<Group>,
    quantities: Vec<Quantity>,
) -> Explorer {
    let mark =
        |point: &NamedPoint| Mark { label: point.name.clone(), position: point.position.iter().copied().collect() };
    Explorer {
        title: title.into(),
        table: table.into(),
        shape: Shape::Grid,
        coordinates: ["x", "y", "z"].map(|axis| Column::new(format!("{axis}_mm"), axis, "mm")).into(),
        group,
        quantities,
        marks: machine.points.iter().map(mark).collect(),
    }
}

/// The size of a grid: "3 × 4 × 5".
pub(crate) fn size_words(grid: &Grid) -> String {
    let [nx, ny, nz] = grid.counts();
    format!("{nx} × {ny} × {nz}")
}

/// Of a tool axis that the machine file does not give, why it is assumed.
pub(crate) fn tool_axis_words(source: ToolAxisSource) -> &'static str {
    match source {
        ToolAxisSource::Given => "",
        ToolAxisSource::TowardsTip => " (assumed: from P to the tool tip)",
        ToolAxisSource::PlatformZ => " (assumed: z of the platform, as the tool tip is P)",
    }
}

/// The tool axis at home and the signs of forces about it.
fn tool_axis_fact(machine: &Machine) -> String {
    format!(
        "{} of the base at home, from the spindle to the tip{}; radial pushes the tool along φ, tangential along φ + 90°, \
         negative axial into the spindle",
        typographic(&direction((machine.home.pose.rotation * machine.tool_axes).column(2).into())),
        tool_axis_words(machine.tool_axis_source)
    )
}

/// Rounded components of a unit vector, without a minus sign before zero.
pub(crate) fn direction(v: Vector3<f64>) -> String {
    let [x, y, z]: [f64; 3] = v.map(|c| (c * 1e3).round() / 1e3 + 0.0).into();
    format!("({x}, {y}, {z})")
}
