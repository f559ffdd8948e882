//! The table that must hold a workpiece.

use kinetostat::{
    questions::placement::{End, Margin, PlacementStudy, Table, compare},
    spatial::Pose,
};
use nalgebra::{Vector2, Vector3};
use proptest::prelude::*;

use crate::support::{
    cases::cases,
    placement::{searched, study_in},
};

const CIRCLE: &str = r#"
schema = 3
question = "where?"
machine = "orthoglide"
[process.force.path_frame]
radial_force_N = 215.0
tangential_force_N = -10.0
axial_force_N = -25.0
[placement]
clearance_mm = 0.0
[[placement.feature]]
name = "circle"
circle = { centre_mm = [0.0, 0.0, 0.0], diameter_mm = 20.0, points = 8 }
tolerance_mm = 0.6
[placement.bounds]
x_mm = [-40.0, 90.0]
y_mm = [-40.0, 90.0]
[placement.fixed]
z_mm = 100.0
[placement.allowance]
position_mm = 0.0
angle_deg = 0.0
[placement.objective]
weights = { worst_deflection = 1.0 }
[placement.search]
grid = { x = 4, y = 4 }
starts = 1
max_iterations = 20
"#;

fn study(more: &str) -> Result<PlacementStudy, String> {
    let folder = tempfile::tempdir().unwrap();
    study_in(folder.path(), &(CIRCLE.to_string() + more)).map_err(|e| e.to_string())
}

fn candidate(x: f64, y: f64) -> String {
    format!("[[placement.candidate]]\nname = \"named\"\norigin_mm = [{x:?}, {y:?}, 100.0]\n")
}

/// 30 mm for the table, 5 mm for its margin and 15 mm for the part keep it at 50 mm and beyond.
const TABLE: &str = "[placement.workpiece]\nmin_mm = [-15.0, -12.0, 0.0]\nmax_mm = [15.0, 12.0, 10.0]\n\
                     [placement.table]\nmin_mm = [30.0, -100.0]\nmax_mm = [120.0, 100.0]\nheight_mm = 110.0\n\
                     margin_mm = 5.0\n";

#[test]
fn a_bound_is_in_the_way_only_where_better_places_are_behind_it() {
    let free = searched(&study("").unwrap()).best.unwrap().site.0[0];
    let towards_bound = |low: f64, more: &str| -> Margin {
        let folder = tempfile::tempdir().unwrap();
        let bounded = CIRCLE.replace("x_mm = [-40.0,", &format!("x_mm = [{low:?},")) + more;
        let results = searched(&study_in(folder.path(), &bounded).unwrap());
        let best = results.best.unwrap().site;
        assert!((best.0[0] - low).abs() < 0.05, "{best:?}");
        results.flatness.into_iter().find(|margin| margin.coordinate == 0 && margin.direction < 0.0).unwrap()
    };
    let better = towards_bound(50.0, "");
    assert!(better.end == End::Bound && better.is_better_beyond, "{better:?}");
    let table = towards_bound(50.0, TABLE);
    assert!(matches!(&table.end, End::Infeasible(reason) if reason.contains("side −x of the table")), "{table:?}");
    assert!(!table.is_better_beyond);
    let best = towards_bound(free, "");
    assert!(!best.is_better_beyond, "the bound is where the best place is anyway: {best:?}");
}

#[test]
fn the_best_place_is_on_the_table() {
    // Without a table it is at (0, 0), about.
    let free = searched(&study("").unwrap()).best.unwrap();
    assert!(free.site.0[0] < 20.0, "{:?}", free.site);
    let results = searched(&study(TABLE).unwrap());
    let best = results.best.unwrap();
    assert!((best.site.0[0] - 50.0).abs() < 0.01, "{:?}", best.site);
    assert!(
        results.flatness.iter().any(|room| format!("{:?}", room.end).contains("side −x of the table")),
        "{:?}",
        results.flatness
    );
}

#[test]
fn a_place_off_the_table_says_by_how_much() {
    let part = "[placement.workpiece]\nmin_mm = [-15.0, -12.0, 0.0]\nmax_mm = [15.0, 12.0, 10.0]\n";
    for (table, reason) in [
        ("min_mm = [-20.0, -20.0]\nmax_mm = [20.0, 20.0]\n", "would hang 2.0 mm over side +x of the table"),
        (
            "centre_mm = [0.0, 0.0]\nsize_mm = [40.0, 40.0]\nmargin_mm = 3.0\n",
            "would be 5.0 mm beyond the margin of 3 mm on side +x of the table",
        ),
        (
            "min_mm = [-20.0, -20.0]\nmax_mm = [200.0, 200.0]\nheight_mm = 104.0\n",
            "would be 6.0 mm above the surface of the table, under which it hangs: the tool points up",
        ),
        // A quarter of a turn makes its long side y: in its own axes the part, 7 mm along x, is at −y.
        (
            "centre_mm = [0.0, 0.0]\nsize_mm = [200.0, 30.0]\nyaw_deg = 90.0\n",
            "would hang 7.0 mm over side −y of the table",
        ),
    ] {
        let study = study(&format!("{part}[placement.table]\n{table}{}", candidate(7.0, 0.0))).unwrap();
        let entries = compare(&study);
        let refusal = entries[0].refusal().unwrap_or_else(|| panic!("{table}: it can be cut"));
        assert_eq!(&*refusal.status, "off_table", "{table}");
        assert!(refusal.reason.contains(reason), "{table}: {}", refusal.reason);
    }
}

