//! ARCHITECTURE.md is what the sources are: its picture is drawn from them, and dependencies point one way.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
};

/// Crates, and folders of the engine, the library and the program; each may use those before it. What a crate uses is up to the compiler.
const ORDER: [&str; 25] = [
    "input",
    "budget",
    "removal",
    "cell",
    "spatial",
    "lanes",
    "machine",
    "statics",
    "compensation",
    "programs",
    "urdf",
    "process",
    "work",
    "simulation",
    "files",
    "figures",
    "page",
    "answer",
    "inspect",
    "redundancy",
    "questions",
    "explore",
    "products",
    "run",
    "cli",
];

/// Crates that are one entry of [`ORDER`]; the engine has its folders there.
const CRATES: [&str; 6] = ["input", "budget", "removal", "cell", "spatial", "programs"];

pub(crate) fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// All files with these extensions in `folder`, relative to the root, sorted.
pub(crate) fn files(folder: &Path, extensions: &[&str], found: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort_by_key(|path| (path.is_dir(), path.clone()));
    for path in entries {
        match path.extension() {
            _ if path.is_dir() => files(&path, extensions, found),
            Some(own) if extensions.iter().any(|extension| own == *extension) => {
                found.push(path.strip_prefix(root()).unwrap().to_path_buf());
            }
            _ => {}
        }
    }
}

fn all_sources() -> Vec<PathBuf> {
    let mut found = Vec::new();
    let crates = fs::read_dir(root().join("crates")).unwrap().map(|entry| entry.unwrap().path().join("src"));
    let mut homes: Vec<PathBuf> = crates.collect();
    homes.sort();
    for home in homes.into_iter().chain([root().join("src")]) {
        files(&home, &["rs"], &mut found);
    }
    found
}

/// The first sentence of a file's own documentation, without the marks of links and code.
fn what_it_is(file: &Path) -> String {
    let text = fs::read_to_string(root().join(file)).unwrap();
    let lines = text.lines().take_while(|line| line.starts_with("//!")).map(|line| line[3..].trim());
    let paragraph: Vec<&str> = lines.take_while(|line| !line.is_empty()).collect();
    let paragraph = paragraph.join(" ");
    // Not after an abbreviation, such as "Eq. (13)".
    let ends = |at: &(usize, &str)| paragraph[at.0 + 2..].starts_with(char::is_uppercase);
    let end = paragraph.match_indices(". ").find(ends).map_or(paragraph.len(), |(end, _)| end + 1);
    paragraph[..end].trim_end_matches(['.', ':']).replace(['[', ']', '`'], "")
}

/// The entry of [`ORDER`] that a file belongs to: its crate, or its folder of the engine or the library.
fn folder_of(file: &Path) -> Option<&'static str> {
    let parts: Vec<&str> = file.iter().map(|part| part.to_str().unwrap()).collect();
    let folder = match *parts.as_slice() {
        ["crates", "engine", "src", folder, ..] | ["src", folder, ..] => folder,
        ["crates", name, ..] => name,
        _ => return None,
    };
    ORDER.into_iter().find(|own| *own == folder)
}

/// Which entries of [`ORDER`] a file names: folders beside its own, and crates.
fn named_in(file: &Path) -> BTreeSet<usize> {
    let code = code(file);
    let beside = used(&code, if file.starts_with("src/cli") { "kinetostat::" } else { "crate::" });
    let crates = used(&code, "kinetostat_");
    // The library calls the crate of programs `toolpath`.
    let is_named = |entry: &str| {
        let alias = if entry == "programs" { "toolpath" } else { entry };
        beside.iter().any(|name| name == alias) || CRATES.contains(&entry) && crates.iter().any(|name| name == entry)
    };
    (0..ORDER.len()).filter(|place| is_named(ORDER[*place])).collect()
}

/// Which entries each entry names, by their place in [`ORDER`].
fn uses() -> BTreeMap<&'static str, BTreeSet<usize>> {
    let mut uses: BTreeMap<_, BTreeSet<usize>> = ORDER.iter().map(|folder| (*folder, BTreeSet::new())).collect();
    for file in all_sources() {
        let Some(own) = folder_of(&file) else { continue };
        uses.get_mut(own).unwrap().extend(named_in(&file).into_iter().filter(|place| ORDER[*place] != own));
    }
    uses
}

