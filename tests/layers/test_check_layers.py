#!/usr/bin/env python3
"""Proves tools/check-layers. A small tree that keeps every rule passes. If one rule is broken, the check fails, and the message names file,
line and rule. CC, AR and NM choose the tools."""
import contextlib
import io
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import tool  # noqa: E402

check_layers = tool.load("check-layers")

CC = os.environ.get("CC") or "cc"
AR = os.environ.get("AR") or "ar"
NM = os.environ.get("NM") or "nm"

TREE = {
    "firmware/math/angle.h": "float angle_wrap(float x);\n",
    "firmware/math/angle.c": (
        '#include "math/angle.h"\n'
        "#include <math.h>\n"
        "/* a double in a comment, sin(x) and 1.0 too */\n"
        "static const char *const names[] = {\"double\", \"uint8_t 1.0\"};\n"
        "float angle_wrap(float x)\n"
        "{\n"
        "    return x < 0.0f ? sqrtf(1.0e3f) : (float)names[x > 1.0f][0];\n"
        "}\n"
    ),
    "firmware/contract/table.h": "float table_get(float x);\n",
    "firmware/contract/table.c": '#include "contract/table.h"\n#include "math/angle.h"\n'
    "float table_get(float x)\n{\n    return angle_wrap(x);\n}\n",
    "firmware/estimator/smo.h": "float smo_step(float x);\n",
    "firmware/estimator/smo.c": '#include "estimator/smo.h"\n#include "contract/table.h"\n#include "math/angle.h"\n'
    "float smo_step(float x)\n{\n    return angle_wrap(x);\n}\n",
    "firmware/fast/inverter/svpwm.h": "float svpwm(float x);\n",
    "firmware/fast/inverter/svpwm.c": '#include "fast/inverter/svpwm.h"\nfloat svpwm(float x)\n{\n    return x;\n}\n',
    "firmware/drive/drive.h": "float drive_step(float x);\n",
    "firmware/drive/drive.c": '#include "drive.h"\n#include "estimator/smo.h"\n#include "fast/inverter/svpwm.h"\n'
    "float drive_step(float x)\n{\n    return svpwm(smo_step(x));\n}\n",
    "firmware/app/app.c": '#include "drive/drive.h"\n#include "hal/hal.h"\nfloat app_run(void);\n'
    "struct { float x; } app;\n"
    "float app_run(void)\n{\n    hal_write((int)drive_step(app.x));\n    return app.x;\n}\n",
    "hal/hal.h": "void hal_write(int x);\n",
    "hal/f28335/bus.h": '#include "hal/f28335/registers.h"\nvoid bus_write16(int x);\n',
    "hal/f28335/registers.h": "#include <stdint.h>\n",
    "hal/f28335/pwm.c": '#include "hal/hal.h"\n#include "hal/f28335/bus.h"\nvoid hal_write(int x)\n{\n    bus_write16(x);\n}\n',
    "host_sim/chip/chip.h": "void chip_run(void);\n",
    "host_sim/chip/chip.c": '#include "host_sim/chip/chip.h"\n#include "hal/f28335/bus.h"\nint chip_count;\n'
    "void bus_write16(int x)\n{\n    chip_count = x;\n}\nvoid chip_run(void)\n{\n}\n",
    "host_sim/plant/plant.h": "double plant_run(double x);\n",
    "host_sim/plant/plant.c": '#include "plant.h"\n#include <math.h>\ndouble plant_run(double x)\n{\n    return sqrt(x);\n}\n',
    "host_sim/rig/rig.c": '#include "host_sim/chip/chip.h"\n#include "host_sim/plant/plant.h"\n#include "drive/drive.h"\n'
    "double rig_step(void);\ndouble rig_step(void)\n{\n    chip_run();\n    return plant_run((double)drive_step(1.0f));\n}\n",
    "tests/unit/test_angle.c": '#include "math/angle.h"\n#include "unity.h"\n',
}
LIBRARIES = {
    "firmware": ("firmware/math/angle.c", "firmware/contract/table.c", "firmware/estimator/smo.c", "firmware/fast/inverter/svpwm.c",
                 "firmware/drive/drive.c"),
    "app": ("firmware/app/app.c",),
    "hal": ("hal/f28335/pwm.c",),
    "chip": ("host_sim/chip/chip.c",),
    "plant": ("host_sim/plant/plant.c",),
    "rig": ("host_sim/rig/rig.c",),
}


