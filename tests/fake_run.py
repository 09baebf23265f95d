"""Runs made up for tests of the report."""
import csv
import html
import json
import re
import subprocess
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[1]
PLOT = SOURCE / "bench/report/plot.py"
METRIC_COLUMNS = ("schema,run_id,point_id,scene,technique,view,pass,metric,unit,better,n,median,ci_lo,ci_hi,q1,q3,min,max,"
                  "backend,status,flags").split(",")


def writeCsv(path, columns, rows):
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, columns, restval="")
        writer.writeheader()
        writer.writerows(rows)


def plot(folder, *words, **options):
    """Runs the report; `options` go to subprocess.run()."""
    return subprocess.run(["/usr/bin/python3", PLOT, folder, *words], capture_output=True, text=True, **options)


def textsOf(svg):
    """What an SVG says, in its order: its text is text."""
    return [html.unescape(re.sub("<[^>]*>", "", found)) for found in re.findall(r"<text[^>]*>(.*?)</text>", svg.read_text(), re.S)]


class FakeRun:
    """Builds the three files of a run, point by point."""

    def __init__(self):
        self.plan, self.metrics = [], []

    def add(self, technique, ms=None, error=None, status="planned", reason="", scene="forest-small", view="near", stress="",
            flags="", fallback="", failed="", floor=0.0004, paired=None, leftOut="", invalid=False, variant="", bytesOf=16 * 2**20, **axes):
        point = f"{len(self.plan):016x}"
        self.plan.append({"point_id": point, "shard": "1", "status": status, "reason": reason, "scene": scene,
                          "technique": technique, "view": view, "width": "1024", "height": "768", "stress": stress, "variant": variant, **axes})
        base = {"schema": "2.0", "run_id": "r", "point_id": point, "scene": scene, "technique": technique, "view": view,
                "backend": "cpu_finish", "status": "failed" if failed else "ok", "flags": failed}
        add = lambda metric, value, **more: self.metrics.append({**base, "metric": metric, "median": value, **more})
        if failed:
            add("failed", "")
            return
        if ms is not None:
            add("frame_time", ms, ci_lo=ms * 0.98, ci_hi=ms * 1.04, n="50", unit="ms", flags=flags,
                status="invalid" if invalid else "ok")
            add("pass_time", ms / 3, **{"pass": "gbuffer"})  # a pass's time is no frame time
        if error is not None:
            add("error", error)
            add("false_shadow", error / 4)
            add("false_light", error * 3 / 4)
            add("edge_p95", 1.5)
            add("half_pixel_sensitivity", floor)
            add("texture_bytes", bytesOf)
            add("mean_absolute", error / 2)
        if fallback:
            add("fallback", "", flags=fallback, status="fallback")
        if paired:
            add("to_unshadowed", paired)
        if leftOut:
            add("left_out", "", flags=leftOut, status="left_out", **{"pass": "alpha"})

    def write(self, folder, plot=None):
        folder.mkdir(parents=True)
        axes = [c for c in dict.fromkeys(k for row in self.plan for k in row)
                if c not in ("point_id", "shard", "status", "reason", "scene", "technique")]
        writeCsv(folder / "plan.csv", ["point_id", "shard", "status", "reason", "scene", "technique", *axes], self.plan)
        writeCsv(folder / "metrics.csv", METRIC_COLUMNS, self.metrics)
        info = {"schema": "2.0", "gl": {"renderer": "llvmpipe (LLVM 15.0.6, 256 bits)"}}
        if plot is not None:
            info["plot"] = plot
        (folder / "run.json").write_text(json.dumps(info))
        return folder
