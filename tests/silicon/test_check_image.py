#!/usr/bin/env python3
"""tools/check-image with images that are made here, word by word: a good image must pass, and in each other image one fault must be named.
TI's linker is not needed; the files have the format of its files.

usage: test_check_image.py BUILDS [unittest options]    BUILDS: the folder of chip_build.py

CC names a GCC, for the call graph.
"""
import contextlib
import io
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest

import chip_build
import graphs
from chip_build import ROOT

TOOL = ROOT / "tools/check-image"
checker = graphs.tool.load("check-image")
graphs.remember(checker.linker)

ALLOC, WRITE, EXEC = 2, 1, 4
CODE, CONST, VARIABLE = ALLOC | EXEC, ALLOC, ALLOC | WRITE
LRETR, NOP = 0x0006, 0x7700
UNDEFINED, ABSOLUTE = 0, 0xFFF1
LOCAL, GLOBAL, WEAK = 0, 1, 2
NOTYPE, OBJECT, FUNC, FILE = 0, 1, 2, 4


def lcr(address):
    return [0x7640 | address >> 16, address & 0xFFFF]


def lb(address):
    return [0x0040 | address >> 16, address & 0xFFFF]


class Section:
    """A section. `run` and `load` are in words; `contents` is a list of words, or their number if the file does not contain them."""

    def __init__(self, name, flags, run, contents, load=None):
        self.name, self.flags, self.run, self.contents = name, flags, run, contents
        self.load = run if load is None else load
        self.in_segment, self.header_address, self.align = True, run, 1
        self.gap = None  # filling words between this section and the previous one of the same segment

    @property
    def stored(self):
        return isinstance(self.contents, list)

    @property
    def words(self):
        return len(self.contents) if self.stored else self.contents


class Elf:
    """An ELF file in the form of the C28x EABI: addresses in words, sizes in octets."""

    def __init__(self):
        self.sections, self.symbols, self.more_segments = [], [], []
        self.entry, self.machine, self.type, self.order = 0, 141, 2, "<"

    def section(self, name):
        (found,) = [section for section in self.sections if section.name == name]
        return found

    def add(self, *section, load=None):
        self.sections.append(Section(*section, load=load))
        return self.sections[-1]

    def move(self, name, run):
        section = self.section(name)
        section.run = section.load = section.header_address = run

    def change(self, name, **attributes):
        vars(self.section(name)).update(attributes)

    def load_ramfunc(self, at):
        """Loads .TI.ramfunc at this address, and sets the symbol that states the address."""
        self.change(".TI.ramfunc", load=at)
        self.define("ramfunc_load_start", at, NOTYPE)

    def remove(self, name):
        self.sections.remove(self.section(name))

    def define(self, name, value, kind=FUNC, bind=GLOBAL, place=ABSOLUTE, size=0):
        self.symbols = [symbol for symbol in self.symbols if symbol[0] != name or LOCAL in (symbol[3], bind)]
        self.symbols.append((name, value, kind, bind, place, size))

    def forget(self, name):
        self.symbols = [symbol for symbol in self.symbols if symbol[0] != name]

    def write(self, path):
        def pack(form, *values):
            return struct.pack(self.order + form, *values)

        names, strings = bytearray(b"\0"), bytearray(b"\0")

        def text(table, word):
            table += word.encode() + b"\0"
            return len(table) - len(word) - 1

        body, headers, segments = bytearray(52), [pack("10I", *[0] * 10)], []
        for section in self.sections:
            if section.gap is not None:
                body += struct.pack(f"<{len(section.gap)}H", *section.gap)
            offset, octets = len(body), 2 * section.words
            if section.stored:
                body += struct.pack(f"<{section.words}H", *section.contents)
            kind = 1 if section.stored else 8  # PROGBITS, NOBITS
            headers.append(pack("10I", text(names, section.name), kind, section.flags, section.header_address, offset, octets,
                                0, 0, section.align, 0))
            if section.gap is not None:
                segments[-1][4] = segments[-1][5] = offset + octets - segments[-1][1]
            elif section.in_segment and section.words:
                segments.append([1, offset, section.run, section.load, octets if section.stored else 0, octets, 4,
                                 section.align])
        for address, contents in self.more_segments:
            segments.append([1, len(body), address, address, 2 * len(contents), 2 * len(contents), 4, 1])
            body += struct.pack(f"<{len(contents)}H", *contents)
        if self.symbols:
            # Local symbols come first, each after the name of its file.
            ordered = sorted(self.symbols, key=lambda symbol: symbol[3] != LOCAL)
            table = b"".join([bytes(16)] + [pack("3I2BH", text(strings, name), value, size, bind << 4 | kind, 0, place)
                                            for name, value, kind, bind, place, size in ordered])
            link, local = len(headers) + 1, sum(1 for symbol in ordered if symbol[3] == LOCAL) + 1
            headers.append(pack("10I", text(names, ".symtab"), 2, 0, 0, len(body), len(table), link, local, 1, 16))
            body += table
            headers.append(pack("10I", text(names, ".strtab"), 3, 0, 0, len(body), len(strings), 0, 0, 1, 0))
            body += strings
        name = text(names, ".shstrtab")
        headers.append(pack("10I", name, 3, 0, 0, len(body), len(names), 0, 0, 1, 0))
        body += names
        program = len(body)
        body += b"".join(pack("8I", *segment) for segment in segments)
        header = struct.pack("4s5B7x", b"\x7fELF", 1, 1 if self.order == "<" else 2, 1, 0, 0)
        header += pack("2H5I6H", self.type, self.machine, 1, self.entry, program, len(body), 0, 52, 32, len(segments), 40,
                       len(headers), len(headers) - 1)
        body[:52] = header
        path.write_bytes(bytes(body) + b"".join(headers))


