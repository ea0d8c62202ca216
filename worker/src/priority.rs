//! Priority of threads with the operating system. A closed loop of small rollouts passes a dozen
//! threads of clients, server and worker on its way; beside a fit that keeps all cores busy each of
//! them would wait for a core as long as the fit's threads have a turn. So these have a low priority:
//! a thread that wakes up takes their core immediately.

/// Niceness of a fit's threads. One that competes with an ordinary thread still gets a tenth of its
/// core.
#[cfg(target_os = "linux")]
const FIT_NICENESS: i32 = 10;

/// Gives this thread the priority of fits permanently: raising it again takes a privilege. Threads
/// that it starts have it too. Does nothing where the system has no priorities of single threads.
pub(crate) fn as_fit() {
    #[cfg(target_os = "linux")]
    {
        use std::cell::Cell;

        use rustix::process::{getpriority_process, setpriority_process};

        thread_local! {
            static IS_SET: Cell<bool> = const { Cell::new(false) };
        }
        if IS_SET.replace(true) {
            return;
        }
        // On Linux this is the priority of the calling thread, despite the names.
        let set = getpriority_process(None)
            .and_then(|own| setpriority_process(None, own.max(FIT_NICENESS)));
        if let Err(error) = set {
            tracing::debug!(%error, "the priority of a fit's thread is unchanged");
        }
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use rustix::process::getpriority_process;

    use super::*;

    #[test]
    fn a_thread_of_a_fit_is_nice_and_no_other() {
        let before = getpriority_process(None).unwrap();
        let fit = std::thread::spawn(|| {
            as_fit();
            let own = getpriority_process(None).unwrap();
            let child = std::thread::spawn(|| getpriority_process(None).unwrap());
            (own, child.join().unwrap())
        });
        let expected = before.max(FIT_NICENESS);
        assert_eq!(fit.join().unwrap(), (expected, expected));
        assert_eq!(getpriority_process(None).unwrap(), before);
    }
}
