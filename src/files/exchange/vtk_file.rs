//! Arrays over a grid and over faces, written as the bytes of VTK files (`.vti`, `.vtp`).

use std::io;

use vtkio::model::{
    Attribute, Attributes, ByteOrder, DataArray, DataSet, Extent, IOBuffer, ImageDataPiece, Piece, PolyDataPiece,
    Version, VertexNumbers, Vtk,
};

use super::{
    image::{Array, Values},
    surface::Surface,
};
use crate::spatial::Grid;

/// Returns the bytes of a `.vti` file with these arrays over `grid`; `Err` when the library refuses the data.
pub fn image(grid: &Grid, arrays: Vec<Array>) -> io::Result<Vec<u8>> {
    let counts = grid.counts();
    let last = |axis: usize| i32::try_from(counts[axis] - 1).map_err(io::Error::other);
    let extent = Extent::Ranges([0..=last(0)?, 0..=last(1)?, 0..=last(2)?]);
    let data = Attributes { point: arrays.into_iter().map(point_attribute).collect(), cell: Vec::new() };
    let axes = [0, 1, 2].map(|axis| &grid.axes[axis]);
    let image = DataSet::ImageData {
        extent: extent.clone(),
        origin: axes.map(|axis| axis[0] as f32),
        spacing: axes.map(|axis| spacing(axis) as f32),
        meta: None,
        pieces: vec![Piece::Inline(Box::new(ImageDataPiece { extent, data }))],
    };
    written(image)
}

/// Returns the bytes of a `.vtp` file with the numbers of each face of `surface`, NaN where one is not known; `Err` when the library refuses the data.
pub fn surface(surface: &Surface) -> io::Result<Option<Vec<u8>>> {
    let count = surface.faces.len() as u64;
    let number = |(name, values): &(String, Vec<Option<f64>>)| {
        let values = values.iter().map(|own| own.map_or(f32::NAN, |own| own as f32)).collect();
        (name.clone(), IOBuffer::F32(values))
    };
    let lines = ("line".to_string(), IOBuffer::I32(surface.lines.clone()));
    let known = ("known".to_string(), IOBuffer::U8(surface.known.iter().map(|own| u8::from(*own)).collect()));
    let all = surface.columns.iter().map(number).chain([lines, known]);
    let cell = all.map(|(name, data)| Attribute::DataArray(DataArray::scalars(name, 1).with_buf(data))).collect();
    let piece = PolyDataPiece {
        points: IOBuffer::F32(surface.faces.as_flattened().as_flattened().to_vec()),
        polys: Some(VertexNumbers::XML {
            connectivity: (0..4 * count).collect(),
            offsets: (1..=count).map(|own| 4 * own).collect(),
        }),
        data: Attributes { point: Vec::new(), cell },
        ..PolyDataPiece::default()
    };
    written(DataSet::PolyData { meta: None, pieces: vec![Piece::Inline(Box::new(piece))] }).map(Some)
}

/// Returns the bytes of a file with `data`.
fn written(data: DataSet) -> io::Result<Vec<u8>> {
    let file = Vtk {
        version: Version::new_xml(1, 0),
        title: String::new(),
        byte_order: ByteOrder::LittleEndian,
        data,
        file_path: None,
    };
    let mut bytes = Vec::new();
    file.write_xml(&mut bytes).map_err(|e| io::Error::other(e.to_string()))?;
    Ok(bytes)
}

/// Converts an array to an attribute of the points of a VTK image.
fn point_attribute(array: Array) -> Attribute {
    let scalars = |name, data| DataArray::scalars(name, 1).with_buf(data);
    Attribute::DataArray(match array.values {
        Values::Scalars(numbers) => scalars(array.name, IOBuffer::F64(numbers)),
        Values::Statuses(numbers) => scalars(array.name, IOBuffer::I32(numbers)),
        Values::Vectors(vectors) => DataArray::vectors(array.name).with_buf(IOBuffer::F64(vectors.concat())),
    })
}

/// Distance of the points along an axis, mm; any where there is only one.
fn spacing(axis: &[f64]) -> f64 {
    match axis {
        [first, .., last] => (last - first) / (axis.len() - 1) as f64,
        _ => 1.0,
    }
}
