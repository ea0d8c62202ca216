//! Structs read from rows, each field from the column of its name.
//!
//! A declarative macro and not sqlx's derive: the derive's crate contains the whole of sqlx and of
//! SQLite a second time, compiled for the build machine, a fifth of a build from nothing.

use uuid::Uuid;

use crate::{Error, Result};

/// Struct that implements [`sqlx::FromRow`] for rows of SQLite and of PostgreSQL.
macro_rules! row {
    ($(#[$attribute:meta])* $visible:vis struct $name:ident {
        $($field_visible:vis $field:ident: $type:ty),* $(,)?
    }) => {
        $(#[$attribute])*
        $visible struct $name {
            $($field_visible $field: $type),*
        }

        impl sqlx::FromRow<'_, sqlx::sqlite::SqliteRow> for $name {
            fn from_row(row: &sqlx::sqlite::SqliteRow) -> sqlx::Result<Self> {
                Ok(Self { $($field: sqlx::Row::try_get(row, stringify!($field))?),* })
            }
        }

        impl sqlx::FromRow<'_, sqlx::postgres::PgRow> for $name {
            fn from_row(row: &sqlx::postgres::PgRow) -> sqlx::Result<Self> {
                Ok(Self { $($field: sqlx::Row::try_get(row, stringify!($field))?),* })
            }
        }
    };
}

pub(crate) use row;

/// The id of a row of a table.
pub(crate) fn id(table: &str, id: &str) -> Result<Uuid> {
    Uuid::try_parse(id)
        .map_err(|_| Error::CorruptRow { name: format!("{table}/{id}"), fault: "id".to_owned() })
}
