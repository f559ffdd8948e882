//! Arrays over a grid written as the bytes of a VTK image file (`.vti`).

use std::io;

use vtkio::model::{
    Attribute, Attributes, ByteOrder, DataArray, DataSet, Extent, IOBuffer, ImageDataPiece, Piece, Version, Vtk,
};

use super::image::{Array, Values};
use crate::spatial::Grid;

/// Returns the bytes of a `.vti` file with these arrays over `grid`; `Err` when the library refuses the data.
pub fn bytes(grid: &Grid, arrays: Vec<Array>) -> io::Result<Vec<u8>> {
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
    let file = Vtk {
        version: Version::new_xml(1, 0),
        title: String::new(),
        byte_order: ByteOrder::LittleEndian,
        data: image,
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
