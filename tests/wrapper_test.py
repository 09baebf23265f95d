"""The wrapper `dapple`, in a copy of the checkout, with stand-ins for dpkg, apt, cmake and ninja on the path.

The stand-in for ninja puts the real program in place, so that forwarding is the real thing."""
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

PROGRAM = Path(sys.argv[1]).resolve()
SOURCE = Path(__file__).resolve().parents[1]
COPIED = ["dapple", "packages.txt", "CMakeLists.txt", "CMakePresets.json", "src", "scenegen", "bench", "shaders"]
failures = 0


def check(name, ok, detail=""):
    global failures
    failures += not ok
    print(f"{'ok' if ok else 'FAILED'}: {name}" + ("" if ok else f"\n    {detail}"))


def writeTool(path, body):
    path.write_text("#!/bin/bash\n" + body)
    path.chmod(0o755)


class Checkout:
    """A copy of the sources, and a folder of stand-in tools that log each call."""

    def __init__(self, folder, missing=(), root=True, sudo=False, dpkg=True):
        self.top = Path(folder) / "checkout"
        self.tools = Path(folder) / "tools"
        self.log = Path(folder) / "calls"
        self.top.mkdir(parents=True)
        self.tools.mkdir()
        self.log.touch()
        for name in COPIED:
            source = SOURCE / name
            (shutil.copytree if source.is_dir() else shutil.copy2)(source, self.top / name)
        # Only these tools exist, so that what the machine has installed does not matter.
        for name in ["bash", "readlink", "dirname", "find", "mkdir", "touch", "mv", "grep", "flock", "tail", "env",
                     "sleep", "cp", "true", "cat"]:
            (self.tools / name).symlink_to(shutil.which(name))
        record = f'echo "${{0##*/}} $*" >> {self.log}\n'
        writeTool(self.tools / "cmake", record +
                  'echo "CMAKE_HOME_DIRECTORY:INTERNAL=$PWD" > build/release/CMakeCache.txt; echo configured\n')
        writeTool(self.tools / "ninja", record + f'[[ ! -v SLOW ]] || sleep "$SLOW"\ncp {PROGRAM} "$2/dapple"\necho "a step"\n')
        writeTool(self.tools / "ctest", record + "echo '100% tests passed'\n")
        for name in ["c++", "pkg-config"]:
            writeTool(self.tools / name, record)
        if dpkg:
            lost = " ".join(missing)
            writeTool(self.tools / "dpkg-query", record + f'for p in "${{@:4}}"; do [[ " {lost} " == *" $p "* ]] || '
                      'echo "installed $p"; done\n')
            writeTool(self.tools / "apt-get", record)
        if sudo:
            writeTool(self.tools / "sudo", record + '[[ $1 != -n ]] || shift\nexec "$@"\n')
        # EUID is read-only in bash: the copy of the wrapper asks a variable instead.
        wrapper = self.top / "dapple"
        text = wrapper.read_text()
        assert text.count("EUID") == 1
        wrapper.write_text(text.replace("EUID", "0" if root else "1000"))

    def call(self, *words, cwd=None, env=None):
        self.log.write_text("")
        start = time.monotonic()
        done = subprocess.run([self.top / "dapple", *words], cwd=cwd or self.top, capture_output=True, text=True,
                              stdin=subprocess.DEVNULL, env={"PATH": str(self.tools), "HOME": "/", **(env or {})})
        done.seconds = time.monotonic() - start
        done.calls = self.log.read_text().splitlines()
        return done

    def start(self, *words, env):
        return subprocess.Popen([self.top / "dapple", *words], cwd=self.top, stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE, text=True, env={"PATH": str(self.tools), **env})


def called(done, tool):
    return [line for line in done.calls if line.startswith(tool + " ")]


def testPackageList():
    lines = [line.split(None, 1) for line in (SOURCE / "packages.txt").read_text().splitlines()
             if line.strip() and not line.startswith("#")]
    names = [line[0] for line in lines]
    check("each package has a legal Debian name", all(re.fullmatch(r"[a-z0-9][a-z0-9+.-]+", n) for n in names), names)
    check("each package has its reason", all(len(line) == 2 for line in lines), lines)
    check("no package is listed twice", len(set(names)) == len(names), names)


