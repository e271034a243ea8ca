"""Plots in one style: vector graphics with real text, whose lines differ in greyscale too."""

import hashlib
import io
import math
import re
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

INK, GRID = "#222222", "#e2e2e2"
# Neighbours differ in lightness; after M. Okabe, K. Ito, Color Universal Design (2008).
COLORS = ("#0b3c6f", "#d1495b", "#3a9d64", "#e09f1f", "#6b4c9a", "#1f8fb4", "#7a4a21", "#8a8f98")
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<", ">", "h", "*", "p")
LINES = ("-", "--", "-.", ":", (0, (6, 1.5, 1, 1.5, 1, 1.5)))
FONT = "system-ui, sans-serif"
PIXELS_PER_INCH = 96.0
# A plot is squeezed down to this share of its size; if there is less room, it scrolls in its box.
SQUEEZED = 0.72
SETTINGS: dict[Any, Any] = {
    "svg.fonttype": "none",
    "svg.hashsalt": "izo_ref",
    "font.family": "DejaVu Sans",  # comes with matplotlib; wider than fonts of browsers
    "font.size": 10,
    "axes.titlesize": 11,
    "axes.edgecolor": "#999999",
    "axes.labelcolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": GRID,
    "grid.linewidth": 0.8,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "lines.linewidth": 1.6,
    "lines.markersize": 6,
    "legend.frameon": False,
    "legend.fontsize": 9,
    "legend.handlelength": 3.2,
}


def new(
    width: float = 8.0, height: float = 4.5, ncols: int = 1, nrows: int = 1, **kwargs: Any
) -> "tuple[Figure, Any]":
    """Return a new figure and its axes.

    Args:
        width: Width [inch]; an inch is 96 pixels of a page at full size.
        height: Height [inch].
        ncols: Number of columns of axes.
        nrows: Number of rows of axes.
        kwargs: Further arguments of `matplotlib.figure.Figure.subplots`.

    Returns:
        The figure, and one axes or an array of axes.
    """
    from matplotlib.figure import Figure

    _set_up()
    figure = Figure((width, height), layout="constrained")
    return figure, figure.subplots(nrows, ncols, **kwargs)


def style(i: int) -> dict[str, Any]:
    """Return color, marker and dashes of line i; marker and dashes alone distinguish 60 lines."""
    return {
        "color": COLORS[i % len(COLORS)],
        "marker": MARKERS[i % len(MARKERS)],
        "linestyle": LINES[i % len(LINES)],
    }


def logarithmic(ax: Any, x: bool = True, y: bool = True) -> None:
    """Make axes logarithmic, with powers of ten that are readable at a small size."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    for wanted, axis, name in ((x, ax.xaxis, "x"), (y, ax.yaxis, "y")):
        if wanted:
            ax.set(**{f"{name}scale": "log"})
            axis.set_major_locator(LogLocator(numticks=9))
            axis.set_major_formatter(FuncFormatter(power_of_ten))
            axis.set_minor_formatter(NullFormatter())


def power_of_ten(value: float, _position: int | None = None) -> str:
    """Return the label of a tick: 0.01 to 1000 as they are, others as 10 with raised digits."""
    if value <= 0.0:
        return ""
    exponent = round(math.log10(value))
    if -2 <= exponent <= 3:
        return f"{value:g}"
    return "10" + str(exponent).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def legend_below(figure: "Figure", axes: Iterable[Any], ncols: int = 4) -> None:
    """Put one legend for all axes below them."""
    found: dict[str, Any] = {}
    for ax in axes:
        handles, labels = ax.get_legend_handles_labels()
        found |= dict(zip(labels, handles, strict=True))
    if found:
        ncols = min(ncols, len(found))
        figure.legend(
            list(found.values()), list(found.keys()), loc="outside lower left", ncols=ncols
        )


def svg(figure: "Figure") -> str:
    """Return a figure as an SVG element of a page; equal figures give equal text."""
    out = io.StringIO()
    _set_up()
    figure.savefig(out, format="svg", metadata={"Date": None, "Creator": None})
    text = out.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"\s*<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r"\s*<style.*?</style>", "", text, flags=re.DOTALL)  # it would apply to the page
    text = text.replace("'DejaVu Sans'", FONT)
    # hundredths of a point are accurate enough, and halve the size
    text = re.sub(r' (d|x|y)="[^"]*"', lambda match: re.sub(r"(\.\d\d)\d+", r"\1", match[0]), text)
    # several figures share a page, so their ids have to differ
    prefix = "f" + hashlib.sha256(text.encode()).hexdigest()[:8] + "-"
    text = re.sub(r'(\bid="|href="#|url\(#)', lambda match: match[0] + prefix, text)
    width = figure.get_figwidth() * PIXELS_PER_INCH
    least = SQUEEZED * width
    size = f"stroke-linejoin:round;width:100%;max-width:{width:.0f}px;min-width:{least:.0f}px"
    return re.sub(
        r'<svg [^>]*?(viewBox="[^"]*")[^>]*>',
        rf'<svg xmlns:xlink="http://www.w3.org/1999/xlink" \1 style="{size}" role="img">',
        text,
        count=1,
    )


def _set_up() -> None:
    import matplotlib

    matplotlib.rcParams.update(SETTINGS)
