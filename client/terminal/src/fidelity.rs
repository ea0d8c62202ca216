//! The model that answers rollouts, as an argument.

use bendtwin_client::Fidelity;

/// Choice of the model that answers.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub enum Mode {
    /// The twin as fitted.
    Exact,
    /// The fast variant of the twin.
    Fast,
    /// The planner's twin of the twin.
    Planner,
}

impl From<Mode> for Fidelity {
    fn from(mode: Mode) -> Self {
        match mode {
            Mode::Exact => Self::Exact,
            Mode::Fast => Self::Fast,
            Mode::Planner => Self::Planner,
        }
    }
}
