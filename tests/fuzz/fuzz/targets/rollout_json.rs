//! Fuzzes rollout requests as JSON.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| bendtwin_fuzz::requests::rollout_json(data));
