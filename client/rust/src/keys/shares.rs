//! Shares: links by which people without a token look at a twin and play with it.

use std::time::Duration;

use bendtwin_core::ids::{ShareId, TwinId};
use bendtwin_proto::v1::{
    self, DeleteShareRequest, ListSharesRequest, ShareTwinRequest,
    share_service_client::ShareServiceClient,
};
use jiff::Timestamp;
use serde::Serialize;

use crate::{
    Error,
    client::Channel,
    page::{self, Page, PageRequest},
    resources::resource,
};

resource! { v1::Share =>
/// A share of a twin.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Share {
    /// Name of the share.
    pub name: ShareId,
    /// The twin.
    pub twin: TwinId,
    /// For whom it is.
    pub display_name: String,
    /// Owner of the key that made it.
    pub owner: String,
    /// True if its holder may download the twin.
    pub allow_export: bool,
    /// Time of creation.
    pub create_time: Timestamp,
    /// Time from which it is refused.
    pub expire_time: Timestamp,
    /// Time of its revocation.
    pub revoke_time: Option<Timestamp>,
    /// Time of its last use, to about a minute.
    pub last_use_time: Option<Timestamp>,
}
}

/// A share to be made.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct NewShare {
    /// For whom it is.
    pub display_name: String,
    /// Time until it expires, in whole seconds; none: 7 days. At most 90 days.
    pub ttl: Option<Duration>,
    /// True if its holder may download the twin.
    pub allow_export: bool,
}

/// A newly made share. [`MadeShare::link`] is returned only here.
#[derive(Clone, PartialEq, Eq, Serialize)]
pub struct MadeShare {
    /// The share.
    pub share: Share,
    /// The address that opens the twin, which contains the key.
    pub link: String,
}

/// Leaves the link out.
impl std::fmt::Debug for MadeShare {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("MadeShare").field("share", &self.share).finish_non_exhaustive()
    }
}

/// Calls about shares.
#[derive(Clone, Debug)]
pub struct Shares {
    service: ShareServiceClient<Channel>,
    url: String,
}

impl Shares {
    pub(crate) fn new(service: ShareServiceClient<Channel>, url: String) -> Self {
        Self { service, url }
    }

    /// Shares a twin.
    ///
    /// # Errors
    /// If it is refused, or the server cannot be asked. One that requires no token refuses with the
    /// reason `SHARE_NOT_NEEDED`: there [`Shares::plain_link`] opens the twin.
    pub async fn create(&self, twin: TwinId, new: NewShare) -> Result<MadeShare, Error> {
        let request = ShareTwinRequest {
            twin: twin.to_string(),
            display_name: new.display_name,
            ttl_s: new.ttl.map(|ttl| ttl.as_secs()).unwrap_or_default(),
            expire_time: None,
            allow_export: new.allow_export,
        };
        let reply = self.service.clone().share_twin(request).await?.into_inner();
        let share = reply.share.ok_or_else(|| Error::malformed("no share"))?;
        let link = format!("{}?key={}", self.plain_link(twin), reply.secret_key);
        Ok(MadeShare { share: share.try_into()?, link })
    }

    /// The address of a twin's page for visitors, without a key.
    pub fn plain_link(&self, twin: TwinId) -> String {
        format!("{}/#/shared/{}", self.url, twin.uuid())
    }

    /// A page of the shares of a twin, newest first; revoked and expired ones are among them.
    ///
    /// # Errors
    /// If the server cannot be asked.
    pub async fn list(&self, twin: TwinId, page: PageRequest) -> Result<Page<Share>, Error> {
        let request = ListSharesRequest {
            twin: twin.to_string(),
            page_size: page.size,
            page_token: page.token,
        };
        let reply = self.service.clone().list_shares(request).await?.into_inner();
        Page::new(reply.shares, reply.next_page_token, Share::try_from)
    }

    /// All shares of a twin.
    ///
    /// # Errors
    /// If the server cannot be asked.
    pub async fn all(&self, twin: TwinId) -> Result<Vec<Share>, Error> {
        page::all(|page| self.list(twin, page)).await
    }

    /// Revokes a share: no server accepts it 30 s later.
    ///
    /// # Errors
    /// If the share does not exist, or the server cannot be asked.
    pub async fn revoke(&self, name: ShareId) -> Result<(), Error> {
        self.service.clone().delete_share(DeleteShareRequest { name: name.to_string() }).await?;
        Ok(())
    }
}
