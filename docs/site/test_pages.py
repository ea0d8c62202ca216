"""Tests of the pages: `python3 -m unittest discover docs/site`."""

# The standard library's tests: the stage needs no further package.
# ruff: noqa: D102, PT009, PT027

import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path, PurePosixPath

from links import check
from pages import Site, SiteError, place

INDEX = """# Product

## Use

| page | content |
|---|---|
| [Start](use/start.md) | first |

## Appendix

| page | content |
|---|---|
| [Decisions](adr/README.md), [security](../SECURITY.md) | reasons |
"""
START = """# Getting started

See [the options](../../deploy/config.toml), [adr/0001.md](../adr/0001.md), [all](../README.md#use),
[a folder](../../deploy/chart), `[code](../nowhere.md)`, [elsewhere](https://example.org/a.md).

```
[fenced](../nowhere.md)
```

![picture](../pictures/a.png)
"""
FILES = {
    "docs/README.md": INDEX,
    "docs/use/start.md": START,
    "docs/adr/README.md": "# Decisions\n\n| | |\n|---|---|\n| [0001](0001.md) | Points |\n",
    "docs/adr/0001.md": "# 1. Points\n\nText.\n",
    "docs/pictures/a.png": "not really",
    "docs/accuracy.md": "# Moved\n",
    "SECURITY.md": "# Security\n\n[Options](deploy/config.toml), [start](docs/use/start.md)\n",
    "deploy/config.toml": "# ```\nlisten = 1\n",
    "deploy/chart/README.md": "# Chart\n",
    "deploy/chart/templates/a.yaml": "kind: Service\n",
    "deploy/chart/server.yaml": "kind: Deployment\n",
}


class PagesTest(unittest.TestCase):
    """A small repository and its pages."""

    def setUp(self) -> None:
        self.root = Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.root)
        for name, text in FILES.items():
            self.put(name, text)

    def put(self, name: str, text: str) -> None:
        """Write a file of the repository."""
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")

    def pages(self) -> dict[str, str]:
        """Return the text of all pages by name."""
        out = self.root / "pages"
        Site(self.root).write(out)
        files = (path for path in out.rglob("*") if path.is_file())
        return {path.relative_to(out).as_posix(): path.read_text("utf-8") for path in files}

    def test_links_lead_to_pages_of_the_site(self) -> None:
        text = self.pages()["use/start.md"]
        self.assertIn("[the options](../source/deploy/config.toml.md)", text)
        self.assertIn("[all](../index.md#use)", text)
        self.assertIn("[a folder](../source/deploy/chart/folder.md)", text)
        self.assertIn("![picture](../pictures/a.png)", text)
        self.assertIn("[elsewhere](https://example.org/a.md)", text)

    def test_code_stays_as_written(self) -> None:
        text = self.pages()["use/start.md"]
        self.assertIn("`[code](../nowhere.md)`", text)
        self.assertIn("[fenced](../nowhere.md)", text)

    def test_names_of_documents_become_titles(self) -> None:
        self.assertIn("[1. Points](../adr/0001.md)", self.pages()["use/start.md"])

    def test_contents_are_the_tables_of_the_index(self) -> None:
        summary = self.pages()["SUMMARY.md"]
        start = (
            "# Summary\n\n[Product](index.md)\n\n# Use\n\n- [Start](use/start.md)\n\n# Appendix\n\n"
            "- [Decisions](adr/index.md)\n  - [1. Points](adr/0001.md)\n"
            "- [Security](source/SECURITY.md)\n"
        )
        self.assertEqual(summary[: len(start)], start)

    def test_files_outside_the_documents_are_shown(self) -> None:
        pages = self.pages()
        config = "# `deploy/config.toml`\n\n````toml\n# ```\nlisten = 1\n````\n"
        self.assertEqual(pages["source/deploy/config.toml.md"], config)
        rows = "- [`README.md`](index.md)\n- [`server.yaml`](server.yaml.md)\n- `templates/`\n"
        self.assertEqual(pages["source/deploy/chart/folder.md"], f"# `deploy/chart/`\n\n{rows}")
        self.assertIn("kind: Deployment", pages["source/deploy/chart/server.yaml.md"])
        self.assertIn("(source/deploy/chart/server.yaml.md)", pages["SUMMARY.md"])
        self.assertIn("[start](../use/start.md)", pages["source/SECURITY.md"])

    def test_a_page_without_a_row_is_refused(self) -> None:
        self.put("docs/use/more.md", "# More\n")
        with self.assertRaisesRegex(SiteError, r"no table has docs/use/more\.md"):
            self.pages()

    def test_a_link_to_nothing_is_refused_with_its_place(self) -> None:
        self.put("docs/adr/0001.md", "# 1. Points\n\n[a](b.md)\n")
        with self.assertRaisesRegex(SiteError, r"docs/adr/0001\.md:3: b\.md"):
            self.pages()

    def test_a_link_out_of_the_repository_is_refused(self) -> None:
        self.put("docs/adr/0001.md", "# 1. Points\n\n[a](../../../etc)\n")
        with self.assertRaises(SiteError):
            self.pages()

    def test_places(self) -> None:
        places = {
            "docs/adr/README.md": "adr/index.md",
            "docs/use/scripts/a.py": "use/scripts/a.py",
            "client/python/README.md": "source/client/python/index.md",
            "crates/a.rs": "source/crates/a.rs.md",
        }
        for path, page in places.items():
            self.assertEqual(place(PurePosixPath(path)), PurePosixPath(page))


class LinkCheckTest(unittest.TestCase):
    """The check of links, on sites of one page."""

    def status(self, link: str) -> int:
        """Return the status of the check of a page with a link."""
        with tempfile.TemporaryDirectory() as folder:
            page = f'<!DOCTYPE html><h1 id="a">A</h1><p>{link}</p>'
            (Path(folder) / "index.html").write_text(page, encoding="utf-8")
            command = check(Path(folder))
            return subprocess.run(command, capture_output=True, check=False).returncode

    def test_faults_are_found(self) -> None:
        self.assertEqual(self.status('<a href="index.html#a">a</a>'), 0)
        faults = ['<a href="b.html">', '<a href="index.html#b">', '<img alt="" src="b.png">']
        for fault in faults:
            self.assertNotEqual(self.status(fault), 0, fault)


if __name__ == "__main__":
    unittest.main()
