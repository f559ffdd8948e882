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

/// Where a number stands that has a name.
pub(super) enum Slot<'a> {
    Number(&'a mut f64),
    Stiffness(&'a mut StiffnessSpec),
    /// The two entries of a symmetric matrix that are one number.
    Entry(&'a mut [[f64; 6]; 6], usize, usize),
}

impl Slot<'_> {
    /// Its number; `None` where it is unknown.
    pub fn value(&self) -> Option<f64> {
        match self {
            Slot::Number(number) => Some(**number),
            Slot::Stiffness(StiffnessSpec::Known(number)) => Some(*number),
            Slot::Stiffness(StiffnessSpec::Unknown) => None,
            Slot::Entry(rows, row, column) => Some(rows[*row][*column]),
        }
    }

    /// Changes nothing where it is this number already.
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

/// A number found: its name, the key under which the file has it, and its unit.
pub(super) struct Found<'a> {
    pub name: &'a str,
    pub key: &'a str,
    pub unit: Unit,
    pub slot: Slot<'a>,
}

/// Tells `each` the numbers of `spec`; no two have the same name.
pub(super) fn walk(spec: &mut MachineSpec, each: &mut dyn FnMut(Found<'_>)) {
    let mut walk = Walk { name: String::new(), key: String::new(), taken: HashSet::new(), each };
    walk.machine(spec);
}

struct Walk<'w> {
    name: String,
    key: String,
    taken: HashSet<String>,
    each: &'w mut dyn FnMut(Found<'_>),
}

/// Goes from `path` to what is called `part` below it.
fn enter(path: &mut String, part: &str) {
    if !path.is_empty() && !part.is_empty() {
        path.push('.');
    }
    path.push_str(part);
}

