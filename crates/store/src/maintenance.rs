//! Check, repair and backup of a store in SQLite, for its administrator, and its move to PostgreSQL and of
//! its content to a bucket. A check and a backup only read, so they work beside a running server; the
//! others take the lock of the folder. The first three refuse a folder whose database or content is
//! elsewhere.

mod backup;
mod check;
mod folder_state;
mod integrity;
mod mend;
mod migrate;
mod relocate;
mod repair;
mod survey;

pub use backup::{Backup, backup};
pub use check::{CheckReport, Unreferenced, check};
pub use folder_state::{FolderState, folder_state};
pub use migrate::{Migration, MovedTable, migrate};
pub use relocate::{Relocation, relocate};
pub use repair::{Repair, repair};
pub use survey::{Damage, Depth};

#[cfg(test)]
mod tests;
