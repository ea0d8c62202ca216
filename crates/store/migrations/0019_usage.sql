-- Size of what the ingests of a capture made: observation, playback, masks and report [bytes]. It is written
-- with them; that of results from before, or of an older version, is filled in while a server runs.
alter table captures add column derived_bytes bigint not null default 0;
create index captures_by_owner_and_size on captures (owner, size_bytes, derived_bytes);
create index twins_by_owner_and_size on twins (owner, size_bytes);

-- Size of a report, document and page together; null until it is known.
alter table reports add column size_bytes bigint;
create index reports_without_size on reports (capture) where size_bytes is null;

-- Size of the newest checkpoint; null until it is known.
alter table jobs add column checkpoint_bytes bigint;
create index jobs_with_checkpoint on jobs (owner, checkpoint_bytes) where checkpoint is not null;

-- Bytes set aside for an upload whose length is not known; what has arrived is part of them.
alter table uploads add column reserved_bytes bigint not null default 0;

-- Bytes set aside for content that arrives in one request, for as long as it arrives.
create table reservations (
    id         text   primary key,
    owner      text   not null,
    size_bytes bigint not null,
    -- The server that receives it renews this; one that has died does not.
    until_at   bigint not null
);
create index reservations_by_owner on reservations (owner, size_bytes);
