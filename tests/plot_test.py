"""The report on runs made up here: what it must draw, compute, refuse, and repeat byte for byte."""
import csv
import io
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib.image

from fake_run import METRIC_COLUMNS, PLOT, SOURCE, FakeRun, textsOf, writeCsv

failures = 0


def check(name, ok, detail=""):
    global failures
    failures += not ok
    print(f"{'ok' if ok else 'FAILED'}: {name}" + ("" if ok else f"\n    {detail}"))


def sweep():
    run = FakeRun()
    run.add("bare", 40.0, 0.2)
    run.add("unshadowed", 25.0, 0.2)
    for size, step in (("512", 0), ("1024", 1), ("2048", 2), ("10000", 3)):
        run.add("uniform", 31 + 4 * step, 0.08 / 2**step, fit="scene", size=size)
        run.add("focused", 32 + 4.1 * step, 0.03 / 2**step, fit="frustum", size=size)
        run.add("lispsm", 33 + 4 * step, 0.012 / 2**step, fit="lispsm", size=size, flags="noisy" if step == 2 else "")
    run.add("focused", 50.0, 0.03, fit="frustum", size="64", paired=1.9, leftOut="no alpha-tested caster")
    run.add("cascaded", 45.0, 0.0021, fit="frustum", size="1024", filter="nearest")
    run.add("cascaded", 55.0, 0.0, fit="frustum", size="2048", filter="nearest")
    run.add("cascaded", failed="oom", fit="frustum", size="4096", filter="nearest")
    run.add("cascaded", status="pruned", reason="size 65536 is beyond this GL's limit of 16384 texels", size="65536",
            filter="nearest")
    run.add("cascaded", 60.0, 0.001, fit="frustum", size="8192", filter="nearest", flags="lost", invalid=True)
    run.add("instanced", 29.0, 0.006, size="512", mode="depth")
    run.add("instanced", 33.0, 0.004, size="1024", mode="depth")
    run.add("instanced", 27.0, 0.011, size="512", mode="nearest")
    run.add("instanced", 30.0, 0.009, size="1024", mode="nearest")
    run.add("uniform", 21.0, 0.05, view="far", size="512")
    run.add("uniform", 23.0, 0.02, view="far", size="1024")
    run.add("uniform", 90.0, 0.05, scene="models/town 1.glb", size="512")
    return run


def stability():
    run = FakeRun()
    cases = ["", "sun-zenith", "sun-1deg", "sun-below", "light-parallel-0", "no-caster", "far-origin"]
    for number, technique in enumerate(["uniform", "focused", "lispsm", "cascaded", "instanced"]):
        for step, case in enumerate(cases):
            if technique == "instanced" and case == "no-caster":
                run.add(technique, status="pruned", reason="no instances", stress=case)
            elif technique == "cascaded" and case == "sun-1deg":
                run.add(technique, stress=case, failed="nonfinite")
            else:
                fallback = "lispsm → focused: light ∥ view" if (technique, case) == ("lispsm", "light-parallel-0") else ""
                run.add(technique, 30.0, 0.0 if case in ("sun-below", "no-caster") else 0.02 / (1 + number) * (1 + step),
                        stress=case, fallback=fallback)
    return run


def plot(folder, seed="0"):
    return subprocess.run(["/usr/bin/python3", PLOT, folder], capture_output=True, text=True,
                          env={**os.environ, "PYTHONHASHSEED": seed, "PYTHONDONTWRITEBYTECODE": "1"})


def testDrawing(top):
    folder = sweep().write(top / "sweep")
    done = plot(folder)
    names = {Path(line).name for line in done.stdout.splitlines()}
    wanted = {f"work_precision_{stem}.{form}" for stem in ("forest-small_1024x768", "town-1.glb-c1e3ca4a_1024x768")
              for form in ("svg", "png", "pdf")} | {"table.csv", "table.md"}
    check("one diagram per scene in three formats, and the tables", done.returncode == 0 and names == wanted,
          (names, done.stderr))
    if done.returncode:
        return
    texts = textsOf(folder / "work_precision_forest-small_1024x768.svg")
    for text in ("uniform", "instanced", "Pareto front", "half-pixel sensitivity", "unshadowed 25 ms", "bare 40 ms", "view far",
                 "software rasteriser: llvmpipe", "Failed: cascaded 4096", "oom", "invalid frame_time (lost)", "beyond this GL", "error 0 (see note)",
                 "flagged (see table)"):
        check(f"the diagram says '{text}'", any(text in shown for shown in texts), texts)
    pixels = matplotlib.image.imread(folder / "work_precision_forest-small_1024x768.png")
    check("the picture is not blank", pixels[..., :3].std() > 0.02, pixels[..., :3].std())

    first = {name: (folder / name).read_bytes() for name in wanted}
    again = sweep().write(top / "again")
    plot(again, seed="1")
    differ = [name for name in wanted if (again / name).read_bytes() != first[name]]
    check("the same run draws the same bytes", not differ, differ)


