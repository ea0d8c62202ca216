-- Worker that a fit asks for, as JSON with sorted labels; empty: any.
alter table jobs add column requirements text not null default '';
-- Words that a worker was started with, as a JSON array.
alter table workers add column labels text not null default '[]';
-- The queue by owner. A claim reads the first job of each owner, however many there are, and whatever is
-- known of the table.
create index jobs_by_queue on jobs (kind, requirements, owner, priority desc, due_at, id) where state = 'queued';
drop index jobs_by_due;
-- When an owner was served last.
create index jobs_by_start on jobs (kind, owner, started_at);
-- The few that run, by owner: a claim counts them.
create index jobs_running_by_owner on jobs (kind, owner, state) where state = 'running';
