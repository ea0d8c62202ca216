"""Writes the client for asyncio, src/bendtwin/aio, from the synchronous one. Run it after a change
of client.py, session.py, twin.py or connection/caller.py:

    pip install -e 'client/python[test]' && python3 client/python/generate_aio.py

Another output folder may be given (the test that the files are current does so).

Each class becomes one whose calls are awaited. `AsyncCaller` says which: its coroutines are
awaited, its iterators are read with `async for`, and its context managers are entered with
`async with`. A method that waits becomes a coroutine; one that returns an iterator stays a
function.
"""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

PACKAGE = Path(__file__).parent / "src" / "bendtwin"
#: Classes by their modules, in the order in which they need each other.
CLASSES = {"twin": "Twin", "session": "Session", "client": "Client"}
NAMES = {
    "Caller": "AsyncCaller",
    "Iterable": "AsyncIterable",
    "Iterator": "AsyncIterator",
    "__enter__": "__aenter__",
    "__exit__": "__aexit__",
}
#: What is different in the text of documentation.
WORDS = {"`with`": "`async with`", "Thread-safe": "For one event loop"}
HEADER = '"""Generated from {module}.py by client/python/generate_aio.py. Do not edit."""\n\n'

Function = ast.FunctionDef | ast.AsyncFunctionDef


class Calls:
    """Names of methods by what is done with their results."""

    def __init__(self, caller: ast.ClassDef) -> None:
        methods = [node for node in caller.body if isinstance(node, ast.AsyncFunctionDef)]
        self.entered = {m.name for m in methods if m.decorator_list}
        yielding = {m.name for m in methods if any(isinstance(n, ast.Yield) for n in scope(m))}
        self.iterated = yielding - self.entered
        self.awaited = {m.name for m in methods} - yielding


class Rewriting:
    """A class on its way to its asynchronous form: what is inserted where."""

    def __init__(self, made: ast.ClassDef, of_caller: Calls) -> None:
        self.of_caller = of_caller
        methods = [node for node in made.body if isinstance(node, ast.FunctionDef)]
        self.iterators = {m.name for m in methods if annotation(m.returns) == "Iterator"}
        self.coroutines = {"__enter__", "__exit__"}
        self.iterables: set[str] = set()
        # A method that calls a coroutine is one, and so on.
        while found := {m.name for m in methods if self.waits(m)} - self.coroutines:
            self.coroutines |= found
        #: Texts by line and column [bytes].
        self.inserted: list[tuple[int, int, str]] = []
        for method in methods:
            arguments = [*method.args.args, *method.args.kwonlyargs]
            self.iterables = {a.arg for a in arguments if annotation(a.annotation) == "Iterable"}
            self.function(method)

    def function(self, function: ast.FunctionDef) -> None:
        """Notes what is inserted into a function."""
        if function.name in self.coroutines or self.waits(function):
            self.insert(function, "async ")
        for node in scope(function):
            if isinstance(node, ast.FunctionDef):
                self.function(node)
            elif self.is_async(node):
                self.insert(node, "async ")
            elif self.is_awaited(node):
                self.insert(node, "await ")
            elif isinstance(node, ast.GeneratorExp):
                # `for` has no place in the tree: it is the last word before the target.
                for part in node.generators:
                    if self.is_iterated(part.iter):
                        self.inserted.append(
                            (part.target.lineno, part.target.col_offset - len("for "), "async ")
                        )

    def insert(self, node: ast.stmt | ast.expr, text: str) -> None:
        """Notes a text that is inserted before a node."""
        self.inserted.append((node.lineno, node.col_offset, text))

    def waits(self, function: Function) -> bool:
        """True if a function has something to await, functions inside apart."""
        return any(self.is_async(node) or self.is_awaited(node) for node in scope(function))

    def is_async(self, node: ast.AST) -> bool:
        """True for a statement that becomes `async for` or `async with`."""
        if isinstance(node, ast.For):
            return self.is_iterated(node.iter)
        if isinstance(node, ast.With):
            return any(called(i.context_expr)[1] in self.of_caller.entered for i in node.items)
        return False

    def is_awaited(self, node: ast.AST) -> bool:
        """True for a call of a coroutine."""
        owner, name = called(node)
        return name in {"self": self.coroutines, "caller": self.of_caller.awaited}.get(owner, ())

    def is_iterated(self, node: ast.AST) -> bool:
        """True for an asynchronous iterator."""
        if isinstance(node, ast.Name):
            return node.id in self.iterables
        owner, name = called(node)
        return name in {"self": self.iterators, "caller": self.of_caller.iterated}.get(owner, ())


