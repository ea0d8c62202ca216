//! Schema of the database as a list of migrations, applied in order when a store is opened.
//!
//! SQLite and PostgreSQL have the same ones, in one folder. A migration that was applied anywhere
//! never changes: databases remember a checksum of its text.
//!
//! Older programs keep working with a database that newer ones have migrated, as long as these have
//! only added to it (docs/adr/0034). A migration that does more has a name that begins with
//! [`BREAKING`], which the database keeps: programs that do not know it refuse that database.

mod compatibility;

use sqlx::{
    AssertSqlSafe, SqlSafeStr as _, SqlStr,
    migrate::{Migration, MigrationType, Migrator},
};

pub(crate) use compatibility::{newer, require_alone};

/// First word of the name of a migration after which older programs cannot use the database.
pub(crate) const BREAKING: &str = "breaking_";

/// Version, description and SQL of every migration.
const MIGRATIONS: [(i64, &str, &str); 25] = [
    (1, "initial", include_str!("../../migrations/0001_initial.sql")),
    (2, "ingest", include_str!("../../migrations/0002_ingest.sql")),
    (3, "uploads", include_str!("../../migrations/0003_uploads.sql")),
    (4, "store", include_str!("../../migrations/0004_store.sql")),
    (5, "interrupted", include_str!("../../migrations/0005_interrupted.sql")),
    (6, "mass", include_str!("../../migrations/0006_mass.sql")),
    (7, "skin", include_str!("../../migrations/0007_skin.sql")),
    (8, "labels", include_str!("../../migrations/0008_labels.sql")),
    (9, "playback", include_str!("../../migrations/0009_playback.sql")),
    (10, "queue", include_str!("../../migrations/0010_queue.sql")),
    (11, "keys", include_str!("../../migrations/0011_keys.sql")),
    (12, "objects", include_str!("../../migrations/0012_objects.sql")),
    (13, "servers", include_str!("../../migrations/0013_servers.sql")),
    (14, "requirements", include_str!("../../migrations/0014_requirements.sql")),
    (15, "deleted_requests", include_str!("../../migrations/0015_deleted_requests.sql")),
    (16, "recorded_by", include_str!("../../migrations/0016_recorded_by.sql")),
    (17, "supplements", include_str!("../../migrations/0017_supplements.sql")),
    (18, "fairness", include_str!("../../migrations/0018_fairness.sql")),
    (19, "usage", include_str!("../../migrations/0019_usage.sql")),
    (20, "projects", include_str!("../../migrations/0020_projects.sql")),
    (21, "trash", include_str!("../../migrations/0021_trash.sql")),
    (22, "sign_in", include_str!("../../migrations/0022_sign_in.sql")),
    (23, "previews", include_str!("../../migrations/0023_previews.sql")),
    (24, "shares", include_str!("../../migrations/0024_shares.sql")),
    (25, "level", include_str!("../../migrations/0025_level.sql")),
];

/// The migrations of SQLite.
pub(crate) fn sqlite() -> Migrator {
    migrator(|sql| sql.into_sql_str())
}

/// The migrations of PostgreSQL: the same, with text that is compared byte by byte.
pub(crate) fn postgres() -> Migrator {
    migrator(|sql| AssertSqlSafe(with_byte_order(sql)).into_sql_str())
}

fn migrator(dialect: impl Fn(&'static str) -> SqlStr) -> Migrator {
    let all = MIGRATIONS.map(|(version, description, sql)| {
        let kind = MigrationType::Simple;
        Migration::new(version, description.into(), kind, dialect(sql), false)
    });
    let mut migrator = Migrator::with_migrations(all.into());
    // Those of newer versions: whether they matter is decided by their names.
    migrator.set_ignore_missing(true);
    migrator
}

/// Gives columns of the type `text` the order of their bytes, which SQLite's have: PostgreSQL's have
/// that of the language which the database was made with. Nothing else differs.
fn with_byte_order(sql: &str) -> String {
    let mut ordered = String::with_capacity(2 * sql.len());
    for line in sql.lines() {
        let (code, comment) = line.split_at(line.find("--").unwrap_or(line.len()));
        let mut rest = code;
        while let Some(at) = rest.find("text") {
            let (before, after) = (&rest[..at], &rest[at + "text".len()..]);
            let is_name = |letter: char| letter.is_alphanumeric() || letter == '_';
            let alone = !before.ends_with(is_name) && !after.starts_with(is_name);
            ordered += before;
            ordered += if alone { r#"text collate "C""# } else { "text" };
            rest = after;
        }
        ordered += rest;
        ordered += comment;
        ordered.push('\n');
    }
    ordered
}

/// The version of the last migration.
pub(crate) fn newest() -> i64 {
    MIGRATIONS.iter().map(|(version, ..)| *version).max().unwrap_or_default()
}

#[cfg(test)]
mod tests;
