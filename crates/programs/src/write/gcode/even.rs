//! Corrections of lines that run several times, made equal where they differ by less than the written decimals.

use std::{
    borrow::Cow,
    collections::{BTreeMap, BTreeSet},
    ops::Range,
};

use nalgebra::Vector3;

use crate::{
    model::{NumberFormat, PathPoint, Toolpath, gcode::LengthUnit},
    read::gcode::{Expansion, GcodeProgram, Origin},
};

impl GcodeProgram {
    /// Returns `corrected_mm`, one position for each point of `path`, with equal corrections in all runs of a line that runs several times,
    /// where they differ by at most a unit of the last decimal. Unchanged unless the program keeps its calls.
    pub(crate) fn even_out_corrections<'a>(
        &self,
        path: &Toolpath,
        corrected_mm: &'a [Vector3<f64>],
        format: NumberFormat,
    ) -> Cow<'a, [Vector3<f64>]> {
        let Some(expansion) = self.expansion.as_ref().filter(|expansion| expansion.keeps_calls) else {
            return Cow::Borrowed(corrected_mm);
        };
        let points = path.points();
        let mut evened = Cow::Borrowed(corrected_mm);
        let unit_mm = resolution_mm(format);
        for runs in self.repeated_lines(expansion, points) {
            let runs: Vec<Range<usize>> = runs.into_iter().map(|(_, points)| points).collect();
            if runs.iter().any(|run| run.len() != runs[0].len()) {
                continue;
            }
            for k in 0..runs[0].len() {
                let moved = |run: &Range<usize>| corrected_mm[run.start + k] - points[run.start + k].position_mm;
                let least = runs.iter().map(moved).reduce(|one, other| one.inf(&other)).unwrap_or_default();
                let most = runs.iter().map(moved).reduce(|one, other| one.sup(&other)).unwrap_or_default();
                if least != most && (most - least).amax() <= unit_mm {
                    for run in &runs {
                        evened.to_mut()[run.start + k] = points[run.start + k].position_mm + (least + most) / 2.0;
                    }
                }
            }
        }
        evened
    }

    /// Returns the expanded lines (from 1) whose source line runs several times and ends at the same corrected position each time.
    pub(crate) fn lines_corrected_alike(&self, path: &Toolpath, corrected_mm: &[Vector3<f64>]) -> BTreeSet<usize> {
        let Some(expansion) = &self.expansion else { return BTreeSet::new() };
        let end = |points: &Range<usize>| corrected_mm[points.end - 1];
        let is_alike = |runs: &Vec<(usize, Range<usize>)>| {
            runs.iter().all(|(_, points)| (end(points) - end(&runs[0].1)).amax() < NumberFormat::FINEST)
        };
        let alike = self.repeated_lines(expansion, path.points()).into_iter().filter(is_alike);
        alike.flatten().map(|(line, _)| line).collect()
    }

    /// Groups the expanded lines (from 1) that come from the same source line which runs several times, with the ranges of their points.
    fn repeated_lines(&self, expansion: &Expansion, points: &[PathPoint]) -> Vec<Vec<(usize, Range<usize>)>> {
        let line_of = |point: &PathPoint| self.motions.get(point.source.segment).map(|motion| motion.line);
        let mut runs: BTreeMap<Origin, Vec<(usize, Range<usize>)>> = BTreeMap::new();
        let mut first = 0;
        for of_line in points.chunk_by(|one, next| line_of(one) == line_of(next)) {
            let range = first..first + of_line.len();
            first = range.end;
            if let Some(line) = line_of(&of_line[0]) {
                runs.entry(expansion.origin(line)).or_default().push((line, range));
            }
        }
        runs.into_values().filter(|runs| runs.len() > 1).collect()
    }
}

/// Returns the smaller of the last written decimals of mm and inch coordinates, mm.
fn resolution_mm(format: NumberFormat) -> f64 {
    let unit = |unit: LengthUnit, decimals: u8| unit.mm() * 10_f64.powi(-i32::from(decimals));
    unit(LengthUnit::Millimetre, format.mm_decimals()).min(unit(LengthUnit::Inch, format.inch_decimals()))
}
