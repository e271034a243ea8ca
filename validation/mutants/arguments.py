"""Find the parameters of a function that could be confused: arrays or numbers of one kind."""

import ast
import re

# `# (n, 3) f8 [m], what it is` beside a parameter, or `name: (n, 3) f8 [m], ...` in a docstring
BESIDE = re.compile(r"#\s*(\([^)]*\) \w+|\w\d)")
IN_TEXT = r"^\s*{}: (\([^)]*\) \w+|\[[^]]*\])"


def twins(text: str, function: ast.FunctionDef) -> dict[str, tuple[str, ...]]:
    """Return, for each parameter, the others with the same declared type and shape.

    The type is the annotation. The shape is in the comment beside the parameter or in the
    docstring; parameters whose shape is not stated are alike if their annotations are.

    Args:
        text: The source of the module.
        function: A function of it.
    """
    lines, docstring = text.splitlines(), ast.get_docstring(function) or ""
    kinds: dict[str, list[str]] = {}
    parameters = [*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs]
    for parameter in parameters:
        if parameter.annotation is None:
            continue
        beside = BESIDE.search(lines[parameter.lineno - 1])
        within = re.search(IN_TEXT.format(re.escape(parameter.arg)), docstring, re.MULTILINE)
        shape = beside or within
        kind = f"{ast.unparse(parameter.annotation)} {shape.group(1) if shape else ''}"
        kinds.setdefault(kind, []).append(parameter.arg)
    return {
        name: tuple(other for other in names if other != name)
        for names in kinds.values()
        for name in names
        if len(names) > 1
    }
