//! Check, repair and backup of a store, for its administrator. A check and a backup only read, so
//! they work beside a running server; a repair takes the lock of the folder.

mod backup;
mod check;
mod folder_state;
mod integrity;
mod mend;
mod repair;
mod survey;

pub use backup::{Backup, backup};
pub use check::{CheckReport, Unreferenced, check};
pub use folder_state::{FolderState, folder_state};
pub use repair::{Repair, repair};
pub use survey::{Damage, Depth};

#[cfg(test)]
mod tests;
