//! Sizes of batches and durations of measurements, as arguments and in reports.

use std::{fmt, str::FromStr};

use serde::Serialize;

/// Size of a batch: instances x frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Size {
    /// Number of instances.
    pub instances: usize,
    /// Frames of each instance.
    pub frames: u32,
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} x {}", self.instances, self.frames)
    }
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let fault =
            || format!("`{text}` is not a size: give instances x frames, for example 4000x200");
        let (instances, frames) = text.split_once('x').ok_or_else(fault)?;
        let size = Self {
            instances: instances.parse().map_err(|_| fault())?,
            frames: frames.parse().map_err(|_| fault())?,
        };
        if size.instances == 0 || size.frames == 0 { Err(fault()) } else { Ok(size) }
    }
}

/// Parses the duration of a measurement [s].
///
/// # Errors
/// If the text is not a number of seconds up to a day.
pub fn seconds(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| format!("`{text}` is not a number of seconds"))?;
    if (0.0..=86_400.0).contains(&value) {
        Ok(value)
    } else {
        Err(format!("{value} s: give 0 to 86400"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_instances_times_frames() {
        assert_eq!("4000x200".parse(), Ok(Size { instances: 4000, frames: 200 }));
        for wrong in ["", "4000", "x", "0x200", "4000x0", "4000x200x3", "-1x2"] {
            assert!(wrong.parse::<Size>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn durations_are_seconds_of_at_most_a_day() {
        assert_eq!(seconds("0.5"), Ok(0.5));
        for wrong in ["", "nan", "-1", "86401", "1 s"] {
            assert!(seconds(wrong).is_err(), "{wrong}");
        }
    }
}
