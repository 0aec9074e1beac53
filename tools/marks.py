"""The part of a document that a tool writes, between two comments which name the tool."""
import sys


def written(tool, document, text=None):
    """The text between the marks of `tool` in a document; with `text`, this text replaces it."""
    begin, end = f"<!-- begin: written by tools/{tool} --accept -->\n", f"<!-- end: tools/{tool} -->\n"
    head, _, rest = document.read_text(encoding="utf-8").partition(begin)
    shown, mark, tail = rest.partition(end)
    if not mark:
        sys.exit(f"tools/{tool}: {document.name} has no marks for the result: {begin.strip()} ... {end.strip()}")
    if text is not None:
        document.write_text(head + begin + text + end + tail, encoding="utf-8")
    return shown
