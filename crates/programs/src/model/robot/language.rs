//! The languages of robot and APT programs, and the options for what programs do not say themselves.

use std::{collections::BTreeMap, path::Path};

use nalgebra::{Isometry3, UnitQuaternion};

use crate::model::{NumberFormat, robot::RobotFault};

/// A language that programs of poses are written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Language {
    /// KUKA Robot Language.
    Krl,
    /// RAPID of ABB.
    Rapid,
    /// TP programs of FANUC as listings (LS).
    Ls,
    /// URScript of Universal Robots.
    UrScript,
    /// APT, and the CLDATA of CAM systems as text.
    Apt,
}

impl Language {
    /// Detects the language by the file's extension and, for `mod` and `prg`, by its first words; of others, APT by its records. `None` if it
    /// is no robot or APT program.
    #[must_use]
    pub fn detect(file: &Path, bytes: &[u8]) -> Option<Language> {
        let extension = file.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        match extension.as_str() {
            "src" => Some(Language::Krl),
            "apt" | "aptsource" | "cl" | "cls" | "clsf" | "ncl" | "cldata" => Some(Language::Apt),
            // Creo counts versions behind the name: part.ncl.1
            version
                if version.bytes().all(|byte| byte.is_ascii_digit())
                    && Path::new(file.file_stem()?)
                        .extension()
                        .is_some_and(|stem| stem.eq_ignore_ascii_case("ncl")) =>
            {
                Some(Language::Apt)
            }
            // A binary .tp is refused with what makes a listing of it.
            "script" | "urscript" => Some(Language::UrScript),
            "ls" | "tp" => Some(Language::Ls),
            "modx" => Some(Language::Rapid),
            "mod" | "prg" => {
                first_words(bytes).any(|word| matches!(word.as_str(), "MODULE" | "PROC")).then_some(Language::Rapid)
            }
            _ => has_apt_motion(bytes).then_some(Language::Apt),
        }
    }

    /// Whether poses have three angles A, B, C in degrees.
    pub(crate) fn has_degrees(self) -> bool {
        matches!(self, Language::Krl | Language::Ls)
    }

    /// Returns the language's name for sentences.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Language::Krl => "KRL",
            Language::Rapid => "RAPID",
            Language::Ls => "FANUC LS",
            Language::UrScript => "URScript",
            Language::Apt => "APT",
        }
    }

    /// Returns in words which motions may cut: those along a path.
    pub fn cutting_motions(self) -> &'static str {
        match self {
            Language::Krl => "LIN, CIRC and splines",
            Language::Rapid => "MoveL and MoveC",
            Language::Ls => "L and C",
            Language::UrScript => "movel, movep and movec",
            Language::Apt => "motions without RAPID",
        }
    }

    /// Returns the value of the key `language` in reports.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Language::Krl => "krl",
            Language::Rapid => "rapid",
            Language::Ls => "fanuc_ls",
            Language::UrScript => "urscript",
            Language::Apt => "apt",
        }
    }
}

/// Iterates over the first word of each line of a file, in capitals.
fn first_words(bytes: &[u8]) -> impl Iterator<Item = String> {
    bytes.split(|byte| matches!(byte, b'\n' | b'\r')).map(|line| {
        let line = line.trim_ascii_start();
        let end = line.iter().position(|byte| !byte.is_ascii_alphanumeric()).unwrap_or(line.len());
        String::from_utf8_lossy(&line[..end]).to_ascii_uppercase()
    })
}

/// Whether a record of the first lines of a file is GOTO or FROM of APT, which a slash follows.
fn has_apt_motion(bytes: &[u8]) -> bool {
    let lines = bytes.split(|byte| matches!(byte, b'\n' | b'\r')).take(LINES_TO_DETECT);
    lines.map(<[u8]>::trim_ascii_start).any(|line| {
        let (word, behind) = line.split_at_checked(4).unwrap_or_default();
        (word.eq_ignore_ascii_case(b"GOTO") || word.eq_ignore_ascii_case(b"FROM"))
            && behind.trim_ascii_start().starts_with(b"/")
    })
}

/// Lines in which a motion of APT is looked for.
const LINES_TO_DETECT: usize = 2000;

/// What a robot or APT program does not say itself: its tool frame, bases, external axes and harmless calls.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct RobotOptions {
    /// Orientation of the frame of the tool, as the program has it, in the platform or flange: `R_PN`. Of a tool that
    /// the program defines itself, its own counts; that of the flange if `None`.
    pub tool_rotation: Option<UnitQuaternion<f64>>,
    /// Poses in the workpiece frame W, mm, of bases or work objects by their names, small letters: `base_data[3]`,
    /// `wobj1`; `world` is the frame in which the program itself says where its bases are.
    pub bases: BTreeMap<String, Isometry3<f64>>,
    /// Whether the tool stands and the robot holds the part: frames of work objects are in the flange then, and those of tools in the base.
    pub is_tool_stationary: bool,
    /// What the external axes E1, E2, … of the program move, as columns of a path name it: `external_rail_mm`. Those
    /// that are not named must stand still.
    pub external_axes: Vec<String>,
    /// Subprograms, by names in small letters, that do not move the tool.
    pub calls_kept: Vec<String>,
    /// Which points an APT program has under CUTCOM, where it does not say so itself.
    pub cutcom_points: Option<CutcomPoints>,
    /// Whether what the program says of the posture of the arm is ignored: how its drives count is not how the robot counts them.
    pub ignores_configuration: bool,
}

/// What the points of an APT program under CUTCOM are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CutcomPoints {
    /// Those of the tool centre: the control only adds the wear of the tool.
    ToolCentre,
    /// Those of the contour, from which the control offsets the tool.
    Contour,
}

impl RobotOptions {
    /// The name under which `bases` has the frame in which a program says where its bases are.
    pub const WORLD: &'static str = "world";

    /// Whether the subprogram `name` is known not to move the tool.
    pub(crate) fn keeps_call(&self, name: &str) -> bool {
        self.calls_kept.iter().any(|kept| kept.eq_ignore_ascii_case(name))
    }

    /// Refuses a call of `name` unless it is known not to move the tool.
    pub(crate) fn check_call(&self, name: &str) -> Result<(), RobotFault> {
        if self.keeps_call(name) { Ok(()) } else { Err(RobotFault::Call { name: name.to_owned() }) }
    }
}

/// Numbers of decimals of rotation components and of external axes in the written poses of a robot program.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Decimals {
    pub rotation: u8,
    pub external: u8,
}

impl Decimals {
    /// Creates the format with the decimals that the source uses, at least 4 (degrees) or 6 for rotations, so that the tip of a long tool
    /// stays in place, and at least 3 for external axes.
    pub fn of_source(language: Language, rotation: usize, external: usize) -> Decimals {
        let least = if language.has_degrees() { 4 } else { 6 };
        let clamp =
            |seen: usize, least: u8| u8::try_from(seen).unwrap_or(u8::MAX).clamp(least, NumberFormat::MAX_DECIMALS);
        Decimals { rotation: clamp(rotation, least), external: clamp(external, 3) }
    }
}
