"""Reads the files of a run (plan.csv, metrics.csv, run.json) into one table with a row per point."""
import hashlib
import json
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy
import pandas

SCHEMA_MAJOR = "2"
BASELINES = ("unshadowed", "bare")  # frames without shadows: the yardsticks of the others
# Columns of plan.csv that are not axes of a technique.
PLAN_COLUMNS = ("point_id", "shard", "status", "reason", "scene", "technique")
PLACE_COLUMNS = ("view", "width", "height", "stress", "variant")
METRIC_COLUMNS = ("schema", "point_id", "pass", "metric", "unit", "median", "ci_lo", "ci_hi", "backend", "status", "flags")
# Whole-frame figures that the report shows; one that a run does not have stays empty.
FIGURES = ("error", "half_pixel_sensitivity", "false_shadow", "false_light", "edge_p95", "texture_bytes",
           "to_unshadowed", "to_bare")


class ReportError(Exception):
    """One line for a person, and the exit code: 2 for usage, 4 for damaged data."""

    def __init__(self, code, line):
        super().__init__(line)
        self.code = code


@dataclass
class Run:
    points: pandas.DataFrame  # see readRun
    axes: list                # names of the techniques' axes, in the plan's order
    machine: str              # what rendered and which clock, for subtitles
    stability: bool           # the plan stresses its scenes
    plot: dict                # x, y and columns of the figure that the sweep asks for; empty: error against frame time
    motion: dict              # what moves from frame to frame; empty: nothing
    units: dict               # of metrics
    leftOut: list             # (pass, reason, techniques) of the passes that the scenes did not need


def readTable(path, required):
    if not path.is_file():
        raise ReportError(2, f"{path} is missing: {path.parent} is not the folder of a run")
    try:
        table = pandas.read_csv(path, dtype=str, keep_default_na=False, encoding="utf-8")
    except (pandas.errors.ParserError, pandas.errors.EmptyDataError, UnicodeDecodeError) as error:
        raise ReportError(4, f"{path} is damaged: {str(error).strip().splitlines()[-1]}")
    lost = [name for name in required if name not in table]
    if lost:
        raise ReportError(4, f"{path} is damaged: it has no column {', '.join(lost)}")
    return table.fillna("")  # a line cut short leaves holes


def verifyManifest(folder):
    """The files are what the run wrote, or exit code 4. A warning where nothing tells."""
    path = folder / "manifest.json"
    if not path.is_file():
        return f"dapple: {folder} has no manifest.json: its files are read unchecked"
    try:
        files = {name: entry["sha256"] for name, entry in json.loads(path.read_text(encoding="utf-8"))["files"].items()}
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise ReportError(4, f"{path} is damaged: {error!r}")
    for name in ("plan.csv", "metrics.csv", "samples.csv", "run.json"):
        file = folder / name
        if not file.is_file():
            raise ReportError(4, f"{file} is missing; run the sweep again")
        if hashlib.sha256(file.read_bytes()).hexdigest() != files.get(name):
            raise ReportError(4, f"{file} is not what the run wrote: its SHA-256 differs from that in {path.name}; run the sweep again")
    return ""


def requireSchema(path, schema):
    if str(schema).split(".")[0] != SCHEMA_MAJOR:
        raise ReportError(4, f"{path} has schema '{schema}', but this report reads schema {SCHEMA_MAJOR}.x")


def findText(tree, *keys):
    """First non-empty text under one of the keys, at any depth."""
    if isinstance(tree, dict):
        for key in keys:
            if isinstance(tree.get(key), str) and tree[key]:
                return tree[key]
    children = tree.values() if isinstance(tree, dict) else tree if isinstance(tree, list) else []
    return next((found for found in (findText(child, *keys) for child in children) if found), "")


def describeMachine(info, backends):
    renderer = findText(info, "renderer", "gl_renderer") or "renderer unknown"
    if any(name in renderer.lower() for name in ("llvmpipe", "softpipe", "swrast")):
        renderer = f"software rasteriser: {renderer}"
    if backends == ["fake"]:
        renderer = "made-up times"
    return f"{renderer} · timer {', '.join(backends) or 'none'}"


def section(path, info, name):
    """The object that run.json holds under `name`, {} if none."""
    found = info.get(name, {})
    if not isinstance(found, dict):
        raise ReportError(4, f"{path} is damaged: {name} is not an object")
    return found


def readPlot(path, info, axes):
    """The figure that the sweep asks for, {} for the usual one."""
    plot = section(path, info, "plot")
    if not plot:
        return {}
    plot = {"columns": "", "y": "error", **plot}
    if any(not isinstance(value, str) for value in plot.values()):
        raise ReportError(4, f"{path} is damaged: plot holds what is no text")
    for key in ("x", "columns"):
        if plot.get(key) not in ([""] if key == "columns" else []) + ["variant"] + axes:
            raise ReportError(4, f"{path} is damaged: plot {key} '{plot.get(key, '')}' is no axis of this run")
    return plot


def numbers(path, table, column):
    text = table[column]
    values = pandas.to_numeric(text.where(text != ""), errors="coerce")
    broken = (values.isna() | ~numpy.isfinite(values.fillna(0))) & (text != "")
    if broken.any():
        row = broken.idxmax()
        raise ReportError(4, f"{path}, line {row + 2}: '{text[row]}' in column {column} is not a number")
    return values


def naturalOrder(value):
    try:
        return (0, float(value), "")
    except ValueError:
        return (1, 0.0, value)