def testTable(top):
    folder = sweep().write(top / "table")
    plot(folder)
    rows = list(csv.DictReader(io.StringIO((folder / "table.csv").read_text())))
    find = lambda **want: [r for r in rows if all(r[k] == v for k, v in want.items())]
    uniform = find(technique="uniform", size="512", view="near", scene="forest-small")[0]
    check("ratios are to the baselines of the same run",
          float(uniform["to_unshadowed"]) == 31 / 25 and float(uniform["to_bare"]) == 31 / 40, uniform)
    check("the run's own paired ratio goes before the quotient", float(find(size="64")[0]["to_unshadowed"]) == 1.9)
    check("no baseline in that view, no ratio", find(view="far")[0]["to_unshadowed"] == "", find(view="far")[0])
    check("texture memory is in MiB", float(uniform["texture_mib"]) == 16)
    # By brute force: a point is on the front if none is as good in both and better in one.
    compared = [r for r in find(scene="forest-small", view="near", state="ok") if r["technique"] not in ("bare", "unshadowed")]
    value = lambda r: (float(r["frame_ms"]), float(r["error"]))
    beaten = lambda r: any(value(o) != value(r) and value(o)[0] <= value(r)[0] and value(o)[1] <= value(r)[1] for o in compared)
    wrong = [r["point_id"] for r in compared if (r["pareto"] == "yes") == beaten(r)]
    check(f"the Pareto front of {len(compared)} points is the undominated set", compared and not wrong, wrong)
    states = {r["state"]: r["why"] for r in rows if r["size"] != "8192"}
    check("failed and pruned points keep their row and reason",
          states.get("failed") == "oom" and "beyond this GL" in states.get("pruned", ""), states)
    text = (folder / "table.md").read_text()
    widths = {line.count("|") - line.count("\\|") for line in text.splitlines() if line.startswith("|")}
    check("table.md names settings and passes left out",
          "| 512 nearest |" in text and "- `alpha`: no alpha-tested caster (focused)" in text)
    check("every row of table.md has all cells", len(widths) == 1 and "failed: oom" in text, widths)


def testStability(top):
    folder = stability().write(top / "stability")
    done = plot(folder)
    check("a stability run draws the heat map", done.returncode == 0 and (folder / "stability.png").exists(), done.stderr)
    svg = (folder / "stability.svg").read_text() if done.returncode == 0 else ""
    for text in ("sun-1deg", "far-origin", "FAILED", "left out", "fallback", "Failed (nonfinite): cascaded at sun-1deg",
                 "Fallback (lispsm → focused: light ∥ view): lispsm at"):
        check(f"the heat map says '{text}'", text in svg)


def testShadowCost(top):
    """Shadow cost by hand: (46 - 25) / (67 - 25) of the standard map, in each variant of its own."""
    run = FakeRun()
    for variant, standard in (("", 67.0), ("sun.elevation=10", 109.0)):
        run.add("unshadowed", 25.0, 0.2, variant=variant)
        run.add("uniform", 40.0, 0.04, size="1024", variant=variant)
        run.add("uniform", standard, 0.03, size="2048", variant=variant)
        run.add("instanced", 46.0, 0.02, size="512", variant=variant)
    run.add("unshadowed", 25.0, 0.2, view="far")
    run.add("instanced", 46.0, 0.02, view="far", size="512")
    folder = run.write(top / "cost")
    plot(folder)
    rows = list(csv.DictReader(io.StringIO((folder / "table.csv").read_text())))
    cost = [(r["variant"], r["technique"], r["shadow_to_standard"]) for r in rows if r["view"] == "near"]
    wanted = {("", "instanced"): 0.5, ("", "uniform"): 15 / 42, ("sun.elevation=10", "instanced"): 0.25, ("sun.elevation=10", "uniform"): 15 / 84}
    for (variant, technique), value in wanted.items():
        found = [float(c) for v, t, c in cost if (v, t) == (variant, technique)]
        check(f"shadow cost of {technique} {variant}", abs(found[0] - value) < 1e-12, found)
    check("the standard map's own cost is 1", [c for _, t, c in cost if t == "uniform"][1::2] == ["1.0", "1.0"], cost)
    check("a baseline has no shadow cost, nor a view without the standard map",
          {c for _, t, c in cost if t == "unshadowed"} == {""} and {r["shadow_to_standard"] for r in rows if r["view"] == "far"} == {""}, rows)
    check("one diagram for each variant", all((folder / f"work_precision_forest-small{v}_1024x768.svg").exists()
                                              for v in ("", "_sun.elevation=10")), list(folder.iterdir()))


