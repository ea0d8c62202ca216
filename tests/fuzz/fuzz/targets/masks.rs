//! Fuzzes masks: arrays, archives of them, and run lengths in JSON.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| bendtwin_fuzz::archives::masks(data));