/// The file that says what an entry is, and where that stands.
fn home_of(entry: &str) -> (PathBuf, &'static str) {
    if CRATES.contains(&entry) {
        return (PathBuf::from(format!("crates/{entry}/src/lib.rs")), "crates/");
    }
    let homes = [("src", "src/"), ("crates/engine/src", "crates/engine/src/")];
    let of = |(home, name): (&str, &'static str)| (PathBuf::from(format!("{home}/{entry}/mod.rs")), name);
    homes.map(of).into_iter().find(|(file, _)| root().join(file).is_file()).expect("a folder with a mod.rs")
}

/// All entries, those that users see first; of each what it uses directly, but for what these use themselves, and what it is.
fn picture() -> String {
    let uses = uses();
    let mut reached: Vec<BTreeSet<usize>> = Vec::new();
    for folder in ORDER {
        let own = &uses[folder];
        // Each may use those before it, of which it is known.
        reached.push(own.iter().chain(own.iter().flat_map(|used| reached.get(*used)).flatten()).copied().collect());
    }
    let library = fs::read_to_string(root().join("src/lib.rs")).unwrap();
    let line = |(name, uses, what): (&str, &str, &str)| format!("{name:<16}{uses:<37}{what}\n");
    let mut picture = line(("what", "uses", "what it is"));
    let mut home_before = "";
    for folder in ORDER.iter().rev() {
        let (main, home) = home_of(folder);
        if home != home_before {
            picture += &format!("{home}\n");
            home_before = home;
        }
        let is_implied = |used: &usize| uses[folder].iter().any(|other| reached[*other].contains(used));
        let direct: Vec<&str> = uses[folder].iter().filter(|used| !is_implied(used)).map(|used| ORDER[*used]).collect();
        let is_report = library.contains(&format!("#[cfg(feature = \"report\")]\npub mod {folder};"));
        let name = format!("  {folder}{}", if is_report { " *" } else { "" });
        picture += &line((&name, &direct.join(" "), &what_it_is(&main)));
    }
    picture.lines().map(|line| format!("{}\n", line.trim_end())).collect()
}

/// What the picture stands between.
const FENCES: [&str; 2] = ["```text\n", "```\n"];

#[test]
fn the_picture_is_drawn_from_the_sources() {
    let page = root().join("ARCHITECTURE.md");
    let text = fs::read_to_string(&page).unwrap();
    let (head, rest) = text.split_once(FENCES[0]).expect("a picture");
    let (found, tail) = rest.split_once(FENCES[1]).expect("the end of the picture");
    let picture = picture();
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        fs::write(&page, format!("{head}{}{picture}{}{tail}", FENCES[0], FENCES[1])).unwrap();
    } else if let Some((line, drawn)) =
        picture.lines().enumerate().find(|(line, own)| found.lines().nth(*line) != Some(own))
    {
        panic!(
            "line {line} of the picture should be {drawn:?}; UPDATE_GOLDEN=1 cargo test --all-features --test it architecture:: draws it"
        );
    }
    assert!(text.len() <= 12_000, "{} bytes: a page that can be held takes at most 12,000", text.len());
}

#[test]
fn every_file_says_what_it_is() {
    for file in all_sources() {
        assert!(!what_it_is(&file).is_empty(), "{} does not say what it is", file.display());
    }
}

#[test]
fn every_folder_is_in_the_picture() {
    for home in ["crates", "crates/engine/src", "src"] {
        for entry in fs::read_dir(root().join(home)).unwrap().map(|entry| entry.unwrap()) {
            let name = entry.file_name().into_string().unwrap();
            let has_place = ORDER.contains(&&*name) || home == "crates" && name == "engine";
            assert!(entry.path().is_file() || has_place, "{home}/{name} has no place in ORDER");
        }
    }
}

#[test]
fn dependencies_point_one_way() {
    for file in all_sources() {
        let Some(own) = folder_of(&file).and_then(|own| ORDER.iter().position(|name| *name == own)) else { continue };
        let above = named_in(&file).into_iter().find(|other| *other > own);
        assert_eq!(above.map(|other| ORDER[other]), None, "{} uses what is above it", file.display());
    }
}

/// Who wants to read and rewrite programs takes their crate alone.
#[test]
fn programs_know_no_machine() {
    let manifest = fs::read_to_string(root().join("crates/programs/Cargo.toml")).unwrap();
    let ours: Vec<&str> = manifest.lines().filter_map(|line| line.strip_prefix("kinetostat-")).collect();
    let names: Vec<&str> = ours.iter().filter_map(|line| line.split(' ').next()).collect();
    assert_eq!(names, ["input", "spatial"]);
}

