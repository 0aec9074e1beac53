#!/usr/bin/env python3
"""The build description of the F28335 image, against stand-ins for TI's tools: every source once, with the right
options, in the right order. What the options do, only the real tools can tell.

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

CHIP = ["-v28", "-ml", "-mt", "--abi=eabi", "--float_support=fpu32"]
FLAGS = ["--gen_func_subsections=on", "--display_error_number", "--diag_warning=225", "--diag_wrap=off", "-O2", "-g"]

# Sources that are compiled for a board; the core is independent of it.
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

    def test_every_source_of_firmware_and_hal_is_compiled_once(self):
        sources = [path.relative_to(ROOT).as_posix() for folder in ("firmware", "hal")
                   for path in (ROOT / folder).rglob("*") if path.suffix in (".c", ".asm")]
        self.assertEqual(sorted((name, len(lines)) for name, lines in self.build.compiled.items()),
                         sorted((name, 1) for name in sources))

    def test_c_is_compiled_with_these_options_in_this_order(self):
        for name, (words,) in self.build.compiled.items():
            if not name.endswith(".c"):
                continue
            own = [word for word in words if word.startswith("-D")]
            where = [word for word in words if word == f"--include_path={ROOT}/firmware"]
            output = stand_in.value(words, "--output_file")
            of_board = OF_BOARD.match(name)
            board = ["-DHAL_GATE_ACTIVE_HIGH=1", '-DLAGLESS_BOARD_FILE="hal/f28335/boards/pm50rl1a060.h"']
            self.assertEqual(own, board if of_board else [], name)
            self.assertEqual(words, [
                "--compile_only", f"--c_file={ROOT}/{name}", *own, *where, f"--include_path={ROOT}", *CHIP,
                f"--include_path={self.build.tools}/include", *FLAGS, "--c99", "--relaxed_ansi",
                "--preproc_with_compile", f"--preproc_dependency={output}.d", f"--output_file={output}"], name)

    def test_the_entry_is_assembled_with_the_same_abi(self):
        (words,) = self.build.compiled["hal/f28335/codestart.asm"]
        self.assertEqual(words[:2], ["--compile_only", f"--asm_file={ROOT}/hal/f28335/codestart.asm"])
        self.assertEqual([word for word in words if word in CHIP], CHIP)

    def test_functions_are_linked_one_by_one_so_that_the_linker_can_collect_the_interrupt_s(self):
        for name, (words,) in self.build.compiled.items():
            if name.endswith(".c"):
                self.assertIn("--gen_func_subsections=on", words, name)

    def test_the_program_is_linked_by_this_command_line(self):
        (words,) = self.build.linked
        objects = [name for name in self.build.objects() if "lagless.dir" in name]
        self.assertEqual(words, [
            *CHIP, f"--include_path={self.build.tools}/include", *FLAGS,
            "--run_linker", "--output_file=lagless.out", "--map_file=lagless.map", "--rom_model",
            "--entry_point=code_start", "--stack_size=0x700", "--heap_size=0", "--warn_sections", "--reread_libs",
            "--priority",
            f"--search_path={self.build.tools}/lib", f"--search_path={(self.build.ware / stand_in.FAST_RTS).parent}",
            f"{ROOT}/linker/f28335_flash.cmd",
            *sorted(objects, key=words.index),
            "firmware/liblagless_app.a", "firmware/liblagless_firmware.a", "firmware/liblagless_core.a",
            "hal/liblagless_hal.a",
            "--library=rts2800_fpu32_fast_supplement_eabi.lib", "--library=rts2800_fpu32_eabi.lib"])

    def test_every_object_is_linked_once(self):
        linked = [word for word in self.build.linked[0] if word.endswith(".obj")]
        for archive in [word for word in self.build.linked[0] if word.endswith(".a")]:
            linked += self.build.archived[archive]
        self.assertEqual(sorted(linked), sorted(self.build.objects()))

    def test_hex_is_made_of_the_program(self):
        self.assertEqual(self.build.converted,
                         [["--intel", "--memwidth=16", "--romwidth=16", "--outfile=lagless.hex", "lagless.out"]])

    def test_program_map_and_hex_are_there_and_say_what_they_are(self):
        for name in ("lagless.out", "lagless.map", "lagless.hex"):
            self.assertIn("STAND-IN", (self.build.folder / name).read_text(encoding="utf-8"))
        self.assertIn("STAND_IN", self.build.built)  # size-report read the map

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
        self.assertIn("LAGLESS_GATES='': accepted are active_high", self.refused())
        self.assertIn("LAGLESS_GATES='high': accepted are active_high", self.refused("-DLAGLESS_GATES=high"))

    def test_a_missing_compiler_is_named(self):
        self.assertIn("/nowhere/bin/cl2000 is missing: C2000_CGT_ROOT", self.refused(C2000_CGT_ROOT="/nowhere"))

    def test_a_missing_fast_library_is_named(self):
        self.assertIn("rts2800_fpu32_fast_supplement_eabi.lib is missing", self.refused(C2000WARE_ROOT="/nowhere"))


class StandIn(unittest.TestCase):
    """That the stand-in can say no."""

    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = pathlib.Path(self.temporary.name)
        self.environment = stand_in.install(self.folder)
        (self.folder / "a.c").write_text("int a;\n", encoding="utf-8")

    def tool(self, name, *words):
        return run(self.folder / "cgt/bin" / name, *words, cwd=self.folder, env=self.environment)

    def test_it_says_that_it_is_one(self):
        asked = self.tool("cl2000", "--compile_only", "--c_file=a.c", "--output_file=a.obj")
        self.assertEqual(asked.returncode, 0)
        self.assertEqual(asked.stdout, "stand-in cl2000: records the command line, compiles nothing\n")
        self.assertIn("holds no code", (self.folder / "a.obj").read_text(encoding="utf-8"))

    def test_an_option_of_another_compiler_is_refused(self):
        asked = self.tool("cl2000", "--compile_only", "--c_file=a.c", "-Wall", "--output_file=a.obj")
        self.assertEqual(asked.returncode, 1)
        self.assertIn("unknown option -Wall", asked.stdout)

    def test_compiler_options_behind_run_linker_are_refused(self):
        asked = self.tool("cl2000", "--run_linker", "--abi=eabi", "--output_file=a.out")
        self.assertIn("unknown option --abi=eabi", asked.stdout)

    def test_a_program_without_linker_file_is_refused(self):
        asked = self.tool("cl2000", "--run_linker", "--output_file=a.out", "a.c")
        self.assertIn("needs one linker command file", asked.stdout)

    def test_a_missing_input_is_refused(self):
        self.assertIn("b.obj does not exist", self.tool("ar2000", "qr", "b.a", "b.obj").stdout)

    def test_a_library_that_no_path_leads_to_is_refused(self):
        (self.folder / "a.cmd").write_text("", encoding="utf-8")
        asked = self.tool("cl2000", "--run_linker", "a.cmd", "--library=c.lib", "--output_file=a.out",
                          "--map_file=a.map")
        self.assertIn("c.lib is in no --search_path", asked.stdout)


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
