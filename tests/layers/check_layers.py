#!/usr/bin/env python3
"""Checks the rules of the house that no linker checks: who may include whom, which symbols a library may need, what may not
stand in the C of firmware/ and hal/, and that no file cites a document that the project has not. Prints one line a breach,
`file:line: rule: text`, and ends with 1 if there is any.

usage: check_layers.py [--root FOLDER] [--nm NM] [--library ROOM=ARCHIVE]...

Libraries: core (of firmware/, what knows no board), firmware, app, hal, chip, plant, rig. Symbol rules need archives without sanitizer or coverage
counters, compiled with -g for line numbers. Python 3.9, standard library only.
"""
import argparse
import pathlib
import re
import subprocess
import sys

# ---- The rules ----------------------------------------------------------------------------------------------------------

# Rooms by folder, the longest that fits wins.
ROOMS = (
    "firmware/math",
    "firmware/contract",
    "firmware/estimator",
    "firmware/fast/inverter",
    "firmware/fast/control",
    "firmware/fast/protect",
    "firmware/fast/reference",
    "firmware/fast",
    "firmware/medium/adapt",
    "firmware/medium/protect",
    "firmware/medium/manoeuvre",
    "firmware/medium",
    "firmware/guard",
    "firmware/settings",
    "firmware/talk",
    "firmware/drive",
    "firmware/app",
    "firmware",
    "hal",
    "host_sim/chip",
    "host_sim/plant",
    "host_sim/rig",
    "host_sim/line",
    "host_sim/lab",
    "host_sim/scope",
    "host_sim/python",
    "host_sim/fmu",
    "host_sim/cli",
    "host_sim",
    "tests",
)

# The floors of the firmware, lowest first; rooms of one floor do not call each other.
FLOOR_1 = ("firmware/math",)
FLOOR_2 = FLOOR_1 + ("firmware/contract",)
FAST_3 = FLOOR_2 + ("firmware/estimator", "firmware/fast/inverter", "firmware/fast/control", "firmware/fast/protect")
MEDIUM_3 = ("firmware/medium/adapt", "firmware/medium/protect")
TALK = ("firmware/talk",)
FAST_4 = FAST_3 + ("firmware/fast/reference",)
# The tables of parameters, requests, faults and reasons: what they say is known to all that follow the board.
TABLES_OF_SETTINGS = ("firmware/settings/params.h", "firmware/settings/requests.h", "firmware/settings/faults.h",
                      "firmware/settings/reasons.h")
# What the medium task knows of the fast one: the two structs between them, and what these are made of.
WINDOW = FAST_4 + ("firmware/fast/window.h", "firmware/fast/measure.h")
MEDIUM_4 = MEDIUM_3 + ("firmware/medium/manoeuvre",)
TASKS = FAST_4 + MEDIUM_4 + ("firmware/guard", "firmware/fast", "firmware/medium")
FIRMWARE_CORE = TASKS + ("firmware/settings", "firmware/drive")
# The door, the shapes of the tables, what both ends of a line hold to.
RIG_DOOR = ("host_sim/rig/rig.h", "firmware/contract/table.h", "firmware/contract/line.h", "firmware/settings/reasons.h",
            "firmware/settings/faults.h")

