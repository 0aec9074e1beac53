#!/usr/bin/env python3
"""The preset f28335-flash, made once with stand-ins for TI's tools, for all tests of this folder. It is configured for both
polarities of the gates and built for one of them. The call graphs of its sources are those of GCC.

usage: chip_build.py FOLDER    makes it; the tests get the same folder as their first argument
"""
import json
import pathlib
import shutil
import subprocess
import sys

import stand_in

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILT = "active_high"
GATES = {BUILT: 1, "active_low": 0}


def run(*command, **more):
    return subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          check=False, **more)


def configure(folder, environment, *options):
    return run("cmake", "--preset", "f28335-flash", "-B", folder, *options, cwd=ROOT, env=environment)


def make(folder):
    shutil.rmtree(folder, ignore_errors=True)
    environment = stand_in.install(folder / "tools")
    configured = {gates: configure(folder / gates, environment, f"-DLAGLESS_GATES={gates}") for gates in GATES}
    # This discards the files that CMake compiled as a trial, which are not part of the build.
    (folder / "tools/log").write_text("", encoding="utf-8")
    built = {gates: run("cmake", "--build", folder / gates, *([] if gates == BUILT else ["--target", "ccs"]), env=environment)
             for gates in GATES}
    told = {what: {gates: (done.returncode, done.stdout) for gates, done in steps.items()}
            for what, steps in (("configured", configured), ("built", built))}
    (folder / "told.json").write_text(json.dumps(told), encoding="utf-8")
    return 0 if all(code == 0 for steps in told.values() for code, _ in steps.values()) else 1


class Build:
    """The results of make(): the command lines of the tools, and their folders."""

    def __init__(self, folder):
        self.folder, self.tools, self.ware = folder / BUILT, folder / "tools/cgt", folder / "tools/ware"
        self.low = folder / "active_low"
        told = json.loads((folder / "told.json").read_text(encoding="utf-8"))
        self.configured, self.built = told["configured"][BUILT][1], told["built"][BUILT][1]
        lines = [json.loads(line) for line in (folder / "tools/log").read_text(encoding="utf-8").splitlines()]
        self.compiled, self.linked, self.archived, self.converted = {}, [], {}, []
        for line in lines:
            words = line["words"]
            if line["tool"] == "ar2000":
                self.archived[words[1]] = words[2:]
            elif line["tool"] == "hex2000":
                self.converted.append(words)
            elif "--run_linker" in words:
                self.linked.append(words)
            else:
                source = next(word for word in words if "_file=" in word).partition("=")[2]
                self.compiled.setdefault(pathlib.Path(source).relative_to(ROOT).as_posix(), []).append(words)

    def objects(self):
        return [stand_in.value(lines[0], "--output_file") for lines in self.compiled.values()]


def folder():
    """The folder, which is the first argument of a test."""
    return pathlib.Path(sys.argv[1]).resolve()


if __name__ == "__main__":
    import graphs  # imported here because graphs needs this module
    status = make(folder())
    if status == 0:
        graphs.make(folder())
    else:
        print((folder() / "told.json").read_text(encoding="utf-8").replace("\\n", "\n"))
    sys.exit(status)
