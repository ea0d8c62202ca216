-- What a database is, in one row. The blobs that belong to it have the same identity in
-- `blobs/identity`.
create table store (
    id        bigint primary key check (id = 1),
    identity  text   not null,
    -- When a write was last proved to work.
    probed_at bigint not null
);

-- Listings by kind, and by kind and capture. The index they replace found all jobs of a capture.
create index jobs_by_kind on jobs (kind, id);
create index jobs_by_kind_and_capture on jobs (kind, capture, id);
drop index jobs_by_capture;
-- Depth of the queues, without a look at the rows.
create index jobs_by_kind_and_state on jobs (kind, state, created_at);
