//! A separate wall clock for the server and its workers, which steps while they run. The preloaded
//! library is `clock.c`.

use std::{path::PathBuf, process::Command};

use anyhow::Context as _;

/// The clock of some processes.
#[derive(Clone, Debug)]
pub(crate) struct Clock {
    library: PathBuf,
    /// The seconds that are added to the true time, which the processes map into their memory.
    file: PathBuf,
}

impl Clock {
    /// A clock that shows the true time.
    pub(crate) fn new(library: PathBuf, file: PathBuf) -> anyhow::Result<Self> {
        std::fs::write(&file, 0i64.to_ne_bytes())?;
        Ok(Self { library, file })
    }

    /// Makes a process that is started use this clock, and all that it starts in turn.
    pub(crate) fn preload(&self, command: &mut Command) {
        command.env("LD_PRELOAD", &self.library).env("CHAOS_CLOCK", &self.file);
    }

    /// Steps the clock to `step_s` seconds from the true time.
    pub(crate) fn set(&self, step_s: i64) -> anyhow::Result<()> {
        use std::os::unix::fs::FileExt as _;
        // Eight aligned bytes in one write, in place: the file is mapped.
        let file = std::fs::OpenOptions::new().write(true).open(&self.file);
        file.and_then(|file| file.write_all_at(&step_s.to_ne_bytes(), 0)).context("set the clock")
    }

    /// True if a process sees the steps of this clock.
    pub(crate) fn works(&self) -> anyhow::Result<bool> {
        let now = || -> anyhow::Result<i64> {
            let mut date = Command::new("date");
            self.preload(&mut date);
            Ok(String::from_utf8_lossy(&date.arg("+%s").output()?.stdout).trim().parse()?)
        };
        let before = now()?;
        self.set(-86_400)?;
        let after = now()?;
        self.set(0)?;
        Ok(before - after > 86_000)
    }
}
