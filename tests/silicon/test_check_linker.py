#!/usr/bin/env python3
"""tools/check-linker must pass on this tree, and on copies with one defect it must name the defect.

usage: test_check_linker.py BUILDS [unittest options]    BUILDS: the folder of chip_build.py

CC names a GCC, for the call graph.
"""
import contextlib
import io
import pathlib
import re
import shutil
import sys
import tempfile
import unittest

import chip_build
import graphs
from chip_build import ROOT, run

FLASH = "linker/f28335_flash.cmd"
IN_FLASH = "linker/interrupt_in_flash.txt"
COMMANDS = "compile_commands.json"

checker = graphs.tool.load("check-linker")
graphs.remember(checker)


# A change, given by a pattern that matches one place of a file, and the report about it.
BREACHES = (
    (FLASH, "origin = 0x00C000, length = 0x004000", "origin = 0x00BFFF, length = 0x004000", "f28335_flash.cmd:",
     "overlap: L4_L7 begins at 0x00bfff, in L0_L3, which ends at 0x00bfff"),
    (FLASH, "origin = 0x000050, length = 0x0007B0", "origin = 0x009000, length = 0x000400",
     "overlap: M0_M1 begins at 0x009000, in L0_L3, which ends at 0x00bfff"),
    (FLASH, "origin = 0x00C000, length = 0x004000", "origin = 0x00C000, length = 0x005000",
     "region: L4_L7, 0x00c000..0x010fff, is not in one memory of the chip"),
    (FLASH, "origin = 0x008000, length = 0x004000", "origin = 0x008000, length = 0x004001",
     "region: L0_L3, 0x008000..0x00c000, is not in one memory of the chip"),
    (FLASH, "origin = 0x00C000, length = 0x004000", "origin = 0x006000, length = 0x001800",
     "region: L4_L7, 0x006000..0x0077ff, reaches into: peripheral frame 1, peripheral frame 2"),
    (FLASH, "origin = 0x000050, length = 0x0007B0", "origin = 0x00004F, length = 0x0007B1",
     "region: M0_M1, 0x00004f..0x0007ff, reaches into: boot ROM's own data and stack"),
    (FLASH, "origin = 0x300000, length = 0x028000", "origin = 0x338000, length = 0x008000",
     "reaches into: words of the code security module that must stay free, CSM password words"),
    (FLASH, "origin = 0x300000, length = 0x028000", "origin = 0x338000, length = 0x007F81",
     "FLASH_H_D, 0x338000..0x33ff80, reaches into: words of the code security module that must stay free\n"),
    (FLASH, "origin = 0x300000, length = 0x028000", "origin = 0x300000, length = 0x028001",
     "region: FLASH_H_D, 0x300000..0x328000, reaches into: sectors C and B, kept for stored parameters"),
    (FLASH, r"\.text         : > FLASH_H_D", ".text         : > M0_M1",
     "prefetch: M0_M1 ends at 0x0007ff and holds section .text"),
    (FLASH, r"\n    \.switch ", "\n    .swich ", "missing: section .switch has no place", "unknown: section .swich"),
    (FLASH, r"\.const        : > FLASH_H_D", ".const        : > L4_L7",
     "place: section .const is in L4_L7, must be in flash: it must be there after a reset"),
    (FLASH, r"\.text         : > FLASH_H_D", ".text         : >> L0_L3 | L4_L7",
     "place: section .text is in L0_L3, must be in flash: it must be there after a reset",
     "place: section .text is in L4_L7, must be in flash"),
    (FLASH, r"\.bss          : > L4_L7", ".bss          : > FLASH_H_D",
     "place: section .bss is in FLASH_H_D, must be in M0 and M1 or L0-L3 or L4-L7: it is written"),
    (FLASH, "RUN = L0_L3", "RUN = L4_L7", "place: section .TI.ramfunc is in L4_L7, must be in L0-L3"),
    (FLASH, r"\*\(\.TI\.ramfunc\) ", "*(ramfuncs) ",
     "inputs: section .TI.ramfunc does not collect * ( .TI.ramfunc ), which the interrupt runs"),
    (FLASH, r" -l rts2800_fpu32_fast_supplement_eabi\.lib\(\.text\)", "", "f28335_flash.cmd:",
     "does not collect -l rts2800_fpu32_fast_supplement_eabi.lib ( .text )"),
    (FLASH, r"\.data         : > L4_L7", ".data         : > L8",
     "region: section .data goes to L8, which MEMORY does not have"),
    (FLASH, ", TYPE = NOLOAD", "", "place: section FPUmathTables must be TYPE = NOLOAD"),
    (FLASH, "origin = 0x3FEBDC", "origin = 0x3FEB50",
     "place: section FPUmathTables is at 0x3feb50, the boot ROM has it at 0x3febdc"),
    (FLASH, "origin = 0x33FFF6, length = 0x000002", "origin = 0x337FFE, length = 0x000002",
     "entry: codestart is at 0x337ffe, 2 words; the boot ROM jumps to 0x33fff6, where 2 words are free"),
    ("hal/f28335/codestart.asm", "code_start: LB ", "code_start: NOP\n            LB ",
     "entry: section codestart must be one long branch (LB), 2 words; it has 2 instructions"),
    ("hal/f28335/codestart.asm", "0068h", "0028h", "entry: watchdog_off does not stop the watchdog: WDCR 0x7029 = 0x0068"),
    ("hal/f28335/codestart.asm", "LB      _c_int00", "NOP",
     "entry: watchdog_off does not end in the run-time library's start-up: LB _c_int00"),
    ("firmware/app/main.c", r" *hal_boot\(\);\n", "",
     "firmware/app/main.c:7: copy: main does not call hal_boot: the code for RAM"),
    ("firmware/app/main.c", r"    hal_boot\(\);\n", "    app_start();\n    hal_boot();\n",
     "copy: main calls app_start before hal_boot, which copies the code to RAM"),
    (FLASH, r"LOAD_SIZE\(ramfunc_load_size\), ", "",
     "copy: section .TI.ramfunc has no symbol LOAD_SIZE, which the start-up needs to copy the section"),
    (FLASH, r", RUN_SIZE\(stack_size\)", "", "stack: section .stack has no RUN_SIZE symbol, which the check of the end of the stack needs"),
    (FLASH, "ramfunc_run_start", "ramfunc_start",
     "copy: hal_boot does not use ramfunc_start, the RUN_START symbol of linker/f28335_flash.cmd"),
    (FLASH, r"\.const        : > FLASH_H_D", ".const        : LOAD = FLASH_H_D, RUN = L4_L7",
     "copy: section .const runs at another address than its load address, and is not copied"),
    ("firmware/app/app.c", r"    app_write\(&command\);\n", "    app_write(&command);\n"
     "    (void)params_check(&app->staged, 0);\n", "firmware/settings/judgement.c:", "params_check stays in flash",
     "the sample interrupt calls params_check, whose folder runs less often: app_interrupt -> params_check"),
    ("firmware/app/app.c", r"    drive_trip\(&app->drive\);\n", "    extern float sinf(float);\n    "
     "app->drive.fast.period = (uint32_t)sinf((float)app->drive.fast.period);\n    drive_trip(&app->drive);\n", "firmware/app/app.c:",
     "calls: sinf belongs to the library and stays in flash: app_trip -> sinf"),
    ("firmware/app/app.c", r"    drive_trip\(&app->drive\);\n",
     "    void (*volatile trip)(drive_t *) = drive_trip;\n    trip(&app->drive);\n",
     "calls: a call through a pointer cannot be followed: app_trip -> __indirect_call"),
    ("firmware/app/app.c", r"    drive_trip\(&app->drive\);\n", "    extern void *memcpy(void *, const void *, "
     "unsigned long);\n    memcpy(&app->staged, &app->drive, 2);\n    drive_trip(&app->drive);\n", "firmware/app/app.c:",
     "memcpy belongs to the library and stays in flash: app_trip -> memcpy"),
    ("hal/f28335/codestart.asm", r"\.ref    _c_int00", ".ref    _c_int00, unknown_name", 'hal/f28335/codestart.asm:',
     'unresolved symbol "unknown_name"'),
    ("hal/f28335/wait.c", r"uint32_t turn;", "uint32_t turn", "hal/f28335/wait.c: ", "gives no call graph"),
    (FLASH, "SECTIONS\n", "GROUP\n", "f28335_flash.cmd:", "'GROUP', but MEMORY or SECTIONS is expected here"),
)


