//! `bendtwin.v1.SessionService`.

use std::sync::Arc;

use bendtwin_core::ids::SessionId;
use bendtwin_proto::{
    deadline::timeout,
    v1::{
        AdvanceSessionRequest, CloseSessionRequest, CloseSessionResponse, CorrectSessionRequest,
        CorrectedSession, ForkSessionRequest, GetSessionRequest, GetSessionStatesRequest,
        OpenSessionRequest, RenderSessionRequest, RenderedSession, ResetSessionRequest,
        RollOutResponse, Session, SessionStates, StepSessionRequest, SteppedSession,
        session_service_server::SessionService,
    },
    worker::v1::manage_session_request::Call,
};
use futures::StreamExt as _;
use tonic::{Request, Response, Status, Streaming};

use super::{Api, Reply, counted::memory_of};
use crate::{
    app::{self, ReplyHold, Step},
    context::Context,
    refusal::Refusal,
};

#[tonic::async_trait]
impl SessionService for Api {
    async fn open_session(
        &self,
        request: Request<OpenSessionRequest>,
    ) -> Result<Response<Session>, Status> {
        let timeout = timeout(request.metadata());
        // Held until the worker has the request.
        let _memory = memory_of(&request);
        let session = self.app.open_session(request.into_inner(), timeout).await?;
        Ok(Response::new(session))
    }

    async fn get_session(
        &self,
        request: Request<GetSessionRequest>,
    ) -> Result<Response<Session>, Status> {
        let timeout = timeout(request.metadata());
        let name = session_name(&request.get_ref().name)?;
        let call = Call::Get(GetSessionRequest { name: name.clone() });
        let session = self.app.session_call(&name, call, timeout).await?;
        Ok(Response::new(session))
    }

    async fn get_session_states(
        &self,
        request: Request<GetSessionStatesRequest>,
    ) -> Result<Response<SessionStates>, Status> {
        let timeout = timeout(request.metadata());
        let asked = request.into_inner();
        let (states, held) = self.app.session_states(asked, timeout, false).await?;
        let mut response = Response::new(states);
        response.extensions_mut().insert(held);
        Ok(response)
    }

    async fn advance_session(
        &self,
        request: Request<AdvanceSessionRequest>,
    ) -> Result<Response<RollOutResponse>, Status> {
        let timeout = timeout(request.metadata());
        let memory = memory_of(&request);
        let advance = request.into_inner();
        let advanced = self.app.advance_session(advance, timeout, false, memory).await?;
        let mut response = Response::new(advanced.response);
        response.extensions_mut().insert(advanced.held.memory());
        Ok(response)
    }

    type ControlSessionStream = Reply<RollOutResponse>;

    async fn control_session(
        &self,
        request: Request<Streaming<AdvanceSessionRequest>>,
    ) -> Result<Response<Self::ControlSessionStream>, Status> {
        let app = self.app.clone();
        let context = Context::current();
        let messages = request.into_inner().take_until(app.stopped());
        // One after another: each waits until the one before has been answered.
        let replies = messages.then(move |message| {
            let (app, context) = (app.clone(), context.clone());
            let of = context.clone();
            of.scope(async move {
                let advance = app.advance_session(message?, None, false, Arc::default());
                let refused = |e| Refusal::from(e).into_status(&context);
                let advanced = advance.await.map_err(refused)?;
                Ok((advanced.response, advanced.held.memory()))
            })
        });
        Ok(Response::new(one_by_one(replies).boxed()))
    }

    async fn fork_session(
        &self,
        request: Request<ForkSessionRequest>,
    ) -> Result<Response<Session>, Status> {
        let timeout = timeout(request.metadata());
        let call = request.into_inner();
        let name = call.name.clone();
        let session = self.app.session_call(&name, Call::Fork(call), timeout).await?;
        Ok(Response::new(session))
    }

    async fn reset_session(
        &self,
        request: Request<ResetSessionRequest>,
    ) -> Result<Response<Session>, Status> {
        let timeout = timeout(request.metadata());
        // Held until the worker has the request.
        let _memory = memory_of(&request);
        let call = request.into_inner();
        let name = call.name.clone();
        let session = self.app.session_call(&name, Call::Reset(call), timeout).await?;
        Ok(Response::new(session))
    }

    async fn correct_session(
        &self,
        request: Request<CorrectSessionRequest>,
    ) -> Result<Response<CorrectedSession>, Status> {
        let timeout = timeout(request.metadata());
        // Held until the worker has the request.
        let _memory = memory_of(&request);
        let correct = request.into_inner();
        let (corrected, held) = self.app.correct_session(correct, timeout, false).await?;
        let mut response = Response::new(corrected);
        response.extensions_mut().insert(held);
        Ok(response)
    }

    async fn render_session(
        &self,
        request: Request<RenderSessionRequest>,
    ) -> Result<Response<RenderedSession>, Status> {
        let timeout = timeout(request.metadata());
        // Held until the worker has the request.
        let _memory = memory_of(&request);
        let render = request.into_inner();
        let (rendered, held) = self.app.render_session(render, timeout, false).await?;
        let mut response = Response::new(rendered);
        response.extensions_mut().insert(held);
        Ok(response)
    }

    async fn step_session(
        &self,
        request: Request<StepSessionRequest>,
    ) -> Result<Response<SteppedSession>, Status> {
        let (timeout, memory) = (timeout(request.metadata()), memory_of(&request));
        let step = Step { request: request.into_inner(), timeout, as_lists: false, memory };
        let stepped = self.app.step_session(step).await?;
        let mut response = Response::new(stepped.response);
        response.extensions_mut().insert(stepped.held);
        Ok(response)
    }

    async fn close_session(
        &self,
        request: Request<CloseSessionRequest>,
    ) -> Result<Response<CloseSessionResponse>, Status> {
        let timeout = timeout(request.metadata());
        let close = CloseSessionRequest { name: session_name(&request.get_ref().name)? };
        self.app.close_session(close, timeout).await?;
        Ok(Response::new(CloseSessionResponse {}))
    }
}

/// The name of a session, of which HTTP gives the last part alone.
fn session_name(given: &str) -> app::Result<String> {
    app::whole_name::<SessionId>(given)
}

/// A stream that ends after its first error. The memory of a reply is held until the next one is
/// there.
fn one_by_one<T: Send>(
    replies: impl futures::Stream<Item = Result<(T, ReplyHold), Status>> + Send,
) -> impl futures::Stream<Item = Result<T, Status>> + Send {
    let begin = (false, None);
    replies.scan(begin, |(has_failed, last), reply| {
        let ends = std::mem::replace(has_failed, reply.is_err());
        let reply = reply.map(|(reply, held)| {
            *last = Some(held);
            reply
        });
        std::future::ready((!ends).then_some(reply))
    })
}
