"""`tools/release` makes the source archive, and from it one wheel for every Python of the platform. The wheel runs in an empty virtual
environment without a compiler and gives the bits of the program `lagless`. All have the same version.

usage: test_wheel.py LAGLESS FOLDER [LIBRARY]     run by a Python that has scikit-build-core and auditwheel. Ends with 77, skipped,
without them. With LIBRARY, the library of this build, the wheel contains that and compiles nothing."""
import importlib.util
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tarfile
import time
import unittest
import zipfile

if importlib.util.find_spec("scikit_build_core") is None or importlib.util.find_spec("auditwheel") is None:
    print("skipped: this Python has no scikit-build-core or no auditwheel (tools/setup all installs them into build/venv)")
    sys.exit(77)

LAGLESS, FOLDER, LIBRARY = sys.argv[1], pathlib.Path(sys.argv[2]).absolute(), (sys.argv[3:] or [None])[0]
ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENARIO = {"title": "as the program", "run": {"duration": "0.3 s"}, "requests": {"enable": "on", "speed_request": 20}}
PROGRAM = """
import json, os, shutil, sys
import lagless
assert not any(shutil.which(name) for name in ("cc", "gcc", "clang", "c++", "cmake", "ninja")), "the environment has a compiler, but the test needs one without"
result = lagless.run(json.loads(sys.argv[1]), record=["i_q"])
assert os.path.dirname(lagless.__file__) == os.path.dirname(os.environ["LAGLESS_MOTORS"]), "motors of the tree"
lagless.run({"title": "a motor of the library", "motor": "teknic-m2310p-ln-04k", "run": {"duration": "1 ms"}})
assert [lagless.Rig(board=name)["u_dc"] >= 0 for name in lagless.boards()]
print(json.dumps({"hash": result.hash, "samples": len(result.i_q), "file": lagless.__file__, "known": list(lagless.scenarios())}))
"""


def without_ours():
    """The environment without the variables that refer to the tree."""
    return {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "LAGLESS_LIBRARY", "LAGLESS_MOTORS")}


