"""A client of other authors, pyxcp, not modified, is connected to the drive of `lagless serve`, and pya2l reads the description that it
fetched.

usage: test_pyxcp.py LAGLESS PYTHON FOLDER SECONDS
PYTHON: one that has pyxcp and pya2l (tools/setup all puts them into build/venv); without them this ends with 77, skipped."""

import json
import os
import shutil
import socket
import struct
import subprocess
import sys
import unittest

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
import stuck  # noqa: E402

LAGLESS, PYTHON, FOLDER, SECONDS = os.path.abspath(sys.argv[1]), sys.argv[2], sys.argv[3], float(sys.argv[4])
HERE = os.path.dirname(os.path.abspath(__file__))
EXTENSIONS = {"signals": 0, "params": 1, "requests": 2, "services": 3}
ON = 0x11111111 ^ 1000 * 0x9E3779B1 & 0xFFFFFFFF  # the request enable, as it is written on the line (docs/serial.md)


CONFIGURATION = """c = get_config()
c.Transport.layer = "ETH"
c.Transport.Eth.host = "127.0.0.1"
c.Transport.Eth.port = %d
c.Transport.Eth.protocol = "TCP"
c.Transport.timeout = 5.0
c.General.disable_error_handling = True
"""

SERIAL_CONFIGURATION = """c = get_config()
c.Transport.layer = "SXI"
c.Transport.SxI.port = "%s"
c.Transport.SxI.bitrate = 937500
c.Transport.SxI.mode = "ASYNCH_FULL_DUPLEX_MODE"
c.Transport.SxI.header_format = "HEADER_LEN_CTR_WORD"
c.Transport.SxI.tail_format = "CHECKSUM_WORD"
c.Transport.SxI.framing = False
c.Transport.timeout = 5.0
c.General.disable_error_handling = True
"""

# The motor starts at once and always turns, so that the recorded values differ in every period.
SCENARIO = """schema = 1
title = "A motor that is never at rest"
[run]
duration = "%.4f s"
every = 1
record = [%s]
[requests]
enable = "on"
speed_request = "500 r/min"
[plant]
load_torque = "1 N m"
"""

FLOATS = ("i_a", "i_b", "i_d", "i_q", "u_d", "u_q", "u_dc", "theta_e", "omega_m", "theta_hat", "omega_hat", "duty_a")

# Reads the rows of a description, and its IF_DATA by two grammars: the one in the file itself, and the complete one of the standard, from
# the example of the association (ASAM).
READER = """
import json, pathlib, re, sys
import pya2l
from pya2l import model
from pya2l.aml.ifdata_parser import IfDataParser
GRAMMAR = re.compile(r"/begin\\s+A2ML.*?/end\\s+A2ML", re.S)
own = pathlib.Path(sys.argv[1]).read_text(encoding="utf-8")
example = pathlib.Path(pya2l.__file__).parent / "examples" / "ASAP2_Demo_V161.a2l"
whole = GRAMMAR.search(example.read_text(encoding="latin-1"))[0]
rows, blocks = [], []
for text in (GRAMMAR.sub(lambda _: whole, own), own):
    path = pathlib.Path("read.a2l")
    path.write_text(text, encoding="utf-8")
    session = pya2l.import_a2l(str(path), in_memory=True, progress_bar=False, loglevel="ERROR", encoding="utf-8")
    [data] = session.query(model.Module).first().if_data
    [segment] = session.query(model.MemorySegment).all()
    blocks.append([IfDataParser(session).parse(data.raw), IfDataParser(session).parse(segment.if_data[0].raw),
                   [segment.address, segment.size]])
for kind, shown in ((model.Measurement, True), (model.Characteristic, False)):
    for row in session.query(kind):
        rows.append({
            "name": row.name, "shown": shown, "text": row.longIdentifier,
            "address": row.ecu_address.address if shown else row.address,
            "extension": row.ecu_address_extension.extension,
            "unit": row.phys_unit.unit})
commands = re.search(r'"OPTIONAL_CMD"\\s+enum\\s*{(.*?)}', whole, re.S)[1]
print(json.dumps({"rows": rows, "epk": session.query(model.Epk).first().identifier, "blocks": blocks,
                  "commands": {name: int(code, 0) for name, code in re.findall(r'"(\\w+)"\\s*=\\s*(\\w+)', commands)}}))
"""


