//! Settings of both ends of a connection, from files.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use rustls::{
    ClientConfig, DigitallySignedStruct, RootCertStore, ServerConfig, SignatureScheme,
    client::{
        VerifierBuilderError, WebPkiServerVerifier,
        danger::{HandshakeSignatureValid, ServerCertVerified, ServerCertVerifier},
    },
    crypto::{CryptoProvider, ring, verify_tls12_signature, verify_tls13_signature},
    pki_types::{CertificateDer, ServerName, UnixTime},
    server::{WebPkiClientVerifier, danger::ClientCertVerifier},
    version::TLS13,
};

use crate::{
    Certificate, FileError, RevocationList,
    files::{self, unusable},
    revocation,
};

/// Protocols of a listener, by preference.
const PROTOCOLS: [&[u8]; 2] = [b"h2", b"http/1.1"];

/// Files of a certificate and its key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PairPaths {
    /// The certificate, and after it those that issued it.
    pub certificate: PathBuf,
    /// Private key.
    pub key: PathBuf,
}

/// Files of a peer among those of one private authority.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MutualPaths {
    /// Certificate and key.
    pub pair: PairPaths,
    /// The certificates of the authority.
    pub ca: PathBuf,
    /// The list of those that it has revoked, if there is one.
    pub crl: Option<PathBuf>,
}

/// Settings of a listener that shows a certificate and demands none.
#[derive(Debug)]
pub struct Public {
    /// Settings of the server's connections.
    pub server: Arc<ServerConfig>,
    /// Certificate shown to peers.
    pub certificate: Option<Certificate>,
}

/// Settings of a peer that shows its certificate, on connections begun by either side, and demands
/// one of the private authority of the other side. TLS 1.3 only: both ends are BendTwin.
#[derive(Debug)]
pub struct Mutual {
    /// Settings of connections that others begin.
    pub server: Arc<ServerConfig>,
    /// Settings of connections that this side begins, over HTTP/2.
    pub client: Arc<ClientConfig>,
    /// Certificate shown to the other side.
    pub certificate: Option<Certificate>,
    /// Lists of revoked certificates, which are refused on connections begun by either side.
    pub lists: Vec<RevocationList>,
    pub(crate) clients: Arc<dyn ClientCertVerifier>,
    pub(crate) servers: Arc<WebPkiServerVerifier>,
}

/// Settings of a client that trusts the authorities of a file, or without one those of the system.
/// The caller adds the protocols that it speaks.
///
/// # Errors
/// If the file cannot be used.
pub fn client_config(ca: Option<&Path>) -> Result<ClientConfig, FileError> {
    let roots = match ca {
        Some(path) => files::authorities(path)?,
        None => of_the_system(),
    };
    let place = || ca.unwrap_or(Path::new("TLS")).to_owned();
    let builder = ClientConfig::builder_with_provider(provider())
        .with_safe_default_protocol_versions()
        .map_err(|fault| unusable(&place(), fault))?;
    Ok(builder.with_root_certificates(roots).with_no_client_auth())
}

/// Settings of a client that accepts any certificate, for a question to a process of this machine that
/// neither shows nor tells anything secret, such as whether a server is ready. A certificate that has
/// expired, or that was replaced a moment ago, must not make a healthy server look broken.
///
/// # Errors
/// If TLS cannot be set up.
pub fn unverified_client_config() -> Result<ClientConfig, FileError> {
    let builder = ClientConfig::builder_with_provider(provider())
        .with_safe_default_protocol_versions()
        .map_err(|fault| unusable(Path::new("TLS"), fault))?;
    let verifier = Arc::new(AnyCertificate(provider()));
    Ok(builder.dangerous().with_custom_certificate_verifier(verifier).with_no_client_auth())
}

/// Accepts every certificate whose key the other side has.
#[derive(Debug)]
struct AnyCertificate(Arc<CryptoProvider>);