# What each room may include besides itself: rooms, or single files. Each floor of the firmware calls only downward.
MAY_INCLUDE = {
    "firmware/math": (),
    "firmware/contract": FLOOR_1,
    "firmware/estimator": FLOOR_2,
    "firmware/fast/inverter": FLOOR_2,
    "firmware/fast/control": FLOOR_2,
    "firmware/fast/protect": FLOOR_2,
    "firmware/medium/adapt": FLOOR_2,
    "firmware/medium/protect": FLOOR_2,
    "firmware/talk": FLOOR_2,
    "firmware/fast/reference": FAST_3,
    "firmware/medium/manoeuvre": WINDOW + MEDIUM_3 + TABLES_OF_SETTINGS,
    "firmware/guard": WINDOW + MEDIUM_4 + TABLES_OF_SETTINGS,
    "firmware/fast": FAST_4 + ("firmware/guard",) + TABLES_OF_SETTINGS,
    "firmware/medium": WINDOW + MEDIUM_4 + ("firmware/guard",) + TABLES_OF_SETTINGS,
    # hal/board.h: rates, ranges and defaults of the board, constants all. Signals are places in drive_t.
    "firmware/settings": TASKS + ("hal/board.h", "firmware/drive/drive.h"),
    "firmware/drive": TASKS + ("firmware/settings",),
    "firmware/app": FIRMWARE_CORE + TALK + ("hal",),
    "firmware": (),
    "hal": (),
    "host_sim/chip": ("hal/f28335/registers.h", "hal/f28335/bus.h"),
    "host_sim/plant": ("hal/board.h",),
    "host_sim/rig": FIRMWARE_CORE + TALK + ("firmware/app", "hal", "host_sim/chip", "host_sim/plant"),
    # The rig's interface is the only door for everything above it.
    "host_sim/line": RIG_DOOR,
    "host_sim/lab": RIG_DOOR,
    "host_sim/scope": RIG_DOOR + ("host_sim/line", "host_sim/lab"),
    # The plant by itself has no other door.
    "host_sim/python": RIG_DOOR + ("host_sim/lab", "host_sim/plant"),
    "host_sim/fmu": ("host_sim/rig/rig.h", "firmware/contract/table.h", "host_sim/lab"),
    "host_sim/cli": RIG_DOOR + ("host_sim/line", "host_sim/lab", "host_sim/scope"),
    "host_sim": ("firmware/math/check.h",),
}

# Which of the two estimators the drive runs on: only the drive and what is above it may see that, for lagless_core is compiled once
# for both.
CHOICE = "firmware/estimator/chosen.h"
CHOOSING = ("firmware/guard", "firmware/fast", "firmware/medium", "firmware/settings", "firmware/drive", "firmware/app")

# Headers of the system in firmware/ and hal/: types, limits, memcpy; math.h for sqrtf and isfinite.
TARGET_HEADERS = {"stdint.h", "stdbool.h", "stddef.h", "limits.h", "float.h", "string.h", "math.h", "inttypes.h"}

# Symbols that no room needs to ask for: memory blocks, and what compiler and linker put in by themselves.
MEMORY = {"memcpy", "memset", "memmove", "memcmp", "__memcpy_chk", "__memset_chk", "__memmove_chk"}
COMPILER = {"_GLOBAL_OFFSET_TABLE_", "__stack_chk_fail", "__tls_get_addr"}

# Libraries: what else each may leave undefined (regular expression), which libraries it may link to, and which writable data
# it may own (regular expression or None). That the rooms of the firmware call only downward, and chip and plant nobody, is
# the linker's to say (CMakeLists.txt beside this file).
LIBRARIES = {
    "core": {"extern": r"sqrtf|str(?:len|chr|n?cmp)|check_failed", "uses": (), "data": None},
    "firmware": {"extern": r"sqrtf|str(?:len|chr|n?cmp)|check_failed", "uses": ("core",), "data": None},
    # desk_drive_...: what the desk's build puts in the place of drive_step and drive_medium_step (host_sim/rig/rig.cmake)
    "app": {"extern": r"desk_drive_(medium_)?step", "uses": ("core", "firmware", "hal"), "data": r"app|talk_line"},
    "hal": {"extern": r"bus_\w+|f28335_base", "uses": (), "data": None},
    "chip": {},
    "plant": {},
    "rig": {},
}
STRICT_LIBRARIES = ("core", "firmware", "app", "hal")

# Functions of libm whose last bit depends on the machine's libm: nowhere in a state computation of firmware or desk.
INEXACT = re.compile(
    r"(?:a?(?:sin|cos|tan)h?|atan2|sincos|exp|exp2|exp10|expm1|log|log2|log10|log1p|pow|cbrt|hypot|erfc?|[lt]gamma|j[01n]|y[01n])"
    r"[fl]?"
)

