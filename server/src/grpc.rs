//! The gRPC form of the API: every method turns its request into a call of the
//! application and the outcome into a message. No decisions are made here.

mod captures;
pub(crate) mod convert;
mod counted;
mod evaluations;
mod fits;
mod health;
mod keys;
mod link;
mod plans;
mod projects;
mod registrations;
mod rollouts;
mod screened;
mod sessions;
mod token;
mod trash;
mod twins;
mod upload;
mod usage;
mod workers;

use std::collections::HashSet;

use bendtwin_proto::{
    DESCRIPTORS,
    v1::{
        capture_service_server::CaptureServiceServer,
        evaluation_service_server::EvaluationServiceServer, fit_service_server::FitServiceServer,
        key_service_server::KeyServiceServer, planning_service_server::PlanningServiceServer,
        project_service_server::ProjectServiceServer,
        registration_service_server::RegistrationServiceServer,
        retention_service_server::RetentionServiceServer,
        rollout_service_server::RolloutServiceServer, session_service_server::SessionServiceServer,
        share_service_server::ShareServiceServer, sign_in_service_server::SignInServiceServer,
        trash_service_server::TrashServiceServer, twin_service_server::TwinServiceServer,
        usage_service_server::UsageServiceServer, worker_service_server::WorkerServiceServer,
    },
    worker::v1::worker_link_server::WorkerLinkServer,
};
use futures::{Stream, StreamExt, stream::BoxStream};
use prost::Message as _;
use prost_types::FileDescriptorSet;
use tonic::{
    Status,
    service::{Routes, interceptor::InterceptedService},
};
use tonic_health::pb::health_server::HealthServer;

use crate::{
    app::{self, App},
    context::Context,
    refusal::Refusal,
    service::StartError,
};

use counted::Counted;
pub(crate) use counted::InProcess;
use health::ServerHealth;
use token::TokenCheck;

/// Bytes of one message of an ordinary call; chunks of uploads are to be smaller. Each call under way
/// may hold as much.
const MESSAGE: usize = 4 << 20;
/// Bytes of one message of a worker.
const WORKER_MESSAGE: usize = 16 << 20;
/// Bytes of a chunk that is sent.
const CHUNK: usize = 1 << 20;

/// A stream of messages to a client.
type Reply<T> = BoxStream<'static, Result<T, Status>>;

/// The application as gRPC services.
#[derive(Clone, Debug)]
struct Api {
    app: App,
}

/// All services as one router.
pub(crate) async fn router(app: &App) -> Result<axum::Router, StartError> {
    let api = Api { app: app.clone() };
    let limits = app.options().limits.rollout;
    let bytes = |limit: u64| usize::try_from(limit).unwrap_or(usize::MAX);
    // A body of JSON becomes one message, with its strings and a few fields.
    let message = MESSAGE.max(app.options().limits.json_bytes.saturating_add(64 << 10));
    let reflection = || {
        tonic_reflection::server::Builder::configure()
            .register_encoded_file_descriptor_set(DESCRIPTORS)
            .register_encoded_file_descriptor_set(tonic_health::pb::FILE_DESCRIPTOR_SET)
    };
    let broken = |e: tonic_reflection::server::Error| StartError::Descriptors(e.to_string());
    let health = ServerHealth::new(app)
        .with::<CaptureServiceServer<Api>>()
        .with::<FitServiceServer<Api>>()
        .with::<TwinServiceServer<Api>>()
        .with::<WorkerServiceServer<Api>>()
        .with::<KeyServiceServer<Api>>()
        .with::<ShareServiceServer<Api>>()
        .with::<ProjectServiceServer<Api>>()
        .with::<UsageServiceServer<Api>>()
        .with::<TrashServiceServer<Api>>()
        .with::<RetentionServiceServer<Api>>()
        .with::<SignInServiceServer<Api>>()
        .with::<RolloutServiceServer<Api>>()
        .with::<SessionServiceServer<Api>>()
        .with::<PlanningServiceServer<Api>>()
        .with::<RegistrationServiceServer<Api>>()
        .with::<EvaluationServiceServer<Api>>();
    let mut routes = Routes::builder();
    routes
        .add_service(HealthServer::new(health))
        .add_service(reflection().build_v1().map_err(broken)?)
        // The version that grpcio-reflection and older tools speak.
        .add_service(reflection().build_v1alpha().map_err(broken)?)
        .add_service(CaptureServiceServer::new(api.clone()).max_decoding_message_size(message))
        .add_service(FitServiceServer::new(api.clone()).max_decoding_message_size(message))
        .add_service(TwinServiceServer::new(api.clone()).max_decoding_message_size(message))
        .add_service(WorkerServiceServer::new(api.clone()))
        .add_service(KeyServiceServer::new(api.clone()).max_decoding_message_size(message))
        .add_service(ShareServiceServer::new(api.clone()).max_decoding_message_size(message))
        .add_service(ProjectServiceServer::new(api.clone()).max_decoding_message_size(message))
        .add_service(UsageServiceServer::new(api.clone()))
        .add_service(TrashServiceServer::new(api.clone()).max_decoding_message_size(message))
        .add_service(RetentionServiceServer::new(api.clone()).max_decoding_message_size(message))
        .add_service(SignInServiceServer::new(api.clone()).max_decoding_message_size(message))
        .add_service(EvaluationServiceServer::new(api.clone()).max_decoding_message_size(message))
        .add_service(Counted {
            app: app.clone(),
            inner: RolloutServiceServer::new(api.clone())
                .max_decoding_message_size(bytes(limits.request_bytes))
                .max_encoding_message_size(bytes(limits.reply_bytes)),
        })
        .add_service(Counted {
            app: app.clone(),
            inner: PlanningServiceServer::new(api.clone())
                .max_decoding_message_size(bytes(limits.request_bytes))
                // An update may have the reply to a rollout beside knots as large as the request's.
                .max_encoding_message_size(bytes(
                    limits.reply_bytes.saturating_add(limits.request_bytes),
                )),
        })
        .add_service(Counted {
            app: app.clone(),
            inner: RegistrationServiceServer::new(api.clone())
                .max_decoding_message_size(bytes(limits.request_bytes))
                .max_encoding_message_size(bytes(limits.reply_bytes)),
        })
        .add_service(Counted {
            app: app.clone(),
            inner: SessionServiceServer::new(api)
                .max_decoding_message_size(bytes(limits.request_bytes))
                .max_encoding_message_size(bytes(limits.reply_bytes)),
        });
    // Workers that have to show a certificate do not connect where none is demanded.
    if app.options().worker_tls.is_none() {
        routes.add_service(worker_link(app));
    }
    Ok(routes.routes().into_axum_router())
}

