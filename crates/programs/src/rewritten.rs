//! Programs written back through corrected positions, and read again.

use kinetostat_input::error::Result;
use nalgebra::Vector3;

use crate::{
    Orientation, ProgramFile, Toolpath, WriteOptions,
    blocks::{Blocks, BlocksBeforeAfter},
    gcode::Calls,
    model::{Rewritable, Rewritten},
};

impl ProgramFile {
    /// Rewrites the program through `positions` (workpiece frame, mm, one per point of `path`) and, if given, with `orientations` of the
    /// tool, and reads it back.
    ///
    /// # Errors
    /// Invalid positions, or a written program that cannot be read back.
    pub fn rewrite(
        &self,
        path: &Toolpath,
        positions: &[Vector3<f64>],
        orientations: Option<&[Orientation]>,
        writing: WriteOptions,
    ) -> Result<RewrittenFile> {
        let is_turned = orientations.is_some();
        match self {
            ProgramFile::Polyline(polyline) => {
                let rewritten = polyline.rewrite_turned(path, positions, orientations, writing.format)?;
                let sent = CommandedPath::read_back(&rewritten, &rewritten.read()?, path.len(), is_turned)?;
                Ok(RewrittenFile { bytes: rewritten.into_bytes(), sent, blocks: None, calls: None })
            }
            ProgramFile::Gcode(program) => {
                let mut rewritten = program.rewrite_turned(path, positions, orientations, writing)?;
                let calls = program.folded_calls(&rewritten);
                let written = rewritten.take_and_read()?;
                let sent = CommandedPath::read_back(&rewritten, &written, path.len(), is_turned)?;
                drop(rewritten);
                let blocks = BlocksBeforeAfter { before: Blocks::of(program)?, after: Blocks::of(&written)? };
                Ok(RewrittenFile { bytes: written.into_source(), sent, blocks: Some(blocks), calls })
            }
            #[cfg(not(target_family = "wasm"))]
            ProgramFile::Robot(program) => {
                let rewritten = program.rewrite(path, positions, orientations, writing)?;
                let calls = program.folded_calls(&rewritten);
                let sent = CommandedPath::read_back(&rewritten, &rewritten.read()?, path.len(), is_turned)?;
                Ok(RewrittenFile { bytes: rewritten.into_bytes(), sent, blocks: None, calls })
            }
        }
    }
}

/// The path on which a program sends the tool, point by point.
#[derive(Debug, Clone)]
pub struct CommandedPath {
    /// Positions in the workpiece frame, mm.
    pub positions: Vec<Vector3<f64>>,
    /// Orientations of the tool, if they are corrected.
    pub orientations: Option<Vec<Orientation>>,
}

impl CommandedPath {
    /// Creates an empty path for so many points; `is_turned`: with orientations.
    pub fn new(points: usize, is_turned: bool) -> Self {
        Self { positions: Vec::with_capacity(points), orientations: is_turned.then(|| Vec::with_capacity(points)) }
    }

    /// Returns the path of the program `written`, as read back, at the `points` of the original path.
    fn read_back<P: Rewritable>(
        rewritten: &Rewritten<P>,
        written: &P,
        points: usize,
        is_turned: bool,
    ) -> std::result::Result<Self, P::Error> {
        let mut sent = Self::new(points, is_turned);
        rewritten.for_each_point(written, |point| {
            sent.positions.push(point.position_mm);
            sent.orientations.iter_mut().for_each(|own| own.extend(point.orientation));
        })?;
        Ok(sent)
    }
}

/// A program that was rewritten and read back.
#[derive(Debug, Clone)]
pub struct RewrittenFile {
    /// Its bytes.
    pub bytes: Vec<u8>,
    /// Path read back, rounding included.
    pub sent: CommandedPath,
    /// Demands of its blocks on a control, before and as written; `None` except for G-code.
    pub blocks: Option<BlocksBeforeAfter>,
    /// What becomes of its calls, if it has any; `bytes` has none.
    pub calls: Option<Calls>,
}
