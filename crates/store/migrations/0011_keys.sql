-- Keys of clients. A revoked key stays, so that what was done with it keeps a name.
create table keys (
    id              text   primary key,
    display_name    text   not null,
    -- Name that is recorded with what is made with the key.
    owner           text   not null,
    -- BLAKE3 of the whole key, hex. The key itself is nowhere.
    hash            text   not null,
    -- JSON array of words, sorted.
    scopes          text   not null,
    created_at      bigint not null,
    -- Null: never.
    expires_at      bigint,
    revoked_at      bigint,
    used_at         bigint,
    -- Null: no bound.
    max_queued_jobs bigint,
    max_stored_bytes bigint,
    max_rollouts    bigint
);

-- Owner of the key with which it was made; empty if it is not known.
alter table captures add column owner text not null default '';
alter table jobs add column owner text not null default '';
alter table twins add column owner text not null default '';
alter table uploads add column owner text not null default '';
create index captures_by_owner on captures (owner, id);
create index jobs_by_owner on jobs (owner, kind, id);
create index twins_by_owner on twins (owner, id);
