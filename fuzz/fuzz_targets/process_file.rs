#![no_main]

use std::path::Path;

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/inputs");

libfuzzer_sys::fuzz_target!(|data: &[u8]| kinetostat_fuzz::process_file(data, Path::new(FOLDER)));
