//! The objects of the demos: what is recorded of them, and the settings of their fits.

use bendtwin_core::{Capture, FitSettings, Sequence};
use bendtwin_synth::Scene;

/// Nodes of the rope's twin: planners need coarse graphs, and people who wait a fast fit.
const ROPE_NODES: usize = 60;

/// An object of a demo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Object {
    /// A foam rope that a hand waves, for what moves and looks well. Its many crossing springs
    /// resist bending by themselves.
    Rope,
    /// A cable between two grippers, for what bending is worth.
    Cable,
}

impl Object {
    pub(super) fn name(self) -> &'static str {
        self.scene().name()
    }

    pub(super) fn scene(self) -> Scene {
        match self {
            Self::Rope => Scene::Rope,
            Self::Cable => Scene::Cable,
        }
    }

    /// Settings of a fit.
    pub(super) fn settings(self, seed: u64) -> FitSettings {
        let mut settings = FitSettings { seed, ..FitSettings::default() };
        match self {
            Self::Rope => settings.graph.max_nodes = Some(ROPE_NODES),
            // One of the three starts that a cable has by default, for people who wait; and gravity is
            // known of a cable that was made.
            Self::Cable => {
                settings.search.starts = Some(1);
                settings.search.gravity = Some(false);
            }
        }
        settings
    }

    /// The settings as flags of the command line.
    pub(super) fn flags(self) -> String {
        match self {
            Self::Rope => format!("--set graph.max_nodes={ROPE_NODES}"),
            Self::Cable => "--set search.starts=1 --set search.gravity=false".to_owned(),
        }
    }

    /// Description of the recording.
    pub(super) fn recording(self) -> &'static str {
        match self {
            Self::Rope => {
                "Record a rope that a robot hand moves (simulated far more finely than the twin will be,\n   \
                 with noise and occlusion)"
            }
            Self::Cable => {
                "Record a cable that two grippers move, by motion capture (simulated six times as finely\n   \
                 as the twin will be, with noise)"
            }
        }
    }

    /// Description of the fit.
    pub(super) fn fitting(self) -> String {
        match self {
            Self::Rope => format!(
                "Fit a coarse twin, fast enough to plan with: {ROPE_NODES} nodes. Search its global numbers, then\n   \
                 refine every spring and bending triplet"
            ),
            Self::Cable => "Fit a twin to it: a node for each marker, springs between neighbours, and bending and\n   \
                            twist along the cable. Search its global numbers, then refine each of them"
                .to_owned(),
        }
    }

    /// The place that a planner moves.
    pub(super) fn target(self) -> &'static str {
        match self {
            Self::Rope => "end of the rope",
            Self::Cable => "middle of the cable",
        }
    }

    /// Parts of a recording that its fit sees and does not see, in words.
    pub(super) fn split(capture: &Capture) -> String {
        let points = capture.object.point_count;
        let (frames, train) =
            capture.sequences.first().map_or((0, 0), |s| (s.frame_count, s.train_frame_count));
        match capture.sequences.iter().filter(|s| Sequence::is_held_out(s)).count() {
            0 => format!(
                "{points} points over {frames} frames; the fit sees the first {train}, the others are its exam"
            ),
            exam => format!(
                "{points} markers in {} motions of {frames} frames; the fit sees {}, the other {exam} are its exam",
                capture.sequences.len(),
                capture.sequences.len() - exam
            ),
        }
    }
}
