#!/usr/bin/env python3
"""Writes the C source that runs the tests of a C file: every function `static void test_...(void)` of the file, in the order of the
file, inside the same #if lines. A setUp() or a tearDown() that the file does not define is empty.

usage: unity_runner.py LIST   LIST has one line for each file to make. A file is written only if its text has changed:
       RUNNER tab test SOURCE          the program of one file
       RUNNER tab module NAME SOURCE   one module of a program: int run_NAME(void)
       RUNNER tab room NAME...         the program that runs all of its modules, or those that its arguments name"""
import os
import re
import sys

CALL = re.compile(r"static void (test_\w+)\(void\)$")
CONDITION = re.compile(r"#\s*(if|ifdef|ifndef|elif|else|endif)\b")
HOOK = r"^(?:static inline )?void {}\(void\)$"
ROOM = """#include <stdio.h>
#include <string.h>
#include <unity.h>

{declarations}
static const struct {{
    const char *name;
    int (*run)(void);
    void (*set_up)(void), (*tear_down)(void);
}} modules[] = {{
{rows}}};
static unsigned now;

void setUp(void)
{{
    modules[now].set_up();
}}

void tearDown(void)
{{
    modules[now].tear_down();
}}

int main(int argc, char **argv)
{{
    int failed = 0, ran = 0;
    for (now = 0; now < sizeof modules / sizeof modules[0]; now++) {{
        int wanted = argc < 2;
        for (int n = 1; n < argc; n++) {{
            wanted |= strcmp(argv[n], modules[now].name) == 0;
        }}
        if (wanted) {{
            failed += modules[now].run();
            ran++;
        }}
    }}
    if (ran < argc - 1 || ran == 0) {{
        fprintf(stderr, "%s: an argument is no module of this room\\n", argv[0]);
        return 1;
    }}
    return failed != 0;
}}"""


def runner(source, name):
    with open(source, encoding="utf-8") as file:
        text = file.read()
    hooks = ["setUp", "tearDown"]
    lines = []
    if name:
        lines += [f"#define {hook} {name}_{hook}" for hook in hooks] + [f"void {name}_{hook}(void);" for hook in hooks]
    lines.append(f'#include "{source}"')
    headers = "".join(open(header, encoding="utf-8").read() for header in re.findall(r'^#include "(tests/.*\.h)"', text, re.MULTILINE))
    lines += [f"void {hook}(void) {{}}" for hook in hooks if not re.search(HOOK.format(hook), text + headers, re.MULTILINE)]
    lines += [f"int run_{name}(void);", f"int run_{name}(void)"] if name else ["int main(void)"]
    lines += ["{", f'#line 1 "{source}"', "UNITY_BEGIN();"]
    for number, line in enumerate(text.split("\n"), 1):
        if CONDITION.match(line):
            lines.append(line.split("//")[0])
        call = CALL.match(line)
        if call:
            lines += [f"#line {number}", f"RUN_TEST({call[1]});"]
    return lines + ["return UNITY_END();", "}"]


def room(names):
    declarations = "".join(f"int run_{name}(void);\nvoid {name}_setUp(void);\nvoid {name}_tearDown(void);\n" for name in names)
    rows = "".join(f'    {{"{name}", run_{name}, {name}_setUp, {name}_tearDown}},\n' for name in names)
    return [ROOM.format(declarations=declarations, rows=rows)]


def made(kind, *words):
    lines = {"test": lambda source: runner(source, ""), "module": lambda name, source: runner(source, name),
             "room": lambda *names: room(names)}[kind](*words)
    return "\n".join(["/* Made by cmake/unity_runner.py. */", *lines, ""])


def main(listing):
    with open(listing, encoding="utf-8") as file:
        rows = [line.split("\t") for line in file.read().splitlines()]
    for path, words in rows:
        text = made(*words.split())
        if not os.path.exists(path) or open(path, encoding="utf-8").read() != text:
            with open(path, "w", encoding="utf-8") as file:
                file.write(text)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])
