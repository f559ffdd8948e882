//! Every saved fuzz input, seeds and past faults, and inputs too large to save: no panic, no hang, no overflow of a
//! thread's stack. What is done with an input, and what must follow, is in `fuzz/src/lib.rs`.

#[path = "../../fuzz/src/lib.rs"]
mod targets;

use std::{
    fs,
    panic::{AssertUnwindSafe, catch_unwind},
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use kinetostat::{
    machine::{Machine, catalogue},
    questions::{Overrides, Study},
    toolpath::{
        Sampling, WriteOptions,
        gcode::{Dialect, GcodeOptions, GcodeProgram},
        polyline::Polyline,
    },
};

/// Fewer inputs than this for a target means that files were lost.
const LEAST_FILES: usize = 10;
/// An input of a few kilobytes that takes longer hangs; a debug build on a busy machine is far below.
const LONGEST: Duration = Duration::from_secs(20);

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz").join(name)
}

/// The saved inputs of a target; the test fails if they are missing.
fn saved(target: &str) -> Vec<PathBuf> {
    let folder = folder("corpus").join(target);
    let entries = fs::read_dir(&folder).unwrap_or_else(|e| panic!("{} is missing: {e}", folder.display()));
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(files.len() >= LEAST_FILES, "{} holds only {} files", folder.display(), files.len());
    files
}

/// Runs all saved inputs of a target and reports every failure at once.
fn run(target: &str, one: impl Fn(&[u8])) {
    let mut failed = Vec::new();
    for file in saved(target) {
        let data = fs::read(&file).unwrap();
        let began = Instant::now();
        let is_good = catch_unwind(AssertUnwindSafe(|| one(&data))).is_ok();
        if !is_good || began.elapsed() > LONGEST {
            failed.push(format!("{} after {:.1?}", file.display(), began.elapsed()));
        }
    }
    assert!(failed.is_empty(), "{} inputs fail:\n{}", failed.len(), failed.join("\n"));
}

#[test]
fn machine_files() {
    run("machine_file", targets::machine_file);
}

#[test]
fn process_files() {
    let inputs = folder("inputs");
    run("process_file", |data| targets::process_file(data, &inputs));
}

#[test]
fn study_files() {
    let inputs = folder("inputs");
    run("study_file", |data| targets::study_file(data, &inputs));
}

#[test]
fn polylines() {
    run("path_csv", targets::path_csv);
}

#[test]
fn programs() {
    run("gcode", targets::gcode);
    run("sinumerik", targets::sinumerik);
    run("heidenhain", targets::heidenhain);
    run("krl", targets::krl);
    run("rapid", targets::rapid);
    run("apt", targets::apt);
}

/// The refusal of a machine file, which must come at once.
fn refusal(text: &str) -> String {
    let began = Instant::now();
    let message = Machine::from_toml(text, "m.toml").expect_err("no machine file").to_string();
    assert!(began.elapsed() < LONGEST, "took {:.1?}: {}", began.elapsed(), &message[..message.len().min(200)]);
    message
}

#[test]
fn deep_nesting_is_refused() {
    const DEPTH: usize = 200_000;
    for text in [
        format!("schema = {}1{}", "[".repeat(DEPTH), "]".repeat(DEPTH)),
        format!("schema = {}1{}", "{a=".repeat(DEPTH), "}".repeat(DEPTH)),
        format!("schema = {}", "[".repeat(DEPTH)),
        format!("{}a = 1", "a.".repeat(DEPTH)),
        format!("schema = {{{}a = 1}}", "a.".repeat(DEPTH)),
        format!("[{}a]\nb = 1", "a.".repeat(DEPTH)),
        format!("[[{}a]]\nb = 1", "a.".repeat(DEPTH)),
        format!("title.{}a = 1\nschema = 1", "a.".repeat(DEPTH)),
    ] {
        assert!(refusal(&text).starts_with("m.toml"), "{}", &text[..40]);
    }
}

