//! The schedule of faults: what happens when, drawn from the seed before anything starts. Each
//! class has a separate random stream, so that leaving out classes does not change the others.

use std::{fmt, time::Duration};

use clap::ValueEnum;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

/// A class of faults.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub(crate) enum Class {
    /// kill -9 of servers, workers and the processes that read captures, and orderly restarts.
    Kills,
    /// Servers and workers that stand still for seconds.
    Pauses,
    /// Steps of the clock.
    Clock,
    /// Full disks.
    Disk,
    /// Hostile captures, twins and rollout requests.
    Hostile,
    /// Clients that begin and then stall.
    Silent,
    /// Clients that ask for as much as they may, and more.
    Greedy,
    /// Partitions of the network of a fleet.
    Partitions,
    /// Ends and pauses of the database and the bucket of a fleet.
    Outages,
    /// Workers that stand still until another has their job, and then resume.
    Zombies,
}

impl Class {
    /// Classes for one server.
    pub(crate) const OF_SERVER: [Self; 7] = [
        Self::Kills,
        Self::Pauses,
        Self::Clock,
        Self::Disk,
        Self::Hostile,
        Self::Silent,
        Self::Greedy,
    ];
    /// Classes for a fleet.
    pub(crate) const OF_FLEET: [Self; 6] =
        [Self::Kills, Self::Pauses, Self::Clock, Self::Partitions, Self::Outages, Self::Zombies];

    /// Faults in a minute of one server.
    fn rate(self) -> f64 {
        match self {
            Self::Kills => 8.0,
            Self::Pauses | Self::Silent | Self::Greedy => 2.0,
            Self::Clock => 3.0,
            Self::Disk => 1.5,
            Self::Hostile => 20.0,
            Self::Partitions | Self::Outages | Self::Zombies => 0.0,
        }
    }

    /// Share in the faults of a fleet; zombies are counted for themselves.
    fn share(self) -> f64 {
        match self {
            Self::Kills => 0.4,
            Self::Partitions => 0.25,
            Self::Pauses => 0.2,
            Self::Outages => 0.1,
            Self::Clock => 0.05,
            Self::Disk | Self::Hostile | Self::Silent | Self::Greedy | Self::Zombies => 0.0,
        }
    }
}

/// Number of faults of a class.
pub(crate) trait Counts {
    fn count(&self, class: Class) -> u32;
}

/// Faults of one server, at a rate per minute.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Paced {
    pub(crate) length: Duration,
    /// Multiple of the usual number.
    pub(crate) pace: f64,
}

impl Counts for Paced {
    fn count(&self, class: Class) -> u32 {
        (self.pace * class.rate() * self.length.as_secs_f64() / 60.0).round().max(1.0) as u32
    }
}

/// Faults of a fleet, by number.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Counted {
    pub(crate) faults: u32,
    pub(crate) zombies: u32,
}

impl Counts for Counted {
    fn count(&self, class: Class) -> u32 {
        match class {
            Class::Zombies => self.zombies,
            _ => (class.share() * f64::from(self.faults)).round() as u32,
        }
    }
}

impl fmt::Display for Class {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Kills => "kills",
            Self::Pauses => "pauses",
            Self::Clock => "clock",
            Self::Disk => "disk",
            Self::Hostile => "hostile",
            Self::Silent => "silent",
            Self::Greedy => "greedy",
            Self::Partitions => "partitions",
            Self::Outages => "outages",
            Self::Zombies => "zombies",
        })
    }
}

/// A kind of process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Victim {
    Server,
    Worker,
    Reader,
}

/// Silence of a client.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Silence {
    /// Connections with the first half of the HTTP/2 preface.
    HalfPrefaces,
    /// Requests whose bodies are announced and do not come.
    NoBodies,
    /// Streams of rollouts that are not read.
    UnreadStreams,
    /// Streams of controls of a session that send nothing, or invalid messages.
    Controls,
}

/// Wish of a greedy client.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Greed {
    /// Large batches of rollouts, several at a time.
    Batches,
    /// A body of JSON with tens of megabytes of numbers.
    LargeJson,
    /// A short request for a reply of gigabytes.
    LargeReply,
    /// Uploads that are begun and left.
    Uploads,
    /// Sessions of as many slots as there may be, which are opened and left.
    Sessions,
}

/// Partition around a machine of a fleet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cut {
    /// From everything.
    Machine,
    /// From the database.
    Database,
    /// From the bucket.
    Objects,
    /// From the other machine.
    Machines,
    /// From the other machine, which still reaches it.
    OneWay,
    /// From what the database answers.
    Answers,
}

/// Failure of a service of a fleet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outage {
    /// The database crashes, and is started again.
    DatabaseEnds,
    /// The database stands still.
    DatabaseStops,
    /// The bucket stands still.
    ObjectsStop,
}

/// A fault.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Fault {
    Kill(Victim),
    /// SIGTERM for the server, and a new start.
    Restart,
    Pause(Victim, Duration),
    /// Step of the clock to this many seconds from the true time.
    Clock(i64),
    /// A full disk for this time. If fresh, right after an orderly restart, when the database has
    /// to make the file of its log. If pressed, space that becomes free is taken immediately.
    FullDisk {
        held: Duration,
        fresh: bool,
        pressed: bool,
    },
    /// The hostile file of this number.
    Hostile(u64),
    Silent(Silence, Duration),
    Greedy(Greed),
    Partition(Cut, Duration),
    Outage(Outage, Duration),
    /// A worker that stands still for this time longer than its lease.
    Zombie(Duration),
}

