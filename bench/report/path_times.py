"""Frame times along the path of a sweep's [motion]: a line per point through the medians of each of its frames, in a band from the fastest to
the slowest, so that spikes show where they are and whether they come back."""
import numpy
from matplotlib.lines import Line2D

from figure import COLOURS, Texts, layout, plainSize, save
from results import ReportError, numbers, readTable
from work_precision import describeLost, plainTicks

PANEL_SIZE = (6.4, 3.0)  # inches
DASHES = ["-", (0, (5, 1.5)), (0, (1.5, 1.5))]


def readTimes(path, frames):
    """Rows of whole frames in samples.csv with their frame of the path: timed frames walk it to and fro, each point from its beginning."""
    samples = readTable(path, ("point_id", "block", "frame", "pass", "value"))
    for column in ("block", "frame", "value"):
        samples[column] = numbers(path, samples, column)
    ofBlock = samples.groupby("point_id")["frame"].transform("max") + 1
    last = frames - 1
    n = (samples.block * ofBlock + samples.frame) % (2 * last)
    samples["at"] = n.where(n <= last, 2 * last - n)
    return samples[(samples["pass"] == "") & samples.value.notna()]


def drawPathTimes(run, points, folder, stem):
    """One figure for a scene at one size. Returns the paths, none where nothing was measured."""
    measured = points[points.state == "ok"]
    if not len(measured):
        return []
    frames = run.motion.get("frames")
    if not isinstance(frames, int) or frames < 2:
        raise ReportError(4, f"{folder / 'run.json'} is damaged: motion has no number of frames")
    times = readTimes(folder / "samples.csv", frames)
    labels = [" ".join(filter(None, [row.technique, row.varies])) for row in measured.itertuples()]
    lines = list(dict.fromkeys(labels))
    styles = {line: (COLOURS[i % len(COLOURS)], DASHES[i // len(COLOURS) % len(DASHES)]) for i, line in enumerate(lines)}
    keys = [key for key in ("variant", "view") if measured[key].nunique() > 1]
    rows = list(dict.fromkeys(measured[keys].itertuples(index=False, name=None))) if keys else [()]
    notes = ["Line: median of what was timed at a place of the path; band: fastest to slowest."] + describeLost(points[points.state != "pruned"])
    step = run.motion.get("camera_metres_per_frame", 0)
    title = "Frame time along a walk" if step or run.motion.get("camera_turn_per_frame", 0) else "Frame time under a moving sun"
    handles = [Line2D([], [], color=styles[line][0], linestyle=styles[line][1], label=line) for line in lines]
    figure, panels = layout(PANEL_SIZE, 1, Texts(f"{title}: {points.place.iloc[0]}", run.machine, notes), handles, [1.0] * len(rows),
                            gaps=(0.2, 0.2), sharex=True)
    for axes, key in zip(panels[:, 0], rows):
        here = (measured[keys] == key).all(axis=1) if keys else numpy.full(len(measured), True)
        for (_, row), label, shown in zip(measured.iterrows(), labels, here):
            if not shown:
                continue
            colour, dash = styles[label]
            at = times[times.point_id == row.point_id].groupby("at").value
            place = at.median().index.to_numpy() * (step or 1)
            axes.fill_between(place, at.min(), at.max(), color=colour, alpha=0.16, linewidth=0, zorder=2)
            axes.plot(place, at.median(), color=colour, linestyle=dash, linewidth=1.4, zorder=3)
        axes.set_yscale("log")
        plainTicks(axes.yaxis, lambda number: f"{number:g}")
        axes.grid(True, which="major", color="#e6e6e6", linewidth=0.6, zorder=0)
        axes.set_ylabel("frame, ms")
        axes.set_title(" · ".join(text for text in key if text), fontsize=plainSize(9), loc="left")
    panels[-1][0].set_xlabel("way walked, m" if step else "frame of the path")
    return save(figure, stem)
