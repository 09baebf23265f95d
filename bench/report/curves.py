"""Error, or the metric that a sweep's [plot] names, against one of its axes: a line per setting, a column of panels per value of `columns`, a
row per scene variant and view, and below them the memory of the maps. What does not vary along the axis is a level line. Frame times have
the unshadowed frame beside them: a view that holds more costs more without any shadow."""
import numpy
import pandas
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, FuncFormatter, NullFormatter, NullLocator

from figure import COLOURS, MARKERS, MUTED, Texts, layout, plainSize, save
from results import BASELINES
from work_precision import describeLost, intervals, plainTicks

PANEL_SIZE = (4.2, 3.4)  # inches
MEMORY_HEIGHT = 1.6
# metric → (title, name of its axis)
NAMES = {"error": ("Error", "error: share of wrong pixels, %"),
         "mean_absolute": ("Mean error", "mean |visibility − truth|, %"),
         "excess_flips": ("Popping", "excess flips: pixels a frame, %"),
         "frame_time": ("Frame time", "median frame time, ms (bars: 95 %)")}
# Axes and keys of recipes that are measured in something.
UNITS = {"size": "texels a side", "cluster": "triangles", "leaf": "triangles", "exact-casters": "triangles", "far-field": "m", "radius": "m",
         "scale": "× area", "trees": "trees", "rotations": "maps", "own": "maps", "budget": "maps a frame", "time": "s",
         "sun.elevation": "degrees", "sun.azimuth": "degrees"}
YARDSTICK = "unshadowed"
LOG_RANGE = 8  # greatest / least value from which an axis is logarithmic;
SCENE_LOG_RANGE = 100  # of what sets scenes apart: counts may span so much, angles do not


def nameOf(metric, units):
    """(title, name of its axis with the unit)."""
    unit = units.get(metric, "")
    return NAMES.get(metric, (metric, f"{metric}, {unit}" if unit else f"{metric} (ratio)"))


def positions(values, name):
    """(position by value, label by value, name of the axis): numbers where they are, other values one after the other.
    Variants that set the same keys stand for what they set them to."""
    shown = {value: value or "as it is" for value in values}
    settings = {value: dict(item.split("=", 1) for item in value.split("; ") if "=" in item) for value in values}
    keys = {tuple(found) for found in settings.values()}
    if len(keys) == 1 and keys != {()}:
        name = ", ".join(*keys)
        shown = {value: ", ".join(dict.fromkeys(found.values())) for value, found in settings.items()}
    numeric = pandas.to_numeric(pandas.Series(shown), errors="coerce")
    if numeric.isna().any():
        return {value: float(i) for i, value in enumerate(shown)}, shown, name
    return numeric.to_dict(), shown, name


def split(points, request, axes):
    """`points` with columns line (its label), level (does not vary along x) and column (panel; empty: all of them)."""
    dropped = [name for name in BASELINES if name != YARDSTICK or request["y"] != "frame_time"]
    points = points[~points.technique.isin(dropped)].copy()
    x, columns = request["x"], request["columns"]
    others = [axis for axis in axes if axis not in (x, columns)]
    several = points.technique[points.technique != YARDSTICK].nunique() > 1
    points["column"] = points[columns] if columns else ""
    points["level"] = False
    points["line"] = ""
    for (technique, column), own in points.groupby(["technique", "column"], sort=False):
        level = own[own.state != "pruned"][x].nunique() < 2
        points.loc[own.index, "level"] = level
        varying = [a for a in others if points[points.technique == technique][a].nunique() > 1]
        words = [technique if several or technique == YARDSTICK else "", column if level else ""]
        for index, row in own.iterrows():
            named = [f"{a} {row[a]}" if len(varying) > 1 or row[a].isdigit() else row[a] for a in varying]
            points.loc[index, "line"] = " ".join(filter(None, words if level else [words[0], ", ".join(named)])) or technique
    points.loc[points.level, "column"] = ""
    return points


def drawPanel(axes, points, x, place, styles, figure, zeroAt=None):
    for line, own in points.groupby("line", sort=False):
        own = own[own[figure].notna()]
        colour, marker = styles[line]
        values = own[figure] if zeroAt is None else own[figure].where(own[figure] > 0, zeroAt)
        if own.level.any():
            for value in sorted(set(values)):
                axes.axhline(value, color=colour, linewidth=1.3, linestyle=(0, (5, 2)), zorder=2)
            for row in own.itertuples() if figure == "frame_time" else []:
                axes.axhspan(row.frame_lo, row.frame_hi, color=colour, alpha=0.12, linewidth=0, zorder=1)
            continue
        at = own[x].map(place)
        order = numpy.argsort(at.to_numpy(), kind="stable")
        axes.plot(at.iloc[order], values.iloc[order], color=colour, marker=marker, markersize=4.5, linewidth=1.3, zorder=3)
        if figure == "frame_time":
            axes.errorbar(at, values, yerr=intervals(own), fmt="none", ecolor=colour, elinewidth=1, capsize=2, zorder=3)
        zero = (own[figure] == 0) & (zeroAt is not None)
        axes.plot(at[zero], values[zero], linestyle="none", marker=11, markersize=8, color=colour, zorder=4)


