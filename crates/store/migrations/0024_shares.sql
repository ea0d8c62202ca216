-- Shares: keys that are limited to one twin. Their scopes are words that older programs do not know, so that such a key
-- opens nothing there.
alter table keys add column twin text;
-- What a share ends with: the id of the key that made it, or, if that came of a sign-in, the person (`signed_in_as`).
-- Null: made with the client token.
alter table keys add column shared_by text;
create index keys_by_twin on keys (twin, id) where twin is not null;
create index keys_by_sharer on keys (shared_by) where shared_by is not null;
