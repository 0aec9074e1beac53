#!/usr/bin/env python3
"""Draws recordings of `lagless run` and `lagless connect`, and compares them.

usage: look.py plot RECORDING [--out FOLDER] [--format html,png,svg] [--quiet | --tell]
       look.py compare A B [--out FOLDER] [--format html,png,svg]

plot: FOLDER/NAME.html (or .png, .svg), by default FOLDER is that of the recording; NAME_fault.csv in the same folder, the drive's
history of a fault, is a second set of panels. compare: prints the first difference; with --out, draws both in FOLDER/compare.html.
On stdin the program's tables as JSON: {"command", "rows": [{"table", "name", "kind", "text", "default", "choices"}], "reasons":
{number: {"name", "text", "remedy"}}, "faults": [name of each bit]}; without them faults have numbers.

Ends with 0 done or equal, 1 not equal, 2 wrong use or input, 3 matplotlib or numpy missing, or a file cannot be written.
Python 3.9 and matplotlib.
"""
import argparse
import json
import os
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))  # python -I does not add this folder to the path
import progress
import style
from table import InputError

VALUES_MAX = 12_000_000  # of a page, which opens too slowly with more samples
SUFFIXES = (".csv", ".mat")


def tables():
    """The tables on stdin; empty if stdin is a terminal."""
    if sys.stdin is None or sys.stdin.isatty():
        return {}
    try:
        return json.load(sys.stdin)
    except ValueError:
        return {}


