"""Every change of one place of a source file that an operator makes, found by Python's `ast`.

An operator is a kind of mistake, such as a comparison that is made strict. The positions come from
the syntax tree, and the text is replaced in place, so that the rest of the file stays as it is.
Annotations, docstrings, messages of errors and imports are never changed.
"""

import ast
import re
from collections.abc import Iterator
from types import CodeType
from typing import NamedTuple

from validation.mutants import arguments
from validation.mutants.source import Change, Source

STRICT = {"<": "<=", "<=": "<", ">": ">=", ">=": ">"}
TURNED = {"<": ">", "<=": ">=", ">": "<", ">=": "<=", "==": "!=", "!=": "=="}
TOKENS = {
    ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=",
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.And: "and", ast.Or: "or",
}  # fmt: skip
EXTREMES = {
    "max": "min", "min": "max", "maximum": "minimum", "minimum": "maximum",
    "argmax": "argmin", "argmin": "argmax",
}  # fmt: skip
# Calls that give back their first argument where they do nothing.
LEFT_OUT = ("abs", "max", "min", "maximum", "minimum", "fabs", "sqrt", "sort", "unique")
FACTORS = ("2.0 *", "0.5 *", "1024.0 *")
WHOLE_FACTORS = ("2 *", "1024 *")
DIVISORS = (2, 8, 64)
# Names of bounds of rounding, and of the shares and margins that cover it.
BOUND = re.compile(
    r"(?-i:^(U|TINY|INSIDE|MIN_STEP|LAST_DIGIT|\w*DEPENDENT|NO_WEIGHT)$)"
    r"|(^|_)(error|errors|threshold|margin|rounding|bound|bounds)\d*($|_)",
    re.IGNORECASE,
)


def changes(text: str) -> list[Change]:
    """Return every change that the operators can make in a source file, in the order of the tree.

    Args:
        text: The source, in ASCII.
    """
    source = Source(text)
    return [change for scope in _scopes(source.tree) for change in _of_scope(source, scope)]


def is_equivalent(text: str, change: Change) -> bool:
    """Return whether the code with a change is compiled to the same instructions.

    Args:
        text: The source.
        change: A change of it.
    """
    return _instructions(text) == _instructions(changed(text, change))


def _instructions(text: str) -> list[object]:
    """Return what Python compiles a source to, without the places of lines."""
    todo, found = [compile(text, "source", "exec", dont_inherit=True)], []
    while todo:
        code = todo.pop()
        inner = [one for one in code.co_consts if isinstance(one, CodeType)]
        constants = [repr(one) for one in code.co_consts if not isinstance(one, CodeType)]
        found.append((code.co_code, code.co_names, code.co_varnames, constants))
        todo += inner
    return found


def changed(text: str, change: Change) -> str:
    """Return a source with a change."""
    return text[: change.begin] + change.new + text[change.end :]


class _Scope(NamedTuple):
    """A function, or a constant of the module: what is changed in one piece."""

    where: str
    body: tuple[ast.stmt, ...]
    function: ast.FunctionDef | None
    names: tuple[str, ...]


def _scopes(tree: ast.Module) -> Iterator[_Scope]:
    """Return the functions of a module, and its constants."""
    todo: list[tuple[str, ast.stmt]] = [("", node) for node in tree.body]
    for prefix, node in todo:
        if isinstance(node, ast.ClassDef):
            todo += [(f"{prefix}{node.name}.", inner) for inner in node.body]
        elif isinstance(node, ast.FunctionDef):
            yield _Scope(prefix + node.name, tuple(node.body), node, ())
        elif isinstance(node, ast.Assign) and not prefix:
            targets = [name for target in node.targets for name in _names(target)]
            if targets and all(name.isupper() for name in targets):
                yield _Scope(", ".join(targets), (node,), None, tuple(targets))


def _names(target: ast.expr) -> list[str]:
    """Return the names that a target of an assignment sets."""
    return [node.id for node in ast.walk(target) if isinstance(node, ast.Name)]


def _of_scope(source: Source, scope: _Scope) -> Iterator[Change]:
    """Return the changes in one function or constant."""
    twins = arguments.twins(source.text, scope.function) if scope.function else {}
    for node, inside_index in _nodes(scope.body):
        for operator, begin, end, new in _of_node(source, node, inside_index, twins):
            yield Change(operator, scope.where, begin, end, new, scope.names)


