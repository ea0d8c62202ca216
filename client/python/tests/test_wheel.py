"""The wheel has the binary of a release build, which is not made again for it."""

from pathlib import Path

PROJECT = Path(__file__).parents[1] / "pyproject.toml"
#: Options of maturin that become arguments of rustc, so that cargo builds anew for the wheel.
REBUILDS = ("strip", "rustc-args", "profile", "features", "no-default-features", "config")


def test_no_option_has_the_binary_built_again():
    table = PROJECT.read_text().split("[tool.maturin]\n")[1].split("\n[")[0]
    options = [line.split("=")[0].strip() for line in table.splitlines() if "=" in line]
    assert "bindings" in options
    assert "locked" not in options, "the source distribution could not be built"
    assert not set(options) & set(REBUILDS)
