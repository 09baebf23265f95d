"""The work-precision diagram: error against frame time, log-log, a line per technique and a point per setting
(the model is SciML's WorkPrecisionSet: failures stay in the picture, as words)."""
import numpy
from matplotlib import patheffects
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from figure import COLOURS, MARKERS, MUTED, PAGE, Texts, layout, plainSize, save
from results import BASELINES, naturalOrder, paretoFront, varyingAxes

HALO = [patheffects.withStroke(linewidth=2, foreground="white")]  # keeps a label readable on a line
MAX_LABELS = 30  # beyond this only the front is labelled, else the labels hide the points
PANEL_SIZE = (6.4, 4.6)  # inches


def plainTicks(axis, form):
    # The narrower the range, the more ticks a decade needs before two of them carry a label.
    low, high = axis.get_view_interval()
    decades = numpy.log10(high / low)
    steps = (1,) if decades > 3 else (1, 2, 5) if decades > 0.8 else numpy.arange(1, 10)
    axis.set_major_locator(LogLocator(base=10, subs=steps, numticks=50))
    axis.set_minor_locator(LogLocator(base=10, subs=numpy.arange(1, 10), numticks=50))
    axis.set_minor_formatter(NullFormatter())
    axis.set_major_formatter(FuncFormatter(lambda value, _: form(value)))


def drawLabels(axes, labels, markers):
    """Puts each label on the side of its point where it hides least. `labels`: (x, y, text, colour)."""
    renderer = axes.figure.canvas.get_renderer()
    taken = []
    dots = axes.transData.transform(numpy.array(markers).reshape(-1, 2))
    frame = axes.get_window_extent(renderer)
    for x, y, text, colour in sorted(labels):
        best = None
        for dx, dy, ha, va in ((6, 4, "left", "bottom"), (-6, 4, "right", "bottom"), (6, -4, "left", "top"),
                               (-6, -4, "right", "top"), (0, 8, "center", "bottom"), (0, -8, "center", "top"),
                               (12, 12, "left", "bottom"), (-12, -12, "right", "top")):
            label = axes.annotate(text, (x, y), (dx, dy), textcoords="offset points", ha=ha, va=va, fontsize=plainSize(7),
                                  color=colour, path_effects=HALO, zorder=6)
            box = label.get_window_extent(renderer)
            cost = sum(3 * box.overlaps(other) for other in taken)
            cost += sum(box.x0 - 3 < u < box.x1 + 3 and box.y0 - 3 < v < box.y1 + 3 for u, v in dots)
            cost += 5 * (box.x0 < frame.x0 or box.x1 > frame.x1 or box.y0 < frame.y0 or box.y1 > frame.y1)
            if best is None or cost < best[0]:
                if best:
                    best[1].remove()
                best = (cost, label, box)
            else:
                label.remove()
            if cost == 0:
                break
        taken.append(best[2])


def intervals(points):
    """95 % intervals of the frame times, as errorbar() wants them; no bar where there is none."""
    return [(points.frame_ms - points.frame_lo).clip(lower=0).fillna(0), (points.frame_hi - points.frame_ms).clip(lower=0).fillna(0)]


def drawPanel(axes, points, allAxes, styles):
    """One scene at one size in one view."""
    shown = points[(points.state == "ok") & points.error.notna() & points.frame_ms.notna()]
    curves = shown[~shown.technique.isin(BASELINES)]
    positive = curves.error[curves.error > 0]
    shifts = points.half_pixel_sensitivity[points.half_pixel_sensitivity > 0]
    sensitivity = shifts.median() if len(shifts) else None
    zeroAt = sensitivity or (positive.min() / 2 if len(positive) else 1e-6)
    height = curves.error.where(curves.error > 0, zeroAt)

    markers, labels = [], []
    front = paretoFront(curves)
    for technique, own in curves.groupby("technique", sort=False):
        colour, marker = styles[technique]
        varied = varyingAxes(own, allAxes)
        others = varied[1:]
        for _, line in own.groupby(others, sort=False) if others else [("", own)]:
            line = line.loc[sorted(line.index, key=lambda i: naturalOrder(line.loc[i, varied[0]]) if varied else 0)]
            y = height[line.index]
            axes.plot(line.frame_ms, y, color=colour, linewidth=1.3, alpha=0.8, zorder=3)
            axes.errorbar(line.frame_ms, y, xerr=intervals(line), fmt="none", ecolor=colour, elinewidth=1, capsize=2,
                          zorder=3)
            for index, row in line.iterrows():
                zero, flagged = row.error == 0, row["flags"] != ""
                axes.plot(row.frame_ms, y[index], marker=11 if zero else marker, color=colour, markersize=7 if zero else 5,
                          markerfacecolor="white" if flagged else colour, zorder=4, clip_on=False)
                markers.append((row.frame_ms, y[index]))
                if row.varies and (len(curves) <= MAX_LABELS or index in front):
                    labels.append((row.frame_ms, y[index], row.varies, colour))
    if front:
        x, y = curves.frame_ms[front], height[front]
        # The front itself is that of the medians; its band is as wide as the intervals of their times.
        corners = numpy.repeat(y.to_numpy(), 2)[:-1] if len(front) > 1 else y.to_numpy()
        edge = lambda times: numpy.repeat(times.to_numpy(), 2)[1:] if len(front) > 1 else times.to_numpy()
        axes.fill_betweenx(corners, edge(curves.frame_lo[front].fillna(x)), edge(curves.frame_hi[front].fillna(x)), color="#dddddd", linewidth=0, zorder=0.9)
        axes.step(x, y, where="post", color="#bbbbbb", linewidth=3, zorder=1, solid_joinstyle="round")
        axes.plot(x, y, linestyle="none", marker="o", markersize=11, markerfacecolor="none", markeredgecolor="#444444",
                  markeredgewidth=1, zorder=5, clip_on=False)

    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.margins(0.12, 0.12)
    if sensitivity:
        axes.axhline(sensitivity, color=MUTED, linestyle=(0, (4, 3)), linewidth=1, zorder=2)
    for number, (baseline, style) in enumerate(zip(BASELINES, ("-", ":"))):
        for row in points[(points.technique == baseline) & points.frame_ms.notna()].head(1).itertuples():
            axes.axvline(row.frame_ms, color="#444444", linestyle=style, linewidth=1, zorder=2)
            if row.frame_lo == row.frame_lo and row.frame_hi == row.frame_hi:  # not NaN
                axes.axvspan(row.frame_lo, row.frame_hi, color="#444444", alpha=0.12, linewidth=0, zorder=0.8)
            axes.annotate(f"{baseline} {row.frame_ms:.3g} ms", (row.frame_ms, 0), (-3, 2), textcoords="offset points",
                          xycoords=("data", "axes fraction"), rotation=90, ha="right", va="bottom", fontsize=plainSize(7),
                          color="#444444")
    plainTicks(axes.xaxis, lambda value: f"{value:g}")
    plainTicks(axes.yaxis, lambda value: f"{value * 100:g} %")
    axes.grid(True, which="major", color="#e6e6e6", linewidth=0.6, zorder=0)
    axes.set_axisbelow(True)
    drawLabels(axes, labels, markers)


