use bendtwin_core::{Problem as _, ids::ProjectId};

use super::*;
use crate::{
    Creator, ListQuery, NewCapture,
    database::testing::{On, on_databases},
    store::tests::{Bench, new_capture},
};

on_databases! {
    projects_are_made_changed_listed_and_deleted,
    projects_and_members_are_bounded,
    a_confined_list_has_what_projects_share_page_by_page,
}

fn names(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

fn change(add: &[&str], remove: &[&str]) -> ProjectChange {
    let members = MemberChange { add: names(add), remove: names(remove), all: None };
    ProjectChange { members, ..ProjectChange::default() }
}

async fn projects_are_made_changed_listed_and_deleted(on: On) {
    let bench = Bench::new(on).await;
    let projects = bench.store.projects();
    let ropes = projects.create("ropes", &names(&["eve", "ada", "eve"])).await.unwrap();
    assert_eq!(ropes.members, ["ada", "eve"]);
    let cloth = projects.create("cloth", &names(&["bob"])).await.unwrap();
    assert_eq!(projects.get(ropes.id).await.unwrap(), ropes);
    let mut page = PageRequest { size: 1, token: String::new() };
    let first = projects.list(&page, None).await.unwrap();
    assert_eq!(first.items, std::slice::from_ref(&cloth));
    page.token = first.next_token;
    assert_eq!(projects.list(&page, None).await.unwrap().items, std::slice::from_ref(&ropes));
    let of = async |owner: &str| {
        let page = PageRequest::default();
        let found = projects.list(&page, Some(owner)).await.unwrap().items;
        found.into_iter().map(|project| project.display_name).collect::<Vec<_>>()
    };
    assert_eq!((of("ada").await, of("zoe").await), (names(&["ropes"]), Vec::new()));

    let known = projects.memberships().await.unwrap();
    assert!(known.share("ada", "eve") && !known.share("ada", "bob") && !known.share("zoe", "zoe"));
    let changed = projects.update(ropes.id, &change(&["bob"], &["eve", "zoe"])).await.unwrap();
    assert_eq!(
        (changed.members, of("bob").await),
        (names(&["ada", "bob"]), names(&["cloth", "ropes"]))
    );
    let members = MemberChange { all: Some(names(&["zoe"])), ..MemberChange::default() };
    let new = ProjectChange { display_name: Some("all".to_owned()), members };
    let changed = projects.update(ropes.id, &new).await.unwrap();
    assert_eq!((changed.display_name.as_str(), changed.members), ("all", names(&["zoe"])));

    projects.delete(ropes.id).await.unwrap();
    assert!(of("zoe").await.is_empty());
    assert!(!projects.memberships().await.unwrap().share("zoe", "zoe"));
    for id in [ropes.id, ProjectId::generate()] {
        assert!(matches!(projects.get(id).await, Err(Error::NotFound { .. })));
        assert!(matches!(projects.delete(id).await, Err(Error::NotFound { .. })));
        let changed = projects.update(id, &change(&[], &[])).await;
        assert!(matches!(changed, Err(Error::NotFound { .. })));
    }
}

async fn projects_and_members_are_bounded(on: On) {
    let bench = Bench::new(on).await;
    let projects = bench.store.projects();
    let many: Vec<String> = (0..MAX_MEMBERS).map(|n| format!("m{n}")).collect();
    let full = projects.create("full", &many).await.unwrap();
    let refused = projects.update(full.id, &change(&["one more"], &[])).await.unwrap_err();
    assert_eq!(refused.reason(), "TOO_MANY_MEMBERS");
    assert_eq!(projects.get(full.id).await.unwrap().members.len(), MAX_MEMBERS);
    let swapped = projects.update(full.id, &change(&["one more"], &["m7"])).await.unwrap();
    assert_eq!(swapped.members.len(), MAX_MEMBERS);
    let mut tx = bench.store.inner.database.write().await.unwrap();
    for n in 1..MAX_PROJECTS {
        query("insert into projects (id, display_name, created_at) values ($1, 'a', 0)")
            .bind(n.to_string())
            .execute(&mut tx)
            .await
            .unwrap();
    }
    tx.commit().await.unwrap();
    let refused = projects.create("one more", &[]).await.unwrap_err();
    assert_eq!(refused.reason(), "TOO_MANY_PROJECTS");
}

async fn a_confined_list_has_what_projects_share_page_by_page(on: On) {
    let bench = Bench::new(on).await;
    let projects = bench.store.projects();
    let owners = ["ada", "eve", "bob", "ada", "bob", "", "eve", "ada"];
    for (name, owner) in ["0", "1", "2", "3", "4", "5", "6", "7"].into_iter().zip(owners) {
        let creator = Creator { owner: owner.to_owned(), ..Creator::default() };
        let new = NewCapture { creator, ..new_capture(name, bench.stage(name).await) };
        bench.store.captures().create(new).await.unwrap();
    }
    let query_of = |owner: &str| ListQuery {
        page: PageRequest { size: 2, token: String::new() },
        shared_with: Some(owner.to_owned()),
        ..ListQuery::default()
    };
    let captures = bench.store.captures();
    // The rest of a list from a page on, as names.
    let rest = async |mut query: ListQuery| {
        let mut seen = Vec::new();
        loop {
            let page = captures.list(&query).await.unwrap();
            seen.extend(page.items.into_iter().map(|capture| capture.labels.display_name));
            if page.next_token.is_empty() {
                return seen;
            }
            query.page.token = page.next_token;
        }
    };
    assert_eq!(rest(query_of("ada")).await, ["7", "3", "0"]);
    assert!(rest(query_of("zoe")).await.is_empty());
    let project = projects.create("ropes", &names(&["ada", "eve"])).await.unwrap();
    assert_eq!(rest(query_of("ada")).await, ["7", "6", "3", "1", "0"]);
    assert_eq!(rest(query_of("bob")).await, ["4", "2"]);
    let named = ListQuery { owner: "eve".to_owned(), ..query_of("ada") };
    assert_eq!(rest(named).await, ["6", "1"]);
    let named = ListQuery { owner: "bob".to_owned(), ..query_of("ada") };
    assert!(rest(named).await.is_empty());
    // After a change of the project a list continues with what is shared then.
    let mut query = query_of("ada");
    query.page.token = captures.list(&query).await.unwrap().next_token;
    projects.update(project.id, &change(&["bob"], &["eve"])).await.unwrap();
    assert_eq!(rest(query).await, ["4", "3", "2", "0"]);
}
