-- Times are microseconds since the Unix epoch, ids bare UUIDs (version 7, so
-- they sort by creation), digests BLAKE3 in hex. Only types and syntax that
-- SQLite and PostgreSQL share.

create table captures (
    id           text   primary key,
    display_name text   not null,
    created_at   bigint not null,
    size_bytes   bigint not null,
    digest       text   not null,
    request_id   text   unique
);
create index captures_by_digest on captures (digest);

-- The queue. A claim adds 1 to lease_epoch; every later write of a worker says
-- `where lease_epoch = $mine and state = 'running'`.
create table jobs (
    id               text    primary key,
    kind             text    not null,
    capture          text    not null,
    state            text    not null
        check (state in ('queued', 'running', 'succeeded', 'failed', 'cancelled')),
    priority         bigint  not null,
    settings         text    not null,
    -- Claims that counted; a lease handed back in good order does not.
    attempts         bigint  not null default 0,
    -- Claims since the job last got further than ever before.
    stalled          bigint  not null default 0,
    -- The furthest share of the job that any attempt reported, 0..1.
    furthest         double precision not null default 0,
    lease_epoch      bigint  not null default 0,
    lease_until      bigint,
    worker           text,
    progress         text,
    -- Digest of the newest checkpoint.
    checkpoint       text,
    cancel_requested boolean not null default false,
    twin             text,
    fault            text,
    -- JSON array: why earlier attempts ended.
    attempt_faults   text    not null default '[]',
    trace_parent     text,
    request_id       text    unique,
    created_at       bigint  not null,
    started_at       bigint,
    ended_at         bigint,
    revision         bigint  not null default 1
);
create index jobs_by_claim on jobs (state, priority desc, created_at, id);
create index jobs_by_capture on jobs (capture, id);
create index jobs_by_checkpoint on jobs (checkpoint);

create table twins (
    id            text   primary key,
    display_name  text   not null,
    capture       text,
    fit           text   unique,
    created_at    bigint not null,
    size_bytes    bigint not null,
    digest        text   not null,
    node_count    bigint not null,
    spring_count  bigint not null,
    triplet_count bigint not null,
    control_count bigint not null,
    fps           double precision not null,
    substeps      bigint not null,
    quality       text   not null,
    request_id    text   unique
);
create index twins_by_capture on twins (capture, id);
create index twins_by_digest on twins (digest);

create table workers (
    id           text    primary key,
    endpoint     text    not null,
    backend      text    not null,
    device       text    not null,
    build        text    not null,
    lanes        bigint  not null,
    -- Started by the server, so it is gone when the server starts anew.
    supervised   boolean not null,
    started_at   bigint  not null
);
