//! A cutter named in one line, as `D=10,z=4,ae=5,ap=8,fz=0.08,cut=down,n=8000`: its law is that of [`end_milling`](super::tool_force).

use super::{
    force_spec::{CutSpec, EndMillingSpec},
    tool_force::end_milling,
};
use crate::{
    input::{
        check::Check,
        error::{Error, Result},
    },
    process::cutting::{CutForce, CuttingLaw, EndMilling},
};

/// A cut of an end mill: its law, feed per tooth and spindle speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cutter {
    /// The law of its force.
    pub law: EndMilling,
    /// Feed per tooth, mm.
    pub feed_per_tooth_mm: f64,
    /// Speed of the spindle, if it is given.
    pub rev_per_min: Option<f64>,
}

impl Cutter {
    /// Reads a cutter: `D` its diameter, `ae` and `ap` width and depth of the cut, `fz` the feed per tooth, in mm; `z` teeth, `cut` (`up` or
    /// `down`), `n` rev/min, and with a material of Kienzle's law `kr` and `ka`, radial and axial force as shares of the tangential one.
    ///
    /// # Errors
    /// A key that is unknown, given twice, missing or out of range, or a `material` that is not known.
    pub fn parse(text: &str, material: &str) -> Result<Self> {
        let mut spec = EndMillingSpec { material: Some(material.into()), ..EndMillingSpec::default() };
        let (mut rev_per_min, mut given) = (None, Vec::new());
        for entry in text.split(',') {
            let Some((key, value)) = entry.split_once('=').map(|(key, value)| (key.trim(), value.trim())) else {
                return Err(unread(entry, "expected entries such as D=10"));
            };
            if given.contains(&key) {
                return Err(unread(entry, "is given twice"));
            }
            given.push(key);
            let number = || value.parse::<f64>().map_err(|_| unread(entry, "expected a number"));
            match key {
                "D" => spec.diameter_mm = Some(number()?),
                "z" => spec.teeth = Some(value.parse().map_err(|_| unread(entry, "expected a whole number"))?),
                "ae" => spec.radial_width_mm = Some(number()?),
                "ap" => spec.axial_depth_mm = Some(number()?),
                "fz" => spec.feed_per_tooth_mm = Some(number()?),
                "n" => rev_per_min = Some(number()?),
                "kr" => spec.radial_ratio = Some(number()?),
                "ka" => spec.axial_ratio = Some(number()?),
                "cut" => {
                    spec.cut = Some(match value {
                        "up" => CutSpec::Up,
                        "down" => CutSpec::Down,
                        _ => return Err(unread(entry, "expected cut=up or cut=down")),
                    });
                }
                _ => return Err(unread(entry, "expected D, z, ae, ap, fz, cut, n, kr and ka")),
            }
        }
        let check = Check::new("--cutter");
        let rev_per_min = check.key("n").optional_positive(rev_per_min)?;
        match (end_milling(&spec, &check)?, spec.feed_per_tooth_mm) {
            (CuttingLaw::EndMilling(law), Some(feed_per_tooth_mm)) => Ok(Self { law, feed_per_tooth_mm, rev_per_min }),
            _ => check.key("fz").fail("missing: expected the feed per tooth in mm".into()),
        }
    }

    /// Returns the mean force and torque over a turn of the spindle.
    #[must_use]
    pub fn force(&self) -> CutForce {
        self.law.force(self.feed_per_tooth_mm)
    }

    /// Returns the mean power at the spindle, W, if its speed is known: that of the torque.
    #[must_use]
    pub fn power_watts(&self) -> Option<f64> {
        let rad_per_s = self.rev_per_min? * std::f64::consts::TAU / 60.0;
        Some(self.force().torque_Nmm.abs() / 1e3 * rad_per_s)
    }

    /// Returns the feed, mm/min; `None` without a spindle speed.
    #[must_use]
    pub fn feed_mm_per_min(&self) -> Option<f64> {
        Some(self.feed_per_tooth_mm * f64::from(self.law.teeth) * self.rev_per_min?)
    }
}

/// Returns the error that `entry` of a cutter is not read.
fn unread(entry: &str, problem: &str) -> Error {
    Error::argument("--cutter", format!("{entry}: {problem}"))
}
