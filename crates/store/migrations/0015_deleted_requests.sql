-- Request ids under which resources were made that have been deleted: an attempt at the same request that
-- comes late makes no other one. Forgotten after a day.
create table deleted_requests (
    -- The table that the resource was in.
    kind       text   not null,
    request_id text   not null,
    -- That of the resource.
    name       text   not null,
    until_at   bigint not null,
    -- The upload that was begun under the id after the deletion: it may make a capture.
    upload     text,
    primary key (kind, request_id)
);
create index deleted_requests_by_end on deleted_requests (until_at);
