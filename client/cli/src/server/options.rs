//! Server options from all their sources: defaults < file < environment < flags.

use anyhow::Context as _;
use bendtwin_server::{ClientTokenPolicy, DatabaseUrl, ObjectsUrl, Options, Tls, WorkerTls};

use super::Server;
use crate::failure::Usage;

/// The argument that makes a worker end with the server that started it.
const END_WITH_SERVER: &str = "--exit-with-parent";

impl Server {
    /// The options in force. The environment is read with the flags, which win over it.
    pub(super) fn options(&self) -> anyhow::Result<Options> {
        let mut options = match &self.config {
            None => Options::default(),
            Some(path) => {
                let text = std::fs::read_to_string(path)
                    .with_context(|| format!("cannot read the options {}", path.display()))?;
                toml::from_str(&text)
                    .map_err(|e| Usage::error(format!("{}: {e}", path.display())))?
            }
        };
        if let Some(listen) = self.listen {
            options.listen = listen;
        }
        if let Some(listen) = self.worker_listen {
            options.worker_listen = listen;
        }
        if let Some(hosts) = &self.allowed_hosts {
            options.allowed_hosts.clone_from(hosts);
        }
        match self.client_token.as_deref() {
            Some("none") => options.client_token = ClientTokenPolicy::None,
            Some(_) => options.client_token = ClientTokenPolicy::Required,
            None => {}
        }
        self.set_tls(&mut options);
        if let Some(by_proxy) = self.tls_terminated_by_proxy {
            options.tls_terminated_by_proxy = by_proxy;
        }
        if let Some(insecure) = self.insecure {
            options.insecure = insecure;
        }
        if let Some(data_dir) = &self.data_dir {
            options.data_dir.clone_from(data_dir);
        }
        if let Some(url) = &self.database {
            // Not read by clap, whose message would repeat it with its password.
            let url = DatabaseUrl::parse(url);
            options.database_url = Some(url.map_err(|e| Usage::error(e.to_string()))?);
        }
        if let Some(url) = &self.objects {
            // Not read by clap, either: people put keys where they do not belong.
            let url = ObjectsUrl::parse(url);
            options.objects_url = Some(url.map_err(|e| Usage::error(e.to_string()))?);
        }
        if let Some(count) = self.workers {
            options.workers.count = count;
        }
        if let Some(backend) = self.backend {
            options.workers.backend = backend.to_string();
        }
        if let Some(devices) = &self.devices {
            options.workers.devices.clone_from(devices);
        }
        if let Some(memory) = self.memory_mib {
            options.memory_mib = Some(memory);
        }
        if let Some(memory) = self.workers_memory_mib {
            options.workers.memory_mib = Some(memory);
        }
        if let Some(token) = &self.worker_token {
            options.worker_token = Some(token.clone());
        }
        if let Some(expiry) = self.upload_expiry {
            options.upload_expiry_s = expiry;
        }
        if let Some(floor) = self.disk_floor_mib {
            options.disk_floor_mib = floor;
        }
        let args = &mut options.workers.args;
        if args.first().is_some_and(|a| a == "worker") && !args.iter().any(|a| a == END_WITH_SERVER)
        {
            args.push(END_WITH_SERVER.to_owned());
        }
        options.validate().map_err(|faults| Usage::error(faults.join("; ")))?;
        Ok(options)
    }

    /// Sets the certificates; files that belong together are given together.
    fn set_tls(&self, options: &mut Options) {
        if let (Some(certificate), Some(key)) = (&self.tls_certificate, &self.tls_key) {
            options.tls = Some(Tls { certificate: certificate.clone(), key: key.clone() });
        }
        let files = (&self.worker_tls_certificate, &self.worker_tls_key, &self.worker_tls_ca);
        if let (Some(listen), (Some(certificate), Some(key), Some(ca))) =
            (self.worker_tls_listen, files)
        {
            let (certificate, key) = (certificate.clone(), key.clone());
            let (client_ca, crl) = (ca.clone(), self.worker_tls_crl.clone());
            options.worker_tls = Some(WorkerTls { listen, certificate, key, client_ca, crl });
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use bendtwin_backends as backends;

    use super::*;

    fn server() -> Server {
        Server {
            config: None,
            listen: None,
            worker_listen: None,
            allowed_hosts: None,
            client_token: None,
            tls_certificate: None,
            tls_key: None,
            worker_tls_listen: None,
            worker_tls_certificate: None,
            worker_tls_key: None,
            worker_tls_ca: None,
            worker_tls_crl: None,
            tls_terminated_by_proxy: None,
            insecure: None,
            data_dir: None,
            database: None,
            objects: None,
            workers: None,
            backend: None,
            devices: None,
            memory_mib: None,
            workers_memory_mib: None,
            worker_token: None,
            upload_expiry: None,
            disk_floor_mib: None,
            port_file: None,
            exit_with_parent: false,
        }
    }

    #[test]
    fn flags_win_over_the_file_and_the_file_over_defaults() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("config.toml");
        std::fs::write(
            &path,
            "data_dir = \"from-file\"\nlease_s = 12.0\n[workers]\ncount = 3\ndevices = [1]\n",
        )
        .unwrap();
        let backend = Some(backends::Choice::Cuda);
        let args = Server { config: Some(path), workers: Some(2), backend, ..server() };
        let options = args.options().unwrap();
        assert_eq!(options.data_dir, PathBuf::from("from-file"));
        assert_eq!(options.workers.count, 2);
        assert_eq!(
            (options.workers.backend.as_str(), &options.workers.devices[..]),
            ("cuda", &[1][..])
        );
        assert!((options.lease_s - 12.0).abs() < 1e-9);
        assert_eq!(options.listen, Options::default().listen);
        assert_eq!(options.workers.args, ["worker", END_WITH_SERVER]);
    }

    #[test]
    fn access_is_set_by_flags_and_checked() {
        let args = Server {
            allowed_hosts: Some(vec!["twin.example".to_owned()]),
            client_token: Some("none".to_owned()),
            ..server()
        };
        let options = args.options().unwrap();
        assert_eq!(options.allowed_hosts, ["twin.example"]);
        assert_eq!(options.client_token, ClientTokenPolicy::None);
        let wrong = Server { allowed_hosts: Some(vec!["http://twin".to_owned()]), ..server() };
        assert!(wrong.options().unwrap_err().to_string().contains("allowed_hosts"));
    }

    #[test]
    fn openness_is_set_by_flags() {
        let listen = Some("0.0.0.0:7070".parse().unwrap());
        let error = Server { listen, ..server() }.options().unwrap_err();
        assert!(error.is::<Usage>() && error.to_string().contains("--insecure"), "{error}");
        let by_proxy = Server { listen, tls_terminated_by_proxy: Some(true), ..server() };
        assert!(by_proxy.options().unwrap().tls_terminated_by_proxy);
        assert!(Server { listen, insecure: Some(true), ..server() }.options().unwrap().insecure);
    }

    #[test]
    fn faults_are_usage_and_name_the_option() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("config.toml");
        std::fs::write(&path, "lise_s = 1.0").unwrap();
        let error = Server { config: Some(path), ..server() }.options().unwrap_err();
        assert!(error.is::<Usage>() && error.to_string().contains("lise_s"), "{error}");
        let short = Server { worker_token: Some("short".into()), ..server() };
        assert!(short.options().unwrap_err().to_string().contains("worker_token"));
    }
}
