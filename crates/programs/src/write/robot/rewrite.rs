//! Writes a robot or APT program back with its path points moved to corrected positions and orientations.

use nalgebra::Vector3;

use crate::{
    model::{
        MotionGeometry, Orientation, RewriteError, Rewritten, Toolpath, check_corrected, end_of_segment,
        gcode::WriteOptions,
    },
    read::robot::RobotProgram,
    write::robot::{Points, PoseFormat, Writer},
};

impl RobotProgram {
    /// Rewrites the program with the points of `path` moved to `corrected_mm`, positions in the workpiece frame, and turned
    /// to `orientations` if they are given.
    ///
    /// `path` is what [`RobotProgram::toolpath`] gave. A motion stays one statement where one of its kind passes all its corrected points to
    /// a unit of the last decimal, or within the tolerance; otherwise it becomes a sequence of straight motions, or of circles and straight
    /// ones, each of which passes as many points as it can. They repeat the statement's velocity, zone, tool and approximation, and nothing
    /// else. Numbers change only by more than half a unit of the last decimal: without correction the bytes are the same. A point that is
    /// declared elsewhere stays declared there; where it is corrected, the motion has its numbers instead of its name. Fails when there is
    /// not one finite position (and orientation) for every point, or `path` is from another program.
    pub fn rewrite(
        &self,
        path: &Toolpath,
        corrected_mm: &[Vector3<f64>],
        orientations: Option<&[Orientation]>,
        writing: WriteOptions,
    ) -> Result<Rewritten<RobotProgram>, RewriteError> {
        check_corrected(path, corrected_mm, orientations)?;
        let writing = writing.checked()?;
        let format = PoseFormat { language: self.language, format: writing.format, decimals: self.decimals };
        let mut writer = Writer::new(&self.source, format, writing.tolerance_mm);
        let foreign = || RewriteError::ForeignPath { program: self.name.clone() };
        let (mut segment, mut next) = (0, 0);
        self.walk(|motion| {
            let at = |t: f64| motion.geometry.at(t).map(|(position, _)| position);
            let has_points = motion.geometry != MotionGeometry::Unlocated;
            let range = next..end_of_segment(path, segment, next, has_points, at).ok_or_else(foreign)?;
            let points = Points {
                points: &path.points()[range.clone()],
                corrected: &corrected_mm[range.clone()],
                orientations: orientations.map(|orientations| &orientations[range.clone()]),
                postures: path.postures().get(range.clone()).unwrap_or_default(),
            };
            writer.write_motion(motion, points).map_err(|fault| self.error_at(&motion.statement, fault))?;
            (segment, next) = (segment + 1, range.end);
            Ok::<(), RewriteError>(())
        })?;
        if next != path.len() {
            return Err(foreign());
        }
        let chunks = self.expansion.iter().flat_map(|expansion| &expansion.chunks);
        let edges: Vec<usize> = chunks.flat_map(|chunk| [chunk.at.start, chunk.at.end]).collect();
        let line_ends = writer.places(&edges);
        let (bytes, pieces, parameters) = writer.finish();
        let reading = (self.name.clone(), self.language, self.beside.clone(), self.options.clone());
        Ok(Rewritten { bytes, pieces, parameters, line_ends, reading })
    }
}
