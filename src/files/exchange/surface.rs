//! A surface of four-cornered faces with numbers at each, as PLY and as VTK polygons (`.vtp`).

use super::vtk_file;
use crate::files::OutputFile;

/// Faces with numbers, mm.
#[derive(Debug, Clone)]
pub struct Surface {
    /// What its numbers are, for people who open the file in an editor.
    pub comment: String,
    /// Corners of each face.
    pub faces: Vec<[[f32; 3]; 4]>,
    /// Names and numbers of the faces, one for each; `None` where it is not known.
    pub columns: Vec<(String, Vec<Option<f64>>)>,
    /// Line of the program that makes each face, 0 where none does.
    pub lines: Vec<i32>,
    /// Whether all that is to be known of a face is.
    pub known: Vec<bool>,
}

impl Surface {
    /// Returns it as a binary PLY file called `name`: each corner has the numbers of its face, 0 where one is not known.
    pub fn ply(&self, name: String) -> OutputFile {
        let (faces, columns) = (self.faces.len(), &self.columns);
        let properties: String = columns.iter().map(|(name, _)| format!("property float {name}\n")).collect();
        let header = format!(
            "ply\nformat binary_little_endian 1.0\ncomment {}\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
             {properties}property int line\nproperty uchar known\nelement face {faces}\nproperty list uchar int vertex_indices\nend_header\n",
            self.comment,
            4 * faces
        );
        let mut bytes = Vec::with_capacity(faces * (4 * (17 + 4 * columns.len()) + 17) + header.len());
        bytes.extend(header.as_bytes());
        for (k, corners) in self.faces.iter().enumerate() {
            for corner in corners {
                let numbers = columns.iter().map(|own| own.1[k].unwrap_or(0.0) as f32);
                corner.iter().copied().chain(numbers).for_each(|own| bytes.extend(own.to_le_bytes()));
                bytes.extend(self.lines[k].to_le_bytes());
                bytes.push(self.known[k].into());
            }
        }
        for k in 0..faces as i32 {
            bytes.push(4);
            (0..4).for_each(|corner| bytes.extend((4 * k + corner).to_le_bytes()));
        }
        OutputFile::new(name, bytes)
    }

    /// Returns it as a VTK file called `name`, with NaN where a number is not known; `None` if this program was built without VTK.
    ///
    /// # Errors
    /// The library refuses the data.
    pub fn vtp(&self, name: String) -> std::io::Result<Option<OutputFile>> {
        Ok(vtk_file::surface(self)?.map(|bytes| OutputFile::new(name, bytes)))
    }
}
