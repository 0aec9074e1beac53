"""The site that tools/site makes of README.md and docs/*.md. Pages and their order are the list in docs/README.md, which the
site has for its menu; a page that the list leaves out, and a link that leads nowhere, are errors.

tools/site lays the documents out as in the repository, README.md under the name of root_doc, and gives by the environment:
LAGLESS_ROOT, the repository; LAGLESS_MERMAID, a folder with mermaid.tiny.js, or nothing.
"""
import os
import pathlib
import re

from docutils import nodes
from sphinx import addnodes

ROOT = pathlib.Path(os.environ["LAGLESS_ROOT"])
MERMAID = os.environ.get("LAGLESS_MERMAID", "")
MENU = "docs/README"

project = "lagless"
html_title = "lagless"
extensions = ["myst_parser"]
source_suffix = {".md": "markdown"}
root_doc = "index"
suppress_warnings = ["myst.header"]  # a document may begin a part with ###
myst_heading_anchors = 4
highlight_language = "text"
smartquotes = False
html_theme = "furo"
html_static_path = ["site.css"] + ([MERMAID + "/mermaid.tiny.js"] if MERMAID else [])
html_css_files = ["site.css"]
html_use_index = html_copy_source = html_show_sphinx = html_show_copyright = False


def add_menu(app, docname, source):
    """The list of docs/README.md, a heading a part, becomes the menu of the first page."""
    if docname != root_doc:
        return
    parts = re.split(r"^## ", (ROOT / (MENU + ".md")).read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]
    for part in parts:
        pages = "\n".join("docs/" + name for name in re.findall(r"^- \[[^]]*\]\((\w+)\.md\)", part, re.MULTILINE))
        source[0] += f"\n\n```{{toctree}}\n:hidden:\n:caption: {part.splitlines()[0]}\n\n{pages}\n```\n"


def follow_links(app, doctree):
    """A link to README.md leads to the first page. One to another file of the repository becomes its text: on the code host it is
    a link, but the site has no sources. What is no file stays, to be told as a broken link."""
    for link in [link for link in doctree.findall(addnodes.pending_xref) if not link["refdomain"]]:
        path, _, anchor = link["reftarget"].partition("#")
        target = (ROOT / os.path.dirname(app.env.docname) / path).resolve()
        if target in (ROOT / "README.md", ROOT / (MENU + ".md")):
            link["refdomain"], link["reftarget"], link["reftargetid"] = "doc", root_doc, anchor
        elif path and target.exists() and target.suffix != ".md":
            link.replace_self(list(link.children))


def draw_diagrams(app, doctree):
    for block in list(doctree.findall(nodes.literal_block)):
        if block.get("language") == "mermaid":
            text = block.astext().replace("&", "&amp;").replace("<", "&lt;")
            block.replace_self(nodes.raw("", f'<pre class="mermaid">{text}</pre>', format="html"))


def load_mermaid(app, pagename, templatename, context, doctree):
    if MERMAID and 'class="mermaid"' in context.get("body", ""):
        app.add_js_file("mermaid.tiny.js")
        app.add_js_file(None, body="mermaid.initialize({startOnLoad: true, theme: 'neutral'});")


def setup(app):
    app.connect("source-read", add_menu)
    app.connect("doctree-read", follow_links)
    app.connect("doctree-read", draw_diagrams)
    app.connect("html-page-context", load_mermaid)
