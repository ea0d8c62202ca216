"""Check of the links of a site."""

from pathlib import Path


def check(site: Path) -> list[str | Path]:
    """Return the command that checks every link, anchor and picture within a site.

    Links to other sites are left alone, so that a build depends on nothing but the repository.
    """
    return ["lychee", "--offline", "--include-fragments", "--no-progress", "--root-dir", site, site]