impl Walk<'_> {
    /// Walks what stands below `name`, in the file below `key`.
    fn inside(&mut self, name: &str, key: &str, walk: impl FnOnce(&mut Self)) {
        let outer = (self.name.len(), self.key.len());
        enter(&mut self.name, name);
        enter(&mut self.key, key);
        walk(self);
        self.name.truncate(outer.0);
        self.key.truncate(outer.1);
    }

    fn slot(&mut self, unit: Unit, slot: Slot<'_>) {
        let mut name = self.name.clone();
        let mut other = 1;
        while self.taken.contains(&name) {
            other += 1;
            name = format!("{}_{other}", self.name);
        }
        (self.each)(Found { name: &name, key: &self.key, unit, slot });
        self.taken.insert(name);
    }

    fn number(&mut self, field: &str, unit: Unit, value: &mut f64) {
        self.inside(field, &unit.key(field), |walk| walk.slot(unit, Slot::Number(value)));
    }

    fn optional(&mut self, field: &str, unit: Unit, value: &mut Option<f64>) {
        if let Some(value) = value {
            self.number(field, unit, value);
        }
    }

    fn stiffness(&mut self, unit: Unit, value: &mut StiffnessSpec) {
        self.inside("stiffness", &unit.key("stiffness"), |walk| walk.slot(unit, Slot::Stiffness(value)));
    }

    /// Components by their names.
    fn components<const N: usize>(&mut self, field: &str, unit: Unit, names: [&str; N], values: &mut [f64; N]) {
        self.inside(field, &unit.key(field), |walk| {
            for (name, value) in names.into_iter().zip(values) {
                walk.inside(name, "", |walk| walk.slot(unit, Slot::Number(value)));
            }
        });
    }

    fn vector(&mut self, field: &str, unit: Unit, values: &mut [f64; 3]) {
        self.components(field, unit, AXES, values);
    }

    fn interval(&mut self, field: &str, unit: Unit, values: &mut Option<[f64; 2]>) {
        if let Some(values) = values {
            self.components(field, unit, ["min", "max"], values);
        }
    }

    fn machine(&mut self, spec: &mut MachineSpec) {
        let MachineSpec {
            schema: _,
            name: _,
            title: _,
            source: _,
            provenance: _,
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
        } = spec;
        self.inside("platform", "platform", |walk| walk.platform(platform));
        self.vector("gravity", Unit::M_PER_S2, gravity.get_or_insert(GRAVITY));
        let HomeSpec { position_mm, rotation_deg } = home;
        self.inside("home", "home", |walk| {
            walk.vector("position", Unit::MM, position_mm);
            walk.vector("rotation", Unit::DEG, rotation_deg);
        });
        let BoxSpec { min_mm, max_mm } = workspace;
        self.inside("workspace", "workspace", |walk| {
            walk.vector("min", Unit::MM, min_mm);
            walk.vector("max", Unit::MM, max_mm);
        });
        for (name, MaterialSpec { youngs_modulus, shear_modulus }) in material {
            let path = format!("material.{name}");
            self.inside(&path, &path, |walk| {
                walk.number("youngs_modulus", Unit::N_PER_MM2, youngs_modulus);
                walk.number("shear_modulus", Unit::N_PER_MM2, shear_modulus);
            });
        }
        for (i, ChainSpec { name, elements }) in chain.iter_mut().enumerate() {
            let names = ElementSpec::names(elements);
            self.inside(name, &format!("chain[{i}]"), |walk| {
                for (e, (element, name)) in elements.iter_mut().zip(names).enumerate() {
                    let key = format!("elements[{e}].{}", element.kind_and_name().0);
                    walk.inside(&name, &key, |walk| walk.element(element));
                }
            });
        }
        self.mounts("mount", mount);
        if let Some(CarrierSpec { name, chain: _, base }) = workpiece_carrier {
            self.inside(name, "workpiece_carrier", |walk| walk.inside("base", "base", |walk| walk.frame(base)));
        }
    }

    fn platform(&mut self, spec: &mut PlatformSpec) {
        let PlatformSpec { tool_tip_mm, tool_axis, tool, mass, controls: _ } = spec;
        self.vector("tool_tip", Unit::MM, tool_tip_mm);
        if let Some(axis) = tool_axis {
            self.vector("tool_axis", Unit::ONE, axis);
        }
        if let Some(tool) = tool {
            self.inside("tool", "tool", |walk| walk.tool(tool));
        }
        if let Some(MassSpec { kg, at_mm }) = mass {
            self.inside("mass", "mass", |walk| walk.mass(kg, at_mm));
        }
    }

    fn tool(&mut self, spec: &mut ToolSpec) {
        let ToolSpec { compliance, cutter } = spec;
        self.compliance(compliance);
        if let Some(CutterSpec { diameter_mm, stick_out_mm, material: _ }) = cutter {
            self.inside("cutter", "cutter", |walk| {
                walk.number("diameter", Unit::MM, diameter_mm);
                walk.number("stick_out", Unit::MM, stick_out_mm);
            });
        }
    }

    fn compliance(&mut self, rows: &mut Option<Box<[[f64; 6]; 6]>>) {
        if let Some(rows) = rows {
            let units = [Unit::MM_PER_N, Unit::RAD_PER_N, Unit::RAD_PER_NMM];
            self.matrix("compliance", "compliance_mm_rad_N", units, rows);
        }
    }

    fn mass(&mut self, kg: &mut f64, at_mm: &mut [f64; 3]) {
        self.number("kg", Unit::KG, kg);
        self.vector("at", Unit::MM, at_mm);
    }

    fn mounts(&mut self, key: &str, mounts: &mut [MountSpec]) {
        for (i, MountSpec { name, chain: _, base, platform }) in mounts.iter_mut().enumerate() {
            self.inside(name, &format!("{key}[{i}]"), |walk| {
                walk.inside("base", "base", |walk| walk.frame(base));
                walk.inside("platform", "platform", |walk| walk.frame(platform));
            });
        }
    }

    fn frame(&mut self, spec: &mut FrameSpec) {
        let FrameSpec { position_mm, x_axis, y_axis, rotation_deg } = spec;
        self.vector("position", Unit::MM, position_mm);
        for (field, axis) in [("x_axis", x_axis), ("y_axis", y_axis)] {
            if let Some(axis) = axis {
                self.vector(field, Unit::ONE, axis);
            }
        }
        if let Some(rotation) = rotation_deg {
            self.vector("rotation", Unit::DEG, rotation);
        }
    }

    fn element(&mut self, element: &mut ElementSpec) {
        match element {
            ElementSpec::Fixed(FixedSpec { name: _, translation_mm, rotation_deg }) => {
                self.vector("translation", Unit::MM, translation_mm);
                self.vector("rotation", Unit::DEG, rotation_deg);
            }
            ElementSpec::PrismaticDrive(drive) => self.prismatic_drive(drive),
            ElementSpec::RevoluteDrive(drive) => self.revolute_drive(drive),
            ElementSpec::PrismaticJoint(joint) => {
                let PrismaticJointSpec { name: _, axis: _, home_mm, limits_mm, stiffness, neutral_mm } = joint;
                self.number("home", Unit::MM, home_mm);
                self.interval("limits", Unit::MM, limits_mm);
                self.optional("stiffness", Unit::N_PER_MM, stiffness);
                self.number("neutral", Unit::MM, neutral_mm);
            }
            ElementSpec::RevoluteJoint(joint) => {
                let RevoluteJointSpec { name: _, axis: _, home_deg, limits_deg, stiffness, neutral_deg } = joint;
                self.number("home", Unit::DEG, home_deg);
                self.interval("limits", Unit::DEG, limits_deg);
                self.optional("stiffness", Unit::NMM_PER_RAD, stiffness);
                self.number("neutral", Unit::DEG, neutral_deg);
            }
            ElementSpec::Beam(BeamSpec { name: _, length_mm, advance_mm, section, material: _ }) => {
                self.number("length", Unit::MM, length_mm);
                self.optional("advance", Unit::MM, advance_mm);
                self.inside("", "section", |walk| walk.section(section));
            }
            ElementSpec::Link(link) => self.link(link),
            ElementSpec::Parallelogram(spec) => self.parallelogram(spec),
            ElementSpec::UniversalJoint(UniversalJointSpec { name: _, axes, home_deg, limits_deg }) => {
                self.hinges(axes.map(|axis| AXES[axis as usize]), home_deg, limits_deg);
            }
            ElementSpec::SphericalJoint(SphericalJointSpec { name: _, home_deg, limits_deg }) => {
                self.hinges(AXES, home_deg, limits_deg);
            }
            ElementSpec::Mass(NamedMassSpec { name: _, kg, at_mm }) => self.mass(kg, at_mm),
            ElementSpec::Frame(_) => {}
            ElementSpec::Spring(spring) => self.point_spring(spring),
            ElementSpec::Module(ModuleSpec { name: _, mounts }) => self.mounts("mounts", mounts),
        }
    }

    fn prismatic_drive(&mut self, drive: &mut PrismaticDriveSpec) {
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
        self.stiffness(Unit::N_PER_MM, stiffness);
        self.optional("shaft_stiffness", Unit::N_PER_MM, shaft_stiffness);
        self.number("home", Unit::MM, home_mm);
        self.interval("travel", Unit::MM, travel_mm);
        self.optional("force_limit", Unit::N, force_limit);
        self.optional("backlash", Unit::MM, backlash_mm);
        self.optional("friction", Unit::N, friction);
        self.shown(shown);
    }

    fn revolute_drive(&mut self, drive: &mut RevoluteDriveSpec) {
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
        self.stiffness(Unit::NMM_PER_RAD, stiffness);
        self.optional("shaft_stiffness", Unit::NMM_PER_RAD, shaft_stiffness);
        self.number("home", Unit::DEG, home_deg);
        self.interval("travel", Unit::DEG, travel_deg);
        self.optional("torque_limit", Unit::NMM, torque_limit);
        self.optional("backlash", Unit::DEG, backlash_deg);
        self.optional("friction", Unit::NMM, friction);
        self.shown(shown);
    }

    fn shown(&mut self, shown: &mut Option<ShownSpec>) {
        let Some(ShownSpec { of, offset_deg, offset_mm }) = shown else { return };
        self.inside("shown", "shown", |walk| {
            walk.inside("of", "of", |walk| {
                of.iter_mut().for_each(|(name, factor)| walk.number(name, Unit::ONE, factor))
            });
            walk.optional("offset", Unit::DEG, offset_deg);
            walk.optional("offset", Unit::MM, offset_mm);
        });
    }

    fn hinges<const N: usize>(&mut self, axes: [&str; N], home: &mut [f64; N], limits: &mut Option<[[f64; 2]; N]>) {
        self.components("home", Unit::DEG, axes, home);
        let Some(limits) = limits else { return };
        self.inside("limits", "limits_deg", |walk| {
            for (i, (axis, [min, max])) in axes.into_iter().zip(limits).enumerate() {
                walk.inside(axis, "", |walk| {
                    walk.key += &format!("[{i}]");
                    walk.inside("min", "", |walk| walk.slot(Unit::DEG, Slot::Number(min)));
                    walk.inside("max", "", |walk| walk.slot(Unit::DEG, Slot::Number(max)));
                });
            }
        });
    }

    fn parallelogram(&mut self, spec: &mut ParallelogramSpec) {
        let ParallelogramSpec { name: _, length_mm, width_mm, bar_section, material: _, home_deg, limits_deg } = spec;
        self.number("length", Unit::MM, length_mm);
        self.number("width", Unit::MM, width_mm);
        self.inside("bar_section", "bar_section", |walk| walk.section(bar_section));
        self.number("home", Unit::DEG, home_deg);
        self.interval("limits", Unit::DEG, limits_deg);
    }

    fn section(&mut self, section: &mut SectionSpec) {
        match section {
            SectionSpec::Rectangle(RectangleSpec { width_mm, height_mm }) => {
                self.lengths("rectangle", [("width", width_mm), ("height", height_mm)]);
            }
            SectionSpec::Round(RoundSpec { diameter_mm }) => self.lengths("round", [("diameter", diameter_mm)]),
            SectionSpec::Tube(TubeSpec { outer_diameter_mm, inner_diameter_mm }) => {
                let diameters = [("outer_diameter", outer_diameter_mm), ("inner_diameter", inner_diameter_mm)];
                self.lengths("tube", diameters);
            }
            SectionSpec::IBeam(IBeamSpec { width_mm, height_mm, flange_mm, web_mm }) => {
                let outside = [("width", width_mm), ("height", height_mm)];
                self.lengths("i_beam", outside);
                self.lengths("i_beam", [("flange", flange_mm), ("web", web_mm)]);
            }
            SectionSpec::Box(BoxSectionSpec { width_mm, height_mm, wall_mm }) => {
                self.lengths("box", [("width", width_mm), ("height", height_mm), ("wall", wall_mm)]);
            }
            SectionSpec::TaperedTube(TaperedTubeSpec { start_diameter_mm, end_diameter_mm, wall_mm }) => {
                let diameters = [("start_diameter", start_diameter_mm), ("end_diameter", end_diameter_mm)];
                self.lengths("tapered_tube", diameters);
                self.lengths("tapered_tube", [("wall", wall_mm)]);
            }
        }
    }

    /// Lengths of a cross-section, the word for whose shape is no part of their names.
    fn lengths<const N: usize>(&mut self, shape: &str, lengths: [(&str, &mut f64); N]) {
        self.inside("", shape, |walk| {
            for (field, length) in lengths {
                walk.number(field, Unit::MM, length);
            }
        });
    }

    fn link(&mut self, link: &mut LinkSpec) {
        let LinkSpec { name: _, advance_mm, stiffness, compliance } = link;
        self.number("advance", Unit::MM, advance_mm);
        if let Some(rows) = stiffness {
            let units = [Unit::N_PER_MM, Unit::N_PER_RAD, Unit::NMM_PER_RAD];
            self.matrix("stiffness", "stiffness_N_mm_rad", units, rows);
        }
        self.compliance(compliance);
    }

    /// The upper triangle of a symmetric matrix; units by how many of row and column are rotations.
    fn matrix(&mut self, name: &str, key: &str, units: [Unit; 3], rows: &mut [[f64; 6]; 6]) {
        self.inside(name, key, |walk| {
            for (row, column) in (0..6).flat_map(|row| (row..6).map(move |column| (row, column))) {
                let unit = units[usize::from(row > 2) + usize::from(column > 2)];
                let entry = format!("{}_{}", ROWS[row], ROWS[column]);
                walk.inside(&entry, "", |walk| walk.slot(unit, Slot::Entry(rows, row, column)));
            }
        });
    }

    fn point_spring(&mut self, spring: &mut PointSpringSpec) {
        let PointSpringSpec { name: _, from, to, stiffness, free_length_mm, preload } = spring;
        for (end, AnchorSpec { frame: _, at_mm }) in [("from", from), ("to", to)] {
            self.inside(end, end, |walk| walk.vector("at", Unit::MM, at_mm));
        }
        self.number("stiffness", Unit::N_PER_MM, stiffness);
        self.number("free_length", Unit::MM, free_length_mm);
        self.number("preload", Unit::N, preload);
    }
}
