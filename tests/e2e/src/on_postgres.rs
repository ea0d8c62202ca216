//! A server whose rows are in PostgreSQL, which crashes and comes back in the middle of a fit: nothing
//! that was acknowledged is lost, and nobody restarts the server.

use std::time::Duration;

use bendtwin_proto::v1::{CreateFitRequest, Fit, job::State};
use tonic::Code;

use crate::harness::{
    Postgres, Setup, TestCluster,
    api::fraction,
    reference::{FIT, SETTINGS, capture},
    until,
};

const PASSWORD: &str = "not-to-be-shown";
const STATE: Duration = Duration::from_secs(60);

#[tokio::test]
async fn a_capture_becomes_a_twin_although_postgres_crashes() {
    let Some(postgres) = Postgres::start_or_skip().await else { return };
    let database = Some(postgres.url_with_password(PASSWORD));
    let mut server = TestCluster::start(Setup { database, ..Setup::default() }).await;
    let api = server.api();
    let archive = capture().await;
    let stored = api.upload(&archive, "the capture").await.unwrap();
    let under_way = |fit: &Fit| fit.state() == State::Running && fraction(fit) > 0.0;
    let fit = api.fit(&stored.name, SETTINGS, 0).await.unwrap();
    api.fit_when(&fit.name, "running", FIT, under_way).await;

    postgres.kill().await;
    let request = CreateFitRequest {
        capture: stored.name.clone(),
        settings_json: SETTINGS.to_owned(),
        request_id: "the second".to_owned(),
        ..CreateFitRequest::default()
    };
    let refused = api.fits().create_fit(request.clone()).await.unwrap_err();
    assert_eq!(refused.code(), Code::Unavailable, "{}", refused.message());
    assert!(!refused.message().contains(PASSWORD), "{}", refused.message());
    assert!(!server.http().is_ready().await);

    postgres.start().await;
    let second = until("the server to take requests again", STATE, async || {
        Some(api.fits().create_fit(request.clone()).await.ok()?.into_inner())
    })
    .await;
    for name in [&fit.name, &second.name] {
        let fitted = api.succeeded(name, FIT).await;
        let twin = api.export(&fitted.twin).await.unwrap();
        assert!(bendtwin_core::Twin::decode(&twin).is_ok());
    }
    assert!(server.is_alive(), "the server is the same");
    assert_eq!(api.list_captures().await.unwrap().len(), 1);
    assert_eq!(api.list_fits().await.unwrap().len(), 2);

    // Its own restart finds everything in the database, and the folder has none.
    server.kill();
    server.start_again().await;
    assert_eq!(server.api().list_twins().await.unwrap().len(), 2);
    let content = server.http().get(&format!("/v1/{}/content", stored.name)).await;
    assert_eq!(content.bytes().await.unwrap(), archive);
    assert!(!server.data_dir().join("bendtwin.sqlite").exists());
    assert!(!server.log().contains(PASSWORD), "the password is in a log");
}
