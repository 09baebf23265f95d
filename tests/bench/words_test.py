"""Words of the command line: each has its place, or is refused by name; help, version, lists and completion."""
import csv
import json
import os
import shutil
import subprocess
import unittest

from command_line import DAPPLE, SWEEP, CommandLine, dapple, onTerminal, program

VERBS = ["bundle", "completion", "doctor", "help", "list", "plan", "plot", "quick", "render", "run", "scene", "view"]


class Words(CommandLine):
    def test_every_word_too_many_is_refused_and_nothing_runs(self):
        out = self.folder / "out"
        for words, says in ((["rnu", "quick", "-o", out], ["'rnu'", "'run'"]),
                            (["quick", "rnu", "-o", out], ["'rnu'", "dapple quick"]),
                            (["quick", "-o", out, "plan"], ["'plan'", "dapple quick"]),
                            (["x", "run", self.sweep, "-o", out], ["'x'"]),
                            (["run", self.sweep, "twice", "-o", out], ["'twice'", "dapple run"]),
                            (["list", "scenes", "axes"], ["'axes'"]), (["doctor", "here"], ["'here'"]),
                            (["plan", self.sweep, "--axs", "size=1"], ["--axs", "--axis"])):
            self.refused(*words, says=says)
            self.assertFalse(out.exists(), words)

    def test_global_options_stand_before_or_after_the_verb(self):
        before, after = self.done("plan", self.sweep), self.done("plan", self.sweep, "--backend", "fake", call=program)
        self.assertEqual(before, after)
        self.assertIn("fake", self.done("doctor", "--backend", "fake", call=program))
        self.assertEqual(self.done("doctor"), self.done("doctor", "--backend", "fake", call=program))
        self.assertEqual(json.loads(self.done("doctor", "--json"))["timers"], {"chosen": "fake"})
        for words in (["--backend", "fka", "doctor"], ["doctor", "--backend", "fka"],
                      ["list", "axes", "--backend", "fka"]):
            self.refused(*words, says=["'fka'", "'fake'"], call=program)
        for words in (["render", "box", "uniform", "-o", self.folder / "x.png"], ["view", "box"]):
            self.refused(*words, says=["--backend fake"])

    def test_a_and_s_take_one_value_each(self):
        many = ["render", "box", "-s", "seed=2", "uniform", "many", "-o", "x.png"]
        self.refused(*many, says=["'many'"], call=program)
        for option in (["-s", "seed=2"], ["-a", "size=64"]):
            misspelt = ["render", "box", *option, "unifrom", "-o", "x.png"]
            self.refused(*misspelt, says=["technique", "'uniform'"], call=program)
        self.refused("scene", "-s", "seed=2", "bxo", says=["scene", "'box'"])
        self.assertIn("box", self.done("scene", "-s", "seed=2", "box"))

    def test_settings_reach_tables_that_the_recipe_leaves_out(self):
        def fact(name, *settings):
            words = [word for setting in settings for word in ("-s", setting)]
            lines = self.done("scene", "forest-small", *words).splitlines()
            return next(line.split(None, 1)[1] for line in lines if line.startswith(name + " "))
        self.assertEqual((fact("moving"), fact("moving", "wind.strength=0.8")), ("no", "yes"))
        self.assertNotEqual(fact("hash"), fact("hash", "clearing.0.centre=[0, 0]", "clearing.0.radius=20"))
        self.assertIn("elevation 12", fact("further sun", "further_sun.0.elevation=12"))
        self.refused("scene", "forest-small", "-s", "wnd.strength=1", says=["wnd.strength=1", "'wind'"])
        self.refused("scene", "forest-small", "-s", "wind.strnegth=1", says=["wind.strnegth=1", "'strength'"])
        self.refused("scene", "forest-small", "-s", "wind.strength=7", says=["wind.strength=7", "outside"])
        self.refused("scene", "forest-small", "-s", "clearing.3.radius=1", says=["clearing.3.radius"])

    def test_figures_have_sensible_digits(self):
        stats = self.done("scene", "city-vienna", "-s", "scale=0.02", "-s", "sun.azimuth=123.45678901234567")
        for line in stats.splitlines():
            for word in line.replace("(", " ").replace(")", " ").replace(",", " ").split():
                digits = word.strip("-").replace(".", "")
                if digits.isdigit() and "." in word:
                    self.assertLessEqual(len(digits.lstrip("0")), 10, line)

    def test_a_folder_named_like_a_sweep_or_a_scene_hides_neither(self):
        for name in ("quick", "box"):
            (self.folder / name).mkdir()
        inside = self.done("plan", "quick", cwd=self.folder)
        self.assertEqual(inside, self.done("plan", "quick", cwd="/"))
        self.assertIn("box", self.done("scene", "box", cwd=self.folder))
        (self.folder / "rotations").write_text(SWEEP)
        self.assertEqual(len(list(csv.DictReader(self.done("plan", "./rotations", cwd=self.folder).splitlines()))), 2)
        self.assertGreater(len(self.done("plan", "quick", cwd=self.folder).splitlines()), 5)
        (self.folder / "mine").mkdir()
        self.refused("plan", "mine", says=["mine is a folder"], cwd=self.folder)

    def test_filters_of_all_kinds_end_at_once(self):
        def count(*filters):
            words = [word for pattern in filters for word in ("--filter", pattern)]
            return len(self.done("plan", self.sweep, *words).splitlines()) - 1
        self.assertEqual(count("UNIFORM"), 2)
        self.assertEqual(count("size=(256|1024)"), 1)
        self.assertEqual(count("box", r"size=512\b"), 1)
        self.assertEqual(count("^box uniform.*size=[25]"), 2)
        self.assertIn(dapple("plan", self.sweep, "--filter", "(" * 60000 + ")" * 60000).returncode, (0, 2))
        for hostile in ("(((a{1000}){1000}){1000})", "(x", r"(a)\1", "(?=a)", "a" * 100000 + "[", "\udcff"):
            self.refused("plan", self.sweep, "--filter", hostile, says=["--filter"])
        for slow in ("(a*)*" * 50 + "%", "(u|u)*" * 40 + "%", "(.*)*" * 30 + "%", "(.*.*.*=)+%"):
            self.refused("plan", self.sweep, "--filter", slow, says=["no point is left"])