def styleX(axes, place, shown, ofTechnique):
    where = sorted(place.values())
    if where[0] > 0 and where[-1] / where[0] >= (LOG_RANGE if ofTechnique else SCENE_LOG_RANGE):
        axes.set_xscale("log")
    axes.xaxis.set_major_locator(FixedLocator(where))
    axes.xaxis.set_minor_locator(NullLocator())
    labels = {place[value]: text for value, text in shown.items()}
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: labels.get(value, "")))
    axes.xaxis.set_minor_formatter(NullFormatter())
    if max(map(len, shown.values())) > 8:
        axes.tick_params(axis="x", rotation=30)
    axes.grid(True, which="major", color="#e6e6e6", linewidth=0.6, zorder=0)
    axes.set_axisbelow(True)


def drawCurves(run, points, stem):
    """One figure for a scene at one size. Returns the paths, none where nothing was measured."""
    x, y = run.plot["x"], run.plot["y"]
    points = split(points, run.plot, run.axes)
    measured = points[(points.state == "ok") & points[y].notna()]
    if not len(measured):
        return []
    along = measured[~measured.level] if not measured.level.all() else measured
    place, shown, name = positions(list(dict.fromkeys(along[x])), x)
    places = [key for key in ("variant", "view", "stress") if key not in (x, run.plot["columns"])]
    keys = [key for key in places if measured[key].nunique() > 1]
    common = [measured[key].iloc[0] for key in places if key not in keys]
    rows = list(dict.fromkeys(measured[keys].itertuples(index=False, name=None))) if keys else [()]
    columns = list(dict.fromkeys(along.column))
    # Lines that vary first, so that their colours do not depend on how many levels there are.
    lines = list(dict.fromkeys([*along.line, *measured.line]))
    lines.sort(key=lambda line: line == YARDSTICK)
    styles = {line: (COLOURS[i % len(COLOURS)], MARKERS[i % len(MARKERS)]) for i, line in enumerate(lines)}
    styles[YARDSTICK] = (MUTED, "")
    memory = measured[measured.texture_bytes > 0].copy()
    memory = memory if memory.texture_bytes.nunique() > 1 else memory.head(0)
    memory["mib"] = memory.texture_bytes / 2**20
    notes = describeLost(points[points.state != "pruned"])
    positive = measured.loc[measured[y] > 0, y]
    signed = (measured[y] < 0).any()
    zeroAt = None if signed else positive.min() / 2 if len(positive) else 1e-6
    if not signed and (measured[y] == 0).any():
        notes.insert(0, "A logarithmic axis has no 0: ▼ points without any stand at half the least.")

    title, yName = nameOf(y, run.units)
    long = max(map(len, shown.values())) > 8  # labels that stand aslant
    levels = set(measured.line[measured.level])
    handles = [Line2D([], [], color=styles[line][0], label=line, markersize=5, linestyle=(0, (5, 2)) if line in levels else "-",
                      marker="" if line in levels else styles[line][1]) for line in lines]
    texts = Texts(" · ".join(filter(None, [f"{title} by {x if ',' in name else name}: {points.place.iloc[0]}", *common])), run.machine, notes)
    figure, panels = layout(PANEL_SIZE, len(columns), texts, handles, [1.0] * len(rows) + [MEMORY_HEIGHT / PANEL_SIZE[1]] * bool(len(memory)),
                            below=0.95 if long else 0.5, gaps=(0.08, 0.2), sharex=True, sharey="row")
    for row, key in enumerate(rows):
        here = measured[(measured[keys] == key).all(axis=1)] if keys else measured
        for column, value in enumerate(columns):
            axes = panels[row][column]
            if signed:
                axes.axhline(0, color=MUTED, linewidth=0.8, zorder=1)
            else:
                axes.set_yscale("log")
            drawPanel(axes, here[(here.column == value) | (here.column == "")], x, place, styles, y, zeroAt)
            styleX(axes, place, shown, name == x)
            heading = [*(text for text in key if text), f"{run.plot['columns']} {value}" if value else ""]
            axes.set_title(" · ".join(filter(None, heading)), fontsize=plainSize(9), loc="left")
        panels[row][0].set_ylabel(yName, fontsize=plainSize(9))
    for column, value in enumerate(columns) if len(memory) else []:
        axes = panels[-1][column]
        axes.set_yscale("log")
        drawPanel(axes, memory[(memory.column == value) | (memory.column == "")], x, place, styles, "mib")
        styleX(axes, place, shown, name == x)
        plainTicks(axes.yaxis, lambda number: f"{number:g}")
    if len(memory):
        panels[-1][0].set_ylabel("maps, MiB")
    for axes in panels[:len(rows)].flat:
        text = (lambda number: f"{number * 100:g} %") if yName.endswith("%") else (lambda number: f"{number:g}")
        if signed:
            axes.yaxis.set_major_formatter(FuncFormatter(lambda number, _, text=text: text(round(number, 6))))
        else:
            plainTicks(axes.yaxis, text)
    for axes in panels[-1]:
        axes.set_xlabel(f"{name}, {UNITS[name]}" if name in UNITS else name, fontsize=plainSize(9))
    return save(figure, stem)
