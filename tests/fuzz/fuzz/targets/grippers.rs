//! Fuzzes the document of a robot's grippers.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| bendtwin_fuzz::archives::grippers(data));
