//! Check and repair of a store in SQLite, for its administrator; backup and restore of a store of any kind;
//! and the move of rows to PostgreSQL and of content to a bucket. A check and a backup work beside running
//! servers; the others take the lock of the folder. Check and repair refuse a folder whose database or
//! content is elsewhere.

mod backup;
mod check;
mod folder_state;
mod integrity;
mod manifest;
mod mend;
mod migrate;
mod relocate;
mod repair;
mod rest;
mod restore;
mod rows;
mod site;
mod source;
mod survey;

pub use backup::{Backup, backup};
pub use check::{CheckReport, Unreferenced, check};
pub use folder_state::{FolderState, folder_state};
pub use manifest::Manifest;
pub use migrate::{Migration, migrate};
pub use relocate::{Relocation, relocate};
pub use repair::{Repair, repair};
pub use restore::{Restore, restore};
pub use rows::CopiedTable;
pub use site::Site;
pub use survey::{Damage, Depth};

#[cfg(test)]
mod tests;
