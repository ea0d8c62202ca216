-- Files that were added to captures after their upload, one of each kind: the next ingest reads them
-- beside the archive. An older version takes their content for garbage.
create table supplements (
    capture    text   not null,
    -- masks or calibration.
    kind       text   not null,
    created_at bigint not null,
    size_bytes bigint not null,
    digest     text   not null,
    -- Of the key that added it.
    owner      text   not null,
    primary key (capture, kind)
);
create index supplements_by_digest on supplements (digest);
create index supplements_by_owner on supplements (owner);

-- Masks that the last ingest of a capture made of strokes.
create table masks (
    capture    text   primary key,
    created_at bigint not null,
    size_bytes bigint not null,
    digest     text   not null
);
create index masks_by_digest on masks (digest);

-- True of an ingest that succeeded and made no observation, because it was to end with the masks.
alter table jobs add column masks_only boolean not null default false;
