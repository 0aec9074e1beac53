#!/usr/bin/env python3
"""The project for Code Composer Studio agrees with CMake. It is compared with the command lines that the preset
gives to the stand-ins for TI's tools. Only Code Composer Studio can show how it reads the project.

usage: test_ccs.py BUILDS [unittest options]    BUILDS: the folder of chip_build.py

CC names a C compiler, for project_check.c.
"""
import os
import pathlib
import re
import shlex
import shutil
import sys
import tempfile
import unittest
import xml.etree.ElementTree

import chip_build
from chip_build import ROOT, run

TOOL = ROOT / "tools/projectspec"
COMMITTED = ROOT / "ti"
CC = os.environ.get("CC", "cc")
GIVEN = "--define=HAL_GATE_ACTIVE_HIGH=1"  # the user gives this option, because the project does not define the polarity of the gates
CHECK = "ti/project_check.c"  # the only source that exists in this project alone


class Project:
    """The project as Code Composer Studio would read it."""

    def __init__(self, folder):
        self.folder = folder
        self.project = xml.etree.ElementTree.parse(folder / "lagless.projectspec").getroot().find("project")
        (configuration,) = self.project.findall("configuration")
        self.compiler = shlex.split(configuration.get("compilerBuildOptions"))
        self.linker = shlex.split(configuration.get("linkerBuildOptions"))
        self.after = shlex.split(configuration.get("postBuildStep"))
        self.sources, self.linker_files, self.others = [], [], []
        for file in self.project.findall("file"):
            name = (pathlib.PurePosixPath(file.get("targetDirectory")) / pathlib.Path(file.get("path")).name).as_posix()
            kind = {".c": self.sources, ".asm": self.sources, ".cmd": self.linker_files}
            kind.get(pathlib.Path(name).suffix, self.others).append((name, self.path(file), file.get("action")))
        self.own = {}
        text = (folder / "makefile.defs").read_text(encoding="utf-8").replace("\\\n", " ")
        for line in text.splitlines():
            if line and not line.startswith("#"):
                objects, _, options = line.partition(": GEN_OPTS__FLAG += ")
                for name in objects.split():
                    self.own.setdefault(name, []).extend(shlex.split(options))

    def path(self, file):
        return (self.folder / file.get("path")).resolve()


def kind_of(word):
    return next((kind for kind in ("--define", "--include_path") if word.startswith(kind + "=")), "options")


def differences(project, build, gates=None):
    """Differences between the project and the build; `gates` is the option that the user gives."""
    found = []

    def compare(what, here, there):
        if here != there:
            found.append(f"{what}: {here} in the project, {there} in the build")

    def portable(word):
        for folder, variable in ((build.tools, "${CG_TOOL_ROOT}"), (build.ware,
                                 "${COM_TI_C2000WARE_INSTALL_DIR}"), (ROOT, "${LAGLESS_ROOT}")):
            word = re.sub(f"(^|=){re.escape(str(folder))}(?=/|$)", lambda m: m.group(1) + variable, word)
        return re.sub(r"^-D(\w+)$", r"--define=\1=1", re.sub(r"^-D(\w+=)", r"--define=\1", word))

    def of(words, kind):
        return [word for word in words if kind_of(word) == kind]

    sources = [name for name, _, _ in project.sources if name != CHECK]
    compare("sources", sorted(sources), sorted(build.compiled))
    compare("paths", [path for name, path, _ in project.sources if name != CHECK], [ROOT / name for name in sources])
    everywhere = {"--define": set(), "--include_path": set()}
    for name, (words,) in build.compiled.items():
        words = [portable(word) for word in words
                 if not re.match(r"--(compile_only|(c|asm)_file|preproc_\w+|output_file)\b", word)]
        if name.endswith(".asm"):  # Code Composer Studio assembles with the options of the compiler
            compare(f"{name}: options of its own", [word for word in words if word not in project.compiler and word != gates], [])
            continue
        own = project.own.get(name[:-len(".c")] + ".obj", [])
        compare(f"{name}: options", of(project.compiler + own, "options"), of(words, "options"))
        path = of(words, "--include_path")
        compare(f"{name}: include path", [word for word in of(project.compiler, "--include_path") if word in path],
                list(dict.fromkeys(path)))
        for kind, words_of_it in everywhere.items():
            words_of_it.update(of(words, kind))
    for kind, words in everywhere.items():
        compare(kind, set(of(project.compiler, kind)), words - {gates})
    compare("objects with options of their own that are none", sorted(set(project.own) - {
        str(pathlib.PurePosixPath(name).with_suffix(".obj")) for name, _, _ in project.sources}), [])
    (linked,) = build.linked
    at = linked.index("--run_linker")
    compare("compiler options at the link", [portable(word) for word in linked[:at]
                                             if portable(word) not in project.compiler], [])
    options = [portable(word) for word in linked[at + 1:] if word.startswith("--") and "output_file" not in word]
    rest = [[word for word in words if not word.startswith("--map_file=")] for words in (project.linker, options)]
    compare("linker options", *rest)
    compare("map file", *([word for word in words if word not in those]
                          for words, those in zip((project.linker, options), rest)))
    compare("linker file", [str(path) for _, path, _ in project.linker_files],
            [word for word in linked if word.endswith(".cmd")])
    compare("hex", project.after, ["${CG_TOOL_ROOT}/bin/hex2000", *build.converted[0]])
    return found


