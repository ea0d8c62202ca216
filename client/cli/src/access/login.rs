//! `bendtwin login`, `logout` and `whoami`: sign-in of a person at a server. The key that comes of it
//! is kept in a file for that server, where all commands and clients find it.

use std::time::Instant;

use anyhow::{Context as _, bail};
use bendtwin_client::{Client, DeviceCode, MadeKey, token};
use clap::Args;

use crate::{global::Global, output};

#[derive(Debug, Args)]
pub(crate) struct Login {
    /// Only print the address; do not open a browser
    #[arg(long)]
    no_browser: bool,
}

pub(crate) async fn log_in(args: Login, global: &Global) -> anyhow::Result<()> {
    // What is kept from before may have expired.
    let client = Client::connect_with(&global.server, None, global.ca.as_deref()).await?;
    let code = client.sign_ins().start_device().await?;
    tell(&code, args.no_browser);
    let MadeKey { key, secret_key } = confirmed(&client, &code).await?;
    // A file that cannot be used has no key that could be revoked.
    let earlier = token::sign_in_of(&global.server).ok().flatten();
    let path = token::keep_sign_in(&global.server, &secret_key)
        .context("signed in, but the key cannot be kept")?;
    if let Some(earlier) = earlier
        && let Err(error) = revoke(&earlier, global).await
    {
        eprintln!("The key of the earlier sign-in stays valid until it expires: {error}");
    }
    for variable in [token::TOKEN_VARIABLE, token::FILE_VARIABLE] {
        if std::env::var_os(variable).is_some_and(|value| !value.is_empty()) {
            eprintln!("{variable} is set, and goes before the sign-in: unset it to use this");
        }
    }
    output::print(global, &key, || {
        let until = key.expire_time.map(|time| format!(" until {time:.0}")).unwrap_or_default();
        format!("signed in as {}{until}; the key is in {}", key.owner, path.display())
    })
}

/// Says what to do, on standard error: the output is the result.
fn tell(code: &DeviceCode, no_browser: bool) {
    let DeviceCode { verification_uri, verification_uri_complete, user_code, .. } = code;
    eprintln!("Open {} and enter the code {}", shown(verification_uri), shown(user_code));
    if no_browser {
        return;
    }
    let address = match verification_uri_complete.is_empty() {
        true => verification_uri,
        false => verification_uri_complete,
    };
    // The system would run what another kind of address names, and the server is only believed here.
    if !["https://", "http://"].iter().any(|scheme| address.starts_with(scheme)) {
        return;
    }
    if let Err(error) = open::that_detached(address) {
        eprintln!("No browser could be opened here ({error}): any other device will do.");
    }
}

/// Text without characters that change how a terminal shows the others.
fn shown(text: &str) -> String {
    let is_shown = |c: &char| c.is_alphanumeric() || c.is_ascii_graphic() || *c == ' ';
    text.chars().filter(is_shown).collect()
}

/// Waits until the person has confirmed the sign-in.
async fn confirmed(client: &Client, code: &DeviceCode) -> anyhow::Result<MadeKey> {
    let begun = Instant::now();
    let mut delay = code.interval;
    loop {
        tokio::time::sleep(delay).await;
        match client.sign_ins().create(code, delay).await? {
            Ok(made) => return Ok(made),
            Err(next) => delay = next,
        }
        if begun.elapsed() > code.expires_in {
            bail!("nobody confirmed the sign-in in time: run the command again");
        }
    }
}

pub(crate) async fn log_out(global: &Global) -> anyhow::Result<()> {
    let Some(key) = token::sign_in_of(&global.server)? else {
        return output::print(global, &(), || format!("not signed in at {}", global.server));
    };
    revoke(&key, global).await?;
    token::forget_sign_in(&global.server).context("the key of the sign-in cannot be removed")?;
    output::print(global, &(), || format!("signed out of {}", global.server))
}

/// Revokes the key of a sign-in, which may have ended already.
async fn revoke(key: &str, global: &Global) -> Result<(), bendtwin_client::Error> {
    let client = Client::connect_with(&global.server, Some(key), global.ca.as_deref()).await?;
    match client.sign_ins().delete().await {
        Err(error) if !["SIGN_IN_ENDED", "BAD_CLIENT_TOKEN"].contains(&error.reason()) => {
            Err(error)
        }
        _ => Ok(()),
    }
}

pub(crate) async fn who_am_i(global: &Global) -> anyhow::Result<()> {
    let caller = global.connect().await?.sign_ins().caller().await?;
    output::print(global, &caller, || {
        let owner = if caller.owner.is_empty() { "anyone" } else { caller.owner.as_str() };
        let by = match (caller.is_sign_in, caller.key.is_empty()) {
            (true, _) => "signed in".to_owned(),
            (false, false) => format!("with {}", caller.key),
            (false, true) => "with the token of the server, or without one".to_owned(),
        };
        let until = caller.expire_time.map(|time| format!(" until {time:.0}")).unwrap_or_default();
        format!("{owner}, {by}{until}\nscopes: {}", caller.scopes.join(", "))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_code_has_nothing_that_changes_the_terminal() {
        assert_eq!(shown("AB\u{1b}[2J-\u{202e}CD\u{200b}\u{feff}\u{e0041}\u{ad}\n"), "AB[2J-CD");
        assert_eq!(shown("https://id.example/activate"), "https://id.example/activate");
    }
}