/// The tool of the delta points down, that of the Orthoglide up: the part is on the side that the tool comes to.
#[test]
fn a_part_stands_on_a_table_that_the_tool_points_down_to_and_hangs_under_one_that_it_points_up_to() {
    let refusal = |machine: &str, height_mm: f64, part: [f64; 2]| {
        let machine_line = format!("machine = \"{machine}\"");
        let text = CIRCLE.replace("machine = \"orthoglide\"", &machine_line)
            + &format!(
                "[placement.workpiece]\nmin_mm = [-15.0, -12.0, {:?}]\nmax_mm = [15.0, 12.0, {:?}]\n\
                 [placement.table]\nmin_mm = [-500.0, -500.0]\nmax_mm = [500.0, 500.0]\nheight_mm = {height_mm:?}\n{}",
                part[0],
                part[1],
                candidate(0.0, 0.0)
            );
        let folder = tempfile::tempdir().unwrap();
        let study = study_in(folder.path(), &text).unwrap();
        let entries = compare(&study);
        entries[0].refusal().map(|failure| failure.reason.to_string()).filter(|reason| reason.contains("table"))
    };
    // The origin of the part is at z = 100 mm.
    assert_eq!(refusal("orthoglide", 120.0, [0.0, 20.0]), None);
    let up = refusal("orthoglide", 90.0, [0.0, 20.0]).unwrap();
    assert!(up.contains("30.0 mm above the surface of the table"), "{up}");
    assert_eq!(refusal("rotary_delta", 80.0, [-20.0, 0.0]), None);
    let down = refusal("rotary_delta", 120.0, [-20.0, 0.0]).unwrap();
    assert!(down.contains("40.0 mm below the surface of the table"), "{down}");
}

#[test]
fn without_a_box_of_the_part_its_paths_are_on_the_table() {
    // A circle of 20 mm, eight points: a table turned by 45° just holds it, though not the square around it.
    let table = "[placement.table]\ncentre_mm = [0.0, 0.0]\nsize_mm = [20.1, 20.1]\nyaw_deg = 45.0\n";
    let entries = compare(&study(&format!("{table}{}", candidate(0.0, 0.0))).unwrap());
    assert!(entries[0].feasible().is_some(), "{:?}", entries[0].refusal());
    let entries = compare(&study(&format!("{table}{}", candidate(0.2, 0.0))).unwrap());
    assert_eq!(entries[0].refusal().map(|failure| &*failure.status), Some("off_table"));
}

#[test]
fn tables_that_are_none_are_refused() {
    for (table, message) in [
        ("", "placement.table: expected min_mm and max_mm, or centre_mm and size_mm"),
        (
            "min_mm = [0.0, 0.0]\nsize_mm = [1.0, 1.0]\n",
            "placement.table: expected min_mm and max_mm, or centre_mm and size_mm",
        ),
        ("min_mm = [0.0, 0.0]\nmax_mm = [-1.0, 1.0]\n", "placement.table: is -1 mm × 1 mm: expected sides above 0"),
        (
            "min_mm = [0.0, 0.0]\nmax_mm = [10.0, 10.0]\nmargin_mm = 5.0\n",
            "placement.table.margin_mm: is 5 mm at each edge, which leaves nothing of a table 10 mm wide: expected less than 5 mm",
        ),
        ("min_mm = [0.0, 0.0]\nmax_mm = [10.0, nan]\n", "placement.table.max_mm"),
    ] {
        let refused = study(&format!("[placement.table]\n{table}")).unwrap_err();
        assert!(refused.contains(message), "{table}: {refused}");
    }
}

proptest! {
    #![proptest_config(cases(200))]

    /// Against the corners of the table as half-planes: a point is on it if it lies left of all its sides.
    #[test]
    fn what_is_on_a_table_lies_left_of_its_sides(
        centre in prop::array::uniform2(-50.0..50.0f64),
        size in prop::array::uniform2(10.0..200.0f64),
        yaw in -4.0..4.0f64,
        points in prop::collection::vec(prop::array::uniform3(-60.0..60.0f64), 1..6),
    ) {
        let footprint: Vec<Vector3<f64>> = points.iter().map(|point| Vector3::from(*point)).collect();
        let table = Table {
            centre_mm: Vector2::from(centre),
            size_mm: Vector2::from(size),
            yaw,
            height_mm: None,
            is_overhead: false,
            margin_mm: 0.0,
            footprint: footprint.clone(),
        };
        let (off, _) = table.overhang(&Pose::from_rotation_vector(Vector3::zeros()));
        let corners = table.corners();
        let outside = |p: &Vector3<f64>| {
            (0..4).map(|k| {
                let (a, b) = (corners[k], corners[(k + 1) % 4]);
                let (side, to) = (b - a, p.xy() - a);
                -(side.x * to.y - side.y * to.x) / side.norm()
            }).fold(f64::NEG_INFINITY, f64::max)
        };
        let expected = footprint.iter().map(outside).fold(f64::NEG_INFINITY, f64::max);
        prop_assert!((off - expected).abs() < 1e-9, "{off} {expected}");
    }
}
