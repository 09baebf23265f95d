"""The line of progress: it fits the terminal, names what varies, and comes at once where nobody can see a bar."""
import re
import subprocess
import time
import unittest

from command_line import DAPPLE, CommandLine, dapple, onTerminal

LONG = """question = "?"
scenes = ["box"]
[sampling]
min_blocks = {blocks}
max_blocks = {blocks}
timeout_s = 9000
budget_s = 1e8
[[technique]]
name = "instanced"
size = [64, 128]
"""


class Progress(CommandLine):
    def long(self, blocks):
        self.sweep.write_text(LONG.format(blocks=blocks))
        return ("--backend", "fake", "run", self.sweep, "-o", self.folder / f"out{time.monotonic_ns()}")

    def test_fits_the_terminal_and_names_what_varies(self):
        for columns in (40, 72, 200):
            _, text = onTerminal(columns, *self.long(1000), enough=lambda text: text.count(b"\r") > 8)
            shown = [line for line in re.split(r"\r?\x1b\[K|\n", text) if line.startswith("run")]
            self.assertGreater(len(shown), 3, text)
            self.assertLess(max(map(len, shown)), columns)
            self.assertTrue(any("/100" in line for line in shown))
            if columns == 200:
                self.assertTrue(all(re.search(r"  box instanced size=(64|128)$", line) for line in shown), shown)

    def test_a_terminal_that_cannot_redraw_gets_plain_lines(self):
        code, text = onTerminal(80, *self.long(10), TERM="dumb")
        self.assertEqual(code, 0)
        self.assertNotIn("\x1b", text)
        self.assertIn("run (%): 0/100, 0:00 elapsed", text)

    def test_elsewhere_a_first_line_comes_at_once(self):
        process = subprocess.Popen([DAPPLE, *map(str, self.long(1000))], stdout=subprocess.DEVNULL,
                                   stderr=subprocess.PIPE, text=True)
        first = process.stderr.readline()
        self.assertIsNone(process.poll())
        self.assertRegex(first, r"^run \(%\): 0/100, 0:0\d elapsed, \? left  box instanced size=64\n$")
        process.kill()
        process.wait()
        process.stderr.close()
        quick = dapple(*self.long(5)[2:])
        self.assertEqual(len([line for line in quick.stderr.splitlines() if line.startswith("run")]), 1, quick.stderr)


if __name__ == "__main__":
    unittest.main()
