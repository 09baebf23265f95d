"""Files that say one thing in several ways have one picture: the visibility image of each equals that of its control."""
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

DAPPLE = Path(sys.argv.pop(1)).resolve()
FIXTURES = Path(__file__).resolve().parents[1] / "fixtures"
# Folder, control, and the files that equal it.
GROUPS = [
    ("mtl-opacity", "control.obj", ["map_d.obj"]),
    ("mtl-opacity", "nothing.obj", ["d0.obj", "Tr1.obj"]),
    ("mtl-opacity", "s2_control.obj", ["s2.obj"]),
    ("mtl-not-found", "control.obj", ["case.obj", "bom.obj", "folder.obj"]),
    ("inside-out", "control.gltf", ["box.gltf", "doublesided.gltf"]),
]


class FilePictures(unittest.TestCase):
    def picture(self, file, what):
        with tempfile.TemporaryDirectory() as folder:
            picture = Path(folder) / "p.png"
            done = subprocess.run([DAPPLE, "render", file, "uniform", "--what", what, "-r", "320x240", "-o", picture],
                                  capture_output=True, text=True, timeout=120)
            self.assertEqual(done.returncode, 0, done.stderr)
            return picture.read_bytes()

    def test_each_equals_its_control(self):
        for folder, control, files in GROUPS:
            # Front walls are there, so that a technique errs as on the control.
            for what in ["visibility", "error"] if folder == "inside-out" else ["visibility"]:
                expected = self.picture(FIXTURES / folder / control, what)
                for name in files:
                    with self.subTest(file=f"{folder}/{name}", what=what):
                        self.assertEqual(self.picture(FIXTURES / folder / name, what), expected)

    def test_the_controls_differ(self):
        pictures = {self.picture(FIXTURES / "mtl-opacity" / f"{name}.obj", "visibility") for name in ["control", "nothing", "s2_control"]}
        self.assertEqual(len(pictures), 3)


if __name__ == "__main__":
    unittest.main()
