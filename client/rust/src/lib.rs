//! The typed client of a BendTwin server.
