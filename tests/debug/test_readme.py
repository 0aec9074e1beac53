#!/usr/bin/env python3
"""The README's debugger session, command by command: what it shows is what gdb prints, "..." standing for any number of lines.

usage: test_readme.py --root FOLDER --program LAGLESS"""
import argparse
import pathlib
import re
import subprocess
import sys

PARSER = argparse.ArgumentParser()
PARSER.add_argument("--root", type=pathlib.Path, required=True)
PARSER.add_argument("--program", type=pathlib.Path, required=True)
OPTIONS = PARSER.parse_args()
MARK = "@@@"
SECTION = "## Stop inside the interrupt"


def session():
    """(command line, {gdb's command: lines shown}) of the README; "" is what the command line itself prints."""
    text = (OPTIONS.root / "README.md").read_text().split(SECTION)[1].split("\n## ")[0]
    blocks = re.findall(r"(?:^    .*\n)+", text, re.MULTILINE)
    (command,), lines = blocks[0].split("\n")[:-1], blocks[1].splitlines()
    shown = {"": []}
    for line in lines:
        line = line[4:]
        if line.startswith("(gdb) "):
            shown[line[6:]] = []
        else:
            shown[list(shown)[-1]].append(line)
    return command.split(), shown


def differs(shown, printed):
    """The first line shown that is not printed in its place; None."""
    at, gap = 0, False
    for line in shown:
        if line.strip() == "...":
            gap = True
        elif gap and line in printed[at:]:
            at, gap = printed.index(line, at) + 1, False
        elif not gap and at < len(printed) and printed[at] == line:
            at += 1
        else:
            return line
    return None if gap or at == len(printed) else f"(nothing, where gdb prints '{printed[at]}')"


def main():
    (tool, *words), shown = session()
    line = [sys.executable, OPTIONS.root / tool, *words, "--program", OPTIONS.program, "--batch"]
    for command in list(shown)[1:]:
        line += ["-ex", f"echo {MARK}\\n", "-ex", command]
    done = subprocess.run(
        line, cwd=OPTIONS.root, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, text=True, check=False
    )
    parts = done.stdout.split(MARK + "\n")
    begin = next((n for n, text in enumerate(parts[0].splitlines()) if text.startswith("period ")), 0)
    parts[0] = "\n".join(parts[0].splitlines()[begin:])  # above it gdb may tell of libraries
    if len(parts) != len(shown):
        sys.exit(done.stdout)
    for (command, lines), printed in zip(shown.items(), parts):
        wrong = differs(lines, printed.splitlines())
        if wrong is not None:
            sys.exit(f"README.md, '(gdb) {command}' shows\n  {wrong}\nwhere gdb prints\n{printed}")
    print(f"{len(shown)} commands as in README.md")


main()
