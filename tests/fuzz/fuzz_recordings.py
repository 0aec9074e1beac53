"""Damaged recordings, CSV and MAT, in `lagless plot` and `lagless compare`: each is drawn or refused in one
sentence that names the file, without a traceback. usage: fuzz_recordings.py LAGLESS FOLDER SEED SECONDS; ends with 77, skipped, without
numpy."""
import contextlib
import importlib.util
import io
import pathlib
import random
import shutil
import subprocess
import sys
import time
import warnings

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools/plot"))

if importlib.util.find_spec("numpy") is None:
    print("skipped: this Python has no numpy (tools/setup all installs it into build/venv)")
    sys.exit(77)

import look  # noqa: E402


def damaged(octets, other, dice):
    """The octets with one change: some changed, removed or doubled, the rest removed, or a piece of another file inserted."""
    octets = bytearray(octets)
    for _ in range(dice.choice((1, 1, 1, 2, 5))):
        at, some = dice.randrange(dice.choice((len(octets), len(octets), 4000)) or 1), dice.randrange(1, 60)
        kind = dice.randrange(7)
        if kind == 0:
            octets[at:at + 1] = bytes([dice.randrange(256)])
        elif kind == 1:
            octets[at:at + 1] = dice.choice([b"\n", b",", b" ", b"#", b"-", b"e", b"nan", b"inf", b"1e999", b"0", b":"])
        elif kind == 2:
            del octets[at:at + some]
        elif kind == 3:
            octets[at:at] = octets[at:at + some]
        elif kind == 4:
            begin = dice.randrange(len(other))
            octets[at:at] = other[begin:begin + some]
        elif kind == 5 and dice.randrange(3) == 0:
            del octets[at:]
        else:  # removes a line
            begin = octets.rfind(b"\n", 0, at) + 1
            end = octets.find(b"\n", at)
            del octets[begin:end + 1 if end >= 0 else len(octets)]
    return bytes(octets)


def run(arguments):
    """Runs look.py in this process; returns its exit code and output."""
    told = io.StringIO()
    argv, stdin = sys.argv, sys.stdin
    sys.argv, sys.stdin = ["look.py", *map(str, arguments)], io.StringIO("")
    try:
        with contextlib.redirect_stderr(told), contextlib.redirect_stdout(told), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return look.main(), told.getvalue()
    finally:
        sys.argv, sys.stdin = argv, stdin


def main():
    lagless, folder, seed, seconds = sys.argv[1], pathlib.Path(sys.argv[2]), int(sys.argv[3]), float(sys.argv[4])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    subprocess.run([lagless, "run", "stuck_sensor", "--set", "run.duration=1.1 s", "--every", "100", "--format", "csv,mat", "--quiet",
                    "--out", folder / "whole"], check=False)
    whole = [path.read_bytes() for path in sorted((folder / "whole").iterdir())]
    begun, rounds, drawn = time.monotonic(), 0, 0
    while rounds == 0 or time.monotonic() - begun < seconds:
        dice = random.Random(seed)
        n = dice.randrange(len(whole))
        path = folder / ("a.mat" if whole[n][:6] == b"MATLAB" else "a.csv")
        path.write_bytes(damaged(whole[n], dice.choice(whole), dice))
        command = ["plot", path, "--out", folder / "out"] if dice.randrange(3) else ["compare", path, path]
        try:
            code, told = run(command)
        except BaseException:
            print(f"seed {seed}: {path} is kept", file=sys.stderr)
            raise
        if code not in (0, 1) and (code != 2 or str(path) not in told or told.count("\n") != 1):
            print(f"seed {seed}: {path} is kept: exit {code}: {told}", file=sys.stderr)
            return 1
        rounds, drawn, seed = rounds + 1, drawn + (code != 2), dice.getrandbits(63)
    print(f"{rounds} rounds, {drawn} of them drawn or compared")
    return 0


if __name__ == "__main__":
    sys.exit(main())