/// A fault and its time from the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Event {
    pub(crate) at: Duration,
    pub(crate) class: Class,
    /// A number for choices that are made when it happens.
    pub(crate) chance: u64,
    pub(crate) fault: Fault,
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:8.2} s  {:8} {:?}", self.at.as_secs_f64(), self.class.to_string(), self.fault)
    }
}

/// The faults of a run, by time. Every class has at least one, since the run is cut into as many
/// equal parts as there are faults of a class, with one in each.
pub(crate) fn schedule(
    seed: u64,
    length: Duration,
    counts: &dyn Counts,
    classes: &[Class],
) -> Vec<Event> {
    let mut events = Vec::new();
    for class in classes {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(*class as u64 + 1);
        let count = counts.count(*class);
        for number in 0..count {
            let within = random.random_range(0.0..0.9);
            let at = length.mul_f64((f64::from(number) + within) / f64::from(count));
            let fault = fault(*class, number, &mut random);
            events.push(Event { at, class: *class, chance: random.random(), fault });
        }
    }
    events.sort_by_key(|event| event.at);
    events
}

fn fault(class: Class, number: u32, random: &mut ChaCha8Rng) -> Fault {
    let mut seconds = |from: f64, to: f64| Duration::from_secs_f64(random.random_range(from..to));
    match class {
        Class::Kills => match random.random_range(0..16) {
            0 => Fault::Restart,
            1..=4 => Fault::Kill(Victim::Server),
            5..=8 => Fault::Kill(Victim::Reader),
            _ => Fault::Kill(Victim::Worker),
        },
        Class::Pauses => {
            let held = seconds(1.0, 8.0);
            Fault::Pause(if random.random() { Victim::Server } else { Victim::Worker }, held)
        }
        Class::Clock => {
            let steps = [-86_400, -3_600, -7, 0, 7, 3_600, 6 * 3_600];
            Fault::Clock(steps[random.random_range(0..steps.len())])
        }
        Class::Disk => Fault::FullDisk {
            held: seconds(3.0, 8.0),
            fresh: number.is_multiple_of(2),
            pressed: number % 3 == 1,
        },
        Class::Hostile => Fault::Hostile(u64::from(number)),
        Class::Silent => {
            // Longer than an honest client waits: clients that the silent lock out are found.
            let held = seconds(70.0, 100.0);
            let kinds = [
                Silence::UnreadStreams,
                Silence::HalfPrefaces,
                Silence::NoBodies,
                Silence::Controls,
            ];
            Fault::Silent(kinds[number as usize % kinds.len()], held)
        }
        Class::Greedy => {
            let kinds = [
                Greed::Batches,
                Greed::LargeJson,
                Greed::LargeReply,
                Greed::Uploads,
                Greed::Sessions,
            ];
            Fault::Greedy(kinds[number as usize % kinds.len()])
        }
        Class::Partitions => {
            let held = seconds(1.0, 12.0);
            let kinds = [
                Cut::Machine,
                Cut::Database,
                Cut::Objects,
                Cut::Machines,
                Cut::OneWay,
                Cut::Answers,
            ];
            Fault::Partition(kinds[number as usize % kinds.len()], held)
        }
        Class::Outages => {
            let held = seconds(0.5, 6.0);
            let kinds = [Outage::DatabaseEnds, Outage::ObjectsStop, Outage::DatabaseStops];
            Fault::Outage(kinds[number as usize % kinds.len()], held)
        }
        Class::Zombies => Fault::Zombie(seconds(0.0, 2.0)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MINUTE: Duration = Duration::from_secs(60);

    #[test]
    fn a_seed_is_a_schedule_and_every_class_is_in_it() {
        let paced = Paced { length: 2 * MINUTE, pace: 1.0 };
        let counted = Counted { faults: 20, zombies: 3 };
        let systems: [(&dyn Counts, &[Class]); 2] =
            [(&paced, &Class::OF_SERVER), (&counted, &Class::OF_FLEET)];
        for (counts, all) in systems {
            let first = schedule(7, 2 * MINUTE, counts, all);
            assert_eq!(first, schedule(7, 2 * MINUTE, counts, all));
            assert_ne!(first, schedule(8, 2 * MINUTE, counts, all));
            assert!(first.is_sorted_by_key(|event| event.at));
            for class in all {
                assert!(first.iter().any(|event| event.class == *class), "{class}");
            }
        }
    }

    #[test]
    fn leaving_classes_out_does_not_change_the_others() {
        let paced = Paced { length: 5 * MINUTE, pace: 1.0 };
        let all = schedule(7, 5 * MINUTE, &paced, &Class::OF_SERVER);
        let kills: Vec<_> = all.into_iter().filter(|e| e.class == Class::Kills).collect();
        assert_eq!(schedule(7, 5 * MINUTE, &paced, &[Class::Kills]), kills);
    }

    #[test]
    fn a_fleet_gets_the_number_of_faults_that_was_asked_for() {
        let counted = Counted { faults: 200, zombies: 100 };
        let events = schedule(7, 5 * MINUTE, &counted, &Class::OF_FLEET);
        let zombies = events.iter().filter(|event| event.class == Class::Zombies).count();
        assert_eq!((zombies, events.len() - zombies), (100, 200));
    }
}
