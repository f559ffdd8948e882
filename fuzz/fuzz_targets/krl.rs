#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| kinetostat_fuzz::krl(data));
