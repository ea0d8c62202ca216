//! Fuzzes `capture.json`.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| bendtwin_fuzz::archives::manifest(data));
