//! How near names are to one another.

use kinetostat_input::names::edit_distance;

#[test]
fn edits_are_those_of_levenshtein() {
    for (one, other, expected) in [("", "", 0), ("a", "", 1), ("kitten", "sitting", 3), ("flaw", "lawn", 2)] {
        assert_eq!(edit_distance(one, other), expected, "{one} {other}");
        assert_eq!(edit_distance(other, one), expected, "{other} {one}");
    }
}
