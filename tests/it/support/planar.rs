//! Small machines with closed-form behaviour, as machine files.

use kinetostat::machine::Machine;

use super::engine::machine_from;

const HEAD: &str = r#"
schema = 1
title = "test machine"
workspace = { min_mm = [0.0, 0.0, 0.0], max_mm = [0.0, 0.0, 0.0] }
[material.steel]
youngs_modulus_N_per_mm2 = 210000.0
shear_modulus_N_per_mm2 = 80000.0
"#;

/// A 6×6 stiffness with `translation` N/mm and `rotation` N·mm/rad on the diagonal, as TOML.
pub fn diagonal_link(translation: f64, rotation: f64) -> String {
    let row = |i: usize| {
        let entry = if i < 3 { translation } else { rotation };
        let row: Vec<String> = (0..6).map(|j| if i == j { format!("{entry:e}") } else { "0.0".into() }).collect();
        format!("[{}]", row.join(", "))
    };
    let rows: Vec<String> = (0..6).map(row).collect();
    format!("{{ link = {{ advance_mm = 0.0, stiffness_N_mm_rad = [{}] }} }}", rows.join(", "))
}

/// A mounted chain: its name, elements (TOML, one per entry) and mount keys.
pub struct Leg {
    pub name: &'static str,
    pub elements: Vec<String>,
    pub mount: String,
}

impl Leg {
    pub fn new(name: &'static str, elements: &[&str], mount: &str) -> Self {
        Self { name, elements: elements.iter().map(ToString::to_string).collect(), mount: mount.into() }
    }
}

/// A machine of these legs with its home at `home_mm`, controlling `controls`.
pub fn machine(name: &str, home_mm: [f64; 3], controls: &str, legs: &[Leg]) -> Machine {
    let mut toml = format!("name = \"{name}\"\n{HEAD}");
    let platform = format!("platform = {{ tool_tip_mm = [0.0, 0.0, 0.0], controls = [{controls}] }}\n");
    let home = format!("home = {{ position_mm = {home_mm:?} }}\n");
    toml.insert_str(0, &(platform + &home));
    for Leg { name, elements, mount } in legs {
        let elements = elements.join(",\n  ");
        toml += &format!("[[chain]]\nname = \"{name}\"\nelements = [\n  {elements},\n]\n");
        toml += &format!("[[mount]]\nname = \"{name}\"\nchain = \"{name}\"\n{mount}\n");
    }
    machine_from(&toml)
}