FORBIDDEN_INCLUDES = (
    ("firmware/math/angle.c", "estimator/smo.h"), ("firmware/math/angle.h", "../fast/inverter/svpwm.h"),
    ("firmware/math/angle.c", "contract/table.h"), ("firmware/contract/table.c", "estimator/smo.h"),
    ("firmware/contract/table.h", "drive/drive.h"), ("firmware/estimator/smo.c", "fast/inverter/svpwm.h"),
    ("firmware/estimator/smo.c", "estimator/chosen.h"),
    ("firmware/fast/inverter/svpwm.c", "firmware/estimator/smo.h"), ("firmware/fast/inverter/svpwm.c", "drive/drive.h"),
    ("firmware/drive/drive.c", "app/app.h"), ("firmware/drive/drive.c", "hal/hal.h"),
    ("firmware/app/app.c", "host_sim/chip/chip.h"), ("hal/f28335/pwm.c", "math/angle.h"), ("hal/hal.h", "host_sim/chip/chip.h"),
    ("host_sim/chip/chip.c", "hal/hal.h"), ("host_sim/chip/chip.h", "host_sim/plant/plant.h"),
    ("host_sim/chip/chip.c", "drive/drive.h"), ("host_sim/plant/plant.c", "../chip/chip.h"),
    ("host_sim/plant/plant.c", "hal/f28335/registers.h"), ("host_sim/plant/plant.h", "math/angle.h"),
    ("host_sim/rig/rig.c", "host_sim/cli/cli.h"), ("host_sim/rig/rig.c", "tests/unit/test_angle.h"),
)

# Lines at the head of a file, the line that is reported, and the text of the report.
FORBIDDEN_LINES = (
    ("firmware/drive/drive.c", "  #  include <hal/hal.h>", "include", "hal/hal.h"),
    ("firmware/drive/drive.c", "#include BOARD_HEADER", "include", "BOARD_HEADER"),
    ("firmware/math/angle.h", "#include <stdio.h>", "include", "<stdio.h>"),
    ("firmware/drive/drive.c", "#define REACHES (drive->estimator.pll.amplitude)", "parts", "is an inner field of the estimator"),
    ("firmware/drive/drive.c", "#define REACHES (all->smo.gain)", "parts", "is an inner field of the estimator"),
    ("firmware/drive/drive.c", "#define REACHES (estimator.tracker.pll.detector)", "parts", "is an inner field of the estimator"),
    ("host_sim/rig/rig.c", "#define REACHES(x) ((x)->pll.theta_e)", "parts", "is an inner field of the estimator"),
    *((name, "/* as in notes" + ".md, section 2 */", "document", "notes" + ".md is no file of the project")
      for name in ("hal/f28335/pwm.c", "host_sim/chip/chip.c", "firmware/math/angle.h")),
)

# Permitted lines at the head of a file.
GOOD_LINES = (
    ("firmware/estimator/smo.c", "#define KNOWN(x) ((x)->smo.gain)"),
    ("firmware/drive/drive.c", '/*\n#include "hal/hal.h"\n*/ // #include "hal/hal.h"'),
    ("hal/hal.h", "/* the facts of a board; by design; what an issue is; SPRU812; pll_design(&params); " + "/".join(["docs", "home", "index"]) + " */"),
)

