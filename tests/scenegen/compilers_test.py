"""One recipe gives the same bytes from g++ at -O0 and -O3 and from clang++ as from the program under test.

What computes geometry (plants, placement, terrain, primitives, cities and their traffic, the grid) is compiled anew with each; recipes, files and the rest come
from the program's own library, whose copies of these sources the linker then does not take.
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
COMPILERS = [("g++", "-O0"), ("g++", "-O3"), ("clang++", "-O3")]
LIBRARIES = ["OpenMeshTools", "OpenMeshCore", "osdCPU", "assimp", "fmt", "draco", "meshoptimizer", "webp"]

DRIVER = """
#include "base/hash.h"
#include "scenegen/library.h"
#include <cstdio>
int main(int n, char** argv) { std::puts(dapple::base::hex16(dapple::scenegen::loadScene(argv[1], {argv + 2, argv + n}).contentHash()).c_str()); }
"""

HEAD = """description = "Every species at two levels of detail, with every kind of leaf, in the wind"
seed = 3
trees = 60
spacing = 0.3
time = 0.7
[wind]
strength = 0.4
[terrain]
size = 160
cells = 64
relief = 9
droplets = 2000
[path]
views = 2
"""


def recipe():
    names = sorted(p.stem for p in (SOURCE / "scenegen/plants/species").glob("*.toml"))
    tables = [f'[[species]]\nname = "{name}"\nlod = {lod}\nleaves = "{("polygon", "card", "solid")[(i + lod) % 3]}"\n'
              for i, name in enumerate(names) for lod in (0, 1)]
    return HEAD + "".join(tables)


def flags():
    """Of CMake: those that decide about bytes, and what the sources need to compile."""
    text = (SOURCE / "CMakeLists.txt").read_text()
    options = re.search(r"add_compile_options\((.*?)\)", text).group(1).split()
    found = [o for o in options if o.startswith("-f")]
    assert "-ffp-contract=off" in found, options
    return found + ["-std=c++20", "-DNDEBUG", f'-DDAPPLE_SOURCE_DIR="{SOURCE}"', "-DGLM_ENABLE_EXPERIMENTAL",
                    f"-I{SOURCE}", f"-I{SOURCE}/src"]


def sources(folder):
    """One file of all plants, placement and primitives, for speed; terrain's have constants of the same names."""
    parts = sorted((SOURCE / "scenegen/plants").glob("*.cpp")) + sorted((SOURCE / "scenegen/placement").glob("*.cpp"))
    unity = folder / "unity.cpp"
    unity.write_text("".join(f'#include "{p}"\n' for p in [*parts, SOURCE / "scenegen/primitives.cpp"]) + DRIVER)
    return [unity, SOURCE / "scenegen/lod/grid.cpp", SOURCE / "scenegen/scene.cpp",
            *sorted((SOURCE / "scenegen/terrain").glob("*.cpp")), *sorted((SOURCE / "scenegen/city").glob("*.cpp"))]


def run(command):
    done = subprocess.run(command, capture_output=True, text=True, cwd=SOURCE)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}\n{done.stdout}{done.stderr}")
    return done.stdout


def compileAll(compiler, level, files, folder, pool):
    """Objects, as promises."""
    def one(source):
        target = folder / f"{source.stem}-{compiler}{level}.o"
        run([compiler, level, *flags(), "-c", str(source), "-o", str(target)])
        return str(target)
    return [pool.submit(one, source) for source in files]


def link(compiler, level, objects, folder, libraries):
    program = folder / f"driver-{compiler}{level}"
    exr = run(["pkg-config", "--libs", "OpenEXR"]).split()
    run([compiler, *objects, *libraries, *(f"-l{name}" for name in LIBRARIES), *exr, "-o", str(program)])
    return str(program)


def main():
    program = Path(sys.argv[1]).resolve()
    libraries = [str(program.parent / f"libdapple_{name}.a") for name in ("scenegen", "base")]
    with tempfile.TemporaryDirectory() as name, ThreadPoolExecutor(os.cpu_count()) as pool:
        folder = Path(name)
        scene = folder / "every-species.toml"
        scene.write_text(recipe())
        scenes = [[str(scene)], ["city-vienna", "scale=0.1"], ["city-manhattan", "scale=0.03"]]

        def hashOfProgram(name, *settings):
            stats = run([str(program), "scene", name, *(f"--set={s}" for s in settings), "--stats"])
            return re.search(r"^hash\s+([0-9a-f]{16})$", stats, re.M).group(1)
        expected = [hashOfProgram(*s) for s in scenes]
        files, objects = sources(folder), {}
        for compiler, level in COMPILERS:
            if shutil.which(compiler):
                objects[compiler, level] = compileAll(compiler, level, files, folder, pool)
            else:
                print(f"{compiler} {level}: skipped, as {compiler} is not installed")
        different = False
        for (compiler, level), promises in objects.items():
            driver = link(compiler, level, [p.result() for p in promises], folder, libraries)
            for words, hash in zip(scenes, expected):
                found = run([driver, *words]).strip()
                print(f"{compiler} {level}, {Path(words[0]).stem}: {found}{'' if found == hash else f', but the program has {hash}'}")
                different |= found != hash
        sys.exit(1 if different else 0)


main()
