//! Defaults of a fit that depend on the kind of object in its capture alone.

use bendtwin_core::{capture::Subject, settings::SequenceMean};

/// Defaults for one kind of object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Defaults {
    /// Mean of the losses of several sequences.
    pub(crate) sequence_mean: SequenceMean,
    /// True if the strength of gravity is searched. It pays in motion capture, where nothing else
    /// corrects a frame rate that is not quite true.
    pub(crate) searches_gravity: bool,
    /// Initial bending stiffness and damping, relative to those that resist like the springs. A
    /// cable is held by its bending, other bodies by their springs.
    pub(crate) bend_share: f64,
    /// Initial dashpot coefficient of springs [N s/m].
    pub(crate) dashpot: f64,
    /// Pull of the search to where it starts; see [`crate::space::Space::penalty`].
    pub(crate) search_prior: f64,
}

impl Defaults {
    /// The defaults for a kind of object.
    pub(crate) fn of(subject: Subject) -> Self {
        match subject {
            Subject::Cable => Self {
                sequence_mean: SequenceMean::Geometric,
                searches_gravity: true,
                bend_share: 1.0,
                dashpot: 20.0,
                search_prior: 0.0,
            },
            Subject::Body => Self {
                sequence_mean: SequenceMean::Arithmetic,
                searches_gravity: false,
                bend_share: 0.01,
                dashpot: 100.0,
                search_prior: 0.4,
            },
        }
    }
}