class Pyxcp(stuck.TestCase):
    def setUp(self):
        self.folder = os.path.join(FOLDER, "pyxcp_work", self.id().rsplit(".", 1)[1])
        shutil.rmtree(self.folder, ignore_errors=True)
        os.makedirs(self.folder)
        self.server = None

    def tearDown(self):
        self.stop()

    def stop(self):
        if self.server is not None:
            self.server.terminate()
            self.assertEqual(0, self.server.wait(10))
            self.server = None

    def serve(self, scenario, *options):
        self.server = subprocess.Popen([LAGLESS, "serve", scenario, "--port", "0", "--quiet", *options], text=True,
                                       stdout=subprocess.PIPE)
        self.addCleanup(self.server.stdout.close)
        self.port = int(self.server.stdout.readline().rsplit(":", 1)[1])
        with open(os.path.join(self.folder, "pyxcp_conf.py"), "w") as file:
            file.write(CONFIGURATION % self.port)

    def serve_serial(self, scenario, handling=False):
        """Serves over the serial line of the chip, in the time of the simulation, at a pseudo terminal."""
        self.server = subprocess.Popen([LAGLESS, "serve", scenario, "--serial", "--quiet"], text=True, stdout=subprocess.PIPE)
        self.addCleanup(self.server.stdout.close)
        terminal = self.server.stdout.readline().split()[-1]
        with open(os.path.join(self.folder, "pyxcp_conf.py"), "w") as file:
            file.write((SERIAL_CONFIGURATION % terminal).replace("handling = True", "handling = %s" % (not handling)))

    def python(self, *arguments, timeout=120):
        done = subprocess.run([PYTHON, *arguments], cwd=self.folder, capture_output=True, text=True, timeout=timeout,
                              stdin=subprocess.DEVNULL)
        self.assertEqual(0, done.returncode, done.stdout[-2000:] + done.stderr[-4000:])
        return done

    def tool(self, name):
        return self.python(os.path.join(os.path.dirname(PYTHON), name), timeout=60)

    def client(self, *arguments):
        return json.loads(self.python(os.path.join(HERE, "client.py"), *arguments).stdout.splitlines()[-1])

    def tables(self):
        rows = {}
        for command in ("params", "signals"):
            done = subprocess.run([LAGLESS, command, "--json"], capture_output=True, text=True, check=True)
            rows.update({row["name"]: row for row in json.loads(done.stdout)["rows"] if row["table"] in EXTENSIONS})
        return rows

    def info_is_clean(self):
        done = self.tool("xcp-info")
        for complaint in ("WARNING", "ERROR", "CRITICAL", "Traceback", "not implemented"):
            self.assertNotIn(complaint, done.stdout + done.stderr)

    def test_description_is_fetched_and_has_every_row_and_the_line_of_the_drive(self):
        self.serve("cold_start")
        self.info_is_clean()
        self.tool("xcp-fetch-a2l")
        reader = os.path.join(self.folder, "reader.py")
        with open(reader, "w") as file:
            file.write(READER)
        read = json.loads(self.python(reader, "lagless.a2l").stdout.splitlines()[-1])
        self.rows_are_those_of_the_tables(read)
        self.line_is_what_the_drive_says(read)

    def rows_are_those_of_the_tables(self, read):
        """Compares the rows with the tables; tests/unit/test_a2l.c checks the other entries of a row."""
        self.assertRegex(read["epk"], "^lagless-[0-9a-f]{8}$")
        self.assertEqual({(name, 4 * row["id"], EXTENSIONS[row["table"]], row["unit"], row["text"]) for name, row in self.tables().items()},
                         {(row["name"], row["address"], row["extension"], row["unit"], row["text"]) for row in read["rows"]})
        self.assertEqual(len(self.tables()), len(read["rows"]))

    def line_is_what_the_drive_says(self, done):
        """Both grammars must read IF_DATA XCP in the same way; it must agree with the answers of the drive and with the properties of each
        transport."""
        self.assertEqual(*done["blocks"])
        [blocks] = done["blocks"][0][0]["XCP"]
        says = self.client("facts")

        layer = blocks["PROTOCOL_LAYER"]
        self.assertEqual([0x100 * says["version"], says["max_cto"], says["max_dto"]], [layer[0], *layer[8:10]])
        self.assertEqual([("INTEL", "BYTE"), ("BYTE_ORDER_MSB_LAST", "ADDRESS_GRANULARITY_BYTE")],
                         [(says["byte_order"], says["address_granularity"]), tuple(layer[10:12])])
        self.assertEqual({name for name, code in done["commands"].items() if self.knows(code)}, set(layer[12]["OPTIONAL_CMD"]))

        daq = blocks["DAQ"]
        self.assertEqual([says["daq_config_type"], says["max_daq"], says["max_event_channel"], says["min_daq"]], daq[:4])
        self.assertEqual(("OM_DEFAULT", "AE_DIFFERENT_WITHIN_ODT", "IDF_ABS_ODT_NUMBER"),
                         (says["optimisation"], says["address_extension"], says["identification_field"]))
        self.assertEqual(["OPTIMISATION_TYPE_DEFAULT", "ADDRESS_EXTENSION_FREE", "IDENTIFICATION_FIELD_TYPE_ABSOLUTE"], daq[4:7])
        self.assertEqual((4, "GRANULARITY_ODT_ENTRY_SIZE_DAQ_DWORD"), (says["granularity"], daq[7]))
        self.assertEqual(says["max_entry"], daq[8])
        self.assertEqual((True, "OVERLOAD_INDICATION_EVENT"), (says["overload_event"], daq[9]))
        more = daq[10]
        self.assertEqual(says["prescaler"], more["PRESCALER_SUPPORTED"])
        self.assertEqual(("S4", True), (says["stamp_size"], says["stamp_fixed"]))
        self.assertEqual([says["stamp_ticks"], "SIZE_DWORD", says["stamp_unit"].replace("DAQ_TIMESTAMP_", ""), {"TIMESTAMP_FIXED": True}],
                         more["TIMESTAMP_SUPPORTED"])
        [event] = more["EVENT"]
        self.assertEqual([says["event_name"], 0, "DAQ", says["event_lists"], says["event_cycle"], says["event_priority"]],
                         [event[0], *event[2:6], event[7]])
        units = ["1NS", "10NS", "100NS", "1US", "10US", "100US", "1MS", "10MS", "100MS", "1S"]
        self.assertEqual(says["event_unit"], "EVENT_CHANNEL_TIME_UNIT_" + units[event[6]])

        self.assertIn("c.Transport.SxI.bitrate = %d\n" % blocks["XCP_ON_SxI"][1], SERIAL_CONFIGURATION)
        self.assertEqual([{"ASYNCH_FULL_DUPLEX_MODE": ["PARITY_NONE", "ONE_STOP_BIT"]}, "HEADER_LEN_CTR_WORD", "CHECKSUM_WORD"],
                         blocks["XCP_ON_SxI"][2:])
        [segment] = done["blocks"][0][1]["XCP"]
        number, pages, extension, compression, encryption, more = segment["SEGMENT"]
        self.assertEqual([0, 2, EXTENSIONS["params"], 0, 0], [number, pages, extension, compression, encryption])
        set_mta = bytes([0xF6, 0, 0, EXTENSIONS["params"], 4, 0, 0, 0])
        too_long = self.asked(set_mta, bytes([0xF3, 0, 0, 0, 0, 0, 0, 0x80]))[1]
        self.assertEqual(["XCP_CRC_32", {"MAX_BLOCK_SIZE": int.from_bytes(too_long[4:], "little")}], more["CHECKSUM"])
        self.assertEqual([int.from_bytes(answer[4:], "little") for answer in
                          self.asked(bytes([0xE8, 0, 0, 0, 0]), bytes([0xE8, 0, 0, 1, 0]))], done["blocks"][0][2])
        self.assertEqual([0, 1], [page[0] for page in more["PAGE"]])
        port = blocks["XCP_ON_TCP_IP"][1]
        self.assertEqual([0x100, port, {"ADDRESS": "127.0.0.1"}], blocks["XCP_ON_TCP_IP"])
        told = subprocess.run([LAGLESS, "serve", "--help"], capture_output=True, text=True, check=True).stdout
        self.assertIn("default %d;" % port, told)

    def knows(self, code):
        """Returns true if the drive has this command. The zeros after it address no existing item."""
        return self.asked(bytes([code, *[0] * 7]))[0] != b"\xfe\x20"

    def asked(self, *packets):
        """The answers to these commands, in a session of their own."""
        answers = []
        with socket.create_connection(("127.0.0.1", self.port), timeout=5) as line:
            for n, packet in enumerate([b"\xff\0", *packets, b"\xfe"]):
                line.sendall(struct.pack("<HH", len(packet), n) + packet)
                answers.append(self.exactly(line, self.exactly(line, 4)[0]))
        return answers[1:-1]

    def exactly(self, line, count):
        octets = b""
        while len(octets) < count:
            more = line.recv(count - len(octets))
            self.assertNotEqual(b"", more)
            octets += more
        return octets

    def test_samples_are_those_of_the_recording(self):
        """The client receives twelve floats in every period over TCP."""
        self.samples_are_those_of_the_recording(self.serve, FLOATS, 1)

    def test_the_serial_line_carries_what_fits_it(self):
        """Three floats with their stamp are 24 octets, which take 256 us at 937500 baud: a sample in every third period."""
        self.serve_serial("cold_start")
        self.info_is_clean()
        self.stop()
        self.samples_are_those_of_the_recording(self.serve_serial, FLOATS[2:5], 3)

    def test_a_master_of_the_standard_writes_over_the_serial_line(self):
        """pyxcp handles errors as the standard requires: it repeats a command that the drive answers with "busy". The motor turns and
        stops."""
        scenario = os.path.join(self.folder, "scenario.toml")
        with open(scenario, "w") as file:
            file.write('schema = 1\ntitle = "At rest"\n[run]\nduration = "1 s"\n[rig]\nfidelity = "averaged"\n')
        self.serve_serial(scenario, handling=True)
        done = self.client("writes")
        self.assertEqual([ON, 20.0, 8.0], done["read"])
        self.assertEqual([3, 1], done["states"])  # the states operation_enabled and ready
        self.assertGreater(done["speed"], 19.0)

    def test_a_master_of_the_standard_unlocks_a_locked_drive(self):
        scenario = os.path.join(self.folder, "scenario.toml")
        with open(scenario, "w") as file:
            file.write('schema = 1\ntitle = "Locked"\n[run]\nduration = "1 s"\n[params]\nline_key = 4711\n')
        self.serve(scenario)
        done = self.client("unlocks", "4711")
        self.assertEqual([True, 4], [done["locked"][0], done["length"]])
        self.assertIn("ERR_ACCESS_LOCKED", done["locked"][1])
        self.assertEqual([False, ""], done["opened"])

    def samples_are_those_of_the_recording(self, serve, names, every):
        """The samples come without a gap, and the difference of their stamps is the number of periods between them. Their bits equal those
        that `lagless run` records of the same scenario without a client."""
        scenario = os.path.join(self.folder, "scenario.toml")
        recorded = ", ".join('"%s"' % name for name in ("period", *names))
        with open(scenario, "w") as file:
            file.write(SCENARIO % (SECONDS, recorded))
        tables = self.tables()
        serve(scenario)
        path = os.path.join(self.folder, "samples")
        floats = sorted(names, key=lambda name: tables[name]["id"])
        done = self.client("record", str(SECONDS), str(every), path, *[str(tables[name]["id"]) for name in floats])
        self.assertEqual({str(100000 * every): done["rows"] - 1}, done["steps"])
        self.assertEqual(0, done["lost"])
        self.assertGreaterEqual(done["rows"], 10000 * SECONDS // every)
        samples = {}
        with open(path, "rb") as file:
            while True:
                row = file.read(4 * len(names) + 4)
                if not row:
                    break
                samples[struct.unpack("<I", row[:4])[0]] = row[4:]
        self.assertEqual(done["rows"], len(samples))
        with open(scenario, "w") as file:  # up to the last of them, in case the client was late
            file.write(SCENARIO % (1e-4 * (max(samples) + 2), recorded))
        subprocess.run([LAGLESS, "run", scenario, "--out", self.folder, "--quiet"], check=True, stdout=subprocess.DEVNULL)
        compared = 0
        [csv] = [name for name in os.listdir(self.folder) if name.endswith(".csv")]
        with open(os.path.join(self.folder, csv)) as file:
            header = next(line for line in file if not line.startswith("#")).strip().split(",")
            columns = [next(n for n, title in enumerate(header) if title.split(" ")[0].split("[")[0] == name)
                       for name in ["period"] + floats]
            for line in file:
                cells = line.split(",")
                sample = samples.get(int(float(cells[columns[0]])))
                if sample is not None:
                    self.assertEqual(sample, struct.pack("<%df" % len(names), *[float(cells[c]) for c in columns[1:]]))
                    compared += 1
        self.assertEqual(done["rows"], compared)


if __name__ == "__main__":
    both = "from importlib.util import find_spec; assert find_spec('pyxcp') and find_spec('pya2l')"
    asked = subprocess.run([PYTHON, "-c", both], capture_output=True, text=True)
    if asked.returncode != 0:
        print("SKIPPED: %s has no pyxcp or no pya2l: nothing of the line was tried with a client of others. `tools/setup all` "
              "installs both into build/venv." % PYTHON)
        sys.exit(77)
    unittest.main(argv=sys.argv[:1])
