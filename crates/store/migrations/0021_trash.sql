-- The trash: a row with `trashed_at` is of something deleted that can still be restored. It is purged once
-- `purge_at` has passed. An older version still shows such rows.
alter table captures add column trashed_at bigint;
alter table captures add column purge_at bigint;
-- Owner of the key that deleted it, or the rule that did; empty if that is not known.
alter table captures add column trashed_by text;
alter table jobs add column trashed_at bigint;
alter table jobs add column purge_at bigint;
alter table jobs add column trashed_by text;
-- 'queued' if the job is to be queued when it is restored.
alter table jobs add column restored_state text;
alter table twins add column trashed_at bigint;
alter table twins add column purge_at bigint;
alter table twins add column trashed_by text;
create index captures_in_trash on captures (trashed_at, id) where trashed_at is not null;
create index jobs_in_trash on jobs (kind, trashed_at, id) where trashed_at is not null;
create index twins_in_trash on twins (trashed_at, id) where trashed_at is not null;

-- Rules by which servers move captures, fits and twins to the trash.
create table retention_rules (
    id           text   primary key,
    display_name text   not null,
    -- captures, fits or twins.
    collection   text   not null,
    -- Microseconds since the creation of what it matches.
    min_age      bigint not null,
    -- Owner, tag, and verdict of a capture's report; empty for any.
    owner        text   not null,
    tag          text   not null,
    verdict      text   not null,
    created_at   bigint not null
);
