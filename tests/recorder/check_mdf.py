#!/usr/bin/env python3
"""Checks that an MDF file and the CSV file of the same recording have the same content, bit for bit.

usage: check_mdf.py own FOLDER              the recordings of recorder_samples, by the reader below
       check_mdf.py asammdf LAGLESS FOLDER  every shipped scenario, recorded into FOLDER, by asammdf

Both compare kinds, bits, units, texts, names of values, and the file's comment. Python 3.9. Ends with 77 (skipped) where
asammdf is missing."""
import json
import pathlib
import shutil
import struct
import subprocess
import sys
import xml.etree.ElementTree

from recordings import expect, plain_nan, read_csv, words_of

SKIPPED = 77
XML = "{http://www.asam.net/mdf/v4}"
KINDS = {0: "uint32", 2: "int32", 4: "single"}
# Octets of a block's data after its links, by the standard; those of CC depend on the number of its values.
DATA = {"HD": 32, "FH": 16, "DG": 8, "CG": 32, "CN": 72}


class Own:
    """Reads the blocks of the standard by their offsets."""

    def __init__(self, octets):
        self.octets = octets
        self.seen = {}  # address of a block -> its end
        expect(octets[:24] == b"MDF     4.10    lagless\0", f"identification {octets[:24]}")
        expect(struct.unpack_from("<H", octets, 28)[0] == 410, "version")
        expect(octets[24:28] + octets[30:64] == bytes(38), "identification: what is reserved is not 0")

    def block(self, at, name):
        """The links and the data of a block."""
        expect(at % 8 == 0 and self.octets[at:at + 8] == b"##" + name.encode() + bytes(4), f"no {name} block at {at}")
        length, links = struct.unpack_from("<QQ", self.octets, at + 8)
        expect(at + length <= len(self.octets), f"{name} at {at} reaches beyond the file")
        data = self.octets[at + 24 + 8 * links:at + length]
        expect(name not in DATA or len(data) == DATA[name], f"{name}: {len(data)} octets of data")
        self.seen[at] = at + length
        return struct.unpack_from(f"<{links}Q", self.octets, at + 24), data

    def text(self, at, name="TX"):
        links, data = self.block(at, name)
        text = data.rstrip(b"\0")
        expect(links == () and 1 <= len(data) - len(text) <= 8, f"{name} at {at}: its end")
        return text.decode("utf-8")

    def names(self, at):
        """The texts of the values 0, 1, ... in a conversion from value to text."""
        links, data = self.block(at, "CC")
        kind, _, flags, references, values = struct.unpack_from("<BBHHH", data)
        expect((kind, flags) == (7, 0) and references == values + 1 == len(links) - 4 and links[-1] == 0, "conversion")
        expect(struct.unpack_from(f"<{values}d", data, 24) == tuple(range(values)) and len(data) == 24 + 8 * values, "values")
        return [self.text(link) for link in links[4:-1]]

    def channels(self, at, size):
        while at != 0:
            (at, composition, name, source, conversion, _, unit, comment), data = self.block(at, "CN")
            kind, sync, form, bit, octet, bits = struct.unpack_from("<BBBBII", data)
            expect((composition, source, bit) == (0, 0, 0) and data[12:] == bytes(60), "channel: what is not used is not 0")
            expect(octet + bits // 8 <= size, "channel beyond its record")
            yield {"name": self.text(name), "unit": self.text(unit), "text": self.text(comment) if comment else "",
                   "names": self.names(conversion) if conversion else None, "kind": (kind, sync, form, bits), "octet": octet}

    def read(self):
        links, data = self.block(64, "HD")
        expect(data == bytes(32), "the head has a time of its own")
        group, history, *rest, comment = links
        expect(rest == [0, 0, 0], "links of the head")
        (after, said), data = self.block(history, "FH")
        expect(after == 0 and data == bytes(16), "history")
        xml.etree.ElementTree.fromstring(self.text(said, "MD"))
        (after, channels, samples, _), data = self.block(group, "DG")
        expect(after == 0 and data == bytes(8), "one group without record numbers")
        (after, first, name, *_), data = self.block(channels, "CG")
        number, count, flags, _, _, size, invalid = struct.unpack("<QQHHIII", data)
        expect((after, number, flags, invalid) == (0, 0, 0, 0), "group of channels")
        self.text(name)
        (), records = self.block(samples, "DT")
        expect(len(records) == count * size, f"{len(records)} octets of {count} records of {size}")
        columns = {}
        for channel in self.channels(first, size):
            master = channel["kind"] == (2, 1, 4, 64)
            expect(master or channel["kind"] in [(0, 0, form, 32) for form in KINDS], f"{channel['name']}: {channel['kind']}")
            word = struct.Struct("<Q" if master else "<I")
            words = [word.unpack_from(records, n * size + channel["octet"])[0] for n in range(count)]
            columns[channel["name"]] = {**channel, "kind": "double" if master else KINDS[channel["kind"][2]], "words": words}
        comment = self.text(comment, "MD")
        ends = {64, *self.seen.values()}
        expect(ends - {len(self.octets)} == set(self.seen), "a gap between two blocks")
        return columns, comment


def read_own(path):
    return Own(path.read_bytes()).read()


def read_asammdf(path):
    import asammdf
    file = asammdf.MDF(path)
    expect(file.version == "4.10", f"{path}: version {file.version}")
    kinds = {"float64": ("double", "<u8"), "float32": ("single", "<u4"), "int32": ("int32", "<u4"), "uint32": ("uint32", "<u4")}
    columns = {}
    for number, channel in enumerate(file.groups[0].channels):
        raw = file.get(group=0, index=number, raw=True)
        kind, word = kinds[str(raw.samples.dtype)]
        names = None
        if channel.conversion is not None:
            count = channel.conversion.val_param_nr
            names = [channel.conversion.referenced_blocks[f"text_{n}"].decode() for n in range(count)]
            shown = [text.decode() for text in file.get(group=0, index=number).samples.tolist()]
            expect(all(text == names[value] for text, value in zip(shown, raw.samples.tolist()) if 0 <= value < count),
                   f"{path}: texts of {channel.name}")
        columns[channel.name] = {"unit": raw.unit, "text": raw.comment, "names": names, "kind": kind,
                                 "words": raw.samples.copy().view(word).tolist()}
        expect(channel.channel_type == 2 or (raw.timestamps.view("<u8") == file.get_master(0).view("<u8")).all(), "time")
    comment = file.header.comment.replace("<HDcomment>", f'<HDcomment xmlns="{XML[1:-1]}">')  # asammdf removes the namespace
    file.close()
    return columns, comment


def entries(tree):
    return {entry.get("name"): (entry.text or "") for entry in tree.findall(XML + "e")}


def notes_of(path):
    return [line[2:] for line in path.read_text(encoding="utf-8").splitlines() if line.startswith(("# event ", "# verdict "))]


def check(path, read):
    """Compares a file with its CSV; returns how many values were compared."""
    keys, text, columns = read_csv(path)
    found, comment = read(path.with_suffix(".mf4"))
    expect(list(found) == list(columns), f"{path.name}: channels {list(found)}")
    for name, (unit, cells) in columns.items():
        column = found[name]
        words = plain_nan(column["words"]) if column["kind"] == "single" else column["words"]
        expected = words_of(cells, column["kind"])
        expect(column["unit"] == unit, f"{path.name}: unit of {name}: {column['unit']}")
        expect(name == "time" or column["text"] != "", f"{path.name}: {name} has no text")
        names = "|".join(column["names"]) if column["names"] else None
        expect(names == keys.get(f"choices {name}"), f"{path.name}: names of {name}: {names}")
        expect(len(words) == len(cells), f"{path.name}: {name} has {len(words)} samples")
        for n, (a, b) in enumerate(zip(words, expected)):
            expect(a == b, f"{path.name}: {name}[{n}] is {a:#x} in MDF, {cells[n]} = {b:#x} in CSV")
    head = xml.etree.ElementTree.fromstring(comment)
    properties = head.find(XML + "common_properties")
    trees = {tree.get("name"): tree for tree in properties.findall(XML + "tree")}
    expect(head.find(XML + "TX").text == keys["title"], f"{path.name}: title {comment}")
    said = entries(properties)
    for key in ("program", "commit", "tables", "scenario", "seed", "every", "ended"):
        expect(said[key] == keys[key], f"{path.name}: {key} is {said[key]}")
    expect(said["period"] + " s" == keys["period"], f"{path.name}: period is {said['period']}")
    lines = [line.replace("\\", "\\\\") for line in said["text"].splitlines()]
    # asammdf keeps neither the indentation of a property's text nor its unit.
    same = lines == text if read is read_own else [line.strip() for line in lines] == [line.strip() for line in text]
    expect(same, f"{path.name}: text of the scenario")
    settings = {entry.get("name"): f"{entry.text} {entry.get('unit', '')}".strip() for entry in trees["settings"]}
    written = {k[6:]: v if read is read_own else v.split(" ")[0] for k, v in keys.items() if k.startswith("value ")}
    expect(settings == written and settings, f"{path.name}: settings")
    expect(said["notes"].splitlines() == notes_of(path), f"{path.name}: notes {said['notes']}")
    return len(columns) * len(columns["time"][1])


def own(folder):
    paths = sorted(pathlib.Path(folder).glob("*.csv"))
    expect(len(paths) >= 4, f"{folder} holds {len(paths)} recordings")
    return paths, read_own


def shipped(lagless, folder):
    """Records each scenario with the signals that it selects, and one scenario with as many signals as fit."""
    try:
        import asammdf  # noqa: F401
    except ImportError:
        print("SKIPPED: asammdf is not installed")
        sys.exit(SKIPPED)
    folder = pathlib.Path(folder)
    shutil.rmtree(folder, ignore_errors=True)
    listed = json.loads(subprocess.run([lagless, "signals", "--json"], capture_output=True, check=True).stdout)["rows"]
    names = [f"{row['table']}.{row['name']}" for row in listed][:128]
    every = {"cold_start": ["--record", ",".join(names)]}
    scenarios = sorted(json.loads(subprocess.run([lagless, "scenarios", "--json"], capture_output=True, check=True).stdout)["scenarios"],
                       key=lambda row: row["name"])
    for row in scenarios:
        run = [lagless, "run", row["name"], "--quiet", "--format", "csv,mdf", "--every", "25", "--out", folder,
               *every.get(row["name"], [])]
        done = subprocess.run([str(word) for word in run], capture_output=True, text=True, check=False)
        expect(done.returncode == 0, f"{row['name']}: {done.stderr}")
    paths = sorted(path for path in folder.glob("*.csv") if not path.stem.endswith("_fault"))
    expect(len(paths) == len(scenarios) >= 20, f"{len(paths)} recordings of {len(scenarios)} scenarios")
    return paths, read_asammdf


def main():
    reader = sys.argv[1]
    paths, read = {"own": own, "asammdf": shipped}[reader](*sys.argv[2:])
    values = sum(check(path, read) for path in paths)
    print(json.dumps({"reader": reader, "files": len(paths), "values": values, "different_bits": 0}))


main()
