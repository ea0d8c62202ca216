"""The scripts of `examples`, on a small twin, and the page that shows what they print."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from server import make_rope, needs_server, running

from bendtwin import Client

EXAMPLES = Path(__file__).parents[1] / "examples"
PAGE = EXAMPLES / "../../../docs/use/examples.md"
#: Modules beside the package that a script needs.
NEEDS = {
    "arm": ("matplotlib",),
    "export": ("mujoco", "trimesh"),
    "gradients": ("matplotlib",),
    "imitation": ("gymnasium", "torch"),
    "mujoco_arm": ("matplotlib", "mujoco"),
    "plan": ("matplotlib",),
    "rollouts": ("matplotlib",),
}
#: Files that a script writes.
WRITES = {
    "arm": ("arm.png",),
    "export": ("twin.glb", "twin.xml", "twin.html"),
    "gradients": ("gradients.png",),
    "mujoco_arm": ("mujoco_arm.png",),
    "plan": ("plan.png",),
    "rollouts": ("rollouts.png",),
}
SETTINGS = {
    "graph": {"max_nodes": 30},
    "search": {"generations": 2, "population": 4},
    "refine": {"passes": 1},
}


def names():
    return sorted(path.stem for path in EXAMPLES.glob("*.py"))


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Runs a script in a folder beside a server with two twins, and returns what it printed."""
    folder = tmp_path_factory.mktemp("server")
    make_rope(folder / "rope.zip")
    with running(folder) as address, Client(address) as client, pytest.MonkeyPatch.context() as at:
        at.setenv("BENDTWIN_SERVER", f"http://{address}")
        at.setenv("MPLBACKEND", "Agg")

        def script(name, *arguments):
            command = [sys.executable, EXAMPLES / f"{name}.py", *arguments]
            done = subprocess.run(command, capture_output=True, text=True, cwd=folder)
            assert done.returncode == 0, done.stderr
            assert "RuntimeWarning" not in done.stderr, done.stderr
            return done.stdout

        # The first twin is that of the first script.
        printed = {"fit": script("fit", "rope.zip", json.dumps({**SETTINGS, "seed": 1}))}
        capture = next(client.captures())
        client.wait(client.fit(capture.name, SETTINGS, display_name="rope, fitted again"))
        yield lambda name: printed[name] if name in printed else script(name), folder


@needs_server
@pytest.mark.parametrize("name", names())
def test_a_script_does_what_the_page_shows(run, name):
    for module in NEEDS.get(name, ()):
        pytest.importorskip(module)
    script, folder = run
    printed = script(name)
    if PAGE.is_file():
        assert shape(printed) == shape(shown(name))
    for file in WRITES.get(name, ()):
        assert (folder / file).stat().st_size > 1000


def test_every_script_is_on_the_page():
    if not PAGE.is_file():
        pytest.skip("no docs folder beside the package")
    linked = re.findall(r"examples/(\w+)\.py\)", PAGE.read_text())
    assert sorted(linked) == names()


def shown(name):
    """The output of a script on the page: the first block after the link to it."""
    page = PAGE.read_text()
    after = page[page.index(f"examples/{name}.py)") :]
    return re.search(r"^```text\n(.*?)^```", after, re.DOTALL | re.MULTILINE)[1]


def shape(text):
    """A text without its numbers, names and keys."""
    text = re.sub(r"http://\S+", "LINK", text)
    return re.sub(r"\d[\d.e+]*", "N", text).splitlines()
