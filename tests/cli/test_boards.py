"""The board is chosen when the program runs. The tests use each board with a motor of the library, and compare the list of boards with their
headers. They also check wrong names, scenarios that name a board, and a header of the user.

usage: test_boards.py LAGLESS FOLDER"""

import json
import os
import random
import re
import shutil
import subprocess
import sys
import time
import unittest

from command_line import LAGLESS, ROOT, TestCase, lagless

HEADERS = os.path.join(ROOT, "hal", "f28335", "boards")

# A board, a motor that suits it, half the rated speed [r/min] and half the rated torque [N m] of the motor, and the inertia of the machine
# that it drives.
DRIVES = (
    ("pm50rl1a060", "baldor-bsm90n-175", 800, 2.0, "20 kg cm^2"),
    ("hvmtrpfckit", "estun-emj-04apb22", 1500, 0.6, "2 kg cm^2"),
    ("mosfet_48v_60a", "beckhoff-am8141", 500, 1.0, "5 kg cm^2"),
    ("igbt_540v_30a", "siemens-1ft6084-8sh7", 1500, 7.0, "0 kg cm^2"),
)

MAP = """schema = 1
title = "A map on a board with 0.4 us of dead time"
board = "mosfet_48v_60a"
motor = "teknic-m2310p-ln-04k"
[run]
duration = "1 s"
[requests]
speed_request = "2000 r/min"
[plant]
load_torque = "0.1 N m"
[rig]
fidelity = "averaged"
"""

DRIVE = """schema = 1
title = "Cold start, load step and reversal"
board = "{board}"
[run]
duration = "5 s"
[motor]
name = "{motor}"
load_inertia = "{inertia}"
[start]
angle = 2
[requests]
enable = "on"
speed_request = "{speed} r/min"
[[at]]
time = "1.7 s"
ramp = "0.1 s"
plant.load_torque = {torque}
[[at]]
time = "2.2 s"
requests.speed_request = "-{speed} r/min"
[[expect]]
name = "under load"
signal = "true_omega_m"
statistic = "mean"
from = "2.1 s"
to = "2.2 s"
at_least = "{least} r/min"
at_most = "{most} r/min"
[[expect]]
name = "reversed"
signal = "true_omega_m"
statistic = "mean"
from = "4.9 s"
at_least = "-{most} r/min"
at_most = "-{least} r/min"
[[expect]]
signal = "lock_losses"
statistic = "max"
at_most = 0
[[expect]]
signal = "fault_reason"
statistic = "max"
at_most = 0
[[expect]]
signal = "manoeuvre"
statistic = "last"
from = "4.9 s"
at_least = "run"
at_most = "run"
"""


def number(board, name):
    """A whole number from the header of a board."""
    with open(os.path.join(HEADERS, f"{board}.h"), encoding="utf-8") as file:
        return int(re.search(rf"#define {name}\s+\(?(-?\d+)", file.read())[1])