# Text that must not be in firmware/ or hal/, the text of the report, and its file if not hal/f28335/pwm.c.
FORBIDDEN_WORDS = (
    ("typedef double wide_t;", "`double`", "firmware/math/angle.h"),
    ("typedef struct { uint8_t x; } octet_t;", "`uint8_t`"),
    ("typedef struct { int8_t x; } octet_t;", "`int8_t`"),
    ("static void *f(void) { return malloc(1u); }", "`malloc`"),
    ("static void f(int x) { assert(x); }", "`assert`: console and abort of the library; use CHECK"),
    ("void abort(void) { for (;;) { } }", "`abort`: abort of the run-time library", "firmware/app/app.c"),
    ("static void f(void) { exit(1); }", "`exit`"),
    ("static float f(float x) { return sinf (x); }", "`sinf`", "firmware/drive/drive.c"),
    ("static float f(void) { return 1.5f * 2.5e-3; }", "`2.5e-3`"),
    ("/* \" */ typedef double wide_t; /* \" */", "`double`"),
)

# Code that is appended to a source, the line of it that is reported, and the text of the report.
FORBIDDEN_SYMBOLS = (
    ("firmware/drive/drive.c", "void hal_write(int x);\nvoid f(void);\nvoid f(void)\n{\n    hal_write(1);\n}\n",
     5, "firmware must not need hal_write"),
    ("firmware/drive/drive.c", "int puts(const char *);\nint f(void);\nint f(void)\n{\n    return puts(\"\");\n}\n",
     5, "firmware must not need puts"),
    ("firmware/drive/drive.c", "void __assert_fail(const char *);\nvoid f(void);\nvoid f(void)\n{\n    __assert_fail(\"\");\n}\n",
     5, "firmware must not need __assert_fail"),
    ("firmware/drive/drive.c", "int last;\n",
     1, "firmware must own no writable data: last"),
    ("firmware/app/app.c", "int spare;\n",
     1, "app must own no writable data: spare"),
    ("hal/f28335/pwm.c", "int shadow = 1;\n",
     1, "hal must own no writable data: shadow in .data"),
    ("hal/f28335/pwm.c", "float drive_step(float);\nvoid f(void);\nvoid f(void)\n{\n    drive_step(1.0f);\n}\n",
     5, "hal must not need drive_step"),
    ("host_sim/plant/plant.c", "double f(double);\ndouble f(double x)\n{\n    return exp(x);\n}\n",
     4, "plant must not need exp"),
)


FIELDS = "".join(f"    float f{n};\n" for n in range(26))

# Additional files, and the text of the report; "" if nothing is reported.
STRUCTS = (
    ({"firmware/a.h": "\n/* one; two; */\ntypedef struct {\n" + FIELDS + "} a_t;\n"}, "firmware/a.h:3: struct: has 26 fields; 25 at most"),
    ({"firmware/a.h": "typedef struct {\n" + FIELDS.replace("    float f25;\n", "") + "} a_t;\n"}, ""),
    # Fields of an inner struct do not count, each name of a declaration counts, and rows of a table do not count.
    ({"firmware/a.h": "struct a {\n    struct {\n" + FIELDS[:-13] + "    } inner;\n    float x, y;\n};\n"}, ""),
    ({"firmware/a.h": "struct a {\n    float " + ", ".join(f"f{n}" for n in range(26)) + ";\n};\n"}, "has 26 fields"),
    ({"firmware/a.h": "#define FIELD(n) float f##n;\ntypedef struct {\n    ROWS(FIELD, FIELD)\n} a_t;\n"}, ""),
    ({"firmware/math/a.h": '#include "math/b.h"\n', "firmware/math/b.h": '#include "math/c.h"\n', "firmware/math/c.h": '#include "math/a.h"\n'},
     "circle: firmware/math/a.h -> firmware/math/b.h -> firmware/math/c.h -> firmware/math/a.h: these include each other"),
    ({"firmware/a.c": '#include "b.h"\n#include "c.h"\n', "firmware/b.h": '#include "c.h"\n', "firmware/c.h": ""}, ""),
    ({"firmware/a.c": "int f(int n)\n{\n    return n % DRIVE_WINDOW; /* % LOOK_SLOT */\n}\n"}, "firmware/a.c:3: slot: % DRIVE_WINDOW"),
)


