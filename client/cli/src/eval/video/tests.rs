use super::*;

#[test]
fn pairs_are_told_from_videos() {
    for name in ["camera0-training-00012.png", "camera12-axial-future-00085.png"] {
        assert!(is_pair(name), "{name}");
    }
    for name in ["camera0.png", "camera0-axial.png", "camera0-a-b.txt", "notes-a-b.png"] {
        assert!(!is_pair(name), "{name}");
    }
}