def marksOf(points):
    """The kinds of marks beside the techniques' own that a figure of these points has."""
    drawn = points[(points.state == "ok") & points.error.notna() & points.frame_ms.notna() & ~points.technique.isin(BASELINES)]
    marks = {"front": len(drawn), "sensitivity": (points.half_pixel_sensitivity > 0).any(), "zero": (drawn.error == 0).any(),
             "flagged": (drawn["flags"] != "").any()}
    return {name for name, has in marks.items() if has}


def legendEntries(styles, used):
    entries = [Line2D([], [], color=colour, marker=marker, markersize=5, label=name)
               for name, (colour, marker) in styles.items()]
    extra = {
        "front": Line2D([], [], color="#bbbbbb", linewidth=4, marker="o", markersize=10, markerfacecolor="white",
                        markeredgecolor="#444444", label="Pareto front (95 %)"),
        "sensitivity": Line2D([], [], color=MUTED, linestyle=(0, (4, 3)), linewidth=1, label="half-pixel sensitivity"),
        "zero": Line2D([], [], color=MUTED, linestyle="none", marker=11, markersize=7, label="error 0 (see note)"),
        "flagged": Line2D([], [], color=MUTED, linestyle="none", marker="o", markerfacecolor="white", markersize=5,
                          label="flagged (see table)"),
    }
    return entries + [entry for kind, entry in extra.items() if kind in used]


def describeLost(points):
    """Sentences that name what is not drawn."""
    sentences = []
    name = lambda row: " ".join(filter(None, [row.technique, row.varies])) + (f" ({row.view})" if row.view else "")
    for state, words in (("failed", "Failed"), ("missing", "Not measured")):
        rows = list(points[points.state == state].itertuples())
        if rows:
            sentences.append(f"{words}: " + "; ".join(name(r) + (f": {r.why}" if state == "failed" and r.why else "")
                                                       for r in rows) + ".")
    pruned = points[points.state == "pruned"]
    for reason, rows in pruned.groupby("why", sort=False):
        sentences.append(f"Left out ({reason}): " + "; ".join(name(r) for r in rows.itertuples()) + ".")
    blank = points[(points.state == "ok") & points.error.isna() & ~points.technique.isin(BASELINES)]
    if len(blank):
        sentences.append("Without a measured error: " + "; ".join(name(r) for r in blank.itertuples()) + ".")
    return sentences


def drawGroup(run, points, stem):
    """One figure for a scene at one size, with a panel per view."""
    views = list(dict.fromkeys(points["view"]))
    techniques = [t for t in dict.fromkeys(run.points.technique) if t not in BASELINES]
    styles = {t: (COLOURS[i % len(COLOURS)], MARKERS[i % len(MARKERS)]) for i, t in enumerate(techniques)}
    notes = describeLost(points)
    if ((points.error == 0) & (points.state == "ok") & ~points.technique.isin(BASELINES)).any():
        notes.insert(0, "A logarithmic axis has no 0: ▼ points without a single wrong pixel stand on the half-pixel sensitivity "
                        "(or, without one, at half the least error).")
    present = {t: s for t, s in styles.items() if t in set(points.technique[points.state == "ok"])}
    columns = min(len(views), 2) if not PAGE.width or PAGE.width > 5 else 1
    texts = Texts(f"Error against frame time: {points.group.iloc[0]}", run.machine, notes)
    figure, panels = layout(PANEL_SIZE, columns, texts, legendEntries(present, marksOf(points)), [1.0] * -(-len(views) // columns))
    for axes, view in zip(panels.flat, views):
        drawPanel(axes, points[points["view"] == view], run.axes, styles)
        axes.set_title(f"view {view}" if view else "", fontsize=plainSize(9), loc="left")
        axes.set_xlabel("median frame time, ms (bars: 95 % interval)", fontsize=plainSize(9))
        axes.set_ylabel("error: share of wrong pixels, %", fontsize=plainSize(9))
        axes.tick_params(labelsize=plainSize(9))
    for axes in list(panels.flat)[len(views):]:
        axes.remove()
    return save(figure, stem)