class Projects(unittest.TestCase):
    maxDiff = None

    @classmethod
    def setUpClass(cls):
        cls.build = chip_build.Build(chip_build.folder())
        cls.all = ((Project(COMMITTED), GIVEN), (Project(cls.build.folder / "ccs"), None))

    def test_the_committed_files_are_those_that_cmake_reports_without_a_compiler_of_ti(self):
        without = {name: value for name, value in os.environ.items() if not name.startswith("C2000")}
        asked = run(sys.executable, "-B", TOOL, "--check", env=without)
        self.assertEqual((asked.returncode, asked.stdout), (0, ""))

    def test_the_project_of_the_other_polarity_differs_in_its_definition_alone(self):
        for path in (self.build.folder / "ccs").glob("*.*"):
            high, low = (file.read_text(encoding="utf-8") for file in (path, self.build.low / "ccs" / path.name))
            self.assertEqual(high.replace(GIVEN, GIVEN[:-1] + "0"), low)
            self.assertEqual(high != low, path.suffix == ".projectspec")

    def test_sources_options_linker_files_and_libraries_are_those_of_the_build(self):
        for project, gates in self.all:
            with self.subTest(folder=project.folder):
                self.assertEqual(differences(project, self.build, gates), [])

    def test_the_project_is_for_the_chip_its_abi_and_its_compiler(self):
        for project, _ in self.all:
            for name, value in (("device", "TMS320C28XX.TMS320F28335"), ("endianness", "little"),
                                ("outputFormat", "ELF"), ("products", "C2000WARE"), ("linkerCommandFile", "")):
                self.assertEqual(project.project.get(name), value)
            self.assertRegex(project.project.get("cgtVersion"), r"^22\.6\.\d+\.LTS$")

    def test_sources_and_linker_files_stay_in_the_tree_what_a_user_may_change_is_copied(self):
        for project, _ in self.all:
            for name, path, action in project.sources + project.linker_files + project.others:
                self.assertTrue(path.is_file(), path)
                self.assertEqual(action, "copy" if name.endswith((".defs", ".ccxml")) else "link")
            self.assertEqual(sorted(name for name, _, _ in project.others), sorted(
                ["makefile.defs", *(f"targetConfigs/{path.name}" for path in (ROOT / "targetConfigs").iterdir())]))

    def test_gnu_make_gives_each_object_its_options(self):
        if not shutil.which("make"):
            self.skipTest("make is not installed")
        project = Project(self.build.folder / "ccs")
        objects = [str(pathlib.PurePosixPath(name).with_suffix(".obj")) for name, _, _ in project.sources]
        folder = self.build.folder / "ccs/flash"
        folder.mkdir(exist_ok=True)
        # A makefile with the structure of those that Code Composer Studio makes: a variable, rules that use it, and at the end the file of
        # the project.
        rules = "".join(f"{name}:\n\t@echo $@ $(GEN_OPTS__FLAG)\n" for name in objects)
        (folder / "makefile").write_text("GEN_OPTS__FLAG := --given\nall: " + " ".join(objects) + f"\n{rules}"
                                         "-include ../makefile.defs\n", encoding="utf-8")
        environment = {name: value for name, value in os.environ.items() if name not in ("MAKEFLAGS", "MAKELEVEL")}
        told = run("make", "--no-print-directory", "-C", folder, env=environment)
        self.assertEqual(told.returncode, 0, told.stdout)
        self.assertEqual({line.split()[0]: line.split()[1:] for line in told.stdout.splitlines()},
                         {name: ["--given", *project.own.get(name, [])] for name in objects})

    def seeded(self, file, pattern, text):
        """The report about the committed project after one change to one of its files."""
        with tempfile.TemporaryDirectory(dir=self.build.folder) as name:
            folder = pathlib.Path(name)
            for path in COMMITTED.iterdir():
                old = path.read_text(encoding="utf-8").replace("../", os.path.relpath(ROOT, folder) + "/")
                new = re.sub(pattern, text, old, count=1) if path.name == file else old
                self.assertEqual(new != old, path.name == file)
                (folder / path.name).write_text(new, encoding="utf-8")
            return " ".join(differences(Project(folder), self.build, GIVEN))

    def test_each_seeded_difference_is_found(self):
        spec = "lagless.projectspec"
        for what, file, pattern, text in (
                ("sources", spec, r".*/smo\.c.*\n", ""),
                ("paths", spec, r"firmware/estimator/smo\.c", "firmware/math/smo.c"),
                ("options", spec, " -O2", " -O3"),
                ("--define", spec, " -v28", " -v28 --define=NDEBUG=1"),
                ("include path", spec, r"(--include_path=\S*/firmware) (--include_path=\S*)", r"\2 \1"),
                ("trig.c: options", "makefile.defs", r"(\nti/project_check)",
                 r"\nfirmware/math/trig.obj: GEN_OPTS__FLAG += --ramfunc=on\n\1"),
                ("options of their own", "makefile.defs", r"(\nti/project_check)",
                 r"\nfirmware/trig.obj: GEN_OPTS__FLAG += --ramfunc=on\n\1"),
                ("linker options", spec, "0x700", "0x400"),
                ("linker options", spec, r"(--library=\S*fast\S*) (--library=\w+\.lib)", r"\2 \1"),
                ("map file", spec, " --map_file=lagless.map", ""),
                ("linker file", spec, r"linker/f28335_flash\.cmd", "linker/f28335_otp.cmd"),
                ("hex", spec, "--romwidth=16", "--romwidth=8")):
            with self.subTest(pattern=pattern):
                self.assertIn(what, self.seeded(file, pattern, text))


