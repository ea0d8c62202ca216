//! What the parts look like: their colours as they were marked, and as they have become.

use crate::{
    colors::{Colors, Densities, bin},
    part::{BACKGROUND, HAND, PARTS, Shares},
};

/// Share of the colours of the first labelled frame; the rest are those of the frames before this one.
const ANCHOR: f32 = 0.6;
/// Share of the latest colours that the next frame keeps.
const KEPT: f32 = 0.9;
/// Logarithm of the density of a colour in what nobody marked, relative to all colours being equally
/// frequent.
const ANYTHING: f32 = -1.0;
/// Logarithm by which a hand is excluded that nobody marked.
const NEVER: f32 = -30.0;

/// Colours of the parts.
#[derive(Clone)]
pub(crate) struct Looks {
    /// Colours in the strokes and in the frame that they began.
    anchors: [Colors; PARTS],
    /// Colours in the latest frames.
    latest: [Colors; PARTS],
    densities: [Densities; PARTS],
    has_hand: bool,
}

impl Looks {
    /// Nothing is known yet.
    pub(crate) fn new(has_hand: bool) -> Self {
        let none = || std::array::from_fn(|_| Colors::default());
        let densities = std::array::from_fn(|_| Colors::default().densities());
        Self { anchors: none(), latest: none(), densities, has_hand }
    }

    /// Adds a marked colour of a part.
    pub(crate) fn mark(&mut self, part: usize, color: [u8; 3], weight: f32) {
        self.anchors[part].add(bin(color), weight);
    }

    /// Takes the present colours of the parts, in addition to a share of earlier ones.
    pub(crate) fn see(&mut self, seen: &[Colors; PARTS]) {
        for (latest, seen) in self.latest.iter_mut().zip(seen) {
            latest.scale(KEPT);
            latest.mix(seen, (1.0 - KEPT) * seen.total());
        }
        self.renew();
    }

    /// Takes the present colours of the parts, and forgets earlier ones.
    pub(crate) fn see_only(&mut self, seen: [Colors; PARTS]) {
        self.latest = seen;
        self.renew();
    }

    /// Makes what is seen now what later frames are compared with, beside what was marked.
    pub(crate) fn anchor(&mut self) {
        for (anchor, latest) in self.anchors.iter_mut().zip(&self.latest) {
            if !latest.is_empty() {
                let marked = std::mem::take(anchor);
                anchor.mix(&marked, 0.2);
                anchor.mix(latest, 0.8);
            }
        }
        self.renew();
    }

    /// Computes the densities.
    pub(crate) fn renew(&mut self) {
        for part in 0..PARTS {
            let mut both = Colors::default();
            both.mix(&self.anchors[part], ANCHOR);
            both.mix(&self.latest[part], 1.0 - ANCHOR);
            self.densities[part] = both.densities();
        }
    }

    /// Logarithms of the densities of a colour in the parts.
    pub(crate) fn logs(&self, bin: usize) -> Shares {
        let mut logs = std::array::from_fn(|part| self.densities[part].of(bin));
        logs[BACKGROUND] = f32::max(logs[BACKGROUND], ANYTHING);
        if !self.has_hand {
            logs[HAND] = NEVER;
        }
        logs
    }

    /// Share that two parts have in common by mean and spread of their colours alone, 0..=1.
    pub(crate) fn likeness(&self, a: usize, b: usize) -> f32 {
        self.anchors[a].likeness(&self.anchors[b])
    }
}
