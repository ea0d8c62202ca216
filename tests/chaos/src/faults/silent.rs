//! Clients that begin and then stall.

use std::time::Duration;

use bendtwin_proto::v1::{AdvanceSessionRequest, OpenSessionRequest, Returns, RollOutRequest};
use futures::{StreamExt as _, future::join_all, stream};
use tokio::{
    io::AsyncWriteExt as _,
    net::{TcpSocket, TcpStream},
    time::{sleep, timeout},
};

use super::{STRANGER, rollouts, sessions};
use crate::{run::Run, schedule::Silence};

/// Connections of one client.
const CONNECTIONS: usize = 256;
/// Streams of one client.
const STREAMS: usize = 32;

pub(super) async fn be(run: &Run, silence: Silence, held: Duration) -> anyhow::Result<()> {
    let held = held.min(run.length.saturating_sub(run.started.elapsed()));
    match silence {
        Silence::HalfPrefaces => {
            let half: &[u8] = b"PRI * HTTP/2.0\r\n";
            connections(run, &[half], held).await?;
        }
        Silence::NoBodies => {
            let captures: &[u8] = b"POST /v1/captures HTTP/1.1\r\nhost: localhost\r\n\
                content-type: application/zip\r\ncontent-length: 100000\r\n\r\nPK";
            let fits: &[u8] = b"POST /v1/fits HTTP/1.1\r\nhost: localhost\r\n\
                content-type: application/json\r\ncontent-length: 1000\r\n\r\n{";
            let headers: &[u8] = b"GET /v1/captures HTTP/1.1\r\nhost: local";
            connections(run, &[captures, fits, headers], held).await?;
        }
        Silence::UnreadStreams => streams(run, held).await?,
        Silence::Controls => controls(run, held).await?,
    }
    run.tally.count(format!("faults: silent clients, {silence:?}"));
    Ok(())
}

async fn connections(run: &Run, openings: &[&[u8]], held: Duration) -> anyhow::Result<()> {
    let mut open: Vec<TcpStream> = Vec::new();
    for number in 0..CONNECTIONS {
        let socket = TcpSocket::new_v4()?;
        socket.bind((STRANGER, 0).into())?;
        // A server that takes no more of them is in its right.
        let Ok(mut stream) = socket.connect(run.system.address().parse()?).await else { break };
        stream.write_all(openings[number % openings.len()]).await.ok();
        open.push(stream);
    }
    sleep(held).await;
    Ok(())
}

async fn streams(run: &Run, held: Duration) -> anyhow::Result<()> {
    let client = rollouts(run, STRANGER).await?;
    let returns = Returns { every_frames: 1, ..Returns::default() };
    let request =
        RollOutRequest { returns: Some(returns), ..run.references.batch(run.twin(), 256, 100) };
    let open = async {
        let unread = join_all((0..STREAMS).map(|_| {
            let (mut client, request) = (client.clone(), request.clone());
            async move { client.stream_roll_out(request).await }
        }));
        let _unread = unread.await;
        std::future::pending::<()>().await;
    };
    timeout(held, open).await.ok();
    Ok(())
}

async fn controls(run: &Run, held: Duration) -> anyhow::Result<()> {
    let mut client = sessions(run, STRANGER).await?;
    let open = OpenSessionRequest { twin: run.twin(), ..OpenSessionRequest::default() };
    let name = client.open_session(open).await?.into_inner().name;
    let garbage = |number: usize| {
        let name = if number.is_multiple_of(2) { name.clone() } else { "\u{0}".repeat(number) };
        let slots = vec![u32::MAX; number];
        let rollout = run.references.walk.steps.first().cloned();
        AdvanceSessionRequest { name, slots, rollout }
    };
    let open = async {
        let unread = join_all((0..STREAMS).map(|number| {
            let mut client = client.clone();
            let said = (number >= STREAMS / 2).then(|| garbage(number));
            let messages = stream::iter(said).chain(stream::pending());
            async move { client.control_session(messages).await }
        }));
        let _unread = unread.await;
        std::future::pending::<()>().await;
    };
    timeout(held, open).await.ok();
    Ok(())
}
