-- A capture is read by a job of its own before it is fitted: kind 'ingest', one row a capture.
-- Captures that are older than this get theirs when the store opens.
create unique index jobs_ingest_of on jobs (capture) where kind = 'ingest';

-- What the last ingest that succeeded made of a capture: the bundle that fits read.
create table observations (
    capture    text   primary key,
    created_at bigint not null,
    size_bytes bigint not null,
    digest     text   not null
);
create index observations_by_digest on observations (digest);

-- What the last ingest that had anything to say says of a capture.
create table reports (
    capture     text   primary key,
    created_at  bigint not null,
    -- One lower-case word.
    verdict     text   not null,
    -- Digests of the document and of the page.
    json_digest text   not null,
    html_digest text   not null
);
create index reports_by_json on reports (json_digest);
create index reports_by_html on reports (html_digest);
