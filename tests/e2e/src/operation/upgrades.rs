//! An upgrade without a stop: what the servers and the worker of a version do while and after a newer
//! version migrates their database. The newer version is its migrations, as it would leave them in the
//! database; the program that runs is the older one.

use std::time::Duration;

use bendtwin_proto::v1::{Fit, job::State};

use crate::{
    harness::{
        Fleet,
        api::fraction,
        reference::{FIT, SETTINGS, capture},
    },
    rollouts,
};

const STATE: Duration = Duration::from_secs(60);
/// Statements of a migration, and its entry among those of the database.
fn migration(version: u32, name: &str, statements: &str) -> String {
    format!(
        "begin; {statements};
         insert into _sqlx_migrations (version, description, success, checksum, execution_time)
             values ({version}, '{name}', true, '', 0); commit"
    )
}

fn is_under_way(fit: &Fit) -> bool {
    fit.state() == State::Running && fraction(fit) > 0.0
}

#[tokio::test]
async fn servers_and_a_fit_keep_running_beside_a_newer_version_and_a_breaking_one_is_refused() {
    let Some(mut fleet) = Fleet::start_or_skip(&[0, 0]).await else { return };
    fleet.start_worker(0).await;
    let (first, second) = (fleet.api(0), fleet.api(1));
    let stored = first.upload(&capture().await, "").await.unwrap();
    let fit = first.fit(&stored.name, SETTINGS, 0).await.unwrap();
    first.fit_when(&fit.name, "under way", STATE, is_under_way).await;

    // A newer version adds to the tables that are in use, while the fit runs.
    let adds = "alter table jobs add column flavour text not null default 'plain';
        alter table workers add column flavour text;
        create table flavours (name text primary key)";
    fleet.query(&migration(9001, "flavours", adds)).await;
    // Its server takes the place of the one that the worker calls.
    fleet.kill(0);
    let ended = second.succeeded(&fit.name, FIT).await;
    assert_eq!(ended.job.as_ref().unwrap().attempts, 1, "{:?}", ended.job);

    // The older version starts again and does all that it did.
    fleet.start_again(0).await;
    let first = fleet.api(0);
    let another = first.upload(&capture().await, "").await.unwrap();
    let fit = first.fit(&another.name, SETTINGS, 0).await.unwrap();
    let again = second.succeeded(&fit.name, FIT).await;
    let file = second.export(&again.twin).await.unwrap();
    let twin = first.get_twin(&again.twin).await.unwrap();
    first.roll_out(rollouts::request(&twin, &rollouts::rest_controls(&file))).await.unwrap();
    let flavours = fleet.query("select distinct flavour from jobs").await;
    assert_eq!(flavours, "plain");

    // A version that changes what the older one uses was started nevertheless.
    let count = "select count(*) from jobs";
    let jobs = fleet.query(count).await;
    fleet.kill(0);
    let renames = "alter table captures add column renamed text";
    fleet.query(&migration(9002, "breaking_names", renames)).await;
    let refusal = fleet.refused_start(0).await;
    for words in ["a newer version of the program has changed the database", "names", "9002"] {
        assert!(refusal.contains(words), "{refusal}");
    }
    let (status, ready) = readiness(&fleet, 1).await;
    assert!(status == 503 && ready.contains("a newer version of the program"), "{ready}");
    assert_eq!(fleet.query(count).await, jobs);
    assert_eq!(second.export(&again.twin).await.unwrap(), file, "what is there can be read");
}

async fn readiness(fleet: &Fleet, server: usize) -> (u16, String) {
    let answer = fleet.http(server).get("/readyz").await;
    (answer.status().as_u16(), answer.text().await.unwrap())
}
