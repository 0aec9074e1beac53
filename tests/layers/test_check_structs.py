#!/usr/bin/env python3
"""check_structs.py on trees that break one of its rules, which must be named, and on what is allowed."""
import contextlib
import io
import pathlib
import tempfile
import unittest

import check_structs

MANY = "".join(f"    float f{n};\n" for n in range(26))


NAMES = ", ".join(f"f{n}" for n in range(26))

# Files of firmware/, and what is told of them.
TREES = (
    ({"a.h": "\n/* one; two; */\ntypedef struct {\n" + MANY + "} a_t;\n"}, "firmware/a.h:3: struct: has 26 fields; 25 at most"),
    ({"a.h": "typedef struct {\n" + MANY.replace("    float f25;\n", "") + "} a_t;\n"}, "no struct of more than 25 fields"),
    # fields of a struct within do not count, each name of a declaration does, rows of a table are none
    ({"a.h": "struct a {\n    struct {\n" + MANY[:-13] + "    } inner;\n    float x, y;\n};\n"}, "no struct"),
    ({"a.h": "struct a {\n    float " + NAMES + ";\n};\n"}, "has 26 fields"),
    ({"a.h": "#define FIELD(n) float f##n;\ntypedef struct {\n    ROWS(FIELD, FIELD)\n} a_t;\n"}, "no struct"),
    ({"math/a.h": '#include "math/b.h"\n', "math/b.h": '#include "math/c.h"\n', "math/c.h": '#include "math/a.h"\n#include <stdint.h>\n'},
     "circle: firmware/math/a.h -> firmware/math/b.h -> firmware/math/c.h -> firmware/math/a.h: these include each other"),
    ({"a.c": '#include "b.h"\n#include "c.h"\n', "b.h": '#include "c.h"\n', "c.h": ""}, "no circle"),
    ({"a.c": "int f(int n)\n{\n    return n % DRIVE_WINDOW; /* % LOOK_SLOT */\n}\n"}, "firmware/a.c:3: slot: % DRIVE_WINDOW"),
)


class Structs(unittest.TestCase):
    def test_each_tree_is_told_of_as_it_is(self):
        for files, text in TREES:
            with self.subTest(text), tempfile.TemporaryDirectory() as root:
                for name, contents in files.items():
                    path = pathlib.Path(root) / "firmware" / name
                    path.parent.mkdir(parents=True, exist_ok=True)
                    path.write_text(contents, encoding="utf-8")
                out = io.StringIO()
                with contextlib.redirect_stdout(out):
                    status = check_structs.main(["--root", root])
                told = out.getvalue()
                self.assertIn(text, told)
                self.assertEqual((status, told.count("\n")), (0 if "check_structs" in told else 1, 1), told)


if __name__ == "__main__":
    unittest.main()
