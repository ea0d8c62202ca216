//! A store that is being backed up while servers use it.
//!
//! What is still to be copied is announced as an arrival ([`crate::blobs`]): nothing announced is
//! deleted. The announcement and the snapshot of the rows are made while no transaction can write, so
//! that all content of the snapshot is there until it is copied. Arrivals of a backup that was killed end
//! by themselves after a day.

use std::collections::BTreeMap;

use uuid::Uuid;

use super::{
    rows::{Connection, Table, require_current, tables},
    site::Site,
};
use crate::{
    Error, Result,
    blobs::{
        Place,
        arrivals::KEPT,
        references::{self, Reference},
    },
    database::{self, postgres},
    sql::{Builder, query, query_scalar},
    store::clock::{Clock as _, SystemClock, micros},
};

/// Digests announced in one statement.
const BATCH: usize = 1000;
/// The time of PostgreSQL [us].
const TIME: &str = "select (extract(epoch from clock_timestamp()) * 1000000)::bigint";

/// An open store.
#[derive(Debug)]
pub(super) struct Source {
    /// Announces what is to be copied.
    writer: Connection,
    /// Has the snapshot.
    pub(super) reader: Connection,
    pub(super) place: Place,
    pub(super) tables: Vec<Table>,
    pub(super) identity: String,
    /// Name of the database in messages.
    pub(super) name: String,
    /// Name of its arrivals.
    arrivals: String,
}

impl Source {
    /// Opens a store beside its servers.
    pub(super) async fn open(site: &Site) -> Result<Self> {
        let place = site.place()?;
        let (mut writer, reader) = (connect(site).await?, connect(site).await?);
        let name = site.database_name();
        if !is_there(&mut writer).await? {
            return Err(Error::NotFound { name });
        }
        require_current(&mut writer).await?;
        let mine = writer.identity().await?;
        let (Some(identity), true) = (mine.clone(), mine == place.identity().await?) else {
            return Err(Error::StoreMismatch { database: name, blobs: place.name() });
        };
        let (tables, arrivals) = (tables().await?, Uuid::new_v4().to_string());
        Ok(Self { writer, reader, place, tables, identity, name, arrivals })
    }

    /// What rows refer to at this moment.
    pub(super) async fn references(&mut self) -> Result<Vec<Reference>> {
        query(references::ALL).fetch_all(self.reader.target()).await
    }

    /// Keeps content from being deleted for a day, or until the backup ends.
    pub(super) async fn keep(&mut self, digests: &[&str]) -> Result<()> {
        for some in digests.chunks(BATCH) {
            self.writer.begin_writing().await?;
            self.announce(some).await?;
            self.writer.commit().await?;
        }
        Ok(())
    }

    /// Begins to read a snapshot of the rows, whose content stays: that which is not `there` is announced.
    pub(super) async fn snapshot(
        &mut self,
        there: &BTreeMap<String, u64>,
    ) -> Result<Vec<Reference>> {
        self.writer.begin_writing().await?;
        let all: Vec<Reference> = query(references::ALL).fetch_all(self.writer.target()).await?;
        let missing: Vec<&str> = missing(&all, there).collect();
        for some in missing.chunks(BATCH) {
            self.announce(some).await?;
        }
        self.reader.begin_reading().await?;
        self.writer.commit().await?;
        Ok(all)
    }

    async fn announce(&mut self, digests: &[&str]) -> Result<()> {
        let now = match &mut self.writer {
            Connection::Sqlite(_) => micros(SystemClock.now()),
            Connection::Postgres(connection) => {
                query_scalar(TIME).fetch_one(&mut *connection).await?
            }
        };
        let until = now + i64::try_from(KEPT.as_micros()).unwrap_or(i64::MAX / 2);
        let mut sql = Builder::new("insert into arrivals (id, digest, until_at) values ");
        for (nth, digest) in digests.iter().enumerate() {
            sql.push(if nth == 0 { "(" } else { ", (" }).push_bind(&self.arrivals).push(", ");
            sql.push_bind(*digest).push(", ").push_bind(until).push(")");
        }
        sql.push(" on conflict do nothing");
        sql.build().execute(self.writer.target()).await.map(drop)
    }

    /// Takes the announcements back.
    pub(super) async fn close(mut self) -> Result<()> {
        self.writer.begin_writing().await?;
        query("delete from arrivals where id = $1")
            .bind(&self.arrivals)
            .execute(self.writer.target())
            .await?;
        self.writer.commit().await?;
        self.writer.close().await?;
        self.reader.close().await
    }
}

/// Digests of references that are not there, each once.
pub(super) fn missing<'r>(
    references: &'r [Reference],
    there: &BTreeMap<String, u64>,
) -> impl Iterator<Item = &'r str> {
    let mut digests: Vec<&str> = references
        .iter()
        .map(|reference| reference.digest.as_str())
        .filter(|digest| !there.contains_key(*digest))
        .collect();
    digests.sort_unstable();
    digests.dedup();
    digests.into_iter()
}

async fn connect(site: &Site) -> Result<Connection> {
    match &site.database {
        None => Connection::sqlite(&site.data_dir.join(database::FILE)).await,
        Some(url) => {
            let options = url.options()?.application_name("bendtwin backup");
            Ok(Connection::Postgres(postgres::connect(&options).await?))
        }
    }
}

/// True if a database has the tables of a store.
async fn is_there(connection: &mut Connection) -> Result<bool> {
    let there = match connection {
        Connection::Sqlite(_) => {
            "select exists (select 1 from sqlite_master where type = 'table' and name = 'store')"
        }
        Connection::Postgres(_) => "select to_regclass('store')::text is not null",
    };
    query_scalar(there).fetch_one(connection.target()).await
}
