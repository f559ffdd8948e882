//! The path through the points of a polyline file, its moves split as those of a program are.

use crate::toolpath::{
    model::{
        path::{Load, PathPoint, PointSource, Toolpath, direction},
        program::{Program, even_places},
        sampling::Sampling,
    },
    read::polyline::{
        Polyline,
        error::{PolylineError, PolylineFault},
    },
};

impl Polyline {
    /// The path through the points of the file, straight between them and split as `sampling` says;
    /// [`PointSource::segment`](crate::toolpath::PointSource) is the row a point leads to, from 0. Rapid moves (`cutting` 0) are
    /// not split. Forces and moments between two rows are interpolated, feed and spindle speed are those of the row ahead.
    ///
    /// # Errors
    /// When the path would have more than [`Sampling::MAX_POINTS`] points.
    pub fn sampled(&self, sampling: Sampling) -> Result<Toolpath, PolylineError> {
        let places = |row: usize| match row.checked_sub(1).map(|before| &self.path.points()[before]) {
            Some(before) if self.path.points()[row].cutting => {
                let here = &self.path.points()[row];
                let turn = before.orientation.zip(here.orientation).map_or(0.0, |(a, b)| a.angle_to(&b));
                let pieces = sampling.turning_pieces((here.position_mm - before.position_mm).norm(), turn);
                pieces.filter(|pieces| *pieces <= Sampling::MAX_POINTS).map(even_places)
            }
            _ => Some(vec![1.0]),
        };
        let mut points = Vec::with_capacity(self.rows.len());
        self.points_at(places, |point| points.push(*point))?;
        Ok(Toolpath::assemble(points).with_external_axes(self.path.external_axes()))
    }
}

impl Program for Polyline {
    type Error = PolylineError;
    type Reading = ();

    fn read_written(bytes: Vec<u8>, (): &()) -> Result<Self, PolylineError> {
        Polyline::read(bytes, "written file")
    }

    fn points_at(
        &self,
        mut places: impl FnMut(usize) -> Option<Vec<f64>>,
        mut take: impl FnMut(&PathPoint),
    ) -> Result<(), PolylineError> {
        let (mut count, mut start) = (0, None);
        for (row, end) in self.path.points().iter().enumerate() {
            let own = places(row).filter(|own| count + own.len() <= Sampling::MAX_POINTS);
            let own = own.ok_or_else(|| PolylineError {
                file: self.name.clone(),
                line: self.line_of(row).unwrap_or(1),
                fault: PolylineFault::TooManyPoints,
            })?;
            let at = |t: &f64| start.filter(|_| *t < 1.0).map_or(*end, |start| between(start, end, *t));
            own.iter().for_each(|t| take(&at(t)));
            (count, start) = (count + own.len(), Some(end));
        }
        Ok(())
    }

    fn external_axes(&self) -> Vec<String> {
        self.path.external_axes().to_vec()
    }
}

/// The point at the share `t` of the way from one row to the next.
fn between(start: &PathPoint, end: &PathPoint, t: f64) -> PathPoint {
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

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    #[test]
    fn moves_are_split_as_those_of_a_program() {
        let source = "x_mm,y_mm,z_mm,force_x_N,force_y_N,force_z_N,cutting\n\
                      0,0,9,0,0,0,0\n0,0,0,0,0,0,0\n20,0,0,10,0,4,1\n20,5,0,10,20,4,1\n";
        let polyline = Polyline::read(source, "path.csv").unwrap();
        let path = polyline.sampled(Sampling::new(0.01, 1.0).unwrap()).unwrap();
        assert_eq!(path.len(), 1 + 1 + 20 + 5);
        let points = path.points();
        assert!(
            points.windows(2).all(|pair| !pair[1].cutting || pair[1].arc_length_mm - pair[0].arc_length_mm < 1.001)
        );
        assert!((points[6].position_mm - Vector3::new(5.0, 0.0, 0.0)).norm() < 1e-12);
        assert!((points[6].load.unwrap().force_N - Vector3::new(2.5, 0.0, 1.0)).norm() < 1e-12);
        assert_eq!(points[6].tangent, Vector3::x());
        assert_eq!((points[6].source.segment, polyline.line_of(points[6].source.segment)), (2, Some(4)));
        // Points of the file stay what they are.
        assert_eq!(points[21], polyline.toolpath().points()[2]);
        let program = "G0 X0 Y0 Z9\nG0 Z0\nG1 X20 F100\nG1 Y5\n";
        let program = crate::toolpath::gcode::Program::parse(program, "p.nc", &Default::default()).unwrap();
        let same = program.toolpath(Sampling::new(0.01, 1.0).unwrap()).unwrap();
        let apart = |(a, b): (&Vector3<f64>, &Vector3<f64>)| (a - b).norm();
        assert_eq!(same.len(), path.len());
        assert!(same.positions_mm().iter().zip(&path.positions_mm()).map(apart).all(|apart| apart < 1e-12));
    }

    #[test]
    fn too_many_points_are_refused_with_their_line() {
        let polyline = Polyline::read("x_mm,y_mm,z_mm\n0,0,0\n100,0,0\n", "path.csv").unwrap();
        let refused = polyline.sampled(Sampling::new(1e-3, 1e-5).unwrap()).unwrap_err().to_string();
        assert!(refused.starts_with("path.csv:3: "), "{refused}");
    }

    #[test]
    fn a_closed_path_has_the_same_directions_whichever_corner_is_first() {
        let corners = ["0,0,0", "10,0,0", "10,6,0", "0,6,0"];
        let directions = |first: usize| {
            let rows: Vec<&str> = (0..=4).map(|k| corners[(first + k) % 4]).collect();
            let source = format!("x_mm,y_mm,z_mm\n{}\n", rows.join("\n"));
            let path = Polyline::read(source, "path.csv").unwrap().sampled(Sampling::default()).unwrap();
            let (start, end) = (path.points()[0], path.points()[path.len() - 1]);
            assert_eq!(start.tangent, end.tangent);
            let mut all: Vec<[i64; 5]> = path.points()[1..]
                .iter()
                .map(|p| [p.position_mm.x, p.position_mm.y, p.position_mm.z, p.tangent.x, p.tangent.y])
                .map(|values| values.map(|value| (value * 1e9).round() as i64))
                .collect();
            all.sort_unstable();
            all
        };
        for first in 1..4 {
            assert_eq!(directions(first), directions(0));
        }
    }
}
