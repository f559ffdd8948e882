//! Which force within a turn of the spindle a verdict rests on, and which one would be right.

use super::{
    Process,
    cutting::{CuttingLaw, EdgeLaw, EndMilling, MeanOrPeak, PathLoad, SlotMilling},
};
use crate::{process::CutPath, toolpath::PathPoint};

/// The force of a law of milling on which a verdict rests: its mean over a turn or its peak within it.
///
/// A machine with the natural frequency f answers the part of the force that changes at the frequency f_t of the teeth by `1 / |1 − (f_t/f)²|` of what it would answer at rest.
/// Where f is below a third of f_t that is less than an eighth, and the mean is right; where f is above three times f_t it is within an eighth of 1, and the tool is where
/// the force of the instant has it. Between them neither is.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(non_snake_case, reason = "the units are N and Hz, not n and hz")]
pub struct VerdictForce {
    /// The one that is computed with.
    pub rests_on: MeanOrPeak,
    /// Mean over a turn and peak within it where the mean is largest, N: to two per cent; the peak is that of straight teeth.
    pub mean_N: f64,
    /// See there.
    pub peak_N: f64,
    /// Least and largest frequency at which teeth pass, Hz; `None` without spindle speed.
    pub teeth_Hz: Option<[f64; 2]>,
    /// Lowest natural frequency that is given, Hz.
    pub natural_Hz: Option<f64>,
}

/// Which force within a turn is right for where the tool is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RightForce {
    /// The mean: the machine is too slow for the teeth.
    Mean,
    /// The peak: it follows each of them.
    Peak,
    /// It swings.
    Neither,
    /// A frequency is not known.
    Unknown,
}

/// A natural frequency so many times below or above that of the teeth is far from it.
const FAR: f64 = 3.0;

impl RightForce {
    /// Its name in files; `None` if it is not known.
    #[must_use]
    pub fn label(self) -> Option<&'static str> {
        match self {
            RightForce::Mean => Some("mean"),
            RightForce::Peak => Some("peak"),
            RightForce::Neither => Some("neither"),
            RightForce::Unknown => None,
        }
    }
}

impl MeanOrPeak {
    /// Its name.
    #[must_use]
    pub fn label(self) -> &'static str {
        if self == MeanOrPeak::Mean { "mean" } else { "peak" }
    }
}

impl VerdictForce {
    /// Returns that of `path` by the laws of `process`; `None` where no law of milling gives a force.
    #[must_use]
    pub fn of(process: &Process, path: &CutPath) -> Option<Self> {
        let (mut found, mut teeth_hz) = (None::<Self>, None::<[f64; 2]>);
        let natural = lowest_natural_hz(process);
        for (k, point) in path.points().iter().enumerate().filter(|own| own.1.cutting) {
            let law = process.own_forces.law_at(point).unwrap_or(&process.cutting);
            let least = found.as_ref().map_or(0.0, |own| own.mean_N * (1.0 + LARGER));
            let Some((teeth, forces)) = forces(law, path, (k, point), least) else { continue };
            if let Some(own) =
                teeth.zip(point.spindle_rev_per_min).map(|(teeth, speed)| f64::from(teeth) * speed / 60.0)
            {
                teeth_hz = Some(teeth_hz.map_or([own; 2], |[low, high]| [low.min(own), high.max(own)]));
            }
            if let Some((rests_on, mean, peak)) = forces {
                found = Some(Self { rests_on, mean_N: mean, peak_N: peak, teeth_Hz: None, natural_Hz: natural });
            }
        }
        let teeth_hz = teeth_hz.or_else(|| process.stock.as_ref().and_then(|stock| stock.teeth_hz(path)));
        found.map(|own| Self { teeth_Hz: teeth_hz, ..own })
    }

    /// Returns that of the cut of an end mill at its own feed per tooth, without a spindle speed; `None` of another law.
    #[must_use]
    pub fn of_cut(process: &Process) -> Option<Self> {
        let CuttingLaw::EndMilling(own) = &process.cutting else { return None };
        let c = own.feed_per_tooth_mm?;
        let [mean, peak] = [own.mean(c), own.peak(c)].map(|cut| cut.force_N.norm());
        let natural = lowest_natural_hz(process);
        Some(Self { rests_on: own.over_turn, mean_N: mean, peak_N: peak, teeth_Hz: None, natural_Hz: natural })
    }

