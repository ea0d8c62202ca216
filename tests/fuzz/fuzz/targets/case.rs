//! Fuzzes the pickle of a PhysTwin case.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| bendtwin_fuzz::archives::case(data));
