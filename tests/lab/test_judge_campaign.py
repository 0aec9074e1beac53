"""Comparison of the counts of a campaign with the stored ones; and the stored file reads back as it was written."""
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import tool  # noqa: E402

judge, defects = tool.load("judge-campaign"), tool.load("seeded-defects")


class Document(unittest.TestCase):
    def test_the_document_lists_the_excuses_of_the_pinned_campaign(self):
        here = pathlib.Path(__file__).parent
        _, runs, _, found = judge.read(here / "campaign_not_yet.txt")
        text = (here.parents[1] / "docs" / "faults.md").read_text(encoding="utf-8")
        rows = text.split(f"| excuse | runs of {runs} |\n|---|---|\n")[1].split("\n\n")[0].splitlines()
        pinned = [f"| {name.removeprefix('excuse ')} | {count} |" for name, count in found.items() if name.startswith("excuse ")]
        self.assertEqual(sorted(pinned), sorted(rows))


class Counts(unittest.TestCase):
    def test_the_tails_are_those_of_the_hypergeometric_distribution(self):
        # One violation in both campaigns together: the probability that it is in the smaller one is 60 of 660 runs.
        more, fewer = judge.tails(1, 0, 60, 600)
        self.assertAlmostEqual(60 / 660, more)
        self.assertAlmostEqual(1.0, fewer)
        # The probability that two violations are both in the smaller campaign is 60 * 59 / (660 * 659).
        self.assertAlmostEqual(60 * 59 / (660 * 659), judge.tails(2, 0, 60, 600)[0])
        self.assertEqual((1.0, 1.0), judge.tails(0, 0, 60, 600))

    def test_equal_rates_are_as_pinned_and_a_defect_is_not(self):
        pinned = {"violation away": 20, "calm": 120, "alarm": 0}
        def wrong(runs, **found):
            names = {"away": "violation away", "calm": "calm", "alarm": "alarm"}
            return judge.compare_counts(judge.collections.Counter({names[k]: v for k, v in found.items()}), runs,
                                        judge.collections.Counter(pinned), 600)
        self.assertEqual([], wrong(60, away=2, calm=12))
        self.assertEqual([], wrong(60, away=6, calm=12))  # three times the rate is possible in so few runs
        self.assertEqual(1, len(wrong(60, away=20, calm=12)))
        self.assertIn("more than pinned: violation away: 20 of 60", wrong(60, away=20, calm=12)[0])
        self.assertEqual(1, len(wrong(60, away=2, calm=12, alarm=10)))
        self.assertIn("fewer than pinned: violation away: 0 of 2000", wrong(2000, away=0, calm=400)[0])

    def test_a_calm_drive_of_the_day_is_red_less_than_once_in_a_million(self):
        """For any rate a sound drive fails the daily judgement less than once in a million; for each pair of counts the worst of all stored
        counts is assumed."""
        for both in range(1, 60):
            chance = sum(judge.math.comb(both, m) * judge.math.comb(660 - both, 60 - m) / judge.math.comb(660, 60)
                         for m in range(both + 1) if min(judge.tails(m, both - m, 60, 600)) < judge.CHANCE)
            self.assertLess(chance, 2.0 * judge.CHANCE)

    def test_an_excuse_of_more_than_a_fiftieth_of_the_runs_is_reported(self):
        found = judge.collections.Counter({"excuse the interrupt begins late": 12, "alarm": 60})
        self.assertEqual([], judge.excuses_too_often(found, 600))
        self.assertEqual([], judge.excuses_beyond_chance(found, 600))
        found["excuse the interrupt begins late"] = 13
        self.assertEqual(1, len(judge.excuses_too_often(found, 600)))
        self.assertEqual([], judge.excuses_beyond_chance(found, 600))  # with a share of 2 % this occurs in nearly every second campaign
        found["excuse the interrupt begins late"] = 36               # binomial distribution of 600 runs and 0.02: probability 1.1e-8
        self.assertEqual(1, len(judge.excuses_beyond_chance(found, 600)))

    def test_the_file_reads_back_as_it_was_written(self):
        summary = {"violations": [{"run": 7, "invariant": "reach", "injected": "none"}], "alarms": 1, "calm": 99,
                   "excuses": {"the interrupt begins late": 4}}
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "pins.txt"
            judge.write(path, summary)
            seed, runs, rows, found = judge.read(path)
            self.assertEqual((judge.POOL_SEED, judge.POOL_RUNS, [(7, "reach", "none")]), (seed, runs, rows))
            self.assertEqual(judge.counts(summary), found)
            self.assertEqual([], judge.compare_pool(summary, rows, found))
            self.assertEqual(2, len(judge.compare_pool({**summary, "violations": [{**summary["violations"][0], "run": 8}]}, rows, found)))
            path.write_text("pool 1 600\nrun x\n", encoding="utf-8")
            with self.assertRaisesRegex(SystemExit, ":2: run x: accepted:"):
                judge.read(path)

class Defects(unittest.TestCase):
    def test_what_each_defect_replaces_is_in_the_firmware(self):
        self.assertEqual([], defects.missing(pathlib.Path(__file__).resolve().parents[2]))


unittest.main()
