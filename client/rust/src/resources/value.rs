//! Fields of messages as typed values: names as ids, times, settings and quality tables as what their JSON says.

mod arrays;

use std::{fmt::Display, str::FromStr, time::Duration};

use bendtwin_core::{
    Fault, Fidelity, Quality,
    ids::{CaptureId, FitId, KeyId, ProjectId, RetentionId, SessionId, ShareId, TwinId, WorkerId},
    quality::Measure,
};
use bendtwin_plan::Origin;
use bendtwin_proto::v1;
use jiff::Timestamp;

use crate::{DeviceMemory, Error, Job, JobState};

/// Declares structs with the fields of a message, each converted to its type by [`FromWire`].
/// `name: Type = other` reads a field of another name.
macro_rules! resource {
    (
        $message:path =>
        $(#[$about:meta])*
        pub struct $name:ident {
            $($(#[$doc:meta])* pub $field:ident: $kind:ty $(= $($wire:ident),+)?,)*
        }
    ) => {
        $(#[$about])*
        pub struct $name {
            $($(#[$doc])* pub $field: $kind,)*
        }

        #[cfg(test)]
        #[allow(dead_code)]
        impl $name {
            /// The names here, and those of the message where they differ.
            pub(crate) const NAMES: &[&str] = &[
                $(stringify!($field), $($(stringify!($wire),)+)?)*
            ];
        }

        impl TryFrom<$message> for $name {
            type Error = $crate::Error;

            fn try_from(message: $message) -> Result<Self, $crate::Error> {
                Ok(Self {
                    $($field: $crate::resources::value::FromWire::from_wire(
                        $crate::resources::value::field!(message, $field $(, $($wire),+)?),
                        stringify!($field),
                    )?,)*
                })
            }
        }

        impl $crate::resources::value::FromWire<Option<$message>> for Option<$name> {
            fn from_wire(wire: Option<$message>, _: &str) -> Result<Self, $crate::Error> {
                wire.map(TryInto::try_into).transpose()
            }
        }

        impl $crate::resources::value::FromWire<Vec<$message>> for Vec<$name> {
            fn from_wire(wire: Vec<$message>, _: &str) -> Result<Self, $crate::Error> {
                wire.into_iter().map(TryInto::try_into).collect()
            }
        }
    };
}

/// A field of a message, or several.
macro_rules! field {
    ($message:ident, $field:ident) => {
        $message.$field
    };
    ($message:ident, $field:ident, $wire:ident) => {
        $message.$wire
    };
    ($message:ident, $field:ident, $($wire:ident),+) => {
        ($($message.$wire),+)
    };
}

pub(crate) use {field, resource};

/// A value made of a field of a message.
pub(crate) trait FromWire<W>: Sized {
    /// The value, of the field of that name.
    fn from_wire(wire: W, name: &str) -> Result<Self, Error>;
}

impl<T> FromWire<T> for T {
    fn from_wire(wire: T, _: &str) -> Result<Self, Error> {
        Ok(wire)
    }
}

impl FromWire<String> for Option<Measure> {
    fn from_wire(name: String, _: &str) -> Result<Self, Error> {
        // One that a newer server knows is unknown here.
        Ok(Measure::parse(&name))
    }
}

/// Ids of names; `None` for an empty name.
macro_rules! ids {
    ($($id:ty),+) => {$(
        impl FromWire<String> for $id {
            fn from_wire(name: String, field: &str) -> Result<Self, Error> {
                parse(&name, field)
            }
        }

        impl FromWire<String> for Option<$id> {
            fn from_wire(name: String, field: &str) -> Result<Self, Error> {
                (!name.is_empty()).then(|| parse(&name, field)).transpose()
            }
        }

        impl FromWire<Vec<String>> for Vec<$id> {
            fn from_wire(names: Vec<String>, field: &str) -> Result<Self, Error> {
                names.iter().map(|name| parse(name, field)).collect()
            }
        }
    )+};
}

ids!(CaptureId, FitId, KeyId, ProjectId, RetentionId, SessionId, ShareId, TwinId, WorkerId);

fn parse<T: FromStr<Err: Display>>(text: &str, field: &str) -> Result<T, Error> {
    text.parse().map_err(|fault| Error::malformed(format!("{field}: {fault}")))
}

impl FromWire<String> for Option<String> {
    fn from_wire(text: String, _: &str) -> Result<Self, Error> {
        Ok(Some(text).filter(|text| !text.is_empty()))
    }
}

impl FromWire<String> for serde_json::Value {
    fn from_wire(json: String, field: &str) -> Result<Self, Error> {
        if json.is_empty() { Ok(Self::Null) } else { parse(&json, field) }
    }
}

impl FromWire<String> for Quality {
    fn from_wire(json: String, _: &str) -> Result<Self, Error> {
        if json.is_empty() {
            return Ok(Self::default());
        }
        serde_json::from_str(&json).map_err(Error::malformed)
    }
}

impl FromWire<Option<prost_types::Timestamp>> for Option<Timestamp> {
    fn from_wire(wire: Option<prost_types::Timestamp>, _: &str) -> Result<Self, Error> {
        wire.map(|t| Timestamp::new(t.seconds, t.nanos).map_err(Error::malformed)).transpose()
    }
}

impl FromWire<Option<prost_types::Timestamp>> for Timestamp {
    fn from_wire(wire: Option<prost_types::Timestamp>, name: &str) -> Result<Self, Error> {
        Option::from_wire(wire, name)?.ok_or_else(|| missing(name))
    }
}

impl FromWire<Option<v1::Job>> for Job {
    fn from_wire(wire: Option<v1::Job>, name: &str) -> Result<Self, Error> {
        wire.ok_or_else(|| missing(name))?.try_into()
    }
}

impl FromWire<i32> for JobState {
    fn from_wire(wire: i32, _: &str) -> Result<Self, Error> {
        let state = Self::try_from(wire).ok().filter(|state| *state != Self::Unspecified);
        state.ok_or_else(|| Error::malformed(format!("job state {wire}")))
    }
}

/// A fidelity that this build does not know counts as exact.
impl FromWire<i32> for Fidelity {
    fn from_wire(wire: i32, _: &str) -> Result<Self, Error> {
        Ok(match v1::Fidelity::try_from(wire) {
            Ok(v1::Fidelity::Fast) => Self::Fast,
            Ok(v1::Fidelity::Planner) => Self::Planner,
            Ok(v1::Fidelity::Exact | v1::Fidelity::Unspecified) | Err(_) => Self::Exact,
        })
    }
}

impl FromWire<i32> for Origin {
    fn from_wire(wire: i32, _: &str) -> Result<Self, Error> {
        Ok(match v1::plan_update::Origin::try_from(wire) {
            Ok(v1::plan_update::Origin::Mean) => Self::Mean,
            Ok(v1::plan_update::Origin::Sample) => Self::Sample,
            _ => Self::Nominal,
        })
    }
}

impl FromWire<f64> for Duration {
    fn from_wire(seconds: f64, _: &str) -> Result<Self, Error> {
        Self::try_from_secs_f64(seconds).map_err(Error::malformed)
    }
}

impl FromWire<Option<v1::Fault>> for Option<Fault> {
    fn from_wire(wire: Option<v1::Fault>, _: &str) -> Result<Self, Error> {
        Ok(wire.as_ref().map(Fault::from))
    }
}

impl FromWire<Vec<v1::Fault>> for Vec<Fault> {
    fn from_wire(wire: Vec<v1::Fault>, _: &str) -> Result<Self, Error> {
        Ok(wire.iter().map(Fault::from).collect())
    }
}

/// Without a message the default: requirements that any worker fulfils, no quotas, zeros.
macro_rules! defaults {
    ($($message:ty),+) => {$(
        impl FromWire<Option<$message>> for $message {
            fn from_wire(wire: Option<$message>, _: &str) -> Result<Self, Error> {
                Ok(wire.unwrap_or_default())
            }
        }
    )+};
}

defaults!(
    v1::KeyQuotas,
    v1::Residual,
    v1::StoredBytes,
    v1::Tracking,
    v1::WorkerRequirements,
    v1::roll_out_response::Timing
);

/// Bytes in use and in total; a total of zero is unknown.
impl FromWire<(u64, u64)> for Option<DeviceMemory> {
    fn from_wire((used_bytes, total_bytes): (u64, u64), _: &str) -> Result<Self, Error> {
        Ok((total_bytes > 0).then_some(DeviceMemory { used_bytes, total_bytes }))
    }
}

fn missing(name: &str) -> Error {
    Error::malformed(format!("{name} is missing"))
}

#[cfg(test)]
mod tests;
