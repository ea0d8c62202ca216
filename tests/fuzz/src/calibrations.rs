//! Calibrations: of BendTwin, of other programs, and models of COLMAP.

use bendtwin_calibrate::{colmap, files};
use bendtwin_capture::raw::Calibration;

use crate::limits;

/// `calibration.json`, and files of Kalibr, OpenCV and ROS.
pub fn calibration(data: &[u8]) {
    if let Ok(read) = Calibration::read(data, &limits()) {
        assert!(!read.cameras.is_empty() && read.cameras.len() <= limits().cameras);
        let again = Calibration::read(read.to_json().as_bytes(), &limits());
        let again = again.expect("what was written is read");
        assert_eq!(again.cameras.len(), read.cameras.len());
    }
    if let Ok(read) = files::parse("file.yaml", data) {
        assert!(!read.cameras.is_empty() && read.cameras.len() <= data.len());
    }
}

/// Each of the three files of a model, binary and as text.
pub fn colmap(data: &[u8]) {
    for is_binary in [true, false] {
        let none: &[u8] = if is_binary { &[0; 8] } else { b"" };
        for files in [[data, none, none], [none, data, none], [none, none, data]] {
            let Ok(model) = colmap::parse(files[0], files[1], files[2], is_binary) else {
                continue;
            };
            let entries = model.cameras.len() + model.images.len() + model.points.len();
            assert!(entries <= data.len());
            let seen: usize = model.images.iter().map(|image| image.points.len()).sum();
            assert!(seen <= data.len());
        }
    }
}
