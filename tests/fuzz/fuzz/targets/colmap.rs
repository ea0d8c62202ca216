//! Fuzzes models of COLMAP.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| bendtwin_fuzz::calibrations::colmap(data));
