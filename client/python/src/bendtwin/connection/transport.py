"""The address of a server, TLS if it is `https://`, and what to do about TLS that fails."""

from __future__ import annotations

import os
import ssl
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import grpc

_HTTPS_PORT = 443


@dataclass(frozen=True)
class Transport:
    """The way to a server."""

    #: `host:port`.
    target: str
    #: True for TLS.
    is_https: bool
    #: File with the certificate of the server's authority; None for the authorities of the system.
    ca: Path | None

    @property
    def url(self) -> str:
        """The address as a URL."""
        return f"{'https' if self.is_https else 'http'}://{self.target}"

    def credentials(self) -> grpc.ChannelCredentials:
        """Credentials of a gRPC channel over TLS."""
        roots = self.ca
        if roots is None:
            system = ssl.get_default_verify_paths().cafile
            roots = Path(system) if system is not None else None
        return grpc.ssl_channel_credentials(None if roots is None else roots.read_bytes())

    def context(self) -> ssl.SSLContext:
        """Settings of TLS for HTTP."""
        return ssl.create_default_context(cafile=self.ca)


def transport(address: str, ca: str | PathLike[str] | None) -> Transport:
    """The way to `host:port`, `http://host:port` or `https://host:port`.

    `ca` is the file with the certificate of the server's authority, else that of `BENDTWIN_CA`.
    """
    target, is_https = address.rstrip("/").removeprefix("http://"), False
    if target.startswith("https://"):
        target, is_https = target.removeprefix("https://"), True
        if ":" not in target.rpartition("]")[2]:
            target = f"{target}:{_HTTPS_PORT}"
    found = ca if ca is not None else os.environ.get("BENDTWIN_CA") or None
    return Transport(target, is_https, None if found is None else Path(found))


def http1_fault(details: str) -> tuple[str, str] | None:
    """Reason and message for an answer of HTTP/1 where gRPC was expected, from what gRPC says."""
    if "http1.x server" not in details.lower():
        return None
    return "PROXY_WITHOUT_GRPC", (
        "the server answers with HTTP/1, and gRPC takes HTTP/2: let the proxy in front of it pass "
        "HTTP/2 on (nginx: `http2 on` and `grpc_pass`), or name the address of the server itself"
    )


def tls_fault(details: str) -> tuple[str, str] | None:
    """Reason and message for a connection that failed for its TLS, from what OpenSSL says."""
    text = details.lower()
    if "wrong_version_number" in text:
        return "TLS_NOT_SPOKEN", "the server does not speak TLS: use http:// in its address"
    if (
        "hostname verification" in text
        or "hostname mismatch" in text
        or "ip address mismatch" in text
    ):
        return "TLS_CERTIFICATE_REFUSED", (
            "the certificate of the server is not for this host: use one of its names in the "
            "address, or have a certificate issued that has this one"
        )
    if "certificate_verify_failed" not in text:
        return None
    if "expired" in text:
        advice = "has expired: have it replaced there, or check the clock of this machine"
    elif "not yet valid" in text:
        advice = "does not hold yet: check the clocks of both machines"
    else:
        advice = (
            "is of an authority that is not trusted here: name the certificate of that authority "
            "(Client(..., ca=FILE), BENDTWIN_CA)"
        )
    return "TLS_CERTIFICATE_REFUSED", f"the certificate of the server {advice}"
