//! Every metric with its help text. Tests compare the list with what is rendered, with
//! docs/run/monitoring.md, and with the alert rules.

/// Name and help of each metric of the server itself.
pub(super) const CATALOG: [(&str, &str); 47] = [
    ("bendtwin_build_info", "Version and revision of the server's program; always 1"),
    ("bendtwin_certificate_end_timestamp_seconds", "End of the certificate of a listener"),
    ("bendtwin_connections", "Open connections of a listener"),
    ("bendtwin_connections_ended_total", "Connections that the server refused or ended"),
    ("bendtwin_device_memory_bytes", "Memory of all workers' devices, where it is known"),
    ("bendtwin_disk_bytes", "Space of the disk that holds the data folder"),
    ("bendtwin_fit_attempts_total", "Attempts of fits that ended, by the state they left"),
    ("bendtwin_fit_queue_seconds", "Time of fits in the queue"),
    ("bendtwin_fits", "Fits by state, as last read from the database"),
    ("bendtwin_ingest_attempts_total", "Attempts of ingests that ended, by the state they left"),
    ("bendtwin_ingest_queue_seconds", "Time of ingests in the queue"),
    ("bendtwin_ingests", "Ingests by state, as last read from the database"),
    ("bendtwin_lease_losses_total", "Jobs taken from workers whose lease ran out"),
    ("bendtwin_memory_budget_bytes", "The server's budget of memory for requests"),
    ("bendtwin_oldest_queued_fit_seconds", "Age of the oldest queued fit"),
    ("bendtwin_oldest_queued_ingest_seconds", "Age of the oldest queued ingest"),
    ("bendtwin_owner_jobs", "Waiting and running jobs of an owner"),
    ("bendtwin_owner_stored_bytes", "Bytes stored for an owner, as its quota counts them"),
    ("bendtwin_plays", "Plays in progress at this server"),
    ("bendtwin_ready", "Result of a check of readiness: 1 or 0"),
    ("bendtwin_request_seconds", "Time until the response began"),
    ("bendtwin_requests_total", "Answered requests"),
    ("bendtwin_rollout_queue_seconds", "Time of rollouts in the line of their worker"),
    ("bendtwin_rollout_seconds", "Time of rollouts at their worker"),
    ("bendtwin_rollouts_in_flight", "Rollouts in progress or waiting"),
    ("bendtwin_rollouts_total", "Rollouts that ended, by outcome"),
    ("bendtwin_rollouts_waiting", "Rollouts that wait for a worker, by class of size"),
    ("bendtwin_sessions", "Sessions at the workers that this server knows"),
    ("bendtwin_store_age_seconds", "Age of the numbers that were read from the database"),
    ("bendtwin_store_errors_total", "Calls to the database or to the content that failed"),
    ("bendtwin_store_seconds", "Time of calls to the database or to the content"),
    ("bendtwin_store_up", "1 if the database answered within the last seconds, else 0"),
    ("bendtwin_upload_bytes_total", "Bytes of resumable uploads that were stored durably"),
    ("bendtwin_uploads", "Unfinished resumable uploads"),
    ("bendtwin_uploads_bytes", "Space reserved for unfinished resumable uploads"),
    ("bendtwin_worker_restarts_total", "Restarts of the server's own worker processes"),
    ("bendtwin_workers", "Workers that this server knows"),
    ("bendtwin_workers_answering", "Workers that gave a sign of life lately"),
    ("bendtwin_write_failures_total", "Writes that failed because of the disk or the database"),
    // Of the process, by the crate metrics-process.
    ("process_cpu_seconds_total", "Processor time of the server's process"),
    ("process_max_fds", "Limit of open files"),
    ("process_open_fds", "Open files"),
    ("process_resident_memory_bytes", "Memory in use"),
    ("process_start_time_seconds", "Start of the process"),
    ("process_threads", "Threads"),
    ("process_virtual_memory_bytes", "Address space in use"),
    ("process_virtual_memory_max_bytes", "Limit of the address space"),
];

/// The help text of a metric.
pub(super) fn help(name: &str) -> &'static str {
    CATALOG.iter().find(|(listed, _)| *listed == name).map_or("", |(_, help)| help)
}