def _nodes(body: tuple[ast.stmt, ...]) -> Iterator[tuple[ast.AST, bool]]:
    """Return the nodes whose values matter, and whether each is inside an index."""
    todo: list[tuple[ast.AST, bool]] = [(node, False) for node in reversed(body)]
    while todo:
        node, inside = todo.pop()
        if isinstance(node, (ast.Raise, ast.JoinedStr, ast.Import, ast.ImportFrom, ast.Assert)):
            continue
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            continue  # a docstring
        yield node, inside
        for name, value in reversed(list(ast.iter_fields(node))):
            if name in ("annotation", "returns", "decorator_list", "args", "keywords") and (
                isinstance(node, (ast.FunctionDef, ast.AnnAssign, ast.Lambda))
            ):
                continue
            inner = value if isinstance(value, list) else [value]
            deeper = inside or (isinstance(node, ast.Subscript) and name == "slice")
            todo += [(one, deeper) for one in reversed(inner) if isinstance(one, ast.AST)]


Piece = tuple[str, int, int, str]  # operator, begin, end, new text


def _of_node(
    source: Source, node: ast.AST, inside: bool, twins: dict[str, tuple[str, ...]]
) -> Iterator[Piece]:
    """Return what the operators make of one node."""
    if isinstance(node, ast.Compare):
        yield from _comparisons(source, node)
    elif isinstance(node, ast.BinOp):
        yield from _arithmetic(source, node)
    elif isinstance(node, ast.BoolOp):
        yield from _logic(source, node)
    elif isinstance(node, ast.UnaryOp):
        names = {ast.USub: "sign flipped", ast.Not: "not dropped"}
        if type(node.op) in names:
            yield _replaced(source, node, names[type(node.op)], source.operand(node.operand))
    elif isinstance(node, ast.Constant) and not inside:
        yield from _constants(source, node)
    elif isinstance(node, ast.Call):
        yield from _calls(source, node)
    elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
        yield _replaced(source, node, "call left out", "pass")
    elif isinstance(node, ast.Subscript):
        yield from _indices(source, node)
    elif isinstance(node, ast.AugAssign) and type(node.op) in (ast.Add, ast.Sub):
        yield from _token(source, node.target, node.value, "sign flipped", _SIGNS[type(node.op)])
        yield _replaced(source, node, "term left out", "pass")
    elif isinstance(node, ast.Assign):
        yield from _bounds(source, node)
    elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
        for other in twins.get(node.id, ()):
            yield _replaced(source, node, "another argument", other)
        if node.id.isupper() and BOUND.search(node.id):
            for divisor in DIVISORS:
                yield _replaced(source, node, "bound divided", f"({node.id} / {divisor})")


_SIGNS = {ast.Add: ("+", "-"), ast.Sub: ("-", "+")}


def _replaced(source: Source, node: ast.expr | ast.stmt, operator: str, new: str) -> Piece:
    """Replace a whole node."""
    return operator, source.begin(node), source.end(node), new


def _token(
    source: Source,
    left: ast.expr,
    right: ast.expr,
    operator: str,
    tokens: tuple[str, str],
) -> Iterator[Piece]:
    """Replace the token between two nodes, if it is found there exactly once."""
    begin, end = source.end(left), source.begin(right)
    between = source.text[begin:end]
    old, new = tokens
    hits = list(re.finditer(rf"(?<![<>=!+*/-]){re.escape(old)}(?![<>=*/-])", between))
    if len(hits) == 1 and "#" not in between:
        yield operator, begin + hits[0].start(), begin + hits[0].end(), new


def _comparisons(source: Source, node: ast.Compare) -> Iterator[Piece]:
    """Make a comparison strict or loose, or turn it."""
    for left, op, right in zip(
        (node.left, *node.comparators), node.ops, node.comparators, strict=False
    ):
        token = TOKENS.get(type(op), "")
        if token in STRICT:
            yield from _token(
                source, left, right, "comparison strict or loose", (token, STRICT[token])
            )
        if token in TURNED:
            yield from _token(source, left, right, "comparison turned", (token, TURNED[token]))


