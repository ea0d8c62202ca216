-- Time for which a job has run at workers, over all attempts [us]; of it the time since the last claim, and the
-- time since its progress or its checkpoint last changed.
alter table jobs add column run_us bigint not null default 0;
alter table jobs add column slice_us bigint not null default 0;
alter table jobs add column idle_us bigint not null default 0;
-- The slice_us at which it was asked to make way for another owner; null: it was not.
alter table jobs add column yield_us bigint;
-- Claims since its last new checkpoint that ended because it made way: each doubles the time until the next
-- checkpoint.
alter table jobs add column fruitless bigint not null default 0;
-- When its owner was served last: the last claim, or the end of the attempt if it made way.
alter table jobs add column served_at bigint;
-- Bounds of the key that created it: running jobs of its owner, and time for which it may run [s]; null: none.
alter table jobs add column max_running bigint;
alter table jobs add column max_run_s bigint;
create index jobs_by_service on jobs (kind, owner, served_at);

-- Null: no bound; of the priority, that of the key's scopes.
alter table keys add column max_running_jobs bigint;
alter table keys add column max_fit_run_s bigint;
alter table keys add column max_priority bigint;