class Wheel(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        begin = time.monotonic()
        # The build is not optimised, which does not change the bits, and has no debug information, which the wheel would not contain
        # anyway. The test python_package uses the optimised library.
        plain = [f"--setting=cmake.define.CMAKE_{language}_FLAGS_DEBUG=-O0" for language in ("C", "CXX")]
        made = subprocess.run([sys.executable, "-B", str(ROOT / "tools/release"), "--out", str(FOLDER), "--setting=cmake.build-type=Debug",
                               *(["--library", LIBRARY] if LIBRARY else plain)], capture_output=True, text=True, check=False)
        if made.returncode != 0 and "numpy cannot be installed" in made.stderr:
            raise unittest.SkipTest(made.stderr)
        if made.returncode != 0:
            raise AssertionError(made.stdout + made.stderr)
        cls.wheel = next(FOLDER.glob("*.whl"))
        cls.source = next(FOLDER.glob("*.tar.gz"))
        print(f"made in {time.monotonic() - begin:.1f} s:\n{made.stdout}")
        cls.python = FOLDER / "venv/bin/python"

    def test_it_is_for_any_python_of_this_platform(self):
        self.assertRegex(self.wheel.name, r"^lagless-[\d.]+-py3-none-manylinux_2_\d+_\w+\.whl$")

    def test_one_version_everywhere(self):
        """CMakeLists.txt defines the version of the project. All other places read it there, except the citation and the page that shows
        it."""
        project = re.search(r"^project\(lagless VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"), re.MULTILINE)[1]
        with tarfile.open(self.source) as archive:
            about = archive.extractfile(f"lagless-{project}/PKG-INFO").read().decode()
        metadata = zipfile.ZipFile(self.wheel).read(f"lagless-{project}.dist-info/METADATA").decode()
        known = {
            "program": subprocess.run([LAGLESS, "--version"], capture_output=True, text=True, check=True).stdout.split()[-1],
            "citation": re.search(r"^version: (.+)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.MULTILINE)[1],
            "first hour": re.search(r"^    lagless ([\d.]+)$", (ROOT / "docs/first_hour.md").read_text(encoding="utf-8"), re.MULTILINE)[1],
            "changes": re.search(r"the first release will be ([\d.]+\d)", (ROOT / "docs/CHANGELOG.md").read_text(encoding="utf-8"))[1],
            "source archive": re.search(r"^Version: (.+)$", about, re.MULTILINE)[1],
            "wheel": re.search(r"^Version: (.+)$", metadata, re.MULTILINE)[1],
            "package": json.loads((FOLDER / "cold_start.json").read_text())["version"],
        }
        self.assertEqual(known, dict.fromkeys(known, project))

    def test_the_source_archive_holds_what_git_keeps_and_nothing_that_was_built(self):
        with tarfile.open(self.source) as archive:
            names = {name.split("/", 1)[1] for name in archive.getnames() if "/" in name}
        self.assertLessEqual({"CMakeLists.txt", "LICENSE", "README.md", "pyproject.toml", "host_sim/python/lagless/__init__.py",
                              "host_sim/scenarios/cold_start.toml", "firmware/fast/fast.c", "tests/CMakeLists.txt"}, names)
        self.assertEqual([name for name in names if name.startswith(("build/", ".git/"))], [])

    def test_its_cold_start_has_the_bits_of_the_program(self):
        said = json.loads((FOLDER / "cold_start.json").read_text())
        program = subprocess.run([LAGLESS, "run", "cold_start", "--json"], capture_output=True, text=True, check=True)
        self.assertEqual((said["hash"], said["passed"]), (json.loads(program.stdout)["state_hash"], True))
        self.assertTrue(pathlib.Path(said["file"]).is_relative_to(FOLDER))

    def test_it_holds_the_package_the_library_scenarios_and_motors_and_no_more(self):
        names = [name for name in zipfile.ZipFile(self.wheel).namelist() if not name.endswith("/")]
        ours = sorted(name for name in names if name.startswith("lagless/"))
        folder = ROOT / "host_sim/python/lagless"
        package = [f"lagless/{path.relative_to(folder)}" for path in (*folder.glob("*.py"), *folder.glob("bench/*"))]
        known = [f"lagless/{folder}/{path.name}" for folder in ("scenarios", "motors")
                 for path in (ROOT / "host_sim" / folder).glob("*.toml")]
        boards = [f"lagless/boards/{path.stem}/liblagless.so" for path in (ROOT / "hal/f28335/boards").glob("*.h") if path.stem != "pm50rl1a060"]
        self.assertEqual(ours, sorted(package + known + boards + ["lagless/liblagless.so"]))
        self.assertEqual({name.split("/")[0] for name in names}, {"lagless", self.wheel.name.rsplit("-", 3)[0] + ".dist-info"})

    @unittest.skipUnless(shutil.which("readelf"), "no readelf")
    def test_its_library_needs_libc_alone_and_shows_the_binding_alone(self):
        library = FOLDER / "lib.so"
        library.write_bytes(zipfile.ZipFile(self.wheel).read("lagless/liblagless.so"))
        for each in (library, pathlib.Path(os.environ["LAGLESS_LIBRARY"])):  # the library of the wheel, and the optimised one of this build
            text = subprocess.run(["readelf", "--wide", "--dynamic", "--dyn-syms", str(each)], capture_output=True, text=True,
                                  check=True).stdout
            needed = set(re.findall(r"\(NEEDED\).*\[(.*)\]", text))
            self.assertLessEqual(needed, {"libc.so.6", "libm.so.6", "libpthread.so.0", "ld-linux-x86-64.so.2", "ld-linux-aarch64.so.1"})
            shown = set(re.findall(r"(?:FUNC|OBJECT)\s+(?:GLOBAL|WEAK)\s+DEFAULT\s+\d+\s+(\w+)", text))
            header = (ROOT / "host_sim/python/binding.h").read_text(encoding="utf-8")
            self.assertEqual(shown, set(re.findall(r"^BINDING [^;(]*?(\w+)\(", header, re.MULTILINE)))

    def test_without_a_compiler_it_runs_with_the_bits_of_the_program(self):
        begin = time.monotonic()
        done = subprocess.run([str(self.python), "-c", PROGRAM, json.dumps(SCENARIO)], capture_output=True, text=True, check=False,
                              cwd=FOLDER, env={**without_ours(), "PATH": str(FOLDER / "venv/bin")})
        self.assertEqual(done.returncode, 0, done.stderr)
        said = json.loads(done.stdout)
        print(f"imported and run in {time.monotonic() - begin:.1f} s")
        path = FOLDER / "scenario.toml"
        path.write_text("""schema = 1
title = "as the program"
[run]
duration = "0.3 s"
[requests]
enable = "on"
speed_request = 20
""", encoding="utf-8")
        program = subprocess.run([LAGLESS, "run", str(path), "--json"], capture_output=True, text=True, check=True)
        self.assertEqual(said["hash"], json.loads(program.stdout)["state_hash"])
        self.assertEqual((said["samples"], pathlib.Path(said["file"]).is_relative_to(FOLDER)), (3000, True))
        self.assertIn("cold_start", said["known"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
