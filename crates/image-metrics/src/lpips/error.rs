//! Files that are no network for LPIPS.

/// A file that is no network for LPIPS, or images that it cannot take.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The operating system failed.
    #[error("`{at}` cannot be read: {source}")]
    Io {
        /// The file.
        at: String,
        /// Error of the system.
        source: std::io::Error,
    },
    /// A file beyond all networks that are known.
    #[error("the network has more than {limit} bytes: export lpips.LPIPS(net=\"alex\")")]
    TooLarge {
        /// Largest number of bytes.
        limit: u64,
    },
    /// A damaged file, or one of another format.
    #[error("this is no ONNX model ({0}): export it again with torch.onnx.export")]
    Format(String),
    /// An operator that is not read.
    #[error(
        "the network uses the operator {operator}{detail}, which is not read: export lpips.LPIPS in float32 \
         with torch.onnx.export(…, dynamo=False, opset_version=13)"
    )]
    Operator {
        /// Name of the operator.
        operator: String,
        /// The attribute that is not read; empty if it is the operator itself.
        detail: String,
    },
    /// A model that contradicts itself or the images.
    #[error(
        "the network cannot be computed: {0}; export lpips.LPIPS again, for images of this size"
    )]
    Network(String),
}

impl Error {
    pub(super) fn operator(operator: &str, detail: impl Into<String>) -> Self {
        Self::Operator { operator: operator.to_owned(), detail: detail.into() }
    }
}
