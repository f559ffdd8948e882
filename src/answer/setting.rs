//! What reports say of a load case: setting, cautions, and the views and captions of its maps.

use nalgebra::Vector3;

use crate::{
    answer::{
        cautions,
        machine::{described, error_facts, marks},
    },
    files::words::{counted, typographic, with_minus_signs},
    machine::{ChainError, Machine, ToolAxisSource},
    page::{Column, Description, Explorer, Fact, Group, Quantity, Shape},
    process::MillingForce,
    simulation::LoadCase,
    spatial::Grid,
};

impl LoadCase {
    /// Returns the cautions about results over `positions` of P (O, mm), each called a `noun`, and about process tables that are `not_used`.
    pub(crate) fn cautions(
        &self,
        not_used: &[&str],
        noun: &str,
        positions: impl Iterator<Item = Vector3<f64>>,
    ) -> String {
        self.force_of_turn.clone()
            + &cautions::unused_tables(not_used)
            + &cautions::machine_cautions(&self.machine, &self.errors, noun, positions)
    }

    /// Returns the facts about machine and force, those of the question (`own`), and those about chain errors, in the order of the page.
    pub(crate) fn facts(&self, own: impl IntoIterator<Item = Fact>) -> Vec<Fact> {
        let MillingForce { radial, tangential, axial, .. } = self.force;
        let forces = format!("{radial} N radial, {tangential} N tangential, {axial} N axial");
        let acting =
            [Fact::new("cutting force", typographic(&forces)), Fact::new("tool axis", tool_axis_fact(&self.machine))];
        facts_of(&self.machine, &self.errors, acting.into_iter().chain(own))
    }

    /// Returns the fact that the worst of all tool angles counts, labelled `label`.
    pub(crate) fn angles_fact(&self, label: &str) -> Fact {
        Fact::new(label, format!("{} over a turn; the worst counts", self.phis.len()))
    }

    /// Starts the page of a result of `kind`, whose positions are of `what`.
    pub(crate) fn description(&self, kind: &str, what: &str) -> Description {
        Description {
            terms: vec![Fact::new("Positions", format!("of {what}, from the origin of the machine's base"))],
            ..Description::new(kind, described(&self.machine))
        }
    }

    /// Returns the interactive view of a `table` over a grid.
    pub(crate) fn view(&self, title: &str, table: &str, group: Option<Group>, quantities: Vec<Quantity>) -> Explorer {
        grid_view(&self.machine, title, table, group, quantities)
    }

    /// Returns the components of the cutting force in words, for captions.
    pub(crate) fn force_text(&self) -> String {
        let MillingForce { radial, tangential, axial, .. } = self.force;
        with_minus_signs(&format!("force {radial} / {tangential} / {axial} N (radial / tangential / axial)"))
    }

    /// Returns of which tool angles and force the worst is shown, for captions.
    pub(crate) fn worst_text(&self) -> String {
        format!("worst of {}, {}", counted(self.phis.len(), "tool angle"), self.force_text())
    }
}

/// Returns the facts about `machine`, those of the question (`own`), and those about locked drives and chain errors.
pub(crate) fn facts_of(machine: &Machine, errors: &[ChainError], own: impl IntoIterator<Item = Fact>) -> Vec<Fact> {
    let mut facts = vec![Fact::new("machine", machine.title.clone())];
    facts.extend(own);
    facts.extend(locked_fact(machine));
    facts.extend(error_facts(machine, errors));
    facts
}

/// Returns the fact about axes that are locked or commanded by the path; `None` without any.
pub(crate) fn locked_fact(machine: &Machine) -> Option<Fact> {
    machine.locked_text().map(|text| Fact::new("locked or external axes", text))
}

/// Returns the interactive view of a table over a grid of positions of P, from its title and the name of its file.
pub(crate) fn grid_view(
    machine: &Machine,
    title: &str,
    table: &str,
    group: Option<Group>,
    quantities: Vec<Quantity>,
) -> Explorer {
    Explorer {
        title: title.into(),
        table: table.into(),
        shape: Shape::Grid,
        coordinates: ["x", "y", "z"].map(|axis| Column::new(format!("{axis}_mm"), axis, "mm")).into(),
        group,
        quantities,
        marks: marks(machine),
    }
}

/// Returns the size of a grid as text: "3 × 4 × 5".
pub(crate) fn size_text(grid: &Grid) -> String {
    let [nx, ny, nz] = grid.counts();
    format!("{nx} × {ny} × {nz}")
}

/// Returns why a tool axis is assumed that the machine file does not give; empty if it does.
pub(crate) fn tool_axis_text(source: ToolAxisSource) -> &'static str {
    match source {
        ToolAxisSource::Given => "",
        ToolAxisSource::TowardsTip => " (assumed: from P to the tool tip)",
        ToolAxisSource::PlatformZ => " (assumed: z of the platform, as the tool tip is P)",
    }
}

/// Returns the tool axis at home and the signs of forces about it, in words.
fn tool_axis_fact(machine: &Machine) -> String {
    format!(
        "{} of the base at home, from the spindle to the tip{}; radial pushes the tool along φ, tangential along φ + 90°, \
         negative axial into the spindle",
        typographic(&direction((machine.home.pose.rotation * machine.tool_axes).column(2).into())),
        tool_axis_text(machine.tool_axis_source)
    )
}

/// Returns a unit vector as text with components rounded to 0.001, without a minus sign before zero.
pub(crate) fn direction(v: Vector3<f64>) -> String {
    let [x, y, z]: [f64; 3] = v.map(|c| (c * 1e3).round() / 1e3 + 0.0).into();
    format!("({x}, {y}, {z})")
}
