#!/usr/bin/env python3
"""Tests tools/mutate on a tree of one source, one header and two test programs: its mutants, the verdict of each, and the inputs that the
tool refuses. An old list must find its lines in a later tree, and a weaker test must be detected. docs/building.md must have the rates
of the list. Needs Python 3.9, standard library, git, CMake and a C compiler.
"""
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import tool  # noqa: E402

ROOT = tool.ROOT
TOOL = ROOT / "tools/mutate"
mutate = tool.load("mutate")
operators = mutate.operators

SOURCE = """#include "math/part.h"

/* a > b stands in a comment. */
int part_larger(int a, int b)
{
    return a > b ? a : b;
}

int part_untested(int a)
{
    return a + 1;
}

void part_wait(volatile unsigned *n)
{
    while (*n != 0u) {
        *n -= 1u;
    }
}
"""
HEADER = """#ifndef MATH_PART_H
#define MATH_PART_H
int part_larger(int a, int b);
int part_untested(int a);
void part_wait(volatile unsigned *n);
static inline int part_sum(int a, int b)
{
    return a + b;
}
#endif
"""
STRONG = """#include "math/part.h"
int main(void)
{
    volatile unsigned n = 3u;
    part_wait(&n);
    return part_larger(1, 2) == 2 && part_larger(2, 1) == 2 && n == 0u ? 0 : 1;
}
"""
WEAK = """#include "math/part.h"
int main(void)
{
    return part_larger(1, 1) == 1 && part_sum(1, 2) == 3 ? 0 : 1;
}
"""
CMAKE = """cmake_minimum_required(VERSION 3.21)
project(small LANGUAGES C)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
enable_testing()
add_library(part STATIC firmware/math/part.c)
target_include_directories(part PUBLIC firmware)
foreach(name strong weak)
    add_executable(test_${name} tests/${name}.c)
    target_link_libraries(test_${name} part)
    add_test(NAME ${name} COMMAND test_${name})
    set_tests_properties(${name} PROPERTIES LABELS unit)
endforeach()
"""
LIST = [  # file, line, occurrence, operator, original text, mutated text, expected state, and expected test that kills the mutant
    ("firmware/math/part.c", "6", "0", "relation", "return a > b ? a : b;", "return a <= b ? a : b;", "killed", "strong"),
    ("firmware/math/part.c", "11", "0", "arithmetic", "return a + 1;", "return a - 1;", "survived", ""),
    ("firmware/math/part.c", "17", "0", "constant", "*n -= 1u;", "*n -= 0u;", "timeout", "strong"),
    ("firmware/math/part.c", "6", "0", "relation", "return a > b ? a : b;", "return (a) > b ? a : b;", "same_code", ""),
    ("firmware/math/part.c", "6", "0", "relation", "return a > b ? a : b;", "return a > c ? a : b;", "not_compiled", ""),
    ("firmware/math/part.c", "9", "0", "relation", "return a > c ? a : b;", "return a < c ? a : b;", "gone", ""),
    ("firmware/math/part.h", "8", "0", "arithmetic", "return a + b;", "return a - b;", "killed", "weak"),
]


def called(*words):
    return subprocess.run([sys.executable, "-B", TOOL, *words], capture_output=True, text=True, check=False)


