"""What a notebook shows: pages, their figures, and small tables."""

from __future__ import annotations

import html
import math
import re
from os import PathLike
from pathlib import Path

# A title, or a figure with what stands in it.
_PARTS = re.compile(r"<h[23][^>]*>(.*?)</h[23]>|(<svg\b.*?</svg>)", re.DOTALL)
_STYLE = re.compile(r"<style>(.*?)</style>", re.DOTALL)
# So many rows of columns are shown.
_SHOWN = 10
# Width and height of a drawn figure, and the margin around its field.
_WIDTH, _HEIGHT, _MARGIN = 560, 330, 60


class Figures(dict[str, str]):
    """Figures (SVG files as text) by their titles; a notebook shows them side by side."""

    @classmethod
    def of_page(cls, page: str) -> Figures:
        """The figures of a report page, each with the page's colours."""
        style = "".join(_STYLE.findall(page))
        figures, title = cls(), "figure"
        for heading, svg in _PARTS.findall(page):
            if heading:
                title = html.unescape(re.sub(r"<[^>]*>", "", heading)).strip()
                continue
            name, number = title, 1
            while name in figures:
                number += 1
                name = f"{title} ({number})"
            figures[name] = re.sub(r"(<svg\b[^>]*>)", rf"\1<style>{style}</style>", svg, count=1)
        return figures

    @classmethod
    def of_columns(cls, columns: dict[str, list[float]]) -> Figures:
        """A line for each column over the first one."""
        (x_name, x), *others = columns.items()
        return cls({name: _line(x_name, x, name, y) for name, y in others})

    def save(self, folder: str | PathLike[str]) -> list[Path]:
        """Write each figure into a folder, as `<title>.svg`, and return the paths."""
        into = Path(folder)
        into.mkdir(parents=True, exist_ok=True)
        paths = []
        for name, svg in self.items():
            path = into / (re.sub(r"[^\w.-]+", "-", name).strip("-") + ".svg")
            path.write_text(svg, encoding="utf-8")
            paths.append(path)
        return paths

    def _repr_html_(self) -> str:
        shown = "".join(f"<figure><figcaption>{html.escape(name)}</figcaption>{svg}</figure>" for name, svg in self.items())
        style = "body{margin:0;font:15px system-ui,sans-serif}main{display:flex;flex-wrap:wrap;gap:16px}figure{margin:0;flex:1 1 440px}"
        return framed(f"<!doctype html><meta charset=utf-8><style>{style}</style><main>{shown}</main>")


def framed(page: str) -> str:
    """A page of its own inside that of a notebook: the styles of neither reach the other."""
    frame = "width:100%;height:600px;border:0"
    return f'<iframe srcdoc="{html.escape(page, quote=True)}" style="{frame}" title="report"></iframe>'


def table(columns: dict[str, list[float]]) -> str:
    """The first rows of columns."""
    rows = list(zip(*columns.values()))
    head = "".join(f"<th>{html.escape(name)}</th>" for name in columns)
    body = "".join("<tr>" + "".join(f"<td>{value:g}</td>" for value in row) + "</tr>" for row in rows[:_SHOWN])
    more = f"<p>{len(rows)} rows</p>" if len(rows) > _SHOWN else ""
    return f"<table><tr>{head}</tr>{body}</table>{more}"


def routines(rows: list[list[str]]) -> str:
    """The routines that were generated."""
    cells = [["routine", "language", "range", "proven within"], *rows]
    lines = ("".join(f"<td>{html.escape(cell)}</td>" for cell in row) for row in cells)
    return "<table>" + "".join(f"<tr>{line}</tr>" for line in lines) + "</table>"


def _line(x_name: str, x: list[float], y_name: str, y: list[float]) -> str:
    """A line over finite points, with the ends of both axes."""
    points = [(a, b) for a, b in zip(x, y) if math.isfinite(a) and math.isfinite(b)]
    if not points:
        points = [(0.0, 0.0)]
    # More points than pixels are not seen.
    points = points[:: max(1, len(points) // (4 * _WIDTH))]
    (left, right), (low, high) = (_ends(values) for values in zip(*points))

    def across(value: float) -> float:
        return _MARGIN + (value - left) / (right - left) * (_WIDTH - 2 * _MARGIN)

    def up(value: float) -> float:
        return _HEIGHT - _MARGIN - (value - low) / (high - low) * (_HEIGHT - 2 * _MARGIN)

    def text(x: float, y: float, anchor: str, what: str) -> str:
        return f'<text x="{x}" y="{y}" text-anchor="{anchor}" fill="currentColor">{html.escape(what)}</text>'

    path = " ".join(f"{across(a):.1f},{up(b):.1f}" for a, b in points)
    bottom = _HEIGHT - _MARGIN + 18
    return (
        f'<svg width="{_WIDTH}" height="{_HEIGHT}" viewBox="0 0 {_WIDTH} {_HEIGHT}" xmlns="http://www.w3.org/2000/svg" '
        f'font-family="system-ui, sans-serif" font-size="12">'
        f'<rect x="{_MARGIN}" y="{_MARGIN}" width="{_WIDTH - 2 * _MARGIN}" height="{_HEIGHT - 2 * _MARGIN}" fill="none" stroke="#8a94a3"/>'
        f'<polyline points="{path}" fill="none" stroke="#1f6fb2" stroke-width="1.5"/>'
        + text(_MARGIN, bottom, "start", f"{left:g}")
        + text(_WIDTH - _MARGIN, bottom, "end", f"{right:g}")
        + text(_WIDTH // 2, bottom, "middle", x_name)
        + text(_MARGIN - 6, _HEIGHT - _MARGIN, "end", f"{low:.4g}")
        + text(_MARGIN - 6, _MARGIN + 4, "end", f"{high:.4g}")
        + text(_MARGIN, _MARGIN - 10, "start", y_name)
        + "</svg>"
    )


def _ends(values: tuple[float, ...]) -> tuple[float, float]:
    low, high = min(values), max(values)
    return (low, high) if high > low else (low - 1.0, high + 1.0)
