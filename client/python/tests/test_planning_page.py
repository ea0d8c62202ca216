"""The snippets of docs/use/planning.md, one after the other, against a real server."""

import os
import re
import warnings
from pathlib import Path

import numpy as np
import pytest
from server import make_rope, needs_server, running

PAGE = Path(__file__).parents[3] / "docs" / "use" / "planning.md"

pytestmark = [
    needs_server,
    pytest.mark.skipif(not PAGE.is_file(), reason="no docs folder beside the package"),
]


def test_the_page_leads_to_a_closed_loop(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    make_rope(tmp_path / "rope.zip")
    page = PAGE.read_text()
    snippets = re.findall(r"^```python\n(.*?)^```", page, re.DOTALL | re.MULTILINE)
    assert len(snippets) >= 8
    names, faults, said = {}, [], ""
    with running(tmp_path) as address:
        for i, snippet in enumerate(snippets):
            code = snippet.replace("127.0.0.1:7070", address)
            line = page[: page.index(snippet)].count("\n")
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                # The page is the file in tracebacks, at its own lines.
                exec(compile("\n" * line + code, os.fspath(PAGE), "exec"), names)
            assert i or names["twin"].name != names["real"].name
            faults += [f"line {line}: {w.message}" for w in caught if is_ours(w)]
            printed = capsys.readouterr().out
            faults += [f"line {line}: {said}" for said in re.findall(r".*\bnan\b.*", printed)]
            said += printed
    assert not faults, said
    start = np.linalg.norm(names["lying"].state(0).positions[names["tip"]] - names["goal"])
    assert names["distance"] < 0.5 * start, said
    assert len(re.findall(r"^\d\.\d s: .* mm$", said, re.MULTILINE)) == 20


def is_ours(warning):
    """True for all but what the interpreter says of its resources."""
    return not issubclass(warning.category, ResourceWarning)
