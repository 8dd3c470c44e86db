"""Faults drawn in the arithmetic of the package: signs, factors, powers, sine and cosine."""

from __future__ import annotations

import ast
import random
from collections.abc import Iterator
from pathlib import Path

PACKAGE = Path(__file__).parents[2] / "flexmech"
# Rooms and files whose arithmetic is not that of a printed number.
LEFT_OUT = ("cli", "plots", "report", "verification", "modelfile", "words", "pictures", "__init__")


def draw(count: int, seed: int) -> list[tuple[str, int, str, str]]:
    """Faults as (file, place in its text, old text, new text), no two in one line."""
    places = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        names = path.relative_to(PACKAGE).with_suffix("").parts
        if not set(names) & set(LEFT_OUT):
            for line, offset, old, new in changes(path.read_text(encoding="utf-8")):
                file = str(path.relative_to(PACKAGE.parent))
                places.setdefault((file, line), []).append((file, offset, old, new))
    generator = random.Random(seed)
    lines = generator.sample(sorted(places), min(count, len(places)))
    return [generator.choice(places[line]) for line in lines]


def changes(text: str) -> Iterator[tuple[int, int, str, str]]:
    """Every change of a sign, a factor, a power or a function: (line, place, old, new text)."""
    lines = text.splitlines(keepends=True)
    starts = [0]
    for line in lines:
        starts.append(starts[-1] + len(line))

    def place(line: int, column: int) -> int:
        """Place in the text of a column that is counted in bytes."""
        before = lines[line - 1].encode()[:column].decode()
        return starts[line - 1] + len(before)

    for node in _arithmetic(ast.parse(text)):
        if isinstance(node, ast.BinOp):
            end = place(node.left.end_lineno, node.left.end_col_offset)
            between = text[end : place(node.right.lineno, node.right.col_offset)]
            if isinstance(node.op, ast.Add | ast.Sub):
                sign, other = ("+", "-") if isinstance(node.op, ast.Add) else ("-", "+")
                at = between.index(sign)
                yield node.lineno, end + at, sign, other
            number = node.right if isinstance(node.right, ast.Constant) else node.left
            if isinstance(number, ast.Constant) and isinstance(number.value, int | float):
                start = place(number.lineno, number.col_offset)
                old = text[start : place(number.end_lineno, number.end_col_offset)]
                if isinstance(node.op, ast.Mult | ast.Div):
                    yield node.lineno, start, old, f"({old} * 1.01)"
                elif isinstance(node.op, ast.Pow) and number is node.right:
                    yield node.lineno, start, old, f"({old} - 1)"
        elif isinstance(node, ast.UnaryOp):
            yield node.lineno, place(node.lineno, node.col_offset), "-", "+"
        elif isinstance(node, ast.Attribute):
            start = place(node.end_lineno, node.end_col_offset) - 3
            yield node.lineno, start, node.attr, {"sin": "cos", "cos": "sin"}[node.attr]


def _arithmetic(node: ast.AST) -> Iterator[ast.AST]:
    """Nodes of arithmetic below a node, but for indices, messages, annotations and defaults."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Raise | ast.JoinedStr | ast.arguments | ast.AnnAssign):
            continue
        if isinstance(node, ast.Subscript) and child is node.slice:
            continue
        if isinstance(child, ast.FunctionDef) and child.name.startswith("__"):
            continue
        text = ast.walk(child)
        if isinstance(child, ast.BinOp) and not any(
            isinstance(n, ast.List | ast.Tuple)
            or (isinstance(n, ast.Constant) and isinstance(n.value, str))
            for n in text
        ):
            yield child
        if (
            isinstance(child, ast.UnaryOp)
            and isinstance(child.op, ast.USub)
            and not isinstance(child.operand, ast.Constant)
        ):
            yield child
        if isinstance(child, ast.Attribute) and child.attr in {"sin", "cos"}:
            yield child
        yield from _arithmetic(child)