/// The Orthoglide with `more` at its end.
fn orthoglide_and(more: &str) -> String {
    format!("{}\n{more}", catalogue::find("orthoglide").unwrap().toml)
}

#[test]
fn machines_too_large_to_solve_are_refused() {
    let mount = |i: usize| format!("[[mount]]\nname = \"m{i}\"\nchain = \"leg\"\n");
    let mounts: String = (0..5000).map(mount).collect();
    let message = refusal(&orthoglide_and(&mounts));
    assert!(message.contains("mount: ") && message.contains("at most"), "{message}");

    let joint = |i: usize| format!("{{ revolute_joint = {{ name = \"j{i}\", axis = \"z\" }} }}");
    let drive = "{ prismatic_drive = { name = \"d\", axis = \"x\", stiffness_N_per_mm = 1.0 } }".to_string();
    let joints: Vec<String> = std::iter::once(drive).chain((0..5000).map(joint)).collect();
    let long =
        format!("[[chain]]\nname = \"long\"\nelements = [{}]\n[[mount]]\nname=\"l\"\nchain=\"long\"", joints.join(","));
    let message = refusal(&orthoglide_and(&long));
    assert!(message.contains("coordinates") && message.contains("at most"), "{message}");
}

#[test]
fn long_lines_and_many_rows_take_no_time() {
    let began = Instant::now();
    let options = GcodeOptions::default();
    let long_line = "M1 ".repeat(300_000);
    let digits = format!("G0 X{}", "1".repeat(1_000_000));
    let comment = format!("({}", "(".repeat(1_000_000));
    let brackets = format!("MSG{}", "(".repeat(1_000_000));
    let words = format!("L {}", "X+1 ".repeat(300_000));
    let centres = format!("BEGIN PGM A MM\nL X+0 Y+0 Z+0\n{}", "CC X+1 Y+1\n".repeat(100_000));
    for source in [long_line, digits, comment, brackets, words, centres] {
        for dialect in Dialect::ALL {
            let options = GcodeOptions { dialect: Some(dialect), ..options.clone() };
            match GcodeProgram::parse(source.clone(), "p.nc", &options) {
                Ok(program) => {
                    let path = program.toolpath(Sampling::default()).unwrap();
                    let written = program
                        .rewrite(&path, &path.positions_mm(), WriteOptions::with_decimals(program.own_format()))
                        .unwrap();
                    assert!(written.bytes() == source.as_bytes());
                }
                Err(refusal) => {
                    let message = refusal.to_string();
                    assert!(message.starts_with("p.nc:1"), "{}", &message[..60]);
                }
            }
        }
    }
    for source in [",".repeat(1_000_000), "\"".repeat(1_000_001), format!("x_mm,y_mm,{}", "z".repeat(1_000_000))] {
        let message = Polyline::read(source, "p.csv").unwrap_err().to_string();
        assert!(message.starts_with("p.csv:1"), "{}", &message[..60]);
    }
    assert!(began.elapsed() < LONGEST, "{:.1?}", began.elapsed());
}

/// The refusal of a study file that names others.
fn study_refusal(text: &str) -> String {
    let study = Study::from_toml(text, "study.toml", folder("inputs"), &Overrides::default());
    study.expect_err("no study").to_string()
}

