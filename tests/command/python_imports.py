"""Who imports whom among Python modules, from their sources: imports inside functions count as well."""
from __future__ import annotations

import ast
from pathlib import Path
from typing import Mapping

Graph = Mapping[str, set[str]]


def modules(root: Path, packages: list[str]) -> dict[str, Path]:
    """Dotted name and file of each module in the packages (or single modules) that lie in `root`."""
    found: dict[str, Path] = {}
    for package in packages:
        files = [root / f"{package}.py"] if (root / f"{package}.py").is_file() else sorted((root / package).rglob("*.py"))
        for path in files:
            parts = path.relative_to(root).with_suffix("").parts
            found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


def imports(found: Mapping[str, Path]) -> dict[str, set[str]]:
    """The modules among `found` that each of them imports."""
    return {name: _imported(name, path, found) - {name} for name, path in found.items()}


def _imported(name: str, path: Path, found: Mapping[str, Path]) -> set[str]:
    package = name if path.name == "__init__.py" else name.rpartition(".")[0]
    out: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            out |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            above = package.split(".")[:len(package.split(".")) - node.level + 1] if node.level else []
            base = ".".join([*above, *([node.module] if node.module else [])])
            for alias in node.names:  # a module of the package, or a name of the module
                inner = f"{base}.{alias.name}"
                out.add(inner if inner in found else base)
    return out & set(found)


def cycle(graph: Graph) -> list[str]:
    """Names along one cycle, [] where there is none."""
    done: set[str] = set()

    def visit(name: str, way: list[str]) -> list[str]:
        if name in way:
            return [*way[way.index(name):], name]
        if name in done:
            return []
        for other in sorted(graph.get(name, ())):
            if found := visit(other, [*way, name]):
                return found
        done.add(name)
        return []

    for name in sorted(graph):
        if found := visit(name, []):
            return found
    return []


def package_of(name: str, found: Mapping[str, Path]) -> str:
    """The package that a module lies in; a single module is one of its own."""
    return name if found[name].name == "__init__.py" else name.rpartition(".")[0] or name


def of_packages(graph: Graph, found: Mapping[str, Path]) -> dict[str, set[str]]:
    """Who imports whom among packages."""
    out: dict[str, set[str]] = {}
    for name, others in graph.items():
        own = package_of(name, found)
        out.setdefault(own, set()).update(package_of(other, found) for other in others)
    return {name: others - {name} for name, others in out.items()}
