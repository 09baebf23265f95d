"""Each header compiles alone, with the flags of its folder's library."""
import concurrent.futures
import json
import shlex
import subprocess
import sys
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[1]
BUILD = Path(sys.argv[1]).resolve().parent
FOLDERS = ["src", "scenegen", "bench", "shaders/shared"]


def flagsByFolder():
    """Top folder (src/base, scenegen, …) → compiler and flags, without the input, the output and the optimiser."""
    flags = {}
    for entry in json.loads((BUILD / "compile_commands.json").read_text()):
        path = Path(entry["file"])
        if not path.is_relative_to(SOURCE) or path.is_relative_to(SOURCE / "tests"):
            continue
        words, kept = shlex.split(entry["command"]), []
        while words:
            word = words.pop(0)
            if word in ("-o", "-c"):
                words.pop(0)
            elif not word.startswith("-O") and word != "-g":
                kept.append(word)
        flags.setdefault(topFolder(path), kept)
    return flags


def topFolder(path):
    parts = path.relative_to(SOURCE).parts
    return "/".join(parts[:2]) if parts[0] == "src" else parts[0]


def compileAlone(flags, text):
    done = subprocess.run([*flags, "-fsyntax-only", "-x", "c++", "-"], input=text, capture_output=True, text=True,
                          cwd=BUILD)
    return done.returncode, done.stderr


def main():
    flags = flagsByFolder()
    flags["shaders"] = flags["src/gl"]
    headers = sorted(p for folder in FOLDERS for p in (SOURCE / folder).rglob("*.h"))
    # Twice: a header must stand alone, and bear being included again.
    jobs = [(flags[topFolder(p)], f'#include "{p}"\n#include "{p}"\n') for p in headers]
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        results = list(pool.map(lambda job: compileAlone(*job), jobs))
    broken = [(p, message) for p, (code, message) in zip(headers, results) if code]
    control, _ = compileAlone(flags["src/base"], "dapple::base::Unknown x;\n")
    for path, message in broken:
        print(f"FAILED: {path.relative_to(SOURCE)} does not compile alone\n{message}")
    ok = not broken and headers and control
    print(f"{'ok' if ok else 'FAILED'}: {len(headers) - len(broken)} of {len(headers)} headers compile alone")
    return not ok


sys.exit(main())
