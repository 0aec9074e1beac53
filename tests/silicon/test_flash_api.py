#!/usr/bin/env python3
"""tools/flash-api with COFF images that are made here by TI's description of the format (SPRAAO8), with one fault each, and
with a stand-in for cl2000 that checks its command line and produces such an image.

usage: test_flash_api.py FOLDER [unittest options]    FOLDER is what chip_build.py made

CC names a C compiler, which compiles the resulting source.
"""
import contextlib
import io
import os
import pathlib
import re
import struct
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests"))
import graphs  # noqa: E402
import stand_in  # noqa: E402
import tool  # noqa: E402

TOOL = ROOT / "tools/flash-api"
flash_api = tool.load("flash-api")
TEXT, DATA, BSS, COPY, NOLOAD = 0x20, 0x40, 0x80, 0x10, 0x02
AT = 0x8000
CODE = [0x761F, 0x0006, 0x9A00, 0x0006]  # arbitrary words
# Four branches to words of .text, and the two variables in .ebss.
TABLE = [0x0040, 0x8010, 0x0040, 0x8011, 0x0040, 0x8012, 0x0040, 0x8013, 0x8020, 0, 0x8022, 0]


def sections(**changed):
    """name -> (address, words or a number of words without contents, kind, relocations)."""
    usual = {"flash_table": (AT, TABLE, TEXT, 0), ".text": (AT + 0x10, CODE, TEXT, 0), ".econst": (AT + 0x18, [0xABCD], DATA, 0),
             ".ebss": (AT + 0x20, 4, BSS, 0), ".debug_info": (0, [1, 2, 3], COPY, 0)}
    for name, value in changed.items():
        usual[{"table": "flash_table"}.get(name, "." + name)] = value
    return usual


def coff(parts, version=0xC2, target=0x9D, flags=0x0003, optional=28):
    """File header, optional header, section headers, contents, and a table of strings for names of more than eight characters."""
    names, strings = {}, b""
    for name in parts:
        encoded = name.encode()
        if len(encoded) > 8:
            names[name] = struct.pack("<II", 0, 4 + len(strings))
            strings += encoded + b"\0"
        else:
            names[name] = encoded.ljust(8, b"\0")
    at, heads, contents = 22 + optional + 48 * len(parts), b"", b""
    for name, (address, words, kind, relocations) in parts.items():
        stored = not isinstance(words, int)
        octets = struct.pack(f"<{len(words)}H", *words) if stored else b""
        heads += names[name] + struct.pack("<IIIIIIIIIHH", address, address, len(words) if stored else words, at if stored else 0, 0, 0,
                                           relocations, 0, kind, 0, 0)
        at, contents = at + len(octets), contents + octets
    head = struct.pack("<HHIIIHHH", version, len(parts), 0, at, 0, optional, flags, target)
    return head + b"\0" * optional + heads + contents + struct.pack("<I", 4 + len(strings)) + strings


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.out = self.folder / "made/flash_api.c"

    def run_on(self, data, *words, environment=None):
        path = self.folder / "input"
        path.write_bytes(data)
        return subprocess.run([sys.executable, "-B", TOOL, path, "--out", self.out, *words], env=environment, capture_output=True,
                              text=True, check=False)

    def made(self):
        """The words that a compiler reads from the resulting source."""
        main = self.folder / "main.c"
        main.write_text('#include <stdio.h>\n#include "hal/f28335/bus.h"\nint main(void)\n{\n    bus_memory_t api = bus_flash_api();\n'
                        '    for (uint32_t n = 0; n < api.count; n++) {\n        printf("%u\\n", api.words[n]);\n    }\n    return 0;\n}\n')
        board = '-DLAGLESS_BOARD_FILE="hal/f28335/boards/pm50rl1a060.h"'
        subprocess.run([os.environ.get("CC", "cc"), "-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Werror", board, f"-I{ROOT}",
                        main, self.out, "-o", self.folder / "main"], check=True)
        return [int(line) for line in subprocess.run([self.folder / "main"], capture_output=True, text=True, check=True).stdout.split()]

    def refused(self, data, *expected):
        done = self.run_on(data)
        self.assertEqual(done.returncode, 1, done.stdout)
        for text in expected:
            self.assertIn(text, done.stderr)
        self.assertEqual(done.stderr.count("Traceback"), 0)
        self.assertFalse(self.out.exists())


