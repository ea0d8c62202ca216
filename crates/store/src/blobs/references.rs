//! All places in which rows refer to blobs, in one list: what no place of it names is garbage.

use crate::{
    Result,
    sql::{Target, query_scalar, row::row},
};

row! {
    /// A row that refers to a blob: its resource name, the part of the resource that the blob is,
    /// its digest, and its size [bytes] if the row has that.
    #[derive(Clone, Debug)]
    pub(crate) struct Reference {
        pub(crate) name: String,
        pub(crate) part: String,
        pub(crate) digest: String,
        pub(crate) size_bytes: Option<i64>,
    }
}

/// All references.
pub(crate) const ALL: &str = "
    select 'captures/' || id as name, 'archive' as part, digest, size_bytes from captures
    union all select 'captures/' || capture, 'observation', digest, size_bytes from observations
    union all select 'captures/' || capture, 'playback', digest, size_bytes from playbacks
    union all select 'captures/' || capture, 'masks', digest, size_bytes from masks
    union all select 'captures/' || capture, kind || ' supplement', digest, size_bytes
        from supplements
    union all select 'captures/' || capture, 'report', json_digest, null from reports
    union all select 'captures/' || capture, 'report page', html_digest, null from reports
    union all select kind || 's/' || id, 'checkpoint', checkpoint, null
        from jobs where checkpoint is not null
    union all select 'twins/' || id, 'twin', digest, size_bytes from twins
    union all select 'uploads/' || id, 'upload', digest, null
        from uploads where digest is not null";

/// True if a row refers to a blob.
pub(crate) async fn exist<'t>(target: impl Into<Target<'t>>, digest: &str) -> Result<bool> {
    let found = query_scalar(
        "select exists (select 1 from captures where digest = $1)
             or exists (select 1 from twins where digest = $1)
             or exists (select 1 from jobs where checkpoint = $1)
             or exists (select 1 from observations where digest = $1)
             or exists (select 1 from playbacks where digest = $1)
             or exists (select 1 from masks where digest = $1)
             or exists (select 1 from supplements where digest = $1)
             or exists (select 1 from reports where json_digest = $1 or html_digest = $1)
             or exists (select 1 from uploads where digest = $1)",
    );
    found.bind(digest).fetch_one(target).await
}
