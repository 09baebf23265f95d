"""The window, on a virtual display: keys pressed during slow frames count, a resized one keeps the picture's aspect."""
import json
import os
import re
import shutil
import struct
import subprocess
import time
import unittest

from command_line import DAPPLE, CommandLine, program

TOOLS = [tool for tool in ("Xvfb", "xdotool") if not shutil.which(tool)]  # Debian's xvfb and xdotool
if TOOLS:
    print(f"skipped: no {' and no '.join(TOOLS)} here")


@unittest.skipIf(TOOLS, f"no {' and no '.join(TOOLS)} here")
class View(CommandLine):
    def setUp(self):
        super().setUp()
        self.screen = self.folder / "Xvfb_screen0"
        ours, theirs = os.pipe()
        server = subprocess.Popen(["Xvfb", "-displayfd", str(theirs), "-noreset", "-screen", "0", "1200x900x24",
                                   "-fbdir", self.folder], pass_fds=[theirs],
                                  stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(theirs)
        self.addCleanup(server.wait)
        self.addCleanup(server.terminate)
        with os.fdopen(ours) as number:  # to its end of line: the server writes that later
            self.display = {**os.environ, "DISPLAY": ":" + number.readline().strip()}

    def view(self, *words):
        process = subprocess.Popen([DAPPLE, "view", *words], env=self.display, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        self.process = process
        for _ in range(600):
            found = self.x("search", "--name", "swap").split()
            if found or process.poll() is not None:
                break
            time.sleep(0.1)
        if not found:
            _, said = process.communicate()
            self.assertIn("no OpenGL 4.5 window", said)
            self.skipTest(said)
        self.window = found[0]
        self.x("windowfocus", self.window)
        return process

    def x(self, *words):
        return subprocess.run(["xdotool", *words], env=self.display, capture_output=True, text=True).stdout

    def title(self):
        """(scene, technique, view, ms of the last frame)."""
        parts = self.x("getwindowname", self.window).split(" | ")
        return (*parts[:3], float(parts[3].split()[0]))

    def becomes(self, part, wanted, seconds=60):
        for _ in range(10 * seconds):
            if self.title()[part] == wanted:
                return
            time.sleep(0.1)
        self.assertEqual(self.title()[part], wanted)

    def test_keys_during_slow_frames_count_each(self):
        techniques = [item["name"] for item in json.loads(self.done("list", "techniques", "--json", call=program))]
        self.view("forest-small", "unshadowed", "-r", "1100x850")
        first = techniques.index("unshadowed")
        self.becomes(1, "unshadowed")
        # Down and up between two frames: xdotool waits 12 ms between its keys.
        self.x("key", "n", "n", "n")
        self.becomes(1, techniques[first + 3])
        self.x("key", "p")
        self.becomes(1, techniques[first + 2])
        views = re.findall(r"^view +(\S+):", self.done("scene", "forest-small", call=program), re.M)
        self.x("key", "Tab", "Tab")
        self.becomes(2, views[2 % len(views)])
        self.x("key", "Escape")
        self.assertEqual(self.process.wait(timeout=60), 0)

    def pixels(self):
        """Rows of the screen, four bytes a pixel; XWD as X11/XWDFile.h has it."""
        data = self.screen.read_bytes()
        header = struct.unpack(">25I", data[:100])
        width, height, stride, colours = header[4], header[5], header[12], header[19]
        start = header[0] + 12 * colours
        return [data[start + y * stride:start + y * stride + 4 * width] for y in range(height)]

    def picture(self):
        """Columns and rows of the window, placed at the screen's corner, that are not black: (x0, x1, y0, y1)."""
        rows = self.pixels()
        drawn = lambda x, y: any(rows[y][4 * x:4 * x + 3])
        lit = [y for y in range(len(rows)) if any(drawn(x, y) for x in range(0, len(rows[0]) // 4, 3))]
        columns = [x for x in range(len(rows[0]) // 4) if any(drawn(x, y) for y in lit[::7])]
        return columns[0], columns[-1] + 1, lit[0], lit[-1] + 1

    def test_a_resized_window_keeps_the_aspect(self):
        self.view("box", "uniform", "-a", "size=64", "-s", "sun.elevation=50", "-r", "400x300")
        for width, height in ((800, 300), (300, 800), (640, 480), (1000, 200)):
            self.x("windowmove", self.window, "0", "0")
            self.x("windowsize", self.window, str(width), str(height))
            scale = min(width / 400, height / 300)
            wide, high = 400 * scale, 300 * scale
            expected = [(width - wide) / 2, (width + wide) / 2, (height - high) / 2, (height + high) / 2]
            for _ in range(100):
                found = self.picture()
                if all(abs(a - b) <= 3 for a, b in zip(found, expected)):
                    break
                time.sleep(0.1)
            self.assertTrue(all(abs(a - b) <= 3 for a, b in zip(found, expected)), (width, height, found, expected))

    def test_options_choose_scene_view_and_technique(self):
        self.view("forest-small", "lispsm", "--view", "walk1", "-a", "size=128", "-s", "wind.strength=0.5",
                  "-r", "160x120")
        self.assertEqual(self.title()[:3], ("forest-small", "lispsm", "walk1"))
        geometry = self.x("getwindowgeometry", self.window)
        self.assertIn("160x120", geometry)
        self.assertEqual(program("view", "box", "--frames", "2", "-r", "64x48", env=self.display).returncode, 0)

    def test_refusals(self):
        for words, says in ((["unifrom"], "'uniform'"), (["uniform", "-a", "siz=3"], "'size'"),
                            (["uniform", "-r", "3"], "WIDTHxHEIGHT"), (["uniform", "--view", "x"], "'x'"),
                            (["uniform", "-s", "sede=3"], "'seed'")):
            self.refused("view", "box", *words, says=[says], call=program, env=self.display)


if __name__ == "__main__":
    unittest.main()