def rotations():
    run = FakeRun()
    for number in (2, 12, 72):
        for mode in ("nearest", "depth"):
            for frame, scale in (("A", 1), ("B", 2)):
                run.add("instanced", 20.0, 0.4 * scale / number, rotations=str(number), mode=mode, bytesOf=number * 2**20, **{"sample-frame": frame})
    run.add("instanced", 20.0, 0.0, rotations="12", mode="exact", **{"sample-frame": "A"})
    return run


def testCurves(top):
    request = {"x": "rotations", "y": "error", "columns": "mode"}
    folder = rotations().write(top / "curves", request)
    done = plot(folder)
    names = {Path(line).name for line in done.stdout.splitlines()}
    wanted = {f"error_by_rotations_forest-small_1024x768.{form}" for form in ("svg", "png", "pdf")} | {"table.csv", "table.md"}
    check("a sweep's own plot stands for the work-precision diagrams", done.returncode == 0 and names == wanted, (names, done.stderr))
    if done.returncode:
        return
    texts = textsOf(folder / "error_by_rotations_forest-small_1024x768.svg")
    for text in ("Error by rotations: forest-small · 1024×768 · near", "mode nearest", "mode depth", "maps, MiB", "rotations, maps", "72", "exact",
                 "error: share of wrong pixels, %"):
        check(f"the curves say '{text}'", text in texts, texts)
    check("one line per sample frame, and one for what does not vary", {"A", "B", "exact"} <= set(texts) and texts.count("A") == 1, texts)
    check("a level is no column of its own, and an error of 0 is explained", "mode exact" not in texts and any("no 0" in t for t in texts), texts)
    again = rotations().write(top / "curves-again", request)
    plot(again, seed="1")
    differ = [name for name in wanted if (again / name).read_bytes() != (folder / name).read_bytes()]
    check("the same run draws the same curves", not differ, differ)

    run = FakeRun()
    for degrees, error in (("80", 0.01), ("10", 0.08), ("45", 0.02)):
        for number in ("6", "12"):
            run.add("instanced", 20.0, error, variant=f"sun.elevation={degrees}", rotations=number)
    folder = run.write(top / "variants", {"x": "variant", "y": "mean_absolute"})
    done = plot(folder)
    svg = folder / "mean_absolute_by_variant_forest-small_1024x768.svg"
    texts = textsOf(svg) if svg.exists() else []
    check("variants of one number make an axis with its name", {"10", "45", "80", "sun.elevation, degrees"} <= set(texts) and len(done.stderr.splitlines()) == 1
          and "has no manifest.json" in done.stderr,
          (texts, done.stderr))
    check("the sweep's metric is the one drawn", "Mean error by sun.elevation: forest-small · 1024×768 · near" in " ".join(texts), texts)
    run = FakeRun()
    for radius in ("640", "1280"):
        run.add("unshadowed", 10.0, 0.3, variant=f"radius={radius}", bytesOf=0)
        run.add("bare", 12.0, None, variant=f"radius={radius}")
        for camera, cull in (("frustum", "frustum"), ("chcpp", "receivers-of-any-kind")):
            run.add("uniform", 20.0, 0.1, variant=f"radius={radius}", camera=camera, cull=cull, bytesOf=2**20)
    folder = run.write(top / "times", {"x": "variant", "y": "frame_time"})
    done = plot(folder)
    svg = folder / "frame_time_by_variant_forest-small_1024x768.svg"
    texts = textsOf(svg) if svg.exists() else []
    check("frame times stand beside the unshadowed frame's and say their unit",
          texts.count("unshadowed") == 1 and {"camera frustum, cull frustum", "median frame time, ms (bars: 95 %)"} <= set(texts) and "bare" not in texts, (texts, done.stderr))
    edge = matplotlib.image.imread(svg.with_suffix(".png"))[:, -4:, :3]
    check("no label is cut off by the figure's edge", (edge == 1).all(), edge.min())
    check("memory that is the same for all that has any is not drawn", "maps, MiB" not in texts, texts)
    run = FakeRun()
    for name in ("oak", "fir"):
        run.add("instanced", 20.0, 0.1, variant=f"species.0.name={name}; species.1.name={name}")
    folder = run.write(top / "crowns", {"x": "variant"})
    plot(folder)
    svg = folder / "error_by_variant_forest-small_1024x768.svg"
    texts = textsOf(svg) if svg.exists() else []
    check("variants of the same keys are named by what they set, in the sweep's order",
          [t for t in texts if t in ("oak", "fir")] == ["oak", "fir"] and "species.0.name, species.1.name" in texts, texts)
    check("memory that does not vary is not drawn", "maps, MiB" not in texts, texts)
    failed = plot(rotations().write(top / "strange", {"x": "size"}))
    check("a plot over what the run does not vary is refused", failed.returncode == 4 and "no axis of this run" in failed.stderr, failed.stderr)


