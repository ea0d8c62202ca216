//! Defaults of a fit that depend on the kind of object in its capture.

use bendtwin_core::{capture::Subject, settings::SequenceMean};

/// Defaults for one kind of object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Defaults {
    /// Number of searches with different seeds. A cable's are cheap, and its training loss shows
    /// which of them predicts best.
    pub(crate) starts: u32,
    /// Generations of a search. A cable's are cheap, and their optimum is narrow: with 25 the fits
    /// of several seeds differ by a tenth.
    pub(crate) generations: u32,
    /// Mean of the losses of several sequences.
    pub(crate) sequence_mean: SequenceMean,
    /// True if the strength of gravity is searched. It pays in motion capture, where nothing else
    /// corrects a frame rate that is not quite true.
    pub(crate) searches_gravity: bool,
    /// Initial bending stiffness and damping, relative to those that resist like the springs. A
    /// cable is held by its bending, other bodies by their springs.
    pub(crate) bend_share: f64,
}

impl Defaults {
    /// The defaults for a kind of object.
    pub(crate) fn of(subject: Subject) -> Self {
        match subject {
            Subject::Cable => Self {
                starts: 3,
                generations: 60,
                sequence_mean: SequenceMean::Geometric,
                searches_gravity: true,
                bend_share: 1.0,
            },
            Subject::Body => Self {
                starts: 1,
                generations: 25,
                sequence_mean: SequenceMean::Arithmetic,
                searches_gravity: false,
                bend_share: 0.01,
            },
        }
    }
}
