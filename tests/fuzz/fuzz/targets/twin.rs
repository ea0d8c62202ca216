//! Fuzzes twin files.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| bendtwin_fuzz::twins::twin(data));