class Boards(TestCase):
    def test_each_board_runs_a_motor_that_suits_it_from_standstill_under_load_and_back(self):
        self.assertEqual(sorted(name[:-2] for name in os.listdir(HEADERS)), sorted(row[0] for row in DRIVES))
        for board, motor, speed, torque, inertia in DRIVES:
            with self.subTest(board=board):
                text = DRIVE.format(board=board, motor=motor, speed=speed, torque=torque, inertia=inertia, least=0.98 * speed,
                                    most=1.02 * speed)
                done = self.expect(0, lagless("run", self.write(f"{board}.toml", text)), "met         under load", "met         reversed")
                self.assertNotIn("warning", done.stderr)

    def test_the_list_has_the_values_of_the_headers(self):
        boards = {board["name"]: board for board in json.loads(lagless("boards", "--json").stdout)["boards"]}
        self.assertEqual([row[0] for row in DRIVES][:1], [name for name, board in boards.items() if board["default"]])
        for name, board in boards.items():
            with self.subTest(board=name):
                self.assertEqual(number(name, "BOARD_DC_NOMINAL_MV") / 1e3, board["link_v"])
                self.assertEqual(number(name, "BOARD_OVERVOLTAGE_MV") / 1e3, board["overvoltage_v"])
                self.assertEqual(number(name, "BOARD_UNDERVOLTAGE_MV") / 1e3, board["undervoltage_v"])
                self.assertEqual(number(name, "BOARD_CURRENT_LIMIT_MA") / 1e3, board["current_limit_a"])
                self.assertEqual(number(name, "BOARD_OVERCURRENT_TRIP_MA") / 1e3, board["overcurrent_trip_a"])
                self.assertAlmostEqual(number(name, "BOARD_CARRIER_HZ"), board["carrier_hz"], delta=1.0)
                self.expect(0, lagless("boards"), f"{name} ")
        self.assertNotIn("choose a carrier", lagless("boards").stdout)

    def test_the_parameters_are_those_of_the_chosen_board(self):
        for board in (row[0] for row in DRIVES):
            rows = {row["name"]: row for row in json.loads(lagless("params", "--board", board, "--json").stdout)["rows"]}
            self.assertEqual(number(board, "BOARD_OVERVOLTAGE_MV") / 1e3, rows["dc_overvoltage"]["default"])
            self.assertAlmostEqual(number(board, "BOARD_CURRENT_LIMIT_MA") / 1e3, rows["current_limit"]["default"], 5)

    def test_the_map_of_a_board_with_a_short_dead_time_makes_it_a_fifth_wrong(self):
        # The delay that a map adds by default, 0.5 us, is longer than the dead time of this board. The voltage that the legs lose is proportional
        # to the dead time: a fifth more and a fifth less shift the angle by the same amount in opposite directions.
        path = self.write("short.toml", MAP)
        done = lagless("map", path, "--adaptation", "off", "--json")
        self.expect(0, done)
        for way in (-2000, 2000):
            rows = {row["deviation"]: row for row in json.loads(done.stdout) if row["rpm"] == way}
            self.assertTrue(all(row["locked"] for row in rows.values()))
            self.assertEqual({"dead time -20 %", "dead time +20 %"}, {name for name in rows if name.startswith("dead time")})
            less, more = (rows[f"dead time {sign}20 %"]["mean_mrad"] - rows["nominal"]["mean_mrad"] for sign in "-+")
            self.assertGreater(abs(more), 2.0 * abs(rows["nominal"]["mean_mrad"]))
            self.assertAlmostEqual(-1.0, less / more, delta=0.2)

    def test_a_wrong_name_is_reported_with_the_nearest_and_all(self):
        path = self.scenario('[rig]\n')
        wrong = self.write("wrong.toml", self.read("a.toml").replace("schema = 1", 'schema = 1\nboard = "pm50rl1a06"'))
        self.refuses((["run", path, "--board", "mosfet48"], "--board mosfet48: no board is called mosfet48; nearest: mosfet_48v_60a; accepted: ",
                      *(row[0] for row in DRIVES)),
                     (["tune", "liu-2019", "--board="], "no board is called"),
                     (["run", wrong], "wrong.toml:2:", "board: no board is called pm50rl1a06; nearest: pm50rl1a060"))

    def test_a_scenario_that_names_a_board_runs_there_from_a_file_and_from_stdin(self):
        text = self.read_step().replace("schema = 1", 'schema = 1\nboard = "igbt_540v_30a"')
        path = self.write("named.toml", text)
        plain = self.write("plain.toml", self.read_step())
        named = json.loads(self.expect(0, lagless("run", path, "--json")).stdout)
        for done in (lagless("run", path, "--board", "igbt_540v_30a", "--json"), lagless("run", "-", "--json", input=text),
                     lagless("run", plain, "--board=igbt_540v_30a", "--json")):
            self.assertEqual(named["state_hash"], json.loads(self.expect(0, done).stdout)["state_hash"])
        self.assertNotEqual(named["state_hash"], json.loads(lagless("run", plain, "--json").stdout)["state_hash"])
        self.assertEqual(1600, named["periods"])  # 0.2 s at 8 kHz

    def read_step(self):
        self.scenario()
        return self.read("a.toml")

    def test_a_scenario_that_contradicts_the_option_is_reported_with_both(self):
        path = self.write("named.toml", self.read_step().replace("schema = 1", 'schema = 1\nboard = "igbt_540v_30a"'))
        for board in ("mosfet_48v_60a", "pm50rl1a060"):
            self.expect(2, lagless("run", path, "--board", board),
                        f"named.toml:2:1: board: the scenario is for board igbt_540v_30a, and {board} is chosen")

    def test_a_motor_that_does_not_suit_is_warned_of_with_both_numbers_and_a_board_is_proposed(self):
        text = 'schema = 1\ntitle = "x"\nmotor = "%s"\n[run]\nduration = "1 ms"\n'
        strong = self.write("strong.toml", text % "siemens-1ft6084-8sh7")
        self.expect(0, lagless("run", strong), "warning: the motor's rated current of 19.66 A peak needs a limit of 24.57 A, and board "
                    "pm50rl1a060 allows 15.83 A", "--board igbt_540v_30a suits")
        self.expect(0, lagless("run", self.write("high.toml", text % "liu-2019"), "--board", "mosfet_48v_60a"), "warning: the motor needs a link of 311 V, ",
                    "and the largest trip of board mosfet_48v_60a is 70 V")
        self.expect(0, lagless("tune", "beckhoff-am8141"), "Proposed: --board mosfet_48v_60a")
        self.assertNotIn("Proposed", lagless("tune", "beckhoff-am8141", "--board", "mosfet_48v_60a").stdout)

    def test_the_matrix_of_another_board_is_a_run_of_a_motor_that_suits_it(self):
        self.expect(2, lagless("matrix", "--share", "1", "--board", "igbt_540v_30a"), "on board pm50rl1a060; accepted on igbt_540v_30a: --only")
        whole = [("mosfet_48v_60a", "cells: 53 pass, 0 fail, 1 cannot occur"), ("igbt_540v_30a", "cells: 54 pass, 0 fail")]
        if os.environ.get("LAGLESS_GRID_SHARE") != "1":  # one of the boards, which the seed of the day selects
            seed = os.environ.get("LAGLESS_GRID_SEED") or time.strftime("%Y%m%d", time.gmtime())
            whole = [random.Random(f"matrix of boards {seed}").choice(whole)]
            print(f"LAGLESS_GRID_SEED={seed}: the matrix of {whole[0][0]}")
        for board, told in whole:
            pages = os.path.join(self.folder, "pages")
            self.expect(0, lagless("matrix", "--board", board, "--out", pages), told)
            self.assertIn('id="stuck_a_rail.scenario.sensorless"', self.read("pages/matrix.html"))
            shutil.rmtree(pages)

    def test_what_tune_writes_for_a_board_names_it(self):
        path = os.path.join(self.folder, "my.toml")
        self.expect(0, lagless("tune", "beckhoff-am8141", "--board", "mosfet_48v_60a", "--write", path))
        self.assertIn('\nboard = "mosfet_48v_60a"\n', self.read("my.toml"))
        self.expect(0, lagless("tune", "liu-2019", "--write", path, "--force"))
        self.assertNotIn("board", self.read("my.toml").partition("[motor]")[0])

    def test_other_commands_run_on_the_board(self):
        few = ["campaign", "--runs", "2", "--seconds", "0.1", "--json"]
        heads = [lagless(*few, "--board", board, "--out", os.path.join(self.folder, board)) and self.read(f"{board}/campaign.csv").splitlines()[0]
                 for board in ("pm50rl1a060", "mosfet_48v_60a")]
        self.assertNotEqual(*heads)
        server, place = self.serve(self.scenario(duration="1 s"), "--board", "mosfet_48v_60a", "--port", "0")
        self.expect(0, lagless("connect", f"tcp://{place}", input="get u_dc\n"), "u_dc ", "47.99")
        server.kill()

    def test_an_own_header_becomes_a_board(self):
        """The build is only configured, because it is the same as for the other boards."""
        if shutil.which("cmake") is None:
            self.skipTest("no cmake")
        with open(os.path.join(HEADERS, "mosfet_48v_60a.h"), encoding="utf-8") as file:
            header = file.read()
        mine = self.write("mine.h", header.replace('"mosfet_48v_60a"', '"mine"'))
        twin = self.write("twin.h", header)

        def configured(board):
            return subprocess.run(["cmake", "-S", ROOT, "-B", os.path.join(self.folder, "build"), "-G", "Ninja", "-DBUILD_TESTING=OFF",
                                   f"-DLAGLESS_BOARDS={board}"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        refused = " ".join(self.expect(1, configured(twin)).stdout.split())
        self.assertIn('both have BOARD_NAME "mosfet_48v_60a"', refused)
        self.expect(0, configured(mine))
        with open(os.path.join(self.folder, "build", "build.ninja"), encoding="utf-8") as file:
            self.assertIn("boards/mine/lagless", file.read())


unittest.main(argv=["test_boards", *sys.argv[3:]], verbosity=2)
