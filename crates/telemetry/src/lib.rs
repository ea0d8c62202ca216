//! Traces: the spans of server and workers, joined over processes by W3C `traceparent` and sent to
//! an OpenTelemetry collector over OTLP. Off unless the standard variables of the environment name
//! a collector; without it all functions here do next to nothing.

mod collector;

use std::{collections::HashMap, env, time::Duration};

use bendtwin_tls::FileError;
use opentelemetry::{
    KeyValue,
    propagation::TextMapPropagator as _,
    trace::{Status, TraceContextExt as _, TracerProvider as _},
};
use opentelemetry_otlp::{SpanExporter, WithTonicConfig as _};
use opentelemetry_sdk::{
    Resource,
    propagation::TraceContextPropagator,
    trace::{SdkTracer, SdkTracerProvider},
};
use tracing::{Span, Subscriber};
use tracing_opentelemetry::{OpenTelemetryLayer, OpenTelemetrySpanExt as _};
use tracing_subscriber::registry::LookupSpan;

/// Name of the header and of the metadata entry that joins spans of two processes.
pub const HEADER: &str = "traceparent";
/// Longest time for the last spans of a process.
const LAST_SPANS: Duration = Duration::from_secs(3);

/// The exporter cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The address of the collector, or another option of its, cannot be used.
    #[error("traces are not exported: {0}: check OTEL_EXPORTER_OTLP_ENDPOINT")]
    Options(#[from] opentelemetry_otlp::ExporterBuildError),
    /// The address of the collector is no URL.
    #[error("traces are not exported: {0}: check OTEL_EXPORTER_OTLP_ENDPOINT")]
    Address(#[from] tonic::transport::Error),
    /// The file of the collector's authority cannot be used.
    #[error("traces are not exported: {0} (OTEL_EXPORTER_OTLP_CERTIFICATE)")]
    Authority(#[from] FileError),
}

/// Sender of spans. A separate thread sends them in batches.
#[derive(Debug)]
pub struct Exporter(SdkTracerProvider);

impl Exporter {
    /// The exporter of a process, if the environment names a collector; called within a runtime of
    /// tokio. `service` is its name where `OTEL_SERVICE_NAME` has none.
    ///
    /// # Errors
    /// If the collector's address or the file of its authority cannot be used.
    pub fn from_environment(service: &'static str) -> Result<Option<Self>, Error> {
        let is_set = |name: &str| env::var_os(name).is_some_and(|value| !value.is_empty());
        let disabled = env::var("OTEL_SDK_DISABLED").is_ok_and(|v| v.eq_ignore_ascii_case("true"));
        let Some(endpoint) = collector::endpoint().filter(|_| !disabled) else { return Ok(None) };
        let mut builder = SpanExporter::builder().with_tonic();
        if endpoint.starts_with("https://") {
            builder = builder.with_channel(collector::with_tls(endpoint)?);
        }
        let exporter = builder.build()?;
        let mut resource = Resource::builder()
            .with_attribute(KeyValue::new("service.version", env!("CARGO_PKG_VERSION")));
        if !is_set("OTEL_SERVICE_NAME") {
            resource = resource.with_service_name(service);
        }
        let provider = SdkTracerProvider::builder()
            .with_resource(resource.build())
            .with_batch_exporter(exporter)
            .build();
        Ok(Some(Self(provider)))
    }

    /// The layer of `tracing` that spans come from.
    pub fn layer<S>(&self) -> OpenTelemetryLayer<S, SdkTracer>
    where
        S: Subscriber + for<'span> LookupSpan<'span>,
    {
        tracing_opentelemetry::layer().with_tracer(self.0.tracer("bendtwin"))
    }

    /// Sends the spans that still wait, for a few seconds at most.
    pub fn end(self) {
        if let Err(error) = self.0.shutdown_with_timeout(LAST_SPANS) {
            eprintln!("warning: the last spans were not sent: {error}");
        }
    }
}

/// Makes a span the child of one in another process. It must not have been entered before.
pub fn continue_from(span: &Span, trace_parent: &str) {
    if trace_parent.is_empty() {
        return;
    }
    let carrier = HashMap::from([(HEADER.to_owned(), trace_parent.to_owned())]);
    // Without an exporter there is no parent to set.
    let _ = span.set_parent(TraceContextPropagator::new().extract(&carrier));
}

/// The `traceparent` by which another process continues this span; none if spans are not exported.
pub fn trace_parent(span: &Span) -> Option<String> {
    let context = span.context();
    if !context.span().span_context().is_valid() {
        return None;
    }
    let mut carrier = HashMap::new();
    TraceContextPropagator::new().inject_context(&context, &mut carrier);
    carrier.remove(HEADER)
}

/// Names a span by what it turned out to be, and notes the code of its answer.
pub fn answered(span: &Span, name: &str, code: &str, failed: bool) {
    let context = span.context();
    let span = context.span();
    if !span.span_context().is_valid() {
        return;
    }
    span.update_name(name.to_owned());
    span.set_attribute(KeyValue::new("code", code.to_owned()));
    if failed {
        span.set_status(Status::error(code.to_owned()));
    }
}
