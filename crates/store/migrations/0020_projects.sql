-- Projects: sets of owners who share what each of them has.
create table projects (
    id           text   primary key,
    display_name text   not null,
    created_at   bigint not null
);
create table project_members (
    project text not null,
    -- Name of an owner, as in the column `owner` of other tables.
    owner   text not null,
    primary key (project, owner)
);
create index project_members_by_owner on project_members (owner, project);
