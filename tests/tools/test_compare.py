"""tools/compare with programs that state their speed."""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

TOOL = pathlib.Path(__file__).resolve().parents[2] / "tools/compare"
PROGRAM = """#!/bin/sh
case $1 in
    bench) echo '{"rows": [{"fidelity": "exact", "size": {"instances": 8, "frames": 5},
        "gradients": false, "time": {"best_s": BEST_S}}]}' ;;
    server)
        while [ "$1" != --port-file ]; do shift; done
        echo 7070 > "$2"
        exec tail -f /dev/null ;;
esac
"""
CARGO = """#!/bin/sh
mkdir -p "$CARGO_TARGET_DIR/release"
cp program "$CARGO_TARGET_DIR/release/bendtwin"
"""


class Compare(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def program(self, name, best_s):
        path = self.folder / name
        path.write_text(PROGRAM.replace("BEST_S", str(best_s)))
        path.chmod(0o755)
        return str(path)

    def compared(self, *arguments, **environment):
        command = [sys.executable, TOOL, *arguments]
        return subprocess.run(
            command, capture_output=True, text=True, env={**os.environ, **environment}
        )

    def test_what_takes_longer_is_marked(self):
        markdown = self.folder / "table.md"
        old, new = self.program("old", 0.002), self.program("new", 0.003)
        done = self.compared(
            old, new, "--rounds", "7", "--only", "bench", "--markdown", str(markdown)
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        expected = "| rope, exact, costs of 8x5 | 2 ms | 3 ms | 1.50 | 1.50 to 1.50 | **more** |"
        self.assertIn(expected, done.stdout)
        self.assertEqual(markdown.read_text(), done.stdout)
        done = self.compared(new, old, "--rounds", "7", "--only", "bench")
        self.assertIn("| 0.67 | 0.67 to 0.67 | **less** |", done.stdout)
        # Few pairs prove nothing.
        self.assertIn(
            "1.50 to 1.50 |  |", self.compared(old, new, "--rounds", "3", "--only", "bench").stdout
        )

    def test_a_server_is_started_and_ended(self):
        program = self.program("same", 1)
        done = self.compared(program, program, "--rounds", "1", "--only", "server")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("| start of a server |", done.stdout)
        self.assertIn("| memory of an idle server |", done.stdout)

    def test_revisions_are_built_and_leave_no_trees(self):
        root, tools = self.folder / "root", self.folder / "tools"
        (root / "tests").mkdir(parents=True)
        (root / "tests/old").symlink_to(TOOL.parents[1] / "tests/old")
        (root / "program").write_text(PROGRAM)
        git = ["git", "-c", "user.name=a", "-c", "user.email=a@example.org"]
        for command in (
            ["init", "--quiet"],
            ["add", "program"],
            ["commit", "--quiet", "--message", "a"],
        ):
            subprocess.run([*git, *command], cwd=root, check=True)
        tools.mkdir()
        (tools / "cargo").write_text(CARGO)
        (tools / "cargo").chmod(0o755)
        places = {"BENDTWIN_COMPARE_ROOT": str(root), "PATH": f"{tools}:{os.environ['PATH']}"}
        done = self.compared("HEAD", "HEAD", "--rounds", "1", "--only", "size", **places)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("| size of the program | 0.0 MiB | 0.0 MiB | 1.00 |", done.stdout)
        trees = subprocess.run(
            ["git", "worktree", "list"], cwd=root, capture_output=True, text=True
        ).stdout
        self.assertEqual(len(trees.splitlines()), 1, trees)

    def test_what_is_no_build_is_refused(self):
        done = self.compared("no-such-revision", "HEAD")
        self.assertEqual(done.returncode, 1)
        self.assertIn("no-such-revision is neither a program nor a revision", done.stderr)


if __name__ == "__main__":
    unittest.main()
