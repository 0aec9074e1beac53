#!/usr/bin/env python3
"""Compares the tables of docs/serial.md with the sources (commands, errors, extensions, sizes), and its sample rates with the length of a
frame."""
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
TALK = ROOT / "firmware" / "talk"
PAGE = (ROOT / "docs" / "serial.md").read_text(encoding="utf-8")


def tables(page):
    """Each table as a list of rows, under the cells of its heading row."""
    found = {}
    head = None
    for line in page.splitlines():
        cells = tuple(cell.strip() for cell in line.strip().strip("|").split("|")) if line.startswith("|") else None
        if cells is None:
            head = None
        elif head is None:
            head = cells
            found.setdefault(head, [])
        elif not set(cells[0]) <= {"-"}:
            found[head].append(cells)
    return found


def defines(*names):
    """The values of the macros in these headers."""
    text = "".join((ROOT / name).read_text(encoding="utf-8") for name in names)
    numbers = re.findall(r"#define\s+(\w+)\s+(?:UINT32_C\()?(0x[0-9A-Fa-f]+|\d+)(?:u\b|\))", text)
    return {name: int(value, 0) for name, value in numbers}


class Serial(unittest.TestCase):
    tables = tables(PAGE)

    def test_commands_are_those_of_the_slave(self):
        rows = "".join((TALK / name).read_text(encoding="utf-8") for name in ("xcp.c", "xcp_page.c", "xcp_daq.c"))
        slave = re.findall(r'\{(0x[0-9A-F]{2}), \d+u, (?:NULL|"(\w+)"), \w+\}', rows)
        page = self.tables[("code", "command", "answer beside the standard's")]
        self.assertEqual(sorted((code for code, _ in slave), reverse=True), [row[0] for row in page])
        names = {row[0]: row[1] for row in page}
        self.assertEqual({}, {code: name for code, name in slave if name and name != names[code]})
        self.assertEqual(len(page), len({row[1] for row in page}))

    def test_errors_are_those_of_the_slave(self):
        errors = re.findall(r"#define XCP_[A-Z_]+\s+(0x[0-9A-F]{2})u\n", (TALK / "xcp.h").read_text(encoding="utf-8"))
        self.assertEqual(sorted(errors), [row[0] for row in self.tables[("code", "when")]])

    def test_extensions_are_those_of_the_application(self):
        known = defines("firmware/talk/xcp.h", "firmware/app/talk_values.h")
        services = (ROOT / "firmware" / "app" / "services.h").read_text(encoding="utf-8")
        order = re.search(r"typedef enum \{\s*(APP_TABLE_\w+[^}]*)\} app_table_t", services).group(1)
        names = [name.strip()[len("APP_TABLE_"):].lower() for name in order.split(",")][:-1]
        page = self.tables[("extension", "what", "address", "writing")]
        self.assertEqual([str(n) for n in range(9)], [row[0] for row in page])
        for n, name in enumerate(names):
            self.assertTrue(page[n][1].startswith({"params": "parameters"}.get(name, name)))
        for macro, word in (("TALK_CAPTURE", "capture"), ("XCP_EXTENSION_A2L", "A2L"), ("XCP_EXTENSION_EPK", "EPK"),
                            ("TALK_FAULTS", "fault log"), ("XCP_EXTENSION_EVENT", "name of the event")):
            self.assertTrue(page[known[macro]][1].startswith(word), macro)

    def test_sizes_are_those_of_the_sources(self):
        known = defines("firmware/talk/frame.h", "firmware/talk/daq.h")
        octets = [int(row[1]) for row in self.tables[("what", "octets")]]
        self.assertEqual([known["FRAME_HEADER"], known["FRAME_MAX_CTO"], known["FRAME_MAX_DTO"]], octets)
        many = [int(row[1]) for row in self.tables[("what", "how many")]]
        self.assertEqual([known[name] for name in ("DAQ_LISTS", "DAQ_ODTS", "DAQ_ENTRIES", "DAQ_CELLS")], many)
        checksum = defines("firmware/talk/xcp.h")["XCP_CHECKSUM_MAX"]
        self.assertIn(f"CRC-32, of {checksum} octets at most", PAGE)

    def test_codes_follow_from_their_formula(self):
        header = (ROOT / "firmware" / "contract" / "line.h").read_text(encoding="utf-8")
        step, row = (int(re.search(r"#define %s\s+UINT32_C\((\w+)\)" % name, header).group(1), 16) for name in ("LINE_STEP", "LINE_ROW"))
        self.assertIn(f"(choice x 0x{step:08X}) XOR (id x 0x{row:08X})", " ".join(PAGE.split()))
        for n, cells in enumerate(self.tables[("request", "choice", "on the line")]):
            self.assertEqual(("enable", ["off", "on", "quick_stop"][n], "0x%08X" % (n * step ^ 1000 * row & 0xFFFFFFFF)), cells)

    def test_the_frame_that_is_shown_has_its_sum(self):
        octets = bytes.fromhex(re.search(r"The frame ([0-9A-F ]+) is CONNECT", PAGE).group(1))
        words = [int.from_bytes(octets[n:n + 2], "little") for n in range(0, len(octets), 2)]
        self.assertEqual((2, 0x0102, 0xFF), tuple(words[:3]))
        self.assertEqual(sum(words[:-1]) % 65536, words[-1])

    def test_rates_follow_from_the_frame(self):
        sample = 4 + 5 + 4 * 3 + 1 + 2  # header, identification and stamp, three floats, fill, sum
        self.assertIn("12 + 4 n octets of ten bits", " ".join(PAGE.split()))
        self.assertIn(f"three floats: {93750 // sample} samples per second at 937500 baud, and {234375 // sample} at 2343750 baud",
                      " ".join(PAGE.split()))


if __name__ == "__main__":
    unittest.main()
