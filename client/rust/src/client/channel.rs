//! The gRPC channel with the token of the server.

use tonic::{
    Request, Status,
    metadata::AsciiMetadataValue,
    service::{Interceptor, interceptor::InterceptedService},
    transport,
};

use crate::Error;

/// A connection that shows the token with every call.
pub(crate) type Channel = InterceptedService<transport::Channel, Credentials>;

/// Interceptor that adds the token to every call, if there is one.
#[derive(Clone, Debug)]
pub(crate) struct Credentials(Option<AsciiMetadataValue>);

impl Credentials {
    pub(crate) fn new(token: Option<&str>) -> Result<Self, Error> {
        let header = token.map(|token| {
            let mut header = AsciiMetadataValue::try_from(format!("Bearer {token}"))
                .map_err(|_| Error::invalid("the token has characters that no token has"))?;
            header.set_sensitive(true);
            Ok::<_, Error>(header)
        });
        Ok(Self(header.transpose()?))
    }
}

impl Interceptor for Credentials {
    fn call(&mut self, mut request: Request<()>) -> Result<Request<()>, Status> {
        if let Some(header) = &self.0 {
            request.metadata_mut().insert("authorization", header.clone());
        }
        Ok(request)
    }
}
