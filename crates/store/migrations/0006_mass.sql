-- Mass of the object in kilograms, as the twin's file says; null where it does not.
alter table twins add column mass_kg double precision;
