//! When a running fit makes way for another owner's: an owner that has none running is not to wait for
//! the end of another's. A report of its worker asks, and the worker hands the fit back at the next
//! checkpoint, from which it resumes in its turn.
//!
//! A fit makes way after a slice. Another that has run before takes its turn only after a longer slice,
//! so that long fits of several owners do not spend their time on being read again. A fit that makes no
//! checkpoint within a slice of being asked is cut off: then the time until its next one doubles from
//! attempt to attempt, so that it gets there, however long that takes.

use std::time::Duration;

use super::{
    Claimant, Kind,
    claim::{HAS_ROOM, QUEUES, allowed, push_allowed},
    row::Row,
};
use crate::{
    Result,
    sql::{Builder, Query, Transaction, query_scalar},
};

/// Slices after which a fit makes way for one that has run before.
const LONG: u32 = 15;
/// Most times that the time until a checkpoint doubles.
const MOST_DOUBLINGS: i64 = 16;
/// Slices for which a fit that was asked to make way, and has not, counts as one that will.
const PATIENCE: u32 = 3;

/// How running fits share a worker with those that wait for it.
#[derive(Clone, Copy, Debug)]
pub struct Turns<'a> {
    /// The worker of the fit.
    pub claimant: &'a Claimant,
    /// Time for which a fit runs before it makes way.
    pub slice: Duration,
}

/// Result of the question whether a fit is to make way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Way {
    /// The slice time at which it was asked, if it is to [us].
    pub(super) asked_us: Option<i64>,
    /// Time until it is to be handed back without a checkpoint.
    pub(super) within: Option<Duration>,
}

/// The question for a running job `row` whose slice is `slice_us` long.
pub(super) async fn way(
    tx: &mut Transaction,
    row: &Row,
    slice_us: i64,
    turns: Turns<'_>,
) -> Result<Way> {
    let slice = as_micros(turns.slice);
    if slice_us < slice || row.kind()? != Kind::Fit {
        return Ok(Way::default());
    }
    let requirements = allowed(tx, Kind::Fit, &turns.claimant.capabilities).await?;
    if requirements.is_empty() {
        return Ok(Way::default());
    }
    let is_long = slice_us >= slice.saturating_mul(i64::from(LONG));
    let waiting = waiting(&row.owner, row.priority, is_long, &requirements);
    let (waiting,): (i64,) = waiting.fetch_one(&mut *tx).await?;
    let others = match row.yield_us {
        Some(_) => 0,
        None => asked(tx, slice).await?,
    };
    if waiting <= others {
        return Ok(Way::default());
    }
    let asked_us = row.yield_us.unwrap_or(slice_us);
    let doublings = (row.fruitless - 1).clamp(0, MOST_DOUBLINGS);
    let end = asked_us.saturating_add(slice.saturating_mul(1 << doublings));
    let within = Duration::from_micros(end.saturating_sub(slice_us).max(0) as u64);
    Ok(Way { asked_us: Some(asked_us), within: Some(within) })
}

/// The statement that counts the owners without a running fit whose next fit would be claimed, of this
/// priority or a higher one; unless `is_long`, only those whose next fit has not run yet.
pub(crate) fn waiting(owner: &str, priority: i64, is_long: bool, allowed: &[String]) -> Query {
    let mut sql = Builder::new("with recursive allowed (requirements) as (values ");
    // The numbers are those of a claim.
    sql.bind(owner).bind(priority).bind(i64::from(is_long)).bind(Kind::Fit.as_str());
    push_allowed(&mut sql, allowed);
    sql.push(QUEUES).push(
        "select count(distinct owner) from firsts
         where id is not null and owner <> $1
             and (select priority from jobs as f where f.id = firsts.id) >= $2
             and ($3 = 1 or (select started_at from jobs as f where f.id = firsts.id) is null)
             and (select count(*) from jobs as r
                 where r.state = 'running' and r.kind = $4 and r.owner = firsts.owner) = 0
             and ",
    );
    sql.push(HAS_ROOM);
    sql.build()
}

/// Number of fits that were asked to make way and are about to.
async fn asked(tx: &mut Transaction, slice: i64) -> Result<i64> {
    query_scalar(
        "select count(*) from jobs
         where state = 'running' and kind = 'fit' and yield_us is not null
             and slice_us - yield_us < $1",
    )
    .bind(slice.saturating_mul(i64::from(PATIENCE)))
    .fetch_one(tx)
    .await
}

/// Microseconds of a time, as the database has it.
pub(super) fn as_micros(time: Duration) -> i64 {
    i64::try_from(time.as_micros()).unwrap_or(i64::MAX)
}
