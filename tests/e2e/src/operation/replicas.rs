//! Several servers over one database and one content: any request at any of them, and the loss of one
//! in the middle of a fit.

use std::time::Duration;

use bendtwin_proto::{
    fault,
    v1::{
        DrainWorkerRequest, Fit, GetSessionRequest, GetSessionStatesRequest, OpenSessionRequest,
        RollOutResponse, Twin, WatchFitRequest, job::State,
    },
};
use tonic::Streaming;

use crate::{
    harness::{
        Api, Fleet,
        api::{fraction, worker},
        reference::{ENDLESS, capture},
        until,
    },
    rollouts,
};

const STATE: Duration = Duration::from_secs(60);
/// A fit of some seconds.
const SETTINGS: &str = r#"{
    "seed": 11,
    "graph": {"max_nodes": 40},
    "search": {"starts": 1, "generations": 60, "population": 8},
    "refine": {"passes": 24}
}"#;

fn is_under_way(fit: &Fit) -> bool {
    fit.state() == State::Running && fraction(fit) > 0.0
}

/// The reply without what differs from call to call.
fn content(reply: RollOutResponse) -> RollOutResponse {
    RollOutResponse { timing: None, ..reply }
}

async fn watch(api: &Api, fit: &Fit) -> Streaming<Fit> {
    let request = WatchFitRequest { name: fit.name.clone(), ..WatchFitRequest::default() };
    api.fits().watch_fit(request).await.unwrap().into_inner()
}

/// The last state of a watched fit, and the number of states that came.
async fn last(mut changes: Streaming<Fit>) -> (Fit, usize) {
    let (mut last, mut count) = (None, 0);
    while let Some(fit) = changes.message().await.unwrap() {
        (last, count) = (Some(fit), count + 1);
    }
    (last.unwrap(), count)
}

async fn opened(api: &Api, twin: &Twin) -> String {
    let open =
        OpenSessionRequest { twin: twin.name.clone(), slots: 2, ..OpenSessionRequest::default() };
    api.sessions().open_session(open).await.unwrap().into_inner().name
}

#[tokio::test]
async fn any_server_answers_and_a_fit_survives_the_loss_of_the_one_it_reported_to() {
    let Some(mut fleet) = Fleet::start_or_skip(&[0, 0]).await else { return };
    let name = fleet.start_worker(0).await;
    let (first, second) = (fleet.api(0), fleet.api(1));
    let stored = first.upload(&capture().await, "").await.unwrap();

    // Undisturbed, and watched at the server that the worker does not call.
    let fit = first.fit(&stored.name, SETTINGS, 0).await.unwrap();
    let (ended, states) = last(watch(&second, &fit).await).await;
    assert!(ended.state() == State::Succeeded && states > 2, "{states} states, {:?}", ended.job);
    let twin = second.get_twin(&ended.twin).await.unwrap();
    let file = second.export(&twin.name).await.unwrap();

    // Rollouts of the worker at both, and a session of one at the other.
    let request = rollouts::request(&twin, &rollouts::rest_controls(&file));
    let at_second = second.roll_out(request.clone()).await.unwrap();
    assert_eq!(at_second.worker, name);
    assert_eq!(content(at_second), content(first.roll_out(request).await.unwrap()));
    let session = opened(&first, &twin).await;
    let asked = GetSessionStatesRequest { name: session.clone(), slots: Vec::new() };
    let states = second.sessions().get_session_states(asked).await.unwrap().into_inner();
    assert_eq!(states.slots, [0, 1]);

    // The same fit again. The server that its worker reports to is killed.
    let fit = second.fit(&stored.name, SETTINGS, 0).await.unwrap();
    second.fit_when(&fit.name, "under way", STATE, is_under_way).await;
    let changes = watch(&second, &fit).await;
    fleet.kill(0);
    let (ended, _) = last(changes).await;
    let job = ended.job.as_ref().unwrap();
    assert_eq!((ended.state(), job.attempts), (State::Succeeded, 1), "{job:?}");
    let again = second.get_twin(&ended.twin).await.unwrap();
    assert!(again.name != twin.name && again.digest == twin.digest);
    assert_eq!(second.export(&again.name).await.unwrap(), file);
    assert_eq!(second.list_twins().await.unwrap().len(), 2);
    let get = GetSessionRequest { name: session };
    assert_eq!(second.sessions().get_session(get).await.unwrap().into_inner().worker, name);

    // It comes back and finds everything unchanged. The worker is drained at one, and gone at both.
    fleet.start_again(0).await;
    assert_eq!(fleet.names(0).await, std::slice::from_ref(&name));
    let fit = second.fit(&stored.name, ENDLESS, 0).await.unwrap();
    second.fit_when(&fit.name, "under way", STATE, is_under_way).await;
    let drained = fleet.api(0).workers().drain_worker(DrainWorkerRequest { name }).await.unwrap();
    assert!(drained.into_inner().draining);
    assert!(fleet.worker_ended(STATE).await);
    let fit = second.get_fit(&fit.name).await.unwrap();
    let job = fit.job.as_ref().unwrap();
    assert_eq!((fit.state(), job.attempts), (State::Queued, 0), "handed back: {job:?}");
    for server in [0, 1] {
        let none = async || fleet.names(server).await.is_empty().then_some(());
        until("the worker to be forgotten", STATE, none).await;
    }
}

#[tokio::test]
async fn servers_leave_each_others_processes_alone_until_one_is_gone() {
    let Some(mut fleet) = Fleet::start_or_skip(&[1, 0]).await else { return };
    let (first, second) = (fleet.api(0), fleet.api(1));
    let its = until("the process of the first server", STATE, async || {
        second.list_workers().await.ok()?.into_iter().next()
    })
    .await;
    assert!(its.server.starts_with("servers/"), "{its:?}");
    let stored = second.upload(&capture().await, "").await.unwrap();
    let fit = second.fit(&stored.name, ENDLESS, 0).await.unwrap();
    second.fit_when(&fit.name, "under way", STATE, is_under_way).await;

    // The other server is killed and restarts: nothing changes for the fit.
    fleet.kill(1);
    fleet.start_again(1).await;
    let second = fleet.api(1);
    let running = first.get_fit(&fit.name).await.unwrap();
    assert_eq!((worker(&running), running.job.as_ref().unwrap().attempts), (&*its.name, 1));

    // What is at a process of one server is not at the other, which says so.
    let file = crate::harness::reference::reference().await.file;
    let twin = first.import(&file).await.unwrap();
    let session = opened(&first, &twin).await;
    let get = GetSessionRequest { name: session };
    let refused = second.sessions().get_session(get).await.unwrap_err();
    assert_eq!(fault::fault(&refused).reason, "SESSION_ELSEWHERE", "{refused}");

    // Once the first is gone, so is its process, and the fit waits for another without blame.
    fleet.kill(0);
    let waits = |fit: &Fit| fit.state() == State::Queued;
    let fit = second.fit_when(&fit.name, "queued again", STATE, waits).await;
    assert_eq!(fit.job.as_ref().unwrap().attempts, 0, "{:?}", fit.job);
    until("its process to be forgotten", STATE, async || {
        fleet.names(1).await.is_empty().then_some(())
    })
    .await;
}
