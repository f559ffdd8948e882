//! Paths through the points of a polyline file, split like the moves of a program.

use crate::{
    model::{Load, PathPoint, PointSource, Rewritable, Sampling, Toolpath, direction, even_parameters},
    read::polyline::{Polyline, PolylineError, PolylineFault},
};

impl Polyline {
    /// Returns the path through the points of the file, straight between them and split as `sampling` says; the segment of a point is the
    /// row, from 0, that it leads to. Rapid moves (`cutting` 0) stay whole. Loads are interpolated between rows; feed and spindle speed are
    /// those of the row ahead. `Err` if it would have more than [`Sampling::MAX_POINTS`] points.
    pub fn sampled(&self, sampling: Sampling) -> Result<Toolpath, PolylineError> {
        let parameters = |row: usize| match row.checked_sub(1).map(|before| &self.path.points()[before]) {
            Some(before) if self.path.points()[row].cutting => {
                let here = &self.path.points()[row];
                let turn = before.orientation.zip(here.orientation).map_or(0.0, |(a, b)| a.angle_to(&b));
                let pieces = sampling.turning_pieces((here.position_mm - before.position_mm).norm(), turn);
                pieces.filter(|pieces| *pieces <= Sampling::MAX_POINTS).map(even_parameters)
            }
            _ => Some(vec![1.0]),
        };
        let mut points = Vec::with_capacity(self.rows.len());
        self.points_at(parameters, |point| points.push(*point))?;
        Ok(Toolpath::assemble(points).with_external_axes(self.path.external_axes()))
    }
}

impl Rewritable for Polyline {
    type Error = PolylineError;
    type Reading = ();

    /// Reads a written polyline file.
    fn read_written(bytes: Vec<u8>, (): &()) -> Result<Self, PolylineError> {
        Polyline::read(bytes, "written file")
    }

    /// Passes the points of each row, at the parameters that `parameters` returns for its index, to `take`; fails where it returns `None`.
    fn points_at(
        &self,
        mut parameters: impl FnMut(usize) -> Option<Vec<f64>>,
        mut take: impl FnMut(&PathPoint),
    ) -> Result<(), PolylineError> {
        let (mut count, mut start) = (0, None);
        for (row, end) in self.path.points().iter().enumerate() {
            let of_row = parameters(row).filter(|of_row| count + of_row.len() <= Sampling::MAX_POINTS);
            let of_row = of_row.ok_or_else(|| PolylineError {
                file: self.name.clone(),
                line: self.line_of(row).unwrap_or(1),
                fault: PolylineFault::TooManyPoints,
            })?;
            let at = |t: &f64| start.filter(|_| *t < 1.0).map_or(*end, |start| interpolate(start, end, *t));
            of_row.iter().for_each(|t| take(&at(t)));
            (count, start) = (count + of_row.len(), Some(end));
        }
        Ok(())
    }

    /// Returns the names of the external axis columns.
    fn external_axes(&self) -> Vec<String> {
        self.path.external_axes().to_vec()
    }
}

/// Interpolates between two rows, at the share `t` (0 to 1) from `start` to `end`.
fn interpolate(start: &PathPoint, end: &PathPoint, t: f64) -> PathPoint {
    let load = |(a, b): (Load, Load)| Load {
        force_N: a.force_N.lerp(&b.force_N, t),
        moment_Nmm: a.moment_Nmm.lerp(&b.moment_Nmm, t),
    };
    PathPoint {
        position_mm: start.position_mm.lerp(&end.position_mm, t),
        orientation: start.orientation.zip(end.orientation).map(|(a, b)| a.towards(&b, t)),
        tangent: direction(end.position_mm - start.position_mm),
        arc_length_mm: start.arc_length_mm + (end.arc_length_mm - start.arc_length_mm) * t,
        load: start.load.zip(end.load).map(load),
        external: std::array::from_fn(|axis| start.external[axis] + (end.external[axis] - start.external[axis]) * t),
        source: PointSource { parameter: t, ..end.source },
        ..*end
    }
}