/// Pages are made of files alone: what they show of a machine or a question is told to them.
#[test]
fn figures_files_and_pages_know_no_machine_and_no_question() {
    const UNKNOWN: [&str; 9] =
        ["lanes", "machine", "statics", "compensation", "urdf", "toolpath", "redundancy", "questions", "products"];
    for file in all_sources() {
        if folder_of(&file).is_some_and(|own| ["figures", "files", "page"].contains(&own)) {
            let named = used(&code(&file), "crate::");
            let foreign = UNKNOWN.iter().find(|folder| named.iter().any(|name| name == *folder));
            assert_eq!(foreign, None, "{}", file.display());
        }
    }
}

/// What a page does with results of one question, that question declares: another one needs nothing here.
#[test]
fn pages_know_no_question_by_a_word() {
    let list = fs::read_to_string(root().join("src/questions/mod.rs")).unwrap();
    let is_word = |text: &&str| text.bytes().all(|byte| byte.is_ascii_lowercase() || byte == b'_');
    let rows = list.lines().skip_while(|line| !line.contains("enum StudyKind {")).take_while(|line| *line != "    }");
    let words = rows.filter_map(|line| line.trim_start().split_once(": ")).map(|(key, _)| key).filter(is_word);
    let words: Vec<String> = words.map(|key| format!("\"{key}\"")).collect();
    assert!(words.len() >= 9 && words.contains(&"\"workspace_map\"".into()), "{words:?}");
    for file in all_sources().iter().filter(|file| file.starts_with("src/page")) {
        let code = code(file);
        let known = words.iter().find(|word| code.contains(*word));
        assert_eq!(known, None, "{}: the question declares it in its PageKind", file.display());
        let names = code.match_indices(".csv\"").filter_map(|(end, _)| code[..end].rsplit('"').next());
        let table = names.filter(|name| !name.contains('{')).last();
        assert_eq!(table, None, "{} knows a table of a question", file.display());
    }
}

/// A test inside is compiled with a library of its own, a second time.
#[test]
fn no_test_stands_in_the_sources() {
    for file in all_sources() {
        assert!(!code(&file).contains("cfg(test)"), "{}: expected its tests in tests/it", file.display());
    }
}

/// The words of `text` that are not followed by `::`.
fn names(text: &str) -> impl Iterator<Item = &str> {
    let words = text.split(|part: char| !(part.is_alphanumeric() || part == '_' || part == ':'));
    words.filter(|word| !word.is_empty() && !word.ends_with(':')).filter_map(|word| word.rsplit("::").next())
}

#[test]
fn what_a_program_needs_is_at_the_top_of_the_crate() {
    let read = |file: &str| fs::read_to_string(root().join(file)).unwrap();
    let statements = |text: &str, begin: &str| -> Vec<String> {
        text.split(begin).skip(1).map(|rest| rest.split(';').next().unwrap().to_string()).collect()
    };
    let library = read("src/lib.rs");
    let doorway = statements(library.split_once("pub use nalgebra;").unwrap().1, "pub use ");
    let doorway: BTreeSet<&str> = doorway.iter().flat_map(|statement| names(statement)).collect();
    assert!((50..=60).contains(&doorway.len()), "{}: {doorway:?}", doorway.len());
    for file in
        ["docs/library.md", "examples/compensate.rs", "examples/equilibrium.rs", "examples/map.rs", "examples/place.rs"]
    {
        let used = statements(&read(file), "use kinetostat::");
        assert!(!used.is_empty(), "{file}");
        for list in used {
            let own = list.split("nalgebra::").next().unwrap();
            assert!(!own.contains("::"), "{file} goes into a module: {own}");
            let foreign: Vec<_> = names(own).filter(|name| !doorway.contains(name)).collect();
            assert!(foreign.is_empty(), "{file} uses {foreign:?}, not at the top of the crate");
        }
    }
}

/// Most lines of each crate, 5 % more than it had when that was written; all of them together have a limit of their own. A new capability is a
/// crate, or says what it takes out.
const MAX_LINES: [(&str, usize); 8] = [
    ("crates/budget/src", 300),
    ("crates/cell/src", 1_470),
    ("crates/engine/src", 22_450),
    ("crates/input/src", 1_260),
    ("crates/programs/src", 32_300),
    ("crates/removal/src", 3_260),
    ("crates/spatial/src", 810),
    ("src", 81_450),
];
const MAX_LINES_OF_ALL: usize = 140_920;

