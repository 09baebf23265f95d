#!/usr/bin/python3
"""plot.py DIR [--width INCHES] [--no-title]: draws the figures of a run and writes its table, into its folder.

Work-precision diagrams (work_precision_<scene>_<size>.svg, .png, .pdf), for a stability run the heat map
(stability.*), for a sweep with a [plot] its metric along x (<metric>_by_<x>_<scene>_<size>.*), for one with a [motion] frame times along its
path (path_times_<scene>_<size>.*), and table.csv, table.md. Prints the paths that it wrote. The same input gives the same bytes.
Exit codes: 2 not the folder of a run, 4 damaged or of another schema."""
import argparse
import logging
import sys
import warnings
from pathlib import Path

warnings.simplefilter("ignore")  # what a person must know is in the report
logging.disable(logging.WARNING)

try:
    import matplotlib  # noqa: F401
    import pandas  # noqa: F401
except ImportError as error:
    sys.exit(print(f"plot needs {error.name}: install python3-matplotlib and python3-pandas", file=sys.stderr) or 2)

from curves import drawCurves  # noqa: E402
from figure import PAGE  # noqa: E402
from file_name import fileName  # noqa: E402
from heat_map import drawHeatMap  # noqa: E402
from path_times import drawPathTimes  # noqa: E402
from results import ReportError, readRun  # noqa: E402
from table import buildTable, markdown  # noqa: E402
from work_precision import drawGroup  # noqa: E402


def writeText(path, text):
    temporary = path.with_name(path.name + ".tmp")
    try:
        temporary.write_text(text, encoding="utf-8")
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
    return path


def stemOf(*names):
    return "_".join(fileName(name) for name in names if name)


def size(point):
    return f"{point.width}x{point.height}" if point.width else ""


def report(folder):
    run = readRun(folder)
    table = buildTable(run)
    paths = [writeText(folder / "table.csv", table.to_csv(index=False, lineterminator="\n")),
             writeText(folder / "table.md", markdown(run, table))]
    for _, points in run.points.groupby("place", sort=False) if run.motion or run.plot else []:
        first = points.iloc[0]
        place = stemOf(first.scene, size(first))
        if run.motion:
            paths += drawPathTimes(run, points, folder, folder / f"path_times_{place}")
        if run.plot:
            paths += drawCurves(run, points, folder / f"{stemOf(run.plot['y'])}_by_{stemOf(run.plot['x'])}_{place}")
    if run.plot:
        return paths
    if run.stability:
        return paths + drawHeatMap(run, folder / "stability")
    for _, points in run.points.groupby("group", sort=False):
        first = points.iloc[0]
        paths += drawGroup(run, points, folder / f"work_precision_{stemOf(first.scene, first.variant, size(first))}")
    return paths


def inches(text):
    value = float(text.removesuffix("in"))
    if not 2 <= value <= 40:
        raise ValueError
    return value


def main(words):
    parser = argparse.ArgumentParser(prog="plot", description="Draws the figures of a run into its folder.")
    parser.add_argument("DIR", type=Path)
    parser.add_argument("--width", type=inches, default=0, metavar="INCHES")
    parser.add_argument("--no-title", action="store_true")
    options = parser.parse_args(words)
    PAGE.width, PAGE.title = options.width, not options.no_title
    try:
        print(*report(options.DIR), sep="\n")
    except ReportError as error:
        print(error, file=sys.stderr)
        return error.code
    except OSError as error:
        print(f"cannot write {error.filename or options.DIR}: {error.strerror or error}", file=sys.stderr)
        return 2
    except Exception as error:  # a run that no check above refused
        print(f"{options.DIR} cannot be drawn: {type(error).__name__}: {' '.join(str(error).split())}", file=sys.stderr)
        return 4
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
