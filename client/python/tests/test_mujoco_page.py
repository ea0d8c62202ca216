"""The snippets of docs/use/mujoco.md, one after the other, against a real server."""

import os
import re
from pathlib import Path

import pytest
from scenes import hanging
from server import needs_server, running
from test_coupling import wait_for_worker

from bendtwin import Client

pytest.importorskip("mujoco")

PAGE = Path(__file__).parents[3] / "docs" / "use" / "mujoco.md"

pytestmark = [
    needs_server,
    pytest.mark.skipif(not PAGE.is_file(), reason="no docs folder beside the package"),
]


def test_the_page_leads_to_a_coupled_simulation(tmp_path, capsys):
    (tmp_path / "cable").write_bytes(hanging().encode())
    page, names = PAGE.read_text(), {}
    snippets = re.findall(r"^```python\n(.*?)^```", page, re.DOTALL | re.MULTILINE)
    assert len(snippets) == 7
    with running(tmp_path) as address:
        with Client(address) as client:
            client.import_twin(tmp_path / "cable")
            wait_for_worker(client)
        for snippet in snippets:
            code = snippet.replace("127.0.0.1:7070", address)
            line = page[: page.index(snippet)].count("\n")
            # The page is the file in tracebacks, at its own lines.
            exec(compile("\n" * line + code, os.fspath(PAGE), "exec"), names)
        names["client"].close()
    said = capsys.readouterr().out
    assert "[TOO_FAST]" in said
    assert len(names["reached"]) == 3
    # Pulling down takes more force than going up.
    assert names["reached"][-0.04] > names["reached"][0.04] + 1
