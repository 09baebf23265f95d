"""The relocatable bundle: unpacked elsewhere, it runs with an empty environment and brings its own libraries."""
import hashlib
import os
import re
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[1]
PROGRAM = Path(sys.argv[1]).resolve()
MAX_MIB = 48
# What may come from the machine: the C library's family, the C++ runtime, GL with the driver behind it.
OWN_OF_MACHINE = re.compile(r"^(ld-linux.*|lib(c|m|mvec|pthread|dl|rt|stdc\+\+|gcc_s)\.so.*)$")
failures = 0


def check(name, ok, detail=""):
    global failures
    failures += not ok
    print(f"{'ok' if ok else 'FAILED'}: {name}" + ("" if ok else f"\n    {detail}"), flush=True)


def bundle(*words):
    return subprocess.run([SOURCE / "bench/bundle.sh", *words], capture_output=True, text=True)


def contents(archive):
    """(name, mode, time, SHA-256) of the members."""
    with tarfile.open(archive) as tar:
        return {(m.name, m.mode, m.mtime, hashlib.sha256(tar.extractfile(m).read()).hexdigest() if m.isfile() else m.linkname)
                for m in tar}


def run(*words, env=None, cwd="/"):
    return subprocess.run(words, capture_output=True, text=True, env=env or {}, cwd=cwd)


def loaded(program, folder, env):
    """Paths of the libraries that the loader took when the program ran, by the loader's own account."""
    log = folder / "loader"
    run(program, "list", "techniques", env={"LD_DEBUG": "libs", "LD_DEBUG_OUTPUT": str(log), **env})
    text = "".join(part.read_text(errors="replace") for part in folder.glob("loader.*"))
    for part in folder.glob("loader.*"):
        part.unlink()
    return {Path(path) for path in re.findall(r"calling init: (/.+)", text)}


def testUnpacked(scratch):
    archive = scratch / "dapple.tar.xz"
    made = bundle("-p", PROGRAM, "-o", archive)
    if made.returncode or not archive.exists():
        return check("the bundle is written", False, made.stderr)
    size = archive.stat().st_size / 2**20
    check(f"the bundle has {size:.1f} MiB, at most {MAX_MIB}", size <= MAX_MIB)
    check("only the archive is left behind", [p.name for p in scratch.iterdir()] == ["dapple.tar.xz"])
    bundle("-p", PROGRAM, "-o", scratch / "again.tar.xz")
    one, two = contents(archive), contents(scratch / "again.tar.xz")
    check("the same input gives the same bytes", archive.read_bytes() == (scratch / "again.tar.xz").read_bytes(),
          f"members that differ: {sorted({member[0] for member in one ^ two})}")

    place = scratch / "another place"
    place.mkdir()
    subprocess.run(["tar", "-xf", archive, "-C", place], check=True)
    top = place / "dapple"
    program, launcher = top / "libexec/dapple", top / "bin/dapple"
    expected = subprocess.run([PROGRAM, "list", "techniques"], capture_output=True, text=True)
    listed = run(launcher, "list", "techniques")
    check("bin/dapple runs with an empty environment",
          listed.returncode == 0 and listed.stdout == expected.stdout and listed.stdout, listed)
    check("so does dapple/dapple, by a relative path", run("./dapple/dapple", "list", "techniques", cwd=place).stdout == listed.stdout)
    check("a wrong word still ends in exit 2", run(launcher, "no-such-verb").returncode == 2)

    # A scene that only the unpacked folder has shows whose data is read.
    scenes = top / "scenegen/scenes"
    some = next(scenes.glob("*.toml"))
    (scenes / "only-in-the-bundle.toml").write_bytes(some.read_bytes())
    check("it reads the bundle's data, not the source tree's", "only-in-the-bundle" in run(launcher, "list", "scenes").stdout)

    libraries = loaded(program, scratch, {})
    inside = {path for path in libraries if path.resolve().is_relative_to(top.resolve())}
    strangers = {str(path) for path in libraries - inside if not OWN_OF_MACHINE.match(path.name)}
    check(f"{len(inside)} libraries come from the bundle, none but the C and C++ runtimes from the machine",
          inside and not strangers, strangers)
    own = loaded(program, scratch, {"LD_LIBRARY_PATH": str(top / "lib/c++")})
    check("the bundled C++ runtime serves where it is asked for",
          all(any(p.name == name and p.is_relative_to(top) for p in own) for name in ("libstdc++.so.6", "libgcc_s.so.1")), own)
    unwanted = [p.name for p in (top / "lib").rglob("*") if re.match(r"lib(c|m|GL.*|EGL.*|OpenGL.*)\.so", p.name)]
    check("neither libc nor GL is packed", not unwanted, unwanted)

    licences = {path.name: path.read_text(errors="replace") for path in (top / "licences").iterdir()}
    ours = (top / "LICENSE").read_text()
    check("it carries its own licence", "the Dapple authors" in ours and "MIT" in ours)
    shipped = {path.name for path in (top / "lib").rglob("*.so*")}
    files = run("/usr/bin/dpkg-query", "-L", *licences).stdout
    unlicensed = {name for name in shipped if name not in files}
    check(f"and those of all {len(shipped)} libraries that it ships", shipped and not unlicensed, unlicensed)
    check("and of what is compiled in",
          {"libglm-dev", "libstb-dev", "libcli11-dev", "nlohmann-json3-dev"} <= set(licences), sorted(licences))
    common = re.compile(r"/usr/share/common-licenses/([\w.+-]*\w)")
    named = {name for text in licences.values() for name in common.findall(text)}
    absent = {name for name in named if name not in licences and Path("/usr/share/common-licenses", name).exists()}
    check("and the texts that these name", named and not absent, absent)
    check("each of them says something", all(len(text) > 200 for text in licences.values()))

    fake = scratch / "tools"
    fake.mkdir()
    (fake / "getconf").write_text("#!/bin/sh\necho glibc 2.17\n")
    (fake / "getconf").chmod(0o755)
    old = run(launcher, "list", "techniques", env={"PATH": f"{fake}:/usr/bin:/bin"})
    check("an older C library: one line and exit 2",
          old.returncode == 2 and len(old.stderr.splitlines()) == 1 and "2.17" in old.stderr, old)

    if run(PROGRAM, "doctor").returncode:
        return print("skipped: no GL context here, so nothing is rendered")
    picture = scratch / "box.png"
    drawn = run(launcher, "render", "box", "uniform", "-a", "size=64", "--what", "visibility", "-o", picture,
                env={"DAPPLE_CACHE": str(scratch / "cache")})
    check("it renders", drawn.returncode == 0 and picture.exists() and picture.stat().st_size > 500, drawn)


def testRefusals(scratch):
    for name, words in {"no file": [], "not an archive's name": ["-o", scratch / "dapple.zip"],
                        "no such folder": ["-o", scratch / "none/dapple.tar.xz"],
                        "no program": ["-p", scratch / "none", "-o", scratch / "dapple.tar.xz"]}.items():
        done = bundle("-p", PROGRAM, *words)
        check(f"{name}: one line, exit 2, nothing written",
              done.returncode == 2 and len(done.stderr.splitlines()) == 1 and not os.listdir(scratch), done)


for test in (testRefusals, testUnpacked):
    with tempfile.TemporaryDirectory() as folder:
        test(Path(folder))
sys.exit(failures > 0)