#[test]
fn a_study_cannot_ask_for_more_points_than_fit_in_memory() {
    let case = |i: usize| {
        format!(
            "[[validation.case]]\nname = \"c{i}\"\ncircle = {{ centre_mm = [0.0, 0.0, 0.0], diameter_mm = 5.0, points = 1000000 }}\n"
        )
    };
    let cases: String = (0..1000).map(case).collect();
    let message = study_refusal(&format!(
        "schema = 3\nquestion = \"?\"\nmachine = \"orthoglide\"\n[[validation.variant]]\nname = \"v\"\nprocess = \"process.toml\"\n{cases}"
    ));
    assert!(message.starts_with("study.toml: validation.case") && message.contains("2000000"), "{message}");

    let feature = |i: usize| {
        format!(
            "[[placement.feature]]\nname = \"f{i}\"\nprocess = \"process_unplaced.toml\"\ntolerance_mm = 1.0\ncircle = {{ centre_mm = [0.0, 0.0, 0.0], diameter_mm = 5.0, points = 1000000 }}\n"
        )
    };
    let features: String = (0..1000).map(feature).collect();
    let rest = "[placement.fixed]\nx_mm = 0.0\ny_mm = 0.0\nz_mm = 0.0\n[placement.objective]\nweights = { worst_deflection = 1.0 }\n[placement.search]\ngrid = { x = 1 }\n";
    let message = study_refusal(&format!("schema = 3\nquestion = \"?\"\nmachine = \"orthoglide\"\n{features}{rest}"));
    assert!(message.starts_with("study.toml: placement.feature") && message.contains("2000000"), "{message}");
}

#[cfg(unix)]
#[test]
fn a_device_is_no_input_file() {
    for endless in ["/dev/zero", "/dev/random"] {
        let path = format!(
            "schema = 3\nquestion = \"?\"\nmachine = \"orthoglide\"\nprocess = \"process.toml\"\n[path]\nfile = \"{endless}\"\n"
        );
        assert!(study_refusal(&path).starts_with(endless));
        let process = format!(
            "schema = 3\nquestion = \"?\"\nmachine = \"orthoglide\"\nprocess = \"{endless}\"\n[path]\ncircle = {{ centre_point = \"Q1\", diameter_mm = 50.0, points = 9 }}\n"
        );
        assert!(study_refusal(&process).starts_with(endless));
    }
}

/// Words that change the meaning of an input more than single bytes do.
const WORDS: [&str; 40] = [
    "nan",
    "inf",
    "-inf",
    "1e308",
    "-1e308",
    "1e-320",
    "1e18",
    "-1e18",
    "1e-18",
    "0",
    "-0.0",
    "1e6",
    "-1",
    "999999",
    "18446744073709551615",
    "-9223372036854775808",
    "0.5e-9",
    "[",
    "]",
    "{",
    "}",
    "[[",
    "]]",
    "=",
    ".",
    ",",
    "\"",
    "\n",
    "\r\n",
    "%",
    "(",
    ")",
    "/",
    "G91",
    "G2",
    "R-5",
    "I0 J0",
    "true",
    "\u{feff}",
    "ä",
];

/// What is done with an input.
type One<'a> = &'a dyn Fn(&[u8]);

/// So many failures end a search: most are the same.
const MAX_FAILURES: usize = 5;

/// Random numbers, xorshift64*.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 33) as usize % n.max(1)
    }

    /// A part of `data` of at most `most` bytes.
    fn part(&mut self, data: &[u8], most: usize) -> std::ops::Range<usize> {
        let start = self.below(data.len() + 1);
        start..(start + self.below(most + 1)).min(data.len())
    }

    /// A run of letters or of digits in `data`, which is what keys, words and numbers are.
    fn token(&mut self, data: &[u8]) -> std::ops::Range<usize> {
        let at = self.below(data.len());
        let is_token = |b: &u8| b.is_ascii_alphanumeric() || matches!(b, b'.' | b'-' | b'_' | b'+');
        let start = data[..at].iter().rposition(|b| !is_token(b)).map_or(0, |p| p + 1);
        let end = data[at..].iter().position(|b| !is_token(b)).map_or(data.len(), |p| at + p);
        start..end.max(start)
    }

    /// `data` with a few changes; `other` is another input to take parts from.
    fn mutated(&mut self, data: &[u8], other: &[u8]) -> Vec<u8> {
        let mut data = data.to_vec();
        for _ in 0..=self.below(4) {
            let word = WORDS[self.below(WORDS.len())].bytes();
            match self.below(7) {
                0 if !data.is_empty() => {
                    let at = self.below(data.len());
                    data[at] = self.below(256) as u8;
                }
                1 => drop(data.splice(self.part(&data, 0), word)),
                2 => drop(data.drain(self.part(&data, 40))),
                3 => {
                    let copied = data[self.part(&data, 200)].to_vec();
                    drop(data.splice(self.part(&data, 0), copied));
                }
                4 => drop(data.splice(self.part(&data, 20), other[self.part(other, 100)].to_vec())),
                _ => drop(data.splice(self.token(&data), word)),
            }
        }
        data
    }
}

