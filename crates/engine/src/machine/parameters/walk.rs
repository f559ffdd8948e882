//! A walk over the numbers of a machine file, each with its name, its key and its unit.
//!
//! Every field of a spec is named here, so that a new one cannot be forgotten.

use std::collections::HashSet;

use super::Unit;
use crate::machine::{
    spec::{
        AnchorSpec, BeamSpec, BoxSectionSpec, BoxSpec, CarrierSpec, ChainSpec, CutterSpec, ElementSpec, FixedSpec,
        FrameSpec, HomeSpec, IBeamSpec, LinkSpec, MachineSpec, MassSpec, MaterialSpec, ModuleSpec, MountSpec,
        NamedMassSpec, ParallelogramSpec, PlatformSpec, PointSpringSpec, PrismaticDriveSpec, PrismaticJointSpec,
        RectangleSpec, RevoluteDriveSpec, RevoluteJointSpec, RoundSpec, SectionSpec, ShownSpec, SphericalJointSpec,
        TaperedTubeSpec, ToolSpec, TubeSpec, UniversalJointSpec,
    },
    unknown::StiffnessSpec,
};

/// Acceleration of gravity on Earth where a machine file says nothing, m/s², in O.
pub(in crate::machine) const GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];

const AXES: [&str; 3] = ["x", "y", "z"];
/// Rows and columns of the stiffness of a link: translations, then rotations.
const ROWS: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];

/// Place of a parameter in a machine file, where it is read and set.
pub(super) enum Slot<'a> {
    Number(&'a mut f64),
    Stiffness(&'a mut StiffnessSpec),
    /// The two entries of a symmetric matrix that are one number.
    Entry(&'a mut [[f64; 6]; 6], usize, usize),
}

impl Slot<'_> {
    /// Number in the slot; `None` where it is unknown.
    pub fn value(&self) -> Option<f64> {
        match self {
            Slot::Number(number) => Some(**number),
            Slot::Stiffness(StiffnessSpec::Known(number)) => Some(*number),
            Slot::Stiffness(StiffnessSpec::Unknown) => None,
            Slot::Entry(rows, row, column) => Some(rows[*row][*column]),
        }
    }

    /// Sets the number; changes nothing where it is this number already.
    pub fn set(&mut self, value: f64) {
        if self.value() == Some(value) {
            return;
        }
        match self {
            Slot::Number(number) => **number = value,
            Slot::Stiffness(stiffness) => **stiffness = StiffnessSpec::Known(value),
            Slot::Entry(rows, row, column) => {
                rows[*row][*column] = value;
                rows[*column][*row] = value;
            }
        }
    }
}

/// A parameter found: its name, the key under which the file has it, and its unit.
pub(super) struct FoundParameter<'a> {
    pub name: &'a str,
    pub key: &'a str,
    pub unit: Unit,
    pub slot: Slot<'a>,
}

/// Calls `each` with every parameter of `spec`; no two have the same name.
pub(super) fn walk(spec: &mut MachineSpec, each: &mut dyn FnMut(FoundParameter<'_>)) {
    let mut walk = SpecWalk { name: String::new(), key: String::new(), taken: HashSet::new(), each };
    walk.visit_machine(spec);
}

/// Visits all numbers of a machine file; `name` and `key` lead to the one under way.
struct SpecWalk<'w> {
    name: String,
    key: String,
    taken: HashSet<String>,
    each: &'w mut dyn FnMut(FoundParameter<'_>),
}

/// Appends `part` to `path`, after a dot unless one of them is empty.
fn enter(path: &mut String, part: &str) {
    if !path.is_empty() && !part.is_empty() {
        path.push('.');
    }
    path.push_str(part);
}

