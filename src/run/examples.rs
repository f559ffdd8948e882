//! The example studies in `studies/`, which are part of the program: where it is installed, their folder is not.

use crate::input::error::{Error, Result};

/// An example study.
#[derive(Debug)]
pub struct Example {
    /// Name of its folder.
    pub name: &'static str,
    /// Names and bytes of its files.
    pub files: &'static [(&'static str, &'static [u8])],
}

/// The list of examples: of each the name and its files.
macro_rules! examples {
    ($($name:literal: $($file:literal)*;)*) => {
        /// The example studies, in the order of their names.
        pub const EXAMPLES: &[Example] = &[$(Example {
            name: $name,
            files: &[$(($file, include_bytes!(concat!("../../studies/", $name, "/", $file)))),*],
        }),*];
    };
}

examples! {
    "01_workspace_map": "README.md" "study.toml";
    "02_groove_50mm": "README.md" "groove.nc" "process.toml" "process_middle.toml" "process_program.toml" "study.toml";
    "03_placement_circle": "README.md" "process.toml" "study.toml";
    "04_placement_pocket": "README.md" "make_pocket.py" "pocket.nc" "process.toml" "study.toml";
    "05_superposition": "README.md" "study.toml";
    "06_paper": "README.md" "process.toml" "process_against_feed.toml" "process_platform_point.toml" "process_reversed_errors.toml" "process_rotated.toml" "study.toml";
    "07_robot_arm": "README.md" "process.toml" "study.toml";
    "07_robot_arm_fitted": "README.md" "machine.toml" "study.toml";
    "07_robot_arm_path": "README.md" "process.toml" "study.toml";
    "08_three_architectures": "README.md" "process.toml" "study.toml";
    "08_three_architectures_3puu": "README.md" "study.toml";
    "08_three_architectures_orthoglide": "README.md" "study.toml";
    "09_robot_part": "README.md" "make_pocket.py" "pocket.src" "process.toml" "study.toml";
    "09_robot_part_path": "README.md" "pocket.src" "process.toml" "study.toml";
    "10_five_axis": "README.md" "cone.nc" "make_cone.py" "process.toml" "study.toml";
    "11_online": "README.md" "process.toml" "study.toml";
    "12_paper_numbers": "README.md" "machine.toml" "process.toml" "study.toml";
}

impl Example {
    /// Returns the example called `name`, or the only one whose name begins so.
    ///
    /// # Errors
    /// There is none, or there are several.
    pub fn named(name: &str) -> Result<&'static Example> {
        let matching: Vec<&Example> =
            EXAMPLES.iter().filter(|example| !name.is_empty() && example.name.starts_with(name)).collect();
        let list = |of: &[&Example]| of.iter().map(|example| example.name).collect::<Vec<_>>().join(", ");
        let problem = match (matching.iter().find(|example| example.name == name), matching.as_slice()) {
            (Some(example), _) | (None, [example]) => return Ok(example),
            (None, []) => {
                format!("no example is called \"{name}\"; there are: {}", list(&EXAMPLES.iter().collect::<Vec<_>>()))
            }
            (None, several) => {
                format!("\"{name}\" begins the names of several examples: expected one of {}", list(several))
            }
        };
        Err(Error::argument("--example", problem))
    }

    /// Returns the other examples of which this one reads files, by paths such as `../07_robot_arm/process.toml`.
    pub fn neighbours(&self) -> impl Iterator<Item = &'static Example> {
        let texts: Vec<&str> = self.files.iter().filter_map(|(_, bytes)| std::str::from_utf8(bytes).ok()).collect();
        EXAMPLES.iter().filter(move |other| texts.iter().any(|text| text.contains(&format!("\"../{}/", other.name))))
    }
}
