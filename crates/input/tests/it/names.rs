//! How near names are to one another.

use kinetostat_input::names::edits;

#[test]
fn edits_are_those_of_levenshtein() {
    for (one, other, expected) in [("", "", 0), ("a", "", 1), ("kitten", "sitting", 3), ("flaw", "lawn", 2)] {
        assert_eq!(edits(one, other), expected, "{one} {other}");
        assert_eq!(edits(other, one), expected, "{other} {one}");
    }
}
