//! What results were computed from: what tells two sets of inputs apart.

use kinetostat::input::Inputs;

#[test]
fn a_change_is_told_by_input_and_line() {
    let before = Inputs::of("study.toml", "a\nb").and(Inputs::of("feet.toml", "k = 1\n"));
    assert_eq!(before.change_since(&before), None);
    for (now, change) in [
        (
            Inputs::of("study.toml", "a\nc").and(Inputs::of("feet.toml", "k = 1\n")),
            "study.toml, line 2: was `b`, is `c`",
        ),
        (
            Inputs::of("study.toml", "a\nb\nc").and(Inputs::of("feet.toml", "k")),
            "study.toml, line 3: was the end, is `c`",
        ),
        (Inputs::of("study.toml", "a").and(Inputs::of("feet.toml", "")), "study.toml, line 2: was `b`, is the end"),
        (
            Inputs::of("study.toml", "a\nb").and(Inputs::of("feet.toml", "k = 1")),
            "feet.toml: the ends of its lines differ",
        ),
        (Inputs::of("study.toml", "a\nb"), "the inputs were study.toml, feet.toml, and are study.toml"),
    ] {
        assert_eq!(now.change_since(&before).unwrap(), change);
    }
}

#[test]
fn the_hash_depends_on_texts_and_where_they_end() {
    let inputs = Inputs::of("a", "12").and(Inputs::of("b", "3"));
    assert_eq!(inputs.sha256(), Inputs::of("x", "12").and(Inputs::of("y", "3")).sha256());
    assert_ne!(inputs.sha256(), Inputs::of("a", "1").and(Inputs::of("b", "23")).sha256());
    assert_eq!(inputs.sha256().len(), 64);
}
