"""What `client/for-publication` makes of the packages before they are published."""

import json
import re
import runpy
import shutil
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
SCRIPT = ROOT / "client" / "for-publication"
ADDRESS = "https://code.example/people/bendtwin"
PARTS = ("python/README.md", "python/pyproject.toml", "typescript/README.md")

pytestmark = pytest.mark.skipif(not SCRIPT.is_file(), reason="no repository around the package")


@pytest.fixture
def ready(tmp_path):
    """The folder `client` of a repository with the packages' texts, after the script."""
    for beside in ("docs", "LICENSE-MIT"):
        (tmp_path / beside).symlink_to(ROOT / beside)
    client = tmp_path / "client"
    for part in (*PARTS, "typescript/package.json", "typescript/examples/rollout.mjs"):
        (client / part).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / "client" / part, client / part)
    runpy.run_path(str(SCRIPT))["main"](f"{ADDRESS}.git", "v1.2.3", client)
    return client


@pytest.mark.parametrize("package", ["python", "typescript"])
def test_links_lead_to_a_revision_of_the_repository(ready, package):
    links = re.findall(r"\]\(([^)]+)\)", (ready / package / "README.md").read_text())
    assert f"{ADDRESS}/blob/v1.2.3/docs/use/errors.md" in links or package == "python"
    assert all(link.startswith(("https://", "#")) for link in links), links


def test_the_packages_name_the_repository(ready):
    project = (ready / "python" / "pyproject.toml").read_text()
    assert f'Changelog = "{ADDRESS}/blob/v1.2.3/CHANGELOG.md"' in project
    package = json.loads((ready / "typescript" / "package.json").read_text())
    assert package["repository"]["url"] == f"git+{ADDRESS}.git"


def test_a_link_to_nothing_is_refused(ready):
    (ready / "python" / "README.md").write_text("[gone](../../docs/gone.md)")
    with pytest.raises(SystemExit, match=r"gone\.md does not exist"):
        runpy.run_path(str(SCRIPT))["main"](ADDRESS, "v1.2.3", ready)
