"""The tree compiles with clang, which reads C++20 more strictly than g++ does. Tests and micro-benchmarks are left out.

All files see the flags of bench, the top floor, so that one precompiled header of what many of them include serves them all.
"""
import collections
import concurrent.futures
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[1]
BUILD = Path(sys.argv[1]).resolve().parent
COMMON = 12  # a system header that so many files include is worth precompiling
SYSTEM = re.compile(r"^#include <([^>]+)>", re.M)


def sources():
    files = [Path(entry["file"]) for entry in json.loads((BUILD / "compile_commands.json").read_text())]
    return sorted({f for f in files if f.is_relative_to(SOURCE) and f.relative_to(SOURCE).parts[0] in ("src", "scenegen", "bench")
                   and not f.is_relative_to(SOURCE / "bench/micro")} | set((SOURCE / "bench/verbs").glob("*.cpp")))


def flags():
    """Those of g++ for bench, without what it alone knows, the output and the optimiser."""
    command = next(e["command"] for e in json.loads((BUILD / "compile_commands.json").read_text())
                   if Path(e["file"]) == SOURCE / "bench/run.cpp")
    kept = [w for w in shlex.split(command) if w.startswith(("-D", "-I", "-W", "-f", "-std")) and w != "-Wno-restrict"]
    isystem = re.findall(r"-isystem (\S+)", command)
    return kept + [w for path in isystem for w in ("-isystem", path)] + [f'-DDAPPLE_SOURCE_DIR="{SOURCE}"', '-DDAPPLE_VERSION=""']


FLAGS = flags()


def compiled(arguments):
    return subprocess.run(["clang++", *FLAGS, *arguments], capture_output=True, text=True, cwd=BUILD)


def main():
    files = sources()
    counts = collections.Counter(h for f in files for h in set(SYSTEM.findall(f.read_text())))
    headers = [h for h, n in counts.items() if n >= COMMON and not h.startswith("epoxy")]
    with tempfile.TemporaryDirectory() as folder:
        common = Path(folder) / "common.h"
        common.write_text("".join(f"#include <{h}>\n" for h in sorted(headers)))
        made = compiled(["-x", "c++-header", str(common), "-o", f"{folder}/common.pch"])
        if made.returncode:
            print("FAILED: the common headers do not compile\n" + made.stderr)
            return True
        check = lambda file: compiled(["-fsyntax-only", "-include-pch", f"{folder}/common.pch", str(file)])
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            results = list(pool.map(check, files))
        # Control: what g++ 12 takes and clang 14 does not.
        bad = Path(folder) / "bad.cpp"
        bad.write_text("#include <utility>\nint f() { auto [a, b] = std::pair(1, 2); return [&] { return a + b; }(); }\n")
        control = check(bad).returncode != 0
    broken = [(f, r.stderr) for f, r in zip(files, results) if r.returncode]
    for path, message in broken:
        print(f"FAILED: {path.relative_to(SOURCE)} does not compile with clang\n{message}")
    ok = not broken and files and control
    print(f"{'ok' if ok else 'FAILED'}: {len(files) - len(broken)} of {len(files)} files compile with clang")
    return not ok


sys.exit(main())
