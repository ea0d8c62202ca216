//! Writes of workers, recorded by both sides: the database notes each checkpoint and each change of
//! state with the epoch of the current lease, and workers log their accepted writes with the epoch
//! of theirs. A write accepted from a worker whose lease was over shows as one that the database
//! noted under another epoch.

use std::{collections::BTreeMap, sync::Arc};

use anyhow::Context as _;

use crate::{supervised::Supervised, tally::Tally};

/// Filter of the logs of workers: what was accepted of checkpoints is among the details.
pub(super) const LOG: &str = "info,bendtwin_worker::job=debug";

/// Makes the database note writes. A queued job in the trash has the state `cancelled`, which is no end: it is
/// queued again when it is restored.
pub(super) const RECORD: &str = "
    create table chaos_writes (number bigserial, job text, epoch bigint, what text);
    create function chaos_write() returns trigger language plpgsql as $$ begin
        insert into chaos_writes (job, epoch, what)
            values (new.id, new.lease_epoch, coalesce(tg_argv[0], new.state));
        return null;
    end $$;
    create trigger chaos_checkpoint after update of checkpoint on jobs for each row
        when (new.state = 'running' and new.checkpoint is not null)
        execute function chaos_write('checkpoint');
    create trigger chaos_state after update of state on jobs for each row
        when (old.state <> new.state and new.restored_state is null)
        execute function chaos_write();";

/// Notes, in order.
pub(super) const NOTED: &str = "select job, epoch, what from chaos_writes order by number";

/// Words that a worker logs when a write of it was refused because its lease was over.
const REFUSED: [&str; 3] = [
    "the lease is stale: another worker has the job",
    "the lease is stale: ",
    "the job is gone, or another worker has it",
];

/// A lease: id of the job, and epoch.
type Lease = (String, u64);

/// Compares both.
pub(super) fn check(noted: &str, workers: &[Arc<Supervised>], tally: &Tally) -> anyhow::Result<()> {
    let mut checkpoints: BTreeMap<Lease, u64> = BTreeMap::new();
    let mut ends: BTreeMap<String, Vec<(u64, String)>> = BTreeMap::new();
    for line in noted.lines() {
        let mut columns = line.split('|');
        let mut next = || columns.next().with_context(|| format!("noted: {line}"));
        let (job, epoch, what) = (next()?.to_owned(), next()?.parse()?, next()?.to_owned());
        match what.as_str() {
            "checkpoint" => *checkpoints.entry((job, epoch)).or_default() += 1,
            "succeeded" | "failed" | "cancelled" => {
                ends.entry(job).or_default().push((epoch, what));
            }
            _ => {}
        }
    }
    for (job, ends) in ends.iter().filter(|(_, ends)| ends.len() > 1) {
        tally.broken("a job ends once", format_args!("{job}: {ends:?}"));
    }
    let mut accepted: BTreeMap<Lease, u64> = BTreeMap::new();
    for worker in workers {
        let log = std::fs::read(worker.log_file())?;
        for line in String::from_utf8_lossy(&log).lines() {
            if REFUSED.iter().any(|words| line.contains(words)) {
                tally.count("leases: late writes that were refused");
            }
            let Some((job, epoch)) = lease(line) else { continue };
            if line.contains("checkpoint saved") {
                *accepted.entry((job, epoch)).or_default() += 1;
            } else if line.contains("fit succeeded") || line.contains("ingest ended") {
                tally.count("leases: results that were accepted");
                let is_of_end =
                    |(last, state): &(u64, String)| *last == epoch && state == "succeeded";
                if !ends.get(&job).is_some_and(|ends| ends.iter().any(is_of_end)) {
                    let case = format_args!("{}: the result of {job}, {epoch}", worker.name());
                    tally.broken(STALE, case);
                }
            }
        }
    }
    for (lease, count) in accepted {
        // The answer to one that was noted may have been lost.
        let noted = checkpoints.get(&lease).copied().unwrap_or(0);
        if count > noted {
            tally.broken(STALE, format_args!("{lease:?}: {count} checkpoints, {noted} noted"));
        }
        for _ in 0..count {
            tally.count("leases: checkpoints that were accepted");
        }
    }
    Ok(())
}

const STALE: &str = "a worker whose lease is over writes nothing";

/// The lease that a line of a worker's log is about.
fn lease(line: &str) -> Option<Lease> {
    let value = |name: &str| {
        let (_, rest) = line.split_once(name)?;
        rest.split([' ', '}']).next().map(|value| value.trim_matches('"'))
    };
    let job = value("job=")?.rsplit('/').next()?.to_owned();
    Some((job, value("epoch=")?.parse().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lease_of_a_line_is_read() {
        let line =
            r#"INFO fit{job="fits/0199-a" epoch=3 request_id=""}: fit succeeded twin="twins/1""#;
        assert_eq!(lease(line), Some(("0199-a".to_owned(), 3)));
        assert_eq!(lease("INFO worker ready"), None);
    }
}
