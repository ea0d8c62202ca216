"""The first example of the package's README, which moves a twin as a robot could."""

import re
import warnings
from pathlib import Path

from server import make_rope, needs_server, running

README = Path(__file__).parents[1] / "README.md"

pytestmark = needs_server


def test_the_first_example_moves_the_twin_as_a_robot_could(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    make_rope(tmp_path / "rope.zip")
    snippet = re.search(r"^```python\n(.*?)^```", README.read_text(), re.DOTALL | re.MULTILINE)
    names = {}
    with running(tmp_path) as address, warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        exec(snippet[1].replace("127.0.0.1:7070", address), names)
    result = names["result"]
    assert result.implausible == []
    assert result.costs.shape == (64,)
    assert result.positions.shape[:2] == (4, 30)