def testForwarding(folder):
    checkout = Checkout(folder)
    expected = subprocess.run([PROGRAM, "list", "techniques"], capture_output=True, text=True)
    first = checkout.call("list", "techniques")
    check("first call configures and builds the program alone",
          called(first, "cmake") == ["cmake --preset release"] and len(called(first, "ninja")) == 1
          and called(first, "ninja")[0].endswith(" dapple"), first.calls)
    check("nothing is installed when nothing is missing", not called(first, "apt-get"), first.calls)
    check("stdout and exit code are the program's",
          (first.stdout, first.returncode) == (expected.stdout, expected.returncode), first)

    calls = [checkout.call("list", "techniques") for _ in range(3)]
    check("unchanged: no tool is called", not any(done.calls for done in calls), calls)
    fastest = min(done.seconds for done in calls)
    check(f"forwarding takes {fastest * 1000:.0f} ms, under 1 s", fastest < 1)
    check("unchanged: nothing on stderr from the wrapper", calls[0].stderr == expected.stderr, calls[0].stderr)

    os.symlink(checkout.top / "dapple", Path(folder) / "link")
    linked = subprocess.run([Path(folder) / "link", "list", "techniques"], cwd="/", capture_output=True, text=True,
                            env={"PATH": str(checkout.tools), "LC_ALL": "de_DE.UTF-8"})
    check("works through a link, from elsewhere, in another locale",
          (linked.stdout, linked.returncode) == (expected.stdout, expected.returncode), linked)
    bad = checkout.call("no-such-verb")
    check("the program's exit code is passed on", bad.returncode == 2, bad)

    (checkout.top / "src/base/new.h").write_text("#pragma once\n")
    check("a new header rebuilds", len(called(checkout.call("list", "techniques"), "ninja")) == 1)
    (checkout.top / "src/base/new.h").unlink()
    check("a removed header rebuilds", len(called(checkout.call("list", "techniques"), "ninja")) == 1)
    (checkout.top / "bench/sweeps/new.toml").parent.mkdir(exist_ok=True)
    checkout.call("list", "techniques")
    next((checkout.top / "bench").rglob("*.cpp")).touch()
    check("a touched source rebuilds", len(called(checkout.call("list", "techniques"), "ninja")) == 1)

    test = checkout.call("test", "-R", "truth")
    check("test builds everything with the ci preset, then hands its words to ctest",
          called(test, "cmake") == ["cmake --preset ci"] and called(test, "ninja")[0].endswith(" all")
          and called(test, "ctest")[0].endswith(" -R truth"), test.calls)
    check("test ends with ctest's summary", test.stdout == "100% tests passed\n", test.stdout)

    moved = checkout.top.rename(Path(folder) / "moved")
    (moved / "CMakeLists.txt").touch()
    checkout.top = moved
    check("a moved checkout is configured afresh",
          called(checkout.call("list", "techniques"), "cmake") == ["cmake --fresh --preset release"])

    writeTool(checkout.tools / "ninja", "echo error: broken; exit 1\n")
    (checkout.top / "CMakeLists.txt").touch()
    broken = checkout.call("list", "techniques")
    check("a broken build is exit 2, on stderr only", broken.returncode == 2 and not broken.stdout
          and "error: broken" in broken.stderr, broken)
    check("and is tried again by the next call", checkout.call("list", "techniques").returncode == 2)


def testHelp(folder):
    checkout = Checkout(folder, missing=["xz-utils"])
    for words in (["test", "--help"], ["test", "-h"], ["test", "-R", "truth", "--help"]):
        done = checkout.call(*words)
        check(f"{' '.join(words)} prints help and calls no tool",
              done.returncode == 0 and not done.calls and done.stdout.startswith("Build everything")
              and "ctest" in done.stdout and not done.stderr, (done, done.calls))
        check("and makes nothing", not (checkout.top / "build").exists())
    words = checkout.call("completion", "words", "--", "re")
    check("completion before the first build is empty and builds nothing",
          (words.returncode, words.stdout, words.stderr, words.calls) == (0, "", "", []), words)
    checkout.call("list", "techniques")
    (checkout.top / "CMakeLists.txt").touch()
    words = checkout.call("completion", "words", "--", "re")
    check("later it is the program's, and still builds nothing", (words.stdout, words.calls) == ("render\n", []), words)


def testConcurrent(folder):
    checkout = Checkout(folder)
    running = [checkout.start("list", "techniques", env={"SLOW": "1"}) for _ in range(3)]
    ends = [(p.communicate()[0], p.returncode) for p in running]
    builds = [line for line in checkout.log.read_text().splitlines() if line.startswith("ninja ")]
    check("three calls at once build once", len(builds) == 1, builds)
    check("and all three get their answer", len(set(ends)) == 1 and ends[0][1] == 0, ends)


def testMissing(folder):
    lost = ["libtbb-dev", "xz-utils"]
    root = Checkout(folder + "/root", missing=lost).call("list", "techniques")
    check("root installs just what is missing",
          called(root, "apt-get")[-1] == "apt-get -q install -y --no-install-recommends libtbb-dev xz-utils", root.calls)
    check("it says what and why", all(re.search(rf"^  {name} +\w", root.stderr, re.M) for name in lost), root.stderr)

    user = Checkout(folder + "/sudo", missing=lost, root=False, sudo=True).call("list", "techniques")
    check("others install through sudo", called(user, "sudo")[-1].startswith("sudo -n env") and user.returncode == 0,
          user)

    nobody = Checkout(folder + "/nobody", missing=lost, root=False).call("list", "techniques")
    check("neither root nor sudo: exit 2 and the command to run",
          nobody.returncode == 2 and "apt-get install libtbb-dev xz-utils" in nobody.stderr, nobody)
    check("and nothing is built", not called(nobody, "ninja"), nobody.calls)

    other = Checkout(folder + "/other", dpkg=False)
    fedora = other.call("list", "techniques")
    check("not Debian, tools at hand: says so and goes on",
          fedora.returncode == 0 and "not a Debian system" in fedora.stderr, fedora)
    (Path(folder) / "other/checkout/build/packages.stamp").unlink()
    (other.tools / "cmake").unlink()
    bare = other.call("list", "techniques")
    check("not Debian, a tool missing: exit 2 and its name", bare.returncode == 2 and "no cmake here" in bare.stderr, bare)


testPackageList()
for test in [testForwarding, testHelp, testConcurrent, testMissing]:
    with tempfile.TemporaryDirectory() as folder:
        test(folder)
sys.exit(failures > 0)
