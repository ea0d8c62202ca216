use bendtwin_contract_kit::hanging::twin;
use bendtwin_core::{Category, Problem as _};
use tokio::sync::mpsc;

use super::*;
use crate::faulty::{Faulty, Script};

/// Twins on a device with memory for `room` models.
fn warm(room: usize) -> (WarmTwins, Arc<Script>) {
    let (backend, script) = Faulty::new(room);
    let (fatal, _) = mpsc::unbounded_channel();
    let device = Device::spawn(move || Ok(Arc::new(backend) as _), fatal, 0.25).unwrap();
    // Nothing listens there: these twins come from memory.
    let server =
        ServerClient::new(&["http://127.0.0.1:1".to_owned()], "a-token", "a-key", None).unwrap();
    let (memory, dir) = (Memory::new(1 << 30), std::env::temp_dir());
    (WarmTwins::new(server, device, Limits::default(), memory, dir), script)
}

async fn load(twins: &WarmTwins, id: TwinId) -> Result<Arc<Warm>, Error> {
    let file: Bytes = twin().encode().unwrap().into();
    let share = twins.room(200 << 10).await?;
    twins.load(id, file, Some(share)).await
}

#[tokio::test]
async fn a_full_device_unloads_the_longest_unused_twin() {
    let (twins, script) = warm(2);
    let [a, b, c] = [(); 3].map(|()| TwinId::generate());
    load(&twins, a).await.unwrap();
    load(&twins, b).await.unwrap();
    assert_eq!(twins.get(a).await.unwrap().id(), a);
    load(&twins, c).await.unwrap();
    assert_eq!(twins.ids(), [c, a]);
    assert_eq!(script.resident(), 2);
}

#[tokio::test]
async fn a_twin_in_use_stays_and_what_finds_no_room_is_refused_clearly() {
    let (twins, script) = warm(1);
    let [a, b] = [(); 2].map(|()| TwinId::generate());
    let used = load(&twins, a).await.unwrap();
    let error = load(&twins, b).await.map(drop).unwrap_err();
    assert_eq!(error.category(), Category::ResourceExhausted);
    assert_eq!(error.reason(), "DEVICE_OUT_OF_MEMORY");
    assert!(error.to_string().contains("coarser twin"), "{error}");
    assert_eq!(twins.ids(), [a]);
    drop(used);
    load(&twins, b).await.unwrap();
    assert_eq!((twins.ids(), script.resident()), (vec![b], 1));
}

#[tokio::test]
async fn what_never_fits_unloads_nothing() {
    let (twins, script) = warm(1);
    let a = TwinId::generate();
    load(&twins, a).await.unwrap();
    // The device says that it is smaller than any model.
    script.room.store(0, std::sync::atomic::Ordering::SeqCst);
    twins.device.sample_memory_now();
    assert!(load(&twins, TwinId::generate()).await.is_err());
    assert_eq!(twins.ids(), [a]);
}

#[tokio::test]
async fn twins_make_room_in_memory_for_others_and_no_twin_takes_more_than_there_is() {
    let (mut twins, _) = warm(9);
    twins.memory.twins = bendtwin_budget::Budget::new(16 << 20);
    let load = async |id| {
        let share = twins.room(6 << 20).await?;
        twins.load(id, twin().encode().unwrap().into(), Some(share)).await
    };
    let [a, b, c] = [(); 3].map(|()| TwinId::generate());
    load(a).await.unwrap();
    load(b).await.unwrap();
    load(c).await.unwrap();
    assert_eq!(twins.ids(), [c, b]);
    let error = twins.room(15 << 20).await.unwrap_err();
    assert_eq!((error.category(), error.reason()), (Category::InvalidArgument, "MEMORY_TOO_SMALL"));
}
