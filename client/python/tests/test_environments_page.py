"""The snippets of docs/use/environments.md, one after the other, against a real server."""

import os
import re
import warnings
from pathlib import Path

import pytest
from server import make_rope, needs_server, running

pytest.importorskip("gymnasium")

PAGE = Path(__file__).parents[3] / "docs" / "use" / "environments.md"

pytestmark = [
    needs_server,
    pytest.mark.skipif(not PAGE.is_file(), reason="no docs folder beside the package"),
]


def test_the_page_leads_to_success_rates(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    make_rope(tmp_path / "rope.zip")
    page = PAGE.read_text()
    snippets = re.findall(r"^```python\n(.*?)^```", page, re.DOTALL | re.MULTILINE)
    assert len(snippets) >= 7
    names = {}
    with running(tmp_path) as address, warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        for snippet in snippets:
            code = snippet.replace("127.0.0.1:7070", address)
            line = page[: page.index(snippet)].count("\n")
            # The page is the file in tracebacks, at its own lines.
            exec(compile("\n" * line + code, os.fspath(PAGE), "exec"), names)
    said = capsys.readouterr().out
    assert names["script"].rate >= 0.75, said
    assert names["chance"].rate <= 0.25, said
    assert re.search(r"script: \d+% of 16 episodes succeed \(95 % interval", said), said


def test_the_page_lists_every_task():
    from bendtwin.envs import list_tasks

    listed = re.findall(r"^\| `(\w+)` \| [a-z]", PAGE.read_text(), re.MULTILINE)
    assert sorted(set(listed)) == list_tasks()
