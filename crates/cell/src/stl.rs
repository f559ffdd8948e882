//! Surfaces of triangles from STL files.

use std::{collections::HashMap, io::Cursor};

use nalgebra::Point3;

/// Length of what stands before the triangles of a binary file, and of a triangle, bytes.
const BINARY: [usize; 2] = [84, 50];
/// Most triangles of a file.
const MAX_TRIANGLES: usize = 5_000_000;
/// Largest coordinate, mm: beyond any machine.
const MAX_MM: f32 = 1e6;

/// A surface of triangles.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mesh {
    /// Corners, each once, in the unit of the file.
    pub vertices: Vec<Point3<f64>>,
    /// Indices of the corners of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

/// Reads a binary or ASCII STL file: equal vertices become one, and triangles of which two corners are equal are left out.
///
/// # Errors
/// What is wrong with the file.
pub fn read_stl(mut bytes: Vec<u8>) -> Result<Mesh, String> {
    let count = bytes.get(80..BINARY[0]).and_then(|own| Some(u32::from_le_bytes(own.try_into().ok()?) as usize));
    let text = bytes.len() - bytes.trim_ascii_start().len();
    let is_text =
        || bytes[text..].get(..5).is_some_and(|start| start.eq_ignore_ascii_case(b"solid")) && !bytes.contains(&0);
    let is_binary = count.and_then(|count| count.checked_mul(BINARY[1])?.checked_add(BINARY[0])) == Some(bytes.len());
    if is_binary {
        // A binary file may begin with "solid" as well, which the reader takes for text.
        bytes[..80].fill(0);
    } else if is_text() {
        let end = bytes[text..].iter().position(|byte| *byte == b'\n').map_or(bytes.len(), |end| text + end);
        bytes.splice(..end, *b"solid s");
        // Names may be in any encoding.
        bytes.iter_mut().for_each(|own| *own = if own.is_ascii() { own.to_ascii_lowercase() } else { b'?' });
        let is_end = |line: &&[u8]| line.trim_ascii_start().starts_with(b"endsolid");
        let solids = bytes.split(|byte| *byte == b'\n').filter(is_end).count();
        if solids > 1 {
            return Err(format!("has {solids} solids: expected one"));
        }
    } else {
        return Err(
            "is no STL file: expected text from \"solid\" on, or 84 bytes and 50 for each triangle that they announce"
                .into(),
        );
    }
    let mut bytes = Cursor::new(bytes);
    let (mut numbers, mut mesh) = (HashMap::new(), Mesh::default());
    for (index, triangle) in stl_io::create_stl_reader(&mut bytes).map_err(|error| error.to_string())?.enumerate() {
        let triangle = triangle.map_err(|error| format!("triangle {}: {error}", index + 1))?;
        let mut corners = [0; 3];
        for (corner, vertex) in corners.iter_mut().zip(triangle.vertices) {
            // Not-a-numbers compare as false; 0 and −0 are one place.
            if !vertex.0.iter().all(|own| own.abs() <= MAX_MM) {
                let [x, y, z] = vertex.0;
                return Err(format!("has a vertex at ({x}, {y}, {z}) mm: expected numbers of at most {MAX_MM}"));
            }
            let place = vertex.0.map(|own| own + 0.0);
            *corner = *numbers.entry(place.map(f32::to_bits)).or_insert_with(|| {
                mesh.vertices.push(Point3::from(place.map(f64::from)));
                mesh.vertices.len() as u32 - 1
            });
        }
        let [a, b, c] = corners;
        if a != b && b != c && c != a {
            mesh.triangles.push(corners);
        }
        if mesh.triangles.len() > MAX_TRIANGLES {
            return Err(format!("has more than {MAX_TRIANGLES} triangles: expected a coarser mesh"));
        }
    }
    Ok(mesh)
}