def testRefusals(top):
    def refuse(name, code, words, spoil):
        folder = sweep().write(top / name)
        spoil(folder)
        before = sorted(p.name for p in folder.iterdir()) if folder.is_dir() else []
        done = plot(folder)
        after = sorted(p.name for p in folder.iterdir()) if folder.is_dir() else []
        lines = done.stderr.splitlines()
        check(f"{name}: exit {code}, one line, nothing written",
              done.returncode == code and len(lines) == 1 and words in lines[0] and before == after,
              (done.returncode, done.stderr))

    def edit(file, old, new):
        def spoil(folder):
            text = (folder / file).read_text()
            assert old in text
            (folder / file).write_text(text.replace(old, new))
        return spoil

    refuse("no-folder", 2, "is not a folder", shutil.rmtree)
    for file in ("plan.csv", "metrics.csv", "run.json"):
        refuse(f"no-{file}", 2, f"{file} is missing", lambda folder: (folder / file).unlink())
        refuse(f"empty-{file}", 4, f"{file} is damaged", lambda folder: (folder / file).write_text(""))
    refuse("no-column", 4, "no column technique", edit("plan.csv", ",technique,", ",tecnique,"))
    refuse("binary", 4, "metrics.csv is damaged", lambda folder: (folder / "metrics.csv").write_bytes(b"\xff\xfe\x00\x01" * 9))
    refuse("torn-json", 4, "run.json is damaged", lambda folder: (folder / "run.json").write_text('{"schema": "1'))
    refuse("future-schema", 4, "schema '3.0'", edit("run.json", '"2.0"', '"3.0"'))
    refuse("future-metrics", 4, "schema '3.0'", edit("metrics.csv", "\n2.0,", "\n3.0,"))
    refuse("not-a-number", 4, "'fast'", edit("metrics.csv", ",40.0,", ",fast,"))
    refuse("unknown-point", 4, "which is not in", edit("metrics.csv", f"{0:016x}", "f" * 16))
    refuse("no-points", 4, "has no points", lambda folder: (folder / "plan.csv").write_text(
        (folder / "plan.csv").read_text().splitlines()[0] + "\n"))


def testSchema(top):
    """The columns that the program writes are those that the page for readers explains."""
    page = (SOURCE / "results/SCHEMA.md").read_text()
    source = (SOURCE / "bench/rows.h").read_text()
    for file, constant in (("metrics.csv", "kMetricsColumns"), ("samples.csv", "kSamplesColumns")):
        written = set(re.findall(r'"(\w+)"', re.search(constant + r"\{(.*?)\}", source, re.S)[1]))
        section = page.split(f"## {file}")[1].split("\n\n")[0]  # the heading and its table
        cells = [line.split("|")[1] for line in section.splitlines() if re.match(r"\| [a-z`]", line)]
        explained = set(re.findall(r"\w+", " ".join(cells))) - {"column"}
        check(f"results/SCHEMA.md explains each column of {file}", written and written == explained, written ^ explained)


def testSparse(top):
    """Shuffled columns and a run that measured little: still a report."""
    folder = FakeRun()
    folder.add("uniform", 10.0, None, size="512")
    folder.add("uniform", size="1024")
    folder = folder.write(top / "sparse")
    for name in ("plan.csv", "metrics.csv"):
        rows = list(csv.DictReader((folder / name).open(newline="", encoding="utf-8")))
        writeCsv(folder / name, list(reversed(rows[0])), rows)
    done = plot(folder)
    text = (folder / "table.md").read_text() if done.returncode == 0 else ""
    check("absent metrics and unmeasured points leave blanks", done.returncode == 0 and "not measured" in text, done.stderr)


with tempfile.TemporaryDirectory() as scratch:
    for test in (testDrawing, testTable, testShadowCost, testCurves, testStability, testRefusals, testSchema, testSparse):
        test(Path(scratch))
if os.environ.get("KEEP"):
    for name, run in (("sweep", sweep()), ("stability", stability()), ("rotations", rotations())):
        shutil.rmtree(Path(os.environ["KEEP"]) / name, ignore_errors=True)
        plot(run.write(Path(os.environ["KEEP"]) / name))
sys.exit(failures > 0)
