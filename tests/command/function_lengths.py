"""Lengths of functions, by a scan of the text. In C++ a function is a block of braces that only namespaces and classes hold."""
from __future__ import annotations

import ast
import re

WORDS = re.compile(r"//[^\n]*|/\*.*?\*/|R\"(\w*)\(.*?\)\1\"|\"(?:\\.|[^\"\\\n])*\"|(?<![0-9a-fA-F])'(?:\\.|[^'\\\n])+'|^\s*#[^\n]*", re.DOTALL | re.MULTILINE)
CONTAINER = re.compile(r"^(?:template ?<.*> ?)?(?:inline |export )?(?:namespace|struct|class|union|enum|extern)\b[^()=]*$")


def of_cpp(text: str) -> list[tuple[int, int]]:
    """First line and number of lines of each function. Raises ValueError where braces do not close."""
    text = WORDS.sub(lambda found: "\n" * found[0].count("\n"), text)
    out: list[tuple[int, int]] = []
    blocks: list[tuple[int, str]] = []  # line of the head, and the head
    line, begin, head = 1, 0, ""
    for letter in text:
        if letter == "\n":
            line += 1
        if letter == "{":
            words = " ".join(head.split())
            blocks.append((begin or line, "container" if CONTAINER.match(words) else "function" if ")" in words else "value"))
        elif letter == "}":
            if not blocks:
                raise ValueError(f"line {line}: a brace closes that is not open")
            first, kind = blocks.pop()
            if kind == "function" and all(outer == "container" for _, outer in blocks):
                out.append((first, line - first + 1))
        if letter in "{};":
            begin, head = 0, ""
        elif begin or not letter.isspace():
            begin, head = begin or line, head + letter
    if blocks:
        raise ValueError(f"line {blocks[-1][0]}: a brace does not close")
    return out


def of_python(text: str) -> list[tuple[int, int]]:
    """First line and number of lines of each function."""
    return [(node.lineno, (node.end_lineno or node.lineno) - node.lineno + 1) for node in ast.walk(ast.parse(text))
            if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))]
