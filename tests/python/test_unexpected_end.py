"""The Python package by the rule of `lagless run`: a run that ends with a fault or a lasting refusal that no expectation names
has not passed. PYTHONPATH and LAGLESS_LIBRARY say which package; ends with 77, skipped, without numpy."""
import importlib.util
import sys
import unittest

if importlib.util.find_spec("numpy") is None:
    print("skipped: this Python has no numpy (tools/setup all installs it into build/venv)")
    sys.exit(77)

import lagless

RUN = {"title": "a link that sags", "run": {"duration": "1 s"}, "params": {"position_source": "encoder"},
       "requests": {"enable": "on", "speed_request": "300 r/min"}, "at": [{"time": "0.5 s", "plant.dc_voltage": "100 V"}],
       "expect": [{"signal": "true_omega_m", "minus": "omega_m_ref", "statistic": "peak", "from": "0.99 s", "at_most": "500 r/min"}]}
FAULT = {"signal": "fault_reason", "statistic": "last", "at_least": 23, "at_most": 23}


class UnexpectedEnd(unittest.TestCase):
    def test_a_fault_that_no_expectation_names_has_not_passed(self):
        result = lagless.run(RUN)
        self.assertFalse(result.passed)
        self.assertEqual("met", result.verdicts[0].judgement)
        self.assertEqual("fault dc_undervoltage at 0.5010 s, which no expectation names", result.unexpected_end)
        self.assertIn("FAILED      end of the run: fault dc_undervoltage", result.report())
        self.assertIn("1 of 1 expectations met", repr(result))

    def test_a_fault_that_one_names_has_passed(self):
        result = lagless.run({**RUN, "expect": [FAULT]})
        self.assertTrue(result.passed)
        self.assertIsNone(result.unexpected_end)

    def test_a_lasting_refusal_has_not_passed(self):
        result = lagless.run({**RUN, "at": [], "expect": [], "plant": {"dc_voltage": "150 V"}})
        self.assertFalse(result.passed)
        self.assertIn("refuses with dc_undervoltage", result.unexpected_end)


if __name__ == "__main__":
    unittest.main(verbosity=2)
