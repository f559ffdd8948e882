//! TOML to raw values: what is taken, what is refused, and the key and line that a refusal names.

use std::collections::BTreeMap;

use kinetostat_input::{
    error::{Error, Result},
    toml_file::parse,
};
use serde::Deserialize;

#[derive(Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Spec {
    name: String,
    count: Option<usize>,
    #[serde(default)]
    is_rigid: bool,
    position: [f64; 3],
    laws: Vec<Law>,
    held: BTreeMap<String, f64>,
}

#[derive(Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Law {
    None,
    Constant(f64),
    Linear { slope: f64 },
}

const WHOLE: &str = "name = 'a'\ncount = 3\nposition = [\n1,\n-2.5,\ninf]\n\
    laws = [\n'none',\n{ constant = 2 },\n{ linear = { slope = 0.5 } }]\nheld = { x = 7 }";

fn read(text: &str) -> Result<Spec> {
    parse(text, "spec.toml")
}

#[test]
fn reads_what_the_parser_reads() {
    let spec = read(WHOLE).unwrap();
    assert_eq!(spec, toml::from_str(WHOLE).unwrap());
    assert_eq!(spec.laws, [Law::None, Law::Constant(2.0), Law::Linear { slope: 0.5 }]);
}

#[test]
fn refuses_what_is_not_asked_for() {
    for (from, to, says) in [
        ("count = 3", "count = -3", "expected a whole number, 0 or more"),
        ("count = 3", "count = 3.5", "expected a whole number, 0 or more"),
        ("count = 3", "size = 3", "unknown key `size`"),
        ("name = 'a'", "", "missing key `name`"),
        ("name = 'a'", "name = 1", "expected a text in quotes"),
        ("name = 'a'", "name = 2020-01-01", "invalid type: date"),
        ("-2.5,\ninf", "-2.5", "has 2 items, expected 3"),
        ("-2.5,\ninf", "-2.5, 3, 4", "has 4 items, expected 3"),
        ("{ x = 7 }", "[7]", "expected a map"),
        ("{ x = 7 }", "{ x = true }", "expected a number"),
        ("'none'", "'some'", "unknown value `some`"),
        ("'none'", "'constant'", "wrong type, expected a table"),
        ("'none'", "{ none = 1 }", "expected a word in quotes"),
        ("{ constant = 2 }", "{ constant = 2, none = 1 }", "exactly one key"),
        ("{ slope = 0.5 }", "[0.5]", "expected a table"),
    ] {
        let said = read(&WHOLE.replace(from, to)).unwrap_err().to_string();
        assert!(said.contains(says), "{to}: {said}");
    }
}

#[test]
fn faults_have_their_key_and_their_line() {
    for (from, to, key, line) in [
        ("count = 3", "count = 3.5", "count", 2),
        ("count = 3", "size = 3", "size", 2),
        ("-2.5,", "'a',", "position[1]", 5),
        ("-2.5,\ninf", "-2.5", "position", 3),
        ("0.5", "'steep'", "laws[2].linear.slope", 10),
        ("slope = 0.5", "rise = 0.5", "laws[2].linear", 10),
        ("'none'", "'some'", "laws[0]", 8),
        ("{ x = 7 }", "{ x = true }", "held.x", 11),
        (WHOLE, "", "", 1),
    ] {
        let fault = read(&WHOLE.replace(from, to)).unwrap_err();
        let Error::Syntax { key: own, line: at, .. } = &fault else { panic!("{fault}") };
        assert_eq!((own.as_str(), *at), (key, Some(line)), "{to}: {fault}");
    }
}

/// Places are counted in bytes: letters of two bytes stand before the fault, on its line too.
#[test]
fn a_fault_quotes_the_text_that_is_at_fault() {
    for (from, to, quoted) in [
        ("count = 3", "count = 3\nname = 'b'", "`name`"),
        ("name = 'a'", "name = 'Größe'\ncount = 4", "`count`"),
        ("{ x = 7 }", "{ 'größer' = 1, x = 7, x = 8 }", "`x`"),
        ("{ x = 7 }", "{ x = 7, 'größer' = 1, 'größer' = 2 }", "`'größer'`"),
    ] {
        let fault = read(&WHOLE.replace(from, to)).unwrap_err();
        let Error::Syntax { problem, .. } = &fault else { panic!("{fault}") };
        assert_eq!(*problem, format!("key {quoted} is given twice"), "{to}");
    }
}
