//! Plans of launches: graphs cut for teams of blocks, models on the device, the team for a batch,
//! tapes.

pub(crate) mod choice;
pub(crate) mod graph;
pub(crate) mod layout;
pub(crate) mod layouts;
pub(crate) mod partition;
pub(crate) mod resident;
pub(crate) mod shared;
pub(crate) mod skin;
pub(crate) mod tape;
