//! Digest of a capture, 64 letters: equal content from any file gives the same digest.

use bendtwin_core::{Capture, Point};

/// BLAKE3 digest of the content, hex. The name does not count; sequence names do.
pub fn digest(capture: &Capture) -> String {
    let mut hash = Hash(blake3::Hasher::new());
    hash.bytes(b"bendtwin capture 1");
    hash.recording(capture);
    // Of a single recording the digest is what it always was.
    for other in &capture.others {
        hash.bytes(b"recording");
        hash.recording(other);
    }
    hash.0.finalize().to_hex().to_string()
}

/// Every field goes in behind its length, so that no two captures run together.
struct Hash(blake3::Hasher);

impl Hash {
    fn recording(&mut self, capture: &Capture) {
        let hash = self;
        hash.bytes(&capture.fps.to_le_bytes());
        let environment = &capture.environment;
        hash.points(&[environment.gravity]);
        let ground: Vec<Point> =
            environment.ground.iter().flat_map(|g| [g.normal, [g.offset_m, 0.0, 0.0]]).collect();
        hash.points(&ground);
        hash.points(&capture.source_to_world);
        let object = &capture.object;
        hash.count(object.point_count);
        for points in
            [&object.colors, &object.completed_surface, &object.interior, &object.rest_points]
        {
            hash.points(points);
        }
        hash.pairs(object.edges.iter().copied());
        hash.pairs(object.pins.iter().map(|p| [p.point, p.control]));
        hash.count(capture.sequences.len());
        for sequence in &capture.sequences {
            hash.bytes(sequence.name.as_bytes());
            for count in [sequence.frame_count, sequence.train_frame_count, sequence.start_frames] {
                hash.count(count);
            }
            for points in [&sequence.points, &sequence.controls, &sequence.truth_tracks] {
                hash.points(points);
            }
            for flags in [&sequence.visible, &sequence.motion_valid] {
                hash.bytes(&flags.iter().map(|f| u8::from(*f)).collect::<Vec<_>>());
            }
        }
    }

    fn count(&mut self, n: usize) {
        self.0.update(&(n as u64).to_le_bytes());
    }

    fn bytes(&mut self, bytes: &[u8]) {
        self.count(bytes.len());
        self.0.update(bytes);
    }

    fn points(&mut self, points: &[Point]) {
        self.count(points.len());
        for chunk in points.chunks(4096) {
            let bytes: Vec<u8> = chunk.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
            self.0.update(&bytes);
        }
    }

    fn pairs(&mut self, pairs: impl ExactSizeIterator<Item = [u32; 2]>) {
        self.count(pairs.len());
        for pair in pairs {
            for index in pair {
                self.0.update(&index.to_le_bytes());
            }
        }
    }
}