impl ServerCertVerifier for AnyCertificate {
    fn verify_server_cert(
        &self,
        _end_entity: &CertificateDer<'_>,
        _intermediates: &[CertificateDer<'_>],
        _server_name: &ServerName<'_>,
        _ocsp_response: &[u8],
        _now: UnixTime,
    ) -> Result<ServerCertVerified, rustls::Error> {
        Ok(ServerCertVerified::assertion())
    }

    fn verify_tls12_signature(
        &self,
        message: &[u8],
        certificate: &CertificateDer<'_>,
        signature: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, rustls::Error> {
        let algorithms = &self.0.signature_verification_algorithms;
        verify_tls12_signature(message, certificate, signature, algorithms)
    }

    fn verify_tls13_signature(
        &self,
        message: &[u8],
        certificate: &CertificateDer<'_>,
        signature: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, rustls::Error> {
        let algorithms = &self.0.signature_verification_algorithms;
        verify_tls13_signature(message, certificate, signature, algorithms)
    }

    fn supported_verify_schemes(&self) -> Vec<SignatureScheme> {
        self.0.signature_verification_algorithms.supported_schemes()
    }
}

impl Public {
    /// Settings from files.
    ///
    /// # Errors
    /// If the files cannot be used.
    pub fn load(paths: &PairPaths) -> Result<Self, FileError> {
        let (chain, key) = (files::certificates(&paths.certificate)?, files::key(&paths.key)?);
        let certificate = chain.first().and_then(Certificate::of);
        let builder = ServerConfig::builder_with_provider(provider())
            .with_safe_default_protocol_versions()
            .map_err(|fault| unusable(&paths.certificate, fault))?;
        let server = builder.with_no_client_auth().with_single_cert(chain, key);
        let mut server = server.map_err(|fault| of_pair(paths, fault))?;
        server.alpn_protocols = PROTOCOLS.map(<[u8]>::to_vec).into();
        Ok(Self { server: server.into(), certificate })
    }
}

impl PairPaths {
    /// The files, to be watched.
    pub fn all(&self) -> Vec<PathBuf> {
        vec![self.certificate.clone(), self.key.clone()]
    }
}

impl MutualPaths {
    /// The files, to be watched.
    pub fn all(&self) -> Vec<PathBuf> {
        let mut paths = self.pair.all();
        paths.push(self.ca.clone());
        paths.extend(self.crl.clone());
        paths
    }
}

impl Mutual {
    /// Settings from files.
    ///
    /// # Errors
    /// If the files cannot be used.
    pub fn load(paths: &MutualPaths) -> Result<Self, FileError> {
        let MutualPaths { pair, ca, crl } = paths;
        let chain = files::certificates(&pair.certificate)?;
        let key = files::key(&pair.key)?;
        let roots = Arc::new(files::authorities(ca)?);
        let (crls, lists) = match crl {
            Some(path) => revocation::load(path, &files::certificates(ca)?)?,
            None => Default::default(),
        };
        let certificate = chain.first().and_then(Certificate::of);
        let of_ca = |fault: &dyn std::fmt::Display| unusable(ca, fault);
        let of_verifier = |fault: VerifierBuilderError| match (crl, fault) {
            (Some(path), fault @ VerifierBuilderError::InvalidCrl(_)) => unusable(path, fault),
            (_, fault) => of_ca(&fault),
        };

        // Checking end entities suffices: authorities sign them directly, and intermediates are listed as
        // authorities, too.
        let clients = WebPkiClientVerifier::builder_with_provider(roots.clone(), provider())
            .with_crls(crls.clone())
            .only_check_end_entity_revocation()
            .build()
            .map_err(of_verifier)?;
        let server = ServerConfig::builder_with_provider(provider())
            .with_protocol_versions(&[&TLS13])
            .map_err(|fault| of_ca(&fault))?
            .with_client_cert_verifier(clients.clone())
            .with_single_cert(chain.clone(), key.clone_key());
        let mut server = server.map_err(|fault| of_pair(pair, fault))?;
        server.alpn_protocols = PROTOCOLS.map(<[u8]>::to_vec).into();

        let servers = WebPkiServerVerifier::builder_with_provider(roots, provider())
            .with_crls(crls)
            .only_check_end_entity_revocation()
            .build()
            .map_err(of_verifier)?;
        let client = ClientConfig::builder_with_provider(provider())
            .with_protocol_versions(&[&TLS13])
            .map_err(|fault| of_ca(&fault))?
            .with_webpki_verifier(servers.clone())
            .with_client_auth_cert(chain, key);
        let mut client = client.map_err(|fault| of_pair(pair, fault))?;
        client.alpn_protocols = vec![b"h2".to_vec()];
        Ok(Self {
            server: server.into(),
            client: client.into(),
            certificate,
            lists,
            clients,
            servers,
        })
    }
}

/// The single implementation of cryptography, shared with the database driver.
fn provider() -> Arc<CryptoProvider> {
    Arc::new(ring::default_provider())
}

/// Authorities that the system trusts. A system without any has servers of private authorities
/// alone, whose certificates are refused with an advice then.
fn of_the_system() -> RootCertStore {
    let found = rustls_native_certs::load_native_certs();
    for error in &found.errors {
        tracing::debug!(%error, "an authority of the system is left out");
    }
    let mut roots = RootCertStore::empty();
    roots.add_parsable_certificates(found.certs);
    roots
}

fn of_pair(paths: &PairPaths, fault: rustls::Error) -> FileError {
    match fault {
        rustls::Error::InconsistentKeys(_) => FileError::KeyMismatch {
            certificate: paths.certificate.clone(),
            key: paths.key.clone(),
        },
        fault => unusable(&paths.certificate, fault),
    }
}
