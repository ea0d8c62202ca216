//! Fuzzes files of Gaussians.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| bendtwin_fuzz::splats::splats(data));
