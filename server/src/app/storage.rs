//! Space of the disk, and what is deleted: by people, by rules, and for good.

mod disk;
mod retention;
mod trash;