def pointState(plan, rows):
    """(state, reason) of a planned point from its rows; state: ok, pruned, failed or missing."""
    if plan.status == "pruned":
        return "pruned", plan.reason
    failed = rows[rows.status == "failed"]
    if plan.status == "failed" or len(failed):
        return "failed", plan.reason or "; ".join(sorted(set(failed["flags"]) - {""}))
    frames = rows[rows["pass"] == ""]
    invalid = frames[(frames.status == "invalid") & frames.metric.isin(["frame_time", "error"])]
    if len(invalid):
        return "failed", "; ".join(f"invalid {row['metric']} ({row['flags']})" for _, row in invalid.iterrows())
    if "frame_time" not in set(frames.metric):
        return "missing", "not measured yet"
    return "ok", ""


def readRun(folder):
    """Columns of `points`: those of the plan; state, why; frame_ms with frame_lo, frame_hi (the metric frame_time);
    FIGURES and the plot's y; flags; fallback; place (scene and size); group (what the points of one plot share: place and variant); varies (the settings by which a technique's
    points differ)."""
    folder = Path(folder)
    if not folder.is_dir():
        raise ReportError(2, f"{folder} is not a folder; name the folder of a run")
    unchecked = verifyManifest(folder)
    planPath, metricsPath, infoPath = (folder / name for name in ("plan.csv", "metrics.csv", "run.json"))
    plan = readTable(planPath, PLAN_COLUMNS)
    metrics = readTable(metricsPath, METRIC_COLUMNS)
    if not infoPath.is_file():
        raise ReportError(2, f"{infoPath} is missing: {folder} is not the folder of a run")
    try:
        info = json.loads(infoPath.read_text(encoding="utf-8"))
        requireSchema(infoPath, info["schema"])
    except (ValueError, KeyError, TypeError) as error:
        raise ReportError(4, f"{infoPath} is damaged: {error!r}")
    for schema in metrics.schema.unique():
        requireSchema(metricsPath, schema)
    if not len(plan):
        raise ReportError(4, f"{planPath} has no points")
    if plan.point_id.duplicated().any():
        raise ReportError(4, f"{planPath} has point {plan.point_id[plan.point_id.duplicated()].iloc[0]} twice")
    strangers = sorted(set(metrics.point_id) - set(plan.point_id))
    if strangers:
        raise ReportError(4, f"{metricsPath} has point {strangers[0]}, which is not in {planPath}")
    for column in ("median", "ci_lo", "ci_hi"):
        metrics[column] = numbers(metricsPath, metrics, column)
    frames = metrics[metrics["pass"] == ""]
    twice = frames.duplicated(["point_id", "metric"])
    if twice.any():
        row = frames[twice].iloc[0]
        raise ReportError(4, f"{metricsPath} has {row.metric} of point {row.point_id} twice")

    for column in PLACE_COLUMNS:
        if column not in plan:
            plan[column] = ""
    axes = [name for name in plan if name not in PLAN_COLUMNS + PLACE_COLUMNS]
    byPoint = dict(list(metrics.groupby("point_id")))
    states = [pointState(row, byPoint.get(row.point_id, metrics.iloc[:0])) for row in plan.itertuples()]
    points = plan.assign(state=[s for s, _ in states], why=[w for _, w in states])

    times = frames[frames.metric == "frame_time"].set_index("point_id")
    for column, source in (("frame_ms", "median"), ("frame_lo", "ci_lo"), ("frame_hi", "ci_hi")):
        points[column] = points.point_id.map(times[source])
    points["flags"] = points.point_id.map(times["flags"]).fillna("")
    plot = readPlot(infoPath, info, axes)
    for figure in dict.fromkeys([*FIGURES, *([plot["y"]] if plot else [])]):
        points[figure] = points.point_id.map(frames[frames.metric == figure].set_index("point_id")["median"])
    points["fallback"] = points.point_id.map(frames[frames.metric == "fallback"].set_index("point_id")["flags"]).fillna("")
    size = [f"{p.width}×{p.height}" if p.width else "" for p in points.itertuples()]
    points["place"] = [" · ".join(filter(None, [p.scene, s])) for p, s in zip(points.itertuples(), size)]
    points["group"] = [" · ".join(filter(None, [p.scene, p.variant, s])) for p, s in zip(points.itertuples(), size)]
    points["varies"] = describeSettings(points, axes)
    dropped = metrics[metrics.metric == "left_out"].merge(plan[["point_id", "technique"]], on="point_id", suffixes=("_", ""))
    leftOut = [(*key, list(dict.fromkeys(rows.technique))) for key, rows in dropped.groupby(["pass", "flags"], sort=False)]
    if unchecked:
        print(unchecked, file=sys.stderr)
    return Run(points, axes, describeMachine(info, sorted(set(times["backend"]) - {""})),
               bool((plan.stress != "").any()), plot, section(infoPath, info, "motion"), dict(zip(metrics.metric, metrics.unit)), leftOut)


def varyingAxes(points, axes):
    """The axes by which these points of one technique differ; size first, for it is what work is bought with."""
    names = [axis for axis in axes if points[axis].nunique() > 1]
    return sorted(names, key=lambda axis: axis != "size")


def describeSettings(points, axes):
    """Per point, the values of the axes that vary within its technique and plot: "2048 pcf3"."""
    text = pandas.Series("", index=points.index)
    for _, group in points.groupby(["group", "technique"], sort=False):
        names = varyingAxes(group[group.state != "pruned"], axes)
        for index, row in group.iterrows():
            shown = names if row.state != "pruned" else varyingAxes(group, axes)
            text[index] = " ".join(row[name] for name in shown if row[name])
    return text


def paretoFront(points):
    """Indices of the points that no other beats in both frame time and error, fastest first."""
    front, best = [], float("inf")
    usable = points[points.frame_ms.notna() & points.error.notna()]
    for index, row in usable.sort_values(["frame_ms", "error", "point_id"]).iterrows():
        if row.error < best:
            front.append(index)
            best = row.error
    return front
