-- When a queued job is due: jobs of equal priority run in this order. A fit is due when it was created; an
-- ingest later than that by a second for a megabyte of its capture, ten minutes at most.
alter table jobs add column due_at bigint not null default 0;
update jobs set due_at = created_at + case when kind <> 'ingest' then 0 else coalesce((
    select case when captures.size_bytes > 600000000 then 600000000 else captures.size_bytes end
    from captures where captures.id = jobs.capture), 0) end;
-- The queue alone, in its order: a claim reads its first rows, however long it is and whatever is known
-- of the table.
create index jobs_by_due on jobs (kind, priority desc, due_at, id) where state = 'queued';
drop index jobs_by_claim;
-- The few that run, which are looked at again and again.
create index jobs_running on jobs (worker) where state = 'running';
