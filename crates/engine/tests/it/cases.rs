//! How many cases the properties of tests draw, and from which seed.

use std::panic::Location;

use proptest::test_runner::{Config, FileFailurePersistence, RngSeed};

/// `count` random cases, the same in every run. `INVARIANT_CASES` multiplies them and draws new ones, from the seed `PROPTEST_RNG_SEED` if there
/// is one. Seeds of cases that fail are kept in `tests/proptest-regressions` and tried first from then on.
#[track_caller]
pub fn cases(count: u32) -> Config {
    let factor = std::env::var("INVARIANT_CASES").ok();
    let factor = factor.map(|text| text.parse::<u32>().expect("INVARIANT_CASES: expected a whole number"));
    let given = Config::default();
    let rng_seed = match given.rng_seed {
        RngSeed::Random if factor.is_none() => RngSeed::Fixed(1),
        seed => seed,
    };
    let file = Location::caller().file();
    let name = file.rsplit("tests/it/").next().unwrap_or(file).trim_end_matches(".rs").replace('/', "_");
    let kept: &str = Box::leak(format!("tests/proptest-regressions/{name}.txt").into_boxed_str());
    let failure_persistence = Some(Box::new(FileFailurePersistence::Direct(kept)) as Box<_>);
    Config { cases: count * factor.unwrap_or(1), failure_persistence, rng_seed, ..given }
}
