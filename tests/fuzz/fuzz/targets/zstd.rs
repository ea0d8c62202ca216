//! Fuzzes chunks in Zstandard.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| bendtwin_fuzz::recordings::zstd(data));