#[test]
fn no_crate_outgrows_its_lines() {
    let page = fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let mut all = 0;
    let mut homes = BTreeSet::new();
    let written = |most: usize| match most / 1000 {
        0 => most.to_string(),
        thousands => format!("{thousands},{:03}", most % 1000),
    };
    for (home, most) in MAX_LINES {
        let inside: Vec<PathBuf> = all_sources().into_iter().filter(|file| file.starts_with(home)).collect();
        let lines = |file: &PathBuf| fs::read_to_string(root().join(file)).unwrap().lines().count();
        let found: usize = inside.iter().map(lines).sum();
        assert!(
            found <= most,
            "{home}: {found} lines, at most {most}: a new capability is a crate, or says what it takes out"
        );
        assert!(most <= found + found / 8, "{home}: {found} lines, and {most} allowed: expected 5 % of slack");
        assert!(page.contains(&written(most)), "ARCHITECTURE.md does not say that {home} may have {}", written(most));
        all += found;
        homes.insert(home);
    }
    assert!(all <= MAX_LINES_OF_ALL && page.contains(&written(MAX_LINES_OF_ALL)), "{all} lines in all");
    for file in all_sources() {
        assert!(homes.iter().any(|home| file.starts_with(home)), "{} has no limit", file.display());
    }
}

/// What names of columns end with: their units.
const UNITS: [&str; 12] = ["mm", "um", "deg", "mrad", "rad", "N", "Nm", "Nmm", "percent", "s", "Hz", "N_per_mm"];

/// Names of columns in the reports of questions, keys of JSON left out, with how often each is there.
fn columns_of(question: &str) -> BTreeMap<String, usize> {
    let folder = Path::new("src/questions").join(question).join("report");
    let mut columns = BTreeMap::new();
    for file in all_sources().iter().filter(|file| file.starts_with(&folder)) {
        let code = code(file);
        // Between quotes is every second part.
        let parts: Vec<&str> = code.split('"').collect();
        for (text, behind) in parts.iter().zip(&parts[1..]).skip(1).step_by(2) {
            let is_name =
                !text.starts_with('_') && text.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_');
            let has_unit = UNITS.iter().any(|unit| text.ends_with(&format!("_{unit}")));
            if is_name && has_unit && !behind.starts_with(':') {
                *columns.entry((*text).to_string()).or_default() += 1;
            }
        }
    }
    columns
}

#[test]
fn a_question_names_a_column_once() {
    let questions = fs::read_dir(root().join("src/questions")).unwrap().map(|entry| entry.unwrap());
    let questions = questions.filter(|entry| entry.path().join("report").is_dir());
    let mut count = 0;
    for question in questions {
        let question = question.file_name().into_string().unwrap();
        let columns = columns_of(&question);
        count += columns.len();
        let again: Vec<_> = columns.into_iter().filter(|(_, times)| *times > 1).collect();
        assert!(again.is_empty(), "{question} names columns more than once: {again:?}");
    }
    assert!(count > 50, "{count} columns");
}

