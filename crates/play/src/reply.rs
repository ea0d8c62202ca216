//! Messages to a browser beside states and facts.

use serde::Serialize;
use serde_json::Value;

/// A command was refused and changed nothing; `problem` is the document of the error.
pub fn refused(problem: Value) -> String {
    #[derive(Serialize)]
    struct Refused {
        r#type: &'static str,
        problem: Value,
    }
    text(&Refused { r#type: "refused", problem })
}

/// The last message of a play, with the document of the error that ended it, if one did.
pub fn ended(problem: Option<Value>) -> String {
    #[derive(Serialize)]
    struct Ended {
        r#type: &'static str,
        problem: Option<Value>,
    }
    text(&Ended { r#type: "ended", problem })
}

/// An event, with a sentence for the player.
pub(crate) fn notice(event: &'static str, said: &str) -> String {
    #[derive(Serialize)]
    struct Notice<'a> {
        r#type: &'static str,
        event: &'static str,
        text: &'a str,
    }
    text(&Notice { r#type: "notice", event, text: said })
}

fn text(message: &impl Serialize) -> String {
    // Nothing in these messages fails to be written.
    serde_json::to_string(message).unwrap_or_default()
}
