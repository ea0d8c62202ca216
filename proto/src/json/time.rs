//! Times as messages and as JSON: RFC 3339 in UTC, with as many digits of a second as it takes.

use jiff::Timestamp;
use serde::{
    Serialize, Serializer,
    de::{Error, MapAccess},
    ser::Error as _,
};

/// A time to be written.
pub(super) struct Time(pub(super) prost_types::Timestamp);

impl Serialize for Time {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let time = Timestamp::new(self.0.seconds, self.0.nanos).map_err(S::Error::custom)?;
        serializer.collect_str(&time)
    }
}

/// A time, if one is given.
pub(super) fn time<'de, A: MapAccess<'de>>(
    map: &mut A,
) -> Result<Option<prost_types::Timestamp>, A::Error> {
    let Some(text) = map.next_value::<Option<String>>()? else { return Ok(None) };
    let time: Timestamp = text
        .parse()
        .map_err(|_| A::Error::custom("is not an RFC 3339 time, such as 2030-01-31T12:00:00Z"))?;
    Ok(Some(timestamp(time)))
}

/// A time as a message.
pub fn timestamp(time: Timestamp) -> prost_types::Timestamp {
    // Whole nanoseconds since the epoch, split so that nanos are never negative.
    let nanos = time.as_nanosecond();
    const SECOND: i128 = 1_000_000_000;
    // Times end with the year 9999, so neither is cut.
    prost_types::Timestamp {
        seconds: nanos.div_euclid(SECOND) as i64,
        nanos: nanos.rem_euclid(SECOND) as i32,
    }
}
