//! The trash against a model of it: captures and twins with few different contents are made, deleted,
//! restored and purged in any order, while time passes and garbage is collected. Everything that can be read
//! has its content, and nothing else is stored.

use std::collections::{BTreeMap, BTreeSet};

use proptest::prelude::*;

use super::*;

const CONTENTS: [&str; 3] = ["a", "b", "c"];

#[derive(Clone, Debug)]
enum Step {
    Capture { content: usize },
    Twin { content: usize },
    Delete { nth: usize, days: u64 },
    DeleteForGood { nth: usize },
    Restore { nth: usize },
    Pass { hours: u64 },
    Sweep,
    MakeRoom { count: usize },
    CollectGarbage,
    Reopen,
}

fn steps() -> impl Strategy<Value = Vec<Step>> {
    let step = prop_oneof![
        3 => (0..CONTENTS.len()).prop_map(|content| Step::Capture { content }),
        3 => (0..CONTENTS.len()).prop_map(|content| Step::Twin { content }),
        5 => (0..8usize, 1..4u64).prop_map(|(nth, days)| Step::Delete { nth, days }),
        1 => (0..8usize).prop_map(|nth| Step::DeleteForGood { nth }),
        4 => (0..8usize).prop_map(|nth| Step::Restore { nth }),
        3 => (1..48u64).prop_map(|hours| Step::Pass { hours }),
        3 => Just(Step::Sweep),
        1 => (0..3usize).prop_map(|count| Step::MakeRoom { count }),
        2 => Just(Step::CollectGarbage),
        1 => Just(Step::Reopen),
    ];
    proptest::collection::vec(step, 1..40)
}

/// A resource: its content, and when it was deleted and is due.
#[derive(Clone, Copy, Debug)]
struct Entry {
    content: usize,
    trashed: Option<(Timestamp, Timestamp)>,
}

async fn run(on: On, steps: Vec<Step>) {
    let mut bench = Bench::new(on).await;
    // In the order of creation; without those that are gone.
    let mut model: Vec<(Resource, Entry)> = Vec::new();
    for step in steps {
        // No two deletions have the same time, so that their order is known.
        bench.clock.advance(Duration::from_micros(1));
        match step {
            Step::Capture { content } => {
                let id = bench.capture(CONTENTS[content]).await.id;
                model.push((id.into(), Entry { content, trashed: None }));
            }
            Step::Twin { content } => {
                let id = twin(&bench, "twin", CONTENTS[content]).await;
                model.push((id.into(), Entry { content, trashed: None }));
            }
            Step::Delete { nth, days } => {
                let Some((resource, entry)) = model.get_mut(nth) else { continue };
                let kept = DAY * u32::try_from(days).unwrap();
                let terms = Deletion { kept, by: String::new() };
                let done = bench.store.trash().put(*resource, &terms).await;
                assert_eq!(done.is_ok(), entry.trashed.is_none());
                if let Ok(purged) = done {
                    entry.trashed = Some((bench.store.now(), purged));
                }
            }
            Step::DeleteForGood { nth } => {
                if nth >= model.len() {
                    continue;
                }
                match model.remove(nth).0 {
                    Resource::Capture(id) => bench.store.captures().delete(id).await.unwrap(),
                    Resource::Twin(id) => bench.store.twins().delete(id).await.unwrap(),
                    Resource::Fit(_) => unreachable!(),
                }
            }
            Step::Restore { nth } => {
                let Some((resource, entry)) = model.get_mut(nth) else { continue };
                restore(&bench, *resource).await.unwrap();
                entry.trashed = None;
            }
            Step::Pass { hours } => bench.clock.advance(Duration::from_secs(hours * 3600)),
            Step::Sweep => {
                bench.store.trash().sweep().await.unwrap();
                let now = bench.store.now();
                model.retain(|(_, entry)| entry.trashed.is_none_or(|(_, due)| due > now));
            }
            Step::MakeRoom { count } => {
                let mut left = count + 1;
                let wanted = || {
                    left -= 1;
                    Ok(left > 0)
                };
                bench.store.trash().purge_while(wanted).await.unwrap();
                let deleted = model.iter().filter_map(|(r, e)| Some((e.trashed?.0, *r)));
                let mut deleted: Vec<_> = deleted.collect();
                deleted.sort_unstable();
                deleted.truncate(count);
                let purged: BTreeSet<_> =
                    deleted.into_iter().map(|(_, resource)| resource).collect();
                model.retain(|(resource, _)| !purged.contains(resource));
            }
            Step::CollectGarbage => bench.store.collect_garbage().await.unwrap(),
            Step::Reopen => bench = bench.reopen().await,
        }
        check(&bench, &model).await;
    }
}

async fn check(bench: &Bench, model: &[(Resource, Entry)]) {
    let mut trashed = BTreeMap::new();
    for (resource, entry) in model {
        let read = match *resource {
            Resource::Capture(id) => bench.store.captures().content(id).await.map(drop),
            Resource::Twin(id) => bench.store.twins().content(id).await.map(drop),
            Resource::Fit(_) => unreachable!(),
        };
        match entry.trashed {
            None => read.unwrap(),
            Some((deleted, due)) => {
                assert_in_trash(read);
                trashed.insert(*resource, (deleted, due));
            }
        }
    }
    let mut listed = BTreeMap::new();
    for collection in Collection::ALL {
        let page = PageRequest { size: 100, token: String::new() };
        let page = bench.store.trash().list(collection, "", None, &page).await.unwrap();
        listed.extend(page.items.iter().map(|t| (t.resource, (t.deleted, t.purged))));
    }
    assert_eq!(listed, trashed);
    let live = model.iter().filter(|(_, entry)| entry.trashed.is_none()).count();
    let all = ListQuery::from(PageRequest { size: 100, token: String::new() });
    let captures = bench.store.captures().list(&all).await.unwrap().items.len();
    assert_eq!(captures + bench.store.twins().list(&all).await.unwrap().items.len(), live);
    let contents: BTreeSet<_> = model.iter().map(|(_, entry)| entry.content).collect();
    assert_eq!(bench.published_count().await, contents.len(), "{model:?}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]
    #[test]
    fn the_trash_is_its_model(steps in steps()) {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        runtime.block_on(run(On::Sqlite, steps));
    }
}

proptest! {
    // Each makes a database.
    #![proptest_config(ProptestConfig { cases: 6, ..ProptestConfig::default() })]
    #[test]
    fn the_trash_is_its_model_on_postgres(steps in steps()) {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        if let Some(on) = On::postgres_or_skip() {
            runtime.block_on(run(on, steps));
        }
    }
}