class Check(unittest.TestCase):
    """project_check.c stops the build of a wrong project that would otherwise succeed."""

    def test_what_is_missing_is_reported_and_a_complete_project_builds(self):
        whole = "-DLAGLESS_PER_FILE_OPTIONS"
        for definitions, *texts in (([whole], "HAL_GATE_ACTIVE_HIGH is not defined: add it to the predefined symbols", "1 with active_high, 0 with active_low"),
                                    ([whole, "-DHAL_GATE_ACTIVE_HIGH=2"], "accepted: 1 with active_high, 0 with active_low"),
                                    (["-DHAL_GATE_ACTIVE_HIGH=1"], "makefile.defs was not read"),
                                    ([whole, "-DHAL_GATE_ACTIVE_HIGH=0"],), ([whole, "-DHAL_GATE_ACTIVE_HIGH=1"],)):
            with self.subTest(definitions=definitions):
                asked = run(CC, "-std=c99", "-Wall", "-Wextra", "-fsyntax-only", *definitions, COMMITTED / "project_check.c")
                self.assertEqual((asked.returncode == 0, asked.stdout == ""), (not texts, not texts), asked.stdout)
                for text in texts:
                    self.assertIn(text, asked.stdout)

    def test_makefile_defs_marks_the_file_that_looks_for_it(self):
        self.assertEqual(Project(COMMITTED).own["ti/project_check.obj"], ["--define=LAGLESS_PER_FILE_OPTIONS"])
        self.assertIn((CHECK, COMMITTED / "project_check.c", "link"), Project(COMMITTED).sources)


