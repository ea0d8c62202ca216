-- What a player shows of a capture, made with its observation. Captures that were read before there
-- were any have none.
create table playbacks (
    capture    text   primary key,
    created_at bigint not null,
    size_bytes bigint not null,
    digest     text   not null
);
create index playbacks_by_digest on playbacks (digest);
