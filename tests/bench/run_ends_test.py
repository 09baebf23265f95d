"""How `dapple run` ends when its plot cannot be drawn, its folder is taken or its files were damaged. Fake back-end, no GL."""
import os
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

DAPPLE = Path(sys.argv.pop(1)).resolve()
HOME = Path(__file__).resolve().parents[2]
SWEEP = """question = "?"
scenes = ["box"]
[[technique]]
name = "uniform"
size = [256, 512]
"""


class RunEnds(unittest.TestCase):
    def setUp(self):
        keep = tempfile.TemporaryDirectory()
        self.addCleanup(keep.cleanup)
        self.folder = Path(keep.name)
        self.out = self.folder / "out"
        (self.folder / "small.toml").write_text(SWEEP)

    def dapple(self, *words, home=HOME):
        return subprocess.run([DAPPLE, "--backend", "fake", *map(str, words)], capture_output=True, text=True, timeout=120,
                              env={**os.environ, "DAPPLE_HOME": str(home)})

    def run_(self, *words, **options):
        return self.dapple("run", self.folder / "small.toml", "-o", self.out, *words, **options)

    def home(self, script):
        """An installation whose plot.py is `script`."""
        home = self.folder / "home"
        (home / "bench/report").mkdir(parents=True)
        for name in ("shaders", "scenegen"):
            (home / name).symlink_to(HOME / name)
        (home / "bench/sweeps").symlink_to(HOME / "bench/sweeps")
        (home / "bench/report/plot.py").write_text(script)
        return home

    def test_a_plot_that_fails_fails_the_run_and_loses_nothing(self):
        for script, code in (("raise ValueError('odd name')", 2), ("import sys; sys.exit(4)", 4), ("import sys; sys.exit(99)", 2),
                             ("import os; os.kill(os.getpid(), 9)", 2)):
            with self.subTest(script):
                self.setUp()
                done = self.run_(home=self.home(script))
                self.assertEqual(done.returncode, code, done.stderr)
                self.assertIn("measurements are safe", done.stderr)
                self.assertTrue((self.out / "metrics.csv").is_file())
                self.assertEqual(self.dapple("plot", self.out).returncode, 0)

    def test_no_plot_needs_no_script(self):
        done = self.run_("--no-plot", home=self.home("raise ValueError"))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(sorted(p.name for p in self.out.iterdir()),
                         ["manifest.json", "metrics.csv", "plan.csv", "run.json", "samples.csv"])

    def test_retry_and_mix_are_for_resuming(self):
        for option in ("--mix", "--retry-failed"):
            self.assertEqual(self.run_(option).returncode, 2)

    def test_a_changed_byte_is_code_4_for_everyone_who_reads(self):
        self.assertEqual(self.run_().returncode, 0)
        for name in ("metrics.csv", "samples.csv", "plan.csv", "run.json"):
            good = (self.out / name).read_bytes()
            (self.out / name).write_bytes(good.replace(b"0", b"1", 1))
            for done in (self.dapple("plot", self.out), self.run_("--resume")):
                self.assertEqual(done.returncode, 4, done.stderr)
                self.assertIn(name, done.stderr)
            (self.out / name).write_bytes(good)
        self.assertEqual(self.dapple("plot", self.out).returncode, 0)

    def test_a_folder_that_another_process_writes_is_refused(self):
        slow = self.home("import pathlib, time, sys\npathlib.Path(sys.argv[1], 'plotting').touch()\ntime.sleep(60)")
        first = subprocess.Popen([DAPPLE, "--backend", "fake", "run", self.folder / "small.toml", "-o", self.out], start_new_session=True,
                                 stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env={**os.environ, "DAPPLE_HOME": str(slow)})
        try:
            while not (self.out / "plotting").exists():
                self.assertIsNone(first.poll())
                time.sleep(0.02)
            before = (self.out / "metrics.csv").read_bytes()
            for words in (["--resume"], []):
                done = self.run_(*words)
                self.assertEqual(done.returncode, 2)
                self.assertIn(f"process {first.pid}", done.stderr)
            self.assertEqual((self.out / "metrics.csv").read_bytes(), before)
        finally:
            os.killpg(first.pid, signal.SIGKILL)
            first.wait()
        self.assertEqual(self.run_("--resume").returncode, 0)


if __name__ == "__main__":
    unittest.main()
