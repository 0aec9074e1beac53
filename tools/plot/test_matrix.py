#!/usr/bin/env python3
"""Tests of matrix.py."""
import html.parser
import json
import pathlib
import shutil
import tempfile
import unittest

from called import called


def cell(fault, manoeuvre, source, shaft, verdict, reaction="opens"):
    one = {"cell": f"{fault}/{manoeuvre}/{source}/{shaft}", "fault": fault, "manoeuvre": manoeuvre, "source": source,
           "shaft": shaft, "verdict": verdict}
    if verdict == "never":
        return {**one, "because": "there is no such thing"}
    return {**one, "red_by": "time" if verdict == "red" else "", "promised": {"text": "opens <soon>", "because": "of \"physics\""},
            "seen": {"text": f"{reaction} at once", "reaction": reaction}}


def matrix():
    return {"faults": [{"name": "stuck", "text": "a & b"}, {"name": "open", "text": "broken"}],
            "manoeuvres": [{"name": "off", "text": "off"}, {"name": "run", "text": "running"}],
            "cells": [cell("stuck", "off", "encoder", "h", "green", "rides"), cell("stuck", "run", "encoder", "l", "red"),
                      cell("stuck", "run", "sensorless", "h", "never"), cell("stuck", "run", "sensorless", "l", "green", "warns")]}


class Fields(html.parser.HTMLParser):
    """(class, letter) of the boxes of the table; ids; what is loaded from elsewhere."""

    def __init__(self, text):
        super().__init__()
        self.boxes, self.ids, self.links, self.outside, self.box = [], set(), set(), [], None
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        values = dict(attrs)
        kind = values.get("class", "")
        self.ids.add(values.get("id"))
        self.box = kind.split()[1] if kind.startswith("cell ") else None
        if "src" in values or tag == "link":
            self.outside.append(values)
        if values.get("href", "").startswith("#"):
            self.links.add(values["href"][1:])

    def handle_data(self, data):
        if self.box is not None:
            self.boxes.append((self.box, data.strip()))
            self.box = None


class Page(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="lagless_plot_"))
        self.addCleanup(shutil.rmtree, self.folder)
        self.json = self.folder / "matrix.json"
        self.html = self.folder / "out" / "matrix.html"

    def run_script(self, what, *arguments):
        self.json.write_text(what if isinstance(what, str) else json.dumps(what))
        return called("matrix", self.json, self.html, *arguments)

    def assert_refused(self, what, *words):
        run = self.run_script(what)
        self.assertEqual(run.returncode, 2, run.stderr)
        self.assertEqual(len(run.stderr.splitlines()), 1, run.stderr)
        for word in words:
            self.assertIn(word, run.stderr)
        self.assertFalse(self.html.exists())

    def written(self, what):
        run = self.run_script(what, "--title", "Matrix <1>")
        self.assertEqual(run.returncode, 0, run.stderr)
        return self.html.read_text(encoding="utf-8")

    def test_each_field_has_the_colour_of_its_verdict_and_the_letter_of_its_reaction(self):
        fields = Fields(self.written(matrix()))
        run = [("unseen", ""), ("red", "O"), ("never", "·"), ("green", "w")]
        self.assertEqual(fields.boxes, [("green", "r")] + 3 * [("unseen", "")] + run)

    def test_a_run_of_the_user_has_one_field_for_each_fault(self):
        cells = [cell("stuck", "scenario", "sensorless", None, "red"), cell("open", "scenario", "sensorless", None, "green", "warns")]
        for one in cells:
            del one["shaft"]
        text = self.written({**matrix(), "manoeuvres": [{"name": "scenario", "text": "<Load> step, faults at 2 s"}], "cells": cells})
        self.assertEqual(Fields(text).boxes, [("red", "O"), ("green", "w")])
        self.assertIn("this run: &lt;Load&gt; step, faults at 2 s.", text)
        self.assertIn("<td>scenario sensorless</td>", text)
        self.assertNotIn("four cells", text)
        self.assertNotIn("meaning of the manoeuvres", text)

    def test_a_number_of_zero_has_no_colour_and_stays_beside_its_word(self):
        held = [cell("stuck", "off", "encoder", "h", "green", "rides")]
        self.assertIn('<span class="total"><b>0</b> <span class="word zero">not as promised</span></span>', self.written({**matrix(), "cells": held}))

    def test_a_fault_whose_cells_cannot_occur_has_their_reasons_and_no_empty_table(self):
        text = self.written({**matrix(), "cells": [cell("stuck", "run", "sensorless", "h", "never")]})
        self.assertNotIn("<tbody></tbody>", text)
        self.assertIn("cells that cannot occur", text)
        self.assertIn("<b>·</b> is a cell that cannot occur", text)

    def test_a_fault_without_a_cell_has_no_row(self):
        self.assertNotIn('id="open"', self.written(matrix()))

    def test_every_link_of_the_page_leads_somewhere_and_nothing_is_loaded(self):
        fields = Fields(self.written(matrix()))
        self.assertTrue(fields.links)
        self.assertLessEqual(fields.links, fields.ids)
        self.assertEqual(fields.outside, [])

    def test_text_is_escaped(self):
        text = self.written(matrix())
        for part in ("Matrix &lt;1&gt;", "a &amp; b", "opens &lt;soon&gt;", "of &quot;physics&quot;"):
            self.assertIn(part, text)

    def test_a_drawn_share_reports_its_seed(self):
        self.assertIn("by seed 20260101", self.written({**matrix(), "share_percent": 10, "seed": 20260101}))

    def test_what_is_not_a_matrix_is_refused(self):
        self.assert_refused("", "matrix.json")
        self.assert_refused([], "faults")
        for key in ("faults", "manoeuvres", "cells"):
            self.assert_refused({name: value for name, value in matrix().items() if name != key}, key)

    def test_every_key_of_a_cell_is_needed(self):
        for number, one in enumerate(matrix()["cells"]):
            for key in one:
                broken = matrix()
                del broken["cells"][number][key]
                self.assert_refused(broken, f"cell {number + 1}", key)

    def test_a_cell_of_no_row_or_twice_is_refused(self):
        broken = matrix()
        broken["cells"][1]["manoeuvre"] = "fly"
        self.assert_refused(broken, "cell 2", "fly")
        broken = matrix()
        broken["cells"].append(broken["cells"][0])
        self.assert_refused(broken, "cell 5", "twice")

    def test_another_suffix_is_refused_and_a_page_that_cannot_be_written_ends_with_3(self):
        self.html = self.folder / "matrix.txt"
        self.assertEqual(self.run_script(matrix()).returncode, 2)
        (self.folder / "file").write_text("")
        self.html = self.folder / "file" / "matrix.html"
        run = self.run_script(matrix())
        self.assertEqual(run.returncode, 3)
        self.assertIn("matrix.py", run.stderr)


if __name__ == "__main__":
    unittest.main()
