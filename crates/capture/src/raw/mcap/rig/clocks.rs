//! Streams whose stamps come from different clocks: depth by the time of its device, colour by that of
//! the system. The times at which messages were recorded join them.

use bendtwin_core::Finding;

use super::super::index::{Stamped, Topic};

/// Difference of two streams' delays beyond which they have different clocks [ns]: no image is
/// recorded so late.
const MOST_DELAY_NS: i64 = 500_000_000;

/// Rates of two clocks are alike within this share.
const RATE: f64 = 0.2;

/// Delays from stamp to recording of a topic [ns].
struct Delay {
    median_ns: i64,
    /// `true` if its stamps advance as fast as the recording.
    runs: bool,
    /// First and last time of recording [ns].
    recorded: (i64, i64),
}

impl Delay {
    fn of(images: &[Stamped]) -> Option<Self> {
        let mut delays: Vec<i64> = images.iter().map(|i| i.log_ns.saturating_sub(i.ns)).collect();
        delays.sort_unstable();
        let median_ns = *delays.get(delays.len() / 2)?;
        let stamped = images.last()?.ns.saturating_sub(images.first()?.ns) as f64;
        let recorded = images.iter().map(|i| i.log_ns);
        let recorded = (recorded.clone().min()?, recorded.max()?);
        let span = recorded.1.saturating_sub(recorded.0) as f64;
        let runs = (stamped - span).abs() <= RATE * span;
        Some(Self { median_ns, runs, recorded })
    }

    /// `true` if two streams were recorded at one time. What was computed and added later was not,
    /// and has the stamps of the images that it belongs to.
    fn is_beside(&self, other: &Self) -> bool {
        let end = self.recorded.1.min(other.recorded.1);
        let shared = end.saturating_sub(self.recorded.0.max(other.recorded.0));
        let span = |d: &Self| d.recorded.1.saturating_sub(d.recorded.0);
        2 * i128::from(shared) >= i128::from(span(self).min(span(other)))
    }
}

/// Moves the times of streams with other clocks onto that of the stream whose stamps are nearest to
/// the times of recording. The finding names the streams; none if all have one clock.
pub(super) fn join(topics: &mut [&mut Topic]) -> Option<Finding> {
    let delays: Vec<Option<Delay>> = topics.iter().map(|t| Delay::of(&t.images)).collect();
    // A clock that stands still may be near by chance: those that run go before.
    let nearest = |runs: bool| {
        let known = delays.iter().flatten().filter(|delay| delay.runs || !runs);
        known.min_by_key(|delay| delay.median_ns.saturating_abs())
    };
    let reference = nearest(true).or_else(|| nearest(false))?;
    let (mut moved, mut most) = (Vec::new(), 0_i64);
    for (topic, delay) in topics.iter_mut().zip(&delays) {
        let Some(delay) = delay else { continue };
        let off = delay.median_ns.saturating_sub(reference.median_ns);
        if off.saturating_abs() <= MOST_DELAY_NS || !delay.is_beside(reference) {
            continue;
        }
        for image in &mut topic.images {
            image.ns = if delay.runs {
                image.ns.saturating_add(off)
            } else {
                image.log_ns.saturating_sub(reference.median_ns)
            };
        }
        topic.images.sort_by_key(|image| image.ns);
        moved.push(format!("`{}`", topic.name));
        most = if off.saturating_abs() > most.saturating_abs() { off } else { most };
    }
    let named = moved.iter().take(6).cloned().collect::<Vec<_>>().join(", ");
    let more = if moved.len() > 6 { ", ..." } else { "" };
    let message = format!(
        "the stamps of {named}{more} come from another clock, which is {:.3} s off: these streams are joined with the \
         others by the times at which their messages were recorded, which may be wrong by a frame",
        most as f64 * 1e-9
    );
    let advice = "set all drivers to the system's clock (RealSense: `global_time_enabled`); \
                  docs/use/cameras.md#time";
    let finding = Finding { advice: advice.into(), ..Finding::warning("CLOCKS_JOINED", message) };
    (!moved.is_empty()).then_some(finding)
}

#[cfg(test)]
mod tests {
    use super::{
        super::super::{
            messages::{ImageHead, Kind, Wire},
            place::Place,
        },
        *,
    };

    const FRAME: i64 = 33_333_333;
    const NOW: i64 = 1_700_000_000_000_000_000;

    fn topic(name: &str, stamp: impl Fn(i64) -> i64, late_ns: i64) -> Topic {
        let place = Place { part: 0, chunk: None, start: 0, length: 0 };
        let images = (0..30).map(|i| {
            let log_ns = NOW + i * FRAME + late_ns;
            Stamped { ns: stamp(i), log_ns, place }
        });
        let (kind, wire, head) = (Kind::Image, Wire::Ros2, ImageHead::default());
        Topic { name: name.to_owned(), kind, wire, head, images: images.collect() }
    }

    fn joined(mut a: Topic, mut b: Topic) -> (Option<Finding>, Vec<i64>) {
        let finding = join(&mut [&mut a, &mut b]);
        let off = a.images.iter().zip(&b.images).map(|(a, b)| b.ns - a.ns).collect();
        (finding, off)
    }

    #[test]
    fn streams_of_one_clock_stay_as_they_are() {
        let system = |late| topic("/color", move |i| NOW + i * FRAME - late, 4_000_000);
        let (finding, off) = joined(system(0), system(30_000_000));
        assert!(finding.is_none());
        assert!(off.iter().all(|ns| *ns == -30_000_000));
        // The log may lack times: then every stream lacks them alike.
        let mut unlogged = (system(0), system(0));
        for image in unlogged.0.images.iter_mut().chain(&mut unlogged.1.images) {
            image.log_ns = 0;
        }
        assert!(joined(unlogged.0, unlogged.1).0.is_none());
    }

    #[test]
    fn a_stream_by_its_device_is_moved_onto_the_systems_clock() {
        let color = || topic("/color", |i| NOW + i * FRAME, 4_000_000);
        let (finding, off) = joined(color(), topic("/depth", |i| 5 * FRAME + i * FRAME, 6_000_000));
        assert!(finding.unwrap().message.contains("`/depth`"));
        assert!(off.iter().all(|ns| *ns == 2_000_000), "{off:?}");
        // Masks that were computed a day later, with the stamps of their images.
        let mut masks = color();
        masks.images.iter_mut().for_each(|i| i.log_ns += 86_400_000_000_000);
        let (finding, off) = joined(color(), masks);
        assert!(finding.is_none() && off.iter().all(|ns| *ns == 0), "{off:?}");
        // Stamps that count something else than time.
        let (finding, off) = joined(color(), topic("/depth", |i| 1 + i, 5_000_000));
        assert!(finding.is_some());
        assert!(off.iter().all(|ns| *ns == 1_000_000), "{off:?}");
    }
}