impl SpecWalk<'_> {
    /// Calls `walk` with `name` and `key` appended to the paths of parameter names and file keys.
    fn descend(&mut self, name: &str, key: &str, walk: impl FnOnce(&mut Self)) {
        let outer = (self.name.len(), self.key.len());
        enter(&mut self.name, name);
        enter(&mut self.key, key);
        walk(self);
        self.name.truncate(outer.0);
        self.key.truncate(outer.1);
    }

    /// Reports a number under the present name, made unique by a number if need be.
    fn visit_slot(&mut self, unit: Unit, slot: Slot<'_>) {
        let mut name = self.name.clone();
        let mut other = 1;
        while self.taken.contains(&name) {
            other += 1;
            name = format!("{}_{other}", self.name);
        }
        (self.each)(FoundParameter { name: &name, key: &self.key, unit, slot });
        self.taken.insert(name);
    }

    /// Visits the number that the present table has as `field`.
    fn visit_number(&mut self, field: &str, unit: Unit, value: &mut f64) {
        self.descend(field, &unit.key(field), |walk| walk.visit_slot(unit, Slot::Number(value)));
    }

    /// Visits the number that the present table has as `field`, if it is given.
    fn visit_optional(&mut self, field: &str, unit: Unit, value: &mut Option<f64>) {
        if let Some(value) = value {
            self.visit_number(field, unit, value);
        }
    }

    /// Visits the stiffness in the present table, which may be unknown.
    fn visit_stiffness(&mut self, unit: Unit, value: &mut StiffnessSpec) {
        self.descend("stiffness", &unit.key("stiffness"), |walk| walk.visit_slot(unit, Slot::Stiffness(value)));
    }

    /// Visits the components of a vector by their `names`.
    fn visit_components<const N: usize>(&mut self, field: &str, unit: Unit, names: [&str; N], values: &mut [f64; N]) {
        self.descend(field, &unit.key(field), |walk| {
            for (name, value) in names.into_iter().zip(values) {
                walk.descend(name, "", |walk| walk.visit_slot(unit, Slot::Number(value)));
            }
        });
    }

    /// Visits the x, y and z components of the vector that the present table has as `field`.
    fn visit_vector(&mut self, field: &str, unit: Unit, values: &mut [f64; 3]) {
        self.visit_components(field, unit, AXES, values);
    }

    /// Visits both ends of the interval that the present table has as `field`, if it is given.
    fn visit_interval(&mut self, field: &str, unit: Unit, values: &mut Option<[f64; 2]>) {
        if let Some(values) = values {
            self.visit_components(field, unit, ["min", "max"], values);
        }
    }

    /// Visits the numbers of the whole machine file.
    fn visit_machine(&mut self, spec: &mut MachineSpec) {
        let MachineSpec {
            schema: _,
            name: _,
            title: _,
            source: _,
            provenance: _,
            accuracy: _,
            platform,
            gravity,
            zeroed: _,
            home,
            workspace,
            point: _,
            material,
            chain,
            mount,
            workpiece_carrier,
            body: _,
            may_touch: _,
        } = spec;
        self.descend("platform", "platform", |walk| walk.visit_platform(platform));
        self.visit_vector("gravity", Unit::M_PER_S2, gravity.get_or_insert(GRAVITY));
        let HomeSpec { position_mm, rotation_deg } = home;
        self.descend("home", "home", |walk| {
            walk.visit_vector("position", Unit::MM, position_mm);
            walk.visit_vector("rotation", Unit::DEG, rotation_deg);
        });
        let BoxSpec { min_mm, max_mm } = workspace;
        self.descend("workspace", "workspace", |walk| {
            walk.visit_vector("min", Unit::MM, min_mm);
            walk.visit_vector("max", Unit::MM, max_mm);
        });
        for (name, MaterialSpec { youngs_modulus, shear_modulus }) in material {
            let path = format!("material.{name}");
            self.descend(&path, &path, |walk| {
                walk.visit_number("youngs_modulus", Unit::N_PER_MM2, youngs_modulus);
                walk.visit_number("shear_modulus", Unit::N_PER_MM2, shear_modulus);
            });
        }
        for (i, ChainSpec { name, elements }) in chain.iter_mut().enumerate() {
            let names = ElementSpec::names(elements);
            self.descend(name, &format!("chain[{i}]"), |walk| {
                for (e, (element, name)) in elements.iter_mut().zip(names).enumerate() {
                    let key = format!("elements[{e}].{}", element.kind_and_name().0);
                    walk.descend(&name, &key, |walk| walk.visit_element(element));
                }
            });
        }
        self.visit_mounts("mount", mount);
        if let Some(CarrierSpec { name, chain: _, base }) = workpiece_carrier {
            self.descend(name, "workpiece_carrier", |walk| walk.descend("base", "base", |walk| walk.visit_frame(base)));
        }
    }

    fn visit_platform(&mut self, spec: &mut PlatformSpec) {
        let PlatformSpec { tool_tip_mm, tool_axis, tool, mass, controls: _, body: _ } = spec;
        self.visit_vector("tool_tip", Unit::MM, tool_tip_mm);
        if let Some(axis) = tool_axis {
            self.visit_vector("tool_axis", Unit::ONE, axis);
        }
        if let Some(tool) = tool {
            self.descend("tool", "tool", |walk| walk.visit_tool(tool));
        }
        let MassSpec { kg, at_mm } = mass.get_or_insert_default();
        self.descend("mass", "mass", |walk| walk.visit_mass(kg, at_mm));
    }

    fn visit_tool(&mut self, spec: &mut ToolSpec) {
        let ToolSpec { compliance, cutter } = spec;
        self.visit_compliance(compliance);
        if let Some(CutterSpec { diameter_mm, stick_out_mm, material: _ }) = cutter {
            self.descend("cutter", "cutter", |walk| {
                walk.visit_number("diameter", Unit::MM, diameter_mm);
                walk.visit_number("stick_out", Unit::MM, stick_out_mm);
            });
        }
    }

    fn visit_compliance(&mut self, rows: &mut Option<Box<[[f64; 6]; 6]>>) {
        if let Some(rows) = rows {
            let units = [Unit::MM_PER_N, Unit::RAD_PER_N, Unit::RAD_PER_NMM];
            self.visit_matrix("compliance", "compliance_mm_rad_N", units, rows);
        }
    }

    fn visit_mass(&mut self, kg: &mut f64, at_mm: &mut [f64; 3]) {
        self.visit_number("kg", Unit::KG, kg);
        self.visit_vector("at", Unit::MM, at_mm);
    }

    /// Visits the frames of all mounts of the list `key`.
    fn visit_mounts(&mut self, key: &str, mounts: &mut [MountSpec]) {
        for (i, MountSpec { name, chain: _, base, platform }) in mounts.iter_mut().enumerate() {
            self.descend(name, &format!("{key}[{i}]"), |walk| {
                walk.descend("base", "base", |walk| walk.visit_frame(base));
                walk.descend("platform", "platform", |walk| walk.visit_frame(platform));
            });
        }
    }

    fn visit_frame(&mut self, spec: &mut FrameSpec) {
        let FrameSpec { position_mm, x_axis, y_axis, rotation_deg } = spec;
        self.visit_vector("position", Unit::MM, position_mm);
        for (field, axis) in [("x_axis", x_axis), ("y_axis", y_axis)] {
            if let Some(axis) = axis {
                self.visit_vector(field, Unit::ONE, axis);
            }
        }
        if let Some(rotation) = rotation_deg {
            self.visit_vector("rotation", Unit::DEG, rotation);
        }
    }

    /// Visits the numbers of one element of a chain design.
    fn visit_element(&mut self, element: &mut ElementSpec) {
        match element {
            ElementSpec::Fixed(FixedSpec { name: _, translation_mm, rotation_deg }) => {
                self.visit_vector("translation", Unit::MM, translation_mm);
                self.visit_vector("rotation", Unit::DEG, rotation_deg);
            }
            ElementSpec::PrismaticDrive(drive) => self.visit_prismatic_drive(drive),
            ElementSpec::RevoluteDrive(drive) => self.visit_revolute_drive(drive),
            ElementSpec::PrismaticJoint(joint) => {
                let PrismaticJointSpec { name: _, axis: _, home_mm, limits_mm, stiffness, neutral_mm } = joint;
                self.visit_number("home", Unit::MM, home_mm);
                self.visit_interval("limits", Unit::MM, limits_mm);
                self.visit_optional("stiffness", Unit::N_PER_MM, stiffness);
                self.visit_number("neutral", Unit::MM, neutral_mm);
            }
            ElementSpec::RevoluteJoint(joint) => {
                let RevoluteJointSpec { name: _, axis: _, home_deg, limits_deg, stiffness, neutral_deg } = joint;
                self.visit_number("home", Unit::DEG, home_deg);
                self.visit_interval("limits", Unit::DEG, limits_deg);
                self.visit_optional("stiffness", Unit::NMM_PER_RAD, stiffness);
                self.visit_number("neutral", Unit::DEG, neutral_deg);
            }
            ElementSpec::Beam(BeamSpec { name: _, length_mm, advance_mm, section, material: _ }) => {
                self.visit_number("length", Unit::MM, length_mm);
                self.visit_optional("advance", Unit::MM, advance_mm);
                self.descend("", "section", |walk| walk.visit_section(section));
            }
            ElementSpec::Link(link) => self.visit_link(link),
            ElementSpec::Parallelogram(spec) => self.visit_parallelogram(spec),
            ElementSpec::UniversalJoint(UniversalJointSpec { name: _, axes, home_deg, limits_deg }) => {
                self.visit_axes(axes.map(|axis| AXES[axis as usize]), home_deg, limits_deg);
            }
            ElementSpec::SphericalJoint(SphericalJointSpec { name: _, home_deg, limits_deg }) => {
                self.visit_axes(AXES, home_deg, limits_deg);
            }
            ElementSpec::Mass(NamedMassSpec { name: _, kg, at_mm }) => self.visit_mass(kg, at_mm),
            ElementSpec::Frame(_) | ElementSpec::Body(_) => {}
            ElementSpec::Spring(spring) => self.visit_point_spring(spring),
            ElementSpec::Module(ModuleSpec { name: _, mounts }) => self.visit_mounts("mounts", mounts),
        }
    }

    fn visit_prismatic_drive(&mut self, drive: &mut PrismaticDriveSpec) {
        let PrismaticDriveSpec {
            name: _,
            axis: _,
            stiffness,
            shaft_stiffness,
            home_mm,
            travel_mm,
            force_limit,
            backlash_mm,
            friction,
            shown,
        } = drive;
        self.visit_stiffness(Unit::N_PER_MM, stiffness);
        self.visit_optional("shaft_stiffness", Unit::N_PER_MM, shaft_stiffness);
        self.visit_number("home", Unit::MM, home_mm);
        self.visit_interval("travel", Unit::MM, travel_mm);
        self.visit_optional("force_limit", Unit::N, force_limit);
        self.visit_optional("backlash", Unit::MM, backlash_mm);
        self.visit_optional("friction", Unit::N, friction);
        self.visit_shown(shown);
    }

    fn visit_revolute_drive(&mut self, drive: &mut RevoluteDriveSpec) {
        let RevoluteDriveSpec {
            name: _,
            axis: _,
            stiffness,
            shaft_stiffness,
            home_deg,
            travel_deg,
            torque_limit,
            backlash_deg,
            friction,
            shown,
        } = drive;
        self.visit_stiffness(Unit::NMM_PER_RAD, stiffness);
        self.visit_optional("shaft_stiffness", Unit::NMM_PER_RAD, shaft_stiffness);
        self.visit_number("home", Unit::DEG, home_deg);
        self.visit_interval("travel", Unit::DEG, travel_deg);
        self.visit_optional("torque_limit", Unit::NMM, torque_limit);
        self.visit_optional("backlash", Unit::DEG, backlash_deg);
        self.visit_optional("friction", Unit::NMM, friction);
        self.visit_shown(shown);
    }

    fn visit_shown(&mut self, shown: &mut Option<ShownSpec>) {
        let Some(ShownSpec { of, offset_deg, offset_mm }) = shown else { return };
        self.descend("shown", "shown", |walk| {
            walk.descend("of", "of", |walk| {
                of.iter_mut().for_each(|(name, factor)| walk.visit_number(name, Unit::ONE, factor))
            });
            walk.visit_optional("offset", Unit::DEG, offset_deg);
            walk.visit_optional("offset", Unit::MM, offset_mm);
        });
    }

    /// Visits the home angles and limits of crossed revolute joints about `axes`.
    fn visit_axes<const N: usize>(&mut self, axes: [&str; N], home: &mut [f64; N], limits: &mut Option<[[f64; 2]; N]>) {
        self.visit_components("home", Unit::DEG, axes, home);
        let Some(limits) = limits else { return };
        self.descend("limits", "limits_deg", |walk| {
            for (i, (axis, [min, max])) in axes.into_iter().zip(limits).enumerate() {
                walk.descend(axis, "", |walk| {
                    walk.key += &format!("[{i}]");
                    walk.descend("min", "", |walk| walk.visit_slot(Unit::DEG, Slot::Number(min)));
                    walk.descend("max", "", |walk| walk.visit_slot(Unit::DEG, Slot::Number(max)));
                });
            }
        });
    }

    fn visit_parallelogram(&mut self, spec: &mut ParallelogramSpec) {
        let ParallelogramSpec { name: _, length_mm, width_mm, bar_section, material: _, home_deg, limits_deg } = spec;
        self.visit_number("length", Unit::MM, length_mm);
        self.visit_number("width", Unit::MM, width_mm);
        self.descend("bar_section", "bar_section", |walk| walk.visit_section(bar_section));
        self.visit_number("home", Unit::DEG, home_deg);
        self.visit_interval("limits", Unit::DEG, limits_deg);
    }

    fn visit_section(&mut self, section: &mut SectionSpec) {
        match section {
            SectionSpec::Rectangle(RectangleSpec { width_mm, height_mm }) => {
                self.visit_lengths("rectangle", [("width", width_mm), ("height", height_mm)]);
            }
            SectionSpec::Round(RoundSpec { diameter_mm }) => self.visit_lengths("round", [("diameter", diameter_mm)]),
            SectionSpec::Tube(TubeSpec { outer_diameter_mm, inner_diameter_mm }) => {
                let diameters = [("outer_diameter", outer_diameter_mm), ("inner_diameter", inner_diameter_mm)];
                self.visit_lengths("tube", diameters);
            }
            SectionSpec::IBeam(IBeamSpec { width_mm, height_mm, flange_mm, web_mm }) => {
                let outside = [("width", width_mm), ("height", height_mm)];
                self.visit_lengths("i_beam", outside);
                self.visit_lengths("i_beam", [("flange", flange_mm), ("web", web_mm)]);
            }
            SectionSpec::Box(BoxSectionSpec { width_mm, height_mm, wall_mm }) => {
                self.visit_lengths("box", [("width", width_mm), ("height", height_mm), ("wall", wall_mm)]);
            }
            SectionSpec::TaperedTube(TaperedTubeSpec { start_diameter_mm, end_diameter_mm, wall_mm }) => {
                let diameters = [("start_diameter", start_diameter_mm), ("end_diameter", end_diameter_mm)];
                self.visit_lengths("tapered_tube", diameters);
                self.visit_lengths("tapered_tube", [("wall", wall_mm)]);
            }
        }
    }

    /// Visits lengths of a cross-section; `shape` is part of their keys and not of their names.
    fn visit_lengths<const N: usize>(&mut self, shape: &str, lengths: [(&str, &mut f64); N]) {
        self.descend("", shape, |walk| {
            for (field, length) in lengths {
                walk.visit_number(field, Unit::MM, length);
            }
        });
    }

    fn visit_link(&mut self, link: &mut LinkSpec) {
        let LinkSpec { name: _, advance_mm, stiffness, compliance } = link;
        self.visit_number("advance", Unit::MM, advance_mm);
        if let Some(rows) = stiffness {
            let units = [Unit::N_PER_MM, Unit::N_PER_RAD, Unit::NMM_PER_RAD];
            self.visit_matrix("stiffness", "stiffness_N_mm_rad", units, rows);
        }
        self.visit_compliance(compliance);
    }

    /// Visits the upper triangle of a symmetric matrix; units by how many of row and column are rotations.
    fn visit_matrix(&mut self, name: &str, key: &str, units: [Unit; 3], rows: &mut [[f64; 6]; 6]) {
        self.descend(name, key, |walk| {
            for (row, column) in (0..6).flat_map(|row| (row..6).map(move |column| (row, column))) {
                let unit = units[usize::from(row > 2) + usize::from(column > 2)];
                let entry = format!("{}_{}", ROWS[row], ROWS[column]);
                walk.descend(&entry, "", |walk| walk.visit_slot(unit, Slot::Entry(rows, row, column)));
            }
        });
    }

    fn visit_point_spring(&mut self, spring: &mut PointSpringSpec) {
        let PointSpringSpec { name: _, from, to, stiffness, free_length_mm, preload } = spring;
        for (end, AnchorSpec { frame: _, at_mm }) in [("from", from), ("to", to)] {
            self.descend(end, end, |walk| walk.visit_vector("at", Unit::MM, at_mm));
        }
        self.visit_number("stiffness", Unit::N_PER_MM, stiffness);
        self.visit_number("free_length", Unit::MM, free_length_mm);
        self.visit_number("preload", Unit::N, preload);
    }
}