class Images(Case):
    def test_the_words_lie_as_they_were_linked(self):
        expected = TABLE + [0] * 4 + CODE + [0] * 4 + [0xABCD] + [0] * 11
        for optional in (0, 28):
            done = self.run_on(coff(sections(), optional=optional))
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(self.made(), expected)
            self.assertIn(f"{len(expected)} words", done.stdout)

    def test_an_image_of_the_largest_size_is_taken_and_one_more_word_is_not(self):
        room = 0x4000 - 0x40
        self.assertEqual(self.run_on(coff(sections(econst=(AT + 0x40, [7] * room, DATA, 0)))).returncode, 0)
        self.assertEqual(len(self.made()), 0x4000)
        self.out.unlink()
        self.refused(coff(sections(econst=(AT + 0x40, [7] * (room + 1), DATA, 0))), ".econst", "0x8000 to 0xbfff")

    def test_a_file_that_ends_anywhere_is_refused(self):
        whole = coff(sections())
        needed = whole.rindex(struct.pack("<H", 0xABCD)) + 2  # debug information and names are not needed
        for length in range(needed):
            with self.subTest(length=length), self.assertRaises(flash_api.Refused):
                flash_api.block_of(flash_api.read_sections(whole[:length]))
        self.refused(whole[:needed - 1], "ends", ".econst")

    def test_another_machine_and_another_format_are_refused(self):
        self.refused(coff(sections(), target=0x98), "target 0x98", "0x9d")
        self.refused(coff(sections(), version=0xC1), "version 0xc1", "0xc2")
        self.refused(b"\x7fELF\x01\x01\x01" + b"\0" * 100, "--abi=eabi")

    def test_what_is_not_linked_to_the_end_is_refused(self):
        self.refused(coff(sections(), flags=0x0001), "references are open")
        self.refused(coff(sections(text=(AT + 0x10, CODE, TEXT, 3))), ".text", "3 relocations")

    def test_sections_outside_the_range_or_one_over_the_other_are_refused(self):
        self.refused(coff(sections(econst=(0x7FFF, [1], DATA, 0))), ".econst", "0x7fff")
        self.refused(coff(sections(ebss=(0xBFFE, 4, BSS, 0))), ".ebss", "0xc001")
        self.refused(coff(sections(econst=(0x300000, [1], DATA, 0))), ".econst", "0x300000")
        self.refused(coff(sections(econst=(AT + 0x12, [1], DATA, 0))), ".econst", "overlap at 0x8012")
        self.refused(coff(sections(econst=(AT + 0x18, [1], DATA | NOLOAD, 0))), ".econst", "NOLOAD")

    def test_sizes_in_octets_are_seen(self):
        twice = bytearray(coff(sections()))
        for n in range(3):  # the three sections with contents
            place = 22 + 28 + 48 * n + 16
            struct.pack_into("<I", twice, place, 2 * struct.unpack_from("<I", twice, place)[0])
        self.refused(bytes(twice), "overlap in the file")

    def test_a_table_that_leads_elsewhere_is_refused(self):
        for at, words, text in ((0, [0x7640, 0x8010], "erase"), (2, [0x0040, 0x8014], "program"), (4, [0x0041, 0x8010], "verify"),
                                (6, [0x0040, 0x8002], "version"), (8, [0x8021, 0], "scale factor"), (8, [0x8020, 1], "scale factor"),
                                (10, [0x8024, 0], "callback pointer"), (10, [0x8020, 0], "both variables")):
            with self.subTest(text=text):
                self.refused(coff(sections(table=(AT, TABLE[:at] + words + TABLE[at + 2:], TEXT, 0))), text)
        self.refused(coff(sections(table=(AT + 1, TABLE, TEXT, 0))), "nothing lies at 0x8000")
        self.refused(coff({}), "no section")


