-- Who recorded a capture; empty if it was not stated.
alter table captures add column recorded_by text not null default '';
create index captures_by_recorder on captures (recorded_by, id);
