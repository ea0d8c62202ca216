//! `bendtwin.v1.SessionService`.

use std::sync::Arc;

use bendtwin_proto::{
    deadline::timeout,
    v1::{
        AdvanceSessionRequest, CloseSessionRequest, CloseSessionResponse, CorrectSessionRequest,
        CorrectedSession, ForkSessionRequest, GetSessionRequest, GetSessionStatesRequest,
        OpenSessionRequest, ResetSessionRequest, RollOutResponse, Session, SessionStates,
        session_service_server::SessionService,
    },
    worker::v1::manage_session_request::Call,
};
use futures::StreamExt as _;
use tonic::{Request, Response, Status, Streaming};

use super::{Api, Reply, counted::memory_of};
use crate::{
    app::{Error, Result},
    context::Context,
    error::Refusal,
};

#[tonic::async_trait]
impl SessionService for Api {
    async fn open_session(
        &self,
        request: Request<OpenSessionRequest>,
    ) -> Result<Response<Session>, Status> {
        let timeout = timeout(request.metadata());
        let reply = self.app.dispatch.open_session(request.into_inner(), timeout).await?;
        Ok(Response::new(session(reply.session)?))
    }

    async fn get_session(
        &self,
        request: Request<GetSessionRequest>,
    ) -> Result<Response<Session>, Status> {
        let timeout = timeout(request.metadata());
        let call = request.into_inner();
        let name = call.name.clone();
        let reply = self.app.dispatch.manage_session(&name, Call::Get(call), timeout).await?;
        Ok(Response::new(session(reply.session)?))
    }

    async fn get_session_states(
        &self,
        request: Request<GetSessionStatesRequest>,
    ) -> Result<Response<SessionStates>, Status> {
        let timeout = timeout(request.metadata());
        let call = request.into_inner();
        let name = call.name.clone();
        let reply = self.app.dispatch.manage_session(&name, Call::States(call), timeout).await?;
        Ok(Response::new(reply.states.unwrap_or_default()))
    }

    async fn advance_session(
        &self,
        request: Request<AdvanceSessionRequest>,
    ) -> Result<Response<RollOutResponse>, Status> {
        let timeout = timeout(request.metadata());
        let memory = memory_of(&request);
        let advance = request.into_inner();
        let advanced = self.app.dispatch.advance_session(advance, timeout, memory).await?;
        let mut response = Response::new(advanced.response);
        response.extensions_mut().insert(advanced.held.memory());
        Ok(response)
    }

    type ControlSessionStream = Reply<RollOutResponse>;

    async fn control_session(
        &self,
        request: Request<Streaming<AdvanceSessionRequest>>,
    ) -> Result<Response<Self::ControlSessionStream>, Status> {
        let dispatch = self.app.dispatch.clone();
        let stopping = self.app.stopping.clone();
        let context = Context::current();
        let messages = request.into_inner().take_until(stopping.cancelled_owned());
        // One after another: each waits until the one before has been answered.
        let replies = messages.then(move |message| {
            let (dispatch, context) = (dispatch.clone(), context.clone());
            let of = context.clone();
            of.scope(async move {
                let advanced = dispatch.advance_session(message?, None, Arc::default()).await;
                let advanced = advanced.map_err(|e| Refusal::from(e).into_status(&context))?;
                Ok(advanced.response)
            })
        });
        Ok(Response::new(until_error(replies).boxed()))
    }

    async fn fork_session(
        &self,
        request: Request<ForkSessionRequest>,
    ) -> Result<Response<Session>, Status> {
        let timeout = timeout(request.metadata());
        let call = request.into_inner();
        let name = call.name.clone();
        let reply = self.app.dispatch.manage_session(&name, Call::Fork(call), timeout).await?;
        Ok(Response::new(session(reply.session)?))
    }

    async fn reset_session(
        &self,
        request: Request<ResetSessionRequest>,
    ) -> Result<Response<Session>, Status> {
        let timeout = timeout(request.metadata());
        let call = request.into_inner();
        let name = call.name.clone();
        let reply = self.app.dispatch.manage_session(&name, Call::Reset(call), timeout).await?;
        Ok(Response::new(session(reply.session)?))
    }

    async fn correct_session(
        &self,
        request: Request<CorrectSessionRequest>,
    ) -> Result<Response<CorrectedSession>, Status> {
        let timeout = timeout(request.metadata());
        let corrected = self.app.dispatch.correct_session(request.into_inner(), timeout).await?;
        Ok(Response::new(corrected))
    }

    async fn close_session(
        &self,
        request: Request<CloseSessionRequest>,
    ) -> Result<Response<CloseSessionResponse>, Status> {
        let timeout = timeout(request.metadata());
        let call = request.into_inner();
        let name = call.name.clone();
        self.app.dispatch.manage_session(&name, Call::Close(call), timeout).await?;
        Ok(Response::new(CloseSessionResponse {}))
    }
}

fn session(session: Option<Session>) -> Result<Session> {
    session.ok_or_else(|| Error::Internal("a worker's reply has no session".to_owned()))
}

/// A stream that ends after its first error.
fn until_error<T: Send>(
    items: impl futures::Stream<Item = Result<T, Status>> + Send,
) -> impl futures::Stream<Item = Result<T, Status>> + Send {
    items.scan(false, |has_failed, item| {
        let ends = std::mem::replace(has_failed, item.is_err());
        std::future::ready((!ends).then_some(item))
    })
}
