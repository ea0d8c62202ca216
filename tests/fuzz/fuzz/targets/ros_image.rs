//! Fuzzes images of ROS 2 in MCAP files.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| bendtwin_fuzz::recordings::ros_image(data));
