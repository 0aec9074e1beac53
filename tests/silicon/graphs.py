"""What tests of tools/check-linker and tools/check-image work out once and not for each of their cases: the compiler's call
graph of a source, its text without comments, the words of its command line. A case changes next to none of them."""
import functools
import types


def remember(linker):
    """In the module of tools/check-linker. No case changes a header."""
    known, graph_of = {}, linker.graph_of

    def remembered(root, source, compiler, lister, output):
        key = (source.name, (root / source.name).read_text(encoding="utf-8"))
        if key not in known:
            known[key] = graph_of(root, source, compiler, lister, output)
        return known[key]

    linker.graph_of = remembered
    linker.without_comments = functools.cache(linker.without_comments)
    linker.shlex = types.SimpleNamespace(split=functools.cache(linker.shlex.split))  # the module's own name: no one else's split
