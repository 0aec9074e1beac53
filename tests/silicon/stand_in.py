#!/usr/bin/env python3
"""A stand-in for TI's cl2000, ar2000 and hex2000, with which the build description is tested where these tools are not available. It
compiles nothing. It refuses options and inputs that the real tools would refuse according to TI's manuals, writes placeholders that are
marked as such, and appends each command line to the file that STAND_IN_LOG names. It is called by the name of the tool that it replaces."""
import json
import os
import pathlib
import re
import sys

TOOL = pathlib.Path(sys.argv[0]).name
PLACEHOLDER = "STAND-IN placeholder, holds no code: "

# The options by SPRU514 and SPRU513. The arguments after --run_linker belong to the linker.
COMPILER = (
    r"-v28|-ml|-mt|-g|-O[0-4]|--abi=(eabi|coffabi)|--float_support=fpu32|--ramfunc=on|--gen_func_subsections=on|--c99|"
    r"--relaxed_ansi|--display_error_number|--diag_warning=\d+|--diag_wrap=off|--include_path=.+|-D\w+(=\S*)?|"
    r"--compile_only|--(c|asm)_file=.+|--preproc_with_compile|--preproc_dependency=.+|--output_file=.+"
)
LINKER = (
    r"--output_file=.+|--map_file=.+|--rom_model|--entry_point=\w+|--stack_size=\w+|--heap_size=\w+|--warn_sections|"
    r"--reread_libs|--priority|--search_path=.+|--library=.+"
)
HEX = r"--intel|--memwidth=16|--romwidth=16|--outfile=.+"


FAST_RTS = "libraries/math/FPUfastRTS/c28/lib/rts2800_fpu32_fast_supplement_eabi.lib"


def install(folder):
    """Puts the stand-ins where TI's installers put the tools. Returns the environment with which a build finds them."""
    tools, ware = folder / "cgt", folder / "ware"
    for name in ("cl2000", "ar2000", "hex2000"):
        (tools / "bin").mkdir(parents=True, exist_ok=True)
        program = pathlib.Path(__file__).read_text(encoding="utf-8").partition("\n")[2]
        (tools / "bin" / name).write_text(f"#!{sys.executable} -ISB\n{program}", encoding="utf-8")
        (tools / "bin" / name).chmod(0o755)
    for library in (tools / "lib/rts2800_fpu32_eabi.lib", ware / FAST_RTS):
        library.parent.mkdir(parents=True)
        library.write_text(PLACEHOLDER + library.name + "\n", encoding="utf-8")
    own = {"C2000_CGT_ROOT": str(tools), "C2000WARE_ROOT": str(ware), "STAND_IN_LOG": str(folder / "log")}
    return {**os.environ, **own}


def fail(text):
    sys.exit(f"stand-in {TOOL}: {text}")


def options(words, known):
    """The words that are no options; ends with an error at an unknown option."""
    inputs = []
    for word in words:
        if not word.startswith("-"):
            inputs.append(word)
        elif not re.fullmatch(known, word):
            fail(f"unknown option {word}")
    for word in inputs:
        if not pathlib.Path(word).exists():
            fail(f"{word} does not exist")
    return inputs


def value(words, option):
    found = [word.partition("=")[2] for word in words if word.startswith(option + "=")]
    if len(found) != 1:
        fail(f"{option}= is there {len(found)} times")
    return found[0]


def compile_(words):
    inputs = options(words, COMPILER)
    sources = [word.partition("=")[2] for word in words if re.match(r"--(c|asm)_file=", word)]
    if [pathlib.Path(name).name for name in inputs] == ["CMakeCCompilerId.c"]:
        # The properties that CMake reads from a compiler at its first use.
        about = ("INFO:compiler[TI]", "INFO:compiler_version[00000022.00000006.00000001]", "INFO:arch[TMS320C28x]",
                 "INFO:standard_default[90]", PLACEHOLDER)
        pathlib.Path("CMakeCCompilerId.obj").write_text("\0".join(about), encoding="utf-8")
        return
    if inputs or len(sources) != 1 or "--compile_only" not in words:
        fail(f"one source with --compile_only was expected, not {inputs + sources}")
    output = pathlib.Path(value(words, "--output_file"))
    output.write_text(PLACEHOLDER + sources[0] + "\n", encoding="utf-8")
    if "--preproc_with_compile" in words:
        pathlib.Path(value(words, "--preproc_dependency")).write_text(f"{output}: {sources[0]}\n", encoding="utf-8")


def link(words):
    inputs = options(words, LINKER)
    if len([name for name in inputs if name.endswith(".cmd")]) != 1:
        fail("a program needs one linker command file")
    folders = [word.partition("=")[2] for word in words if word.startswith("--search_path=")]
    for library in (word.partition("=")[2] for word in words if word.startswith("--library=")):
        if not any(pathlib.Path(folder, library).exists() for folder in folders):
            fail(f"{library} is in no --search_path")
    pathlib.Path(value(words, "--output_file")).write_text(PLACEHOLDER + " ".join(inputs) + "\n", encoding="utf-8")
    text = PLACEHOLDER + "\nMEMORY CONFIGURATION\n\n  STAND_IN   00000000   00000000  00000000  00000000  RWIX\n"
    pathlib.Path(value(words, "--map_file")).write_text(text, encoding="utf-8")


def main():
    words = sys.argv[1:]
    with open(os.environ["STAND_IN_LOG"], "a", encoding="utf-8") as log:
        log.write(json.dumps({"tool": TOOL, "words": words}) + "\n")
    print(f"stand-in {TOOL}: records the command line, compiles nothing")
    if TOOL == "cl2000" and "--run_linker" in words:
        at = words.index("--run_linker")
        if options(words[:at], COMPILER):
            fail("inputs in front of --run_linker would be compiled")
        link(words[at + 1:])
    elif TOOL == "cl2000":
        compile_(words)
    elif TOOL == "ar2000":
        if len(words) < 3 or words[0] != "qr":
            fail(f"'qr ARCHIVE OBJECT...' was expected, not {words}")
        options(words[2:], r"(?!)")
        pathlib.Path(words[1]).write_text(PLACEHOLDER + " ".join(words[2:]) + "\n", encoding="utf-8")
    elif TOOL == "hex2000":
        (source,) = options(words, HEX)
        pathlib.Path(value(words, "--outfile")).write_text(PLACEHOLDER + source + "\n", encoding="utf-8")
    else:
        fail("stands for cl2000, ar2000 and hex2000 only")


if __name__ == "__main__":
    main()
