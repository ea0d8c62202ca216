//! Projects: sets of owners who share what each of them has. An owner is a name: it need not have a
//! key yet.

use std::collections::{BTreeSet, HashMap, HashSet};

use bendtwin_core::ids::ProjectId;
use jiff::Timestamp;
use uuid::Uuid;

use crate::{
    Error, Page, PageRequest, Result, Store,
    sql::{Builder, Transaction, query, query_scalar, row::row},
    store::clock::from_micros,
};

/// Most members of a project.
pub const MAX_MEMBERS: usize = 200;
/// Most projects of a store: servers have all memberships in memory.
const MAX_PROJECTS: i64 = 1000;

/// A project.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Project {
    /// Id of the project.
    pub id: ProjectId,
    /// Display name.
    pub display_name: String,
    /// Owners who share, sorted.
    pub members: Vec<String>,
    /// Time of creation.
    pub created: Timestamp,
}

/// A change of the members of a project.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MemberChange {
    /// New members in place of those that there are.
    pub all: Option<Vec<String>>,
    /// Members to add.
    pub add: Vec<String>,
    /// Members to take away.
    pub remove: Vec<String>,
}

/// A change of a project; `None` keeps a value.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ProjectChange {
    /// New display name.
    pub display_name: Option<String>,
    /// Change of its members.
    pub members: MemberChange,
}

/// The projects of a store.
#[derive(Clone, Copy, Debug)]
pub struct Projects<'a> {
    pub(crate) store: &'a Store,
}

/// The projects of each owner.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Memberships(HashMap<String, HashSet<String>>);

impl Memberships {
    /// True if two owners are members of one project.
    pub fn share(&self, one: &str, other: &str) -> bool {
        let (Some(of_one), Some(of_other)) = (self.0.get(one), self.0.get(other)) else {
            return false;
        };
        !of_one.is_disjoint(of_other)
    }
}

row! {
    struct Row {
        id: String,
        display_name: String,
        created_at: i64,
    }
}

impl Row {
    fn with(self, mut members: Vec<String>) -> Result<Project> {
        let corrupt =
            || Error::CorruptRow { name: format!("projects/{}", self.id), fault: "id".to_owned() };
        members.sort();
        Ok(Project {
            id: Uuid::try_parse(&self.id).map_err(|_| corrupt())?.into(),
            display_name: self.display_name,
            members,
            created: from_micros(self.created_at),
        })
    }
}