# Words that must not stand in firmware/ and hal/, and why.
FORBIDDEN = {
    "double": "no double precision on the target",
    "uint8_t": "a C28x has no 8-bit type",
    "int8_t": "a C28x has no 8-bit type",
    "malloc": "no dynamic memory",
    "calloc": "no dynamic memory",
    "realloc": "no dynamic memory",
    "free": "no dynamic memory",
    "alloca": "no dynamic memory",
    "setjmp": "no jumps out of functions",
    "longjmp": "no jumps out of functions",
    "assert": "the library's console and abort; CHECK of firmware/math/check.h",
    "abort": "the run-time library's, in one object with exit",
    "exit": "nothing to go back to",
}

# Paths of one person's machine. Written so that this line is none.
MACHINE_PATH = re.compile(r"(?<![A-Za-z0-9_.$}/-])/(?:root|home|work|farm|Users)/[A-Za-z0-9_.]")

# Documents: a comment cites nothing that a reader of the project has not before him. A word that ends like a document must
# be a file of the project; these phrases have stood for papers of our own outside it. Manuals by number are real documents.
DOCUMENT = re.compile(r"(?<![A-Za-z0-9_./-])[A-Za-z0-9_./-]*[A-Za-z0-9_]\.md\b")
OUTSIDE = re.compile(
    r"\b[Ff]acts (?:on|sheet|section|table)\b|\bfacts: (?=[a-z])|\bF28335 facts\b|\(design\)|\bdesign: (?=[a-z])"
    r"|\breference study\b|\b[Ii]ssue #?\d"
)
CITED_SECTION = re.compile(r"docs/theory\.md,[\s*#/]*(\d+)")

# What a reader can hold in his head: lines of a function and of a file of firmware/ and hal/. A table may be longer.
FUNCTION_LINES = 60
FILE_LINES = {"firmware/drive/drive.c": 200}
ANY_FILE_LINES = 500
TABLES = re.compile(r".*/(registers|params|faults|signals|reasons)\.h|hal/f28335/boards/.*")

# What keeps the firmware readable and is in no single line: structs that are no bags (the rows of a table, X macros, are no fields
# that a reader has to know), no circle of includes, and no schedule by a remainder: a task has its steps in their order.
FIELDS = 25
STRUCT = re.compile(r"\bstruct\b[ \t]*\w*[ \t\n]*\{")
SLOT = re.compile(r"% *(?:GUARD|CURRENT|DRIVE|LOOK)_\w+")

# The parts of the estimator are its own: nobody else reaches through it into one of them.
INNER_PARTS = re.compile(r"(?:\.|->)(?:pll|smo)(?:\.|->)")
INNER_PARTS_OF = "firmware/estimator/"

# ---- Reading sources ----------------------------------------------------------------------------------------------------

C_ENDINGS = {".c", ".h", ".cpp", ".hpp"}
NOT_OURS = {".git", "build", "report", "__pycache__"}
COMMENT_OR_TEXT = re.compile(
    r"//(?:\\\n|[^\n])*|/\*.*?\*/|\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])*'", re.DOTALL
)
INCLUDE = re.compile(r"^[ \t]*#[ \t]*include[ \t]*(.*?)[ \t]*$", re.MULTILINE)
WORD = re.compile(r"[A-Za-z_]\w*")
FLOAT_WITHOUT_F = re.compile(r"(?<![\w.])(?:\d+\.\d*(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?|\d+[eE][+-]?\d+)(?![\w.])")


def without_comments(text, keep_text):
    """The source with comments (and, unless kept, strings and characters) blanked out; line breaks stay."""

    def blank(match):
        found = match.group()
        if keep_text and found[0] in "\"'":
            return found
        return re.sub(r"[^\n]", " ", found)

    return COMMENT_OR_TEXT.sub(blank, text)