class Operators(unittest.TestCase):
    def changed(self, text):
        return [(change.operator, change.mutated) for change in operators.changes_of(text)]

    def test_what_a_line_becomes(self):
        for line, wanted in (
                ("a = b;", {("statement", ";")}),
                ("x = -y;", {("sign", "x = y;"), ("statement", ";")}),
                ("const float x = a * 0.5f;", {("arithmetic", "const float x = a / 0.5f;"), ("constant", "const float x = a * 1.0f;"),
                                               ("constant", "const float x = a * 0.25f;")}),
                ("return a < b;", {("relation", "return a <= b;"), ("relation", "return a >= b;")}),
                ("if (a && !b) {", {("condition", "if (!(a && !b)) {"), ("logic", "if (a || !b) {"), ("negation", "if (a && b) {")}),
                ("return x >> 8u;", {("bits", "return x << 8u;"), ("constant", "return x >> 9u;"), ("constant", "return x >> 7u;")}),
                ("return bounds_clamp(f(a, b), most);", {("limit", "return (f(a, b));")}),
                ("return c.d;", {("axis", "return c.q;")}),
                ("#define EMF_MIN 0.5f", {("constant", "#define EMF_MIN 1.0f"), ("constant", "#define EMF_MIN 0.25f")})):
            with self.subTest(line=line):
                self.assertEqual(set(self.changed(";\n" + line + "\n}")), wanted)

    def test_text_that_is_not_code_stays(self):
        for line in ("/* a < b */", "// a < b", '#include "a/b.h"', "#if A < 2", "float x[3];", "part_t *part;", 'f("a < b, 1");'):
            with self.subTest(line=line):
                self.assertEqual([change for change in self.changed("{\n" + line + "\n}") if change[0] != "statement"], [])

    def test_a_line_is_found_though_it_has_moved_and_has_another_comment(self):
        text = "f(a);\n\n    x  = 1; /* a\n comment */\nx = 1; // the second\n"
        self.assertEqual(operators.applied(text, "x = 1;", "x = 2;", 1)[1], 5)
        changed, line = operators.applied(text, "x = 1;", "x = 2;", 0)
        self.assertEqual((line, [operators.plain(each) for each in changed.split("\n")]), (3, ["f(a);", "", "x = 2;", "", "x = 1;", ""]))
        self.assertEqual(operators.applied(text, "x = 1;", "x = 2;", 2), (None, None))


class Draw(unittest.TestCase):
    def test_each_module_has_its_share_and_a_few_at_least(self):
        wanted = mutate.shares({"a": 900, "b": 90, "c": 10}, 100)
        self.assertEqual(wanted, {"a": 90, "b": 9, "c": mutate.FEWEST})

    def test_a_seed_gives_the_same_mutants_and_another_gives_others(self):
        texts = [("firmware/math/part.c", SOURCE)]
        one, again, other = (list(mutate.shuffled(texts, seed)[1]) for seed in ("1:math", "1:math", "2:math"))
        self.assertEqual(one, again)
        self.assertNotEqual(one, other)
        self.assertEqual(sorted(one), sorted(other))


