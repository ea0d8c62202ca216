//! Partitions of the network of a fleet, and services that end or stand still.

use std::time::Duration;

use anyhow::Context as _;
use tokio::{sync::Mutex, time::sleep};

use super::processes::Stopped;
use crate::{
    fleet::Fleet,
    run::Run,
    schedule::{Cut, Outage},
};

/// The database is ended by one at a time.
static DATABASE: Mutex<()> = Mutex::const_new(());

/// Cuts a machine off, and joins it again after a while.
pub(super) async fn cut(run: &Run, cut: Cut, chance: u64, held: Duration) -> anyhow::Result<()> {
    let fleet = run.system.fleet().context("there is one server")?;
    let excuse = run.excuses.begin();
    let partition = fleet.network.cut(cut, (chance % Fleet::MACHINES as u64) as usize)?;
    sleep(held).await;
    drop((partition, excuse));
    run.disturb();
    run.tally.count(format!("faults: partitions, {cut:?}"));
    Ok(())
}

/// Ends or stops a service, and starts it again.
pub(super) async fn fail(run: &Run, outage: Outage, held: Duration) -> anyhow::Result<()> {
    let services = &run.system.fleet().context("there is one server")?.services;
    let _alone = DATABASE.lock().await;
    let excuse = run.excuses.begin();
    match outage {
        Outage::DatabaseEnds => {
            services.kill_database()?;
            sleep(held).await;
            services.start_database()?;
        }
        Outage::DatabaseStops => {
            let stopped = Stopped::new(services.database_pids()?);
            sleep(held).await;
            drop(stopped);
        }
        Outage::ObjectsStop => {
            let stopped = Stopped::new(vec![services.objects_pid()?]);
            sleep(held).await;
            drop(stopped);
        }
    }
    drop(excuse);
    run.disturb();
    run.tally.count(format!("faults: services, {outage:?}"));
    Ok(())
}
