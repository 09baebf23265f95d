"""What the tests of the command line share: the program, run with the fake back-end, and how a refusal looks."""
import fcntl
import os
import pty
import struct
import subprocess
import sys
import tempfile
import termios
import unittest
from pathlib import Path

DAPPLE = Path(sys.argv.pop(1)).resolve()
SWEEP = """question = "?"
scenes = ["box"]
[[technique]]
name = "uniform"
size = [256, 512]
"""


def program(*words, **options):
    return subprocess.run([DAPPLE, *map(str, words)], capture_output=True, text=True, errors="replace", timeout=300,
                          **options)


def dapple(*words, **options):
    return program("--backend", "fake", *words, **options)


def hasGl():
    return program("doctor", "--json").returncode in (0, 5)


def onTerminal(columns, *words, enough=lambda text: False, **environment):
    """(exit code, all that a terminal of so many columns got); the program is ended once that is `enough`."""
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
    process = subprocess.Popen([DAPPLE, *map(str, words)], stdin=theirs, stdout=theirs, stderr=theirs,
                               env={**os.environ, "TERM": "xterm", **environment})
    os.close(theirs)
    text = b""
    while True:
        try:
            read = os.read(ours, 65536)
        except OSError:  # the program has closed its end
            break
        if not read:
            break
        text += read
        if enough(text):
            process.terminate()
            break
    os.close(ours)
    return process.wait(timeout=60), text.decode().replace("\r\n", "\n")


class CommandLine(unittest.TestCase):
    def setUp(self):
        keep = tempfile.TemporaryDirectory()
        self.addCleanup(keep.cleanup)
        self.folder = Path(keep.name)
        self.sweep = self.folder / "small.toml"
        self.sweep.write_text(SWEEP)

    def refused(self, *words, says, code=2, call=dapple, **options):
        """One line on stderr that holds the texts, nothing on stdout."""
        done = call(*words, **options)
        self.assertEqual(done.returncode, code, done.stderr)
        self.assertEqual(done.stdout, "")
        self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
        self.assertTrue(done.stderr.startswith("dapple: "), done.stderr)
        for text in says:
            self.assertIn(text, done.stderr)

    def done(self, *words, call=dapple, **options):
        """What it printed on stdout; it must succeed."""
        done = call(*words, **options)
        self.assertEqual(done.returncode, 0, f"{words}: {done.stderr}")
        return done.stdout
