-- The newest preview of each fit that runs, or that ended without a twin.
create table previews (
    fit        text   primary key,
    created_at bigint not null,
    -- Up to a hundred thousand characters, which only servers read.
    content    text   not null
);

-- Error over the training frames with the best parameters up to the iteration [m]; null where none was measured.
alter table losses add column error_m double precision;

-- Kind of the error of a fit's twin: track, coordinate or chamfer; null where it is not known.
alter table jobs add column measure text;
