-- Content in a place that several servers share. Content that is about to be referred to: nobody deletes
-- it meanwhile. The server that published it takes its rows away; those of one that died go after a day.
create table arrivals (
    id       text   not null,
    digest   text   not null,
    until_at bigint not null,
    primary key (id, digest)
);
create index arrivals_by_digest on arrivals (digest);
-- Content that a server is deleting: nobody publishes it meanwhile.
create table deletions (
    digest   text   primary key,
    -- That of the one who deletes it.
    id       text   not null,
    begun_at bigint not null
);

-- The one server that writes to an upload, where several may; each claim adds 1 to lease_epoch.
alter table uploads add column holder text;
alter table uploads add column lease_epoch bigint not null default 0;
alter table uploads add column lease_until bigint;
-- True once another server waits for the upload.
alter table uploads add column is_wanted boolean not null default false;
-- In a bucket: the id of the multipart upload, and the name of the object with the bytes after its parts.
alter table uploads add column multipart text;
alter table uploads add column tail text;
create table upload_parts (
    upload   text   not null,
    -- From 0.
    number   bigint not null,
    -- That of S3.
    tag      text   not null,
    -- BLAKE3's chaining value of its bytes, in hex.
    chaining text   not null,
    primary key (upload, number)
);
