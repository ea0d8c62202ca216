//! Numbers for the judge of what lifting needs.

/// Objects that are lost.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct StartThresholds {
    /// Least tracks of the object in a frame; with fewer, it is lost. As many as lifting asks for.
    pub(crate) min_tracks: usize,
}

impl Default for StartThresholds {
    fn default() -> Self {
        Self { min_tracks: 3 }
    }
}
