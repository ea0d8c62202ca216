"""Files that HTTP alone offers, from the same address as the calls."""

from __future__ import annotations

import http.client
from urllib.parse import urlsplit

from bendtwin.captures.uploads import refusal
from bendtwin.connection.transport import Transport, tls_fault
from bendtwin.errors import BendTwinError, Category

_SILENCE_S = 300.0


def downloaded(server: Transport, path: str, token: str | None) -> bytes:
    """The content of a file."""
    host = urlsplit(server.url).netloc
    connection = (
        http.client.HTTPSConnection(host, timeout=_SILENCE_S, context=server.context())
        if server.is_https
        else http.client.HTTPConnection(host, timeout=_SILENCE_S)
    )
    headers = {} if token is None else {"authorization": f"Bearer {token}"}
    try:
        connection.request("GET", path, headers=headers)
        response = connection.getresponse()
        content = response.read()
    except (OSError, http.client.HTTPException) as error:
        fault = tls_fault(str(error))
        if fault is not None:
            raise BendTwinError(Category.FAILED_PRECONDITION, *fault) from error
        message = f"no BendTwin server answers at {server.url} ({error!r})"
        raise BendTwinError(Category.UNAVAILABLE, "SERVER_UNREACHABLE", message) from error
    finally:
        connection.close()
    if response.status >= 300:
        raise refusal(response.status, content)
    return content
