#!/usr/bin/env python3
"""Makes docs/cold_start.png, README's picture of a cold start, by a run of the program.

usage: docs.py LAGLESS            runs the scenario and draws it
       docs.py LAGLESS --check only checks whether the picture shows the present results of the program: by the fingerprint of its content,
       which the file contains, and, with the matplotlib of requirements.txt, pixel by pixel

Ends with 0 done or up to date, 1 not up to date, 2 wrong use, 3 the picture cannot be made, 77 matplotlib is missing (--check).
Python 3.9 and matplotlib.
"""
import argparse
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENARIO = "cold_start"
ROWS = ("manoeuvre", "omega_m_ref", "omega_m", "true_omega_m", "true_torque", "load_torque", "i_d", "i_q", "true_i_a", "true_i_b", "true_i_c",
        "theta_err", "theta_hat_err")
SAME = 0.002  # [share of full brightness] largest average difference that another build of the same matplotlib may cause by rounding


def made(lagless, folder):
    """The picture of a fresh run."""
    subprocess.run([lagless, "run", SCENARIO, "--record", ",".join(ROWS), "--plot=png", "--quiet", "--out", folder], check=True)
    return folder / f"{SCENARIO}.png"


def fingerprint(png):
    """The text `Description` of a PNG; None if it has none."""
    octets = png.read_bytes()
    at = 8
    while at + 8 <= len(octets):
        size, kind = struct.unpack_from(">I4s", octets, at)
        if kind == b"tEXt":
            key, _, text = octets[at + 8:at + 8 + size].partition(b"\0")
            if key == b"Description":
                return text.decode("latin-1")
        at += 12 + size
    return None


def difference(a, b):
    """A description of the difference between two pictures; "" if there is none."""
    if not a.exists():
        return "is missing"
    if fingerprint(a) != fingerprint(b):
        return "shows other numbers than the program gives now"
    import matplotlib
    from matplotlib import image
    pinned = (ROOT / "tools" / "plot" / "requirements.txt").read_text(encoding="utf-8").strip().partition("==")[2]
    if matplotlib.__version__ == pinned:
        pixels = image.imread(a), image.imread(b)
        if pixels[0].shape != pixels[1].shape or abs(pixels[0] - pixels[1]).mean() > SAME:
            return "is drawn otherwise now"
    return ""


def main():
    parser = argparse.ArgumentParser(description="Makes the pictures of docs/ that show a run.")
    parser.add_argument("lagless")
    parser.add_argument("--check", action="store_true", help="write nothing")
    options = parser.parse_args()
    picture = ROOT / "docs" / f"{SCENARIO}.png"
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        print("docs.py: matplotlib is missing: run tools/setup demo")
        return 77 if options.check else 3
    folder = pathlib.Path(tempfile.mkdtemp(prefix="lagless_docs_"))
    try:
        fresh = made(options.lagless, folder)
        if options.check:
            what = difference(picture, fresh)
            if what:
                print(f"docs.py: {picture.relative_to(ROOT)} {what}: run tools/plot/docs.py {options.lagless}", file=sys.stderr)
            return 1 if what else 0
        shutil.copyfile(fresh, picture)
    except (OSError, subprocess.CalledProcessError) as error:
        print(f"docs.py: {error}", file=sys.stderr)
        return 3
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
