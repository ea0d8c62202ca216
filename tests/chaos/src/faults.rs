//! The faults, each at its time, beside each other where they meet.

mod disk;
mod greedy;
mod hostile;
mod partitions;
mod processes;
mod silent;
mod zombies;

use std::{net::IpAddr, sync::Arc, time::Duration};

use anyhow::Context as _;
use bendtwin_proto::v1::{
    rollout_service_client::RolloutServiceClient, session_service_client::SessionServiceClient,
};
use tokio::{
    task::JoinSet,
    time::{Instant, sleep},
};
use tonic::transport::{Channel, Endpoint};

use crate::{
    run::Run,
    schedule::{Event, Fault},
};

/// Time for the faults that are under way at the end.
const END: Duration = Duration::from_secs(90);
/// Pause before a fault that was prevented is tried again.
const RETRY: Duration = Duration::from_secs(1);
/// Address of hostile and silent clients, another one than that of honest clients.
const STRANGER: IpAddr = IpAddr::V4(std::net::Ipv4Addr::new(127, 0, 0, 2));
/// Address of greedy clients.
const GREEDY: IpAddr = IpAddr::V4(std::net::Ipv4Addr::new(127, 0, 0, 3));

/// Lets everything happen that is in the schedule, and ends it.
pub(crate) async fn happen(run: &Arc<Run>, events: Vec<Event>) {
    let mut faults = JoinSet::new();
    let files = Arc::new(hostile::Files::new(run.seed));
    for event in events {
        tokio::time::sleep_until(Instant::from_std(run.started) + event.at).await;
        run.tally.log(format_args!("FAULT {event}"));
        let (run, files) = (run.clone(), files.clone());
        faults.spawn_local(async move { one(&run, event, &files).await });
    }
    // Those that wait for a chance have it as long as there is a load.
    let over = async {
        while run.is_under_load() {
            sleep(RETRY).await;
        }
        sleep(END).await;
    };
    let all = async {
        while let Some(fault) = faults.join_next().await {
            if let Err(error) = fault {
                run.tally.broken("the suite itself works", error);
            }
        }
    };
    let are_cut_short = tokio::select! {
        () = all => false,
        () = over => true,
    };
    if are_cut_short {
        run.tally.log(format_args!("{} faults were cut short", faults.len()));
        faults.shutdown().await;
    }
    for clock in &run.clocks {
        clock.set(0).unwrap_or_else(|e| run.tally.log(format_args!("the clock stays wrong: {e}")));
    }
    if let Some(disk) = &run.disk {
        disk.free().unwrap_or_else(|e| run.tally.log(format_args!("the disk stays full: {e}")));
    }
}

/// Injects a fault. A fault that another one prevents does not count; a fleet, which needs a
/// certain number of faults, gets it later.
async fn one(run: &Run, event: Event, files: &hostile::Files) {
    loop {
        let Err(error) = attempt(run, event, files).await else { return run.fault_happened() };
        run.tally.log(format_args!("{event} did not come about: {error:#}"));
        if run.faults_to_come() == 0 || !run.is_under_load() {
            return;
        }
        sleep(RETRY).await;
    }
}

async fn attempt(run: &Run, event: Event, files: &hostile::Files) -> anyhow::Result<()> {
    match event.fault {
        Fault::Kill(victim) => processes::kill_one(run, victim, event.chance).await,
        Fault::Restart => processes::restart(run, event.chance).await,
        Fault::Pause(victim, held) => processes::pause(run, victim, event.chance, held).await,
        Fault::Clock(step_s) => step(run, event.chance, step_s),
        Fault::FullDisk { held, fresh, pressed } => disk::fill(run, held, fresh, pressed).await,
        Fault::Hostile(number) => hostile::send_file(run, number, files).await,
        Fault::Silent(silence, held) => silent::be(run, silence, held).await,
        Fault::Greedy(greed) => greedy::ask(run, greed).await,
        Fault::Partition(cut, held) => partitions::cut(run, cut, event.chance, held).await,
        Fault::Outage(outage, held) => partitions::fail(run, outage, held).await,
        Fault::Zombie(beyond) => zombies::make(run, event.chance, beyond).await,
    }
}

fn step(run: &Run, chance: u64, step_s: i64) -> anyhow::Result<()> {
    let clock = run.clocks.get(chance as usize % run.clocks.len().max(1));
    clock.context("there is no clock")?.set(step_s)?;
    run.tally.count("faults: steps of the clock");
    Ok(())
}

/// A client of rollouts with a separate address.
async fn rollouts(run: &Run, from: IpAddr) -> anyhow::Result<RolloutServiceClient<Channel>> {
    let client = RolloutServiceClient::new(channel(run, from).await?);
    Ok(client.max_decoding_message_size(1 << 30))
}

/// A client of sessions with a separate address.
async fn sessions(run: &Run, from: IpAddr) -> anyhow::Result<SessionServiceClient<Channel>> {
    Ok(SessionServiceClient::new(channel(run, from).await?))
}

async fn channel(run: &Run, from: IpAddr) -> anyhow::Result<Channel> {
    let endpoint = Endpoint::from_shared(run.system.url())?.local_address(Some(from));
    Ok(endpoint.connect_timeout(Duration::from_secs(10)).connect().await?)
}

/// An HTTP client with a separate address.
fn http(from: IpAddr) -> anyhow::Result<reqwest::Client> {
    let builder = reqwest::Client::builder().local_address(from).pool_max_idle_per_host(0);
    Ok(builder.timeout(Duration::from_secs(60)).build()?)
}
