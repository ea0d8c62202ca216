-- What PostgreSQL has beside the common tables. Run at every start: each statement may be repeated.

-- Wakes whoever waits for a job, on every server, in the transaction that queues one or that ends an
-- ingest, which sets fits free.
create or replace function bendtwin_wake() returns trigger language plpgsql as $$
begin
    perform pg_notify('bendtwin_queue', new.kind);
    return null;
end
$$;
create or replace trigger bendtwin_wake after insert or update of state on jobs for each row
    when (new.state = 'queued'
        or (new.kind = 'ingest' and new.state in ('succeeded', 'failed', 'cancelled')))
    execute function bendtwin_wake();

-- Plans follow statistics, and a queue grows and shrinks many times before a fifth of its rows has
-- changed.
alter table jobs set (autovacuum_analyze_scale_factor = 0.02, autovacuum_vacuum_scale_factor = 0.05);
