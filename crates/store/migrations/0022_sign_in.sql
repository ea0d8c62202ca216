-- Keys that people get by signing in: who it was, as the identity provider names them (issuer and subject). Null: a
-- key that somebody made.
alter table keys add column signed_in_as text;
create index keys_by_person on keys (signed_in_as, id);
