"""The snippets of docs/use/arms.md, one after the other, against a real server."""

import os
import re
import warnings
from pathlib import Path

import pytest
from made import rope_file
from server import needs_server, running

from bendtwin import Client

PAGE = Path(__file__).parents[3] / "docs" / "use" / "arms.md"

pytestmark = [
    needs_server,
    pytest.mark.skipif(not PAGE.is_file(), reason="no docs folder beside the package"),
]


def test_the_page_leads_from_a_urdf_to_a_trajectory(tmp_path, capsys):
    page = PAGE.read_text()
    snippets = re.findall(r"^```python\n(.*?)^```", page, re.DOTALL | re.MULTILINE)
    assert len(snippets) >= 8
    (tmp_path / "rope.twin").write_bytes(rope_file().encode())
    names = {}
    with running(tmp_path) as address:
        with Client(address) as client:
            client.import_twin(tmp_path / "rope.twin")
        for snippet in snippets:
            code = snippet.replace("127.0.0.1:7070", address)
            line = page[: page.index(snippet)].count("\n")
            with warnings.catch_warnings():
                warnings.simplefilter("error", RuntimeWarning)
                # The page is the file in tracebacks, at its own lines.
                exec(compile("\n" * line + code, os.fspath(PAGE), "exec"), names)
    said = capsys.readouterr().out
    assert "nan" not in said
    assert re.search(r"^21 points over 0\.67 s$", said, re.MULTILINE), said
    assert said.endswith("within all limits\n")
    trajectory = names["trajectory"]
    assert trajectory["joint_names"] == list(names["robot"].joint_names)
    assert trajectory["points"][0]["positions"] == names["start"].tolist()
