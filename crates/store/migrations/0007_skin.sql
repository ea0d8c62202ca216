-- Number of points of the twin's skin; null for twins that were stored before it was counted, whose skin
-- is their surface nodes.
alter table twins add column skin_point_count bigint;