# The program, at the addresses of the linker command files. Each function has several words.
FUNCTION_WORDS = 8
RAM_CODE = 0x8000
APP_INTERRUPT, APP_TRIP, DRIVE_STEP, DRIVE_TRIP, DIVISION = (RAM_CODE + FUNCTION_WORDS * n for n in range(5))
LOCAL_STEP = RAM_CODE + 5 * FUNCTION_WORDS


def function(*words):
    return list(words) + [NOP] * (FUNCTION_WORDS - 1 - len(words)) + [LRETR]


def good():
    elf = Elf()
    boot, text, stored, ramfunc = 0x33FFF6, 0x300000, 0x300100, 0x300400
    elf.entry = boot
    elf.add("codestart", CODE, boot, lb(text))
    elf.add(".text", CODE, text, function(*lcr(APP_INTERRUPT)) + function() * 3)
    elf.add(".cinit", CONST, stored, [1, 2, 3, 4])
    elf.add(".const", CONST, stored + 0x100, [0x3F80] * 16)
    elf.add(".switch", CONST, 0, 0).flags = 0
    elf.add(".TI.ramfunc", CODE | WRITE, RAM_CODE,
            function(*lcr(DRIVE_STEP)) + function(*lb(DRIVE_TRIP)) + function(*lcr(DIVISION), *lcr(LOCAL_STEP)) + function() * 3,
            load=ramfunc)
    elf.add(".stack", VARIABLE, 0x0050, 0x700)
    elf.add(".bss", VARIABLE, 0xC000, 0x200)
    elf.add(".data", VARIABLE, 0xC200, 0x40)
    elf.add("FPUmathTables", ALLOC, 0x3FEBDC, 0x6A0).in_segment = False
    elf.add(".reset", 0, 0x3FFFC0, 0)
    elf.define("hal.asm", 0, FILE, LOCAL)
    elf.define("step", LOCAL_STEP, FUNC, LOCAL, 1, 8)
    elf.define("$C$L1", text + 3, FUNC, LOCAL, 1)
    elf.define("table.asm", 0, FILE, LOCAL)
    elf.define("step", text + 16, FUNC, LOCAL, 1, 8)  # a function of another source, which the interrupt does not call
    for name, address in (("code_start", boot), ("watchdog_off", text), ("main", text + 8), ("params_check", text + 24),
                          ("app_interrupt", APP_INTERRUPT), ("app_trip", APP_TRIP), ("drive_step", DRIVE_STEP),
                          ("drive_trip", DRIVE_TRIP), ("__c28xabi_divf", DIVISION)):
        elf.define(name, address, place=1, size=8)
    for name, value in (("ramfunc_load_start", ramfunc), ("ramfunc_load_size", 6 * FUNCTION_WORDS),
                        ("ramfunc_run_start", RAM_CODE), ("__TI_STACK_SIZE", 0x700)):
        elf.define(name, value, NOTYPE)
    elf.define("__c_args__", 0, NOTYPE, WEAK, UNDEFINED)
    return elf


