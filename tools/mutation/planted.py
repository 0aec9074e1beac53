"""Links a program of a Ninja build with changed sources: they are compiled as in the build, and linked before the objects that they
replace."""
import pathlib
import shlex
import subprocess


def words_of(build, target):
    """The command line that makes this target, without its launcher."""
    listed = subprocess.run(["ninja", "-C", build, "-t", "commands", target], capture_output=True, text=True, check=True)
    line = [line for line in listed.stdout.splitlines() if line.strip()][-1]
    words = shlex.split(line.split("&&")[1] if "&&" in line else line)
    return words[next((n + 1 for n, word in enumerate(words) if pathlib.PurePath(word).name == "ccache"), 0):]


def compile_firmware(build, compiled, source, output, headers=None):
    """`source` as the build compiles firmware/`compiled`, with the headers of another folder before those of the tree."""
    library, = (name for name in ("lagless_core", "lagless_firmware") if (build / f"firmware/CMakeFiles/{name}.dir/{compiled}.o").exists())
    words = words_of(build, f"firmware/CMakeFiles/{library}.dir/{compiled}.o")
    words[words.index("-o") + 1] = str(output)
    words[words.index("-c") + 1] = str(source)
    words.remove("-MD")
    for flag in ("-MT", "-MF"):
        del words[words.index(flag):words.index(flag) + 2]
    words[1:1] = [f"-I{headers}"] if headers else []
    subprocess.run([*(word for word in words if word != "-Werror"), "-fno-lto"], cwd=build, check=True)


def link(build, program, objects, output):
    """Links the program of the build with these objects before its own. Without link-time optimisation this takes a second instead of a
    minute; the program computes the same bits."""
    words = words_of(build, program)
    words[words.index("-o") + 1] = str(output)
    first = next(n for n, word in enumerate(words) if word.endswith(".o"))
    words[first:first] = map(str, objects)
    subprocess.run([*words, "-fno-lto"], cwd=build, check=True)
    return output
