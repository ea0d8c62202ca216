//! Fuzzes trainings of PhysTwin.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| bendtwin_fuzz::archives::pth(data));