def join_constants(image, gap):
    """Puts .const into the segment of .cinit, with this number of filling words between them."""
    image.change(".cinit", contents=[1, 2, 3])
    at = image.section(".cinit").run + 3 + gap
    image.change(".const", align=2, gap=[0xDEAD] * gap, run=at, load=at, header_address=at)


# Images with one fault each, and the report about it.
FAULTS = (
    (lambda image: image.forget("app_trip"), "symbols: app_trip is not there: the interrupts of the drive\n"),
    (lambda image: image.define("code_start", 0x300000, place=1),
     "entry: code_start at 0x300000: code_start at 0x33fff6, where"),
    (lambda image: image.forget("code_start"), "entry: code_start is not there: code_start at 0x33fff6, where"),
    (lambda image: image.remove("codestart"), "entry: no section codestart: 2 words at 0x33fff6\n"),
    (lambda image: image.more_segments.append((0x310000, [1, 2, 3])),
     "segments: segment 8 loads 0x310000..0x310002, from 0x310000 on what no section holds:"),
    (lambda image: image.add("ramfuncs", CONST, 0x310000, [1, 2]),
     "memory: section ramfuncs, 0x310000..0x310001: sections that the linker command file gives a place: codestart, "),
    (lambda image: image.add(".text.2", CODE, 0xD000, [NOP] * 4, load=0x310000),
     "memory: section .text.2 runs at 0x00d000..0x00d003: FLASH_H_",
     "code: code of .text.2 runs at 0x00d000..0x00d003: flash sectors H-D, 0x300000..0x327fff or L0-L3,",
     "stored: .text.2 is loaded at 0x310000 and runs at 0x00d000: only .TI.ramfunc may be copied when the program starts"),
    (lambda image: image.move(".const", 0xD000), "memory: section .const runs at 0x00d000..0x00d00f: FLASH_H_",
     "stored: .const is loaded at 0x00d000..0x00d00f: flash, 0x300000..0x33ffff\n"),
    (lambda image: image.move(".data", 0x9000), "memory: section .data runs at 0x009000..0x00903f: L4_L7,",
     "variables: .data, 0x009000..0x00903f: L4-L7, 0x00c000..0x00ffff\n"),
    (lambda image: image.add(".text.2", CODE, 0x33FFF8, [0] * 8), "memory: section .text.2 runs at 0x33fff8..0x33ffff:",
     "code: code of .text.2 runs at 0x33fff8..0x33ffff:",
     "reserved: .text.2, 0x33fff8..0x33ffff, reaches into the CSM password words, 0x33fff8..0x33ffff: nothing there\n",
     "sectors: .text.2, 0x33fff8..0x33ffff, reaches into flash sector A, 0x338000..0x33ffff: codestart only\n"),
    (lambda image: image.move(".const", 0x33FF80), "memory: section .const runs at",
     "reserved: .const, 0x33ff80..0x33ff8f, reaches into "
     "the words of the code security module that must stay free, 0x33ff80..0x33fff5:",
     "sectors: .const, 0x33ff80..0x33ff8f, reaches into flash sector A,"),
    (lambda image: image.move(".data", 0x6800), "memory: section .data runs at", "variables: .data, 0x006800",
     "reserved: .data, 0x006800..0x00683f, reaches into the peripheral frame 1, 0x006000..0x006fff: nothing there\n"),
    (lambda image: image.remove(".stack"), "stack: 0 sections .stack: one\n"),
    (lambda image: image.move(".stack", 0x010000), "memory: section .stack runs at 0x010000..0x0106ff: M0_M1,",
     "stack: .stack, 0x010000..0x0106ff: up to 0x00ffff: the stack pointer has 16 bits\n"),
    (lambda image: image.define("__TI_STACK_SIZE", 0xE00, NOTYPE),
     "stack: __TI_STACK_SIZE = 0xe00: 0x700, the words of .stack\n"),
    (lambda image: image.define("board_on", 0, NOTYPE, GLOBAL, UNDEFINED), "undefined: board_on is undefined: all defined\n"),
    (lambda image: image.define("board_on", 0, NOTYPE, WEAK, UNDEFINED), "undefined: board_on is undefined: all defined\n"),
    (lambda image: image.add(".sysmem", VARIABLE, 0xC300, 0x40), "heap: .sysmem, 0x00c300..0x00c33f: no heap\n"),
    (lambda image: image.add(".cio", VARIABLE, 0xC300, 0x120), "memory: section .cio,",
     "console: .cio, 0x00c300..0x00c41f: no console of the library\n"),
    # the entry
    (lambda image: setattr(image, "entry", 0x300000), "entry: entry point 0x300000: code_start at 0x33fff6, where the boot ROM jumps to\n"),
    (lambda image: image.change("codestart", contents=[*lb(0x300000), NOP]),
     "entry: section codestart, 0x33fff6..0x33fff8: 2 words at 0x33fff6\n",
     "memory: section codestart runs at 0x33fff6..0x33fff8: ENTRY, 0x33fff6..0x33fff7\n",
     "reserved: codestart, 0x33fff6..0x33fff8, reaches into the CSM password words, 0x33fff8..0x33ffff: nothing there\n"),
    (lambda image: image.change("codestart", contents=[NOP, NOP]), "entry: section codestart begins with 0x7700: a long branch (LB)\n"),
    (lambda image: image.change("codestart", contents=lb(0x310000)), "entry: its branch leads to 0x310000: code of this image\n"),
    # segments
    (lambda image: image.change(".const", in_segment=False),
     "segments: .const is in no segment and would not be loaded: contents that a segment loads"),
    (lambda image: image.change(".const", header_address=2 * 0x300200),  # the address is in octets
     "segments: .const: its segment runs it at 0x300200, its header at 0x600400: the same, addresses in words, sizes in octets\n",
     "memory: section .const runs at 0x600400..0x60040f:", "stored: .const is loaded at 0x300200 and runs at 0x600400:"),
    (lambda image: join_constants(image, 5),  # more filling than an alignment needs
     "segments: segment 2 loads 0x300100..0x300117, from 0x300103 on what no section holds: segments made of sections"),
    # memories
    (lambda image: (image.change(".bss", contents=0x4001), image.remove(".data")),
     "memory: section .bss runs at 0x00c000..0x010000: L4_L7, 0x00c000..0x00",
     "variables: .bss, 0x00c000..0x010000: L4-L7, 0x00c000..0x00ffff\n"),
    (lambda image: (image.move(".data", 0xBFF0), image.remove(".bss")),
     "memory: section .data runs at 0x00bff0..0x00c02f: L4_L7, 0x00c000..0x00ffff\n",
     "variables: .data, 0x00bff0..0x00c02f: L4-L7, 0x00c000..0x00ffff\n"),
    (lambda image: image.change(".data", contents=[7] * 0x40, load=0x310000),
     "memory: section .data is loaded at 0x310000..0x31003f: L4_L7,",
     "stored: .data is loaded at 0x310000 and runs at 0x00c200: only .TI.ramfunc may be copied when the program starts",
     "variables: .data has contents to load: none: .cinit sets variables at start-up"),
    (lambda image: image.change(".bss", contents=0x201),
     "overlap: .bss, 0x00c000..0x00c200, and .data, 0x00c200..0x00c23f: each word for one of them\n"),
    (lambda image: image.load_ramfunc(0x300010),
     "overlap: .text, 0x300000..0x30001f, and .TI.ramfunc (loaded), 0x300010..0x30003f:"),
    # memory that must stay free
    (lambda image: image.load_ramfunc(0x338000), "memory: section .TI.ramfunc is loaded at 0x338000..0x33802f:",
     "sectors: .TI.ramfunc (loaded), 0x338000..0x33802f, reaches into flash sector A, 0x338000..0x33ffff: codestart only\n"),
    (lambda image: image.change("FPUmathTables", contents=[0] * 0x6A0, in_segment=True),
     "reserved: FPUmathTables is loaded at 0x3febdc..0x3ff27b: TYPE = NOLOAD: the boot ROM has it\n"),
    (lambda image: image.change("FPUmathTables", run=0x3FEBDE, header_address=0x3FEBDE, contents=0x69E),
     "reserved: FPUmathTables at 0x3febde: 0x3febdc, where the boot ROM has it\n"),
    # what is copied to RAM
    (lambda image: image.change(".TI.ramfunc", contents=6 * FUNCTION_WORDS),
     "ramfunc: .TI.ramfunc without code to load: one, with the code of the interrupt\n"),
    (lambda image: image.load_ramfunc(RAM_CODE),  # loaded where a reset loses it
     "memory: section .TI.ramfunc is loaded at 0x008000..0x00802f: FLASH_H_",
     "stored: .TI.ramfunc is loaded at 0x008000..0x00802f: flash, 0x300000..0x33ffff\n"),
    (lambda image: image.change(".TI.ramfunc", run=0xD000, header_address=0xD000),
     "memory: section .TI.ramfunc runs at 0x00d000..0x00d02f:", "code: code of .TI.ramfunc runs at 0x00d000..0x00d02f:",
     "ramfunc: .TI.ramfunc runs at 0x00d000..0x00d02f: L0-L3, 0x008000..0x00bfff: no wait states\n",
     "interrupt: app_interrupt at 0x008000: .TI.ramfunc, 0x00d000..0x00d02f\n", "calls: app_interrupt, which is at 0x008000:"),
    (lambda image: image.move(".const", 0x330000), "memory: section .const runs at 0x330000..0x33000f:",
     "reserved: .const, 0x330000..0x33000f, reaches into the sectors C and B, kept for stored parameters,",
     "sectors: .const, 0x330000..0x33000f, reaches into flash sectors C and B, 0x328000..0x337fff: nothing: they are kept for parameters\n"),
    # the stack
    (lambda image: (image.change(".stack", contents=0x6FF), image.define("__TI_STACK_SIZE", 0x6FF, NOTYPE)),
     "stack: .stack has 0x6ff words: at least 0x700\n"),
)


