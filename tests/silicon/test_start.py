#!/usr/bin/env python3
"""Executes the assembly sources of the chip instruction by instruction: codestart.asm, from the entry of the boot ROM to the run-time
library, and bus_debug_groups(). The few instructions are simulated by SPRU430; any other instruction is an error.

The expected values follow from SPRUFB0, chapter 3: 0x68 (WDDIS, WDCHK 101) in WDCR at 0x7029 turns the watchdog off, and the write is
accepted only between EALLOW and EDIS.
"""
import pathlib
import re
import unittest

HAL = pathlib.Path(__file__).resolve().parents[2] / "hal/f28335"
WDCR, OFF = 0x7029, 0x68
TURNS = 20


def number(text, names):
    """The number that #constant, NAME, 0a5h, or one of these >> a number, represents."""
    value, *shift = text.lstrip("#").split(">>")
    value = value.strip()
    value = names[value] if value in names else int(value[:-1], 16) if value.lower().endswith("h") else int(value, 0)
    return value >> int(shift[0]) if shift else value


class Cpu:
    """The registers that these instructions change; `source` is the text of a file."""

    def __init__(self, source):
        self.program, self.labels, self.names = [], {}, {}
        self.written, self.allowed, self.objmode, self.dp = [], False, False, None
        self.al, self.dbgier, self.stack, self.sections = 0, None, [], []
        section = None
        for line in source.splitlines():
            line = line.split(";")[0].rstrip()
            if match := re.match(r"(\w+)\s+\.set\s+(\S+)$", line):
                self.names[match[1]] = number(match[2], self.names)
                continue
            if match := re.match(r"(\w+):", line):
                self.labels[match[1]] = len(self.program)
                line = line[match.end():]
            word, *rest = line.split(None, 1) or [""]
            if word == ".sect":
                section = rest[0].strip('"')
                self.sections.append(section)
            elif word and word not in (".ref", ".def", ".end"):
                self.program.append((section, word, [part.strip() for part in rest[0].split(",")] if rest else []))

    def run(self, at):
        """Runs from this address until the code leaves the file; returns the target."""
        for _ in range(TURNS):
            _, word, operands = self.program[at]
            at += 1
            if word == "LB":
                if operands[0] not in self.labels:
                    return operands[0]
                at = self.labels[operands[0]]
            elif word == "LRETR":
                return "return"
            elif (word, operands) == ("SETC", ["OBJMODE"]):
                self.objmode = True
            elif word in ("EALLOW", "EDIS"):
                self.allowed = word == "EALLOW"
            elif (word, operands[:1]) == ("MOVZ", ["DP"]):
                self.dp = number(operands[1], self.names)
            elif word == "MOV" and operands[0].startswith("@") and operands[1].startswith("#"):
                address = self.dp << 6 | number(operands[0][1:], self.names) & 0x3F
                self.written.append((address, number(operands[1], self.names), self.allowed, self.objmode))
            elif (word, operands) == ("MOV", ["*SP++", "AL"]):
                self.stack.append(self.al)
            elif (word, operands) == ("POP", ["DBGIER"]):
                self.dbgier = self.stack.pop()
            else:
                raise ValueError(f"{word} {', '.join(operands)}: an instruction that this test does not know")
        raise ValueError("no end")


class Codestart(unittest.TestCase):
    source = (HAL / "codestart.asm").read_text()

    def test_the_watchdog_is_stopped_before_the_library_starts(self):
        cpu = Cpu(self.source)
        self.assertEqual(cpu.run(cpu.labels["code_start"]), "_c_int00")
        self.assertEqual(cpu.written, [(WDCR, OFF, True, True)])
        self.assertFalse(cpu.allowed)

    def test_the_entry_is_one_long_branch(self):
        cpu = Cpu(self.source)
        self.assertEqual([word for section, word, _ in cpu.program if section == "codestart"], ["LB"])
        self.assertEqual(cpu.labels["code_start"], 0)
        self.assertIn(".def    code_start", self.source)


class DebugGroups(unittest.TestCase):
    def test_the_argument_goes_to_dbgier_and_the_stack_is_as_before(self):
        cpu = Cpu((HAL / "debug.asm").read_text())
        cpu.al = 0x2001
        self.assertEqual(cpu.run(cpu.labels["bus_debug_groups"]), "return")
        self.assertEqual((cpu.dbgier, cpu.stack), (0x2001, []))


class Sources(unittest.TestCase):
    def test_there_are_no_others(self):
        self.assertEqual(sorted(path.name for path in HAL.glob("*.asm")), ["codestart.asm", "debug.asm"])


if __name__ == "__main__":
    unittest.main()
