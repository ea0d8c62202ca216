//! Waiting for states instead of sleeping, and not too many worlds at a time.

use std::time::Duration;

use tokio::{
    sync::{Semaphore, SemaphorePermit},
    time::{Instant, sleep, timeout},
};

const POLL: Duration = Duration::from_millis(10);

/// Worlds that may live at once: fits want the cores for themselves.
const WORLDS: u32 = 2;
static SLOTS: Semaphore = Semaphore::const_new(WORLDS as usize);

/// Waits for this world's turn.
pub(crate) async fn turn() -> SemaphorePermit<'static> {
    SLOTS.acquire().await.unwrap()
}

/// Waits until no other world lives: for stories in which time is measured.
pub(crate) async fn alone() -> SemaphorePermit<'static> {
    SLOTS.acquire_many(WORLDS).await.unwrap()
}

/// Asks again and again until there is an answer; fails the test after `deadline`.
pub(crate) async fn until<T>(
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
pub(crate) async fn within<T>(
    what: &str,
    deadline: Duration,
    future: impl Future<Output = T>,
) -> T {
    timeout(deadline, future).await.unwrap_or_else(|_| panic!("{what} took over {deadline:?}"))
}