class CheckImage(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name).resolve()
        self.image = good()
        self.names = ["app_interrupt", "app_trip", "drive_step"]

    def check(self, elf, *options, names=True):
        """Returns (exit status, output)."""
        path, graph = self.folder / "lagless.out", self.folder / "names"
        if isinstance(elf, bytes):
            path.write_bytes(elf)
        else:
            elf.write(path)
        graph.write_text("# the interrupt's\n" + "\n".join(self.names) + "\n", encoding="utf-8")
        told = io.StringIO()
        with contextlib.redirect_stdout(told), contextlib.redirect_stderr(told):
            status = checker.main([str(path), *(["--call-graph", str(graph)] if names else []), *options])
        return status, told.getvalue()

    def assert_breach(self, elf, *texts, options=(), names=True):
        status, told = self.check(elf, *options, names=names)
        self.assertEqual(status, 1, told)
        for text in texts:
            self.assertIn(f"lagless.out: {text}", told)
            self.assertIn(f"failed: {', '.join(dict.fromkeys(text.partition(':')[0] for text in texts))}", told)

    def assert_passes(self, elf, *options):
        status, told = self.check(elf, *options)
        self.assertEqual(status, 0, told)
        return told

    def test_each_fault_is_named(self):
        for spoil, *texts in FAULTS:
            with self.subTest(texts[0]):
                elf = good()
                spoil(elf)
                self.assert_breach(elf, *texts)

    # Images that are right

    def test_a_good_image(self):
        self.assertEqual(self.assert_passes(self.image), "lagless.out: 17 of 17 checks passed; 3 of the "
                         "interrupt's 3 functions have a symbol, the others are inline\n")

    def test_the_program_itself(self):
        self.image.write(self.folder / "lagless.out")
        told = subprocess.run([sys.executable, "-B", TOOL, self.folder / "lagless.out"], stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, check=False)
        self.assertEqual(told.returncode, 0, told.stdout)
        self.assertEqual(told.stdout, "lagless.out: 16 of 17 checks passed; not made: interrupt "
                                      "(no --call-graph)\n")

    def test_code_that_the_linker_split(self):
        self.image.section(".text").name = ".text.1"
        self.image.add(".text.2", CODE, 0x310000, [NOP] * 16)
        self.assert_passes(self.image)

    def test_a_gap_for_alignment_in_a_segment(self):
        join_constants(self.image, 1)
        self.assert_passes(self.image)

    # The file

    def test_a_file_that_is_no_whole_elf(self):
        self.image.write(self.folder / "whole")
        whole = (self.folder / "whole").read_bytes()
        for contents in (b"", b"STAND-IN placeholder, holds no code", b"\x7fELF\x01\x01\x01", whole[:300], whole[:len(whole) // 2], whole[:-1]):
            status, told = self.check(contents)
            self.assertEqual(status, 1)
            self.assertIn(": a whole ELF file\n", told)
        self.assertIn("no image for this chip: none of the 17 checks was made\n", self.check(b"")[1])

    def test_a_file_of_something_else(self):
        header = struct.pack("<4s5B7x2HI3QI6H", b"\x7fELF", 2, 1, 1, 0, 0, 2, 141, 1, 0, 0, 0, 0, 64, 0, 0, 0, 0, 0)
        for elf, changes, text in ((good(), {"machine": 40}, "machine EM_ARM: EM_TI_C2000 (0x8d), a C28x\n"),
                                   (good(), {"type": 1}, "type ET_REL: ET_EXEC, a linked program\n"),
                                   (good(), {"order": ">"}, "big-endian: little-endian\n"), (header, {}, "class of 64 bits: 32 bits\n")):
            if changes:
                vars(elf).update(changes)
            status, told = self.check(elf)
            self.assertEqual(status, 1)
            self.assertIn("file: " + text, told)

    def test_an_image_without_symbols(self):
        self.image.symbols = []
        status, told = self.check(self.image)
        self.assertEqual(status, 1)
        self.assertIn("symbols: no symbol table: an image that was not stripped", told)
        self.assertIn("not made: interrupt (no symbol table), calls (no symbol table)", told)

    # The entry

    def test_an_image_for_a_debugger(self):
        """The whole image is in RAM, where a reset loses it."""
        self.image.entry = 0
        for name, run in (("codestart", 0), (".text", 0x9000), (".cinit", 0xC400), (".const", 0xC500)):
            self.image.move(name, run)
        self.image.section("codestart").contents = lb(0x9000)
        self.assert_breach(self.image, "entry: entry point 0x000000: code_start at 0x33fff6, where the boot ROM jumps to\n",
                           "memory: section codestart runs at", "stored: .text is loaded at 0x009000..0x00901f: flash, 0x300000..0x33ffff\n")

    # What is copied to RAM

    def test_no_code_for_ram(self):
        self.image.remove(".TI.ramfunc")
        self.assert_breach(self.image, "ramfunc: 0 sections .TI.ramfunc: one, with the code of the interrupt\n")
        self.assertIn("not made: interrupt (0 sections .TI.ramfunc), calls (0 sections .TI.ramfunc)", self.check(self.image)[1])

    def test_symbols_of_the_copy_that_are_wrong(self):
        for name, wrong, wanted in (
            ("ramfunc_load_start", 0x300402, "0x300400, the LOAD_START of .TI.ramfunc"),
            ("ramfunc_load_size", 12 * FUNCTION_WORDS, "0x30, the LOAD_SIZE of .TI.ramfunc in words"),
            ("ramfunc_run_start", 0x8002, "0x8000, the RUN_START of .TI.ramfunc"),
        ):
            with self.subTest(name):
                elf = good()
                elf.define(name, wrong, NOTYPE)
                self.assert_breach(elf, f"ramfunc: {name} = {wrong:#x}: {wanted}\n")
                elf.forget(name)
                self.assert_breach(elf, f"ramfunc: {name} is not there: {wanted}\n")

    def test_a_command_file_that_names_no_symbol_for_the_copy(self):
        text = (ROOT / "linker/f28335_flash.cmd").read_text(encoding="utf-8")
        (self.folder / "linker").mkdir()
        (self.folder / "linker/f28335_flash.cmd").write_text(text.replace("LOAD_SIZE(ramfunc_load_size), ", ""),
                                                             encoding="utf-8")
        self.assert_breach(self.image, "ramfunc: the linker command file names no LOAD_SIZE symbol: three, which the start-up "
                                       "copies by\n", options=("--root", str(self.folder)))

    # What is linked

    def test_a_heap_and_a_console_by_their_functions(self):
        console = ("printf", "sprintf", "vsnprintf", "__TI_printfi", "__TI_printfi_nofloat", "puts", "fputs", "putchar", "fopen", "fflush",
                   "HOSTwrite", "C$$IO$$", "_IO_putc", "__TI_writemsg", "_abort_msg", "_ftable")
        for rule, names, wanted in (("heap", ("malloc", "calloc", "realloc", "free", "memalign"), "no heap"),
                                    ("console", console, "no console of the library")):
            for name in names:
                with self.subTest(name):
                    elf = good()
                    elf.define(name, 0x300008, place=1)
                    self.assert_breach(elf, f"{rule}: {name} is linked: {wanted}\n")

    def test_the_size_of_a_heap(self):
        self.image.define("__TI_SYSMEM_SIZE", 0, NOTYPE)
        self.assert_passes(self.image)
        self.image.define("__TI_SYSMEM_SIZE", 0x400, NOTYPE)
        self.assert_breach(self.image, "heap: __TI_SYSMEM_SIZE is linked: no heap\n")

    def test_names_that_are_not_a_console(self):
        for name in ("app_read", "hal_output", "params_print", "sprint", "_lock", "abort", "exit", "memcpy"):
            self.image.define(name, 0x300008, place=1)
        self.assert_passes(self.image)

    # What the interrupt runs

    def test_a_function_of_the_interrupt_elsewhere(self):
        self.names.append("params_check")
        for at in (0x300018, 0xD000):  # in flash, and in RAM with wait states
            self.image.define("params_check", at, place=1)
            self.assert_breach(self.image, f"interrupt: params_check at {at:#08x}: .TI.ramfunc, 0x008000..0x00802f\n")

    def test_a_function_that_was_made_in_line(self):
        self.names.append("limit")
        self.assertIn("3 of the interrupt's 4 functions have a symbol", self.assert_passes(self.image))

    def test_a_function_of_the_interrupt_that_may_stay_in_flash(self):
        code = self.image.section(".TI.ramfunc").contents
        at = DRIVE_STEP - RAM_CODE
        code[at + 4:at + 6] = lcr(0x300018)
        self.names.append("params_check flash")
        self.assertIn("4 of the interrupt's 4 functions have a symbol", self.assert_passes(self.image))

    def test_calls_and_branches_into_flash(self):
        for elf, at, words, told in ((good(), DRIVE_STEP + 4, lcr(0x300018), "app_interrupt -> drive_step -> params_check, which is at 0x300018: "
                                      "calls of .TI.ramfunc, 0x008000..0x00802f\n"),
                                     (good(), LOCAL_STEP + 6, lb(0x300018), "app_interrupt -> drive_step -> step -> params_check, which is at 0x300018:")):
            elf.section(".TI.ramfunc").contents[at - RAM_CODE:at - RAM_CODE + 2] = words
            self.assert_breach(elf, "calls: " + told, names=False)
        self.image.define("app_trip", 0x300008, place=1)
        self.assertIn("calls: app_trip, which is at 0x300008: .TI.ramfunc, 0x008000..0x00802f\n", self.check(self.image, names=False)[1])

    def test_a_call_into_flash_by_what_only_the_background_calls(self):
        self.image.section(".TI.ramfunc").contents += function(*lcr(0x300018))
        self.image.define("app_start", RAM_CODE + 6 * FUNCTION_WORDS, place=1, size=8)
        self.image.define("ramfunc_load_size", 7 * FUNCTION_WORDS, NOTYPE)
        self.assert_passes(self.image)
        self.names.append("app_start")
        self.assert_breach(self.image, "calls: app_start -> params_check, which is at 0x300018:")

    def test_words_that_look_like_a_call(self):
        code = self.image.section(".TI.ramfunc").contents
        code[2:4] = lcr(0x300019)  # the address is not the begin of a function
        self.assert_passes(self.image)


class CallGraph(unittest.TestCase):
    """The functions that the interrupt calls, by the command lines of a build for the chip."""

    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name).resolve()
        cls.commands = chip_build.Build(chip_build.folder()).folder

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def check(self, elf, graph):
        elf.write(self.folder / "lagless.out")
        told = io.StringIO()
        with contextlib.redirect_stdout(told), contextlib.redirect_stderr(told):
            status = checker.main([str(self.folder / "lagless.out"), "--call-graph", str(graph), "--cc", graphs.CC])
        return status, told.getvalue()

    def test_the_functions_of_this_tree(self):
        status, told = self.check(good(), self.commands)
        self.assertEqual(status, 0, told)
        self.assertRegex(told, r"17 of 17 checks passed; 4 of the interrupt's \d{3} functions have a symbol")

    def test_a_function_of_this_tree_in_flash(self):
        elf = good()
        elf.define("drive_step", 0x300008, place=1)
        status, told = self.check(elf, self.commands / "compile_commands.json")
        self.assertEqual(status, 1, told)
        self.assertIn("interrupt: drive_step at 0x300008: .TI.ramfunc, 0x008000..0x00802f\n", told)

    def test_a_static_function_is_that_of_its_source(self):
        """interrupts.c has a static handler named unexpected; another source may have a function of that name in flash."""
        elf = good()
        elf.define("drive.asm", 0, FILE, LOCAL)
        elf.define("unexpected", 0x300008, FUNC, LOCAL, 1, 8)
        elf.define("interrupts.asm", 0, FILE, LOCAL)
        self.assertEqual(self.check(elf, self.commands)[0], 0)
        elf.define("unexpected", 0x300010, FUNC, LOCAL, 1, 8)
        status, told = self.check(elf, self.commands)
        self.assertEqual(status, 1, told)
        self.assertIn("interrupt: unexpected of hal/f28335/interrupts.c at 0x300010: .TI.ramfunc, ", told)
        self.assertNotIn("0x300008", told)

    def test_what_is_not_a_call_graph_is_refused(self):
        for name, text, status, why in (
                ("graph.json", '[{"directory": "/"}]', 2, "accepted: the compile_commands.json of a build for the chip"),
                ("names", "app_interrupt\nint main(void)\n", 2, "names:2: 'int main(void)' is not the name of a function"),
                ("names", "# none\n", 2, "names no function; accepted: one a line"), ("nothing", None, 3, "nothing")):
            if text:
                (self.folder / name).write_text(text, encoding="utf-8")
            told = self.check(good(), self.folder / name)
            self.assertEqual((told[0], why in told[1]), (status, True), told)


if __name__ == "__main__":
    if checker.ELFFile is None:
        sys.exit(f"pyelftools is missing for {sys.executable}: tools/setup installs it (Debian: python3-pyelftools)")
    unittest.main(argv=sys.argv[:1] + sys.argv[2:])
