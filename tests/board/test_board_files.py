#!/usr/bin/env python3
"""hal/board.h rejects a board file with a mistake. Each fact of a good board file is removed, and each kind of mistake is made in it; the
compiler must report an error that names docs/board.md and the line of its table. The guide must list the facts that the header checks,
under the same numbers. The compilers are CC and, if installed, clang."""
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import unittest

PROJECT = pathlib.Path(__file__).resolve().parents[2]
HEADERS = (PROJECT / "hal/board.h", PROJECT / "hal/board_check.h")
GUIDE = PROJECT / "docs/board.md"
BOARDS = [*sorted((PROJECT / "hal/f28335/boards").glob("*.h")), PROJECT / "tests/board/desk48.h", PROJECT / "tests/board/pump325.h"]
GOOD = PROJECT / "tests/board/desk48.h"  # this file states every fact, also the optional one of line 5
KIT = PROJECT / "hal/f28335/boards/hvmtrpfckit.h"
CC = shlex.split(os.environ.get("CC", "cc"))
CLANG = shutil.which("clang")
STRICT = ["-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Werror"]
FACT = re.compile(r"^#define (BOARD_\w+)[ \t]", re.MULTILINE)

# Every macro of the header whose value the firmware, the HAL or the simulation uses.
USES = """#include "hal/board.h"
const int uses[] = {BOARD_PERIOD_COUNT, BOARD_DEAD_BAND_MIN, BOARD_SINK_MAX, BOARD_MOTOR_MAX, BOARD_CURRENT_SENSORS,
                    BOARD_ADC_PRESCALE, BOARD_PLL_TIMES, HAL_GATE_ACTIVE_HIGH};
const float scales[] = {BOARD_CURRENT_RANGE, BOARD_CURRENT_PER_CODE, BOARD_DC_PER_CODE, BOARD_PERIOD};
"""


