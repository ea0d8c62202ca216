//! Fuzzes headers of uploads.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| bendtwin_fuzz::requests::tus(data));
