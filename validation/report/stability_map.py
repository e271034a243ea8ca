"""The map of a family: a strip of cells for each ladder, as a picture."""

import html
import textwrap
from collections.abc import Sequence

from validation.ladders.ladder import ANOTHER, NO_ANSWER, RIGHT, SAYS_SO, WRONG
from validation.report.stability_rows import Measured

# Color and sign of each verdict. The colors differ in lightness, and the signs without color.
LOOK = {
    RIGHT: ("#bfe3c6", ""),
    SAYS_SO: ("#f6d58a", "!"),
    ANOTHER: ("#c9b8e8", "≠"),
    NO_ANSWER: ("#9aa3ad", "…"),
    WRONG: ("#b3261e", "×"),
}
INK, PAPER, LINE = "#1c1c1c", "#ffffff", "#ffffff"
LABEL_PX, WIDTH_PX, MARGIN_PX = 215, 1000, 12
ROW_PX, TEXT_PX, GAP_PX = 30, 11, 4
LEAST_CELL_PX = 46
CHARACTER_PX = 6.2  # of TEXT_PX letters, on average


def map_svg(title: str, found: Sequence[Measured]) -> str:
    """Return the map of a family as an SVG document.

    Args:
        title: Plain text, for screen readers too.
        found: The ladders with what was measured.
    """
    y, parts = MARGIN_PX, []
    for measured in found:
        strip, height = _strip(measured, y)
        parts += strip
        y += height + GAP_PX
    parts += _legend(y + GAP_PX)
    height = y + ROW_PX + 2 * MARGIN_PX
    label = html.escape(title, quote=True)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH_PX} {height}" role="img" '
        f'aria-label="{label}" font-family="system-ui, sans-serif" font-size="{TEXT_PX}">\n'
        f'<rect width="{WIDTH_PX}" height="{height}" fill="{PAPER}"/>\n' + "\n".join(parts) + "\n"
        "</svg>\n"
    )


def _strip(measured: Measured, y: int) -> tuple[list[str], int]:
    """Return the shapes of one ladder whose top is at y, and its height."""
    cells = [(rung, outcome.verdict) for rung, outcome in measured.own]
    room = WIDTH_PX - LABEL_PX - 2 * MARGIN_PX
    in_row = max(1, min(len(cells), room // LEAST_CELL_PX))
    if measured.named:  # names need room: as many in a row as keep three lines of text
        in_row = max(1, min(len(cells), 6))
    width = room / in_row
    lines = [_lines(rung, width) for rung, _ in cells]
    n_lines = max((len(text) for text in lines), default=1)
    parts = _label(measured, y)
    n_rows = -(-max(1, len(cells)) // in_row)
    of_label = (6 + len(parts) * (TEXT_PX + 3)) // n_rows
    height = max(ROW_PX, 10 + n_lines * (TEXT_PX + 3), of_label)
    for i, ((_, verdict), text) in enumerate(zip(cells, lines, strict=True)):
        x = LABEL_PX + MARGIN_PX + (i % in_row) * width
        top = y + (i // in_row) * height
        parts += _cell(x, top, width, height, verdict, text)
    return parts, n_rows * height


def _label(measured: Measured, y: float) -> list[str]:
    """Return the name of a ladder and what its rungs are, at the left of a strip."""
    letters = int((LABEL_PX - MARGIN_PX) / CHARACTER_PX)
    names = textwrap.wrap(measured.ladder.name, letters - 3)
    lines = [(name, "600", INK) for name in names]
    lines += [(unit, "", "#666") for unit in textwrap.wrap(measured.ladder.unit, letters)]
    parts = []
    for i, (words, weight, color) in enumerate(lines):
        top = y + TEXT_PX + 2 + i * (TEXT_PX + 3)
        parts += _text(words, MARGIN_PX, top, weight=weight, color=color)
    return parts


def _cell(
    x: float, y: float, width: float, height: float, verdict: str, lines: Sequence[str]
) -> list[str]:
    color, sign = LOOK[verdict]
    ink = PAPER if verdict == WRONG else INK
    parts = [
        f'<rect x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}" '
        f'fill="{color}" stroke="{LINE}"/>'
    ]
    top = y + height / 2 + 4 - (len(lines) - 1) * (TEXT_PX + 3) / 2
    for i, line in enumerate(lines):
        words = f"{line} {sign}" if sign and i == len(lines) - 1 else line
        parts += _text(words, x + width / 2, top + i * (TEXT_PX + 3), anchor="middle", color=ink)
    return parts


def _lines(rung: str, width: float) -> list[str]:
    letters = max(4, int((width - 8) / CHARACTER_PX))
    return textwrap.wrap(short(rung), letters) or [""]


def short(rung: str) -> str:
    """Return a number with few letters, such as 1e6 or 1 + 1e-11; a name as it is."""
    try:
        value = float(rung)
    except ValueError:
        return rung
    near, sign = float(f"{value:.5g}"), "+" if value > float(f"{value:.5g}") else "-"
    beyond = float(f"{abs(value - near):.1g}")
    if beyond > 0.0 and abs(abs(value - near) - beyond) <= 1e-3 * beyond:  # as in 1 + 1e-11
        return f"{_few_letters(near)} {sign} {_few_letters(beyond)}"
    return _few_letters(value)


def _few_letters(value: float) -> str:
    return f"{value:.5g}".replace("e+0", "e").replace("e+", "e").replace("e-0", "e-")


def _legend(y: float) -> list[str]:
    parts, x = [], float(LABEL_PX + MARGIN_PX)
    words = {
        RIGHT: "right",
        SAYS_SO: "not reached, and it says so",
        ANOTHER: "free, but another answer",
        NO_ANSWER: "no answer",
        WRONG: "wrong, not said",
    }
    for verdict, text in words.items():
        parts += _cell(x, y, 24, 18, verdict, [""])
        parts += _text(text, x + 30, y + 13)
        x += 60 + CHARACTER_PX * len(text)
    return parts


def _text(
    words: str, x: float, y: float, anchor: str = "start", weight: str = "", color: str = INK
) -> list[str]:
    bold = f' font-weight="{weight}"' if weight else ""
    return [
        f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" fill="{color}"{bold}>'
        f"{html.escape(words)}</text>"
    ]
