//! The data folder: its database, its disk and its user.

use std::path::Path;

use bendtwin_server::maintenance::{FolderState, folder_state};

use super::check::Check;
use crate::output;

const NAME: &str = "data";

/// The check of a folder, with the free space below which a server refuses content [MiB].
pub(super) async fn check(folder: &Path, floor_mib: u64) -> Check {
    let shown = folder.display();
    match folder_state(folder).await {
        Ok(state) => judged(&shown.to_string(), &state, floor_mib),
        Err(error) => Check::problem(NAME, format!("{shown}: {error}")),
    }
}

fn judged(folder: &str, state: &FolderState, floor_mib: u64) -> Check {
    let free = output::bytes(state.free_bytes);
    if state.too_new {
        let advice = "it was made by a newer version of BendTwin: use that one";
        return Check::problem(NAME, format!("{folder} cannot be opened: {advice}"));
    }
    if !state.writable {
        let advice = "give it to this user, or name another one with --data-dir";
        return Check::problem(NAME, format!("{folder} cannot be written: {advice}"));
    }
    if state.free_bytes >> 20 < floor_mib {
        let advice = "free space, or delete captures and twins";
        let refused = format!("{free} are free, less than {floor_mib} MiB: content is refused");
        return Check::problem(NAME, format!("{folder}: {refused}; {advice}"));
    }
    let what = match (state.exists, state.in_use, state.schema) {
        (_, true, _) => "a server has it open",
        (true, _, Some(_)) => "no server has it open",
        (true, _, None) => "no server has used it yet",
        (false, ..) => "it is made when a server starts",
    };
    Check::ok(NAME, format!("{folder}: {what}; {free} free"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::check::State;

    const GOOD: FolderState = FolderState {
        exists: true,
        writable: true,
        in_use: false,
        free_bytes: 10 << 30,
        schema: Some(3),
        too_new: false,
    };

    #[test]
    fn what_a_server_would_refuse_is_a_problem() {
        assert_eq!(judged("d", &GOOD, 256).state, State::Ok);
        let cases = [
            (FolderState { too_new: true, ..GOOD }, "newer"),
            (FolderState { writable: false, ..GOOD }, "--data-dir"),
            (FolderState { free_bytes: 1 << 20, ..GOOD }, "free space"),
        ];
        for (state, word) in cases {
            let check = judged("d", &state, 256);
            assert!(check.state == State::Problem && check.message.contains(word), "{check:?}");
        }
    }
}