# Text that is added to a source, the line from which it is reported, and the report.
ADDED = (
    ("firmware/app/main.c", "void abort(void);\nvoid abort(void)\n{\n    hal_gates_off();\n    for (;;) {\n    }\n}\n", 1,
     'names: error #10056: symbol "abort" redefined: first defined here; redefined in rts2800_fpu32_eabi.lib<exit.c.obj>, '
     "which every program links\n"),
    ("firmware/app/main.c", "void __TI_zero_init_nomemset(void) {}\n", None, "<copy_zero_init.c.obj>, which every program links"),
    ("firmware/app/main.c", "void code_start(void) {}\n", None, 'symbol "code_start" redefined: first defined in firmware/app/main.c'),
    ("hal/f28335/board.c", "uint16_t _stack;\n", 0, 'names: error #10056: symbol "_stack" redefined', "<boot28.asm.obj>"),
    ("hal/f28335/board.c", "void printf(void) {}\n", 0, "names: printf is a name of the library"),
    ("hal/f28335/board.c", "extern void unknown_name(void);\nvoid f(void) { unknown_name(); }\n", 0,
     'names: error #10234: unresolved symbol "unknown_name": it is not in our sources, not in linker/f28335_flash.cmd'),
    ("hal/f28335/boot.c", "extern const uint16_t stack_end[];\nuint16_t f(void) { return stack_end[0]; }\n", None,
     'unresolved symbol "stack_end"', "not in linker/f28335_flash.cmd"),
    ("hal/f28335/board.c", "void *malloc(unsigned);\nvoid *f(void) { return malloc(2u); }\n", None,
     "names: malloc needs the heap of the library, which this image does not have"),
    ("hal/f28335/board.c", "int printf(const char *, ...);\nvoid f(int n) { printf(\"%d\", n); }\n", None,
     "names: printf needs the console of the library, which this image does not have"),
    ("hal/f28335/board.c", "#include <assert.h>\nvoid f(int n) { assert(n); }\n", None,
     "names: __assert_fail needs the console of the library"),
)