def write(root, name, text):
    path = root / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)


class CheckLayers(unittest.TestCase):
    def setUp(self):
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="lagless_layers_"))
        self.addCleanup(shutil.rmtree, self.root)
        for name, text in TREE.items():
            self.write(name, text)

    def write(self, name, text):
        write(self.root, name, text)

    def prepend(self, name, line):
        self.write(name, line + "\n" + TREE[name])

    def append(self, name, text):
        self.write(name, TREE[name] + text)

    def last_line(self, name):
        return TREE[name].count("\n")

    @classmethod
    def compile(cls, root, source):
        result = root / "build" / (pathlib.Path(source).name + ".o")
        result.parent.mkdir(exist_ok=True)
        subprocess.run([CC, "-std=c11", "-O1", "-g", "-fPIE", "-fno-builtin", "-I", root, "-I", root / "firmware",
                        "-c", root / source, "-o", result], check=True)
        return result

    @classmethod
    def setUpClass(cls):
        cls.good = pathlib.Path(tempfile.mkdtemp(prefix="lagless_layers_good_"))
        cls.addClassCleanup(shutil.rmtree, cls.good)
        for name, text in TREE.items():
            write(cls.good, name, text)
        cls.good_objects = {source: cls.compile(cls.good, source) for room in LIBRARIES.values() for source in room}

    def build(self):
        """Builds the libraries of the tree; only sources that a test has changed are compiled again."""
        arguments = []
        for room, sources in LIBRARIES.items():
            changed = {s for s in sources if (self.root / s).read_text() != TREE[s]}
            objects = [self.compile(self.root, s) if s in changed else self.good_objects[s] for s in sources]
            archive = self.root / "build" / f"lib{room}.a"
            archive.parent.mkdir(exist_ok=True)
            subprocess.run([AR, "rcs", archive, *objects], check=True)
            arguments += ["--library", f"{room}={archive}"]
        return arguments

    def check(self, *arguments):
        """The result of the checker, which runs in this process: a new Python process would take longer than the test."""
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            try:
                code = check_layers.main(["--root", str(self.root), "--nm", NM, *map(str, arguments)])
            except SystemExit as end:
                code = end.code
                if isinstance(code, str):
                    print(code, file=err)
                    code = 1
        return subprocess.CompletedProcess(arguments, code, out.getvalue(), err.getvalue())

    def assert_breach(self, start, text, symbols=False):
        """The checker prints exactly one message, which begins with `file:line: rule:` and contains the text."""
        run = self.check(*(self.build() if symbols else ()))
        rows = run.stdout.splitlines()
        self.assertEqual(run.returncode, 1, run.stdout + run.stderr)
        self.assertEqual(len(rows), 1, run.stdout)
        self.assertTrue(rows[0].startswith(start), rows[0])
        self.assertIn(text, rows[0])

    def test_good_tree_passes(self):
        run = self.check(*self.build())
        self.assertEqual((run.returncode, run.stderr), (0, ""), run.stdout)
        self.assertIn("6 libraries", run.stdout)

    def test_command_ends_with_the_verdict(self):
        command = [sys.executable, "-B", check_layers.__file__, "--root", str(self.root)]
        self.assertEqual(subprocess.run(command, stdout=subprocess.DEVNULL, check=False).returncode, 0)
        self.prepend("firmware/drive/drive.c", '#include "hal/hal.h"')
        broken = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=False)
        self.assertEqual(broken.returncode, 1)
        self.assertEqual(broken.stdout, "firmware/drive/drive.c:1: include: firmware/drive must not include hal/hal.h\n")

    # Includes and lengths of files

    def test_what_is_too_long_is_reported(self):
        self.write("firmware/settings/faults.h", "\n" * 501)  # a table
        self.prepend("firmware/math/angle.c", "void wide(float x)\n{\n" + "    (void)x;\n" * 57 + "}\n")
        self.assertEqual(self.check().returncode, 0)
        for name, text, line, told in (("firmware/math/angle.c", "void wide(float x)\n{\n" + "    (void)x;\n" * 58 + "}\n", 1, "wide has 61 lines; 60 at most"),
                                       ("firmware/math/angle.c", "\n" * 501, 501, "500 at most"), ("firmware/drive/drive.c", "\n" * 201, 201, "200 at most")):
            with self.subTest(told):
                self.prepend(name, text)
                self.assert_breach(f"{name}:{line}: length: ", told)
                self.write(name, TREE[name])

    def test_each_forbidden_line_is_found_and_what_is_right_is_not(self):
        for name, line, rule, text in FORBIDDEN_LINES:
            with self.subTest(line=line):
                self.prepend(name, line)
                self.assert_breach(f"{name}:1: {rule}: ", text)
                self.write(name, TREE[name])
        for name, lines in GOOD_LINES:
            self.prepend(name, lines)
        self.assertEqual(self.check().returncode, 0)

    def test_each_forbidden_include_is_found(self):
        for name, included in FORBIDDEN_INCLUDES:
            with self.subTest(name=name, included=included):
                self.prepend(name, f'#include "{included}"')
                self.assert_breach(f"{name}:1: include: ", "must not include")
                self.write(name, TREE[name])

    def test_cli_must_not_include_drive(self):
        self.write("host_sim/cli/main.c", '#include "host_sim/rig/rig.h"\n#include "contract/table.h"\n#include "drive/drive.h"\n')
        self.assert_breach("host_sim/cli/main.c:3: include: ", "host_sim/cli must not include firmware/drive/drive.h")

    def test_a_failed_check_of_the_desk_may_include_nothing_else_of_the_firmware(self):
        self.write("host_sim/check_failed.c", '#include <stdio.h>\n#include "math/check.h"\n')
        self.assertEqual(self.check().returncode, 0)
        self.write("host_sim/check_failed.c", '#include <stdio.h>\n#include "math/angle.h"\n')
        self.assert_breach("host_sim/check_failed.c:2: include: ", "host_sim must not include firmware/math/angle.h")

    # Words

    def test_each_forbidden_word_is_found(self):
        for text, word, *names in FORBIDDEN_WORDS:
            name = names[0] if names else "hal/f28335/pwm.c"
            with self.subTest(text=text):
                self.append(name, "\n" + text + "\n")
                self.assert_breach(f"{name}:{self.last_line(name) + 2}: word: ", word)
                self.write(name, TREE[name])

    # Structs, circles of includes

    def test_bags_circles_and_schedules_by_a_remainder_are_found(self):
        for files, told in STRUCTS:
            with self.subTest(told):
                for name, text in files.items():
                    self.write(name, text)
                if told:
                    self.assert_breach("firmware/", told)
                else:
                    self.assertEqual(self.check().returncode, 0)
                for name in files:
                    (self.root / name).unlink()

    # Recursion

    def test_recursion_over_two_files_is_found(self):
        self.append("firmware/math/angle.c", "float again(float x)\n{\n    return drive_step(x);\n}\n")
        self.append("firmware/drive/drive.c", "float once(float x)\n{\n    return again(x);\n}\n")
        self.write("firmware/drive/drive.c", (self.root / "firmware/drive/drive.c").read_text().replace("svpwm(smo", "once(smo"))
        run = self.check()
        self.assertEqual(run.returncode, 1)
        self.assertIn(": recursion: ", run.stdout)
        self.assertIn("drive_step -> once -> again -> drive_step", run.stdout)

    # Machine paths

    def test_machine_path_is_found(self):
        self.write("README.md", "line one\nsee " + "/".join(["", "home", "somebody", "notes"]) + "\n")
        self.assert_breach("README.md:2: machine: ", "somebody")

    # Documents. The names are composed so that these lines do not cite a document themselves.

    def test_document_in_another_folder_is_found(self):
        self.write("docs/notes" + ".md", "")
        self.prepend("hal/f28335/pwm.c", "/* docs/notes" + ".md */")
        self.assertEqual(self.check().returncode, 0)
        self.prepend("hal/f28335/pwm.c", "/* papers/notes" + ".md */")
        self.assert_breach("hal/f28335/pwm.c:1: document: ", "papers/notes" + ".md")

    def test_phrases_for_papers_outside_are_found(self):
        for phrase in ("facts" + " on dead time", "(" + "facts" + " section 13)", "facts" + ": memory map", "(" + "design" + ": timing)",
                       "Timing (" + "design)", "the reference" + " study", "Issue" + " 4"):
            with self.subTest(phrase=phrase):
                self.write("tools/thing", f"line one\n# {phrase}\n")
                self.assert_breach("tools/thing:2: document: ", "cites what is not in the project")

    def test_section_of_the_theory_must_exist(self):
        self.write("docs/theory" + ".md", "# Theory\n\n## 1. One\n")
        self.prepend("hal/f28335/pwm.c", "/* docs/theory" + ".md, 1 */")
        self.assertEqual(self.check().returncode, 0)
        self.prepend("hal/f28335/pwm.c", "/* docs/theory" + ".md,\n * 2 */")
        self.assert_breach("hal/f28335/pwm.c:1: document: ", "has no section 2")

    # Symbols: a declaration in the source itself evades the rule of the includes.

    def assert_forbidden_symbol(self, name, text, line, message):
        self.append(name, text)
        self.assert_breach(f"{name}:{self.last_line(name) + line}: symbol: ", message, symbols=True)

    def test_firmware_may_check_and_hal_may_not(self):
        text = "void check_failed(int);\nvoid g{0}(void);\nvoid g{0}(void)\n{{\n    check_failed(1);\n}}\n"
        self.append("firmware/drive/drive.c", text.format(1))
        self.assertEqual(self.check(*self.build()).returncode, 0)
        self.assert_forbidden_symbol("hal/f28335/pwm.c", text.format(2), 5, "hal must not need check_failed")

    def test_static_data_in_a_function_is_data(self):
        self.append("firmware/drive/drive.c", "int f(void);\nint f(void)\n{\n    static int n = 3;\n    return n++;\n}\n")
        run = self.check(*self.build())
        self.assertEqual(run.returncode, 1)
        self.assertRegex(run.stdout, r"symbol: firmware must own no writable data: n\.\d+ in \.data")

    def test_data_of_a_thread_is_data(self):
        self.append("firmware/app/app.c", "_Thread_local int spare;\n")
        self.assert_breach("libapp.a(app.c.o):0: symbol: ", "app must own no writable data: spare in .tbss", symbols=True)

    def test_each_forbidden_symbol_is_found(self):
        for name, text, line, message in FORBIDDEN_SYMBOLS:
            with self.subTest(message=message):
                self.assert_forbidden_symbol(name, text, line, message)
                self.write(name, TREE[name])

    def test_wrong_use_is_an_error(self):
        self.assertEqual(self.check("--library", "cellar=x.a").returncode, 2)
        run = self.check("--library", f"hal={self.root / 'nothing.a'}")
        self.assertEqual((run.returncode, "nothing.a" in run.stderr), (1, True))
        shutil.rmtree(self.root / "firmware")
        shutil.rmtree(self.root / "hal")
        self.assertNotEqual(self.check().returncode, 0)


if __name__ == "__main__":
    unittest.main()