def line_of(text, position):
    return text.count("\n", 0, position) + 1


def room_of(path):
    for room in ROOMS:
        if path == room or path.startswith(room + "/"):
            return room
    return None


def project_files(root):
    """All files of the project, as paths from the root: what git knows or would add, or everything without git."""
    git = subprocess.run(
        ["git", "-C", str(root), "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        check=False,
    ) if (root / ".git").exists() else None
    if git is not None and git.returncode == 0:
        names = [name for name in git.stdout.decode().split("\0") if name]
    else:
        names = [p.relative_to(root).as_posix() for p in root.rglob("*")]
    return sorted(n for n in set(names) if not NOT_OURS & set(n.split("/")) and (root / n).is_file())


def fields_of(code, opening):
    """How many fields the struct has whose brace opens here; those of a struct within it are that one's."""
    depth, body = 0, ""
    for sign in code[opening:]:
        depth += (sign == "{") - (sign == "}")
        if depth == 0:
            break
        body += sign if depth == 1 and sign not in "{}" else ""
    lines = [line for line in body.splitlines() if not line.lstrip().startswith("#")]
    return sum(len(field.split(",")) for field in "\n".join(lines).split(";") if re.search(r"\w", field))


def rings(nodes, edges):
    """The rings of a graph, each with its first node at both ends; edges: an iterator over the nodes behind one."""
    finished = set()
    for first in nodes:
        trail, stack = [], [(first, None)]
        while stack:
            node, inner = stack.pop()
            if inner is None:
                if node in finished:
                    continue
                if node in trail:
                    yield trail[trail.index(node):] + [node]
                    continue
                trail.append(node)
                inner = edges(node)
            following = next(inner, None)
            if following is None:
                finished.add(trail.pop())
            else:
                stack.append((node, inner))
                stack.append((following, None))


class Checker:
    def __init__(self, root):
        self.root = root
        self.breaches = []

    def breach(self, path, line, rule, text):
        self.breaches.append((path, line, rule, text))

    # ---- Includes ---------------------------------------------------------------------------------------------------

    def resolve(self, path, name):
        """The project file that an include of `path` means, or None for a header from outside. A file that is not there
        is taken for what its name says."""
        folder = pathlib.PurePosixPath(path).parent
        candidates = []
        for base in (folder, pathlib.PurePosixPath("firmware"), pathlib.PurePosixPath(".")):
            parts = []
            for part in (base / name).parts:
                if part == ".." and parts:
                    parts.pop()
                else:
                    parts.append(part)
            candidates.append("/".join(parts))
        for candidate in candidates:
            if (self.root / candidate).is_file():
                return candidate
        for candidate in reversed(candidates):
            if "/" in name and room_of(candidate) not in (None, "firmware", "host_sim"):
                return candidate
        return None

    def check_includes(self, path, text):
        room = room_of(path)
        if room not in MAY_INCLUDE:
            return
        for match in INCLUDE.finditer(without_comments(text, keep_text=True)):
            line = line_of(text, match.start())
            spelled = re.fullmatch(r"\"(.+)\"|<(.+)>", match.group(1))
            if match.group(1) == "LAGLESS_BOARD_FILE" and path == "hal/board.h":
                continue  # the one file that the build chooses
            if not spelled:
                self.breach(path, line, "include", f"include of a macro ({match.group(1)}) hides what it includes")
                continue
            name = spelled.group(1) or spelled.group(2)
            target = self.resolve(path, name)
            if target is None:
                if spelled.group(2) and room.split("/")[0] in ("firmware", "hal") and name not in TARGET_HEADERS:
                    self.breach(path, line, "include", f"{room} must not include <{name}>: not for the target")
                continue
            target_room = room_of(target)
            if target == CHOICE and room.startswith("firmware/") and room not in CHOOSING:
                self.breach(path, line, "include", f"{room} must not include {target}: only {' and '.join(CHOOSING)} may")
                continue
            if target_room == room or target in MAY_INCLUDE[room] or target_room in MAY_INCLUDE[room]:
                continue
            self.breach(path, line, "include", f"{room} must not include {target}")

    # ---- Words ------------------------------------------------------------------------------------------------------

    def check_words(self, path, text):
        code = without_comments(text, keep_text=False)
        for match in WORD.finditer(code):
            word = match.group()
            if word in FORBIDDEN:
                self.breach(path, line_of(code, match.start()), "word", f"`{word}`: {FORBIDDEN[word]}")
            elif INEXACT.fullmatch(word) and re.match(r"\s*\(", code[match.end():]):
                # A call, not a member or a declaration of our own.
                if not re.search(r"(?:\.|->)\s*$", code[: match.start()]):
                    self.breach(path, line_of(code, match.start()), "word", f"`{word}`: libm; use firmware/math")
        for match in FLOAT_WITHOUT_F.finditer(code):
            self.breach(path, line_of(code, match.start()), "word", f"`{match.group()}`: double literal, needs an f")

    # ---- Recursion --------------------------------------------------------------------------------------------------

    def calls_of(self, path, text):
        """Functions that a source defines: name -> (path, line, words followed by a bracket in the body, last line)."""
        code = re.sub(r"^[ \t]*#(?:\\\n|[^\n])*", lambda m: re.sub(r"[^\n]", " ", m.group()),
                      without_comments(text, keep_text=False), flags=re.MULTILINE)
        functions = {}
        depth, start, head = 0, 0, 0
        for match in re.finditer(r"[{};]", code):
            sign = match.group()
            if sign == "{":
                if depth == 0:
                    start = match.end()
                depth += 1
            elif sign == "}":
                depth -= 1
                if depth == 0:
                    named = re.search(r"(\w+)\s*\([^{}]*\)\s*$", code[head: start - 1])
                    if named:
                        line = line_of(code, head + named.start())
                        body = code[start: match.start()]
                        functions[named.group(1)] = (path, line, set(re.findall(r"\b([A-Za-z_]\w*)\s*\(", body)),
                                                     line_of(code, match.start()))
                    head = match.end()
            elif depth == 0:
                head = match.end()
        return functions

    def check_recursion(self, sources):
        # Static functions of two files may share a name: a file's own wins, then a unique public one.
        by_file = {path: self.calls_of(path, text) for path, text in sources.items() if path.endswith(".c")}
        everywhere = {}
        for path, functions in by_file.items():
            for name in functions:
                everywhere.setdefault(name, []).append(path)

        def edges(node):
            path, name = node
            for called in sorted(by_file[path][name][2]):
                if called in by_file[path]:
                    yield path, called
                elif called in everywhere and len(everywhere[called]) == 1:
                    yield everywhere[called][0], called

        for ring in rings([(path, name) for path, functions in by_file.items() for name in functions], edges):
            path, line, *_ = by_file[ring[0][0]][ring[0][1]]
            self.breach(path, line, "recursion", " -> ".join(name for _, name in ring))

    # ---- Structs, circles of includes -------------------------------------------------------------------------------

    def check_structs(self, path, text):
        code = without_comments(text, keep_text=False)
        for match in STRUCT.finditer(code):
            count = fields_of(code, match.end() - 1)
            if count > FIELDS:
                self.breach(path, line_of(code, match.start()), "struct",
                            f"has {count} fields; {FIELDS} at most: give each task or room a struct of its own in it")
        for match in SLOT.finditer(code):
            self.breach(path, line_of(code, match.start()), "slot", f"{match.group()}: a task does its steps in their order")

    def check_circles(self, sources):
        def edges(path):
            for match in INCLUDE.finditer(without_comments(sources[path], keep_text=True)):
                target = self.resolve(path, match.group(1).strip('"<>'))
                if target in sources:
                    yield target

        for ring in rings(sorted(sources), edges):
            self.breach(ring[0], 1, "circle", " -> ".join(ring) + ": these include each other")

    # ---- Machine paths ----------------------------------------------------------------------------------------------

    def check_inner_parts(self, path, text):
        if path.startswith(INNER_PARTS_OF):
            return
        code = without_comments(text, keep_text=False)
        for match in INNER_PARTS.finditer(code):
            self.breach(path, line_of(code, match.start()), "parts",
                        f"`{match.group()}` reaches into the estimator; what is known of it is in its estimate_t")

    def check_lengths(self, path, text):
        most = FILE_LINES.get(path, ANY_FILE_LINES)
        lines = text.count("\n")
        if lines > most and not TABLES.fullmatch(path):
            self.breach(path, most + 1, "length", f"a file of {lines} lines; {most} at most, but for tables")
        for name, (_, line, _, end) in self.calls_of(path, text).items():
            if end - line + 1 > FUNCTION_LINES:
                self.breach(path, line, "length", f"{name} has {end - line + 1} lines; {FUNCTION_LINES} at most")

    def check_machine_paths(self, path, text):
        for match in MACHINE_PATH.finditer(text):
            line = line_of(text, match.start())
            self.breach(path, line, "machine", "a path of one machine: " + text.splitlines()[line - 1].strip())

    # ---- Documents --------------------------------------------------------------------------------------------------

    def check_documents(self, path, text, files, names, sections):
        """files: of the project; names: without their folders; sections: of docs/theory.md."""
        for match in DOCUMENT.finditer(text) if ".md" in text else ():
            word = re.sub(r"^(?:\.{0,2}/)+", "", match.group())
            if word not in (files if "/" in word else names):
                self.breach(path, line_of(text, match.start()), "document", f"{word} is no file of the project")
        if path.endswith(".md"):
            return
        for match in OUTSIDE.finditer(text):
            self.breach(path, line_of(text, match.start()), "document",
                        f"`{match.group()}`: cites what is not in the project; docs/theory.md, a manual's number, or the reason")
        for match in CITED_SECTION.finditer(text):
            if match.group(1) not in sections:
                self.breach(path, line_of(text, match.start()), "document", f"docs/theory.md has no section {match.group(1)}")

    def check_sources(self):
        target_sources = {}
        files = project_files(self.root)
        names = {name.rpartition("/")[2] for name in files}
        theory = self.root / "docs/theory.md"
        sections = set(re.findall(r"^## (\d+)\.", theory.read_text(), re.MULTILINE)) if theory.is_file() else set()
        for path in files:
            data = (self.root / path).read_bytes()
            if b"\0" in data:
                continue
            text = data.decode("utf-8", errors="replace")
            self.check_machine_paths(path, text)
            self.check_documents(path, text, files, names, sections)
            if pathlib.PurePosixPath(path).suffix not in C_ENDINGS:
                continue
            self.check_includes(path, text)
            if path.startswith(("firmware/", "hal/", "host_sim/")):
                self.check_inner_parts(path, text)
            if path.startswith(("firmware/", "hal/")):
                self.check_words(path, text)
                self.check_lengths(path, text)
                target_sources[path] = text
            if path.startswith("firmware/"):
                self.check_structs(path, text)
        self.check_recursion(target_sources)
        self.check_circles({path: text for path, text in target_sources.items() if path.startswith("firmware/")})
        return len(target_sources)

    # ---- Symbols ----------------------------------------------------------------------------------------------------

    def check_symbols(self, archives, nm):
        symbols = {room: read_symbols(archive, nm) for room, archive in archives.items()}
        defined = {room: {s.name for s in found if s.defined} for room, found in symbols.items()}
        for room, found in symbols.items():
            rules = LIBRARIES[room]
            archive = pathlib.PurePath(archives[room]).name
            for s in found:
                where, line = s.source(self.root) or (f"{archive}({s.member})", 0)
                if s.defined:
                    if room in STRICT_LIBRARIES and s.writable and not re.fullmatch(rules["data"] or r"(?!)", s.name):
                        self.breach(where, line, "symbol", f"{room} must own no writable data: {s.name} in {s.section}")
                    continue
                if s.name in defined[room] or s.name in MEMORY or s.name in COMPILER:
                    continue
                if INEXACT.fullmatch(s.name):
                    self.breach(where, line, "symbol", f"{room} must not need {s.name}: libm, not exactly rounded")
                elif room in STRICT_LIBRARIES:
                    allowed = any(s.name in defined.get(other, ()) for other in rules["uses"])
                    if not allowed and not re.fullmatch(rules["extern"], s.name):
                        self.breach(where, line, "symbol", f"{room} must not need {s.name}")


class Symbol:
    def __init__(self, member, name, kind, section, place):
        self.member, self.name, self.section, self.place = member, name, section, place
        self.defined = kind not in "Uw"
        # By section: constant tables of pointers (.data.rel.ro) are relocated once and then read-only.
        self.writable = (
            section.startswith((".data", ".bss", ".tbss", ".tdata", ".sdata", ".sbss", "*COM*", "COMMON"))
            and not section.startswith(".data.rel.ro")
        ) or kind == "C"

    def source(self, root):
        """File and line where the symbol is defined or first needed, if the debug information tells."""
        if not self.place:
            return None
        path, _, line = self.place.rpartition(":")
        if not line.isdigit():
            return None
        try:
            path = pathlib.Path(path).resolve().relative_to(root.resolve()).as_posix()
        except ValueError:
            pass
        return path, int(line)


def read_symbols(archive, nm):
    """Every symbol of every object in an archive, from `nm --format=sysv --line-numbers`:
    name | value | class | type | size | line | section <tab> file:line"""
    run = subprocess.run([nm, "--format=sysv", "--line-numbers", str(archive)], stdout=subprocess.PIPE,
                         stderr=subprocess.PIPE, check=False, text=True)
    if run.returncode != 0:
        sys.exit(f"check_layers: {nm} cannot read {archive}: {run.stderr.strip()}")
    found, member = [], "?"
    for row in run.stdout.splitlines():
        head = re.match(r"(?:Undefined s|S)ymbols from .*\[(.+)\]:$", row)
        if head:
            member = head.group(1)
            continue
        columns = row.split("|")
        if len(columns) != 7 or columns[0].strip() == "Name":
            continue
        section, _, place = columns[6].partition("\t")
        found.append(Symbol(member, columns[0].strip(), columns[2].strip(), section.strip(), place.strip()))
    if not found:
        sys.exit(f"check_layers: {archive} shows no symbols")
    return found


def main(arguments=None):
    parser = argparse.ArgumentParser(description="Checks the layer rules of the project.")
    parser.add_argument("--root", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parents[2])
    parser.add_argument("--nm", default="nm")
    parser.add_argument("--library", action="append", default=[], metavar="ROOM=ARCHIVE")
    options = parser.parse_args(arguments)

    archives = {}
    for pair in options.library:
        room, equals, archive = pair.partition("=")
        if not equals or room not in LIBRARIES:
            parser.error(f"--library {pair}: expected ROOM=ARCHIVE with a room of {', '.join(LIBRARIES)}")
        archives[room] = archive

    checker = Checker(options.root)
    count = checker.check_sources()
    if count == 0:
        sys.exit(f"check_layers: no sources in {options.root}/firmware and hal")
    checker.check_symbols(archives, options.nm)
    for path, line, rule, text in sorted(set(checker.breaches)):
        print(f"{path}:{line}: {rule}: {text}")
    if checker.breaches:
        print(f"check_layers: {len(set(checker.breaches))} breaches", file=sys.stderr)
        return 1
    print(f"check_layers: {count} sources of firmware and hal and {len(archives)} libraries keep the rules")
    return 0


if __name__ == "__main__":
    sys.exit(main())