/// Searches where there is no nightly compiler: saved inputs, changed at random, for `FUZZ_SECONDS` (10) per target. An
/// input that fails is saved in the corpus.
#[test]
#[ignore = "a search, not a test"]
fn changed_inputs() {
    let from_environment = |key: &str| std::env::var(key).ok().and_then(|text| text.parse::<u64>().ok());
    let seconds = Duration::from_secs(from_environment("FUZZ_SECONDS").unwrap_or(10));
    let mut random = Random(from_environment("FUZZ_SEED").unwrap_or(1).max(1));
    let inputs = folder("inputs");
    let process = |data: &[u8]| targets::process_file(data, &inputs);
    let study = |data: &[u8]| targets::study_file(data, &inputs);
    let targets: [(&str, One<'_>); 10] = [
        ("machine_file", &targets::machine_file),
        ("process_file", &process),
        ("study_file", &study),
        ("path_csv", &targets::path_csv),
        ("gcode", &targets::gcode),
        ("sinumerik", &targets::sinumerik),
        ("heidenhain", &targets::heidenhain),
        ("krl", &targets::krl),
        ("rapid", &targets::rapid),
        ("apt", &targets::apt),
    ];
    let mut failed = Vec::new();
    for (target, one) in targets {
        let seeds: Vec<Vec<u8>> = saved(target).iter().map(|file| fs::read(file).unwrap()).collect();
        let (began, mut tried, mut slowest) = (Instant::now(), 0, Duration::ZERO);
        while began.elapsed() < seconds {
            let [a, b] = [0; 2].map(|_| random.below(seeds.len()));
            let data = random.mutated(&seeds[a], &seeds[b]);
            let start = Instant::now();
            let is_good = catch_unwind(AssertUnwindSafe(|| one(&data))).is_ok();
            tried += 1;
            slowest = slowest.max(start.elapsed());
            if !is_good || start.elapsed() > LONGEST {
                let file = folder("corpus").join(target).join(format!("found_{}", failed.len()));
                fs::write(&file, &data).unwrap();
                failed.push(file);
            }
            if failed.len() >= MAX_FAILURES {
                break;
            }
        }
        println!("{target}: {tried} inputs, the slowest in {slowest:.1?}");
    }
    assert!(failed.is_empty(), "{} inputs fail: {failed:?}", failed.len());
}

/// A pipe without a writer would be waited for without end.
#[cfg(unix)]
#[test]
fn a_pipe_is_no_input_file() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe.csv");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let study = format!(
        "schema = 3\nquestion = \"?\"\nmachine = \"orthoglide\"\nprocess = \"process.toml\"\n[path]\nfile = \"{}\"\n",
        pipe.display()
    );
    let expected = format!("{}: cannot be read: is a device or a pipe, expected a file", pipe.display());
    assert_eq!(study_refusal(&study), expected);
    let head = "schema = 3\nquestion = \"?\"\n";
    let measured = format!(
        "{head}machine = \"fanuc_r2000ic\"\n[identification]\ndata = \"{}\"\nunknowns = [\"arm.J1.stiffness\"]\n",
        pipe.display()
    );
    let of_machine = study.replace("\"orthoglide\"", &format!("{:?}", pipe.display().to_string()));
    for study in [measured, of_machine] {
        assert_eq!(study_refusal(&study), expected);
    }
}
