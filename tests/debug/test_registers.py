#!/usr/bin/env python3
"""The debugger's helpers without gdb: bit fields of the registers, compared with hal/f28335/registers.h, and the conversion of times.

usage: test_registers.py --root FOLDER"""
import argparse
import pathlib
import re
import sys
import unittest

PARSER = argparse.ArgumentParser()
PARSER.add_argument("--root", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parents[2])
ROOT = PARSER.parse_known_args()[0].root

sys.dont_write_bytecode = True
sys.path.insert(0, str(ROOT / "tools" / "gdb"))
import lagless_registers as registers  # noqa: E402
import lagless_time as time  # noqa: E402

# The first word of a macro's name, and the registers whose fields it names.
REGISTERS = {
    "TCR": [("CPUTIMER0", "TCR")],
    "FOPT": [("FLASH", "FOPT")],
    "PIECTRL": [("PIE", "PIECTRL")],
    "AQCTL": [("EPWM1", "AQCTLA"), ("EPWM1", "AQCTLB")],
    "TZ": [("EPWM1", "TZFLG"), ("EPWM1", "TZCLR")],
    "ET_FLAG": [("EPWM1", "ETFLG"), ("EPWM1", "ETCLR")],
    "QEP": [("EQEP1", "QFLG"), ("EQEP1", "QEINT"), ("EQEP1", "QCLR")],
}
for block, names in {
    "SYSCTRL": "PLLSTS PCLKCR0 PCLKCR1 PCLKCR3 SCSR WDCR",
    "EPWM1": "TBCTL TBSTS CMPCTL DBCTL TZSEL TZCTL ETSEL ETPS",
    "EQEP1": "QDECCTL QEPCTL QEPSTS",
    "ADC": "ADCTRL1 ADCTRL2 ADCTRL3 ADCST",
}.items():
    REGISTERS.update({name: [(block, name)] for name in names.split()})

# Macros that are a value of a field and not its mask.
VALUES = {"TBCTL_PHSDIR_UP": "PHSDIR", "DBCTL_POLSEL_ALC": "POLSEL"}
FIELD = re.compile(
    r"^#define (?P<macro>(?P<register>" + "|".join(sorted(REGISTERS, key=len, reverse=True)) + r")_(?P<field>\w+))"
    r"(?:\(n\))?\s+(?:\\\n\s*)?(?:\(1u << (?P<bit>\d+)\)|\(\(uint16_t\)(?:\(n\)|\(\(n\) << (?P<shift>\d+)\))\))",
    re.MULTILINE,
)


