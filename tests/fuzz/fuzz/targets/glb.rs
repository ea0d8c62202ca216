//! Fuzzes GLB.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| bendtwin_fuzz::meshes::glb(data));
