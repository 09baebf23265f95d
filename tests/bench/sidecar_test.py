"""Looks pixels of cascaded pictures up again, from nothing but the .json beside them and the .exr of depth, normals, map and
visibility, and holds the numbers of error and reference against the metrics. Shares no code with Dapple: it reads EXR by itself and
follows the text of "lookup"."""
import csv
import json
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib
from pathlib import Path

import numpy as np

DAPPLE = Path(sys.argv.pop(1)).resolve()
RESOLUTION = "96x72"


def readExr(path):
    """Scan lines of 32-bit floats, uncompressed or ZIP, as (height, width, channels) in the order R, G, B or Y."""
    data = path.read_bytes()
    assert struct.unpack_from("<I", data)[0] == 20000630
    at, header = 8, {}
    while data[at]:
        name, kind = data[at:].split(b"\0", 2)[:2]
        at += len(name) + len(kind) + 2
        size = struct.unpack_from("<i", data, at)[0]
        header[name.decode()] = data[at + 4:at + 4 + size]
        at += 4 + size
    names, rest = [], header["channels"]
    while rest[0]:
        name = rest.split(b"\0", 1)[0]
        assert struct.unpack_from("<i", rest, len(name) + 1)[0] == 2, "not 32-bit floats"
        names.append(name.decode())
        rest = rest[len(name) + 17:]
    x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"])
    width, height, compression = x1 - x0 + 1, y1 - y0 + 1, header["compression"][0]
    rows = {0: 1, 2: 1, 3: 16}[compression]
    image = np.empty((height, width, len(names)), np.float32)
    for offset in struct.unpack_from(f"<{-(-height // rows)}Q", data, at + 1):
        y, size = struct.unpack_from("<ii", data, offset)
        block = data[offset + 8:offset + 8 + size]
        count = min(rows, height - (y - y0))
        if compression and size < count * width * len(names) * 4:
            packed = np.frombuffer(zlib.decompress(block), np.uint8).astype(np.int64)
            packed[1:] -= 128
            packed = (np.cumsum(packed) & 255).astype(np.uint8)
            half = (len(packed) + 1) // 2
            block = np.empty(len(packed), np.uint8)
            block[0::2], block[1::2] = packed[:half], packed[half:]
        image[y - y0:y - y0 + count] = np.frombuffer(bytes(block), "<f4").reshape(count, len(names), width).transpose(0, 2, 1)
    order = [names.index(n) for n in ("R", "G", "B", "Y") if n in names]
    return image[..., order].astype(float)


