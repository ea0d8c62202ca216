-- Uploads that can be resumed. What is acknowledged of one is in the file
-- `blobs/partial/{id}` up to offset_bytes; what the file has beyond is not.
create table uploads (
    id              text   primary key,
    state           text   not null check (state in ('receiving', 'stored', 'gone')),
    display_name    text   not null,
    -- Given up when the upload is gone, so that another may have it.
    request_id      text   unique,
    -- BLAKE3 that the client declared.
    expected_digest text,
    -- As the client wrote it.
    metadata        text   not null,
    -- Null while the client does not know it.
    length_bytes    bigint,
    offset_bytes    bigint not null default 0,
    -- BLAKE3 of whole content on its way to becoming a capture: keeps its blob.
    digest          text,
    capture         text,
    -- Why it is gone.
    why             text,
    created_at      bigint not null,
    -- When it is given up, or, having ended, forgotten.
    expires_at      bigint not null
);
create index uploads_by_expiry on uploads (state, expires_at);
create index uploads_by_digest on uploads (digest);
