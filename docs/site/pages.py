"""Pages of the site, made of the markdown files of the repository.

The files are written to be read on a forge. Here their links are led to pages of the site: a link
to a file outside `docs` leads to a page with that file, so that the site needs no forge. The
contents are the tables of `docs/README.md`.
"""

import re
import shutil
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path, PurePosixPath
from posixpath import normpath, relpath

LINK = re.compile(r"\]\(([^)\s]+)\)")
NAMED_LINK = re.compile(r"\[([\w./-]+\.md)\]\(([^)\s]+)\)")
ROW_LINK = re.compile(r"\[([^\]]+)\]\(([^)\s]+)\)")
CODE = re.compile(r"(`+[^`]*`+)")
FENCE = re.compile(r"\s*(```|~~~)")

DOCS = PurePosixPath("docs")
INDEX = DOCS / "README.md"
#: Folder of the pages with files outside `docs`.
OUTSIDE = PurePosixPath("source")
#: Page above them.
LIST = OUTSIDE / "files.md"
#: Pages that only lead to a new place; `book.toml` redirects them.
MOVED = {DOCS / "accuracy.md"}
#: The site's own program.
OWN = DOCS / "site"
#: Files that are shown by the browser and not as text.
PICTURES = {".png", ".svg", ".jpg", ".webp"}
LANGUAGES = {".proto": "protobuf", ".py": "python", ".rs": "rust", ".toml": "toml", ".yaml": "yaml"}


FILES = """# Files

The pages below this one show files of the repository to which other pages lead, as they were when
the site was built.
"""


class SiteError(Exception):
    """Fault of a document, with its place and what to do."""


@dataclass
class Chapter:
    """Entry of the contents: a file, its title, and the entries below it."""

    title: str
    path: PurePosixPath
    below: list["Chapter"] = field(default_factory=list)

    def all(self) -> Iterator["Chapter"]:
        """Return this entry and all below it."""
        yield self
        for chapter in self.below:
            yield from chapter.all()


@dataclass
class Part:
    """Group of chapters under a heading."""

    title: str
    chapters: list[Chapter]


def place(path: PurePosixPath, is_folder: bool = False) -> PurePosixPath:
    """Return where a file or folder of the repository is among the pages."""
    inside = path.relative_to(DOCS) if path.is_relative_to(DOCS) else OUTSIDE / path
    if is_folder:
        return inside / "folder.md"
    if path.name == "README.md":
        return inside.with_name("index.md")
    if path.suffix == ".md" or path.suffix in PICTURES or path.is_relative_to(DOCS):
        return inside
    return inside.with_name(f"{inside.name}.md")


def prose(text: str) -> Iterator[tuple[int, str, bool]]:
    """Return the parts of a document with their lines, and whether they are text, not code."""
    fenced = False
    for number, line in enumerate(text.splitlines(keepends=True), 1):
        is_fence = FENCE.match(line) is not None
        if is_fence or fenced:
            fenced ^= is_fence
            yield number, line, False
            continue
        for at, part in enumerate(CODE.split(line)):
            yield number, part, at % 2 == 0