class Look:
    """One command, with its name in messages and the files that it has written."""

    def __init__(self, options):
        self.options, self.tables = options, tables()
        self.name = f"lagless {self.tables['command']}" if "command" in self.tables else "look.py"
        self.written = []

    def say(self, text):
        progress.clear()
        print(f"{self.name}: {text}", file=sys.stderr)

    def tell(self):
        """Where the pictures are."""
        progress.end()
        for path in self.written:
            kind = "page: " if path.suffix == ".html" else "picture: "
            print(f"{kind}{path}", file=sys.stderr)

    def folder(self, standard):
        folder = self.options.out or standard
        folder.mkdir(parents=True, exist_ok=True)
        return folder

    def drawn(self, recording):
        import drive
        return drive.Drawn(recording, self.tables)

    def thinned(self, recording):
        """(recording, sentence): every n-th sample of a recording that is too large for a page."""
        import dataclasses
        count = len(recording.time) * (1 + len(recording.units))
        every = -(-count // VALUES_MAX)
        if every == 1:
            return recording, ""
        self.say(f"{recording.path}: the page has one sample in {every}, the recording all of them")
        columns = {name: values[::every] for name, values in recording.columns.items()}
        return dataclasses.replace(recording, columns=columns), f" The page has one sample in {every}."

    def save(self, folder, name, pages, title, html):
        """pages: [(suffix of the name, heading, Drawn, events)]; html(pictures) writes the page."""
        formats = self.options.format
        library = None
        if "html" in formats:
            import page
            library = page.uplot()
        pictures = {}
        if "png" in formats or "svg" in formats or ("html" in formats and not library):
            import drive_picture
            for suffix, heading, drawn, events in pages:
                wanted = [kind for kind in ("png", "svg") if kind in formats]
                pictures[suffix] = drive_picture.save(folder / f"{name}{suffix}", heading, drawn, events, wanted)
                self.written += [folder / f"{name}{suffix}.{kind}" for kind in wanted]
        if "html" in formats:
            self.written.insert(0, html({} if library else pictures))

    def section(self, name, heading, drawn, events, data, png):
        import drive_page
        import page
        layout = drawn.layout(name)
        return drive_page.plot_section(name, heading, events, [] if png else page.plots([layout], drawn.data), data, png)


HOW = ("Values on this page are rounded to 1/20000 of each trace's range or finer; the recording has all digits.")


def beside(recording):
    """NAME_fault.csv of NAME.csv or NAME.mat, if it is there."""
    path = recording.path.with_name(f"{recording.path.stem}_fault.csv")
    return path if path.is_file() else None


def fault_heading(recording, reasons):
    """The text about the fault of a history."""
    length = 1e3 * (recording.time[-1] - recording.time[0])
    return f"The last {length:.4g} ms up to {reasons[-1]}" if reasons else f"History of a fault, {length:.4g} ms"


def plot(look):
    import drive
    import recording as recordings
    options = look.options
    # of the progress of a long recording; reading takes most of the time
    whole = recordings.read(options.recordings[0], progress.part(0.0, 0.4))
    if len(whole.time) < 2:
        raise InputError(f"{whole.path}: 1 sample: a plot needs two or more")
    recording, thinned = look.thinned(whole)
    drawn = look.drawn(recording)
    progress.tell(0.5)
    events = drive.events(drawn)
    folder = look.folder(whole.path.parent)
    name = whole.path.stem
    title = whole.meta.get("title") or name
    if whole.meta.get("ended") == "fault":
        title = f"{title}: history of the fault"
    faults = [(event["time"], event["text"]) for event in events if event["kind"] == "fault"]
    pages = [("", title, drawn, events)]
    path = beside(whole) if whole.meta.get("ended") != "fault" else None
    if path:
        history = recordings.read(path)
        of_history = look.drawn(history)
        heading = fault_heading(history, [f"{text} at {when:.9g} s" for when, text in faults])
        pages.append(("_fault", heading, of_history, drive.events(of_history)))

    def html(pictures):
        import drive_page
        reasons = {f"fault {reason['name']}": reason for reason in look.tables.get("reasons", {}).values()}
        data = [whole.path] + ([path] if path else [])
        # A link works if the page is in the folder of the data.
        data = [each.name if each.resolve().parent == folder.resolve() else "" for each in data]
        names = ("run", "fault")
        headings = ("Recorded", pages[-1][1])
        sections = [look.section(names[n], headings[n], of, marks, data[n], pictures.get(suffix))
                    for n, (suffix, _, of, marks) in enumerate(pages)]
        sections += [drive_page.verdict_section(whole.notes), drive_page.settings_section(whole, drawn.rows), drive_page.text_section(whole)]
        alarms = [drive_page.verdict_line(whole.notes)]
        alarms += [drive_page.alarm(when, reasons[text]) for when, text in dict.fromkeys(faults) if text in reasons]
        return drive_page.write(folder / f"{name}.html", title, drive_page.escape(drive_page.about(whole)), sections, alarms,
                                HOW + thinned)
    look.save(folder, name, pages, title, html)
    if not options.quiet:
        look.tell()
    return 0


def compare(look):
    import compared
    return compared.run(look)


def main():
    parser = argparse.ArgumentParser(description="Draws recordings of lagless, and compares them.")
    commands = parser.add_subparsers(dest="command", required=True)
    for name, count in (("plot", 1), ("compare", 2)):
        command = commands.add_parser(name)
        command.add_argument("recordings", type=pathlib.Path, nargs=count)
        command.add_argument("--out", type=pathlib.Path)
        command.add_argument("--format", type=style.formats, default=["html"])
        command.add_argument("--quiet", action="store_true")
        command.add_argument("--tell", dest="quiet", action="store_false")
    look = Look(parser.parse_args())
    try:
        return {"plot": plot, "compare": compare}[look.options.command](look)
    except ImportError as error:
        if error.name and error.name.split(".")[0] in ("numpy", "matplotlib"):
            look.say(style.MISSING)
            return 3
        raise
    except InputError as error:
        look.say(error)
        return 2
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # Python does not try again at its end to write the rest of the output.
        look.say(f"{error.filename or 'the output'} cannot be written: {error.strerror or error}")
        return 3


if __name__ == "__main__":
    sys.exit(main())
