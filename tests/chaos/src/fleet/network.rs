//! The network of a fleet: its machines are network namespaces with separate addresses, joined by
//! veth pairs to the namespace of the suite, which routes between them. A partition is a rule there
//! by which packets vanish, as in a real one: neither side gets an error.

use std::{
    net::{Ipv4Addr, TcpListener},
    process::{Child, Command},
    sync::atomic::{AtomicU32, Ordering},
    time::{Duration, Instant},
};

use anyhow::{Context as _, bail};

use super::Fleet;
use crate::{schedule::Cut, tally::Tally};

/// Set by `tests/chaos/run` in a namespace where interfaces may be made.
const MAY_NETWORK: &str = "CHAOS_MAY_NETWORK";
/// Number of the machine with the services.
const SERVICES: usize = Fleet::MACHINES;
/// Time for a namespace to be made.
const START: Duration = Duration::from_secs(10);

/// Machines and the ways between them.
pub(crate) struct Network {
    /// Processes that keep the namespaces; none where there are no namespaces.
    namespaces: Vec<Child>,
    /// Preference of the next rule.
    next: AtomicU32,
}

/// A partition, until it is dropped.
pub(crate) struct Partition {
    preference: String,
    rules: usize,
}

impl Network {
    /// Makes the machines. Where that is not allowed, says so, and takes addresses of loopback.
    pub(super) fn new(tally: &Tally) -> anyhow::Result<Self> {
        let mut network = Self { namespaces: Vec::new(), next: AtomicU32::new(1000) };
        if std::env::var_os(MAY_NETWORK).is_none() {
            tally.say(
                "SKIPPED partitions: network namespaces cannot be made here; \
                 the machines are addresses of loopback",
            );
            return Ok(network);
        }
        ip("link set lo up")?;
        std::fs::write("/proc/sys/net/ipv4/ip_forward", "1").context("forward packets")?;
        for machine in 0..=SERVICES {
            let holder = Command::new("unshare").args(["--net", "sleep", "infinity"]).spawn()?;
            let pid = holder.id();
            network.namespaces.push(holder);
            is_apart(pid)?;
            ip(&format!("link add machine{machine} type veth peer name eth0 netns {pid}"))?;
            ip(&format!("address add 10.90.{machine}.1/24 dev machine{machine}"))?;
            ip(&format!("link set machine{machine} up"))?;
            let inside = |arguments: String| {
                run(Command::new("nsenter")
                    .args(["--target", &pid.to_string(), "--net", "ip"])
                    .args(arguments.split(' ')))
            };
            inside("link set lo up".to_owned())?;
            inside(format!("address add 10.90.{machine}.2/24 dev eth0"))?;
            inside(format!("address add 10.90.{machine}.3/24 dev eth0"))?;
            inside("link set eth0 up".to_owned())?;
            inside(format!("route add default via 10.90.{machine}.1"))?;
        }
        Ok(network)
    }

    /// True if there are namespaces.
    pub(crate) fn is_divided(&self) -> bool {
        !self.namespaces.is_empty()
    }

    /// Address of a machine.
    pub(super) fn address(&self, machine: usize) -> Ipv4Addr {
        if self.is_divided() {
            Ipv4Addr::new(10, 90, machine as u8, 2)
        } else {
            Ipv4Addr::new(127, 0, 1, 1 + machine as u8)
        }
    }

    /// Address of the database.
    pub(super) fn database(&self) -> Ipv4Addr {
        self.address(SERVICES)
    }

    /// Address of the bucket, on the same machine.
    pub(super) fn objects(&self) -> Ipv4Addr {
        if self.is_divided() {
            Ipv4Addr::new(10, 90, SERVICES as u8, 3)
        } else {
            self.address(SERVICES)
        }
    }

    /// The wanted port, or one that is free where others may have that.
    pub(super) fn free_port(&self, machine: usize, wanted: u16) -> anyhow::Result<u16> {
        if self.is_divided() {
            return Ok(wanted);
        }
        Ok(TcpListener::bind((self.address(machine), 0))?.local_addr()?.port())
    }

    /// A command as it runs on a machine.
    pub(super) fn on(&self, machine: usize, command: &Command) -> Command {
        let Some(namespace) = self.namespaces.get(machine) else {
            let mut same = Command::new(command.get_program());
            same.args(command.get_args());
            return with_environment(same, command);
        };
        let mut entered = Command::new("nsenter");
        entered.args(["--target", &namespace.id().to_string(), "--net"]);
        entered.arg(command.get_program()).args(command.get_args());
        with_environment(entered, command)
    }

    /// A command as it runs on the machine of the services.
    pub(super) fn beside_services(&self, command: &Command) -> Command {
        self.on(SERVICES, command)
    }

    /// Makes a partition around a machine.
    pub(crate) fn cut(&self, cut: Cut, machine: usize) -> anyhow::Result<Partition> {
        let (this, other) = (machine, (machine + 1) % Fleet::MACHINES);
        let here = self.address(this);
        let both = |there: Ipv4Addr| {
            vec![format!("from {here} to {there}"), format!("from {there} to {here}")]
        };
        let selectors = match cut {
            Cut::Machine => {
                vec![format!("iif machine{this}"), format!("to 10.90.{this}.0/24")]
            }
            Cut::Database => both(self.database()),
            Cut::Objects => both(self.objects()),
            Cut::Machines => both(self.address(other)),
            Cut::OneWay => vec![format!("from {here} to {}", self.address(other))],
            Cut::Answers => vec![format!("from {} to {here}", self.database())],
        };
        let preference = self.next.fetch_add(1, Ordering::SeqCst).to_string();
        let mut partition = Partition { preference, rules: 0 };
        for selector in selectors {
            ip(&format!("rule add preference {} {selector} blackhole", partition.preference))?;
            partition.rules += 1;
        }
        Ok(partition)
    }
}

impl Drop for Network {
    fn drop(&mut self) {
        for namespace in &mut self.namespaces {
            namespace.kill().ok();
            namespace.wait().ok();
        }
    }
}

impl Drop for Partition {
    fn drop(&mut self) {
        for _ in 0..self.rules {
            ip(&format!("rule delete preference {}", self.preference)).ok();
        }
    }
}

fn with_environment(mut command: Command, like: &Command) -> Command {
    for (name, value) in like.get_envs() {
        match value {
            Some(value) => command.env(name, value),
            None => command.env_remove(name),
        };
    }
    command
}

/// Waits until a process has a separate network namespace.
fn is_apart(pid: u32) -> anyhow::Result<()> {
    let namespace = |process: &str| std::fs::read_link(format!("/proc/{process}/ns/net"));
    let (ours, began) = (namespace("self")?, Instant::now());
    while namespace(&pid.to_string())? == ours {
        if began.elapsed() > START {
            bail!("no network namespace was made within {START:?}");
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    Ok(())
}

fn ip(arguments: &str) -> anyhow::Result<()> {
    run(Command::new("ip").args(arguments.split(' ')))
}

fn run(command: &mut Command) -> anyhow::Result<()> {
    let output = command.output()?;
    if !output.status.success() {
        bail!("{command:?}: {}", String::from_utf8_lossy(&output.stderr).trim());
    }
    Ok(())
}
