//! Bodies as files have them: shapes made of them, meshes read, and what is refused.

use kinetostat_cell::{
    Cell,
    spec::{BodySpec, ReadMesh},
};
use kinetostat_input::{check::Check, error::Result, toml_file::parse};
use nalgebra::Isometry3;

/// A box as triangles that go round anticlockwise seen from outside: its corners and those of its sides.
fn box_stl(size: [f64; 3], is_open: bool, is_inside_out: bool) -> Vec<u8> {
    let corner = |k: usize| [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { size[axis] } else { 0.0 });
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut text = "solid box\n".to_owned();
    for (index, [a, b, c, d]) in sides.into_iter().enumerate() {
        for mut corners in [[a, b, c], [a, c, d]] {
            if is_inside_out {
                corners.swap(1, 2);
            }
            if is_open && index == 5 {
                continue;
            }
            text += "facet normal 0 0 0\nouter loop\n";
            for k in corners {
                let [x, y, z] = corner(k);
                text += &format!("vertex {x} {y} {z}\n");
            }
            text += "endloop\nendfacet\n";
        }
    }
    (text + "endsolid box\n").into_bytes()
}

fn body(text: &str, read: ReadMesh<'_>) -> Result<kinetostat_cell::Body> {
    let spec: BodySpec = parse(text, "body.toml")?;
    Ok(spec.resolve(&spec.name, 1, Some(read), &Check::new("body.toml"))?.expect("a body"))
}

fn nothing(_: &str) -> Result<Vec<u8>> {
    panic!("no file is named")
}

/// Distance of a body from a ball of 1 mm about a place, both in one frame.
fn distance(text: &str, read: ReadMesh<'_>, at: [f64; 3]) -> f64 {
    let ball = format!(
        "name = \"ball\"\ngrade = \"given\"\nshapes = [{{ capsule = {{ from_mm = {at:?}, to_mm = {at:?}, radius_mm = 1.0 }} }}]"
    );
    let mut ball = body(&ball, &nothing).unwrap();
    ball.frame = 0;
    let cell = Cell::new(vec![ball, body(text, read).unwrap()], |_, _| false);
    cell.nearest(&[Isometry3::identity(), Isometry3::identity()]).unwrap().distance_mm
}

#[test]
fn shapes_stand_where_their_keys_say() {
    for (shape, at, expected) in [
        ("capsule = { from_mm = [0, 0, 0], to_mm = [0, 0, 100], radius_mm = 10 }", [50.0, 0.0, 30.0], 39.0),
        ("cylinder = { from_mm = [0, 0, 0], to_mm = [0, 0, 100], radius_mm = 10 }", [0.0, 0.0, 150.0], 49.0),
        ("box = { size_mm = [20, 40, 60], at_mm = [100, 0, 0] }", [0.0, 0.0, 0.0], 89.0),
        // Turned about z by 90°, its length along x is that along y.
        ("box = { size_mm = [20, 40, 60], at_mm = [100, 0, 0], rotation_deg = [0, 0, 90] }", [0.0, 0.0, 0.0], 79.0),
        ("hull = { points_mm = [[0, 0, 0], [30, 0, 0], [0, 30, 0], [0, 0, 30]] }", [-20.0, 5.0, 5.0], 19.0),
    ] {
        let text = format!(
            "name = \"it\"\nshapes = [{{ {} }}]",
            shape.replace("0,", "0.0,").replace("0]", "0.0]").replace("= 10 ", "= 10.0 ")
        );
        let found = distance(&text, &nothing, at);
        assert!((found - expected).abs() < 1e-6, "{shape}: {found}");
    }
}

#[test]
fn a_mesh_is_read_in_its_unit_and_place() {
    let read = |name: &str| {
        assert_eq!(name, "box.stl");
        Ok(box_stl([0.1, 0.2, 0.3], false, false))
    };
    let text = "name = \"it\"\nshapes = [{ mesh = { file = \"box.stl\", unit = \"m\", at_mm = [50.0, 0.0, 0.0], rotation_deg = [0.0, 0.0, 90.0] } }]";
    // Turned: along x from 50 − 200 to 50 mm, along y from 0 to 100 mm.
    assert!((distance(text, &read, [90.0, 50.0, 100.0]) - 39.0).abs() < 1e-3);
    assert!((distance(text, &read, [-190.0, 50.0, 100.0]) - 39.0).abs() < 1e-3);
}

#[test]
fn a_mesh_as_small_as_one_in_metres_is_taken_where_its_unit_is_said() {
    let small = |unit: &str| format!("name = \"it\"\nshapes = [{{ mesh = {{ file = \"box.stl\"{unit} }} }}]");
    let read = |_: &str| Ok(box_stl([5.0, 4.0, 3.0], false, false));
    assert!(body(&small(""), &read).is_err());
    assert!(body(&small(", unit = \"mm\""), &read).is_ok());
}

#[test]
fn a_hull_in_any_plane_is_flat() {
    let points = "[[0.0, 0.0, 0.0], [90.0, 0.0, 90.0], [0.0, 90.0, 90.0], [90.0, 90.0, 180.0], [30.0, 40.0, 70.0]]";
    let text = format!("name = \"it\"\nshapes = [{{ hull = {{ points_mm = {points} }} }}]");
    let said = body(&text, &nothing).unwrap_err().to_string();
    assert!(said.contains("shapes[0].hull: has its points in a plane"), "{said}");
}

#[test]
fn meshes_that_are_none_are_refused() {
    let text = "name = \"it\"\nshapes = [{ mesh = { file = \"box.stl\" } }]";
    for (bytes, expected) in [
        (box_stl([100.0, 200.0, 300.0], true, false), "box.stl is open at the edge from"),
        (box_stl([100.0, 200.0, 300.0], false, true), "box.stl is inside out"),
        // A table of 2 m, in metres.
        (box_stl([2.0, 1.2, 0.5], false, false), "has numbers within a ball of radius 1.193: are they metres"),
        (b"ISO-10303-21;".to_vec(), "box.stl is no STL file"),
        (b"solid nothing\nendsolid nothing\n".to_vec(), "box.stl has 0 triangles"),
    ] {
        let said = body(text, &|_| Ok(bytes.clone())).unwrap_err().to_string();
        assert!(said.starts_with("body.toml: shapes[0].mesh.file: ") && said.contains(expected), "{said}");
    }
}