class FieldTest(unittest.TestCase):
    def test_every_field_of_the_header_is_decoded_at_its_place(self):
        header = (ROOT / "hal" / "f28335" / "registers.h").read_text()
        found = list(FIELD.finditer(header))
        self.assertGreater(len(found), 70, "the header is not read as it should be")
        for match in found:
            name = VALUES.get(match["macro"], match["field"])
            low = int(match["bit"] or match["shift"] or 0)
            for block, register in REGISTERS[match["register"]]:
                places = {field[0]: field[1] for field in registers.fields_of(block, register)}
                self.assertEqual(places.get(name), low, f"{match['macro']}: field {name} of {block}.{register}")

    def test_fields_neither_overlap_nor_leave_their_register(self):
        for block in "EPWM1 EQEP1 ADC SYSCTRL FLASH CPUTIMER0 PIE".split():
            for register, fields in getattr(registers, block.rstrip("01")).items():
                self.check_fields(f"{block}.{register}", fields, 16)
        for port, name in enumerate(("GPIOA", "GPIOB", "GPIOC")):
            for register, fields in registers.gpio_fields(port).items():
                self.assertEqual(registers.fields_of(name, register), fields)
                self.check_fields(f"{name}.{register}", fields, 32)

    def check_fields(self, register, fields, width):
        taken = 0
        for name, low, bits, meanings in fields:
            mask = ((1 << bits) - 1) << low
            self.assertEqual(taken & mask, 0, f"{register}.{name} overlaps")
            self.assertLess(mask, 1 << width, f"{register}.{name} leaves its register")
            taken |= mask
            if isinstance(meanings, str):
                self.assertLessEqual(len(meanings.split("|")), 1 << bits, f"{register}.{name} has too many meanings")
        self.assertEqual(len(fields), len({field[0] for field in fields}), f"{register}: a name twice")

    def test_words_of_a_drive_read_as_meant(self):
        # A carrier of 10 kHz with dead band and one-shot trip; each register word by SPRUG04.
        for register, word, text in (
            ("TBCTL", 0x4012, "CTRMODE up-down, PRDLD shadow, SYNCOSEL CTR=0, HSPCLKDIV /1, CLKDIV /1, "
             "PHSDIR down after sync, FREE_SOFT halt: end of cycle"),
            ("TBCTL", 0x6006, "CTRMODE up-down, PHSEN, PRDLD shadow, SYNCOSEL SYNCI, HSPCLKDIV /1, CLKDIV /1, "
             "PHSDIR up after sync, FREE_SOFT halt: end of cycle"),
            ("AQCTLA", 0x0090, "CAU clear, CAD set"),
            ("DBCTL", 0x000B, "OUT_MODE both edges, POLSEL active high complementary, IN_MODE A"),
            ("TZSEL", 0x0100, "OSHT1"),
            ("TZCTL", 0x000A, "TZA low, TZB low"),
            ("TZEINT", 0x0004, "OST"),
            ("ETSEL", 0x0900, "SOCASEL CTR=0, SOCAEN"),
            ("ETPS", 0x0100, "SOCAPRD every"),
        ):
            self.assertEqual(registers.summary(registers.fields_of("EPWM1", register), word), text)

    def test_reset_value_shows_the_effective_divider(self):
        self.assertIn("HSPCLKDIV /2", registers.summary(registers.fields_of("EPWM3", "TBCTL"), 0x0083))

    def test_bits_outside_all_fields_are_shown(self):
        self.assertIn("other bits 0x8000", registers.summary(registers.fields_of("EPWM1", "TZFLG"), 0x8005))


class TimeTest(unittest.TestCase):
    def test_time_is_the_period_it_lies_in(self):
        for ticks, rows in ((15000, {"0.5 s": 5000, "500 ms": 5000, "0.5": 5000, "0": 0, "99.9us": 0, "100us": 1, "1e-4s": 1, "0.29999 s": 2999,
                                     "0.3s": 3000, ".1 s": 1000}),
                            (7500, {"49.9 us": 0, "50 us": 1, "1 s": 20000}), (30000, {"0.5 s": 2500, "199us": 0}),
                            (9378, {"62.51 us": 0, "62.52 us": 1, "1 s": 15994}),  # periods of 62.52 us: 15994.88 of them
                            (9374, {"62.492 us": 0, "62.494 us": 1})):  # periods of 62.4933.. us
            for text, period in rows.items():
                self.assertEqual(time.period_of_time(text, ticks), period, (text, ticks))

    def test_begin_of_a_period_is_exact_or_the_nearest_nanosecond_and_leads_back(self):
        for period, ticks, text in ((4294967294, 15000, "429496.7294 s"), (0, 15000, "0.0000 s"), (1, 7500, "0.00005 s"), (5000, 30000, "1.0000 s"),
                                    (16000, 9378, "1.00032000 s"), (1, 9374, "0.000062493 s"), (2, 9374, "0.000124987 s"), (3, 9374, "0.000187480 s")):
            self.assertEqual(time.seconds(period, ticks), text)
        for ticks in (7500, 9374, 9376, 9378, 15000, 30000):
            for period in (*range(50), 123456, 4294967290):
                self.assertEqual(time.period_of_time(time.seconds(period, ticks), ticks), period, ticks)

    def test_what_is_not_a_time_or_a_period_is_refused(self):
        self.assertEqual(time.period_number("4294967294"), 4294967294)
        for read, texts in ((lambda text: time.period_of_time(text, 15000), ("", "1 h", "-1 s", "one", "nan", "1,5 s", "1 s 2", "1e9 s", "1e999999999 s")),
                            (time.period_number, ("4294967295", "-1", "1.5", "", "0x10"))):
            for text in texts:
                with self.assertRaises(ValueError, msg=text):
                    read(text)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]])
