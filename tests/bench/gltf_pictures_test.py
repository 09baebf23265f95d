"""What glTF says of opacity, wrap modes, transforms and skins: files that say one thing in two ways give equal pictures.

Camera, shadow map and ray-traced reference must honour cut-off, opacity factor, wrap modes and texture transform alike, so
each pair is compared by visibility (map), by reference (rays) and by the shaded picture (camera).
"""
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

import matplotlib.image
import numpy

dapple = pathlib.Path(sys.argv[1]).resolve()
fixtures = pathlib.Path(__file__).resolve().parents[1] / "fixtures" / "gltf"
failures = 0


def picture(folder, scene, what, size="160x120", technique="uniform"):
    out = folder / f"{pathlib.Path(scene).name}-{what}.png"
    done = subprocess.run([dapple, "render", scene, technique, "--what", what, "-r", size, "-o", out], capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"{scene}: {done.stderr}")
    return matplotlib.image.imread(out)[..., :3]


def check(name, different, most=0):
    global failures
    failures += different > most
    print(f"{'ok' if different <= most else 'FAILED'}: {name}: {different} pixels differ, at most {most} may")


def pair(folder, a, b, whats=("visibility", "reference", "shaded"), most=0, size="160x120"):
    for what in whats:
        differs = numpy.abs(picture(folder, a, what, size) - picture(folder, b, what, size)).max(axis=2) > 1e-6
        check(f"{pathlib.Path(a).name} and {pathlib.Path(b).name}, {what}", int(differs.sum()), most)


def expanded(source, target):
    """`source` with EXT_mesh_gpu_instancing written out as nodes."""
    import base64
    import struct
    gltf = json.loads(source.read_text())
    data = base64.b64decode(gltf["buffers"][0]["uri"].split(",")[1])

    def values(accessor, n):
        a = gltf["accessors"][accessor]
        view = gltf["bufferViews"][a["bufferView"]]
        numbers = struct.unpack_from(f"<{a['count'] * n}f", data, view.get("byteOffset", 0) + a.get("byteOffset", 0))
        return [list(numbers[i * n:(i + 1) * n]) for i in range(a["count"])]

    for index, node in enumerate(list(gltf["nodes"])):
        instancing = node.get("extensions", {}).pop("EXT_mesh_gpu_instancing", None)
        if not instancing:
            continue
        node["children"] = []
        columns = {k: values(v, 4 if k == "ROTATION" else 3) for k, v in instancing["attributes"].items()}
        for i in range(len(columns["TRANSLATION"])):
            node["children"].append(len(gltf["nodes"]))
            gltf["nodes"].append({"mesh": node["mesh"], "name": node["name"], **{k.lower(): v[i] for k, v in columns.items()}})
        del node["mesh"]
    gltf.pop("extensionsRequired"), gltf.pop("extensionsUsed")
    target.write_text(json.dumps(gltf))
    shutil.copy(source.with_suffix(".toml"), target.with_suffix(".toml"))


with tempfile.TemporaryDirectory() as name:
    work = pathlib.Path(name)
    expanded(fixtures / "instancing/rows.gltf", work / "expanded.gltf")
    pair(work, fixtures / "instancing/rows.gltf", work / "expanded.gltf")
    for case in ("cut_low", "cut_high", "factor"):
        pair(work, fixtures / f"opacity/{case}.gltf", fixtures / "opacity/control.gltf")
    for case in ("space", "umlaut"):
        pair(work, fixtures / f"uri/{case}.gltf", fixtures / "uri/control.gltf")
    for case in ("both", "offset", "scale_half", "scale_two"):
        pair(work, fixtures / f"texture_transform/{case}.gltf", fixtures / f"texture_transform/{case}_control.gltf", ("visibility", "reference"))
    for case in ("ibm", "no_ibm"):
        pair(work, fixtures / f"skin/{case}.gltf", fixtures / "skin/control.gltf", ("visibility", "reference"))

    # A card whose coordinates run from -1 to 2: a sampler's wrap against a picture that is written out three times as large.
    card = json.loads((fixtures / "opacity/control.gltf").read_text())
    texels = numpy.roll(matplotlib.image.imread(fixtures / "opacity/control_t.png"), (3, 5), axis=(0, 1))  # without symmetry
    matplotlib.image.imsave(work / "control_t.png", texels)
    wrapped = {}
    for mode, pad in ((33071, "edge"), (33648, "symmetric"), (10497, "wrap")):
        wide = dict(card, samplers=[{"wrapS": mode, "wrapT": mode}], textures=[{"source": 0, "sampler": 0}])
        surface = next(m for m in wide["materials"] if "baseColorTexture" in m["pbrMetallicRoughness"])["pbrMetallicRoughness"]["baseColorTexture"]
        surface["extensions"] = {"KHR_texture_transform": {"scale": [3, 3], "offset": [-1, -1]}}
        (work / "wide.gltf").write_text(json.dumps(wide))
        surface.pop("extensions")
        wide["samplers"], wide["images"] = [{"wrapS": 33071, "wrapT": 33071}], [{"uri": "large.png"}]
        h, w = texels.shape[:2]
        matplotlib.image.imsave(work / "large.png", numpy.pad(texels, ((h, h), (w, w), (0, 0)), mode=pad))
        (work / "large.gltf").write_text(json.dumps(wide))
        for file in ("wide", "large"):
            shutil.copy(fixtures / "opacity/control.toml", work / f"{file}.toml")
        pair(work, work / "wide.gltf", work / "large.gltf", ("visibility", "reference"))
        wrapped[pad] = picture(work, work / "wide.gltf", "visibility")
    for a, b in (("edge", "symmetric"), ("symmetric", "wrap"), ("wrap", "edge")):
        same = bool((wrapped[a] == wrapped[b]).all())
        failures += same
        print(f"{'FAILED: nothing differs' if same else 'ok: a difference'} between {a} and {b}")

    # The same scene through other people's tools. Those that store positions exactly give the same pixels; the rest moves them by
    # up to a few millimetres, and shadow edges with them.
    tools = fixtures / "tools"
    pixels = 480 * 360
    for file, most in (("11-separate.gltf", 0), ("05-webp.glb", 0), ("23-pack-noq.glb", 0), ("22-pack-mi.glb", pixels // 1000), ("03-meshopt.glb", pixels // 500),
                       ("04-draco.glb", pixels // 500), ("21-pack-cc.glb", pixels // 300), ("31-pipeline-draco.glb", pixels // 100)):
        pair(work, tools / file, tools / "00-export.glb", ("visibility",), most, "480x360")
    pair(work, tools / "11-separate.gltf", tools / "00-export.glb", ("shaded",), 0, "480x360")

sys.exit(1 if failures else 0)