/// The services of the workers' listener.
pub(crate) fn worker_router(app: &App) -> axum::Router {
    let health = HealthServer::new(ServerHealth::new(app));
    let mut routes = Routes::builder();
    routes.add_service(health).add_service(worker_link(app));
    routes.routes().into_axum_router()
}

fn worker_link(app: &App) -> InterceptedService<WorkerLinkServer<Api>, TokenCheck> {
    let link =
        WorkerLinkServer::new(Api { app: app.clone() }).max_decoding_message_size(WORKER_MESSAGE);
    InterceptedService::new(link, TokenCheck(app.clone()))
}

/// The paths of all methods, as `/package.Service/Method`.
pub(crate) fn methods() -> Result<HashSet<String>, StartError> {
    let sets = [
        DESCRIPTORS,
        tonic_health::pb::FILE_DESCRIPTOR_SET,
        tonic_reflection::pb::v1::FILE_DESCRIPTOR_SET,
        tonic_reflection::pb::v1alpha::FILE_DESCRIPTOR_SET,
    ];
    let mut paths = HashSet::new();
    for set in sets {
        let set =
            FileDescriptorSet::decode(set).map_err(|e| StartError::Descriptors(e.to_string()))?;
        for file in &set.file {
            for service in &file.service {
                let (package, name) = (file.package(), service.name());
                let methods =
                    service.method.iter().map(|m| format!("/{package}.{name}/{}", m.name()));
                paths.extend(methods);
            }
        }
    }
    Ok(paths)
}

/// Turns items into messages and errors into statuses of this request.
fn reply<T, M: 'static>(
    items: impl Stream<Item = app::Result<T>> + Send + 'static,
    message: impl Fn(T) -> M + Send + 'static,
) -> Reply<M> {
    // Streams outlive the scope of the request's context.
    let context = Context::current();
    let status = move |e: app::Error| Refusal::from(e).into_status(&context);
    items.map(move |item| item.map(&message).map_err(&status)).boxed()
}

/// Sends content in chunks of a size that every client accepts.
fn chunks<M: 'static>(
    content: bendtwin_store::Content,
    message: impl Fn(bytes::Bytes) -> M + Send + 'static,
) -> Reply<M> {
    let split = content.chunks.map(|chunk| chunk.map_err(app::Error::from)).flat_map(|chunk| {
        let pieces = match chunk {
            Ok(mut bytes) => {
                let mut pieces = Vec::new();
                while bytes.len() > CHUNK {
                    pieces.push(Ok(bytes.split_to(CHUNK)));
                }
                pieces.push(Ok(bytes));
                pieces
            }
            Err(error) => vec![Err(error)],
        };
        futures::stream::iter(pieces)
    });
    reply(split, message)
}

/// `?` on application errors within service methods.
impl From<app::Error> for Status {
    fn from(error: app::Error) -> Self {
        Refusal::from(error).into()
    }
}