class Site:
    """Assembly of the pages from the files below a root."""

    def __init__(self, root: Path) -> None:
        """Read the contents from the index."""
        self.root = root
        self.parts = self.contents()
        self.listed = {c.path for part in self.parts for top in part.chapters for c in top.all()}
        #: Files and folders outside the contents that pages lead to.
        self.shown: set[PurePosixPath] = set()

    def read(self, path: PurePosixPath) -> str:
        """Return the text of a file."""
        return (self.root / path).read_text(encoding="utf-8")

    def title(self, path: PurePosixPath) -> str:
        """Return the first heading of a document."""
        return self.read(path).split("\n", 1)[0].lstrip("# ")

    def contents(self) -> list[Part]:
        """Return the groups of the index: its headings, with the links of their tables."""
        parts: list[Part] = []
        for line in self.read(INDEX).splitlines():
            if line.startswith("## "):
                parts.append(Part(line[3:], []))
            elif line.startswith("| [") and parts:
                cell = line.split("|")[1]
                for title, target in ROW_LINK.findall(cell):
                    title = title[0].upper() + title[1:]
                    parts[-1].chapters.append(self.chapter(title, self.target(INDEX, target)[0]))
        return [part for part in parts if part.chapters]

    def chapter(self, title: str, path: PurePosixPath) -> Chapter:
        """Return the entry of a file; below a README are the documents of its folder."""
        chapter = Chapter(title, path)
        if path.name == "README.md" and path.is_relative_to(DOCS):
            for _, target in ROW_LINK.findall(self.read(path)):
                below = PurePosixPath(normpath(path.parent / target.split("#")[0]))
                known = {c.path for c in chapter.below}
                if below.parent == path.parent and below.suffix == ".md" and below not in known:
                    chapter.below.append(Chapter(self.title(below), below))
        return chapter

    def target(self, path: PurePosixPath, link: str) -> tuple[PurePosixPath, str]:
        """Return the file that a link of a document leads to, and the anchor with its `#`."""
        name, mark, anchor = link.partition("#")
        return PurePosixPath(normpath(path.parent / name)) if name else path, mark + anchor

    def page(self, path: PurePosixPath) -> str:
        """Return a document with links that lead to pages."""
        here = place(path).parent

        def named(match: re.Match[str]) -> str:
            target = self.target(path, match[2])[0]
            is_its_name = str(target).endswith(match[1].lstrip("./"))
            if not is_its_name or not (self.root / target).is_file():
                return match[0]
            return f"[{self.title(target)}]({match[2]})"

        def lead(number: int, match: re.Match[str]) -> str:
            link = match[1]
            if "://" in link or link.startswith(("#", "mailto:")):
                return match[0]
            target, anchor = self.target(path, link)
            file = self.root / target
            if target.parts[:1] == ("..",) or not file.exists():
                raise SiteError(f"{path}:{number}: {link} leads to no file of the repository")
            if target not in self.listed:
                self.shown.add(target)
            return f"]({relpath(place(target, file.is_dir()), here)}{anchor})"

        parts = []
        for number, part, is_text in prose(self.read(path)):
            if is_text:
                part = NAMED_LINK.sub(named, part)
                part = LINK.sub(partial(lead, number), part)
            parts.append(part)
        return "".join(parts)

    def source(self, path: PurePosixPath) -> str:
        """Return a page that shows a file which is no document."""
        text = self.read(path)
        longest = max((len(run) for run in re.findall(r"`{3,}", text)), default=2)
        fence = "`" * (longest + 1)
        language = LANGUAGES.get(path.suffix, "text")
        return f"# `{path}`\n\n{fence}{language}\n{text.rstrip()}\n{fence}\n"

    def folder(self, path: PurePosixPath) -> str:
        """Return a page that lists a folder, whose files are shown as well."""
        here = place(path, is_folder=True).parent
        rows = []
        for file in sorted((self.root / path).iterdir()):
            if file.is_dir():
                rows.append(f"- `{file.name}/`\n")
            else:
                self.shown.add(path / file.name)
                rows.append(f"- [`{file.name}`]({relpath(place(path / file.name), here)})\n")
        return f"# `{path}/`\n\n{''.join(rows)}"

    def write(self, out: Path) -> None:
        """Write all pages and the contents to an empty folder."""
        missing = sorted(self.documents() - self.listed - MOVED - {INDEX})
        if missing:
            names = ", ".join(map(str, missing))
            raise SiteError(f"{INDEX}: no table has {names}: add a row for each")
        for path in [INDEX, *self.listed]:
            save(out / place(path), self.page(path))
        written: set[PurePosixPath] = {INDEX}
        while waiting := self.shown - written:
            for path in waiting:
                self.show(path, out)
            written |= waiting
        save(out / LIST, FILES)
        save(out / "SUMMARY.md", self.summary())

    def documents(self) -> set[PurePosixPath]:
        """Return the documents below `docs`."""
        found = (PurePosixPath(f.relative_to(self.root)) for f in (self.root / DOCS).rglob("*.md"))
        return {path for path in found if not path.is_relative_to(OWN)}

    def show(self, path: PurePosixPath, out: Path) -> None:
        """Write the page of a file or folder, or the file if browsers show or keep it."""
        file = self.root / path
        target = out / place(path, file.is_dir())
        if file.is_dir():
            save(target, self.folder(path))
        elif path.suffix == ".md":
            save(target, self.page(path))
        elif target.suffix == ".md":
            save(target, self.source(path))
        else:
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, target)

    def summary(self) -> str:
        """Return the contents in mdBook's form."""
        lines = ["# Summary\n", f"[{self.title(INDEX)}](index.md)\n"]
        for part in self.parts:
            lines.append(f"# {part.title}\n")
            lines.extend(entry(chapter) for chapter in part.chapters)
            lines.append("")
        shown = {path: place(path, (self.root / path).is_dir()) for path in self.shown - {INDEX}}
        pages = sorted((path, page) for path, page in shown.items() if page.suffix == ".md")
        if pages:
            lines.append(f"# Files\n\n- [Files that pages lead to]({LIST})")
            lines.extend(f"  - [`{path}`]({page})" for path, page in pages)
        return "\n".join(lines) + "\n"


def entry(chapter: Chapter, depth: int = 0) -> str:
    """Return a chapter as an item of mdBook's contents, with those below it."""
    line = f"{'  ' * depth}- [{chapter.title}]({place(chapter.path)})"
    return "\n".join([line, *(entry(below, depth + 1) for below in chapter.below)])


def save(path: Path, text: str) -> None:
    """Write a file, and the folders that it is in."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
