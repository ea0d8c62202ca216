"""The Python of docs/use/ros.md, one block after the other, against a real server."""

from __future__ import annotations

import os
import re

import pytest
from server import needs_server

from conftest import ROOT
from made_ros import cable_file

PAGE = ROOT.parents[1] / "docs" / "use" / "ros.md"

pytestmark = [
    needs_server,
    pytest.mark.skipif(not PAGE.is_file(), reason="no docs folder beside the package"),
]


def test_the_page_follows_a_cable_and_plans(server, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "cable.twin").write_bytes(cable_file().encode())
    page = PAGE.read_text()
    snippets = re.findall(r"^```python\n(.*?)^```", page, re.DOTALL | re.MULTILINE)
    assert len(snippets) >= 3
    names = {}
    for snippet in snippets:
        line = page[: page.index(snippet)].count("\n")
        code = snippet.replace("127.0.0.1:7070", server.address)
        exec(compile("\n" * line + code, os.fspath(PAGE), "exec"), names)
    assert names["error_mm"] < 10.0
    assert names["result"].success
    assert "mm off" in capsys.readouterr().out
