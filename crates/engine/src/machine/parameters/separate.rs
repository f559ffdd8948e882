//! A chain design for each mounting, so that numbers of chains that are drawn alike are parameters of their own.

use std::collections::BTreeMap;

use crate::{
    input::error::Result,
    machine::{
        Machine,
        provenance::is_named,
        refusal,
        spec::{ChainSpec, ElementSpec, MachineSpec, MountSpec, ProvenanceSpec},
    },
};

impl Machine {
    /// This machine with a chain design of its own for each mounting, called as the mount (in a module as the outer mount, a dot and the inner
    /// one): `leg.rail.stiffness` of three legs becomes `x.rail.stiffness`, `y.rail.stiffness` and `z.rail.stiffness`. A design that is mounted
    /// once keeps its name, but for that of a workpiece carrier. Beside the machine, the design of each new name.
    ///
    /// # Errors
    /// A mount is called as another design.
    pub fn with_separate_mounts(&self) -> Result<(Machine, BTreeMap<String, String>)> {
        let spec = self.definition.spec();
        let mut counts = BTreeMap::new();
        spec.mount.iter().for_each(|mount| count_mountings(spec, &mount.chain, &mut counts));
        if let Some(carrier) = &spec.workpiece_carrier {
            count_mountings(spec, &carrier.chain, &mut counts);
            // A design of its own even where it is mounted once, so that its parameters are known from the name.
            *counts.entry(carrier.chain.clone()).or_default() += 1;
        }
        let mut separate = Separation { spec, counts, chains: Vec::new(), designs: BTreeMap::new() };
        let mut new_spec = MachineSpec::clone(spec);
        for mount in &mut new_spec.mount {
            separate.visit_mount("", mount);
        }
        if let Some(carrier) = &mut new_spec.workpiece_carrier {
            carrier.chain = separate.design_of(&carrier.name, &carrier.chain);
        }
        let Separation { chains, designs, .. } = separate;
        if designs.is_empty() {
            return Ok((self.clone(), designs));
        }
        if let Some(name) = designs.keys().find(|name| chains.iter().filter(|chain| chain.name == **name).count() > 1) {
            let problem = "is the name of a mount and of another chain design: parameters of the mount would be called as those of the design";
            return Err(refusal(name, problem.into()));
        }
        new_spec.chain = chains;
        let names = super::names(&new_spec);
        let parts_of = |chain: &str, parts: Vec<String>| -> Vec<String> {
            let patterns = parts.iter().map(|part| format!("{chain}.{part}"));
            patterns.filter(|pattern| names.iter().any(|name| is_named(name, pattern))).collect()
        };
        let elements = |copy: &str, design: Option<&str>| -> Vec<String> {
            let Some(design) = design else { return parts_of(copy, vec!["base".into(), "platform".into()]) };
            let of_design = spec.chain.iter().filter(|chain| chain.name == design);
            parts_of(copy, of_design.flat_map(|chain| ElementSpec::names(&chain.elements)).collect())
        };
        new_spec.provenance =
            spec.provenance.iter().flat_map(|entry| separate_entries(entry, &designs, &elements)).collect();
        Ok((self.rebuild_from(new_spec)?, designs))
    }
}

/// Adds to `counts` how often the design called `name` is mounted, and the designs of its modules.
fn count_mountings(spec: &MachineSpec, name: &str, counts: &mut BTreeMap<String, usize>) {
    *counts.entry(name.into()).or_default() += 1;
    let elements = spec.chain.iter().filter(|chain| chain.name == name).flat_map(|chain| &chain.elements);
    for element in elements {
        if let ElementSpec::Module(module) = element {
            module.mounts.iter().for_each(|mount| count_mountings(spec, &mount.chain, counts));
        }
    }
}

/// Designs of a machine as they are given to each mounting.
struct Separation<'a> {
    spec: &'a MachineSpec,
    counts: BTreeMap<String, usize>,
    /// Designs so far, those that are mounted once among them.
    chains: Vec<ChainSpec>,
    /// The design that each new one is a copy of, by name.
    designs: BTreeMap<String, String>,
}

impl Separation<'_> {
    /// Gives `mount`, which is called by the mounts `around` it, a design of its own.
    fn visit_mount(&mut self, around: &str, mount: &mut MountSpec) {
        mount.chain = self.design_of(&format!("{around}{}", mount.name), &mount.chain);
    }

    /// Name of the design that the mount called `name` has instead of `design`.
    fn design_of(&mut self, name: &str, design: &str) -> String {
        let is_shared = self.counts.get(design).is_some_and(|count| *count > 1);
        let new_name = if is_shared { name } else { design };
        let Some(mut chain) = self.spec.chain.iter().find(|chain| chain.name == design).cloned() else {
            return design.into();
        };
        chain.name = new_name.into();
        for element in &mut chain.elements {
            if let ElementSpec::Module(module) = element {
                module.mounts.iter_mut().for_each(|mount| self.visit_mount(&format!("{name}."), mount));
            }
        }
        self.chains.push(chain);
        if is_shared {
            self.designs.insert(new_name.into(), design.into());
        }
        new_name.into()
    }
}

/// The entry of provenance for parameters of the copies in `designs`: one for each copy where it has an interval, which is about one number. `parts`
/// are the parts of a chain by the names of copy and design, or of its mount.
fn separate_entries(
    entry: &ProvenanceSpec,
    designs: &BTreeMap<String, String>,
    parts: &dyn Fn(&str, Option<&str>) -> Vec<String>,
) -> Vec<ProvenanceSpec> {
    let copies = |pattern: &String| -> Vec<String> {
        let copies_in = |(copy, design): (&String, &String)| match pattern.strip_prefix(design.as_str()) {
            Some("") => parts(copy, Some(design)),
            Some(rest) if rest.starts_with('.') => vec![format!("{copy}{rest}")],
            _ => Vec::new(),
        };
        // A mount and the copy of a design in it have the same name.
        if designs.contains_key(pattern) {
            return parts(pattern, None);
        }
        let copies: Vec<String> = designs.iter().flat_map(copies_in).collect();
        if copies.is_empty() { vec![pattern.clone()] } else { copies }
    };
    let parameters: Vec<String> = entry.parameters.iter().flat_map(copies).collect();
    let with = |parameters: Vec<String>| ProvenanceSpec { parameters, ..entry.clone() };
    match entry.interval {
        Some(_) => parameters.into_iter().map(|name| with(vec![name])).collect(),
        None => vec![with(parameters)],
    }
}
