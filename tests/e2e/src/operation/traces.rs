//! Traces: one request is one trace, over server, worker and the process that reads a capture. They go
//! to a collector over TLS.

use std::{
    collections::BTreeSet,
    sync::{Arc, Mutex},
    time::Duration,
};

use opentelemetry_proto::tonic::{
    collector::trace::v1::{
        ExportTraceServiceRequest, ExportTraceServiceResponse,
        trace_service_server::{TraceService, TraceServiceServer},
    },
    common::v1::{KeyValue, any_value::Value},
};
use reqwest::Method;
use serde_json::json;
use tokio::net::TcpListener;
use tonic::{Request, Response, Status, transport::server::TcpIncoming};

use super::tls_terminator::TlsTerminator;
use crate::harness::{
    Setup, TestCluster,
    reference::{SETTINGS, capture},
    until,
};

/// Trace of a client.
const TRACE: &str = "0af7651916cd43dd8448eb211c80319c";

/// Spans of that trace, each as its service, its name and its stage.
#[derive(Clone, Default)]
struct Collector(Arc<Mutex<BTreeSet<(String, String, String)>>>);

fn text(attributes: &[KeyValue], key: &str) -> String {
    let found = attributes.iter().find(|attribute| attribute.key == key);
    match found.and_then(|a| a.value.as_ref()?.value.as_ref()) {
        Some(Value::StringValue(text)) => text.clone(),
        _ => String::new(),
    }
}

#[tonic::async_trait]
impl TraceService for Collector {
    async fn export(
        &self,
        request: Request<ExportTraceServiceRequest>,
    ) -> Result<Response<ExportTraceServiceResponse>, Status> {
        for of_process in request.into_inner().resource_spans {
            let resource = of_process.resource.unwrap_or_default();
            let service = text(&resource.attributes, "service.name");
            for span in of_process.scope_spans.into_iter().flat_map(|scope| scope.spans) {
                let trace: String = span.trace_id.iter().map(|b| format!("{b:02x}")).collect();
                if trace == TRACE {
                    let stage = text(&span.attributes, "stage");
                    self.0.lock().unwrap().insert((service.clone(), span.name, stage));
                }
            }
        }
        Ok(Response::new(ExportTraceServiceResponse::default()))
    }
}

#[tokio::test]
async fn a_fit_and_its_capture_are_one_trace_over_all_processes() {
    let collector = Collector::default();
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap();
    let service = TraceServiceServer::new(collector.clone());
    let serving = tonic::transport::Server::builder().add_service(service);
    tokio::spawn(serving.serve_with_incoming(TcpIncoming::from(listener)));

    let behind = TlsTerminator::to(&address.to_string()).await;
    let setup = Setup {
        environment: vec![
            ("OTEL_EXPORTER_OTLP_ENDPOINT", behind.url().to_owned()),
            ("OTEL_EXPORTER_OTLP_CERTIFICATE", behind.authority()),
            ("OTEL_BSP_SCHEDULE_DELAY", "200".to_owned()),
        ],
        ..Setup::default()
    };
    let server = TestCluster::start(setup).await;
    let http = server.http();
    let traced = |method, path: &str| {
        let parent = format!("00-{TRACE}-b7ad6b7169203331-01");
        http.request(method, path).header("traceparent", parent)
    };
    let upload = traced(Method::POST, "/v1/captures").header("content-type", "application/zip");
    let stored = upload.body(capture().await).send().await.unwrap();
    let stored: serde_json::Value = stored.json().await.unwrap();
    let settings: serde_json::Value = serde_json::from_str(SETTINGS).unwrap();
    let order = json!({"capture": stored["name"], "settings": settings});
    let accepted = traced(Method::POST, "/v1/fits").json(&order).send().await.unwrap();
    assert_eq!(accepted.status(), 202);

    let span = |service: &str, name: &str, stage: &str| {
        (format!("bendtwin-{service}"), name.to_owned(), stage.to_owned())
    };
    let expected = BTreeSet::from([
        span("server", "/v1/captures", ""),
        span("server", "/v1/fits", ""),
        span("worker", "ingest", ""),
        span("worker", "fit", ""),
        span("worker", "stage", "search"),
        span("worker", "stage", "refine"),
    ]);
    until("all spans", Duration::from_secs(60), async || {
        let spans = collector.0.lock().unwrap();
        // The steps of the process that reads the capture have distinct names.
        let reads = spans.iter().any(|(_, name, stage)| {
            name == "stage" && !["search", "refine", "evaluate"].contains(&stage.as_str())
        });
        (reads && expected.is_subset(&spans)).then_some(())
    })
    .await;
}
