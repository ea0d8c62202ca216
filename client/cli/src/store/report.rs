//! Outcomes of `bendtwin store` for people.

use bendtwin_server::maintenance::{
    Backup, CheckReport, CopiedTable, Damage, Migration, Relocation, Repair, Restore,
};

use crate::{output, table::Table};

/// The faults, a line each, and the conclusion.
pub(super) fn check(report: &CheckReport) -> String {
    let mut lines: Vec<String> =
        report.database.iter().map(|fault| format!("database: {fault}")).collect();
    if report.mismatch {
        lines.push("The database and the content belong to different stores.".to_owned());
    }
    lines.extend(damages(&report.damaged));
    let (blobs, size) = (report.blobs, output::bytes(report.blobs_bytes));
    let references = report.references;
    lines.push(format!("{references} references of rows to {blobs} blobs ({size})."));
    if !report.unreferenced.is_empty() {
        let size = output::bytes(report.unreferenced.iter().map(|blob| blob.size_bytes).sum());
        let count = report.unreferenced.len();
        lines.push(format!("{count} blobs have no row ({size}): the server removes them."));
    }
    lines.push(match (report.is_sound(), report.damaged.len()) {
        (true, _) => "The store is sound.".to_owned(),
        (false, count) => format!("The store is damaged: {count} references lack their content."),
    });
    lines.join("\n")
}

/// All that was done, and what stays lost.
pub(super) fn repair(done: &Repair) -> String {
    let mut lines = done.actions.clone();
    if lines.is_empty() {
        lines.push("There was nothing to repair.".to_owned());
    }
    lines.extend(damages(&done.lost));
    lines.join("\n")
}

/// The size of a copy, and what it lacks.
pub(super) fn backup(done: &Backup) -> String {
    let mut lines: Vec<String> = damages(&done.lost).into_iter().collect();
    let (blobs, size) = (done.blobs, output::bytes(done.blobs_bytes));
    let (rows, brought) = (done.tables.iter().map(|table| table.rows).sum::<u64>(), done.brought);
    let shared = match done.linked {
        0 => String::new(),
        n => format!(", {n} of them as links to the files of the store (same disk)"),
    };
    lines.push(format!("{rows} rows and {blobs} blobs ({size}); {brought} are new here{shared}."));
    lines.push(match done.client_token {
        true => "The client token is part of it.".to_owned(),
        false => {
            "There is no client token: a server of the restored store makes a new one.".to_owned()
        }
    });
    if let Some(taken) = done.manifest.taken {
        let database = &done.manifest.database;
        lines.push(format!("The backup has what {database} had at {taken:.0}."));
    }
    lines.join("\n")
}

/// What a restored store has, and how to start its server.
pub(super) fn restore(done: &Restore) -> String {
    let mut table = Table::new(["TABLE", "ROWS"]);
    for CopiedTable { name, rows, .. } in done.tables.iter().filter(|table| table.rows > 0) {
        table.row([name.clone(), rows.to_string()]);
    }
    let mut lines = vec![table.text()];
    lines.extend(damages(&done.lost));
    let Restore { database, objects, blobs, .. } = done;
    let size = output::bytes(done.blobs_bytes);
    lines.push(format!("The rows are in {database}, and {blobs} blobs ({size}) in {objects}."));
    if let Some(taken) = done.manifest.as_ref().and_then(|manifest| manifest.taken) {
        lines.push(format!("That is what the store had at {taken:.0}."));
    }
    lines.push(match done.client_token {
        true => "The client token is that of the backup.".to_owned(),
        false => "The client token is not from the backup: a server that finds none makes one."
            .to_owned(),
    });
    lines.push(
        "Start the server with the same data folder, database and place of content.".to_owned(),
    );
    lines.join("\n")
}

/// The tables that were moved, and where to.
pub(super) fn migration(done: &Migration) -> String {
    let mut table = Table::new(["TABLE", "ROWS", "BLAKE3 ON BOTH SIDES"]);
    for CopiedTable { name, rows, digest } in &done.tables {
        table.row([name.clone(), rows.to_string(), digest.clone()]);
    }
    let done_before = if done.was_moved { "had been moved before" } else { "are moved" };
    let (rows, database) = (table.text(), &done.database);
    format!(
        "{rows}\nThe rows {done_before} to {database}; the SQLite file is kept as \
         bendtwin.sqlite.migrated.\nStart the server with BENDTWIN_DATABASE_URL."
    )
}

pub(super) fn relocation(done: &Relocation) -> String {
    let Relocation { objects, blobs, blobs_bytes, damaged } = done;
    let damaged = match damaged.len() {
        0 => String::new(),
        count => format!("{count} more are damaged and were left: {}.\n", damaged.join(", ")),
    };
    format!(
        "{blobs} blobs ({blobs_bytes} bytes) are in {objects}.\n{damaged}\
         The old folder is kept as blobs.migrated.\nStart the server with BENDTWIN_OBJECTS."
    )
}

/// A table of damage; none if there is no damage.
fn damages(damages: &[Damage]) -> Option<String> {
    let mut table = Table::new(["NAME", "PART", "FAULT", "DIGEST"]);
    for damage in damages {
        let Damage { name, part, digest, fault } = damage.clone();
        table.row([name, part, fault, digest]);
    }
    (!damages.is_empty()).then(|| table.text())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damage_is_named_and_counted() {
        let damage = Damage {
            name: "twins/1".into(),
            part: "twin".into(),
            digest: "ab".into(),
            fault: "missing".into(),
        };
        let sound = CheckReport { references: 2, blobs: 1, ..CheckReport::default() };
        assert!(check(&sound).ends_with("The store is sound."), "{}", check(&sound));
        let damaged = CheckReport { damaged: vec![damage], ..sound };
        let text = check(&damaged);
        assert!(text.contains("twins/1  twin  missing  ab"), "{text}");
        assert!(text.ends_with("damaged: 1 references lack their content."), "{text}");
        assert_eq!(repair(&Repair::default()), "There was nothing to repair.");
    }
}