class Help(CommandLine):
    def test_version_and_help(self):
        self.assertRegex(self.done("--version"), r"^dapple \d+\.\d+\.\d+, commit ")
        self.assertEqual(self.done("help", "render"), self.done("render", "--help"))
        self.assertEqual(self.done("help"), self.done("--help"))
        for verb in VERBS:
            self.assertIn(verb, self.done("help"))
        self.refused("help", "rendr", says=["'rendr'", "'render'"])

    def test_help_is_wrapped_at_the_terminals_width_by_words(self):
        for columns in (44, 60, 80, 140):
            for verb in VERBS:
                code, text = onTerminal(columns, verb, "--help")
                self.assertEqual(code, 0)
                long = [line for line in text.splitlines() if len(line) > columns and len(line.split()) > 1]
                self.assertEqual(long, [], f"{verb} at {columns}")
        narrow, wide = onTerminal(44, "help")[1], onTerminal(200, "help")[1]
        self.assertEqual(narrow.split(), wide.split())
        self.assertGreater(len(narrow.splitlines()), len(wide.splitlines()))

    def test_nothing_is_coloured(self):
        for words in (["help"], ["list", "axes"], ["lst"]):
            self.assertNotIn("\x1b", onTerminal(80, *words)[1])
            self.assertNotIn("\x1b", onTerminal(80, *words, NO_COLOR="1")[1])

    def test_lists_as_json_say_what_the_tables_say(self):
        for what in ("scenes", "techniques", "axes", "metrics", "sweeps", "stress"):
            items = json.loads(self.done("list", what, "--json"))
            table = self.done("list", what)
            self.assertTrue(items)
            self.assertTrue(all(item["name"] in table for item in items))
            self.assertEqual(len({item["name"] for item in items}), len(items))
        techniques = {item["name"]: item for item in json.loads(self.done("list", "techniques", "--json"))}
        self.assertEqual(techniques["uniform"]["axes"]["fit"], "scene")


class Completion(CommandLine):
    def words(self, *words):
        return self.done("completion", "words", "--", *words).split()

    def test_what_may_stand_at_the_cursor(self):
        self.assertEqual(self.words(""), VERBS)
        self.assertEqual(self.words("pl"), ["plan", "plot"])
        self.assertIn("forest-small", self.words("render", "forest"))
        self.assertEqual(self.words("render", "box", "unif"), ["uniform"])
        self.assertEqual(self.words("render", "-a", "size=64", "box", "unif"), ["uniform"])
        self.assertIn("size=", self.words("render", "box", "uniform", "-a", ""))
        self.assertIn("filter=pcf3", self.words("render", "box", "uniform", "--axis", "filter="))
        self.assertEqual(self.words("render", "box", "uniform", "--what", "vis"), ["visibility"])
        self.assertIn("rotations", self.words("run", "ro"))
        self.assertEqual(self.words("list", "me"), ["metrics"])
        self.assertEqual(self.words("--backend", "fa"), ["fake"])
        self.assertEqual(self.words("run", "--res"), ["--resume"])
        self.assertEqual(self.words("help", "dap"), [])
        self.assertEqual(self.words("run", "quick", "-o", ""), [])
        self.refused("completion", "fsh", says=["'fish'"])

    def test_scripts_are_ones_that_their_shells_take(self):
        for shell in ("bash", "zsh", "fish"):
            script = self.folder / shell
            script.write_text(self.done("completion", shell))
            if not shutil.which(shell):
                print(f"skipped: no {shell} here")
                continue
            checked = subprocess.run([shell, "-n", script], capture_output=True, text=True)
            self.assertEqual((checked.returncode, checked.stderr), (0, ""), shell)

    def test_bash_completes(self):
        script = self.folder / "completion"
        script.write_text(self.done("completion", "bash"))
        def complete(line):
            body = (f'source {script}; COMP_LINE=$1; COMP_POINT=${{#1}}; compopt() {{ :; }}; _dapple; '
                    'printf "%s\\n" "${COMPREPLY[@]}"')
            path = f"{DAPPLE.parent}:{os.environ['PATH']}"
            done = subprocess.run(["bash", "-c", body, "bash", line], capture_output=True, text=True,
                                  env={**os.environ, "PATH": path})
            self.assertEqual(done.stderr, "")
            return done.stdout.split()
        self.assertEqual(complete("dapple ren"), ["render"])
        self.assertEqual(complete("dapple render box uniform --what vis"), ["visibility"])
        self.assertIn("pcf3", complete("dapple render box uniform -a filter="))
        self.assertEqual(complete("dapple run quick -o "), [])


if __name__ == "__main__":
    unittest.main()
