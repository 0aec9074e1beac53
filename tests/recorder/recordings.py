"""Common code of the checks of recordings: the CSV file, whose texts define the bits that every other format must have. Python 3.9."""
import struct
import sys


def expect(condition, text):
    if not condition:
        sys.exit(f"FAILED: {text}")


def read_csv(path):
    """The comments by their key, and the columns as {name: (unit, texts)}."""
    keys, text, names, columns = {}, [], None, []
    for line in path.read_text(encoding="utf-8").splitlines():
        if line.startswith("# "):
            key, _, value = line[2:].partition(": ")
            if key == "text":
                text.append(value)
            else:
                keys[key] = value
        elif names is None:
            names = [cell.rstrip("]").split("[") for cell in line.split(",")]
            columns = [[] for _ in names]
        else:
            cells = line.split(",")
            assert len(cells) == len(names), line
            for column, cell in zip(columns, cells):
                column.append(cell)
    return keys, text, {name: (unit, column) for (name, unit), column in zip(names, columns)}


def words_of(cells, kind):
    """The bit patterns that the texts represent."""
    if kind == "double":
        return [struct.unpack("<Q", struct.pack("<d", float(c)))[0] for c in cells]
    if kind == "single":
        # In text the NaN of a float has no sign and no payload.
        return [struct.unpack("<I", struct.pack("<f", float(c)))[0] for c in cells]
    return [int(c) & 0xFFFFFFFF for c in cells]


def plain_nan(words):
    """The words of floats, in which every NaN is the one that the text of CSV represents."""
    return [0x7FC00000 if w & 0x7FFFFFFF > 0x7F800000 else w for w in words]
