-- Attempts that other work of their worker ended, since the job last got further than ever before.
alter table jobs add column interrupted bigint not null default 0;
