#!/usr/bin/env python3
"""Tests of tools/cost: the cost of a load, a store and a constant of the M4F on a C28x. (tools/check compares its sums with
tools/target/cost.json.) The expected values follow from the addressing modes of the C28x: *+XARn[3 bits], *-SP[6 bits], *XARn++,
*+XARn[AR0] after a load of AR0; MOVIZ and MOVXI; MOVL XARn with 22 bits."""
import contextlib
import io
import json
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import tool  # noqa: E402

cost = tool.load("cost")

IN_REACH = (1, 1, 1)
BEYOND = (1.5, 1.95, 2)  # with the load of the index register before it: in half of the cases, in 19 of 20, in all
BY_INDEX = (2, 4, 6)

ACCESSES = [  # a line as QEMU writes it, and the cycles of each word that it transfers
    ("vldr     s15, [r0]", [IN_REACH]),
    ("vldr     s15, [r0, #4]", [IN_REACH]),
    ("vldr     s15, [r0, #0xc]", [IN_REACH]),  # words 6 and 7: the last float that 3 bits can address
    ("vldr     s15, [r0, #0x10]", [BEYOND]),  # word 8
    ("vstr     s15, [r4, #0x3ac]", [BEYOND]),
    ("ldr      r3, [r1, #0xc]", [IN_REACH]),
    ("ldr.w    r3, [r0, #0x164]", [BEYOND]),
    ("str      r3, [r1, #0x10]", [BEYOND]),
    ("ldrb.w   fp, [r0, #0xf]", [IN_REACH]),
    ("ldrh     r2, [r0, #0x10]", [BEYOND]),
    ("vldrle   s21, [r0, #0x80]", [BEYOND]),  # an instruction that an IT block skips takes its time too
    ("ldr      r3, [r0, #-0x4]", [BEYOND]),  # the 3 bits have no sign
    ("ldrd     r0, r3, [r4, #8]", [IN_REACH, IN_REACH]),
    ("strd     r0, r3, [r4, #0xc]", [IN_REACH, BEYOND]),  # words 6 and 8
    ("strd     r0, r3, [r4, #0x3ac]", [BEYOND, BEYOND]),
    ("vldr     s0, [sp, #0x10]", [IN_REACH]),
    ("str      r0, [sp, #0x7c]", [IN_REACH]),  # word 62: the last float that 6 bits can address
    ("str      r0, [sp, #0x80]", [BEYOND]),  # word 64
    ("ldrd     r0, r1, [sp, #0x7c]", [IN_REACH, BEYOND]),
    ("push.w   {r4, r5, r6, lr}", [IN_REACH] * 4),  # *SP++
    ("vpush    {s16, s17}", [IN_REACH] * 2),
    ("ldm      r3, {r0, r1, r2, r3}", [IN_REACH] * 4),  # *XARn++
    ("stmdb    r4, {r2, r3}", [IN_REACH] * 2),
    ("ldr      r0, [r1], #4", [IN_REACH]),
    ("str      r3, [r2, #0x40]!", [IN_REACH]),  # the instruction changes the pointer
    ("ldr.w    r3, [r2, r3, lsl #2]", [BY_INDEX]),
    ("ldrh.w   r0, [r0, r1, lsl #1]", [BY_INDEX]),
]
CONSTANTS = [  # a line, the constant after the code, the cycles
    ("vldr     s10, [pc, #0x35c]", 0x3F000000, (1, 1, 1)),  # 0.5 needs MOVIZ alone
    ("vldr     s10, [pc, #0x35c]", 0xC0490000, (1, 1, 1)),
    ("vldr     s10, [pc, #0x35c]", 0x40490FDA, (2, 2, 2)),  # pi needs MOVIZ and MOVXI
    ("vldr     s10, [pc, #0x35c]", 0x3F808000, (2, 2, 2)),
    ("vldrle   s10, [pc, #0x35c]", 0x00000001, (2, 2, 2)),
    ("ldr      r5, [pc, #0x2d0]", 0x003FFFFF, (1, 1, 1)),  # 22 bits fit MOVL
    ("ldr      r5, [pc, #0x2d0]", 0x00400000, (2, 2, 2)),
    ("ldr      r5, [pc, #0x2d0]", 0xFFFFFFFF, (2, 2, 2)),
]
ENDS = [("pop      {r4, pc}", "return"), ("ldr      pc, [sp], #4", "return"), ("pop      {r4, r5}", None),
        ("ldr      r3, [r0, #4]", None), ("bx       lr", "return"), ("bl       #0x2300", "call"),
        ("cbz      r3, #0x3746", "branch")]


