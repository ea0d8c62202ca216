//! `bendtwin.v1.RegistrationService`.

use bendtwin_proto::{
    deadline::timeout,
    v1::{RegisterStateRequest, RegisteredState, registration_service_server::RegistrationService},
};
use tonic::{Request, Response, Status};

use super::{Api, counted::memory_of};
use crate::app::{Register, Registered};

#[tonic::async_trait]
impl RegistrationService for Api {
    async fn register_state(
        &self,
        request: Request<RegisterStateRequest>,
    ) -> Result<Response<RegisteredState>, Status> {
        let timeout = timeout(request.metadata());
        let memory = memory_of(&request);
        let request = request.into_inner();
        let register = Register { request, timeout, as_lists: false, memory };
        let Registered { state, held } = self.app.register_state(register).await?;
        let mut response = Response::new(state);
        response.extensions_mut().insert(held);
        Ok(response)
    }
}
