#!/usr/bin/env python3
"""check_structs.py on trees that break one of its rules, which must be named, and on what is allowed."""
import contextlib
import io
import pathlib
import tempfile
import unittest

import check_structs

MANY = "".join(f"    float f{n};\n" for n in range(26))


class Structs(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.root = pathlib.Path(temporary.name)

    def write(self, name, text):
        path = self.root / "firmware" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")

    def told(self):
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            status = check_structs.main(["--root", str(self.root)])
        self.assertEqual(status, 1 if "check_structs" not in out.getvalue() else 0)
        return out.getvalue()

    def test_a_struct_of_26_fields_is_named_and_one_of_25_is_not(self):
        self.write("a.h", "\n/* one; two; */\ntypedef struct {\n" + MANY + "} a_t;\n")
        self.assertIn("firmware/a.h:3: struct: has 26 fields; 25 at most", self.told())
        self.write("a.h", "typedef struct {\n" + MANY.replace("    float f25;\n", "") + "} a_t;\n")
        self.assertIn("no struct of more than 25 fields", self.told())

    def test_each_name_of_a_declaration_counts_and_the_fields_of_a_struct_within_do_not(self):
        self.write("a.h", "struct a {\n    struct {\n" + MANY[:-13] + "    } inner;\n    float x, y;\n};\n")
        self.assertIn("no struct", self.told())
        self.write("a.h", "struct a {\n    float " + ", ".join(f"f{n}" for n in range(26)) + ";\n};\n")
        self.assertIn("has 26 fields", self.told())

    def test_rows_of_a_table_are_no_fields(self):
        self.write("a.h", "#define FIELD(n) float f##n;\ntypedef struct {\n    ROWS(FIELD, FIELD)\n} a_t;\n")
        self.assertIn("no struct", self.told())

    def test_a_circle_of_includes_is_named_once(self):
        self.write("math/a.h", '#include "math/b.h"\n')
        self.write("math/b.h", '#include "math/c.h"\n')
        self.write("math/c.h", '#include "math/a.h"\n#include <stdint.h>\n')
        told = self.told()
        self.assertIn("circle: firmware/math/a.h -> firmware/math/b.h -> firmware/math/c.h -> firmware/math/a.h: these include each other", told)
        self.assertEqual(told.count("circle:"), 1)

    def test_a_file_that_two_include_is_no_circle(self):
        self.write("a.c", '#include "b.h"\n#include "c.h"\n')
        self.write("b.h", '#include "c.h"\n')
        self.write("c.h", "")
        self.assertIn("no circle", self.told())

    def test_a_schedule_by_a_remainder_is_named(self):
        self.write("a.c", "int f(int n)\n{\n    return n % DRIVE_WINDOW; /* % LOOK_SLOT */\n}\n")
        self.assertIn("firmware/a.c:3: slot: % DRIVE_WINDOW", self.told())


if __name__ == "__main__":
    unittest.main()
