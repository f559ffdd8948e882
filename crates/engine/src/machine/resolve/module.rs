//! Parallel modules (closed loops within a chain), from a machine file as written.
//!
//! One of a module's chains becomes part of the route that goes on behind it; each of the others is a loop between the frames where the module
//! starts and ends. The route takes the chain that leaves its end the least freedom: a rigid one is then no loop, which could not be condensed.

use super::{MAX_COORDINATES, chain::ChainBuilder, design_index};
use crate::{
    input::{check::Check, error::Result},
    machine::{
        Loop, Route, Step,
        spec::{ElementSpec, MachineSpec, ModuleSpec, MountSpec},
    },
};

/// Whether a module of any chain design uses the design called `name`.
pub(super) fn is_design_used(spec: &MachineSpec, name: &str) -> bool {
    let elements = spec.chain.iter().flat_map(|chain| &chain.elements);
    elements
        .filter_map(|element| if let ElementSpec::Module(module) = element { Some(module) } else { None })
        .any(|module| module.mounts.iter().any(|mount| mount.chain == name))
}

/// Modules within modules go no deeper than this.
const DEEPEST: usize = 8;

impl ChainBuilder<'_> {
    /// Appends a module: its chain with the fewest passive joints continues the route, the others become loops.
    pub fn add_module(&mut self, module: &ModuleSpec, check: &Check) -> Result<()> {
        if module.mounts.len() < 2 {
            let problem = format!("a module needs two chains or more, got {}", module.mounts.len());
            return check.key("mounts").fail(problem);
        }
        let mut ways: Vec<(String, Route)> = Vec::new();
        let mut freedoms: Vec<usize> = Vec::new();
        for (i, mount) in module.mounts.iter().enumerate() {
            let check = check.key(&format!("mounts[{i}]"));
            check.key("name").identifier(&mount.name)?;
            check.key("name").unique(&mount.name, module.mounts[..i].iter().map(|m| m.name.as_str()))?;
            let before = self.chain.passive.len();
            ways.push((format!("{}{}", self.prefix, mount.name), self.mount_route(mount, &check)?));
            freedoms.push(self.chain.passive.len() - before);
        }
        let least = freedoms.iter().copied().enumerate().min_by_key(|&(i, freedom)| (freedom, i));
        let main = least.map_or(0, |(i, _)| i);
        let (_, route) = ways.remove(main);
        let from = self.ensure_frame();
        self.append_route(route);
        let to = self.ensure_frame();
        self.route.loops.extend(ways.into_iter().map(|(name, route)| Loop { name, from, to, route }));
        Ok(())
    }

    /// Builds the route of one chain of a module and keeps the route under way.
    fn mount_route(&mut self, mount: &MountSpec, check: &Check) -> Result<Route> {
        let design = design_index(self.spec, &mount.chain, &check.key("chain"))?;
        if self.designs.contains(&design) {
            return check.key("chain").fail(format!("chain \"{}\" would be a part of itself", mount.chain));
        }
        if self.designs.len() > DEEPEST {
            return check.key("chain").fail(format!("modules may stand in modules {DEEPEST} deep at most"));
        }
        let coordinates = self.chain.coordinate_count();
        let outer_route = std::mem::take(&mut self.route);
        let outer_frames = std::mem::take(&mut self.frames);
        let outer_springs = std::mem::take(&mut self.springs);
        let prefix = format!("{}{}_", self.prefix, mount.name);
        let outer_prefix = std::mem::replace(&mut self.prefix, prefix);
        self.add_route(design, mount, check)?;
        self.prefix = outer_prefix;
        self.springs = outer_springs;
        self.frames = outer_frames;
        if self.chain.coordinate_count() == coordinates {
            let problem = "the chain has neither a joint nor an elastic element (drive, beam, link, parallelogram), so the \
                           module is rigid";
            return check.key("chain").fail(problem.into());
        }
        // Modules within modules multiply.
        if self.chain.coordinate_count() > MAX_COORDINATES {
            let problem = format!(
                "expected at most {MAX_COORDINATES} coordinates of joints and springs, got more up to this one"
            );
            return check.key("chain").fail(problem);
        }
        Ok(std::mem::replace(&mut self.route, outer_route))
    }

    /// Appends the route `inner`, its masses, springs and loops to the route under way.
    fn append_route(&mut self, inner: Route) {
        // Its frames keep their order behind those there are.
        let first = self.route.steps.iter().filter(|step| matches!(step, Step::Frame)).count();
        self.add_fixed(inner.base);
        self.route.steps.extend(inner.steps);
        self.add_fixed(inner.attachment);
        self.route.masses.extend(inner.masses.into_iter().map(|mut mass| {
            mass.frame += first;
            mass
        }));
        self.route.bodies.extend(inner.bodies.into_iter().map(|mut body| {
            body.frame += first;
            body
        }));
        self.route.point_springs.extend(inner.point_springs.into_iter().map(|mut spring| {
            for anchor in [&mut spring.from, &mut spring.to] {
                anchor.frame = anchor.frame.map(|frame| frame + first);
            }
            spring
        }));
        self.route.loops.extend(inner.loops.into_iter().map(|mut inner| {
            (inner.from, inner.to) = (inner.from + first, inner.to + first);
            inner
        }));
    }
}
