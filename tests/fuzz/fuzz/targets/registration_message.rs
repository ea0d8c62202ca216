//! Fuzzes registrations as messages.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| bendtwin_fuzz::requests::registration_message(data));