class Tool(unittest.TestCase):
    FACTS = ("root /tree\ntools /cgt\nware /ware\nprocessor CHIP\nflags -v28\nlink_options --priority;/tree/flash.cmd\n"
             "libraries \nhex_options --intel\nlinker_file /tree/flash.cmd\ntarget one\n"
             "definitions A=1\nincludes /tree\noptions --c99\nsource /tree/a.c\n")

    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name).resolve()

    def asked(self, facts, *more):
        (self.folder / "facts").write_text(facts, encoding="utf-8")
        return run(sys.executable, "-B", TOOL, "--facts", self.folder / "facts", "--out", self.folder / "out", *more)

    def test_options_of_all_and_of_single_sources_are_distinguished(self):
        for value in ('"boards/x.h"', '"a b"', r'"a\b"', "a&b<c>"):  # a definition remains one word
            self.assertEqual(self.asked(self.FACTS.replace("A=1", f"A={value}")).returncode, 0)
            self.assertIn(f"--define=A={value}", Project(self.folder / "out").compiler)
        facts = self.FACTS + "source_options --ramfunc=on;--x=1\nsource /tree/b/b.c\nsource_options --x=1\n"
        self.assertEqual(self.asked(facts).returncode, 0)
        project = Project(self.folder / "out")
        self.assertEqual(project.own["a.obj"], ["--ramfunc=on"])
        self.assertEqual([word for word in project.compiler if word in ("--c99", "--x=1")], ["--c99", "--x=1"])

    def test_wrong_facts_are_refused_with_what_is_wrong(self):
        for facts, text in ((self.FACTS + "target two\ndefinitions A=2\n", "A is 2 here and 1 elsewhere"),
                            (self.FACTS.replace("includes /tree", "includes /" "home/me/include"), "/" "home/me/include names a folder outside"),
                            ("int main(void);\n", "facts:1: 'int' is none of"), (self.FACTS.replace("tools /cgt\n", ""), "tools missing")):
            asked = self.asked(facts)
            self.assertEqual((asked.returncode, "Traceback" in asked.stdout), (2, False), asked.stdout)
            self.assertIn(text, asked.stdout)

    def test_check_names_the_stale_file_and_writes_nothing(self):
        self.asked(self.FACTS)
        self.assertEqual(self.asked(self.FACTS, "--check").returncode, 0)
        asked = self.asked(self.FACTS.replace("--c99", "--c11"), "--check")
        self.assertEqual(asked.returncode, 1)
        self.assertRegex(asked.stdout, r"^\S*lagless\.projectspec: differs from the targets of CMake")
        self.assertIn("--c99", Project(self.folder / "out").compiler)


class Targets(unittest.TestCase):
    def test_a_target_configuration_names_probe_driver_and_chip_by_the_files_of_the_target_database(self):
        probes = {"f28335_xds100v2": ("Texas Instruments XDS100v2 USB Debug Probe", "TIXDS100v2_Connection.xml", "tixds100v2c28x.xml"),
                  "f28335_xds110": ("Texas Instruments XDS110 USB Debug Probe", "TIXDS110_Connection.xml", "tixds510c28x.xml"),
                  "f28335_xds200": ("Texas Instruments XDS2xx USB Debug Probe", "TIXDS2XXUSB_Connection.xml", "tixds560c28x.xml")}
        self.assertEqual({path.stem for path in (ROOT / "targetConfigs").iterdir()}, set(probes))
        for name, (probe, connection, driver) in probes.items():
            root = xml.etree.ElementTree.parse(ROOT / f"targetConfigs/{name}.ccxml").getroot()
            self.assertEqual({root.find("configuration").get("id"), root.find("configuration/connection").get("id")}, {probe + "_0"})
            self.assertEqual([(found.get("href"), found.get("xml")) for found in root.iter("instance")],
                             [(f"{folder}/{file}", file) for folder, file in (("connections", connection), ("drivers", driver), ("devices", "f28335.xml"))])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[2:])
