#!/usr/bin/env python3
"""Each tool in Python answers --help with its usage, exit code 0 and no output on stderr, and has no other effect. Python 3.9, standard
library only."""
import pathlib
import subprocess
import sys
import unittest

TOOLS = pathlib.Path(__file__).resolve().parents[2] / "tools"


class Help(unittest.TestCase):
    def test_each_tool_answers_help(self):
        tools = [path for path in sorted(TOOLS.iterdir()) if path.is_file() and path.read_bytes().startswith(b"#!/usr/bin/env python3")]
        self.assertGreater(len(tools), 20)
        for tool in tools:
            with self.subTest(tool=tool.name):
                done = subprocess.run([sys.executable, "-B", tool, "--help"], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                      text=True, timeout=60, check=False)
                self.assertEqual((done.returncode, done.stderr), (0, ""))
                self.assertIn("usage", done.stdout)


if __name__ == "__main__":
    unittest.main()
