//! Members of a fleet, each a row: servers that have the database open, and registered workers.

pub(crate) mod servers;
pub(crate) mod workers;
