"""Files that say one thing in several ways have one picture: each one's visibility image equals its control's."""
import base64
import json
import shutil
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

    def test_the_one_of_two_that_faces_inwards_is_turned(self):
        """The control has the second box's triangles turned in the file."""
        file = FIXTURES / "inside-out" / "one_of_two.gltf"
        gltf = json.loads(file.read_text())
        head, data = gltf["buffers"][0]["uri"].split(",")
        data = bytearray(base64.b64decode(data))
        first = gltf["bufferViews"][3]["byteOffset"] + 36 * 4
        for at in range(first, first + 36 * 4, 12):
            data[at + 4:at + 8], data[at + 8:at + 12] = data[at + 8:at + 12], data[at + 4:at + 8]
        gltf["buffers"][0]["uri"] = head + "," + base64.b64encode(data).decode()
        with tempfile.TemporaryDirectory() as folder:
            control = Path(folder) / "one_of_two.gltf"
            control.write_text(json.dumps(gltf))
            shutil.copy(file.with_suffix(".toml"), folder)
            for what in ["visibility", "error"]:
                self.assertEqual(self.picture(file, what), self.picture(control, what), what)

    def test_the_controls_differ(self):
        names = ["control", "nothing", "s2_control"]
        pictures = {self.picture(FIXTURES / "mtl-opacity" / f"{name}.obj", "visibility") for name in names}
        self.assertEqual(len(pictures), 3)


if __name__ == "__main__":
    unittest.main()
