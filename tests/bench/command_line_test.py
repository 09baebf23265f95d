"""The command line: exit codes, one clear line on stderr, data alone on stdout. Uses the fake back-end, no GL."""
import csv
import os
import signal
import subprocess
import time
import unittest

from command_line import DAPPLE, SWEEP, CommandLine, dapple, program


class RunsAndPlans(CommandLine):
    def write(self, text):
        path = self.folder / "bad.toml"
        path.write_text(text)
        return path

    def test_verbs_and_options_that_do_not_exist(self):
        self.refused(says=["quick", "run"])
        self.refused("pln", says=["'pln'", "'plan'"])
        self.refused("--frobnicate", says=["--frobnicate"])
        self.refused("list", "technique", says=["'techniques'"])
        self.refused("run", self.sweep, says=["--output", "dapple run --help"])
        self.assertEqual(subprocess.run([DAPPLE, "--backend", "fka", "plan", self.sweep], capture_output=True).returncode, 2)

    def test_bad_sweeps(self):
        out = self.folder / "out"
        for words in (["plan"], ["run", "-o", out]):
            self.refused(*words, self.write(""), says=["bad.toml", "empty"])
            self.refused(*words, self.write(SWEEP[:30]), says=["bad.toml:", "TOML"])
            self.refused(*words, self.write(SWEEP.replace("uniform", "unifrom")), says=["bad.toml:4", "'uniform'"])
            self.refused(*words, self.write(SWEEP.replace("size", "sise")), says=["bad.toml:5", "'size'"])
            self.refused(*words, self.write(SWEEP.replace("256", "0")), says=["bad.toml:5", "size"])
            self.refused(*words, self.write(SWEEP.replace('"box"', '"bx"')), says=["'bx'", "'box'"])
            self.refused(*words, self.folder / "missing.toml", says=["missing.toml"])
            self.refused(*words, "quik", says=["'quick'"])
            self.refused(*words, self.sweep, "-a", "siz=3", says=["'size'"])
            self.refused(*words, self.sweep, "--filter", "nowhere", says=["--filter"])
            self.assertFalse(out.exists())

    def test_places_that_cannot_be_written(self):
        self.refused("run", self.sweep, "-o", "/proc/nowhere", says=["/proc"])
        self.refused("run", self.sweep, "-o", self.sweep / "below", says=["small.toml"])
        if os.geteuid() != 0:
            self.folder.chmod(0o555)
            self.refused("run", self.sweep, "-o", self.folder / "out", says=["Permission denied"])
            self.folder.chmod(0o755)
        for what in "axes", "techniques":  # more and less than stdout's buffer
            with open("/dev/full", "w") as full:
                done = subprocess.run([DAPPLE, "list", what], stdout=full, stderr=subprocess.PIPE, text=True)
            self.assertEqual(done.returncode, 2)
            self.assertIn("disk", done.stderr)

    def test_plan_and_run_agree_and_stdout_is_data(self):
        plan = dapple("plan", self.sweep)
        self.assertEqual((plan.returncode, plan.stderr), (0, ""))
        planned = [row["point_id"] for row in csv.DictReader(plan.stdout.splitlines())]
        self.assertEqual(len(planned), 2)
        out = self.folder / "out"
        run = dapple("run", self.sweep, "-o", out)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertIn(f"{out}/metrics.csv\n", run.stdout)
        self.assertEqual((out / "plan.csv").read_text(), plan.stdout)
        with open(out / "metrics.csv", newline="") as file:
            self.assertEqual({row["point_id"] for row in csv.DictReader(file)}, set(planned))
        self.refused("run", self.sweep, "-o", out, says=["not empty", "--resume"])
        self.assertEqual(dapple("run", self.sweep, "-o", out, "--resume").returncode, 0)
        self.refused("run", self.sweep, "-o", out, "--resume", "-a", "size=64", says=["another plan"])

    def test_every_verb_has_help_with_an_example(self):
        for verb in ("quick", "scene", "list", "plan", "run", "render", "plot", "doctor", "view", "bundle", "help",
                     "completion"):
            done = dapple(verb, "--help")
            self.assertEqual(done.returncode, 0, verb)
            self.assertIn(f"dapple {verb}", done.stdout)
            self.assertIn("xample", done.stdout, verb)

    def test_ctrl_c_says_how_to_go_on(self):
        out = self.folder / "out"
        # A thousand blocks: long enough to be caught at work.
        self.sweep.write_text(SWEEP.replace("[[", "[sampling]\nmin_blocks = 1000\nmax_blocks = 1000\ntimeout_s = 9000\n[[", 1))
        words = [DAPPLE, "--backend", "fake", "run", self.sweep, "-o", out]
        process = subprocess.Popen(words, stderr=subprocess.PIPE, text=True)
        for _ in range(400):
            if (out / "journal.part").exists():
                break
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130, said)
        self.assertIn("--resume", said)
        self.assertFalse((out / "metrics.csv").exists())


if __name__ == "__main__":
    unittest.main()
