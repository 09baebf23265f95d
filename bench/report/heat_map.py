"""Stability: technique × stiff case. Colour is the error; words say what failed or which fallback was in force."""
import matplotlib.pyplot as plt
import numpy
from matplotlib.colors import LogNorm
from matplotlib.ticker import FuncFormatter, NullFormatter

from figure import MUTED, Texts, layout, plainSize, save
from results import BASELINES


def cellText(point):
    if point.state != "ok":
        return {"failed": "FAILED", "pruned": "left out", "missing": "missing"}[point.state]
    if numpy.isnan(point.error):
        return "no error"
    error = "0" if point.error == 0 else f"{point.error * 100:.2g} %"
    return error + ("\nfallback" if point.fallback else "")


def drawHeatMap(run, stem):
    points = run.points[~run.points.technique.isin(BASELINES)]
    # A technique's settings, and a case's scene and view, are named where there is more than one.
    several = {column: points[column].nunique() > 1 for column in ("scene", "view", "variant")}
    rowOf = [" ".join(filter(None, [p.technique, p.varies])) for p in points.itertuples()]
    columnOf = [" · ".join(filter(None, [p.stress or "unstressed", p.scene if several["scene"] else "",
                                         p.view if several["view"] else "",
                                         p.variant if several["variant"] else ""])) for p in points.itertuples()]
    rows, columns = list(dict.fromkeys(rowOf)), list(dict.fromkeys(columnOf))
    errors = numpy.full((len(rows), len(columns)), numpy.nan)
    texts = {}
    for row, column, point in zip(rowOf, columnOf, points.itertuples()):
        i, j = rows.index(row), columns.index(column)
        texts.setdefault((i, j), []).append(cellText(point))
        if point.state == "ok":
            errors[i, j] = numpy.nanmax([errors[i, j], point.error]) if not numpy.isnan(point.error) else errors[i, j]

    positive = errors[errors > 0]
    low, high = (positive.min(), positive.max()) if positive.size else (1e-6, 1.0)
    norm = LogNorm(low, max(high, low * 10))
    cells = numpy.ma.masked_invalid(numpy.where(errors == 0, low, errors))
    notes = [f"{name}: {', '.join(dict.fromkeys(cases))}." for name, cases in explain(points, rowOf, columnOf).items()]
    left = 0.4 + 0.075 * max(map(len, rows))  # inches for the names of the rows, and above for the slanted cases
    above = 0.2 + 0.047 * max(map(len, columns))
    figure, panels = layout((0.95 * len(columns) + 1.0, 0.5 * len(rows)), 1, Texts("Error at stiff cases", run.machine, notes), [], [1.0],
                            above=above, below=0.15, left=left)
    axes = panels[0][0]
    colours = plt.get_cmap("cividis").copy()
    colours.set_bad("#f0f0f0")
    image = axes.imshow(cells, cmap=colours, norm=norm, aspect="auto")
    axes.set_xticks(range(len(columns)), columns, rotation=40, ha="left", rotation_mode="anchor", fontsize=plainSize(8))
    axes.xaxis.tick_top()
    axes.set_yticks(range(len(rows)), rows)
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)
    axes.set_xticks(numpy.arange(len(columns) + 1) - 0.5, minor=True)
    axes.set_yticks(numpy.arange(len(rows) + 1) - 0.5, minor=True)
    axes.grid(which="minor", color="white", linewidth=1.5)
    axes.tick_params(which="minor", length=0)
    for (i, j), words in texts.items():
        dark = not cells.mask[i, j] if numpy.ma.is_masked(cells) else True
        colour = "#b00020" if "FAILED" in words else "white" if dark and norm(cells[i, j]) < 0.55 else "black"
        axes.text(j, i, "\n".join(dict.fromkeys(words)), ha="center", va="center", fontsize=plainSize(7), color=colour)
    bar = figure.colorbar(image, ax=axes, fraction=0.03, pad=0.02, aspect=15)
    bar.ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value * 100:g} %"))
    bar.ax.yaxis.set_minor_formatter(NullFormatter())
    bar.ax.set_title("error, %", fontsize=plainSize(8), color=MUTED)
    bar.outline.set_visible(False)
    return save(figure, stem)


def explain(points, rowOf, columnOf):
    """Reason → "technique at case" for what failed, was left out or fell back."""
    reasons = {}
    for row, column, point in zip(rowOf, columnOf, points.itertuples()):
        words = {"failed": "Failed", "pruned": "Left out", "missing": "Missing"}.get(point.state)
        if words:
            reasons.setdefault(f"{words} ({point.why or 'no reason given'})", []).append(f"{row} at {column}")
        elif point.fallback:
            reasons.setdefault(f"Fallback ({point.fallback})", []).append(f"{row} at {column}")
    return reasons
