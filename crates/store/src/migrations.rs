//! Schema of the database as a list of migrations, applied in order when a store is opened.
//!
//! A migration that was applied anywhere never changes: databases remember a checksum of its text.

use sqlx::{
    SqlSafeStr as _,
    migrate::{Migration, MigrationType, Migrator},
};

/// Version, description and SQL of every migration.
const MIGRATIONS: [(i64, &str, &str); 10] = [
    (1, "initial", include_str!("../migrations/0001_initial.sql")),
    (2, "ingest", include_str!("../migrations/0002_ingest.sql")),
    (3, "uploads", include_str!("../migrations/0003_uploads.sql")),
    (4, "store", include_str!("../migrations/0004_store.sql")),
    (5, "interrupted", include_str!("../migrations/0005_interrupted.sql")),
    (6, "mass", include_str!("../migrations/0006_mass.sql")),
    (7, "skin", include_str!("../migrations/0007_skin.sql")),
    (8, "labels", include_str!("../migrations/0008_labels.sql")),
    (9, "playback", include_str!("../migrations/0009_playback.sql")),
    (10, "keys", include_str!("../migrations/0010_keys.sql")),
];

pub(crate) fn migrator() -> Migrator {
    let all = MIGRATIONS.map(|(version, description, sql)| {
        let kind = MigrationType::Simple;
        Migration::new(version, description.into(), kind, sql.into_sql_str(), false)
    });
    Migrator::with_migrations(all.into())
}

/// The version of the last migration.
pub(crate) fn newest() -> i64 {
    MIGRATIONS.iter().map(|(version, ..)| *version).max().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn every_file_is_listed_under_its_name() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/migrations");
        let files: BTreeSet<_> = std::fs::read_dir(folder)
            .unwrap()
            .map(|file| {
                let file = file.unwrap();
                (
                    file.file_name().into_string().unwrap(),
                    std::fs::read_to_string(file.path()).unwrap(),
                )
            })
            .collect();
        let listed: BTreeSet<_> = MIGRATIONS
            .map(|(version, name, sql)| (format!("{version:04}_{name}.sql"), sql.to_owned()))
            .into();
        assert_eq!(listed, files);
    }
}
