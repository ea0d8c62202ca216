-- The level of trust of the twin's assessment: good, fair, poor or unknown, and empty without one; null in rows of
-- older programs, until the store opens.
alter table twins add column level text;
create index twins_by_level on twins (level, id);
