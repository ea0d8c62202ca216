//! Fuzzes calibrations of BendTwin and of other programs.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| bendtwin_fuzz::calibrations::calibration(data));
