"""A source file with the places of its nodes, and a change of one place."""

import ast
from typing import NamedTuple


class Change(NamedTuple):
    """One change of one place.

    Attributes:
        operator: Name of the operator.
        where: The function or constant that is changed, with its class.
        begin: Place of the text that is replaced, from the begin of the file.
        end: Place behind it.
        new: The text that replaces it.
        names: Constants of the module that are changed, for a change outside of all functions.
    """

    operator: str
    where: str
    begin: int
    end: int
    new: str
    names: tuple[str, ...] = ()


class Source:
    """A source file: its text, its syntax tree, and where each node of the tree is.

    Attributes:
        text: The text.
        tree: The syntax tree.
    """

    def __init__(self, text: str) -> None:
        """Parse a text; it has to be ASCII, so that bytes are characters."""
        if not text.isascii():
            raise ValueError("operators: expected a source in ASCII")
        self.text, self.tree = text, ast.parse(text)
        self._lines = [0]
        for line in text.splitlines(keepends=True):
            self._lines.append(self._lines[-1] + len(line))

    def begin(self, node: ast.expr | ast.stmt) -> int:
        """Return the place where a node begins."""
        return self._lines[node.lineno - 1] + node.col_offset

    def end(self, node: ast.expr | ast.stmt) -> int:
        """Return the place behind a node."""
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        return self._lines[node.end_lineno - 1] + node.end_col_offset

    def of(self, node: ast.expr | ast.stmt) -> str:
        """Return the text of a node."""
        return self.text[self.begin(node) : self.end(node)]

    def operand(self, node: ast.expr) -> str:
        """Return the text of a node, in parentheses if it may need them elsewhere."""
        atoms = (ast.Name, ast.Constant, ast.Call, ast.Attribute, ast.Subscript)
        return self.of(node) if isinstance(node, atoms) else f"({self.of(node)})"
