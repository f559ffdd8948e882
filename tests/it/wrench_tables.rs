//! Loads tabulated over the length of a path.

use kinetostat::{
    nalgebra::Vector3,
    process::cutting::{CuttingLaw, PathLoad, TableError, WrenchTable},
    toolpath::{Sampling, Toolpath, polyline::Polyline},
};

use crate::support::path_loads;

const HEADER: &str = "arc_length_mm,force_x_N,force_y_N,force_z_N,moment_x_Nmm,moment_y_Nmm,moment_z_Nmm\n";

fn table(rows: &str) -> Result<WrenchTable, TableError> {
    WrenchTable::read(format!("{HEADER}{rows}").as_bytes(), "wrench.csv")
}

fn message(rows: &str) -> String {
    table(rows).unwrap_err().to_string()
}

fn line(length_mm: f64) -> Toolpath {
    Toolpath::line(Vector3::zeros(), Vector3::new(length_mm, 0.0, 0.0), Sampling::default()).unwrap()
}

#[test]
fn loads_are_linear_between_rows_and_exact_on_them() {
    let table = table("0,0,1,2,3,4,5\n2,10,1,2,3,4,-5\n10,10,9,2,3,4,-5\n").unwrap();
    assert_eq!(table.range_mm(), (0.0, 10.0));
    let at = |length| table.load(length).unwrap();
    assert_eq!(at(0.0).force_N, Vector3::new(0.0, 1.0, 2.0));
    assert_eq!(at(0.5).force_N, Vector3::new(2.5, 1.0, 2.0));
    assert_eq!(at(1.0).moment_Nmm, Vector3::new(3.0, 4.0, 0.0));
    assert_eq!(at(2.0).force_N, Vector3::new(10.0, 1.0, 2.0));
    assert_eq!(at(4.0).force_N, Vector3::new(10.0, 3.0, 2.0));
    assert_eq!(at(10.0).force_N, Vector3::new(10.0, 9.0, 2.0));
    assert_eq!(at(10.0005), at(10.0));
}

#[test]
fn columns_stand_in_any_order() {
    let text = "force_z_N, arc_length_mm,force_x_N,force_y_N,moment_z_Nmm,moment_x_Nmm,moment_y_Nmm\r\n\
        3,0,1,2,6,4,5\r\n\r\n3,1,1,2,6,4,5";
    let load = WrenchTable::read(text.as_bytes(), "wrench.csv").unwrap().load(0.5).unwrap();
    assert_eq!(load.force_N, Vector3::new(1.0, 2.0, 3.0));
    assert_eq!(load.moment_Nmm, Vector3::new(4.0, 5.0, 6.0));
}

#[test]
fn a_table_shorter_than_the_cut_is_refused_with_both_lengths() {
    let law = CuttingLaw::Table(table("0,0,1,2,3,4,5\n40,10,1,2,3,4,-5\n").unwrap());
    assert_eq!(path_loads(&law, &line(40.0)).unwrap().len(), 41);
    assert_eq!(
        path_loads(&law, &line(50.5)).unwrap_err().to_string(),
        "the wrench table covers the path from 0 to 40 mm, but the tool cuts from 0 to 50.5 mm: expected rows \
         over the whole cut"
    );
    let late = CuttingLaw::Table(table("1,0,1,2,3,4,5\n40,10,1,2,3,4,-5\n").unwrap());
    assert!(path_loads(&late, &line(40.0)).is_err());
}

#[test]
fn only_lengths_at_which_the_tool_cuts_need_rows() {
    let source = "x_mm,y_mm,z_mm,cutting\n0,0,0,0\n90,0,0,0\n95,0,0,1\n99,0,0,0\n";
    let path = Polyline::read(source, "path.csv").unwrap();
    let law = CuttingLaw::Table(table("94,1,0,0,0,0,0\n96,3,0,0,0,0,0\n").unwrap());
    let loads = path_loads(&law, path.toolpath()).unwrap();
    let force_x = |load: &PathLoad| match load {
        PathLoad::Workpiece(load) => load.force_N.x,
        other => panic!("{other:?}"),
    };
    assert_eq!(loads.iter().map(force_x).collect::<Vec<_>>(), [0.0, 0.0, 2.0, 0.0]);
}

#[test]
fn what_is_wrong_is_named_with_its_line() {
    assert_eq!(message(""), "wrench.csv:2: rows: 0; expected a header and at least 2 rows");
    assert_eq!(message("0,1,2,3,4,5,6\n"), "wrench.csv:3: rows: 1; expected a header and at least 2 rows");
    assert_eq!(message("0,1,2,3,4,5\n"), "wrench.csv:2: 6 values; expected 7, as many as columns in the header");
    assert_eq!(
        message("0,1,2,3,4,5,6\n\n5,1,2,x,4,5,6\n"),
        "wrench.csv:4: force_z_N = `x`; expected a number up to 1e12"
    );
    assert_eq!(
        message("-1,1,2,3,4,5,6\n"),
        "wrench.csv:2: arc_length_mm = `-1`; expected a length in mm, from 0 to 1e12"
    );
    assert_eq!(
        message("0,1,2,3,4,5,6\n5,1,2,3,4,5,NaN\n"),
        "wrench.csv:3: moment_z_Nmm = `NaN`; expected a number up to 1e12"
    );
    assert_eq!(
        message("0,1,2,3,4,5,6\n0,1,2,3,4,5,6\n"),
        "wrench.csv:3: arc_length_mm = 0 after 0; expected rows in order of increasing length"
    );
    for header in ["arc_length_mm,force_x_N", "s,a,b,c,d,e,f"] {
        assert_eq!(
            WrenchTable::read(header.as_bytes(), "wrench.csv").unwrap_err().to_string(),
            format!("wrench.csv:1: columns `{header}`; expected {}, in any order", HEADER.trim_end())
        );
    }
    assert_eq!(
        WrenchTable::read(b"", "wrench.csv").unwrap_err().to_string(),
        "wrench.csv:1: rows: 0; expected a header and at least 2 rows"
    );
}
