//! Fuzzes rollout requests as messages.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| bendtwin_fuzz::requests::rollout_message(data));
