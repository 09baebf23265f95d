"""Figures for print, and runs that a report may not choke on."""
import json
import os
import re
import resource
import subprocess
import sys
import tempfile
import unittest
import zlib
from pathlib import Path

from fake_run import PLOT, FakeRun, plot, textsOf

sys.argv[1:] = sys.argv[2:]  # the program is not needed


def small(**options):
    run = FakeRun()
    run.add("unshadowed", 25.0, 0.2, **options)
    for size, ms, error in (("512", 31.0, 0.08), ("1024", 36.0, 0.03), ("2048", 34.0, 0.09)):
        run.add("uniform", ms, error, size=size, **options)
    run.add("instanced", 29.0, 0.06, size="512", **options)
    return run


def pdfFonts(path):
    """Kinds of the fonts that a PDF embeds: its objects, with what is deflated inflated."""
    data = path.read_bytes()
    streams = []
    for found in re.finditer(rb"stream\r?\n(.*?)endstream", data, re.S):
        try:
            streams.append(zlib.decompress(found[1]))
        except zlib.error:
            pass
    return set(re.findall(rb"/Subtype\s*/(Type\d|CIDFontType\d|TrueType)", data + b"".join(streams)))


def mediaWidth(path):
    return float(re.search(rb"/MediaBox\s*\[\s*\S+\s+\S+\s+(\S+)", path.read_bytes())[1]) / 72


class Print(unittest.TestCase):
    def setUp(self):
        keep = tempfile.TemporaryDirectory()
        self.addCleanup(keep.cleanup)
        self.folder = Path(keep.name)

    def drawn(self, run, *words, request=None, name="run"):
        folder = run.write(self.folder / name, request)
        done = plot(folder, *words)
        self.assertEqual(done.returncode, 0, done.stderr)
        return folder

    def test_fonts_are_truetype_and_svg_text_is_text(self):
        folder = self.drawn(small())
        fonts = pdfFonts(folder / "work_precision_forest-small_1024x768.pdf")
        self.assertNotIn(b"Type3", fonts)
        self.assertTrue(fonts & {b"CIDFontType2", b"TrueType"}, fonts)
        self.assertIn("median frame time, ms (bars: 95 % interval)", textsOf(folder / "work_precision_forest-small_1024x768.svg"))

    def test_width_is_that_of_the_page_and_text_keeps_its_size(self):
        curves = FakeRun()
        for rotations in ("6", "12", "24"):
            curves.add("instanced", 20.0, 0.1 / int(rotations), rotations=rotations, mode="nearest")
            curves.add("instanced", 22.0, 0.08 / int(rotations), rotations=rotations, mode="depth")
        runs = (("a", small(), None), ("b", small(stress="far-origin"), None),
                ("c", curves, {"x": "rotations", "y": "error", "columns": "mode"}), ("d", small(), {"x": "size", "y": "frame_time"}))
        for width, chosen in (("3.33", runs), ("7in", runs[:1])):
            for name, run, request in chosen:
                folder = self.drawn(run, "--width", width, "--no-title", request=request, name=f"{name}{width}")
                for pdf in folder.glob("*.pdf"):
                    self.assertAlmostEqual(mediaWidth(pdf), float(width.removesuffix("in")), 2, pdf.name)
                    svg = pdf.with_suffix(".svg").read_text()
                    sizes = {float(size) for size in re.findall(r"font(?:-size)?: (?:[a-z0-9]+ )?([\d.]+)px", svg)}
                    self.assertGreaterEqual(min(sizes), 6, pdf.name)
                    self.assertFalse([text for text in textsOf(pdf.with_suffix(".svg")) if text.startswith("Error against")])
        self.assertEqual(plot(self.folder / "a7in", "--width", "700").returncode, 2)

    def test_every_time_has_its_interval(self):
        band = lambda folder, stem: (folder / f"{stem}_forest-small_1024x768.svg").read_text().count("PolyCollection")
        folder = self.drawn(small(), name="front")
        self.assertGreaterEqual(band(folder, "work_precision"), 1)  # the front
        self.assertIn("Pareto front (95 %)", textsOf(folder / "work_precision_forest-small_1024x768.svg"))
        folder = self.drawn(small(), request={"x": "size", "y": "frame_time"}, name="times")
        self.assertGreaterEqual((folder / "frame_time_by_size_forest-small_1024x768.svg").read_text().count("LineCollection"), 1)

    def test_names_are_no_formulas(self):
        for view in ("$x^{6$", "100 % & <b>\t日本", "x" * 300):
            with self.subTest(view):
                self.setUp()
                self.drawn(small(view=view, scene=f"scene {view}"[:60]))

    def test_what_a_run_may_hold_damaged_is_one_line_and_code_4(self):
        damages = {"plot": ["[]", '{"x": 3}', '{"x": "size", "y": {}}', '"size"'], "motion": ["[1]", '{"frames": 1e999}', '{"frames": "x"}', "7"],
                   "gl": ["null", "[[[]]]", '{"renderer": {}}']}
        for key, values in damages.items():
            for value in values:
                with self.subTest(f"{key}: {value}"):
                    self.setUp()
                    folder = small().write(self.folder / "run")
                    info = json.loads((folder / "run.json").read_text())
                    info.pop(key, None)
                    (folder / "run.json").write_text(json.dumps(info)[:-1] + f', "{key}": {value}}}')
                    self.oneLine(plot(folder), (0, 4) if key == "gl" else (4,))

    def test_infinite_numbers_are_damage(self):
        for value in ("inf", "-inf", "nan", "1e999"):
            folder = small().write(self.folder / f"run{value}")
            text = (folder / "metrics.csv").read_text()
            (folder / "metrics.csv").write_text(text.replace(",31.0,", f",{value},"))
            self.oneLine(plot(folder), (4,))

    def test_a_full_disk_is_code_2_and_leaves_nothing_half_written(self):
        folder = small().write(self.folder / "run")
        limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (12000, 12000))  # stands in for the end of the disk
        done = subprocess.run(["/usr/bin/python3", "-c", "import signal, sys, runpy; signal.signal(signal.SIGXFSZ, signal.SIG_IGN); "
                               f"sys.argv = ['plot', {str(folder)!r}]; sys.path.insert(0, {str(PLOT.parent)!r}); runpy.run_path({str(PLOT)!r}, run_name='__main__')"],
                              capture_output=True, text=True, preexec_fn=limit, env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"})
        self.oneLine(done, (2,))
        self.assertIn("cannot write", done.stderr)
        self.assertNotIn("None", done.stderr)
        self.assertFalse(list(folder.glob("*.tmp")))

    def oneLine(self, done, codes):
        lines = [line for line in done.stderr.splitlines() if "no manifest.json" not in line]
        self.assertIn(done.returncode, codes, done.stderr)
        self.assertLessEqual(len(lines), 1, done.stderr)
        self.assertNotIn("Traceback", done.stderr)


if __name__ == "__main__":
    unittest.main()
