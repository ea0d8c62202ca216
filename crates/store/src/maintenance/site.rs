//! The whereabouts of a store: its data folder, and its database and its content where they are not in
//! that.

use std::path::{Path, PathBuf};

use crate::{
    CLIENT_TOKEN, DatabaseUrl, Error, ObjectsUrl, Result,
    blobs::{Place, own},
    database,
    store::meter::{Meter, Part},
};

/// Whereabouts of a store, as a server has them.
#[derive(Clone, Debug)]
pub struct Site {
    /// The data folder. With a database and a place of content elsewhere, nothing in it is needed but
    /// the client token.
    pub data_dir: PathBuf,
    /// The database, if it is PostgreSQL.
    pub database: Option<DatabaseUrl>,
    /// The place of content, if it is not the data folder.
    pub objects: Option<ObjectsUrl>,
    /// The file of the client token, if it is not in the data folder.
    pub client_token: Option<PathBuf>,
}

impl Site {
    /// A store whose rows and content are in its data folder.
    pub fn new(data_dir: impl Into<PathBuf>) -> Self {
        Self { data_dir: data_dir.into(), database: None, objects: None, client_token: None }
    }

    /// The file of the client token.
    pub(super) fn client_token(&self) -> PathBuf {
        self.client_token.clone().unwrap_or_else(|| self.data_dir.join(CLIENT_TOKEN))
    }

    /// Name of the database in messages, without a password.
    pub(super) fn database_name(&self) -> String {
        match &self.database {
            Some(url) => url.to_string(),
            None => self.data_dir.join(database::FILE).display().to_string(),
        }
    }

    /// The place of content of a store that exists.
    ///
    /// # Errors
    /// [`Error::NotFound`], [`Error::DatabaseElsewhere`], [`Error::ObjectsElsewhere`], and if the folder
    /// is a backup or an unfinished restore.
    pub(super) fn place(&self) -> Result<Place> {
        database::require_settled(&self.data_dir)?;
        if self.database.is_none() {
            database::require_none(&self.data_dir)?;
            require(&self.data_dir.join(database::FILE))?;
        }
        database::require_objects(&self.data_dir, self.objects.as_ref())?;
        if self.objects.is_none() {
            require(&own(&self.data_dir))?;
        }
        self.new_place()
    }

    /// The place of content, which need not exist.
    ///
    /// # Errors
    /// Errors of the bucket and of files.
    pub(super) fn new_place(&self) -> Result<Place> {
        let (objects, is_shared) = (self.objects.as_ref(), self.database.is_some());
        Place::open(objects, &self.data_dir, is_shared, Meter::idle(Part::Content))
    }
}

fn require(path: &Path) -> Result<()> {
    match path.try_exists()? {
        true => Ok(()),
        false => Err(Error::NotFound { name: path.display().to_string() }),
    }
}
