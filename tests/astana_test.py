"""fetch_astana reads vector tiles: one written here by hand, with a courtyard, a neighbour's building and a street."""
import importlib.machinery
import importlib.util
import io
import json
import math
import os
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

SCRIPT = Path(__file__).resolve().parents[1] / "scenegen/import/fetch_astana"
ZOOM, COLUMN, ROW = 12, 2860, 1367


def varint(n):
    out = b""
    while n > 127:
        out, n = out + bytes([n & 127 | 128]), n >> 7
    return out + bytes([n])


def block(number, data):
    return varint(number << 3 | 2) + varint(len(data)) + data


def geometry(*rings):
    numbers, x, y = [], 0, 0
    zigzag = lambda n: 2 * n if n >= 0 else -2 * n - 1
    for ring in rings:
        for i, (px, py) in enumerate(ring):
            if i < 2:
                numbers.append((1 if i == 0 else 2) | (1 if i == 0 else len(ring) - 1) << 3)
            numbers += [zigzag(px - x), zigzag(py - y)]
            x, y = px, py
        numbers.append(15)
    return b"".join(map(varint, numbers))


def feature(tags, kind, *rings):
    return block(2, block(2, b"".join(map(varint, tags))) + varint(3 << 3) + varint(kind) + block(4, geometry(*rings)))


def square(x, y, size):
    return [(x, y), (x + size, y), (x + size, y + size), (x, y + size)]  # clockwise on the screen: positive, y down


def tile():
    keys = [b"building", b"height", b"highway"]
    values = [b"yes", b"21.5", b"street"]
    layer = block(1, b"osm")
    layer += feature([0, 0, 1, 1], 3, square(1000, 1000, 40), square(1010, 1010, 10)[::-1])
    layer += feature([0, 0], 3, square(2000, 500, 20))
    layer += feature([0, 0], 3, square(4200, 500, 20))  # of the next tile
    layer += feature([2, 2], 3, square(100, 100, 20))   # no building
    layer += b"".join(block(3, k) for k in keys) + b"".join(block(4, block(1, v)) for v in values)
    return block(3, layer + varint(5 << 3) + varint(4096))


def check(problems, what, got, expected):
    if got != expected:
        problems.append(f"{what}: {got!r}, expected {expected!r}")


def hostile():
    """An archive of tiles that would write beside its folder: by .., an absolute path, and links to be written through."""
    out = io.BytesIO()
    with tarfile.open(fileobj=out, mode="w:gz") as archive:
        def add(name, data=b"x", **kind):
            member = tarfile.TarInfo(name)
            member.size = len(data) if not kind else 0
            for key, value in kind.items():
                setattr(member, key, value)
            archive.addfile(member, io.BytesIO(data) if not kind else None)
        folder = "package/real-world/osm-qa-astana"
        add(f"{folder}/12-1-1.mvt", b"good")
        add(f"{folder}/../../../escaped-1")
        add(f"{folder}-evil/12-1-2.mvt")
        add(f"{folder}/../../../../12-1-3.mvt")
        add("/tmp/dapple-escaped")
        add(f"{folder}/12-1-4.mvt", type=tarfile.SYMTYPE, linkname="../../../escaped-2")
        add(f"{folder}/12-1-4.mvt/escaped", b"through a link")
        add(f"{folder}/12-1-5.mvt", type=tarfile.LNKTYPE, linkname="/etc/passwd")
        add(f"{folder}/out", type=tarfile.SYMTYPE, linkname="/tmp")
        add(f"{folder}/out/12-1-6.mvt")
    return out.getvalue()


def check_archives(problems):
    loader = importlib.machinery.SourceFileLoader("fetch_astana", str(SCRIPT))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("fetch_astana", loader))
    sys.dont_write_bytecode = True
    loader.exec_module(module)
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder) / "a/b"
        work.mkdir(parents=True)
        module.unpack(hostile(), work)
        files = sorted(str(p.relative_to(folder)) for p in Path(folder).rglob("*") if not p.is_dir() or p.is_symlink())
        check(problems, "what a hostile archive leaves", files, ["a/b/package/real-world/osm-qa-astana/12-1-1.mvt"])
        # Another archive than the known one is not opened at all.
        bin_folder = Path(folder) / "bin"
        bin_folder.mkdir()
        (bin_folder / "package.tgz").write_bytes(hostile())
        npm = bin_folder / "npm"
        npm.write_text(f'#!/bin/sh\ncp "{bin_folder}/package.tgz" .\n')
        npm.chmod(0o755)
        environment = {**os.environ, "DAPPLE_CACHE": f"{folder}/cache", "PATH": f"{bin_folder}:{os.environ['PATH']}"}
        done = subprocess.run([SCRIPT], env=environment, capture_output=True, text=True)
        check(problems, "another archive", (done.returncode, "SHA-512 differs" in done.stderr), (2, True))


def main():
    problems = []
    check_archives(problems)
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        tiles = root / "package/real-world/osm-qa-astana"
        tiles.mkdir(parents=True)
        (root / "package/LICENSE-ODbL-1.0.md").write_text("licence")
        run = lambda: subprocess.run([SCRIPT, str(root)], env={**os.environ, "DAPPLE_CACHE": str(root / "cache")}, capture_output=True, text=True)
        check(problems, "exit code without tiles", run().returncode, 2)
        (tiles / f"{ZOOM}-{COLUMN}-{ROW}.mvt").write_bytes(tile())
        done = run()
        check(problems, "exit code", (done.returncode, done.stdout), (0, ""))
        scene = root / "cache/real/astana"
        features = json.loads((scene / "buildings.geojson").read_text())["features"]
        check(problems, "buildings", len(features), 2)
        check(problems, "heights", [f["properties"] for f in features], [{"height": "21.5"}, {}])
        rings = features[0]["geometry"]["coordinates"]
        check(problems, "corners", [len(r) for r in rings], [5, 5])
        # Forward Web Mercator of what came back is the place in the tile.
        lon, lat = rings[0][0]
        x = ((lon + 180) / 360 * 2 ** ZOOM - COLUMN) * 4096
        y = ((1 - math.asinh(math.tan(math.radians(lat))) / math.pi) / 2 * 2 ** ZOOM - ROW) * 4096
        check(problems, "place", (round(x, 1), round(y, 1)), (1000.0, 1000.0))
        stats = subprocess.run([sys.argv[1], "scene", str(scene / "astana.toml"), "--stats"], capture_output=True, text=True)
        check(problems, "the scene loads", stats.returncode, 0)
        # 16 walls × 2, tops and floors of a square ring 8 each; a box; the ground.
        check(problems, "triangles", stats.stdout.split("triangles")[1].split()[0], str(16 + 16 + 12 + 12))
    print("ok" if not problems else "FAILED")
    print("\n".join("    " + p for p in problems))
    return bool(problems)


sys.exit(main())
