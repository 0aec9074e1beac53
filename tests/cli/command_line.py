"""Common code of the tests of the command line: the program, a folder for each test, a short scenario, checks
of a run. usage of every such test: test_*.py LAGLESS FOLDER ..."""

import os
import re
import shutil
import subprocess
import sys

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
import stuck  # noqa: E402

LAGLESS, FOLDER = os.path.abspath(sys.argv[1]), sys.argv[2]
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
NO_PICTURES = {**os.environ, "LAGLESS_PYTHON": "/bin/true"}  # no plots, whose data differ from test to test

STEP = """schema = 1
title = "a test"
[run]
duration = "%s"
[params]
position_source = "encoder"
[requests]
enable = "on"
speed_request = "300 r/min"
"""


def document(path):
    with open(os.path.join(ROOT, path), encoding="utf-8") as file:
        return file.read()


def lagless(*arguments, **settings):
    """A run of the program to its end; `settings` are those of subprocess.run."""
    settings = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **settings}
    if "input" in settings:
        del settings["stdin"]
    return subprocess.run([LAGLESS, *arguments], text=True, **settings)


# A map of one speed and one load, which takes little time.
FEW_POINTS = """schema = 1
title = "My drive"
[run]
duration = "1 s"
[requests]
speed_request = "700 r/min"
[plant]
load_torque = 3
[rig]
fidelity = "averaged"
"""


class TestCase(stuck.TestCase):
    def setUp(self):
        self.folder = os.path.join(FOLDER, "work")
        shutil.rmtree(self.folder, ignore_errors=True)
        os.makedirs(self.folder)

    def write(self, name, text):
        path = os.path.join(self.folder, name)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        return path

    def read(self, name):
        with open(os.path.join(self.folder, name), encoding="utf-8") as file:
            return file.read()

    def started(self, *arguments, **settings):
        """A running program, which ends with the test."""
        running = subprocess.Popen([LAGLESS, *arguments], **{"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, **settings})
        self.addCleanup(lambda: (running.poll() is None and running.kill(), running.communicate()))
        return running

    def serve(self, *arguments, place=r"(127\.0\.0\.1:\d+)"):
        """A running server, and the address on which it listens."""
        server = self.started("serve", *arguments)
        match = re.fullmatch(rf"listening on {place}\n", server.stdout.readline())
        self.assertTrue(match)
        return server, match[1]

    def refuses(self, *rows):
        """Each row is a command line and the texts of its message; the exit code must be 2."""
        for arguments, *fragments in rows:
            with self.subTest(arguments=arguments):
                self.expect(2, lagless(*arguments), *fragments)

    def scenario(self, *more, duration="0.2 s", name="a.toml"):
        """The file of a scenario that accelerates to 300 r/min with an encoder, with the tables `more` added."""
        return self.write(name, STEP % duration + "".join(more))

    def expect(self, code, done, *fragments):
        """Checks that a run ended with this exit code and printed these fragments, on stdout or stderr."""
        told = (done.stdout or "") + (done.stderr or "")
        self.assertEqual(code, done.returncode, told)
        for fragment in fragments:
            self.assertIn(fragment, told)
        return done
