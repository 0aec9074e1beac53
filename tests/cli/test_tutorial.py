"""docs/first_hour.md, step by step. The files of the page are written and its commands run in their order in one folder. Each line of
output that the page shows must be printed: the words exactly, the numbers within a tenth, since times and noise change.

usage: test_tutorial.py LAGLESS FOLDER"""

import importlib.util
import re
import shlex
import subprocess
import unittest

from command_line import LAGLESS, TestCase, document

PAGE = document("docs/first_hour.md")
NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w.])")
EXIT_CODES = {"compare runs/my/my.csv runs/my_2/my.csv --plot": 1, "run my.toml --set motor_resistence=1.5": 2, "run broken.toml": 1}
TIMES = re.compile(r"simulated in \S+ s \(\S+ x real time\)")


def blocks():
    """The indented blocks of the page, without the indentation."""
    return [re.sub(r"(?m)^    ", "", block).rstrip() for block in re.findall(r"(?m)(?:^    .*\n)+", PAGE)]


def same(shown, printed):
    """Two lines are the same if the words are equal and the numbers agree within a tenth or within 0.01."""
    shown, printed = TIMES.sub("", shown), TIMES.sub("", printed)
    if NUMBER.sub("#", shown) != NUMBER.sub("#", printed):
        return False
    pairs = zip(map(float, NUMBER.findall(shown)), map(float, NUMBER.findall(printed)))
    return all(abs(a - b) <= 0.1 * abs(a) + 0.01 for a, b in pairs)


class Tutorial(TestCase):
    def shows(self, command, shown, printed):
        for line in shown.splitlines():
            if line != "...":
                self.assertTrue(any(same(line, one) for one in printed.splitlines()), f"{command}\nshows   {line}\nprinted\n{printed}")

    def run_live(self, command, shown):
        """Runs `serve` and `scope` until they are stopped, with the ports and the token that they choose."""
        if command[0] == "serve":
            _, self.target = self.serve(*[f"{self.folder}/{word}" if word.endswith(".toml") else word for word in command[1:]], "--port", "0")
            self.assertEqual("listening on 127.0.0.1:5555", shown)
            return
        self.assertEqual(["scope", "tcp://127.0.0.1:5555"], command)
        scope = self.started("scope", "tcp://" + self.target, "--http", "0", "--no-browser")
        printed = scope.stdout.readline().rstrip()
        self.assertEqual(re.sub(r":\d+/[0-9a-f]+/", ":PORT/TOKEN/", shown.replace("127.0.0.1:5555", self.target)),
                         re.sub(r":\d+/[0-9a-f]+/", ":PORT/TOKEN/", printed))

    @unittest.skipIf(importlib.util.find_spec("numpy") is None, "no numpy: tools/setup demo")
    def test_each_step_does_what_the_page_shows(self):
        ran = []
        for block in blocks():
            head, _, shown = block.partition("\n")
            if head.startswith("# append to "):
                with open(f"{self.folder}/{head[12:]}", "a", encoding="utf-8") as file:
                    file.write("\n" + shown + "\n")
            elif re.fullmatch(r"# \w+\.toml", head):
                self.write(head[2:], shown + "\n")
            elif head.startswith("$ build/host/lagless "):
                command = shlex.split(head.replace("$ build/host/lagless ", ""))
                ran.append(command[0])
                if command[0] in ("serve", "scope"):
                    self.run_live(command, shown)
                    continue
                done = subprocess.run([LAGLESS, *command], cwd=self.folder, stdout=subprocess.PIPE,
                                      stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, text=True, timeout=120)
                self.assertEqual(EXIT_CODES.get(" ".join(command), 0), done.returncode, f"{command}\n{done.stdout}")
                self.shows(command, shown, done.stdout)
            elif head.startswith("$ "):
                subprocess.run(shlex.split(head[2:]), cwd=self.folder, check=True)
        self.assertEqual(["--version", "run", "tune", "run", "run", "compare", "run", "serve", "scope", "run", "explain"], ran)


if __name__ == "__main__":
    unittest.main(argv=["test_tutorial.py"], verbosity=2)
