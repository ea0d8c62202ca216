//! Fuzzes the envelope of checkpoints.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| bendtwin_fuzz::twins::checkpoint(data));