def pictures(folder, scene, *options, kinds=("visibility", "depth", "normals", "map")):
    found = {}
    for kind in kinds:
        out = folder / f"{kind}.exr"
        done = subprocess.run([DAPPLE, "render", scene, *options, "-r", RESOLUTION, "--what", kind, "-o", out], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        found[kind] = readExr(out)
    return found, json.loads((folder / "visibility.json").read_text())


def lookUp(images, sidecar, matrices, slack):
    """V of every pixel by the sidecar's text, the map's depths taken `slack` (in steps) farther from the sun."""
    camera, settings = sidecar["camera"], sidecar["settings"]
    height, width = images["depth"].shape[:2]
    size, scale, layers = int(settings["size"]), float(settings["bias-scale"]), len(images["map"]) // int(settings["size"])
    right, up, forward = (np.array(camera[k]) for k in ("right", "up", "forward"))
    light = np.array(sidecar["sun"]["light_direction"])
    radius = {"nearest": 0, "pcf2": 0.5, "pcf3": 1.5}[settings["filter"]]
    result = np.ones((height, width))
    for row in range(height):
        for column in range(width):
            d, n = images["depth"][row, column, 0], images["normals"][row, column]
            if d == 0:
                continue
            if n @ light >= 0:
                result[row, column] = 0
                continue
            x, y = 2 * (column + 0.5) / width - 1, 1 - 2 * (row + 0.5) / height
            p = d * (forward + x * camera["tan_half_fov"][0] * right + y * camera["tan_half_fov"][1] * up)
            entry = next((m for m in matrices if m["eye_depth_m"][0] <= d < m["eye_depth_m"][1]), None)
            if not entry or not entry["used"]:
                continue
            facing, texel = max(-n @ light, 1e-4), max(entry["texel_m"])
            slope = (abs(n @ entry["basis_u"]) * entry["texel_m"][0] + abs(n @ entry["basis_v"]) * entry["texel_m"][1]) / facing
            along = 0
            if settings["bias"] == "constant":
                along = scale * texel
            elif settings["bias"] == "slope":
                along = scale * min((radius + 0.5) * slope, 8 * texel)
            else:
                p = p + n * scale * texel * (radius + 0.5) * 2 * (1 + n @ light)
            moved = np.append(p - light * (along + 2 * entry["depth_step_m"]), 1)
            u, v, z, w = np.array(entry["clip_from_relative"]) @ moved
            place, z = np.array([u / w / 2 + 0.5, v / w / 2 + 0.5]) * size, min(z / w, 1)
            layer = images["map"][entry["layer"] * size:(entry["layer"] + 1) * size, :, 0]

            def answer(i, j):
                inside = 0 <= i < size and 0 <= j < size
                return float(not inside or z <= layer[size - 1 - j, i] + slack)

            if settings["filter"] == "nearest":
                first, weights = np.floor(place).astype(int), [[1.0], [1.0]]
            elif settings["filter"] == "pcf2":
                first = np.floor(place - 0.5).astype(int)
                weights = [[1 - s, s] for s in place - 0.5 - first]
            else:
                b = np.floor(place + 0.5).astype(int)
                first, weights = b - 2, [[(1 - s) / 4, (2 - s) / 4, (1 + s) / 4, s / 4] for s in place + 0.5 - b]
            result[row, column] = sum(wu * wv * answer(first[0] + i, first[1] + j)
                                      for i, wu in enumerate(weights[0]) for j, wv in enumerate(weights[1]))
    assert layers >= max(m["layer"] for m in matrices) + 1
    return result


class Sidecar(unittest.TestCase):
    def setUp(self):
        keep = tempfile.TemporaryDirectory()
        self.addCleanup(keep.cleanup)
        self.folder = Path(keep.name)

    def test_with_it_alone_a_cascaded_picture_can_be_checked(self):
        for axes in ([], ["-a", "bias=constant", "-a", "filter=pcf3"], ["-a", "bias=normal-offset", "-a", "filter=pcf2", "-a", "cascades=2"]):
            with self.subTest(axes=axes):
                images, sidecar = pictures(self.folder, "forest-small", "cascaded", "--view", "walk1", "-a", "size=128", *axes)
                v = images["visibility"][..., 0]
                # Where a depth is within rounding of the receiver's, either answer is right.
                near, far = (lookUp(images, sidecar, sidecar["light_matrices"], slack) for slack in (-2e-6, 2e-6))
                clear = np.abs(near - far) < 1e-9
                wrong = clear & (np.abs(v - near) > 2e-3)
                self.assertGreater(clear.mean(), 0.98)
                self.assertLessEqual(wrong.mean(), 2e-4 if not axes else 1e-3)  # a place within rounding of a texel's edge
                self.assertGreater((v < 0.5).mean(), 0.1)
                self.assertGreater(len(sidecar["light_matrices"]), 1)
                # The check is one: with the cascades' distances exchanged it fails.
                first, second = sidecar["light_matrices"][:2]
                first["eye_depth_m"], second["eye_depth_m"] = second["eye_depth_m"], first["eye_depth_m"]
                self.assertGreater((np.abs(v - lookUp(images, sidecar, sidecar["light_matrices"], 0)) > 2e-3).mean(), 0.01)

    def test_further_suns_are_in_it(self):
        _, sidecar = pictures(self.folder, "forest-two-suns", "cascaded", "-a", "size=64", kinds=("visibility",))
        self.assertEqual([s["elevation_deg"] for s in sidecar["suns"]], [45, 25])
        self.assertEqual(sidecar["suns"][1]["strength"], 0.6)
        for sun in sidecar["suns"]:
            self.assertAlmostEqual(np.linalg.norm(sun["light_direction"]), 1)
            self.assertTrue(sun["light_matrices"])
        self.assertNotEqual(sidecar["suns"][0]["light_matrices"], sidecar["suns"][1]["light_matrices"])
        self.assertEqual(sidecar["light_matrices"], sidecar["suns"][0]["light_matrices"])

    def test_error_and_reference_of_a_translucent_scene_are_what_the_metrics_use(self):
        axes = ["-a", "accumulate=multiply", "-a", "size=256"]
        images, _ = pictures(self.folder, "market", "instanced", *axes, kinds=("visibility", "reference", "error"))
        v, g, error = (images[kind][..., 0] for kind in ("visibility", "reference", "error"))
        texts = {kind: json.loads((self.folder / f"{kind}.json").read_text())["values"] for kind in ("reference", "error")}
        for text in texts.values():
            self.assertIn("-2 ambiguous, -3 excluded", text)
        valid = g >= 0
        self.assertEqual(set(np.unique(g[~valid])) - {-2.0, -3.0}, set())
        np.testing.assert_array_equal(error[~valid], g[~valid])
        np.testing.assert_allclose(error[valid], (v - g)[valid], atol=1e-6)
        # The sails' own transmittances, and their product where two shadows overlap.
        for share in (0.35, 0.55, 0.45, 0.35 * 0.55):
            self.assertGreater((np.abs(g - share) < 1e-6).sum(), 5, share)

        sweep = self.folder / "one.toml"
        sweep.write_text('question = "?"\nscenes = ["market"]\nresolution = [96, 72]\n[sampling]\nmax_warmup_frames = 1\nmin_blocks = 1\nmax_blocks = 1\n'
                         '[[technique]]\nname = "instanced"\nsize = 256\naccumulate = "multiply"\n')
        done = subprocess.run([DAPPLE, "run", sweep, "-o", self.folder / "run"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(self.folder / "run" / "metrics.csv", newline="") as file:
            metric = {row["metric"]: row["median"] for row in csv.DictReader(file) if not row["pass"]}
        self.assertAlmostEqual(np.abs(error[valid]).mean(), float(metric["mean_absolute"]), places=6)
        self.assertAlmostEqual(((v >= 0.5) != (g >= 0.5))[valid].mean(), float(metric["error"]), places=6)
        self.assertAlmostEqual(valid.mean(), float(metric["valid"]), places=6)


if __name__ == "__main__":
    unittest.main()