def _arithmetic(source: Source, node: ast.BinOp) -> Iterator[Piece]:
    """Flip the sign of a sum, or leave out a term or a factor."""
    kind = type(node.op)
    texts = (ast.JoinedStr, ast.List, ast.Tuple)
    sides = (node.left, node.right)
    if kind not in (ast.Add, ast.Sub, ast.Mult, ast.Div) or any(
        isinstance(side, texts) or (isinstance(side, ast.Constant) and isinstance(side.value, str))
        for side in sides
    ):
        return
    if kind in _SIGNS:
        yield from _token(source, node.left, node.right, "sign flipped", _SIGNS[kind])
    operator = "term left out" if kind in _SIGNS else "factor left out"
    yield _replaced(source, node, operator, source.operand(node.left))
    if kind in (ast.Add, ast.Mult):
        yield _replaced(source, node, operator, source.operand(node.right))
    if kind is ast.Add and isinstance(node.left, ast.Constant) and node.left.value == 1.0:
        # a factor 1 + x that covers rounding
        for divisor in DIVISORS:
            new = f"{source.operand(node.right)} / {divisor}"
            yield _replaced(source, node.right, "bound divided", new)


def _logic(source: Source, node: ast.BoolOp) -> Iterator[Piece]:
    """Swap `and` and `or`."""
    other = "or" if isinstance(node.op, ast.And) else "and"
    text = f" {other} ".join(source.operand(value) for value in node.values)
    yield _replaced(source, node, "and, or swapped", f"({text})")


def _constants(source: Source, node: ast.Constant) -> Iterator[Piece]:
    """Scale a number."""
    value, text = node.value, source.of(node)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or value == 0:
        return
    for factor in FACTORS if isinstance(value, float) else WHOLE_FACTORS:
        yield _replaced(source, node, "constant scaled", f"({factor} {text})")
    if isinstance(value, int) and value > 1:
        yield _replaced(source, node, "constant scaled", f"({text} // 2)")


def _calls(source: Source, node: ast.Call) -> Iterator[Piece]:
    """Leave out a call, swap smallest and largest, or run a loop once too seldom."""
    function = node.func
    name = function.attr if isinstance(function, ast.Attribute) else ast.unparse(function)
    if name in EXTREMES:
        end = source.end(function)
        yield "min, max swapped", end - len(name), end, EXTREMES[name]
    plain = isinstance(function, ast.Name) or ast.unparse(function).startswith(("np.", "math."))
    one_list = name in ("max", "min") and len(node.args) == 1
    starred = any(isinstance(argument, ast.Starred) for argument in node.args)
    if name in LEFT_OUT and plain and not one_list and not starred:
        for argument in node.args[:2]:
            yield _replaced(source, node, "call left out", source.operand(argument))
    if name == "range" and not node.keywords:
        last = node.args[min(1, len(node.args) - 1)]
        yield _replaced(source, last, "range off by one", f"{source.operand(last)} - 1")
        if len(node.args) == 1:
            new = f"range(1, {source.of(last)})"
            yield _replaced(source, node, "range off by one", new)
        else:
            new = f"{source.operand(node.args[0])} + 1"
            yield _replaced(source, node.args[0], "range off by one", new)


def _indices(source: Source, node: ast.Subscript) -> Iterator[Piece]:
    """Take the neighbour of an element."""
    parts = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
    for part in parts:
        if isinstance(part, ast.Constant) and isinstance(part.value, int):
            for shift in (1, -1):
                if part.value + shift >= 0:
                    new = str(part.value + shift)
                    yield _replaced(source, part, "index off by one", new)
        elif isinstance(part, (ast.Name, ast.BinOp)) and not _is_text(part):
            for shift in ("+ 1", "- 1"):
                yield _replaced(source, part, "index off by one", f"{source.operand(part)} {shift}")
        elif isinstance(part, ast.Slice):
            for bound in (part.lower, part.upper):
                if bound is not None:
                    new = f"{source.operand(bound)} + 1"
                    yield _replaced(source, bound, "index off by one", new)


def _is_text(node: ast.expr) -> bool:
    """Return whether an index is a name of masks or fields, not a number."""
    masks = ("mask", "chosen", "active", "selected", "unpinned", "empty", "used", "keep")
    return isinstance(node, ast.Name) and node.id in masks


def _bounds(source: Source, node: ast.Assign) -> Iterator[Piece]:
    """Divide a bound of rounding where it is set."""
    names = [name for target in node.targets for name in _names(target)]
    if isinstance(node.value, ast.Tuple) or not any(BOUND.search(name) for name in names):
        return
    for divisor in DIVISORS:
        new = f"{source.operand(node.value)} / {divisor}"
        yield _replaced(source, node.value, "bound divided", new)
