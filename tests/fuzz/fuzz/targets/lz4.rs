//! Fuzzes chunks in LZ4.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| bendtwin_fuzz::recordings::lz4(data));
