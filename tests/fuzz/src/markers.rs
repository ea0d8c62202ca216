//! Markers of motion capture.

use bendtwin_capture::{read_bytes, validate};

/// A C3D, CSV or TRC file.
pub fn markers(data: &[u8]) {
    let limits = crate::limits();
    let Ok(capture) = read_bytes("fuzz", data, &limits) else { return };
    assert!(validate(&capture).is_ok());
    assert!(capture.object.point_count <= limits.points);
    for sequence in &capture.sequences {
        assert!(sequence.frame_count <= limits.frames);
        assert!(sequence.control_count() <= limits.controls);
        let seen = sequence.points.iter().zip(&sequence.visible).filter(|(_, seen)| **seen);
        seen.for_each(|(p, _)| assert!(p.iter().all(|x| !x.is_nan())));
    }
}
