#!/usr/bin/env python3
"""Checks that a MAT file and the CSV file of the same recording have the same content, bit for bit.

usage: check_mat.py scipy|octave FOLDER

Reads every FOLDER/NAME.csv as text, NAME.mat by SciPy or GNU Octave, and compares kinds, bits and meta. Python 3.9. Ends
with 77 (skipped) where the reader is missing."""
import json
import pathlib
import shutil
import subprocess
import sys

from recordings import expect, plain_nan, read_csv, words_of

SKIPPED = 77

OCTAVE = r"""
names = argv();
for n = 1:numel(names)
  s = load(names{n});
  printf('file %s\n', names{n});
  f = fieldnames(s);
  for k = 1:numel(f)
    v = s.(f{k});
    if isstruct(v), continue; end
    if isa(v, 'double'), words = typecast(v(:).', 'uint64');
    elseif isempty(v), words = [];
    else words = typecast(v(:).', 'uint32'); end
    printf('variable %s %s %d %d\n', f{k}, class(v), rows(v), columns(v));
    printf('%lu\n', words);
  end
  m = s.meta;
  printf('meta seed %lu\n', m.seed);
  printf('meta title %s\n', m.title);
  printf('meta tables %s\n', m.tables);
  printf('meta resistance %.9g %s\n', m.values.motor_resistance, m.value_units.motor_resistance);
  printf('meta inertia %.9g %s\n', m.values.plant_inertia, m.value_units.plant_inertia);
  printf('meta unit %s\n', m.units.time);
end
"""


def read_scipy(paths):
    try:
        import scipy.io
    except ImportError:
        print("SKIPPED: SciPy is not installed")
        sys.exit(SKIPPED)
    kinds = {"float64": "double", "float32": "single", "int32": "int32", "uint32": "uint32"}
    for path in paths:
        file = scipy.io.loadmat(path, mat_dtype=False)
        variables = {}
        for name, value in file.items():
            if name.startswith("__") or name == "meta":
                continue
            word = "<u8" if value.dtype == "float64" else "<u4"
            variables[name] = (kinds[str(value.dtype)], value.shape, value.copy().view(word).ravel().tolist())
        meta = file["meta"][0, 0]

        def text(value):
            return str(value[0]) if value.size else ""

        yield variables, {
            "seed": str(int(meta["seed"][0, 0])),
            "title": text(meta["title"]),
            "tables": text(meta["tables"]),
            "commit": text(meta["commit"]),
            "scenario_text": text(meta["text"]),
            "notes": text(meta["notes"]),
            "choices": {n: text(meta["choices"][0, 0][n]) for n in (meta["choices"].dtype.names or ())},
            "units": {n: text(meta["units"][0, 0][n]) for n in meta["units"].dtype.names},
            "resistance": f"{float(meta['values'][0, 0]['motor_resistance'][0, 0]):.9g} "
                          + text(meta["value_units"][0, 0]["motor_resistance"]),
            "inertia": f"{float(meta['values'][0, 0]['plant_inertia'][0, 0]):.9g} "
                       + text(meta["value_units"][0, 0]["plant_inertia"]),
        }


def read_octave(paths):
    octave = shutil.which("octave-cli") or shutil.which("octave")
    if octave is None:
        print("SKIPPED: GNU Octave is not installed")
        sys.exit(SKIPPED)
    script = paths[0].parent / "check_mat.m"
    script.write_text(OCTAVE)
    run = subprocess.run([octave, "--no-gui", "--norc", "--quiet", str(script), *map(str, paths)], stdout=subprocess.PIPE,
                         stderr=subprocess.PIPE, check=False)
    expect(run.returncode == 0, f"{octave}: {run.stderr.decode('utf-8', errors='replace').strip()}")
    found, variables, meta = [], None, None
    for line in run.stdout.decode("utf-8", errors="replace").splitlines():
        if line.startswith("file "):
            variables, meta = {}, {}
            found.append((variables, meta))
        elif line.startswith("variable "):
            _, name, kind, rows, columns = line.split()
            variables[name] = (kind, (int(rows), int(columns)), [])
            current = variables[name][2]
        elif line.startswith("meta "):
            _, key, value = line.split(" ", 2)
            meta[key] = value
        elif line:
            current.append(int(line))
    return found


def main():
    reader, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    tables = sorted(p for p in folder.glob("*.csv"))
    expect(len(tables) >= 4, f"{folder} holds {len(tables)} recordings")
    mats = [p.with_suffix(".mat") for p in tables]
    values = 0
    for path, (variables, meta) in zip(tables, {"scipy": read_scipy, "octave": read_octave}[reader](mats)):
        keys, text, columns = read_csv(path)
        expect(set(variables) == {n.replace(".", "_") for n in columns}, f"{path.name}: variables {sorted(variables)}")
        for name, (unit, cells) in columns.items():
            kind, shape, words = variables[name.replace(".", "_")]
            expect(shape == (len(cells), 1), f"{path.name}: {name} is {shape}, not {(len(cells), 1)}")
            expected = words_of(cells, kind)
            if kind == "single":
                words = plain_nan(words)
            for n, (a, b) in enumerate(zip(words, expected)):
                expect(a == b, f"{path.name}: {name}[{n}] is {a:#x} in MAT, {cells[n]} = {b:#x} in CSV")
            expect(kind == {"time": "double", "state": "int32", "refusal": "int32", "fault_reason": "int32",
                            "period": "uint32", "encoder_count": "uint32", "sample_flags": "uint32"}.get(name, "single"),
                   f"{path.name}: {name} is {kind}")
            if "units" in meta:
                expect(meta["units"][name.replace(".", "_")] == unit, f"{path.name}: unit of {name}")
            values += len(cells)
        expect(meta["seed"] == keys["seed"] == "18446744073709551615", f"{path.name}: seed {meta['seed']}")
        expect(meta["tables"] == keys["tables"], f"{path.name}: tables {meta['tables']}")
        expect(meta["resistance"] == "0.949999988 ohm", f"{path.name}: {meta['resistance']}")  # 0.95 as float
        expect(meta["inertia"] == "0.00300000003 kg m^2", f"{path.name}: {meta['inertia']}")
        expect(keys["value plant.inertia"] == "0.003 kg m^2", f"{path.name}: {keys}")
        # Octave cannot read text beyond 8 bits.
        if reader == "scipy" or keys["title"].isascii():
            expect(meta["title"] == keys["title"], f"{path.name}: title {meta['title']}")
        if reader == "scipy":
            expect(meta["commit"] == keys["commit"].replace("\U0001d714", "\ufffd"), f"{path.name}: {meta['commit']}")
            expect(meta["scenario_text"].splitlines() == [t.replace("\\\\", "\\") for t in text], f"{path.name}: text")
            notes = "".join(f"{key}: {keys[key]}\n" for key in keys if key.startswith(("event ", "verdict ")))
            expect(meta["notes"] == notes and notes.count("\n") == 2, f"{path.name}: notes {meta['notes']}")
            expect(meta["choices"] == {k.split()[1]: v for k, v in keys.items() if k.startswith("choices ")},
                   f"{path.name}: choices {meta['choices']}")
    print(json.dumps({"reader": reader, "files": len(tables), "values": values, "different_bits": 0}))


main()
