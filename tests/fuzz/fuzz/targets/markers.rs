//! Fuzzes markers of motion capture.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| bendtwin_fuzz::markers::markers(data));
