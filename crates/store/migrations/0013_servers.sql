-- Servers that have this database open. Each renews `seen_at` while it runs, by the clock of the database if that
-- has one, and removes its row when it stops.
create table servers (
    id         text   primary key,
    build      text   not null,
    started_at bigint not null,
    seen_at    bigint not null
);

-- The server that started it, as a process of its own.
alter table workers add column server text;
-- Changes while any server hears of it.
alter table workers add column seen_at bigint not null default 0;
-- It takes no more jobs and rollouts, and ends.
alter table workers add column draining boolean not null default false;
