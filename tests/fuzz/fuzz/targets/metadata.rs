//! Fuzzes `metadata.json` of raw cases.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| bendtwin_fuzz::archives::metadata(data));
