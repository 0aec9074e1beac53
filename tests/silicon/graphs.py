"""Data that the tests of tools/check-linker and tools/check-image compute only once for all their cases: the compiler's call graph of each
source, made by chip_build.py; the text of each source without comments; the words of its command line. A case changes at most a few of
the sources, and no header."""
import functools
import json
import os
import sys
import types

import chip_build

sys.path.insert(0, str(chip_build.ROOT / "tests"))
import tool  # noqa: E402

FILE = "graphs.json"
CC = os.environ.get("CC", "gcc")


def make(folder):
    """Makes the graphs of all sources of the tree with the command lines of its build."""
    linker = tool.load("check-linker")
    known = []
    of_one = linker.graph_of

    def noted(root, source, compiler, lister, output):
        graph, (defined, needed) = of_one(root, source, compiler, lister, output)
        known.append((source.name, (root / source.name).read_text(encoding="utf-8"), graph, sorted(defined), sorted(needed)))
        return graph, (defined, needed)

    linker.graph_of = noted
    linker.Calls(chip_build.ROOT, linker.read_sources(chip_build.ROOT, folder / chip_build.BUILT / "compile_commands.json"), CC, "nm")
    (folder / FILE).write_text(json.dumps(known), encoding="utf-8")


def remember(linker):
    """Makes the module of tools/check-linker use these stored data."""
    rows = json.loads((chip_build.folder() / FILE).read_text(encoding="utf-8"))
    known = {(name, text): (graph, (set(defined), set(needed))) for name, text, graph, defined, needed in rows}
    graph_of, calls, source, together, sources = linker.graph_of, linker.Calls, linker.Source, {}, {}

    def one_source(name, options, text):  # one object for equal sources: all_calls() compares by identity
        key = (name, tuple(options), text)
        return sources.setdefault(key, source(name, options, text))

    def remembered(root, source, compiler, lister, output):
        key = (source.name, (root / source.name).read_text(encoding="utf-8"))
        if key not in known:
            known[key] = graph_of(root, source, compiler, lister, output)
        return known[key]

    def all_calls(root, sources, *more):
        key = tuple(map(id, sources.values()))
        if key not in together:
            together[key] = calls(root, sources, *more)
        return together[key]

    linker.graph_of, linker.Calls, linker.Source = remembered, all_calls, one_source
    linker.NODE, linker.EDGE = (types.SimpleNamespace(findall=functools.cache(each.findall)) for each in (linker.NODE, linker.EDGE))
    linker.without_comments = functools.cache(linker.without_comments)
    linker.shlex = types.SimpleNamespace(split=functools.cache(linker.shlex.split))  # in that module alone
