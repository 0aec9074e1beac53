#!/usr/bin/env python3
"""Each of the paper's equations that the firmware computes is in one float function: the table of docs/paper.md names that function, its
comment contains `eq. (n)`, and the comment of no other float function does. A plain (n) is a mere mention.

usage: test_equations.py [unittest options]        Python 3.9, standard library only
"""
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
EQUATIONS = {5, 11, 12, 14, 15, 16, 17, 18, 19, 22}

COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)
HIDDEN = re.compile(r"//[^\n]*|/\*.*?\*/|^[ \t]*#(?:\\\n|[^\n])*|\"(?:\\.|[^\"\\\n])*\"", re.DOTALL | re.MULTILINE)
FUNCTION = re.compile(r"^(?:[A-Za-z_][\w *]*[ *])??(\w+)\([^;{}]*\)\s*([;{])", re.MULTILINE)
NUMBERS = r"\(\d+\)(?:\s*-\s*\(\d+\))?"
CLAIM = re.compile(rf"\b[Ee]qs?\.[\s*]+({NUMBERS}(?:(?:,|[\s*]+and)[\s*]+{NUMBERS})*)")
ROW = re.compile(r"^\| \**(\(\d+\)[^|]*)\| ([^|]*) \|$", re.MULTILINE)
PLACE = re.compile(r"`(firmware/[\w/.]+)`: `(\w+)\(\)`")


def numbers_of(text):
    """(5), (15) - (17) -> {5, 15, 16, 17}"""
    found = set()
    for first, last in re.findall(r"\((\d+)\)(?:\s*-\s*\((\d+)\))?", text):
        found |= set(range(int(first), int(last or first) + 1))
    return found


def functions_of(text):
    """For every function declared or defined in a C text: name, whether it is defined in this text, and the equations that its comments
    claim."""
    code = HIDDEN.sub(lambda match: re.sub(r"[^\n]", " ", match.group()), text)
    comments = [(m.start(), m.end(), m.group()) for m in COMMENT.finditer(text)]
    end, found = 0, []
    for match in FUNCTION.finditer(code):
        if match.start() < end:
            continue  # this match is inside the previous function
        end = match.end()
        depth = 1 if match.group(2) == "{" else 0
        while depth and end < len(code):
            depth += {"{": 1, "}": -1}.get(code[end], 0)
            end += 1
        own = [what for start, stop, what in comments
               if match.start() <= start < end or stop <= match.start() and not text[stop:match.start()].strip()]
        claims = set()
        for what in own:
            for claim in CLAIM.findall(what):
                claims |= numbers_of(claim)
        found.append((match.group(1), match.group(2) == "{", claims))
    return found


def float_sources():
    for path in sorted((ROOT / "firmware").rglob("*.[ch]")):
        name = path.relative_to(ROOT).as_posix()
        if not name.startswith("firmware/estimator/fixed/") and not path.stem.endswith("_q"):
            yield name, path.read_text(encoding="utf-8")


def table_of(text):
    """{equation: [(file, function)]} of the table below its heading row."""
    rows = text.partition("| equation | where |\n")[2].partition("\n\n")[0]
    places = {}
    for equations, where in ROW.findall(rows):
        for number in numbers_of(equations.partition(" with")[0].partition(", with")[0]):
            places.setdefault(number, []).extend(PLACE.findall(where))
    return places


class Equations(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.table = table_of((ROOT / "docs/paper.md").read_text(encoding="utf-8"))
        cls.defined, cls.claimed = set(), {}
        for path, text in float_sources():
            for name, is_defined, claims in functions_of(text):
                if is_defined:
                    cls.defined.add((path, name))
                for number in claims:
                    cls.claimed.setdefault(number, set()).add(name)

    def test_table_has_each_equation_and_one_function_for_it(self):
        self.assertEqual(set(self.table), EQUATIONS)
        for number, places in self.table.items():
            self.assertEqual(len(places), 1, f"({number}): {places}")

    def test_function_is_defined_in_the_file(self):
        for number, places in self.table.items():
            self.assertTrue(places[0] in self.defined, f"({number}): {places[0]}")

    def test_its_comment_claims_the_equation_and_no_other_does(self):
        for number, places in self.table.items():
            self.assertEqual(self.claimed.get(number), {places[0][1]}, f"({number})")


if __name__ == "__main__":
    unittest.main()
