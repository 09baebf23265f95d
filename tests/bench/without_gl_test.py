"""Where EGL or GL is not installed: what draws ends in one line that names the packages, and planning goes on."""
import os
import shutil
import subprocess
import unittest
from pathlib import Path

from command_line import DAPPLE, CommandLine, hasGl, program


def installed(name):
    """Where the loader finds a library; None if nowhere."""
    cache = subprocess.run(["/sbin/ldconfig", "-p"], capture_output=True, text=True).stdout
    return next((line.split(" => ")[1] for line in cache.splitlines() if line.split()[:1] == [name]), None)


EGL, OPENGL, GL = "libEGL.so.1", "libOpenGL.so.0", "libGL.so.1"


def without(*libraries):
    """A call of the program in a mount namespace where these libraries are empty files."""
    hide = "; ".join(f"mount --bind /dev/null {installed(name)}" for name in libraries if installed(name))
    enter = ["unshare", "-m"] if os.geteuid() == 0 else ["unshare", "-rm"]

    def call(*words, **options):
        return subprocess.run([*enter, "sh", "-ec", f'{hide}; exec "$0" "$@"', str(DAPPLE), *map(str, words)],
                              capture_output=True, text=True, timeout=300, **options)
    return call


def canHide():
    return shutil.which("unshare") is not None and without(EGL)("list", "stress").returncode == 0


@unittest.skipUnless(canHide(), "no mount namespace can be made here")
class WithoutGl(CommandLine):
    CASES = (((EGL,), ["libEGL.so.1", "libegl1", "libegl-mesa0"]),
             ((OPENGL, GL), ["libOpenGL.so.0", "libopengl0", "libgl1-mesa-dri"]),
             ((EGL, OPENGL, GL), ["libEGL.so.1 and libOpenGL.so.0", "libegl1 libopengl0"]))

    def test_what_draws_names_the_packages(self):
        for libraries, says in self.CASES:
            call = without(*libraries)
            for words in (["doctor"], ["doctor", "--json"], ["render", "box", "uniform", "-o", self.folder / "x.png"],
                          ["run", self.sweep, "-o", self.folder / "out"], ["quick", "-o", self.folder / "out"],
                          ["scene", "box", "-o", self.folder / "x.glb", "--picture", self.folder / "x.png"]):
                done = call(*words)
                self.assertEqual(done.returncode, 2, (libraries, words, done.stderr))
                self.assertTrue(done.stderr.splitlines()[-1].startswith("dapple: lib"), done.stderr)
                for text in says:
                    self.assertIn(text, done.stderr)
            self.assertFalse((self.folder / "x.png").exists())

    def test_the_window_names_them_too(self):
        done = without(OPENGL, GL)("view", "box", "--frames", "1")
        self.assertEqual((done.returncode, len(done.stderr.splitlines())), (2, 1), done.stderr)
        self.assertIn("libopengl0", done.stderr)

    def test_a_plan_is_the_same_and_says_what_it_assumes(self):
        expected = self.done("plan", self.sweep, call=program)
        for libraries, _ in self.CASES:
            done = without(*libraries)("plan", self.sweep)
            self.assertEqual((done.returncode, done.stdout), (0, expected), done.stderr)
            self.assertIn("no GL is here", done.stderr)
            self.assertEqual(len(done.stderr.splitlines()), 1)
        if hasGl():
            self.assertEqual(program("plan", self.sweep).stderr, "")
        self.assertEqual(without(EGL)("plan", self.sweep, "--device", "0").returncode, 2)

    def test_either_gl_library_will_do(self):
        if not hasGl() or not installed(OPENGL) or not installed(GL):
            self.skipTest("not both GL libraries here")
        for hidden in (OPENGL, GL):
            done = without(hidden)("doctor")
            self.assertIn(done.returncode, (0, 5), done.stderr)


if __name__ == "__main__":
    unittest.main()
