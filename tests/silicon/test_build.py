#!/usr/bin/env python3
"""The build description of the F28335 image, tested with stand-ins for TI's tools: the linked files, the files that are built again, and
the refused inputs. Its options are those of the project in ti/, which test_ccs.py compares with the build; only the real tools can show
the effect of the options.

usage: test_build.py BUILDS [unittest options]    BUILDS: the folder of chip_build.py
"""
import pathlib
import re
import sys
import tempfile
import unittest

import chip_build
import stand_in
from chip_build import ROOT, run

# Sources that are compiled once for each board; the core does not depend on the board.
OF_BOARD = re.compile(r"firmware/(fast/[^/]+|guard/.*|medium/[^/]+|medium/manoeuvre/manoeuvres.*|settings/.*|drive/.*|app/.*)$|hal/")


class Preset(unittest.TestCase):
    maxDiff = None

    @classmethod
    def setUpClass(cls):
        cls.build = chip_build.Build(chip_build.folder())

    def test_the_compiler_is_known(self):
        self.assertIn("The C compiler identification is TI 22.6.1", self.build.configured)

    def test_the_other_polarity_of_the_gates_is_built_by_the_same_commands_with_one_definition_changed(self):
        high, low = (run("ninja", "-C", folder, "-t", "commands").stdout.replace(str(folder), "FOLDER")
                     for folder in (self.build.folder, self.build.low))
        given, other = (f"-DHAL_GATE_ACTIVE_HIGH={value}" for value in chip_build.GATES.values())
        of_board = [name for name in self.build.compiled if OF_BOARD.match(name)]
        self.assertEqual(high.count(given), len(of_board))
        self.assertEqual(high.replace(given, other), low)

    def test_every_object_is_linked_once(self):
        linked = [word for word in self.build.linked[0] if word.endswith(".obj")]
        for archive in [word for word in self.build.linked[0] if word.endswith(".a")]:
            linked += self.build.archived[archive]
        self.assertEqual(sorted(linked), sorted(self.build.objects()))

    def test_a_changed_linker_file_links_again(self):
        query = run("ninja", "-C", self.build.folder, "-t", "query", "lagless.out")
        self.assertIn(f"| {ROOT}/linker/f28335_flash.cmd", query.stdout)


class Refusals(unittest.TestCase):
    def refused(self, *options, **environment):
        with tempfile.TemporaryDirectory() as folder:
            whole = {**stand_in.install(pathlib.Path(folder, "tools")), **environment}
            asked = chip_build.configure(pathlib.Path(folder, "build"), whole, *options)
        self.assertNotEqual(asked.returncode, 0)
        return " ".join(asked.stdout.split())

    def test_the_polarity_of_the_gates_has_no_default(self):
        self.assertIn("LAGLESS_GATES='': accepted: active_high", self.refused())
        self.assertIn("LAGLESS_GATES='high': accepted: active_high", self.refused("-DLAGLESS_GATES=high"))

    def test_a_missing_compiler_is_named(self):
        self.assertIn("/nowhere/bin/cl2000 is missing: C2000_CGT_ROOT", self.refused(C2000_CGT_ROOT="/nowhere"))

    def test_a_missing_fast_library_is_named(self):
        self.assertIn("rts2800_fpu32_fast_supplement_eabi.lib is missing", self.refused(C2000WARE_ROOT="/nowhere"))


class SizeReport(unittest.TestCase):
    def report(self, text):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "a.map")
            path.write_text(text, encoding="utf-8")
            return run(sys.executable, "-B", ROOT / "tools/size-report", path)

    def test_it_adds_up_what_a_map_of_the_linker_says(self):
        told = self.report("OUTPUT FILE NAME:   <a.out>\n\nMEMORY CONFIGURATION\n\n"
                           "         name            origin    length      used     unused   attr    fill\n"
                           "----------------------  --------  ---------  --------  --------  ----  --------\n"
                           "PAGE 0:\n"
                           "  L0_L3                 00008000   00004000  00001000  00003000  RWIX\n"
                           "  FLASH_H_D             00300000   00028000  0000ff00  00020100  RWIX\n\n"
                           "SECTION ALLOCATION MAP\n\n"
                           "  other                 00000000   00000001  00000001  00000000\n")
        self.assertEqual(told.returncode, 0)
        self.assertEqual([line.split() for line in told.stdout.splitlines()[1:]],
                         [["L0_L3", "0x008000", "16384", "4096", "25", "%"],
                          ["FLASH_H_D", "0x300000", "163840", "65280", "40", "%"]])

    def test_another_file_is_refused(self):
        told = self.report("int main(void);\n")
        self.assertEqual(told.returncode, 1)
        self.assertIn("is no map file", told.stdout)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[2:])
