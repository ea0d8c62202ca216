//! Waiting for states instead of sleeping, and a limit on clusters at a time.

use std::time::Duration;

use tokio::{
    sync::{Semaphore, SemaphorePermit},
    time::{Instant, sleep, timeout},
};

const POLL: Duration = Duration::from_millis(10);

/// Most clusters at a time: fits need the cores for themselves.
const CLUSTERS: u32 = 2;
static SLOTS: Semaphore = Semaphore::const_new(CLUSTERS as usize);

/// Waits for a slot beside other clusters.
pub async fn shared_slot() -> SemaphorePermit<'static> {
    SLOTS.acquire().await.unwrap()
}

/// Waits until no other cluster runs, for tests that measure time.
pub async fn all_slots() -> SemaphorePermit<'static> {
    SLOTS.acquire_many(CLUSTERS).await.unwrap()
}

/// Asks again and again until there is an answer; fails the test after `deadline`.
pub async fn until<T>(
    what: &str,
    deadline: Duration,
    mut probe: impl AsyncFnMut() -> Option<T>,
) -> T {
    let end = Instant::now() + deadline;
    loop {
        if let Some(answer) = probe().await {
            return answer;
        }
        assert!(Instant::now() < end, "waited {deadline:?} for {what}");
        sleep(POLL).await;
    }
}

/// Fails the test if the future takes longer.
pub async fn within<T>(what: &str, deadline: Duration, future: impl Future<Output = T>) -> T {
    timeout(deadline, future).await.unwrap_or_else(|_| panic!("{what} took over {deadline:?}"))
}
