//! The speed of a worker, measured by its recent work.

/// Assumed until there are measurements: a core of a CPU [element substeps a second].
const ASSUMED: f64 = 4e7;
/// Weight of the assumption [s of measurements].
const ASSUMED_S: f64 = 0.125;
/// Time over which measurements are averaged [s of computing].
const REMEMBERED_S: f64 = 60.0;
/// Bounds on the speed: a worker's word is not to make all rollouts small or large for ever.
const BOUNDS: [f64; 2] = [1e5, 1e14];

/// Work done, and the time that it took.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rate {
    work: f64,
    seconds: f64,
}

impl Default for Rate {
    fn default() -> Self {
        Self { work: ASSUMED * ASSUMED_S, seconds: ASSUMED_S }
    }
}

impl Rate {
    /// Element substeps a second.
    pub(super) fn per_second(&self) -> f64 {
        (self.work / self.seconds).clamp(BOUNDS[0], BOUNDS[1])
    }

    /// Notes work and the time that it took; older measurements fade.
    pub(super) fn measured(&mut self, work: f64, seconds: f64) {
        if !(seconds > 0.0 && seconds.is_finite() && work > 0.0 && work.is_finite()) {
            return;
        }
        let keep = REMEMBERED_S / (self.seconds + seconds).max(REMEMBERED_S);
        self.work = (self.work + work) * keep;
        self.seconds = (self.seconds + seconds) * keep;
    }
}
