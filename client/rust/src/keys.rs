//! Keys with which clients identify themselves. All calls take a key with the scope `admin`, or the
//! client token.

pub(crate) mod projects;
pub(crate) mod shares;
pub(crate) mod sign_ins;

use bendtwin_core::ids::{KeyId, TwinId};
use bendtwin_proto::v1::{
    self, CreateKeyRequest, DeleteKeyRequest, GetKeyRequest, KeyQuotas, ListKeysRequest,
    key_service_client::KeyServiceClient,
};
use jiff::Timestamp;
use serde::Serialize;

use crate::{
    Error,
    client::Channel,
    page::{self, Page, PageRequest},
    resources::resource,
};

resource! { v1::Key =>
/// A key as the server knows it; the key itself is not among it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Key {
    /// Name of the key.
    pub name: KeyId,
    /// Display name.
    pub display_name: String,
    /// Recorded as owner of what is made with it.
    pub owner: String,
    /// Scopes, sorted.
    pub scopes: Vec<String>,
    /// Time of creation.
    pub create_time: Timestamp,
    /// Time from which it is refused, if there is one.
    pub expire_time: Option<Timestamp>,
    /// Time of its revocation.
    pub revoke_time: Option<Timestamp>,
    /// Time of its last use, to about a minute.
    pub last_use_time: Option<Timestamp>,
    /// Bounds on what its owner may have.
    pub quotas: KeyQuotas,
    /// True if a person got it by signing in.
    pub is_sign_in: bool,
    /// The twin that it is limited to, if it is a share.
    pub twin: Option<TwinId>,
}
}

/// A key to be made.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct NewKey {
    /// Display name.
    pub display_name: String,
    /// Owner; empty means the display name.
    pub owner: String,
    /// Scopes: `admin`, `captures:read`, `captures:write`, `fits:read`,
    /// `fits:write`, `metrics:read`, `rollouts:run`, `twins:read`, `twins:write`; those of
    /// captures, fits, rollouts and twins may end in `:own`.
    pub scopes: Vec<String>,
    /// Time from which it is refused; none: never.
    pub expire_time: Option<Timestamp>,
    /// Bounds on what its owner may have.
    pub quotas: KeyQuotas,
}

/// A newly made key. [`MadeKey::secret_key`] is returned only here.
#[derive(Clone, PartialEq, Serialize)]
pub struct MadeKey {
    /// The key as the server knows it.
    pub key: Key,
    /// The key itself.
    pub secret_key: String,
}

/// Leaves the key itself out.
impl std::fmt::Debug for MadeKey {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("MadeKey").field("key", &self.key).finish_non_exhaustive()
    }
}

/// Calls about keys.
#[derive(Clone, Debug)]
pub struct Keys {
    service: KeyServiceClient<Channel>,
}

impl Keys {
    pub(crate) fn new(service: KeyServiceClient<Channel>) -> Self {
        Self { service }
    }

    /// Makes a key.
    ///
    /// # Errors
    /// If it is refused, or the server cannot be asked.
    pub async fn create(&self, new: NewKey) -> Result<MadeKey, Error> {
        let request = CreateKeyRequest {
            display_name: new.display_name,
            owner: new.owner,
            scopes: new.scopes,
            expire_time: new.expire_time.map(to_the_second),
            quotas: Some(new.quotas),
        };
        let reply = self.service.clone().create_key(request).await?.into_inner();
        let key = reply.key.ok_or_else(|| Error::malformed("no key"))?;
        Ok(MadeKey { key: key.try_into()?, secret_key: reply.secret_key })
    }

    /// Returns a key.
    ///
    /// # Errors
    /// If the key does not exist, or the server cannot be asked.
    pub async fn get(&self, name: KeyId) -> Result<Key, Error> {
        let request = GetKeyRequest { name: name.to_string() };
        self.service.clone().get_key(request).await?.into_inner().try_into()
    }

    /// A page of the keys, newest first; revoked and expired ones are among them.
    ///
    /// # Errors
    /// If the server cannot be asked.
    pub async fn list(&self, page: PageRequest) -> Result<Page<Key>, Error> {
        let request = ListKeysRequest { page_size: page.size, page_token: page.token };
        let reply = self.service.clone().list_keys(request).await?.into_inner();
        Page::new(reply.keys, reply.next_page_token, Key::try_from)
    }

    /// All keys.
    ///
    /// # Errors
    /// If the server cannot be asked.
    pub async fn all(&self) -> Result<Vec<Key>, Error> {
        page::all(|page| self.list(page)).await
    }

    /// Revokes a key, with the shares that were made with it: no server accepts them 30 s later.
    ///
    /// # Errors
    /// If the key does not exist, or the server cannot be asked.
    pub async fn revoke(&self, name: KeyId) -> Result<(), Error> {
        self.service.clone().delete_key(DeleteKeyRequest { name: name.to_string() }).await?;
        Ok(())
    }
}

/// The form of a time in a request.
fn to_the_second(time: Timestamp) -> prost_types::Timestamp {
    prost_types::Timestamp { seconds: time.as_second(), nanos: 0 }
}
