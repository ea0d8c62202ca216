//! Start of a search, by the kind of object in its capture.

use bendtwin_core::capture::Subject;

/// Start for one kind of object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Defaults {
    /// Initial bending stiffness and damping, relative to those that resist like the springs. A
    /// cable is held by its bending, other bodies by their springs.
    pub(crate) bend_share: f64,
    /// Initial dashpot coefficient of springs [N s/m].
    pub(crate) dashpot: f64,
}

impl Defaults {
    /// The start for a kind of object.
    pub(crate) fn of(subject: Subject) -> Self {
        match subject {
            Subject::Cable => Self { bend_share: 1.0, dashpot: 20.0 },
            Subject::Body => Self { bend_share: 0.01, dashpot: 100.0 },
        }
    }
}
