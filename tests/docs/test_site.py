#!/usr/bin/env python3
"""tools/site on this tree: every document becomes a page, every target of a link exists, nothing is loaded from other sites, and tables
become tables. Small trees with one mistake each are reported with file and name.

usage: test_site.py [unittest options]

Ends with 77, skipped, where the generator is missing (tools/setup all puts it into build/venv).
"""
import html.parser
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
import urllib.parse

ROOT = pathlib.Path(__file__).resolve().parents[2]
TOOL = ROOT / "tools/site"
# Addresses in style sheets that a browser loads without a click.
STYLE_FETCHES = re.compile(r"(?:@import\s+|url\(\s*)['\"]?(?:https?:)?//[^)'\" ]*")
FETCHING = {"script": "src", "img": "src", "iframe": "src", "source": "src", "video": "src", "audio": "src", "object": "data"}


def made(root, out):
    return subprocess.run([TOOL, "--root", root, "--out", out], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)


class Page(html.parser.HTMLParser):
    """What a page names (tag, attribute, value), the anchors to which a link may lead, and the numbers of tables and diagrams."""

    def __init__(self, text):
        super().__init__()
        self.names, self.places, self.tables, self.diagrams = [], set(), 0, 0
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        attributes = dict(attrs)
        self.places.add(attributes.get("id"))
        self.tables += tag == "table"
        self.diagrams += tag == "pre" and attributes.get("class") == "mermaid"
        for name in ("href", FETCHING.get(tag)):
            if attributes.get(name):
                self.names.append((tag, name, attributes[name]))


class Site(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name).resolve() / "site"
        cls.done = made(ROOT, cls.folder)
        cls.pages = {path: Page(path.read_text(encoding="utf-8")) for path in cls.folder.rglob("*.html")}

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def test_it_is_made_without_a_warning(self):
        self.assertEqual(self.done.returncode, 0, self.done.stdout)
        self.assertRegex((ROOT / "README.md").read_text(encoding="utf-8"), r"`tools/site`[^.;]*`tools/setup` installs")

    def test_every_document_is_a_page_and_in_the_menu(self):
        documents = sorted(path.stem for path in (ROOT / "docs").glob("*.md") if path.name != "README.md")
        self.assertIn("theory", documents)
        menu = [name for _, _, name in self.pages[self.folder / "index.html"].names]
        for name in documents:
            self.assertIn(self.folder / f"docs/{name}.html", self.pages)
            self.assertIn(f"docs/{name}.html", menu)

    def test_what_pages_name_is_there(self):
        seen = 0
        for path, page in self.pages.items():
            for tag, _, name in page.names:
                url = urllib.parse.urlsplit(name)
                if url.scheme or url.netloc:
                    continue
                target = (path.parent / urllib.parse.unquote(url.path)).resolve() if url.path else path
                with self.subTest(page=path.name, name=name):
                    self.assertTrue(target.is_file())
                    if url.fragment and tag == "a" and target in self.pages and not (target == path and url.fragment == ""):
                        self.assertIn(urllib.parse.unquote(url.fragment), self.pages[target].places)
                seen += 1
        self.assertGreater(seen, 500)

    def test_nothing_is_fetched_from_elsewhere(self):
        for path, page in self.pages.items():
            for tag, attribute, name in page.names:
                if tag == "link" or attribute != "href":
                    self.assertFalse(re.match(r"(https?:)?//", name), f"{path.name}: {name}")
        sheets = list(self.folder.rglob("*.css"))
        self.assertTrue(sheets)
        for path in sheets:
            self.assertEqual(STYLE_FETCHES.findall(path.read_text(encoding="utf-8")), [], path.name)

    def test_tables_are_tables_and_diagrams_diagrams(self):
        """The page has the same number of tables and diagrams as the document, which are counted by the line below a table's heading row
        and by the fence."""
        for path, page in self.pages.items():
            source = ROOT / ("README.md" if path.name == "index.html" else f"docs/{path.stem}.md")
            if source.exists():
                text = source.read_text(encoding="utf-8")
                with self.subTest(document=source.name):
                    self.assertEqual(page.tables, len(re.findall(r"^\|(?: ?:?-+:? ?\|)+$", text, re.MULTILINE)))
                    self.assertEqual(page.diagrams, text.count("```mermaid"))


class Mistakes(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name).resolve()
        self.write("README.md", "# First\n\nA [document](docs/one" ".md#a-part), the [list](docs/README.md), a [source](src/a.c).\n")
        self.write("docs/README.md", "# Documents\n\n## Part\n\n- [One](one" ".md): the one\n")
        self.write("docs/one" ".md", "# One\n\n## A part\n\n[Back](../README.md), [there](../README.md#first), [source](../src/a.c).\n")
        self.write("src/a.c", "int a;\n")

    def write(self, name, text):
        (self.folder / "tree" / name).parent.mkdir(parents=True, exist_ok=True)
        (self.folder / "tree" / name).write_text(text, encoding="utf-8")

    def made(self):
        done = made(self.folder / "tree", self.folder / "site")
        return done.returncode, done.stdout

    def test_mistakes_are_reported_and_the_old_site_remains(self):
        self.write("docs/two" ".md", "# Two\n\n[No file](three" ".md), [no part](one" ".md#b-part), [no source](../src/b.c), [part](#c-part)\n")
        self.write("docs/README.md", "# Documents\n\n## Part\n\n- [One](one" ".md): the one\n- [None](none" ".md): not there\n")
        (self.folder / "site").mkdir()
        (self.folder / "site/searchindex.js").write_text("old", encoding="utf-8")
        status, told = self.made()
        self.assertEqual(status, 1, told)
        for name in ("three" ".md", "b-part", "../src/b.c", "c-part"):
            self.assertRegex(told, rf"docs/two\.md:3: WARNING: .*{re.escape(name)}")
        self.assertRegex(told, r"README\.md.*docs/none")
        self.assertRegex(told, r"docs/two\.md: WARNING: document isn't included in any toctree")
        self.assertEqual((self.folder / "site/searchindex.js").read_text(encoding="utf-8"), "old")


if __name__ == "__main__":
    if subprocess.run([TOOL, "--check"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False).returncode == 3:
        print("Sphinx is missing: tools/setup all installs it into build/venv")
        sys.exit(77)
    unittest.main()
