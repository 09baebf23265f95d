"""The shape of the house: a folder includes itself and lower floors only, and no file is too long to read."""
import re
import sys
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[1]
# Folder of the sources → (floor, prefix in #include "prefix/…").
FLOORS = {
    "src/base": (0, "base"),
    "scenegen": (1, "scenegen"), "src/gl": (1, "gl"),
    "src/gpuscene": (2, "gpuscene"), "src/measure": (2, "measure"), "src/truth": (2, "truth"),
    "src/frame": (3, "frame"), "src/visibility": (3, "visibility"),
    "src/shadow": (4, "shadow"),
    "bench": (5, "bench"),
}
FLOOR_OF = {prefix: floor for floor, prefix in FLOORS.values()}
SHARED = "shaders/shared"  # structs that C++ and GLSL both compile: plain data, open to every floor
MAX_LINES = 500
INCLUDE = re.compile(r'^\s*#\s*include\s*(["<])([^">]+)[">]', re.M)


def violations(path, text, ownPrefix, exists):
    """Lines that say what is wrong with the includes of one file of the folder `ownPrefix`."""
    found = []
    for bracket, name in INCLUDE.findall(text):
        prefix = name.split("/")[0]
        if bracket == "<":
            if prefix in FLOOR_OF and exists(name):
                found.append(f"{path}: <{name}> is ours: include it in quotes")
        elif name.startswith(SHARED + "/"):
            pass
        elif prefix not in FLOOR_OF or "/" not in name:
            if not name.endswith(".inc"):
                found.append(f"{path}: \"{name}\" does not begin with a folder of the house")
        elif prefix != ownPrefix and FLOOR_OF[prefix] >= FLOOR_OF[ownPrefix]:
            found.append(f"{path}: \"{name}\" is on floor {FLOOR_OF[prefix]}, not below floor {FLOOR_OF[ownPrefix]}")
    return found


def selfTest():
    """The checker must see each kind of violation."""
    exists = lambda name: True
    cases = {'#include "base/error.h"': 0, '#include "truth/metrics.h"': 0, '#include <vector>': 0,
             '#include "gl/query.h"': 0, '#include "gpuscene/upload.h"': 1, '#  include "frame/pass.h"': 1,
             '#include "error.h"': 1, '#include <base/error.h>': 1, '#include "../base/error.h"': 1}
    return [f"self-test: {text} → {violations('x', text, 'truth', exists)}"
            for text, expected in cases.items() if len(violations("x", text, "truth", exists)) != expected]


def sources(folder, suffixes):
    return sorted(p for p in (SOURCE / folder).rglob("*") if p.suffix in suffixes and p.is_file())


def report(name, problems):
    print(f"{'FAILED' if problems else 'ok'}: {name}")
    for problem in problems:
        print("    " + problem)
    return bool(problems)


def main():
    problems, count = [], 0
    exists = lambda name: (SOURCE / name).exists() or (SOURCE / "src" / name).exists()
    for folder, (_, prefix) in FLOORS.items():
        for path in sources(folder, {".h", ".cpp"}):
            if path.is_relative_to(SOURCE / "bench/micro"):
                continue  # micro-benchmarks time the floors they name
            count += 1
            problems += violations(path.relative_to(SOURCE), path.read_text(), prefix, exists)
    unknown = [str(p.relative_to(SOURCE)) for p in (SOURCE / "src").iterdir()
               if p.is_dir() and f"src/{p.name}" not in FLOORS]
    long = []
    for folder in ["src", "scenegen", "bench", "shaders", "tests"]:
        for path in sources(folder, {".h", ".cpp", ".py", ".sh", ".glsl", ".vert", ".frag", ".comp", ".geom"}):
            lines = path.read_text().count("\n")
            if lines > MAX_LINES:
                long.append(f"{path.relative_to(SOURCE)}: {lines} lines")
    failed = report("the checker sees violations", selfTest())
    failed |= report(f"{count} files include their own folder and lower floors only", problems if count else ["no files"])
    failed |= report("every folder under src has a floor", unknown)
    failed |= report(f"no source is longer than {MAX_LINES} lines", long)
    return failed


sys.exit(main())