def scope(function: Function) -> Iterator[ast.AST]:
    """The nodes of a function; of functions inside only they themselves."""
    waiting: list[ast.AST] = list(function.body)
    while waiting:
        node = waiting.pop()
        yield node
        if not isinstance(node, Function):
            waiting.extend(ast.iter_child_nodes(node))


def called(node: ast.AST) -> tuple[str, str]:
    """Owner and name of a method that is called: `self` or, for `self._caller`, `caller`."""
    if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)):
        return "", ""
    owner = {"self": "self", "self._caller": "caller"}.get(ast.unparse(node.func.value), "")
    return owner, node.func.attr


def annotation(node: ast.expr | None) -> str:
    """The name of a type, without its parameters."""
    name = node.value if isinstance(node, ast.Subscript) else node
    return name.id if isinstance(name, ast.Name) else ""


def class_named(module: ast.Module, name: str) -> ast.ClassDef:
    """A class of a module."""
    return next(n for n in module.body if isinstance(n, ast.ClassDef) and n.name == name)


def asynchronous(module: str, of_caller: Calls) -> str:
    """The module for asyncio that has the class of a synchronous one."""
    text = (PACKAGE / f"{module}.py").read_text()
    tree = ast.parse(text)
    made = class_named(tree, CLASSES[module])
    lines = text.encode().splitlines(keepends=True)
    for row, column, inserted in sorted(Rewriting(made, of_caller).inserted, reverse=True):
        line = lines[row - 1]
        lines[row - 1] = line[:column] + inserted.encode() + line[column:]
    body = b"".join(lines[made.lineno - 1 : made.end_lineno]).decode()

    parts = [HEADER.format(module=module), *imports(module, tree, lines)]
    for word, other in WORDS.items():
        body = body.replace(word, other)
    code = re.sub(r"\b\w+\b", lambda name: NAMES.get(name[0], name[0]), "".join([*parts, body]))
    return tidied(code, f"{module}.py")


def imports(module: str, tree: ast.Module, lines: list[bytes]) -> Iterator[str]:
    """Imports for what the class of a module may name: those of the module, where classes that have
    an asynchronous form are that, and the classes beside it."""
    for node in tree.body:
        if isinstance(node, ast.If):
            others = [n.name for n in tree.body if isinstance(n, ast.ClassDef)]
            others.remove(CLASSES[module])
            if others:
                yield f"from bendtwin.{module} import {', '.join(others)}\n"
        if isinstance(node, ast.Import | ast.ImportFrom | ast.If):
            statement = b"".join(lines[node.lineno - 1 : node.end_lineno]).decode()
            for source, made in CLASSES.items():
                of_source = f"from bendtwin.{source} import {made}\n"
                statement = statement.replace(of_source, of_source.replace(".", ".aio.", 1))
            yield statement


def tidied(code: str, name: str) -> str:
    """Code without imports that it does not need, as the formatter has it."""
    for command in (["check", "--quiet", "--fix", "--select=F401,I"], ["format", "--quiet"]):
        path = PACKAGE / "aio" / name
        ruff = [sys.executable, "-m", "ruff", *command, f"--stdin-filename={path}", "-"]
        code = subprocess.run(ruff, input=code, capture_output=True, text=True, check=True).stdout
    return code


def main() -> None:
    """Writes the modules."""
    source = Path(sys.argv[1]) if len(sys.argv) > 1 else PACKAGE.parent
    folder = source / "bendtwin" / "aio"
    folder.mkdir(parents=True, exist_ok=True)
    sources = "".join((PACKAGE / f"{module}.py").read_text() for module in CLASSES)
    if missing := [word for word in WORDS if word not in sources]:
        sys.exit(f"no documentation has {missing} any more: see WORDS in {Path(__file__).name}")
    caller = ast.parse((PACKAGE / "connection" / "caller.py").read_text())
    of_caller = Calls(class_named(caller, "AsyncCaller"))
    for module in CLASSES:
        (folder / f"{module}.py").write_text(asynchronous(module, of_caller))


if __name__ == "__main__":
    main()
