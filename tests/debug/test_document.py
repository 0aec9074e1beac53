#!/usr/bin/env python3
"""The session of docs/debugger.md, command by command: what it shows is what gdb prints, "..." standing for any number of lines.

usage: test_document.py --root FOLDER --program LAGLESS [--renew]
--renew: the document is written anew, each line as gdb prints the one that is most like it."""
import argparse
import difflib
import pathlib
import re
import subprocess
import sys

PARSER = argparse.ArgumentParser()
PARSER.add_argument("--root", type=pathlib.Path, required=True)
PARSER.add_argument("--program", type=pathlib.Path, required=True)
PARSER.add_argument("--renew", action="store_true")
OPTIONS = PARSER.parse_args()
DOCUMENT = OPTIONS.root / "docs/debugger.md"
MARK = "@@@"


def session():
    """(command line, {gdb's command: lines shown}) of the document; "" is what the command line itself prints."""
    text = DOCUMENT.read_text()
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


def renew(shown, printed):
    """Puts what gdb prints in the place of the lines shown."""
    at, new = 0, []
    for line in shown:
        if line.strip() != "...":
            likeness = [difflib.SequenceMatcher(None, line, other).ratio() for other in printed[at:]]
            at += likeness.index(max(likeness)) + 1
            line = printed[at - 1]
        new.append("    " + line + "\n")
    return "".join(new)


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
        if OPTIONS.renew:
            old = "".join(f"    {line}\n" for line in lines)
            DOCUMENT.write_text(DOCUMENT.read_text().replace(old, renew(lines, printed.splitlines())))
            continue
        wrong = differs(lines, printed.splitlines())
        if wrong is not None:
            sys.exit(f"docs/debugger.md, '(gdb) {command}' shows\n  {wrong}\nwhere gdb prints\n{printed}")
    print(f"{len(shown)} commands as in docs/debugger.md")


main()