class Libraries(Case):
    LIBRARY = b"!<arch>\nTI's, and not here"

    def stand_in(self, fails=""):
        """A stand-in for cl2000 that checks the command line for assembling the table and linking it with the library."""
        image = self.folder / "image"
        image.write_bytes(coff(sections()))
        program = self.folder / "cgt/bin/cl2000"
        program.parent.mkdir(parents=True)
        program.write_text(f"#!/bin/sh\nprintf '%s\\n' \"$@\" >{self.folder}/log\n{fails}\n"
                           f'for word in "$@"; do case $word in --output_file=*) cp {image} "${{word#*=}}";; esac; done\n')
        program.chmod(0o755)
        return {**os.environ, "C2000_CGT_ROOT": str(self.folder / "cgt")}

    def test_a_library_is_linked_with_the_table_by_the_users_tools(self):
        done = self.run_on(self.LIBRARY, environment=self.stand_in())
        self.assertEqual(done.returncode, 0, done.stderr)
        words = (self.folder / "log").read_text().split("\n")
        at = words.index("--run_linker")
        for option in ("--abi=coffabi", "-v28", "--float_support=fpu32", str(ROOT / "linker/flash_api.asm")):
            self.assertIn(option, words[:at])
        for option in ("--entry_point=_flash_api", str(ROOT / "linker/flash_api.cmd"), str(self.folder / "input")):
            self.assertIn(option, words[at:])
        self.assertEqual(self.made()[:12], TABLE)

    def test_the_message_of_the_linker_is_passed_on(self):
        done = self.run_on(self.LIBRARY, environment=self.stand_in("echo 'error #16000: incompatible'; exit 1"))
        self.assertEqual(done.returncode, 1)
        self.assertIn("error #16000: incompatible", done.stderr)
        self.assertFalse(self.out.exists())

    def test_without_the_tools_it_reports_what_is_missing(self):
        environment = {name: value for name, value in os.environ.items() if name != "C2000_CGT_ROOT"}
        self.assertIn("set C2000_CGT_ROOT", self.run_on(self.LIBRARY, environment=environment).stderr)
        self.assertIn("cannot be started", self.run_on(self.LIBRARY, "--cl2000", "/nowhere/cl2000").stderr)


class Builds(Case):
    def test_the_image_is_built_with_it_and_the_interrupts_code_stays_as_it_was(self):
        image, build = self.folder / "flash_api.out", self.folder / "build"
        image.write_bytes(coff(sections()))
        environment = stand_in.install(self.folder / "tools")
        steps = (["cmake", "--preset", "f28335-flash", "-B", build, "-DLAGLESS_GATES=active_high", f"-DLAGLESS_FLASH_API={image}"],
                 ["cmake", "--build", build, "--target", "flash_api.c", "ccs"])
        for step in steps:
            done = subprocess.run(step, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        # Only the new source is compiled for its call graph; chip_build.py has made those of the other sources.
        checker, told = tool.load("check-linker"), io.StringIO()
        graphs.remember(checker)
        with contextlib.redirect_stdout(told), contextlib.redirect_stderr(told):
            status = checker.main(["--commands", str(build / "compile_commands.json"), "--arm", "none", "--cc", graphs.CC])
        self.assertEqual(status, 0, told.getvalue())
        commands = (build / "compile_commands.json").read_text()
        self.assertIn(str(build / "flash_api.c"), commands)
        self.assertNotIn("flash_api_none.c", commands)
        self.assertIn("flash_api.c", (build / "ccs/lagless.projectspec").read_text())
        self.out = build / "flash_api.c"
        self.assertEqual(self.made()[:12], TABLE)


class Table(unittest.TestCase):
    """linker/flash_api.asm, linker/flash_api.cmd and hal/f28335/flash_api.h have the same table."""

    def test_entries_are_where_the_program_reads_them(self):
        header = (ROOT / "hal/f28335/flash_api.h").read_text()
        places = {name: int(value) for name, value in re.findall(r"#define FLASH_API_(ERASE|PROGRAM|VERIFY|VERSION|SCALE|CALLBACK|HEAD)"
                                                                r"\s+(\d+)u", header)}
        source = (ROOT / "linker/flash_api.asm").read_text()
        rows = re.findall(r"^(?:_flash_api:)?\s+(LB|\.long)\s+(\w+)$", source, re.MULTILINE)  # each entry has two words
        expected = {"ERASE": "_Flash28335_Erase", "PROGRAM": "_Flash28335_Program", "VERIFY": "_Flash28335_Verify",
                    "VERSION": "_Flash28335_APIVersionHex", "SCALE": "_Flash_CPUScaleFactor", "CALLBACK": "_Flash_CallbackPtr"}
        self.assertEqual({rows[place // 2][1]: name for name, place in places.items() if name != "HEAD"},
                         {symbol: name for name, symbol in expected.items()})
        self.assertEqual(places["HEAD"], 2 * len(rows))
        self.assertEqual([word for word, _ in rows], ["LB"] * 4 + [".long"] * 2)
        self.assertIn("flash_table : load = 0x008000", (ROOT / "linker/flash_api.cmd").read_text())


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
