//! What hangs on the frames of a route, from a machine file as written: masses, names, springs between points.

use kinetostat_cell::spec::BodySpec;

use super::chain::ChainBuilder;
use crate::{
    input::{check::Check, error::Result},
    machine::{
        Anchor, HungBody, MachineBody, Mass, PointSpring, Step,
        spec::{AnchorSpec, NamedMassSpec},
    },
};

/// The frame of the machine's base.
const BASE: &str = "O";

impl ChainBuilder<'_> {
    /// Index of the frame reached, marked by a new [`Step::Frame`] unless the last step is one.
    pub fn ensure_frame(&mut self) -> usize {
        if !matches!(self.route.steps.last(), Some(Step::Frame)) {
            self.route.steps.push(Step::Frame);
        }
        self.route.steps.iter().filter(|step| matches!(step, Step::Frame)).count() - 1
    }

    /// Hangs a mass on the frame reached.
    pub fn add_mass(&mut self, mass: &NamedMassSpec, check: &Check) -> Result<()> {
        let kilograms = check.key("kg").positive(mass.kg)?;
        let at = check.key("at_mm").position(mass.at_mm)?;
        let frame = self.ensure_frame();
        self.route.masses.push(Mass { frame, at, kilograms });
        Ok(())
    }

    /// Hangs a body on the frame reached; its name has that of its mount before it where the design is mounted several times.
    pub fn add_body(&mut self, body: &BodySpec, check: &Check) -> Result<()> {
        let design = self.designs.last().map(|design| self.spec.chain[*design].name.as_str());
        let is_shared = self.spec.mount.iter().filter(|mount| Some(mount.chain.as_str()) == design).count() > 1;
        let prefix = if is_shared { format!("{} ", self.chain.name) } else { self.prefix.replace('_', " ") };
        let body = MachineBody::resolve(body, &prefix, check)?;
        let frame = self.ensure_frame();
        self.route.bodies.push(HungBody { frame, body });
        Ok(())
    }

    /// Gives the frame reached a name that no other of the route has.
    pub fn name_frame(&mut self, name: &str, check: &Check) -> Result<()> {
        check.identifier(name)?;
        if name == BASE {
            return check.fail(format!("\"{BASE}\" is the machine's base: expected another name"));
        }
        check.unique(name, self.frames.iter().map(|(name, _)| name.as_str()))?;
        let frame = self.ensure_frame();
        self.frames.push((name.into(), frame));
        Ok(())
    }

    /// Adds the springs collected for the route under way, all of whose frames are named now.
    pub fn add_springs(&mut self) -> Result<()> {
        for (number, (spec, check)) in std::mem::take(&mut self.springs).into_iter().enumerate() {
            let mut from = self.resolve_anchor(&spec.from, &check.key("from"))?;
            let mut to = self.resolve_anchor(&spec.to, &check.key("to"))?;
            if from.frame == to.frame {
                let problem = format!(
                    "is the frame of `from` too, \"{}\": a spring between a frame and itself has no effect",
                    spec.to.frame
                );
                return check.key("to.frame").fail(problem);
            }
            if from.frame > to.frame {
                std::mem::swap(&mut from, &mut to);
            }
            let spring_name = spec.name.clone().unwrap_or_else(|| format!("spring_{}", number + 1));
            check.key("name").identifier(&spring_name)?;
            let name = format!("{}{spring_name}", self.prefix);
            check.key("name").unique(&name, self.route.point_springs.iter().map(|spring| spring.name.as_str()))?;
            let free_check = check.key("free_length_mm");
            let free_length = free_check.finite_scalar(spec.free_length_mm)?;
            if free_length < 0.0 {
                return free_check.fail(format!("must be 0 or more, got {free_length:?}"));
            }
            self.route.point_springs.push(PointSpring {
                name,
                from,
                to,
                stiffness: check.key("stiffness_N_per_mm").positive(spec.stiffness)?,
                free_length,
                preload: check.key("preload_N").finite_scalar(spec.preload)?,
            });
        }
        self.frames.clear();
        Ok(())
    }

    /// Resolves an anchor: in a named frame of the route or, outside modules, in O.
    fn resolve_anchor(&self, spec: &AnchorSpec, check: &Check) -> Result<Anchor> {
        let at = check.key("at_mm").position(spec.at_mm)?;
        let is_inner = !self.designs.is_empty();
        let frame = match self.frames.iter().find(|(name, _)| *name == spec.frame) {
            Some((_, frame)) => Some(*frame),
            None if spec.frame == BASE && !is_inner => None,
            None => {
                let outer = if is_inner { None } else { Some(BASE) };
                let known: Vec<&str> =
                    outer.into_iter().chain(self.frames.iter().map(|(name, _)| name.as_str())).collect();
                let known = if known.is_empty() { "none".into() } else { known.join(", ") };
                let problem = format!("no frame of this chain is called \"{}\"; there are: {known}", spec.frame);
                return check.key("frame").fail(problem);
            }
        };
        Ok(Anchor { frame, at })
    }
}