def compiled(board, *options, compiler=None, action="-S"):
    """The messages of the compiler for hal/board.h with this board file; "" if there are none. The action -E runs only the preprocessor,
    which takes a third of the time."""
    command = [*(compiler or CC), *STRICT, f"-I{PROJECT}", f'-DLAGLESS_BOARD_FILE="{board}"', *options, "-x", "c", "-", action, "-o",
               os.devnull]
    done = subprocess.run(command, input=USES, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    return done.stdout if done.returncode != 0 or done.stdout else ""


def header_text():
    return "".join(header.read_text(encoding="utf-8") for header in HEADERS)


def without(text, name):
    """The board file without one #define and its continuation lines."""
    changed, count = re.subn(rf"^#define {name}[ \t](?:.*\\\n)*.*\n", "", text, flags=re.MULTILINE)
    assert count == 1, name
    return changed


def with_value(text, name, value):
    return without(text, name) + f"#define {name} {value}\n"


def errors(output):
    """The line numbers of docs/board.md that the errors of a compilation name, in their order, and the texts."""
    return [(int(number), text) for number, text in re.findall(r"docs/board\.md, line (\d+): (.*?)\"", output)]


class BoardFileTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.file = pathlib.Path(self.folder.name) / "wrong.h"

    def tearDown(self):
        self.folder.cleanup()

    def output(self, text, *options, action="-S"):
        self.file.write_text(text, encoding="utf-8")
        return compiled(self.file, *options, action=action)

    def expect_line(self, number, text, *options, says=""):
        """The first error names this line of the table and has this text."""
        output = self.output(text, *options, action="-E")
        found = errors(output)
        self.assertTrue(found, f"not refused, or without naming the guide:\n{output}")
        self.assertEqual(found[0][0], number, found)
        self.assertIn(says, found[0][1])


class GoodFiles(BoardFileTest):
    def test_each_board_compiles_clean(self):
        self.assertEqual(len(BOARDS), 6)
        for board in BOARDS:
            for compiler in [CC, *([[CLANG]] if CLANG else [])]:
                with self.subTest(board=board.name, compiler=compiler):
                    self.assertEqual(compiled(board, compiler=compiler), "")

    def test_values_at_the_limits_are_accepted(self):
        good = GOOD.read_text(encoding="utf-8")
        for name, value in [("BOARD_CARRIER_HZ", 5000), ("BOARD_CARRIER_HZ", 20000), ("BOARD_TRIP_ZONE", 1),
                            ("BOARD_CURRENT_C_INPUT", "BOARD_NONE"), ("BOARD_SINK_AT_3V", "93"), ("BOARD_LED_RUN", 87),
                            ("BOARD_SHORT_CIRCUIT_TRIP_MA", 0), ("BOARD_OVERCURRENT_TRIP_MA", 48579),
                            ("BOARD_OVERVOLTAGE_MAX_MV", 70560), ("BOARD_SERIAL_BAUD", 0), ("BOARD_ENABLE_INPUT", "BOARD_NONE"), ("BOARD_ENABLE_INPUT", 87),
                            ("BOARD_SERIAL_BAUD", 115200), ("BOARD_SERIAL_BAUD", 797193)]:  # the second rate is 2 % above 781250
            with self.subTest(name=name, value=value):
                self.assertEqual(self.output(with_value(good, name, value)), "")
        # a divider of 24:1, stated as a ratio
        ratio = with_value(with_value(good, "BOARD_DC_STEP_MV", 24), "BOARD_DC_PIN_MV", 1)
        self.assertEqual(self.output(ratio), "")
        # an eighth of the period at 5999 Hz is 20836 ns
        kit = with_value(KIT.read_text(encoding="utf-8"), "BOARD_CARRIER_HZ", 5999)
        self.assertEqual(self.output(with_value(kit, "BOARD_SHUNT_SETTLED_NS", 20836 - 2500)), "")


class MissingFacts(BoardFileTest):
    def test_each_missing_fact_is_reported_with_its_line(self):
        numbers = guide_facts()
        for path in BOARDS:
            text = path.read_text(encoding="utf-8")
            for name in FACT.findall(text):
                if name == "BOARD_GATE_ACTIVE_HIGH":  # the build may set it instead; the host then assumes active high
                    continue
                with self.subTest(board=path.name, name=name):
                    self.expect_line(numbers[name], without(text, name), says="missing")

    def test_an_open_polarity_of_the_gates_is_refused_on_the_chip(self):
        text = without(GOOD.read_text(encoding="utf-8"), "BOARD_GATE_ACTIVE_HIGH")
        self.expect_line(5, text, "-D__TMS320C2000__", says="-DLAGLESS_GATES=")
        self.assertEqual(self.output(text), "")
        self.assertEqual(self.output(text, "-D__TMS320C2000__", "-DHAL_GATE_ACTIVE_HIGH=0"), "")

    def test_no_board_on_the_chip_is_refused(self):
        done = subprocess.run([*CC, f"-I{PROJECT}", "-D__TMS320C2000__", "-fsyntax-only", "-x", "c", "-"], input=USES,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("no board is chosen: -DLAGLESS_BOARD=", done.stdout)


class Mistakes(BoardFileTest):
    # line of the table, part of the message, changed facts
    CASES = [
        (2, "20 to 35 MHz", {"BOARD_CRYSTAL_HZ": 19999000}),
        (2, "20 to 35 MHz", {"BOARD_CRYSTAL_HZ": 36000000}),
        (2, "75 to 150 MHz", {"BOARD_CRYSTAL_HZ": 30000000, "BOARD_SYSCLK_HZ": 151000000}),
        (2, "75 to 150 MHz", {"BOARD_SYSCLK_HZ": 70000000}),
        (2, "gives no such", {"BOARD_SYSCLK_HZ": 150000000}),
        (2, "gives no such", {"BOARD_CRYSTAL_HZ": 30000000}),
        (3, "5000 to 20000", {"BOARD_CARRIER_HZ": 4999}),
        (3, "5000 to 20000", {"BOARD_CARRIER_HZ": 20001}),
        (4, "ePWM1, 2, 3 or ePWM4, 5, 6", {"BOARD_LEG_A": 1, "BOARD_LEG_B": 2, "BOARD_LEG_C": 4}),
        (4, "ePWM1, 2, 3 or ePWM4, 5, 6", {"BOARD_LEG_A": 2, "BOARD_LEG_B": 3, "BOARD_LEG_C": 4}),
        (4, "each once", {"BOARD_LEG_B": 5}),
        (4, "ePWM1, 2, 3 or ePWM4, 5, 6", {"BOARD_LEG_A": 7}),
        (5, "0 or 1", {"BOARD_GATE_ACTIVE_HIGH": 2}),
        (6, "1 to 6", {"BOARD_TRIP_ZONE": 7}),
        (6, "1 to 6", {"BOARD_TRIP_ZONE": 0}),
        (6, "BOARD_TRIP_PULL_UP is 0 or 1", {"BOARD_TRIP_PULL_UP": 2}),
        (7, "from 50", {"BOARD_DEAD_BAND_MIN_NS": 49}),
        (7, "shoot through", {"BOARD_DEAD_TIME_NS": 321}),
        (7, "1023 cycles", {"BOARD_DEAD_TIME_NS": 10231}),
        (7, "0 to 10000", {"BOARD_MINIMUM_PULSE_NS": 10001}),
        (8, "a sensor each", {"BOARD_CURRENT_A_INPUT": "BOARD_NONE"}),
        (8, "BOARD_CURRENT_C_INPUT is BOARD_ADC_A", {"BOARD_CURRENT_C_INPUT": 16}),
        (8, "must be a pair", {"BOARD_CURRENT_B_INPUT": "BOARD_ADC_A(4)"}),
        (8, "on one input", {"BOARD_CURRENT_B_INPUT": "BOARD_ADC_B(5)"}),
        (8, "input of current a or b", {"BOARD_CURRENT_C_INPUT": "BOARD_ADC_A(5)"}),
        (9, "300 to 2700", {"BOARD_CURRENT_ZERO_MV": 299}),
        (9, "300 to 2700", {"BOARD_CURRENT_ZERO_MV": 2701}),
        (9, "no scale", {"BOARD_CURRENT_STEP_MA": 0}),
        (9, "no scale", {"BOARD_CURRENT_STEP_MV": -1320}),
        (10, "BOARD_UPPER_ZERO_VECTOR or BOARD_LOWER_ZERO_VECTOR", {"BOARD_SAMPLES_AT": 2}),
        (10, "an eighth of a carrier period",
         {"BOARD_SAMPLES_AT": "BOARD_LOWER_ZERO_VECTOR", "BOARD_SHUNT_SETTLED_NS": 125000000 // 10000 - 400 + 1}),
        (10, "0 at the upper zero vector", {"BOARD_SHUNT_SETTLED_NS": 1}),
        (11, "BOARD_DC_INPUT is BOARD_ADC_A", {"BOARD_DC_INPUT": "BOARD_NONE"}),
        (11, "no scale", {"BOARD_DC_PIN_MV": 0}),
        (11, "input of a current", {"BOARD_DC_INPUT": "BOARD_ADC_B(2)"}),
        (12, "BOARD_SINK_INPUT is BOARD_ADC_A", {"BOARD_SINK_INPUT": 16}),
        (12, "BOARD_MOTOR_INPUT is BOARD_ADC_A", {"BOARD_MOTOR_INPUT": -1, "BOARD_MOTOR_AT_0V": 0, "BOARD_MOTOR_AT_3V": 150}),
        (12, "BOARD_MOTOR_AT_0V or BOARD_MOTOR_AT_3V is missing", {"BOARD_MOTOR_INPUT": "BOARD_ADC_A(7)"}),
        (12, "of a current or of the link", {"BOARD_SINK_INPUT": "BOARD_ADC_A(0)"}),
        (12, "another signal", {"BOARD_MOTOR_INPUT": "BOARD_ADC_A(6)", "BOARD_MOTOR_AT_0V": 0, "BOARD_MOTOR_AT_3V": 150}),
        (12, "must be able to measure the trip temperature, 90 degC", {"BOARD_SINK_AT_3V": 90}),
        (12, "must be able to measure the trip temperature, 130 degC",
         {"BOARD_MOTOR_INPUT": "BOARD_ADC_A(7)", "BOARD_MOTOR_AT_0V": 130, "BOARD_MOTOR_AT_3V": -50}),
        (13, "BOARD_EQEP1_GPIO20, BOARD_EQEP1_GPIO50 or BOARD_EQEP2_GPIO24", {"BOARD_ENCODER": 3}),
        (14, "0 to 87, or BOARD_NONE", {"BOARD_LED_RUN": 88}),
        (14, "0 to 87, or BOARD_NONE", {"BOARD_LED_FAULT": -1}),
        (14, "a pin of a gate", {"BOARD_LED_RUN": 6}),
        (14, "of the fault line", {"BOARD_LED_FAULT": 17}),
        (14, "of the encoder", {"BOARD_LED_FAULT": 27}),
        (14, "one pin", {"BOARD_LED_FAULT": 32}),
        (14, "BOARD_LED_ACTIVE_LOW is 0 or 1", {"BOARD_LED_ACTIVE_LOW": 2}),
        (15, "0 to 5000", {"BOARD_TURN_ON_DELAY_NS": 5001}),
        (15, "exceeds dead time", {"BOARD_TURN_OFF_DELAY_NS": 521}),
        (15, "BOARD_IGBT_DROP_MV", {"BOARD_IGBT_DROP_MV": -1}),
        (15, "BOARD_DIODE_SLOPE_UOHM", {"BOARD_DIODE_SLOPE_UOHM": 1000001}),
        (15, "more than BOARD_OVERCURRENT_TRIP_MA", {"BOARD_SHORT_CIRCUIT_TRIP_MA": 45000}),
        (16, "up to 95 %", {"BOARD_OVERCURRENT_TRIP_MA": 48580}),
        (16, "from 1.2 BOARD_CURRENT_LIMIT_MA", {"BOARD_OVERCURRENT_TRIP_MA": 35999}),
        (16, "BOARD_CURRENT_LIMIT_MA is accepted", {"BOARD_CURRENT_LIMIT_MA": 0}),
        (16, "BOARD_UNDERVOLTAGE_MV is accepted", {"BOARD_UNDERVOLTAGE_MV": 9999}),
        (16, "BOARD_UNDERVOLTAGE_MV < BOARD_DC_NOMINAL_MV", {"BOARD_UNDERVOLTAGE_MV": 48000}),
        (16, "BOARD_UNDERVOLTAGE_MV < BOARD_DC_NOMINAL_MV", {"BOARD_DC_NOMINAL_MV": 60000}),
        (16, "10 V between", {"BOARD_OVERVOLTAGE_MV": 50000, "BOARD_UNDERVOLTAGE_MV": 40001}),
        (16, "<= BOARD_OVERVOLTAGE_MAX_MV", {"BOARD_OVERVOLTAGE_MAX_MV": 59999}),
        (17, "BOARD_MODULE_CONTINUOUS_MA is accepted", {"BOARD_MODULE_CONTINUOUS_MA": 99}),
        (17, "BOARD_MODULE_TIME_MS is accepted", {"BOARD_MODULE_TIME_MS": 0}),
        (17, "BOARD_GATE_CHARGE_US is accepted", {"BOARD_GATE_CHARGE_US": -1}),
        (17, "BOARD_GATE_CHARGE_US is accepted", {"BOARD_GATE_CHARGE_US": 100001}),
        (16, "98 % of the largest link voltage that the ADC can measure", {"BOARD_OVERVOLTAGE_MAX_MV": 70561}),
        (18, "0 (no line) or accepted from 115200 to 2343750", {"BOARD_SERIAL_BAUD": 115199}),
        (18, "0 (no line) or accepted from 115200 to 2343750", {"BOARD_SERIAL_BAUD": 2343751}),
        (18, "not within 2 %", {"BOARD_SERIAL_BAUD": 797194}),
        (18, "not within 2 %", {"BOARD_SERIAL_BAUD": 2343750}),
        (18, "BOARD_SERIAL_PINS is BOARD_SCIA_GPIO28 or BOARD_SCIA_GPIO35", {"BOARD_SERIAL_PINS": 2}),
        (18, "those of BOARD_LED_RUN or BOARD_LED_FAULT", {"BOARD_LED_RUN": 36}),
        (19, "BOARD_ENABLE_INPUT is the number of a GPIO, 0 to 87, or BOARD_NONE", {"BOARD_ENABLE_INPUT": 88}),
        (19, "BOARD_ENABLE_INPUT is the number of a GPIO, 0 to 87, or BOARD_NONE", {"BOARD_ENABLE_INPUT": -1}),
        (19, "a pin of a gate", {"BOARD_ENABLE_INPUT": 11}),
        (19, "the fault line", {"BOARD_ENABLE_INPUT": 17}),
        (19, "the encoder", {"BOARD_ENABLE_INPUT": 24}),
        (19, "is a pin of a gate, the fault line, the encoder, a light or the serial line", {"BOARD_ENABLE_INPUT": 61}),
        (19, "the serial line", {"BOARD_ENABLE_INPUT": 36}),
        (19, "BOARD_ENABLE_ACTIVE_HIGH is 0 or 1", {"BOARD_ENABLE_ACTIVE_HIGH": 2}),
        (19, "BOARD_ENABLE_DEBOUNCE_US is accepted from 0 to 20000", {"BOARD_ENABLE_DEBOUNCE_US": 20001}),
        (20, "BOARD_STORE is BOARD_STORE_FLASH or BOARD_STORE_I2C", {"BOARD_STORE": 2}),
        (20, "BOARD_STORE_WRITE_US is missing", {"BOARD_STORE": "BOARD_STORE_I2C"}),
        *[(20, says, {"BOARD_LED_RUN": "BOARD_NONE", "BOARD_STORE": "BOARD_STORE_I2C", "BOARD_STORE_PINS": "BOARD_I2CA_GPIO32",
                      "BOARD_STORE_ADDRESS": 0x50, "BOARD_STORE_PAGE_OCTETS": 64, "BOARD_STORE_WRITE_US": 5000, **changed})
          for says, changed in [("the driver uses no other pins", {"BOARD_STORE_PINS": 1}),
                                ("those of BOARD_LED_RUN, BOARD_LED_FAULT or BOARD_ENABLE_INPUT", {"BOARD_LED_RUN": 33}),
                                ("those of BOARD_LED_RUN, BOARD_LED_FAULT or BOARD_ENABLE_INPUT", {"BOARD_ENABLE_INPUT": 32}),
                                ("0x50 to 0x57", {"BOARD_STORE_ADDRESS": 0x58}), ("0x50 to 0x57", {"BOARD_STORE_ADDRESS": 0x4F}),
                                ("multiple of 8", {"BOARD_STORE_PAGE_OCTETS": 12}), ("up to 128", {"BOARD_STORE_PAGE_OCTETS": 136}),
                                ("0 (none) to 20000", {"BOARD_STORE_WRITE_US": 20001})]],
        (21, "the number of a GPIO, 0 to 87, or BOARD_NONE", {"BOARD_CHOPPER_OUTPUT": 88}),
        (21, "the number of a GPIO, 0 to 87, or BOARD_NONE", {"BOARD_BRAKE_OUTPUT": -1}),
        *[(21, "is a pin of lines 4, 6, 13, 14, 18, 19 or 20", {name: pin}) for name in ("BOARD_CHOPPER_OUTPUT", "BOARD_BRAKE_OUTPUT")
          for pin in (11, 17, 24, 32, 36, 50)],
        (21, "are one pin", {"BOARD_BRAKE_OUTPUT": 58}),
        (21, "BOARD_CHOPPER_ACTIVE_HIGH is 0 or 1", {"BOARD_CHOPPER_ACTIVE_HIGH": 2}),
        (21, "BOARD_CHOPPER_CURRENT_MA is accepted from 100 to 1000000", {"BOARD_CHOPPER_CURRENT_MA": 99}),
        (21, "BOARD_BRAKE_ACTIVE_HIGH is 0 or 1", {"BOARD_BRAKE_ACTIVE_HIGH": 2}),
    ]

    def test_each_mistake_names_the_line(self):
        good = GOOD.read_text(encoding="utf-8")
        for number, says, facts in self.CASES:
            with self.subTest(**facts):
                text = good
                for name, value in facts.items():
                    text = (with_value(text, name, value) if re.search(rf"^#define {name}[ \t]", text, re.MULTILINE)
                            else text + f"#define {name} {value}\n")
                self.expect_line(number, text, says=says)

    def test_gates_of_the_build_must_not_contradict_the_file(self):
        text = GOOD.read_text(encoding="utf-8")
        self.expect_line(5, text, "-DHAL_GATE_ACTIVE_HIGH=1", says="contradicts")
        self.assertEqual(self.output(text, "-DHAL_GATE_ACTIVE_HIGH=0"), "")

    def test_every_message_of_the_header_is_provoked(self):
        """Each check of the header must have a case here; otherwise a defect of the check would not be detected."""
        tested = {(number, says) for number, says, _ in self.CASES}
        for number, text in errors(header_text()):
            with self.subTest(number=number, text=text):
                self.assertTrue("missing" in text or number == 5 or any(n == number and says in text for n, says in tested))


class Configuration(unittest.TestCase):
    def configure(self, board):
        with tempfile.TemporaryDirectory() as folder:
            return subprocess.run(["cmake", "-S", str(PROJECT), "-B", folder, "-DBUILD_TESTING=OFF", f"-DLAGLESS_BOARD={board}"],
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)

    def test_unknown_board_is_refused_with_those_that_are_known(self):
        for board in ("nosuch", "nosuch.h", "docs/board.md"):
            with self.subTest(board=board):
                done = self.configure(board)
                self.assertNotEqual(done.returncode, 0)
                said = " ".join(done.stdout.split())
                known = ", ".join(path.stem for path in BOARDS[:-2])
                self.assertIn(f"LAGLESS_BOARD={board}: accepted: {known}, or the path of a board file (docs/board.md)", said)


def guide_rows():
    """The line number and the cells of each row in the table of the guide."""
    rows = {}
    for line in GUIDE.read_text(encoding="utf-8").splitlines():
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if len(cells) == 5 and re.fullmatch(r"\d+", cells[0]):
            rows[int(cells[0])] = cells
    return rows


def guide_facts():
    """The line of the table that names each fact. The table abbreviates: `_B_INPUT` after `BOARD_CURRENT_A_INPUT` replaces its ending, and
    `each with _AT_0V` adds an ending."""
    facts = {}
    for number, cells in guide_rows().items():
        before = None
        endings = re.search(r"each with (.*)", cells[1])
        for name in re.findall(r"`(\w+)`", re.sub(r",? ?each with .*", "", cells[1])):
            if name.startswith("_"):
                name = before[:-len(name)] + name
            facts[name] = number
            before = name
            for ending in re.findall(r"`(\w+)`", endings.group(1)) if endings else []:
                facts[re.sub(r"_INPUT$", ending, name)] = number
    return facts


class Guide(unittest.TestCase):
    def test_table_is_numbered_through(self):
        self.assertEqual(sorted(guide_rows()), list(range(1, 22)))

    def test_table_and_header_name_the_same_facts_under_the_same_numbers(self):
        """Each condition of the header is compared with the number in the message after it."""
        text = header_text().replace("\\\n", " ")
        asked = {"BOARD_GATE_ACTIVE_HIGH": 5}
        for condition, number in re.findall(r"#if ([^\n]*!defined[^\n]*)\n#error\s*\"docs/board\.md, line (\d+):", text):
            for name in re.findall(r"!defined\((BOARD_\w+)\)", condition):
                self.assertEqual(asked.setdefault(name, int(number)), int(number), name)
        self.assertGreater(len(asked), 40)
        self.assertEqual(guide_facts(), asked)

    def test_messages_name_facts_under_their_own_line(self):
        """The line number in a message is that of the fact with which the message begins."""
        facts = guide_facts()
        for number, text in errors(header_text()):
            first = re.match(r"(BOARD_\w+)", text)
            if first and first.group(1) in facts:
                with self.subTest(text=text):
                    self.assertEqual(facts[first.group(1)], number)

    def test_board_files_state_the_facts_of_the_guide_and_nothing_else(self):
        facts = guide_facts()
        for path in BOARDS:
            for name in FACT.findall(path.read_text(encoding="utf-8")):
                with self.subTest(board=path.name, name=name):
                    self.assertIn(name, facts)

    def test_board_files_number_their_lines_as_the_guide_does(self):
        """A comment `/* 7: ... */` behind or above a fact contains the number of the fact's line in the guide."""
        facts = guide_facts()
        for path in BOARDS:
            text = path.read_text(encoding="utf-8").replace("\\\n", " ")
            seen = set()
            for name, number in re.findall(r"#define (BOARD_\w+)[^\n]*/\* (\d+)[:.]? ?[^\n]*\*/", text):
                with self.subTest(board=path.name, name=name):
                    self.assertEqual(facts[name], int(number))
                    seen.add(int(number))
            self.assertGreater(len(seen), 10, path.name)

    def test_ranges_of_the_guide_are_those_of_the_header(self):
        rows = guide_rows()
        for number, *texts in [(2, "20 to 35 MHz", "75 to 150 MHz"), (3, "5000 to 20000"), (6, "1 to 6")]:
            for text in texts:
                with self.subTest(text=text):
                    self.assertIn(text, rows[number][3])
                    self.assertTrue(any(n == number and text in said for n, said in errors(header_text())))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[1:]])
