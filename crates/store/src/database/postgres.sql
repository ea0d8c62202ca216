-- What PostgreSQL has beside the common tables. Run at every start: each statement may be repeated.

-- Wakes whoever waits for a job, on every server, in the transaction that queues one or that ends one: the
-- end of an ingest sets fits free, and that of any job may bring its owner below a bound.
create or replace function bendtwin_wake() returns trigger language plpgsql as $$
begin
    perform pg_notify('bendtwin_queue', new.kind);
    return null;
end
$$;
create or replace trigger bendtwin_wake after insert or update of state on jobs for each row
    when (new.state in ('queued', 'succeeded', 'failed', 'cancelled'))
    execute function bendtwin_wake();

-- Tells every server of changed jobs, for those who watch them.
create or replace function bendtwin_tell_job() returns trigger language plpgsql as $$
begin
    perform pg_notify('bendtwin_jobs', old.kind || '/' || old.id);
    return null;
end
$$;
create or replace trigger bendtwin_tell_job after update on jobs for each row
    when (old.revision is distinct from new.revision) execute function bendtwin_tell_job();
create or replace trigger bendtwin_tell_deleted_job after delete on jobs for each row
    execute function bendtwin_tell_job();

-- Tells every server of workers that come, go, or are to end.
create or replace function bendtwin_tell_workers() returns trigger language plpgsql as $$
begin
    perform pg_notify('bendtwin_workers', '');
    return null;
end
$$;
create or replace trigger bendtwin_tell_workers after insert or delete or update of endpoint, draining on workers
    for each statement execute function bendtwin_tell_workers();

-- Plans follow statistics, and a queue grows and shrinks many times before a fifth of its rows has
-- changed.
alter table jobs set (autovacuum_analyze_scale_factor = 0.02, autovacuum_vacuum_scale_factor = 0.05);
