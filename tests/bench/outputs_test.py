"""What is written never replaces what was read, nor another output; names do not reach outside the output folder."""
import csv
import json
import os
import struct
import subprocess
import sys
import unittest
from pathlib import Path

from command_line import CommandLine, dapple, hasGl, program

REPORT = Path(__file__).resolve().parents[2] / "bench/report"
sys.path.insert(0, str(REPORT))
from file_name import fileName  # noqa: E402

SQUARE = [[0, 0], [2e-4, 0], [2e-4, 2e-4], [0, 2e-4], [0, 0]]
TOWN = {"type": "FeatureCollection", "features": [
    {"type": "Feature", "properties": {"height": 10}, "geometry": {"type": "Polygon", "coordinates": [SQUARE]}}]}
RECIPE = """description = "made by a test"
[[primitive]]
kind = "box"
position = [0, 0, 1]
size = [1, 1, 2]
[ground]
size = 20
[[view]]
name = "{view}"
eye = [0, {y}, 2]
target = [0, 0, 1]
"""
SWEEP = """question = "?"
scenes = [{scenes}]
resolution = [64, 48]
[sampling]
min_blocks = 1
max_blocks = 1
max_warmup_frames = 1
[[technique]]
name = "uniform"
size = [64]
filter = ["nearest", "pcf3"]
"""


class Inputs(CommandLine):
    def setUp(self):
        super().setUp()
        (self.folder / "town.json").write_text(json.dumps(TOWN))
        (self.folder / "town.toml").write_text('description = "x"\n[city]\nfootprints = "town.json"\n')
        self.before = {path: path.read_bytes() for path in self.folder.iterdir()}

    def unchanged(self):
        self.assertEqual({path: path.read_bytes() for path in self.folder.iterdir()}, self.before)

    def test_a_written_scene_replaces_no_input(self):
        self.done("scene", "town.toml", "-o", "out/in.obj", cwd=self.folder)
        self.done("scene", "town.toml", "-o", "out/in.glb", cwd=self.folder)
        os.symlink("in.obj", self.folder / "out/link.obj")
        out = {path: path.read_bytes() for path in (self.folder / "out").iterdir()}
        for scene, output in (("out/in.obj", "out/in.obj"), ("out/in.obj", "out/../out/in.obj"),
                              ("out/in.obj", "out/link.obj"), ("out/in.glb", "out/in.glb"),
                              (self.folder / "out/in.glb", "out/in.glb")):
            self.refused("scene", scene, "-o", output, says=["is an input", "-o"], cwd=self.folder)
            self.assertEqual({path: path.read_bytes() for path in (self.folder / "out").iterdir()}, out)
        self.done("scene", "out/in.obj", "-o", "out/again.obj", cwd=self.folder)
        self.done("scene", "out/in.obj", "-o", "out/again.obj", cwd=self.folder)

    @unittest.skipUnless(hasGl(), "no GL here")
    def test_what_a_scene_file_brings_along_is_an_input_too(self):
        (self.folder / "in.obj").write_text("mtllib m.glb\nv 0 0 0\nv 1 0 0\nv 0 0 1\nusemtl a\nf 1 2 3\n")
        (self.folder / "m.glb").write_text("newmtl a\nKd 1 0 0\n")
        (self.folder / "b.obj").write_bytes(struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 0, 1))
        (self.folder / "in.gltf").write_text(json.dumps({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "buffers": [{"byteLength": 36, "uri": "b.obj"}],
            "bufferViews": [{"buffer": 0, "byteLength": 36}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 0, 1]}]}))
        self.before = {path: path.read_bytes() for path in self.folder.iterdir()}
        for scene, output in (("in.obj", "m.glb"), ("in.gltf", "b.obj")):
            done = dapple("scene", scene, "-o", output, cwd=self.folder)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn("is an input", done.stderr)
            self.unchanged()

    def test_a_picture_replaces_no_input_and_its_sidecar_no_stranger(self):
        render = lambda *words: ("render", *words, "-r", "64x48")
        options = {"cwd": self.folder, "call": program}
        self.refused(*render("town.toml", "uniform", "-o", "town.png"), says=["town.json", "is an input"], **options)
        self.unchanged()
        (self.folder / "mine.json").write_text('{"mine": 1}')
        self.refused(*render("box", "uniform", "-o", "mine.exr"), says=["mine.json", "not a picture's"], **options)
        self.assertEqual((self.folder / "mine.json").read_text(), '{"mine": 1}')
        for _ in range(2):  # its own is replaced
            self.done(*render("box", "uniform", "-o", "fine.png"), **options)
        self.refused("scene", "fine.toml", "--picture", "fine.toml", says=["fine.toml"], **options)


class Names(CommandLine):
    def test_the_reports_escape_names_as_the_program_does(self):
        # tests/base/file_name_test.cpp expects the same.
        self.assertEqual([fileName(name) for name in ("walk0", "../../../../X", "scale=4; trees=3", "Straße", "")],
                         ["walk0", "X-eb159953", "scale=4-trees=3-cd39eb58", "Stra-e-1dc32e38", "_-811c9dc5"])

    def scenes(self, *names, view="near"):
        for y, name in enumerate(names):
            (self.folder / name).parent.mkdir(exist_ok=True)
            (self.folder / name).write_text(RECIPE.format(view=view, y=-8 - y))
        self.sweep.write_text(SWEEP.format(scenes=", ".join(f'"{name}"' for name in names)))

    def test_plots_of_scenes_named_alike_have_names_of_their_own(self):
        self.scenes("a/town.toml", "b/town.toml", "../" * 30 + str(self.folder)[1:] + "/c/town.toml")
        self.done("run", self.sweep, "-o", "out", cwd=self.folder)
        plots = sorted(path.name for path in (self.folder / "out").glob("*.svg"))
        self.assertEqual(len(plots), 3, plots)
        self.assertTrue(all(name.startswith("work_precision_town.toml-") for name in plots), plots)

    @unittest.skipUnless(hasGl(), "no GL here")
    def test_pictures_stay_in_their_folder_and_each_point_has_its_own(self):
        view = "../../../../X" + self.folder.name
        self.scenes("a/town.toml", "b/town.toml", view=view)
        self.done("run", self.sweep, "-o", "deep/in/here/out", "--backend", "cpu_finish", cwd=self.folder, call=program)
        out = self.folder / "deep/in/here/out"
        with open(out / "plan.csv", newline="") as file:
            ids = {row["point_id"] for row in csv.DictReader(file)}
        self.assertEqual(len(ids), 4)
        names = {path.name for path in (out / "pictures").iterdir()}
        drawn = {name.rsplit("_", 2)[1] for name in names}  # points on the front, at least one a scene
        self.assertLessEqual(drawn, ids)
        self.assertGreaterEqual(len(drawn), 2)
        self.assertEqual(len(names), len(drawn) * 2 * 2)
        self.assertTrue(all("filter=" in name for name in names), names)
        tops = (self.folder, self.folder.parent, self.folder / "deep")
        strangers = [path for top in tops for path in top.glob("X*")]
        self.assertEqual(strangers, [])


if __name__ == "__main__":
    unittest.main()