/// The code of a file without comments.
fn code(file: &Path) -> String {
    let text = fs::read_to_string(root().join(file)).unwrap();
    text.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

#[test]
fn no_questions_use_one_another_in_a_circle() {
    let part = |file: &Path| file.iter().nth(2).map(|part| part.to_str().unwrap().trim_end_matches(".rs").to_string());
    let files = all_sources()
        .into_iter()
        .filter(|file| file.starts_with("src/questions") && !file.ends_with("questions/mod.rs"));
    let mut arrows: Vec<(String, String)> = Vec::new();
    for file in files {
        let own = part(&file).unwrap();
        arrows.extend(
            used(&code(&file), "questions::")
                .into_iter()
                .filter(|other| *other != own)
                .map(|other| (own.clone(), other)),
        );
    }
    assert!(arrows.contains(&("validation".into(), "path".into())), "the one question that is made of another");
    // What nobody uses any more is taken away until nothing is left.
    while !arrows.is_empty() {
        let is_used = |name: &String| arrows.iter().any(|(_, used)| used == name);
        let left: Vec<_> = arrows.iter().filter(|(user, _)| is_used(user)).cloned().collect();
        assert!(left.len() < arrows.len(), "in a circle: {left:?}");
        arrows = left;
    }
}

/// Folders of the crate of programs; each may use those before it, so that nothing that is read hangs on how it is written.
const TOOLPATHS: [&str; 4] = ["model", "read", "expand", "write"];

#[test]
fn what_is_read_of_a_program_knows_nothing_of_how_it_is_written() {
    let place = |folder: &str| TOOLPATHS.iter().position(|name| *name == folder);
    let mut seen = [0; 4];
    for file in all_sources().iter().filter(|file| file.starts_with("crates/programs/src")) {
        let Some(own) = file.iter().nth(3).and_then(|part| place(part.to_str().unwrap())) else { continue };
        seen[own] += 1;
        for used in used(&code(file), "crate::").iter().filter(|used| !used.is_empty()) {
            // Beside the folders there are the names that users have; of these, those of points and faults are of the model.
            let is_below = place(used).map_or(used.starts_with(char::is_uppercase), |other| other <= own);
            assert!(is_below, "{} uses {used}, which is above it", file.display());
        }
    }
    assert!(seen.iter().all(|files| *files > 5), "{seen:?}");
}

/// What is named after `prefix`, in braces too.
fn used(code: &str, prefix: &str) -> Vec<String> {
    let word = |text: &str| text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let mut folders = Vec::new();
    for part in code.split(prefix).skip(1) {
        let Some(inner) = part.strip_prefix('{') else {
            folders.push(word(part));
            continue;
        };
        let mut depth = 0;
        for (at, c) in inner.char_indices() {
            match c {
                '{' => depth += 1,
                '}' if depth == 0 => break,
                '}' => depth -= 1,
                _ if depth == 0 && (at == 0 || inner[..at].ends_with([' ', ','])) => folders.push(word(&inner[at..])),
                _ => {}
            }
        }
    }
    folders
}

/// The functions of the standard library are the system's, whose last digits depend on the processor (with or without fused multiply-add).
#[test]
fn functions_are_those_of_libm() {
    const SYSTEM: &str = "sin cos tan asin acos atan atan2 sin_cos sinh cosh tanh asinh acosh atanh exp exp2 exp_m1 ln ln_1p log log2 log10 \
                          powf cbrt hypot mul_add";
    let mut sources = all_sources();
    files(&root().join("python/src"), &["rs"], &mut sources);
    for file in sources {
        // A quaternion's power is nalgebra's, which takes its functions from libm.
        for line in code(&file).lines().filter(|line| !line.contains("rotation_to(b).powf(")) {
            let called = SYSTEM.split(' ').find(|name| {
                line.contains(&format!(".{name}("))
                    || line.split("f64::").skip(1).any(|rest| names(rest).next() == Some(*name))
            });
            assert_eq!(called, None, "{}: expected the function of libm in {}", file.display(), line.trim());
        }
    }
}

/// With its feature `std`, nalgebra has large products from `matrixmultiply`, whose last digits depend on the processor.
#[test]
fn nalgebra_does_not_choose_its_arithmetic_by_the_processor() {
    for folder in ["", "python", "web", "fuzz"] {
        let lock = fs::read_to_string(root().join(folder).join("Cargo.lock")).unwrap();
        let own = lock.split("[[package]]").find(|package| package.contains("name = \"nalgebra\"\n")).unwrap();
        assert!(own.contains("\"simba\"") && !own.contains("matrixmultiply"), "{folder}/Cargo.lock: {own}");
    }
}

/// A property that draws anew in each run fails in some run for what somebody else has changed.
#[test]
fn every_property_draws_from_a_fixed_seed() {
    let mut all = all_sources();
    for tests in ["tests", "crates/engine/tests", "crates/programs/tests", "crates/spatial/tests"] {
        files(&root().join(tests), &["rs"], &mut all);
    }
    let mut count = 0;
    for file in all.iter().filter(|file| !file.ends_with("architecture.rs")) {
        let text = fs::read_to_string(root().join(file)).unwrap();
        for property in ["proptest! {", "proptest!(", "TestRunner::new("] {
            for (at, _) in text.match_indices(property) {
                let head: String = text[at..].lines().take(2).collect();
                assert!(head.contains("cases("), "{}: {property} without `cases`", file.display());
                count += 1;
            }
        }
    }
    assert!(count > 25, "{count}");
}
