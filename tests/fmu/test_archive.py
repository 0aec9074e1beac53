"""The content of the archive of `lagless fmu`: files, description, scenario; refusals of the command.

usage: test_archive.py LAGLESS FOLDER. Python 3.9, nothing else."""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import unittest
import xml.etree.ElementTree
import zipfile

LAGLESS, FOLDER = os.path.abspath(sys.argv[1]), pathlib.Path(sys.argv[2]).absolute()


def lagless(*arguments, **more):
    return subprocess.run([LAGLESS, *map(str, arguments)], capture_output=True, text=True, check=False, **more)


def rows(command):
    return json.loads(lagless(command, "--json").stdout)["rows"]


class Archive(unittest.TestCase):
    def setUp(self):
        shutil.rmtree(FOLDER, ignore_errors=True)
        FOLDER.mkdir(parents=True)

    def made(self, *arguments):
        done = lagless("fmu", *arguments, "--out", FOLDER, "--force")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return done.stdout

    def test_it_holds_description_library_and_scenario(self):
        self.made("load_step")
        with zipfile.ZipFile(FOLDER / "load_step.fmu") as archive:
            self.assertIsNone(archive.testzip())
            self.assertEqual(archive.namelist(), ["modelDescription.xml", "binaries/linux64/lagless.so", "resources/scenario.toml"])
            self.assertEqual(archive.read("binaries/linux64/lagless.so")[:4], b"\x7fELF")

    def test_on_another_board_it_holds_that_board_s_library_and_step(self):
        self.made("load_step", "--board", "mosfet_48v_60a")
        with zipfile.ZipFile(FOLDER / "load_step.fmu") as archive:
            self.assertIn('\nboard = "mosfet_48v_60a"\n', archive.read("resources/scenario.toml").decode())
            built = pathlib.Path(LAGLESS).parent / "fmu/boards/mosfet_48v_60a/lagless.so"
            self.assertEqual(archive.read("binaries/linux64/lagless.so"), built.read_bytes())
            root = xml.etree.ElementTree.fromstring(archive.read("modelDescription.xml"))
            self.assertAlmostEqual(float(root.find("DefaultExperiment").get("stepSize")), 1 / 20000, 12)

    def test_the_document_shows_what_the_command_prints(self):
        document = (pathlib.Path(__file__).resolve().parents[2] / "docs/fmu.md").read_text(encoding="utf-8")
        for part in ("", "--part drive ", "--part plant "):
            printed = self.made("load_step", *part.split()).replace(f"{FOLDER}/", "units/")
            self.assertIn(f"    $ build/host/lagless fmu load_step {part}--out units\n    {printed}", document)

    def test_the_document_lists_every_value_that_the_parts_exchange(self):
        document = (pathlib.Path(__file__).resolve().parents[2] / "docs/fmu.md").read_text(encoding="utf-8")
        self.made("load_step", "--part", "drive")
        self.made("load_step", "--part", "plant")
        inputs = []
        for part in ("drive", "plant"):
            with zipfile.ZipFile(FOLDER / f"load_step_{part}.fmu") as archive:
                root = xml.etree.ElementTree.fromstring(archive.read("modelDescription.xml"))
            inputs.append({variable.get("name") for variable in root.find("ModelVariables") if variable.get("causality") == "input"})
        other = {row["name"] for row in rows("params") + rows("signals")}
        exchanged = sorted(name for name in inputs[0] | inputs[1] if name not in other and "." not in name)
        self.assertEqual(len(exchanged), 22)
        for name in exchanged:
            short = re.sub(r"_(b|c)$", "_a", name)
            self.assertIn(f"`{short}`", document, name)

    def test_every_row_of_the_tables_is_a_variable_with_unit_range_and_start(self):
        self.made("load_step", "--set", "inertia=0.01")
        with zipfile.ZipFile(FOLDER / "load_step.fmu") as archive:
            root = xml.etree.ElementTree.fromstring(archive.read("modelDescription.xml"))
        variables = {int(variable.get("valueReference")): variable for variable in root.find("ModelVariables")}
        units = {unit.get("name") for unit in root.find("UnitDefinitions")}
        types = {simple.get("name"): [item.get("name") for item in simple[0]] for simple in root.find("TypeDefinitions")}
        known = [row for row in rows("signals") + rows("params") if row["table"] != "services"]
        self.assertEqual(set(variables), {0} | {row["id"] for row in known})
        for row in known:
            variable, kind = variables[row["id"]], variables[row["id"]][0]
            self.assertEqual(variable.get("description"), row["text"])
            self.assertEqual(variable.get("causality"), {"params": "parameter", "signals": "output", "truth": "output"}.get(row["table"], "input"))
            self.assertEqual(kind.tag, {"float": "Real", "uint32": "Real", "int32": "Integer", "choice": "Enumeration"}[row["kind"]])
            if kind.tag == "Real":
                self.assertEqual(kind.get("unit"), None if row["unit"] == "-" else row["unit"])
                self.assertIn(kind.get("unit"), units | {None})
            if kind.tag == "Enumeration":
                self.assertEqual("|".join(types[kind.get("declaredType")]), row["choices"])
            if "min" in row:
                for limit in ("min", "max"):
                    self.assertAlmostEqual(float(kind.get(limit)) / (row[limit] or 1), row[limit] / (row[limit] or 1), places=6)
        inertia = next(row["id"] for row in known if (row["table"], row["name"]) == ("plant", "inertia"))
        self.assertAlmostEqual(float(variables[inertia][0].get("start")), 0.01, places=8)
        outputs = [variable.get("causality") == "output" for variable in root.find("ModelVariables")]
        listed = [int(unknown.get("index")) for unknown in root.find("ModelStructure/Outputs")]
        self.assertEqual(listed, [n for n, is_output in enumerate(outputs, 1) if is_output])

    def test_the_scenario_in_it_runs_the_same_bits_as_the_one_it_was_made_of(self):
        """The scenario has motors by name, profiles, ramps, events, a rotor that turns, and values of --set: the archive contains all of
        them as numbers."""
        own = FOLDER / "own.toml"
        own.write_text('schema = 1\ntitle = "a \\"title\\""\nmotor = "teknic-m2310p-ln-04k"\n[run]\nduration = "0.3 s"\nseed = 9\n'
                       '[start]\nspeed = "100 r/min"\nangle = "30 deg"\n[requests]\nenable = "on"\nspeed_request = "300 r/min"\n'
                       '[[profile]]\nrow = "plant.load_torque"\npoints = [["0 s", "0 N m"], ["0.1 s", "0.02 N m"], ["0.2 s", "0 N m"]]\n'
                       '[[at]]\ntime = "0.15 s"\nrequests.enable = "quick_stop"\n')
        for scenario, more in ((own, ["--set", "inertia=2e-5"]), ("dc_link_sag", ["--seed", "4"])):
            self.made(scenario, *more)
            with zipfile.ZipFile(FOLDER / f"{pathlib.Path(scenario).stem}.fmu") as archive:
                (FOLDER / "resolved.toml").write_bytes(archive.read("resources/scenario.toml"))
            hashes = [json.loads(lagless("run", which, "--json", *with_).stdout)["state_hash"]
                      for which, with_ in ((scenario, more), (FOLDER / "resolved.toml", []))]
            self.assertEqual(hashes[0], hashes[1], scenario)

    def test_two_archives_are_equal_and_none_replaces_another_without_force(self):
        self.made("load_step")
        first = (FOLDER / "load_step.fmu").read_bytes()
        self.made("load_step")
        self.assertEqual((FOLDER / "load_step.fmu").read_bytes(), first)
        done = lagless("fmu", "load_step", "--out", FOLDER)
        self.assertEqual(done.returncode, 2)
        self.assertIn("--force", done.stderr)

    def test_json_names_the_file(self):
        told = json.loads(self.made("load_step", "--json"))
        self.assertEqual((told["file"], told["duration_s"]), (str(FOLDER / "load_step.fmu"), 6))
        self.assertGreater(told["period_s"], 0)
        self.assertGreater(told["variables"], 250)

    def test_what_cannot_be_made_is_refused_with_its_cause(self):
        for arguments, code, part in ((["nowhere.toml"], 2, "nowhere.toml"), (["load_step", "--seed", "x"], 2, "accepted: whole numbers"),
                                      (["load_step", "--part", "motor"], 2, "accepted: ring, drive and plant"),
                                      (["load_step", "--set", "inertia=-1"], 2, "inertia"), (["load_step", "--out", "/proc/none"], 3, "/proc/none"),
                                      (["load_step", "--out", FOLDER, "--force"], 3, "tools/get-fmi")):
            env = dict(os.environ, **({"LAGLESS_FMU": "/nowhere/lagless.so"} if "tools" in part else {}))
            done = lagless("fmu", *arguments, env=env, cwd=FOLDER)
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertIn(part, done.stderr)
            self.assertEqual(list(FOLDER.glob("*.fmu*")), [])

    @unittest.skipUnless(os.path.exists("/dev/full"), "no /dev/full")
    def test_a_full_disk_is_reported(self):
        (FOLDER / "load_step.fmu").symlink_to("/dev/full")
        done = lagless("fmu", "load_step", "--out", FOLDER)
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertIn("No space left", done.stderr)


unittest.main(argv=sys.argv[:1])
