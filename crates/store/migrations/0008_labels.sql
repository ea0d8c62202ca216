-- What people write about captures, fits and twins, and what lists are searched and sorted by.
alter table captures add column note text not null default '';
-- JSON array of words, sorted. The table `tags` has the same words to search by.
alter table captures add column tags text not null default '[]';
-- Name at creation, with which a repeated creation is compared; null while it is the display name.
alter table captures add column first_name text;
-- Display name in lower case, to sort by.
alter table captures add column name_key text not null default '';
-- Display name and note in lower case, to search in; null in rows from before, until the store opens.
alter table captures add column search_text text;
create index captures_by_name on captures (name_key, id);

alter table twins add column note text not null default '';
alter table twins add column tags text not null default '[]';
alter table twins add column first_name text;
alter table twins add column name_key text not null default '';
alter table twins add column search_text text;
-- Error over frames that it was not fitted to, metres; 1e300 if there is none, which sorts last.
alter table twins add column error_m double precision not null default 1e300;
create index twins_by_name on twins (name_key, id);
create index twins_by_error on twins (error_m, id);

-- The same of fits; ingests leave it empty.
alter table jobs add column display_name text not null default '';
alter table jobs add column note text not null default '';
alter table jobs add column tags text not null default '[]';
-- Name that the creation gave; empty if none.
alter table jobs add column first_name text;
alter table jobs add column name_key text not null default '';
alter table jobs add column search_text text;
-- That of its twin, which may be gone.
alter table jobs add column error_m double precision not null default 1e300;
-- Of the iterations that are no multiples of this, only the last of each curve is kept in `losses`.
alter table jobs add column loss_stride bigint not null default 1;
create index jobs_by_name on jobs (kind, name_key, id);
create index jobs_by_error on jobs (kind, error_m, id);
create index jobs_by_kind_state_and_id on jobs (kind, state, id);

create table tags (
    -- captures, fits or twins.
    kind     text not null,
    tag      text not null,
    -- Id of the resource.
    resource text not null,
    primary key (kind, tag, resource)
);
create index tags_by_resource on tags (kind, resource);

-- Losses of fits by stage, model and iteration.
create table losses (
    fit       text   not null,
    stage     text   not null,
    variant   text   not null,
    iteration bigint not null,
    -- Null where it was not finite.
    loss      double precision,
    best_loss double precision,
    -- That of the lease under which it was computed.
    epoch     bigint not null,
    primary key (fit, stage, variant, iteration)
);
