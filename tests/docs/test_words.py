#!/usr/bin/env python3
"""No text uses a phrase of the word list in docs/style.md. Checked are README.md and docs, help texts and messages of the program,
comments of C sources and headers of firmware, hal, host_sim and tests, the texts of the tests, and strings and comments of the Python programs of
tools, tests and host_sim; NOT_YET names the areas that still have such phrases. Python 3.9, standard library.

usage: test_words.py
"""
import io
import pathlib
import re
import tokenize
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
STYLE = "docs/style.md"  # quotes the phrases that it bans

# Folders whose comments still have such phrases, with the reason. A folder whose comments have none must leave this table.
NOT_YET = {}
LITERAL = re.compile(r'"((?:[^"\\\n]|\\.)*)"')
C_COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)
GENERATED = re.compile(r"<!-- (?:begin: written by|made by).*?<!-- end.*?-->", re.DOTALL)


def phrases():
    """The phrases of the table in docs/style.md, each as an expression and whether it is checked in comments too."""
    found = []
    for line in (ROOT / STYLE).read_text(encoding="utf-8").splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if line.startswith("|") and cells[-1] in ("everywhere", "texts"):
            found += [(re.compile(r"\b" + r"\s+".join(map(re.escape, phrase.split())) + r"\b", re.IGNORECASE),
                       cells[-1] == "everywhere") for phrase in cells[0].split(", ")]
    return found


def without_generated(text):
    """The text with the same number of lines, in which the parts written by a tool are empty."""
    return GENERATED.sub(lambda block: "\n" * block.group().count("\n"), text)


def without_c_comments(text):
    return C_COMMENT.sub(lambda comment: "\n" * comment.group().count("\n"), LITERAL.sub(
        lambda literal: literal.group().replace("/*", "  ").replace("//", "  "), text))


def messages(text):
    """The string literals of a C source, on their lines; neighbouring literals are joined as the compiler does."""
    lines = []
    for line in without_c_comments(text).splitlines():
        lines.append(" ".join(LITERAL.findall(line)) if not line.startswith("#include") else "")
    return re.sub(r"\\n", "  ", "\n".join(lines))


def comments(text):
    """The comments of a C source, on their lines, without the stars at the begin of a line."""
    kept, end = [], 0
    for comment in C_COMMENT.finditer(text):
        kept.append("\n" * text.count("\n", end, comment.start()) + re.sub(r"(?m)^\s*\* ?", "", comment.group()))
        end = comment.end()
    return "".join(kept)


# A name in a text is no phrase: an identifier between backquotes, in a replacement field of an f-string, or as a whole string.
NAMES = re.compile(r"`[^`\n]*`|\{[^{}\n]*\}|(?<=[\"'])[\w.]+(?=[\"'])")


def python_texts(text):
    """The strings and comments of a Python program, on their lines, without names."""
    lines = [""] * (text.count("\n") + 2)
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type in (tokenize.COMMENT, tokenize.STRING) or tokenize.tok_name[token.type] == "FSTRING_MIDDLE":
            for number, line in enumerate(token.string.split("\n"), token.start[0] - 1):
                lines[number] += " " + line
    return NAMES.sub(" ", re.sub(r"\\n", "  ", "\n".join(lines)))


def is_python(path):
    with path.open("rb") as file:
        return path.suffix == ".py" or (path.suffix == "" and b"python3" in file.readline())


def breaches(text, banned, comment=False):
    return [f"{text.count(chr(10), 0, match.start()) + 1}: {' '.join(match.group().split())}"
            for expression, everywhere in banned if everywhere or not comment for match in expression.finditer(text)]


def area(path):
    name = path.relative_to(ROOT).as_posix()
    return next((area for area in NOT_YET if name == area or name.startswith(area + "/")), None)


def of_documents():
    for path in [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]:
        if path.relative_to(ROOT).as_posix() != STYLE:
            yield path, without_generated(path.read_text(encoding="utf-8")), False


def of_messages():
    for folder in ("host_sim/cli", "host_sim/lab", "host_sim/line", "host_sim/rig", "host_sim/plant", "host_sim/scope", "host_sim/fmu", "host_sim/python", "hal", "firmware/drive",
                   "firmware/app", "firmware/settings"):
        for path in sorted((ROOT / folder).glob("*.[ch]")):
            yield path, messages(path.read_text(encoding="utf-8")), False
    for path in (*sorted((ROOT / "host_sim/scope/page").glob("*.html")), *sorted((ROOT / "tools/plot/page").glob("*.html"))):
        yield path, path.read_text(encoding="utf-8"), False


def of_comments():
    for folder in ("firmware", "hal", "host_sim", "tests"):
        for path in sorted((ROOT / folder).rglob("*.[ch]")):
            yield path, comments(path.read_text(encoding="utf-8")), True


def of_tests():
    for path in sorted((ROOT / "tests").rglob("*.[ch]")):
        text = re.sub(r'grid_of\("[^"]*"', "grid_of(", path.read_text(encoding="utf-8"))  # an id: it selects the points of the grid
        yield path, messages(text), False


def of_python():
    for folder in ("tests", "tools", "host_sim"):
        for path in sorted((ROOT / folder).rglob("*")):
            if path.is_file() and path != pathlib.Path(__file__).resolve() and is_python(path):
                yield path, python_texts(path.read_text(encoding="utf-8")), False


class Words(unittest.TestCase):
    def setUp(self):
        self.banned = phrases()
        self.assertGreater(len(self.banned), 15)

    def judge(self, texts):
        found = [f"{path.relative_to(ROOT)}:{breach}" for path, text, comment in texts if not comment or area(path) is None
                 for breach in breaches(text, self.banned, comment)]
        self.assertFalse(found, "\n" + "\n".join(found) + f"\nthese phrases are in the list of {STYLE}, which has what to write instead")

    def test_documents(self):
        self.judge(of_documents())

    def test_help_and_messages(self):
        self.judge(of_messages())

    def test_comments_of_sources_and_headers(self):
        self.judge(of_comments())

    def test_messages_of_tests(self):
        self.judge(of_tests())

    def test_strings_and_comments_of_python_programs(self):
        self.judge(of_python())

    def test_a_phrase_is_found_in_each_kind_of_text(self):
        source = 'static int a; /* this is told */\nint f(void) { return g("who wants it\\n"); }\n'
        self.assertEqual(["1: is told", "1: told"], breaches(comments(source), self.banned, True))
        self.assertEqual(["2: wants"], breaches(messages(source), self.banned))
        program = "told = 1  # somebody\nprint(f'the desk {told}', 'told')\nx = '`told`'\n"
        self.assertEqual(["1: somebody", "2: the desk"], sorted(breaches(python_texts(program), self.banned)))

    def test_an_area_that_is_clean_leaves_the_list(self):
        left = {area(path) for path, text, comment in of_comments() if area(path) and breaches(text, self.banned, comment)}
        self.assertEqual(set(NOT_YET), left)


if __name__ == "__main__":
    unittest.main()
