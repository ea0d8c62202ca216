//! Refusals in the audit: of calls for a scope, of keys that are no longer valid, and of strangers
//! without a valid key. A client may repeat such a call without end, so for a caller and a call one
//! line is written immediately, and after that one in ten minutes at most, with the number of
//! refusals since the previous one.

use std::{
    collections::HashMap,
    net::IpAddr,
    sync::{Arc, Mutex, PoisonError},
    time::{Duration, Instant},
};

use bendtwin_core::ids::KeyId;

/// Least time between two lines about a caller and a call.
const INTERVAL: Duration = Duration::from_secs(600);
/// Most callers and calls that are remembered. Beyond this number nothing is written until some are
/// old.
const MOST: usize = 4096;

/// Refused calls, by caller and call. Clones share them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Refusals(Arc<Mutex<HashMap<(Refused, String), Record>>>);

/// The caller who was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Refused {
    /// The holder of a key; `None` with the client token.
    Holder(Option<KeyId>),
    /// Someone of a network; none if that is not known.
    Stranger(Option<IpAddr>),
}

#[derive(Debug)]
struct Record {
    at: Instant,
    /// Refusals since then.
    since: u64,
}

impl Refusals {
    /// Notes a refusal at a time. Returns the number to write, if it is time to write.
    pub(crate) fn note(&self, refused: Refused, call: &str, now: Instant) -> Option<u64> {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let is_old = |record: &Record| now.saturating_duration_since(record.at) >= INTERVAL;
        if let Some(record) = all.get_mut(&(refused, call.to_owned())) {
            record.since += 1;
            if !is_old(record) {
                return None;
            }
            let count = record.since;
            *record = Record { at: now, since: 0 };
            return Some(count);
        }
        if all.len() >= MOST {
            all.retain(|_, record| !is_old(record));
        }
        if all.len() >= MOST {
            return None;
        }
        all.insert((refused, call.to_owned()), Record { at: now, since: 0 });
        Some(1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeated_refusals_are_counted_and_reported_in_ten_minutes() {
        let (refusals, start) = (Refusals::default(), Instant::now());
        let key = Refused::Holder(Some(KeyId::generate()));
        assert_eq!(refusals.note(key, "POST /v1/fits", start), Some(1));
        for second in 0..599 {
            let now = start + Duration::from_secs(second);
            assert_eq!(refusals.note(key, "POST /v1/fits", now), None);
        }
        assert_eq!(refusals.note(key, "GET /v1/fits", start), Some(1), "another call");
        assert_eq!(
            refusals.note(Refused::Holder(None), "POST /v1/fits", start),
            Some(1),
            "another caller"
        );
        assert_eq!(refusals.note(key, "POST /v1/fits", start + INTERVAL), Some(600));
        assert_eq!(refusals.note(key, "POST /v1/fits", start + INTERVAL), None);
    }

    #[test]
    fn a_limited_number_is_remembered_and_old_ones_are_dropped() {
        let (refusals, start) = (Refusals::default(), Instant::now());
        let record = |now| {
            let key = || Refused::Holder(Some(KeyId::generate()));
            let call = |_| refusals.note(key(), "POST /v1/fits", now);
            (0..2 * MOST).filter_map(call).count()
        };
        assert_eq!(record(start), MOST);
        assert_eq!(record(start + INTERVAL), MOST);
    }
}