    /// Returns which force would be right.
    #[must_use]
    pub fn right(&self) -> RightForce {
        match (self.teeth_Hz, self.natural_Hz) {
            (Some([low, _]), Some(own)) if FAR * own < low => RightForce::Mean,
            (Some([_, high]), Some(own)) if own > FAR * high => RightForce::Peak,
            (Some(_), Some(_)) => RightForce::Neither,
            _ => RightForce::Unknown,
        }
    }

    /// Returns in sentences which force it is, and whether that is right.
    #[must_use]
    pub fn sentence(&self) -> String {
        let Self { rests_on, mean_N, peak_N, .. } = self;
        let teeth = self.teeth_Hz.map(|[low, high]| match high - low < 0.5 {
            true => format!("teeth pass at {low:.0} Hz"),
            false => format!("teeth pass at {low:.0} to {high:.0} Hz"),
        });
        let own = self.natural_Hz.map_or_else(String::new, |own| format!("the first natural frequency is {own} Hz"));
        let wrong = |right: MeanOrPeak| if right == *rests_on { "" } else { ", which this is not" };
        let why = match (self.right(), teeth) {
            (RightForce::Mean, Some(teeth)) => {
                format!("{teeth}, {own}, below a third of that: the mean is right{}", wrong(MeanOrPeak::Mean))
            }
            (RightForce::Peak, Some(teeth)) => {
                format!("{teeth}, {own}, above three times that: the peak is right{}", wrong(MeanOrPeak::Peak))
            }
            (RightForce::Neither, Some(teeth)) => {
                format!("{teeth}, {own}, between a third and three times that: neither is right, the tool swings")
            }
            (_, Some(teeth)) => format!("{teeth}; which of both is right is not known without natural_frequencies_Hz"),
            (_, None) => "which of both is right is not known without a spindle speed".into(),
        };
        format!(
            "The verdict rests on the {} of the force over a turn of the spindle: mean {mean_N:.0} N, peak {peak_N:.0} N where it is largest; {why}.\n",
            rests_on.label()
        )
    }
}

fn lowest_natural_hz(process: &Process) -> Option<f64> {
    process.natural_frequencies_hz.iter().copied().reduce(f64::min)
}

/// A mean force that is larger than those before by less, as a share, is the same.
const LARGER: f64 = 1e-9;

/// The number of teeth, where the law has it, and which force it is, mean and peak, N, where the mean is at least `least`; `None` for what is no law of milling.
type Forces = Option<(Option<u32>, Option<(MeanOrPeak, f64, f64)>)>;

fn forces(law: &CuttingLaw, path: &CutPath, (k, point): (usize, &PathPoint), least: f64) -> Forces {
    let of = |own: &EndMilling, c: f64| {
        let mean = own.mean(c).force_N.norm();
        (mean > least).then(|| (own.over_turn, mean, own.peak(c).force_N.norm()))
    };
    match law {
        CuttingLaw::EndMilling(own) => Some((Some(own.teeth), of(own, own.feed_per_tooth(point).ok()?))),
        CuttingLaw::SlotMilling(own) => {
            Some((Some(own.teeth), of(&as_wide_as_cutter(own), own.feed_per_tooth(point).ok()?)))
        }
        CuttingLaw::EngagedMilling(_) => {
            let mean = match law.load(point).ok()? {
                PathLoad::Workpiece(load) => load.force_N.norm(),
                _ => 0.0,
            };
            let peak = path.engagements().get(k).and_then(|own| own.peak_N).filter(|_| mean > least);
            Some((None, peak.map(|peak| (MeanOrPeak::Mean, mean, f64::from(peak)))))
        }
        _ => None,
    }
}

/// Returns the same slot as a cut of the side of an end mill, whose force does not depend on its diameter.
fn as_wide_as_cutter(own: &SlotMilling) -> EndMilling {
    EndMilling {
        edge: EdgeLaw::Linear { tangential: own.tangential, radial: own.radial, axial: own.axial },
        diameter_mm: 1.0,
        teeth: own.teeth,
        depth_mm: own.depth_mm,
        width_mm: 1.0,
        direction: super::cutting::CutDirection::Up,
        feed_per_tooth_mm: own.feed_per_tooth_mm,
        spindle: own.spindle,
        over_turn: MeanOrPeak::Mean,
    }
}