# A function that is collected for RAM although it was not before, or vice versa, and the report.
MOVED = (
    ("hal_boot", True, "hal/f28335/boot.c:", "copy: runs from RAM before its code has been copied there: hal_boot"),
    ("flash_program", True, "hal/f28335/flash.c:", "overlay: runs from RAM while the flash API has replaced its code: flash_program"),
    ("hal_store_erase", True, "hal/f28335/store.c:", "overlay: runs from RAM while the flash API has replaced its code"),
    ("bus_copy_code", True, "hal/f28335/boot.c:", "overlay: runs from RAM while the flash API has replaced its code"),
    ("drive_step", False, "firmware/drive/drive.c:",
     "drive_step stays in flash, linker/f28335_flash.cmd does not collect it for RAM: app_interrupt -> drive_step"),
    ("set_flash_waits", False, "hal/f28335/clock.c:", "set_flash_waits stays in flash"),
    ("bus_wait", False, "hal/f28335/wait.c:", "bus_wait stays in flash", "set_flash_waits -> bus_wait"),
    ("table_get", True, "linker/f28335_flash.cmd:31: calls: table_get is collected for RAM, but neither the interrupt nor the flash's"),
)


class CheckLinker(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.root = pathlib.Path(cls.temporary.name).resolve() / "tree"
        for name in ("firmware", "hal", "linker"):
            shutil.copytree(ROOT / name, cls.root / name)
        commands = (chip_build.Build(chip_build.folder()).folder / COMMANDS).read_text(encoding="utf-8").replace(str(ROOT), str(cls.root))
        (cls.root / COMMANDS).write_text(commands, encoding="utf-8")

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def write(self, name, text):
        """Writes a file, which keeps this content until the case ends."""
        path = self.root / name
        if path.exists():
            self.addCleanup(path.write_text, path.read_text(encoding="utf-8"), encoding="utf-8")
        else:
            self.addCleanup(path.unlink)
        path.write_text(text, encoding="utf-8")

    def remove(self, name):
        """Removes a file until the case ends."""
        self.write(name, "")
        (self.root / name).unlink()

    def change(self, name, old, new):
        text = (self.root / name).read_text(encoding="utf-8")
        self.assertEqual(len(re.findall(old, text)), 1, f"{name} has not one {old}")
        self.write(name, re.sub(old, lambda _: new, text))

    def words(self):
        return ["--commands", str(self.root / COMMANDS), "--root", str(self.root), "--cc", graphs.CC, "--arm", "none"]

    def check(self):
        """Returns (exit status, output)."""
        told = io.StringIO()
        with contextlib.redirect_stdout(told), contextlib.redirect_stderr(told):
            status = checker.main(self.words())
        return status, told.getvalue()

    def assert_breach(self, *texts):
        status, told = self.check()
        self.assertEqual(status, 1, told)
        for text in texts:
            self.assertIn(text, told)

    def test_this_tree_passes(self):
        status, told = self.check()
        self.assertEqual(status, 0, told)
        self.assertRegex(told, r"^linker/f28335_flash.cmd: fits the chip; \d{3} functions of \d\d "
                         r"sources must run from RAM, and do; \d{2,3} of the interrupt's stay in flash, by linker/interrupt_in_flash.txt"
                         r"\nevery name is defined once; used from the library: _c_int00, ")

    def test_the_program_itself_asks_for_the_command_lines(self):
        told = run(sys.executable, "-B", ROOT / "tools/check-linker")
        self.assertEqual(told.returncode, 2)
        self.assertIn("--commands", told.stdout)

    def test_each_breach_is_named(self):
        for name, old, new, *texts in BREACHES:
            with self.subTest(texts[0]):
                self.change(name, old, new)
                self.assert_breach(*texts)
            self.doCleanups()

    # The memory map

    def test_flash_up_to_the_reserved_words_is_allowed(self):
        self.change(FLASH, "origin = 0x300000, length = 0x028000", "origin = 0x338000, length = 0x007F80")
        self.assertEqual(self.check()[0], 0)

    def test_code_up_to_the_end_of_memory(self):
        self.change(FLASH, "RUN = L0_L3", "RUN = L4_L7")
        for length in ("0x004000", "0x003FF9"):
            with self.subTest(length):
                self.change(FLASH, "origin = 0x00C000, length = 0x00[34][0-9A-F]+", f"origin = 0x00C000, length = {length}")
                last = 0xC000 + int(length, 16) - 1
                self.assert_breach(f"f28335_flash.cmd:13: prefetch: L4_L7 ends at {last:#08x} and holds section .TI.ramfunc: "
                                   "behind its memory nothing can be fetched, so it must end 8 words before")

    # The interrupt's call tree, and the copy to RAM

    def collect(self, name, for_ram):
        if for_ram:
            self.change(FLASH, r"\*\(\.text:app_interrupt\)", f"*(.text:app_interrupt) *(.text:{name})")
        else:
            self.change(FLASH, rf"\*\(\.text:{name}\) ?", "")

    def test_each_function_in_the_wrong_memory_is_named(self):
        for name, ram, *texts in MOVED:
            with self.subTest(name):
                self.collect(name, ram)
                self.assert_breach(*texts)
            self.doCleanups()

    def listed_in_flash(self, text):
        self.write(IN_FLASH, (self.root / IN_FLASH).read_text(encoding="utf-8") + text + "\n")

    def test_a_function_that_is_to_stay_in_flash_and_is_not_the_interrupt_s_or_not_there(self):
        self.listed_in_flash("firmware/settings/judgement.c: params_check")
        self.listed_in_flash("firmware/drive/none.c: unknown_name")
        self.assert_breach("linker/interrupt_in_flash.txt:", "params_check of firmware/settings/judgement.c: the interrupt does not call it",
                           "unknown_name of firmware/drive/none.c: there is no such function")

        self.doCleanups()
        self.collect("bus_wait", False)  # code that configures the flash must be in RAM, whatever the list contains
        self.listed_in_flash("hal/f28335/wait.c: bus_wait")
        self.assert_breach("hal/f28335/wait.c:", "stays in flash")

    def test_the_collected_files_are_written_with_their_names_in_the_tree(self):
        before = (self.root / FLASH).read_text(encoding="utf-8")
        self.write(FLASH, re.sub(r"(?s)(/\* begin: [^\n]*\n).*?( */\* end:)", r"\1\2", before))
        self.assertEqual(checker.main([*self.words(), "--write"]), 0)
        self.assertEqual((self.root / FLASH).read_text(encoding="utf-8"), before)

    # Free memory

    def test_code_that_leaves_no_quarter_of_the_memory_free(self):
        self.change(FLASH, "origin = 0x008000, length = 0x004000", "origin = 0x008000, length = 0x003000")
        told = io.StringIO()
        with contextlib.redirect_stdout(told):
            status = checker.main([*self.words()[:-2]])
        if shutil.which("arm-none-eabi-gcc") is None:
            self.skipTest("arm-none-eabi-gcc is missing")
        self.assertEqual(status, 1)
        self.assertRegex(told.getvalue(), r"room: the code in L0_L3 takes 1\d{4} words of a C28x \(\d+ to \d+\), estimated; accepted: 9216 "
                         r"of 12288: list in linker/interrupt_in_flash.txt")

    # Names

    def append(self, name, text):
        """Appends text to a file; returns the line where it begins."""
        before = (self.root / name).read_text(encoding="utf-8")
        self.write(name, before + text)
        return before.count("\n") + 1

    def test_each_name_that_is_added_is_named(self):
        for name, text, ahead, *texts in ADDED:
            with self.subTest(texts[0]):
                line = self.append(name, text)
                self.assert_breach(*texts if ahead is None else (f"{name}:{line + ahead}: {texts[0]}", *texts[1:]))
            self.doCleanups()

    def test_names_of_the_start_up(self):
        members = {"_c_int00": "boot28.asm", "_args_main": "args_main.c", "exit": "exit.c", "__TI_dtors_ptr": "exit.c",
                   "_lock": "_lock.c", "_unlock": "_lock.c", "_register_lock": "_lock.c", "_register_unlock": "_lock.c",
                   "_nop": "_lock.c", "memcpy": "memcpy.c", "__TI_auto_init_nobinit_nopinit": "autoinit.c"}
        for name in members:
            self.append("hal/f28335/board.c", f"void {name}(void) {{}}\n")
        self.assert_breach(*[f'symbol "{name}" redefined: first defined here; redefined in rts2800_fpu32_eabi.lib<{member}.obj>'
                             for name, member in members.items()])

    def test_one_name_in_two_of_our_objects(self):
        self.append("firmware/app/main.c", "uint16_t twice;\nstatic uint16_t alone;\n")
        line = self.append("hal/f28335/boot.c", "uint16_t twice;\nstatic uint16_t alone;\n")
        self.assert_breach(f'hal/f28335/boot.c:{line}: names: error #10056: symbol "twice" redefined: first defined in '
                           "firmware/app/main.c\n")
        self.assertNotIn("alone", self.check()[1])

    # Sources and files

    def test_a_source_that_is_not_built(self):
        self.write("hal/f28335/sci.c", "int sci;\n")
        self.assert_breach("hal/f28335/sci.c:1: build: is not compiled")

    def test_a_linker_file_that_is_not_there(self):
        self.remove(FLASH)
        self.assert_breach("f28335_flash.cmd")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[2:])