class SmallTree(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory(prefix="lagless_mutate_")
        self.tree = pathlib.Path(self.folder.name)
        for name, text in (("CMakeLists.txt", CMAKE), ("firmware/math/part.c", SOURCE), ("firmware/math/part.h", HEADER),
                           ("tests/strong.c", STRONG), ("tests/weak.c", WEAK), (".gitignore", "/build/\n")):
            self.write(name, text)
        subprocess.run(["git", "init", "-q", self.tree], check=True)

    def tearDown(self):
        self.folder.cleanup()

    def write(self, name, text):
        (self.tree / name).parent.mkdir(parents=True, exist_ok=True)
        (self.tree / name).write_text(text, encoding="utf-8")

    def judged(self, rows, *words):
        """The exit status, the output, and the result by original and mutated text."""
        listed = self.tree / "build/list.tsv"
        listed.parent.mkdir(exist_ok=True)
        mutate.write_list(listed, [mutate.Row(*row[:6]) for row in rows])
        done = called("--source", self.tree, "--list", listed, *words)
        result = {(row.original, row.mutated): row for row in mutate.read_list(self.tree / "build/mutate/result.tsv")}
        return done, result

    def test_verdicts_and_a_later_tree(self):
        done, result = self.judged(LIST)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        for row in LIST:
            found = result[row[4], row[5]]
            self.assertEqual((found.state, found.killer), row[6:], row)
        self.assertIn("| math | 3 | 4 | 75 % | 0 |", done.stdout)
        self.assertIn("firmware/math/part.c:11: arithmetic\n    - return a + 1;\n    + return a - 1;", done.stdout)

        # The lines have moved, a comment has changed, and a test no longer checks one result.
        before = self.tree / "build/before.tsv"
        (self.tree / "build/mutate/result.tsv").rename(before)
        self.write("firmware/math/part.c", "/* More is said\n * here. */\n" + SOURCE.replace("? a : b;", "? a : b; /* the larger */"))
        self.write("tests/strong.c", STRONG.replace("part_larger(1, 2) == 2 && part_larger(2, 1) == 2 && ", ""))
        done, result = self.judged(LIST[:3], "--compare", before)
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        self.assertEqual([(result[row[4], row[5]].state, result[row[4], row[5]].line) for row in LIST[:3]],
                         [("survived", "8"), ("survived", "13"), ("timeout", "19")])
        self.assertIn("WORSE: strong killed it before, and no program does now: firmware/math/part.c:8", done.stdout)
        self.assertIn("of 2 that were killed 1 survive now", done.stdout)

    def test_a_test_that_fails_without_a_mutant_is_no_judge(self):
        self.write("tests/weak.c", WEAK.replace("== 3", "== 4"))
        done = called("--source", self.tree, "--count", "3")
        self.assertEqual(done.returncode, 3)
        self.assertIn("weak fails without a mutant", done.stderr)

    def test_drawn_mutants_are_all_judged_and_an_interrupted_call_goes_on(self):
        done = called("--source", self.tree, "--count", "6")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        rows = mutate.read_list(self.tree / "build/mutate/result.tsv")
        self.assertEqual(len(rows), 6)
        self.assertLessEqual({row.state for row in rows}, set(mutate.COUNTED))
        again = called("--source", self.tree, "--count", "6")
        self.assertIn("6 mutants are judged already", again.stdout)


class WrongUse(unittest.TestCase):
    def test_mistakes_are_reported(self):
        for words, text in ((["nowhere"], "no module: nowhere; there are app, contract"), (["--count", "0"], "--count must be above 0"),
                            (["--list", "nowhere.tsv"], "nowhere.tsv: No such file"), (["--list", __file__], "is no list of mutants"),
                            (["--again", "--list", "x"], "without these"), (["--accept", "math"], "all modules"),
                            (["--whatever"], "unrecognized arguments: --whatever")):
            with self.subTest(words=words):
                done = called(*words)
                self.assertEqual(done.returncode, 2)
                self.assertIn(text, done.stderr)


class Lists(unittest.TestCase):
    """A mutant whose statement does not exist any more proves nothing. None of the mutants that survived before may be absent, and at most
    a tenth of the drawn ones."""

    def gone(self, name):
        rows = mutate.read_list(ROOT / "tools/mutation" / name)
        texts = {row.file: (ROOT / row.file).read_text(encoding="utf-8") if (ROOT / row.file).exists() else "" for row in rows}
        found = [f"{row.file}:{row.line}: {row.original}" for row in rows
                 if operators.applied(texts[row.file], row.original, row.mutated, int(row.occurrence))[0] is None]
        return found, len(rows)

    def test_the_statements_of_the_lists_are_in_the_present_tree(self):
        for name, share in (("reported.tsv", 0.0), ("mutants.tsv", 0.1)):
            gone, rows = self.gone(name)
            self.assertLessEqual(len(gone), share * rows, f"{name}: the statements have moved or changed; write the present ones:\n" + "\n".join(gone))


class Documents(unittest.TestCase):
    def test_the_rates_are_those_of_the_list(self):
        done = called("--documents")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_other_rates_are_seen(self):
        with tempfile.TemporaryDirectory() as folder:
            tree = pathlib.Path(folder)
            (tree / "docs").mkdir()
            (tree / "tools/mutation").mkdir(parents=True)
            mutate.write_list(tree / "tools/mutation/mutants.tsv", [mutate.Row(*row[:8]) for row in LIST])
            (tree / "docs/building.md").write_text("<!-- begin: written by tools/mutate --accept -->\n| nothing |\n<!-- end: tools/mutate -->\n",
                                                   encoding="utf-8")
            done = called("--documents", "--source", tree)
            self.assertEqual(done.returncode, 1)
            self.assertIn("has other rates", done.stdout)


if __name__ == "__main__":
    unittest.main()
