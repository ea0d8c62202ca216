//! Server options from all their sources: defaults < file < environment < flags.

use anyhow::Context as _;
use bendtwin_server::Options;
use toml::{Table, Value};

use super::Server;
use crate::failure::Usage;

/// The argument that makes a worker end with the server that started it.
const END_WITH_SERVER: &str = "--exit-with-parent";

impl Server {
    /// The options in force: the file's table, with what flags and the environment say put into it.
    pub(crate) fn options(&self) -> anyhow::Result<Options> {
        let mut table = match &self.config {
            None => Table::new(),
            Some(path) => {
                let text = std::fs::read_to_string(path)
                    .with_context(|| format!("cannot read the options {}", path.display()))?;
                // Read as options first, since faults of a text are shown with their lines.
                toml::from_str::<Options>(&text)
                    .and_then(|_| toml::from_str(&text))
                    .map_err(|e| Usage::error(format!("{}: {e}", path.display())))?
            }
        };
        self.check_paths()?;
        let given = Table::try_from(self).map_err(|e| Usage::error(e.to_string()))?;
        given.into_iter().for_each(|(key, value)| put(&mut table, &key, value));
        let mut options: Options = table.try_into().map_err(|e| Usage::error(e.to_string()))?;
        let args = &mut options.workers.args;
        if args.first().is_some_and(|a| a == "worker") && !args.iter().any(|a| a == END_WITH_SERVER)
        {
            args.push(END_WITH_SERVER.to_owned());
        }
        options.validate().map_err(|faults| Usage::error(faults.join("; ")))?;
        Ok(options)
    }

    /// Puts the address and the folder that are given into options, where not all that is given can be used.
    pub(crate) fn put_place(&self, options: Options) -> Options {
        Options {
            listen: self.listen.unwrap_or(options.listen),
            data_dir: self.data_dir.clone().unwrap_or(options.data_dir),
            ..options
        }
    }

    /// Refuses paths that a table of options cannot hold.
    fn check_paths(&self) -> anyhow::Result<()> {
        let paths = [
            ("--data-dir", &self.data_dir),
            ("--client-token-file", &self.client_token_file),
            ("--tls-certificate", &self.tls_certificate),
            ("--tls-key", &self.tls_key),
            ("--worker-tls-certificate", &self.worker_tls_certificate),
            ("--worker-tls-key", &self.worker_tls_key),
            ("--worker-tls-ca", &self.worker_tls_ca),
            ("--worker-tls-crl", &self.worker_tls_crl),
        ];
        for (flag, path) in paths {
            if let Some(path) = path.as_ref().filter(|path| path.to_str().is_none()) {
                let shown = path.display();
                return Err(Usage::error(format!(
                    "{flag}: the path {shown} is not UTF-8: rename it"
                )));
            }
        }
        Ok(())
    }
}

/// Puts a value into a table, at a key with dots between tables.
fn put(table: &mut Table, key: &str, value: Value) {
    let Some((first, rest)) = key.split_once('.') else {
        table.insert(key.to_owned(), value);
        return;
    };
    let inner = table.entry(first).or_insert_with(|| Value::Table(Table::new()));
    if let Value::Table(inner) = inner {
        put(inner, rest, value);
    }
}

#[cfg(test)]
mod tests;
