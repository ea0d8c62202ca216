"""tools/release on a small source tree."""

import json
import os
import pathlib
import subprocess
import sys
import tarfile
import tempfile
import unittest
import zipfile

TOOL = pathlib.Path(__file__).resolve().parents[2] / "tools/release"
CHANGELOG = """# Changelog

## Unreleased

### Twins

- Twins [fly](docs/fly.md), as [elsewhere](https://example.org).

## 0.1.0 (2026-01-01)

- The first.
"""
CARGO = '[workspace]\nmembers = ["a"]\nresolver = "3"\n\n[workspace.package]\nversion = "0.1.0"\n'
MEMBER = '[package]\nname = "a"\nversion.workspace = true\n\n[lib]\npath = "lib.rs"\n'
LOCK = """{
  "name": "c",
  "version": "0.1.0",
  "packages": {
    "": {
      "name": "c",
      "version": "0.1.0"
    },
    "node_modules/d": {
      "version": "0.1.0"
    }
  }
}
"""


class Release(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        self.write("Cargo.toml", CARGO)
        self.write("a/Cargo.toml", MEMBER)
        self.write("a/lib.rs", "")
        self.write(
            "c/package.json", '{\n  "name": "c",\n  "version": "0.1.0",\n  "type": "module"\n}\n'
        )
        self.write("c/package-lock.json", LOCK)
        self.write("ros/package.xml", "<package>\n  <version>0.1.0</version>\n</package>\n")
        self.write("chart/Chart.yaml", 'name: e\nversion: 0.1.0\nappVersion: "0.1.0"\n')
        self.write("openapi.json", '{"info":{"title":"BendTwin","version":"0.1.0"}}')
        self.write("CHANGELOG.md", CHANGELOG)
        for text in ("LICENSE-MIT", "LICENSE-APACHE", "README.md"):
            self.write(text, text)
        self.git("init", "--quiet")
        subprocess.run(
            ["cargo", "generate-lockfile", "--offline", "--quiet"], cwd=self.root, check=True
        )
        self.commit()

    def write(self, name, text):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)

    def read(self, name):
        return (self.root / name).read_text()

    def git(self, *arguments):
        facts = ["-c", "user.name=a", "-c", "user.email=a@example.org"]
        done = subprocess.run(
            ["git", *facts, *arguments], cwd=self.root, check=True, capture_output=True, text=True
        )
        return done.stdout

    def commit(self):
        self.git("add", "--all")
        self.git("commit", "--quiet", "--message", "a")

    def tool(self, *arguments, **environment):
        author = {
            f"GIT_{who}_{fact}": "a"
            for who in ("AUTHOR", "COMMITTER")
            for fact in ("NAME", "EMAIL")
        }
        all_of_it = {**os.environ, **author, "BENDTWIN_RELEASE_ROOT": str(self.root), **environment}
        command = [sys.executable, TOOL, *arguments]
        return subprocess.run(command, env=all_of_it, capture_output=True, text=True)

    def succeeds(self, *arguments, **environment):
        done = self.tool(*arguments, **environment)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def fails(self, words, *arguments):
        done = self.tool(*arguments)
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertIn(words, done.stderr)

    def test_a_release_from_the_version_to_the_tag(self):
        self.succeeds("check")
        self.fails("record the data of 0.1.0", "bump", "0.2.0")
        self.write("tests/old/0.1.0/record.json", "{}")
        self.succeeds("bump", "0.2.0")
        self.assertIn('version = "0.2.0"', self.read("Cargo.toml"))
        self.assertIn('name = "a"\nversion = "0.2.0"', self.read("Cargo.lock"))
        lock = json.loads(self.read("c/package-lock.json"))
        self.assertEqual((lock["version"], lock["packages"][""]["version"]), ("0.2.0", "0.2.0"))
        self.assertEqual(lock["packages"]["node_modules/d"]["version"], "0.1.0")
        self.assertIn("<version>0.2.0</version>", self.read("ros/package.xml"))
        self.assertIn('version: 0.2.0\nappVersion: "0.2.0"', self.read("chart/Chart.yaml"))
        changelog = self.read("CHANGELOG.md")
        self.assertRegex(changelog, r"## Unreleased\n\n## 0\.2\.0 \(\d{4}-\d\d-\d\d\)\n\n### Twins")
        self.assertIn("## 0.1.0 (2026-01-01)\n\n- The first.", changelog)
        self.fails("not committed", "tag")
        self.commit()
        self.succeeds("check", "v0.2.0")
        self.fails("the tag is v0.3.0", "check", "v0.3.0")
        self.succeeds("tag")
        self.assertIn("### Twins", self.git("tag", "--list", "--format=%(contents)", "v0.2.0"))

    def test_notes_have_links_that_work_elsewhere(self):
        self.assertEqual(self.succeeds("notes", "0.1.0"), "- The first.\n")
        notes = self.succeeds(
            "notes", "Unreleased", BENDTWIN_RELEASE_PAGES="https://example.org/tree"
        )
        self.assertIn("[fly](https://example.org/tree/vUnreleased/docs/fly.md)", notes)
        self.assertIn("[elsewhere](https://example.org)", notes)
        self.fails("no section 0.9.0", "notes", "0.9.0")

    def test_what_cannot_be_released(self):
        self.fails("is no version", "bump", "next")
        self.fails("has a section 0.1.0", "bump", "0.1.0")
        self.write(
            "CHANGELOG.md",
            CHANGELOG.replace("### Twins\n\n- Twins", "").split("[fly]")[0] + "\n## 0.1.0 (a)\n",
        )
        self.fails("nothing under Unreleased", "bump", "0.2.0")
        self.write("openapi.json", '{"info":{"title":"BendTwin","version":"0.0.9"}}')
        self.fails("openapi.json states 0.0.9", "check")

    def test_a_wheel_becomes_an_archive_with_licences_beside_its_sbom(self):
        wheel = self.root / "bendtwin-0.1.0-py3-none-manylinux_2_28_aarch64.whl"
        with zipfile.ZipFile(wheel, "w") as parts:
            parts.writestr("bendtwin-0.1.0.data/scripts/bendtwin", "program")
        self.fails("0 files that could be the SBOM", "package", str(wheel), str(self.root / "out"))
        with zipfile.ZipFile(wheel, "a") as parts:
            parts.writestr("bendtwin-0.1.0.dist-info/sboms/bendtwin-cli.cyclonedx.json", "{}")
        self.succeeds("package", str(wheel), str(self.root / "out"))
        name = "bendtwin-0.1.0-linux-arm64"
        self.assertEqual(self.read(f"out/{name}.cdx.json"), "{}")
        with tarfile.open(self.root / f"out/{name}.tar.gz") as archive:
            self.assertIn(f"{name}/LICENSE-MIT", archive.getnames())
            self.assertEqual(archive.getmember(f"{name}/bendtwin").mode, 0o755)
        for platform, expected in (
            ("macosx_11_0_arm64", "macos-arm64"),
            ("manylinux_2_28_x86_64", "linux-x86-64"),
        ):
            other = wheel.with_name(f"bendtwin-0.1.0-py3-none-{platform}.whl")
            wheel.rename(other)
            self.assertIn(expected, self.succeeds("package", str(other), str(self.root / "out")))
            other.rename(wheel)


if __name__ == "__main__":
    unittest.main()