impl Projects<'_> {
    /// Makes a project.
    ///
    /// # Errors
    /// [`Error::TooManyMembers`], [`Error::TooManyProjects`], [`Error::DiskFull`], database errors.
    pub async fn create(&self, display_name: &str, members: &[String]) -> Result<Project> {
        self.store.admit()?;
        let id = ProjectId::generate();
        let mut tx = self.store.inner.database.write().await?;
        let count: i64 = query_scalar("select count(*) from projects").fetch_one(&mut tx).await?;
        if count >= MAX_PROJECTS {
            return Err(Error::TooManyProjects { limit: MAX_PROJECTS });
        }
        query("insert into projects (id, display_name, created_at) values ($1, $2, $3)")
            .bind(id.uuid().to_string())
            .bind(display_name)
            .bind(self.store.now_micros())
            .execute(&mut tx)
            .await?;
        replace_members(&mut tx, id, members.iter().cloned().collect()).await?;
        let project = fetch(&mut tx, id).await?;
        tx.commit().await?;
        Ok(project)
    }

    /// Returns a project.
    ///
    /// # Errors
    /// [`Error::NotFound`].
    pub async fn get(&self, id: ProjectId) -> Result<Project> {
        let row: Option<Row> = query("select * from projects where id = $1")
            .bind(id.uuid().to_string())
            .fetch_optional(self.store.inner.database.read())
            .await?;
        let row = row.ok_or_else(|| Error::NotFound { name: id.to_string() })?;
        let members = query_scalar("select owner from project_members where project = $1")
            .bind(id.uuid().to_string())
            .fetch_all(self.store.inner.database.read())
            .await?;
        row.with(members)
    }

    /// A page of projects, newest first: all, or those that an owner is a member of.
    ///
    /// # Errors
    /// [`Error::InvalidPageToken`].
    pub async fn list(&self, page: &PageRequest, member: Option<&str>) -> Result<Page<Project>> {
        const LISTING: &str = "projects";
        let mut sql = Builder::new("select p.* from projects as p where p.id < ");
        sql.push_bind(page.before(LISTING)?);
        if let Some(member) = member {
            sql.push(" and p.id in (select project from project_members where owner = ");
            sql.push_bind(member).push(")");
        }
        sql.push(" order by p.id desc limit ").push_bind(page.fetch());
        let rows: Vec<Row> = sql.build().fetch_all(self.store.inner.database.read()).await?;
        let mut sql = Builder::new("select project, owner from project_members where project in (");
        sql.push_list(rows.iter().map(|row| row.id.as_str())).push(")");
        let pairs: Vec<(String, String)> =
            sql.build().fetch_all(self.store.inner.database.read()).await?;
        let mut members: HashMap<String, Vec<String>> = HashMap::new();
        for (project, owner) in pairs {
            members.entry(project).or_default().push(owner);
        }
        let items = rows.into_iter().map(|row| {
            let members = members.remove(&row.id).unwrap_or_default();
            row.with(members)
        });
        let items = items.collect::<Result<_>>()?;
        Ok(Page::cut(items, page, LISTING, |p: &Project| (p.id.uuid(), String::new())))
    }

    /// Changes a project.
    ///
    /// # Errors
    /// [`Error::NotFound`], [`Error::TooManyMembers`].
    pub async fn update(&self, id: ProjectId, change: &ProjectChange) -> Result<Project> {
        let mut tx = self.store.inner.database.write().await?;
        let before = fetch(&mut tx, id).await?;
        if let Some(name) = &change.display_name {
            query("update projects set display_name = $2 where id = $1")
                .bind(id.uuid().to_string())
                .bind(name)
                .execute(&mut tx)
                .await?;
        }
        let MemberChange { all, add, remove } = &change.members;
        let mut members: BTreeSet<String> =
            all.as_ref().unwrap_or(&before.members).iter().cloned().collect();
        members.extend(add.iter().cloned());
        members.retain(|member| !remove.contains(member));
        replace_members(&mut tx, id, members).await?;
        let project = fetch(&mut tx, id).await?;
        tx.commit().await?;
        Ok(project)
    }

    /// Deletes a project. What its members have stays.
    ///
    /// # Errors
    /// [`Error::NotFound`].
    pub async fn delete(&self, id: ProjectId) -> Result<()> {
        let mut tx = self.store.inner.database.write().await?;
        let deleted = query("delete from projects where id = $1")
            .bind(id.uuid().to_string())
            .execute(&mut tx)
            .await?;
        if deleted == 0 {
            return Err(Error::NotFound { name: id.to_string() });
        }
        query("delete from project_members where project = $1")
            .bind(id.uuid().to_string())
            .execute(&mut tx)
            .await?;
        tx.commit().await
    }

    /// The projects of all owners.
    ///
    /// # Errors
    /// Database errors.
    pub async fn memberships(&self) -> Result<Memberships> {
        let pairs: Vec<(String, String)> = query("select owner, project from project_members")
            .fetch_all(self.store.inner.database.read())
            .await?;
        let mut memberships = Memberships::default();
        for (owner, project) in pairs {
            memberships.0.entry(owner).or_default().insert(project);
        }
        Ok(memberships)
    }
}

async fn fetch(tx: &mut Transaction, id: ProjectId) -> Result<Project> {
    let key = id.uuid().to_string();
    let row: Option<Row> =
        query("select * from projects where id = $1").bind(&key).fetch_optional(&mut *tx).await?;
    let row = row.ok_or_else(|| Error::NotFound { name: id.to_string() })?;
    let members = query_scalar("select owner from project_members where project = $1")
        .bind(&key)
        .fetch_all(&mut *tx)
        .await?;
    row.with(members)
}

async fn replace_members(
    tx: &mut Transaction,
    id: ProjectId,
    members: BTreeSet<String>,
) -> Result<()> {
    if members.len() > MAX_MEMBERS {
        return Err(Error::TooManyMembers { limit: MAX_MEMBERS });
    }
    let key = id.uuid().to_string();
    query("delete from project_members where project = $1").bind(&key).execute(&mut *tx).await?;
    for member in members {
        query("insert into project_members (project, owner) values ($1, $2)")
            .bind(&key)
            .bind(member)
            .execute(&mut *tx)
            .await?;
    }
    Ok(())
}

/// Adds the condition that a column has an owner, or one who shares a project with it.
pub(crate) fn push_shared_with(sql: &mut Builder, column: &str, owner: &str) {
    sql.push(format_args!(" and ({column} = ")).push_bind(owner);
    sql.push(format_args!(
        " or {column} in (select fellow.owner from project_members as mine
             join project_members as fellow on fellow.project = mine.project
             where mine.owner = "
    ));
    sql.push_bind(owner).push("))");
}

#[cfg(test)]
mod tests;