KINDS = [("vmul.f32 s10, s13, s11", "float arithmetic"), ("vdiv.f32 s10, s13, s11", "float arithmetic"),
         ("vcmpe.f32 s10, s13", "compare of floats"), ("vmrs     apsr_nzcv, fpscr", "compare of floats"),
         ("vldr     s10, [pc, #0x35c]", "constant"), ("vldr     s15, [r0]", "load"), ("ldrd     r0, r3, [r4, #8]", "load"),
         ("str      r3, [r1, #0x10]", "store"), ("vmovmi.f32 s19, s10", "move between registers"),
         ("ite      mi", "choice (IT)"), ("beq.w    #0x3746", "branch"), ("bl       #0x2300", "call, return"),
         ("addw     r3, r4, #0x60c", "integer"), ("push.w   {r4, r5, r6, lr}", "registers saved, structs copied"),
         ("ldm      r3, {r0, r1, r2, r3}", "registers saved, structs copied")]


def weights(line, literals=()):
    names, _ = cost.classify(*line.split(maxsplit=1), literals)
    return [cost.WEIGHTS[name] for name in names]


def refusal(action, *arguments):
    """The exit code and the message of a case that must stop."""
    message = io.StringIO()
    with contextlib.redirect_stderr(message):
        try:
            action(*arguments)
        except SystemExit as end:
            return end.code, message.getvalue()
    return None, message.getvalue()


class Model(unittest.TestCase):
    def test_loads_and_stores_cost_by_how_far_they_reach(self):
        for line, expected in ACCESSES:
            with self.subTest(line):
                self.assertEqual(weights(line), expected)

    def test_constants_cost_by_the_immediates_that_they_take(self):
        for line, value, expected in CONSTANTS:
            with self.subTest(line, value=hex(value)):
                self.assertEqual(weights(line, [value]), [expected])

    def test_address_that_is_not_known_is_named(self):
        code, message = refusal(weights, "ldr      r0, [r1, #4")
        self.assertEqual(code, 2)
        self.assertIn("ldr r0, [r1, #4:", message)

    def test_blocks_end_where_the_program_counter_is_set(self):
        for line, expected in ENDS:
            with self.subTest(line):
                self.assertEqual(cost.classify(*line.split(maxsplit=1))[1], expected)

    def test_block_counts_each_access_and_takes_constants_from_beside_the_code(self):
        # At 0x1002 the program counter reads 0x1006; a constant is addressed from 0x1004.
        asked = []

        def word(address):
            asked.append(address)
            return 0x40490FDA

        block = cost.Block([(0x1000, 2, "ldrd", "r0, r3, [r4, #0xc]"), (0x1002, 4, "vldr", "s10, [pc, #0xc]"),
                            (0x1006, 4, "pop.w", "{r4, pc}")], word)
        self.assertEqual(asked, [0x1010])
        self.assertEqual(block.classes, {cost.NEAR: 3, cost.FAR: 1, cost.LONG: 1, "return": 1})
        self.assertEqual((block.count, block.end, block.following), (3, "return", 0x100A))

    def test_instructions_are_distinguished_by_what_they_do(self):
        for line, expected in KINDS:
            with self.subTest(line):
                self.assertEqual(cost.kind_of(*line.split(maxsplit=1)), expected)


def entered(*blocks):
    """The output of QEMU: a listing of each block, and a line for each block that is entered. A block is an address and its code."""
    lines, numbers, text = [], {}, ""
    for address, listing in blocks:
        if address not in numbers:
            numbers[address] = len(numbers)
            lines += ["----------------", "IN: ", *(f"{address + 4 * n:#x}:  bf00 bf00  {line}" for n, line in enumerate(listing)), ""]
        text += chr(numbers[address])
    return cost.listings_of(lines), text


