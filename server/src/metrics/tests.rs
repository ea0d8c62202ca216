use std::collections::BTreeSet;

use bendtwin_store::{OwnerUsage, QueueDepth, UploadUse};

use super::*;

const ALERTS: &str = include_str!("../../../deploy/prometheus/alerts.yaml");
const RUNBOOKS: &str = include_str!("../../../docs/run/runbooks.md");
const MONITORING: &str = include_str!("../../../docs/run/monitoring.md");

/// Words of a text that are names of metrics of this server.
fn names(text: &str) -> BTreeSet<&str> {
    let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let words = text.split(|c| !is_name(c));
    words.filter(|word| word.starts_with("bendtwin_") || word.starts_with("process_")).collect()
}

/// The metric that a name of a histogram's series belongs to.
fn metric(series: &str) -> &str {
    let suffixes = ["_bucket", "_count", "_sum"].into_iter();
    let mut of_histogram = suffixes.filter_map(|suffix| series.strip_suffix(suffix));
    of_histogram.find(|name| is_listed(name)).unwrap_or(series)
}

fn listed() -> BTreeSet<&'static str> {
    catalog::CATALOG.iter().map(|(name, _)| *name).collect()
}

/// All metrics, each set once.
fn rendered() -> String {
    let metrics = Metrics::new();
    let time = Duration::from_millis(3);
    metrics.request("http", "/healthz", "200", time);
    for kind in [Kind::Ingest, Kind::Fit] {
        metrics.job_leased(kind, 1.0);
        metrics.job_ended(kind, "succeeded");
        metrics.lease_lost(kind);
    }
    metrics.upload_bytes(7);
    metrics.rollout("done", time, time);
    metrics.connections("public", 1);
    metrics.connection_ended("public", "silent");
    metrics.certificate_end("public", jiff::Timestamp::UNIX_EPOCH);
    metrics.rollouts_waiting("small", 0);
    metrics.memory_budget(1, 2);
    metrics.disk(1, 2);
    metrics.ready("writes", true);
    metrics.write_failed("DISK_FULL");
    metrics.worker_restarted(0);
    metrics.stored(&QueueDepth::default(), UploadUse::default());
    metrics.store_up(true, Some(time));
    metrics.called(Call { part: Part::Database, operation: "read", took: time, failed: true });
    metrics.render(&Gauges {
        workers: 2,
        answering: 1,
        rollouts: 0,
        sessions: 3,
        plays: 1,
        memory: Memory::default(),
        usage: Some([OwnerUsage::default()].into()),
    })
}

#[test]
fn the_catalog_has_what_is_rendered_and_nothing_else() {
    let text = rendered();
    let series = text.lines().filter(|line| !line.starts_with('#') && !line.is_empty());
    let found: BTreeSet<&str> = series.flat_map(names).map(metric).collect();
    let missing: Vec<_> = listed().difference(&found).copied().collect();
    let unlisted: Vec<_> = found.difference(&listed()).copied().collect();
    // The system may set no limit.
    let optional = ["process_virtual_memory_max_bytes", "process_max_fds"];
    assert!(missing.iter().all(|name| optional.contains(name)), "{missing:?} in\n{text}");
    assert!(unlisted.is_empty(), "{unlisted:?}");
    for line in [
        "# HELP bendtwin_store_up ",
        "# TYPE bendtwin_store_seconds histogram",
        r#"bendtwin_store_errors_total{store="database",operation="read"} 1"#,
        r#"bendtwin_lease_losses_total{kind="fit"} 1"#,
        "bendtwin_workers_answering 1",
        "bendtwin_sessions 3",
        r#"bendtwin_build_info{version=""#,
    ] {
        assert!(text.contains(line), "{line} is not in\n{text}");
    }
}

#[test]
fn every_metric_is_documented() {
    let documented = names(MONITORING);
    // Described as those of fits, with another word.
    let of_fits = |name: &str| name.replace("_ingest", "_fit");
    let missing: Vec<_> = listed()
        .into_iter()
        .filter(|name| !documented.contains(name) && !documented.contains(of_fits(name).as_str()))
        .collect();
    assert!(missing.is_empty(), "{missing:?} are not in docs/run/monitoring.md");
}

/// The value of a key in the lines of a rule.
fn value<'a>(rule: &'a str, key: &str) -> Option<&'a str> {
    rule.lines().find_map(|line| line.trim_start().strip_prefix(key)?.strip_prefix(": "))
}

#[test]
fn alerts_use_metrics_that_exist_and_have_runbooks() {
    let mut rules: Vec<&str> = ALERTS.split("- alert: ").collect();
    rules.remove(0);
    let mut alerts = BTreeSet::new();
    for rule in rules {
        let name = rule.lines().next().unwrap();
        assert!(alerts.insert(name), "{name} twice");
        let expression = value(rule, "expr").unwrap_or_else(|| panic!("{name} has no expr"));
        let used: Vec<&str> = names(expression).into_iter().map(metric).collect();
        assert!(!used.is_empty() || expression.starts_with("up{"), "{name}: {expression}");
        assert!(used.iter().all(|metric| is_listed(metric)), "{name}: {used:?}");
        let severity = value(rule, "labels").unwrap_or_default();
        assert!(["{severity: page}", "{severity: ticket}"].contains(&severity), "{name}");
        assert!(value(rule, "summary").is_some(), "{name} has no summary");
        let anchor = format!("\"docs/run/runbooks.md#{}\"", name.to_lowercase());
        assert_eq!(value(rule, "runbook_url"), Some(anchor.as_str()), "{name}");
    }
    let headings = RUNBOOKS.lines().filter_map(|line| line.strip_prefix("## "));
    assert_eq!(alerts, headings.filter(|heading| heading.starts_with("BendTwin")).collect());
    assert!(alerts.len() >= 10, "{alerts:?}");
}