class Entered(unittest.TestCase):
    """The sum over the blocks that QEMU has entered."""

    STEP, INNER, OTHER = 0x100, 0x200, 0x300

    def trace(self, *blocks):
        trace = cost.Trace({self.STEP: ("drive_step", 0x180), self.INNER: ("inner", 0x280), self.OTHER: ("other", 0x380)}, {}, [], None, "drive_step")
        return trace.interrupts(*entered(*blocks))

    def test_interrupt_ends_where_its_step_returns(self):
        call = (self.STEP, ["nop      ", "bl       #0x200"])
        inner = (self.INNER, ["nop      ", "nop      ", "bx       lr"])
        rest = (self.STEP + 8, ["bx       lr"])
        beside = (self.OTHER, ["nop      "] * 9 + ["bx       lr"])  # a function that the replay itself calls
        interrupts = self.trace(call, inner, rest, beside, beside, call, inner, rest)
        self.assertEqual([i.count for i in interrupts], [6, 6])
        self.assertEqual(interrupts[0].calls, {"drive_step": 6, "inner": 3})

    def test_a_listing_that_is_not_understood_is_shown(self):
        code, message = refusal(cost.listings_of, ["IN: ", "0x100:  bf00  .byte 0"])
        self.assertEqual(code, 2)
        self.assertIn("0x100:  bf00  .byte 0", message)


class Tree(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.file = pathlib.Path(folder.name) / "hal.h"

    def test_budget_is_a_carrier_period_of_the_board(self):
        text = (cost.ROOT / cost.BOARD).read_text()
        for hertz, expected in ((10000, 15000), (5000, 30000), (20000, 7500)):  # [Hz], [cycles] of the 150 MHz clock
            self.file.write_text(text.replace("BOARD_CARRIER_HZ 10000", f"BOARD_CARRIER_HZ {hertz}"))
            self.assertEqual(cost.period_cycles(self.file), expected)

    def test_readme_shows_the_committed_numbers(self):
        committed = json.loads(cost.COMMITTED.read_text())
        shown = cost.marks.written("cost", cost.DOCUMENT)
        self.assertEqual(shown, cost.readme_table(committed, cost.period_cycles()))

    def test_longest_interrupt_may_take_half_of_a_period_of_a_c28x(self):
        self.assertEqual(cost.limits_of()["isr_cycles_c28x_most"], 7500)  # half of the 15000 cycles at 10 kHz

    def test_a_board_without_a_carrier_is_named(self):
        self.file.write_text("#define BOARD_NAME \"nothing\"\n")
        for absent in (self.file, self.file.with_name("moved.h")):
            code, message = refusal(cost.period_cycles, absent)
            self.assertEqual(code, 2)
            self.assertIn(f"{absent} gives no carrier period", message)


class Words(unittest.TestCase):
    """The number of words of a C28x, with sizes by SPRU430 and SPRUEO2 and the rates that tools/target/c28x_words.py names."""

    def of(self, *lines, pool=""):
        text = "00000000 <f>:\n" + "".join(f"   {4 * n:x}:\t{code}\n" for n, code in enumerate(lines)) + pool
        return [round(words, 2) for words in cost.c28x_words.of_listing(text)["f"]]

    def test_a_float_operation_between_load_and_return(self):
        # MOV32, then ADDF32 with 0.2, 0.4 or 0.83 NOPs, then LRETR.
        self.assertEqual(self.of("ed90 0a00 \tvldr\ts0, [r0]", "ee30 0a20 \tvadd.f32\ts0, s0, s1", "4770      \tbx\tlr"),
                         [5.2, 5.4, 5.83])

    def test_what_lies_beyond_eight_words_takes_an_index_register(self):
        self.assertEqual(self.of("ed90 0a03 \tvldr\ts0, [r0, #12]"), [2, 2, 2])
        self.assertEqual(self.of("ed90 0a04 \tvldr\ts0, [r0, #16]"), [2.5, 3, 3])
        self.assertEqual(self.of("6901      \tldr\tr1, [r0, #16]"), [1.5, 2, 3])
        self.assertEqual(self.of("9910      \tldr\tr1, [sp, #64]"), [1, 1, 2])


if __name__ == "__main__":
    unittest.main()
