"""The messages of the scope about a drive that does not follow a request. The test uses no browser: a client receives the events as a page
does.

usage: test_scope_state.py LAGLESS FOLDER"""
import pathlib
import sys
import time
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent), str(HERE.parent / "scope")]
import stuck  # noqa: E402
import test_scope  # noqa: E402


class State(stuck.TestCase):
    setUp, start, wait = (getattr(test_scope.Scope, name) for name in
                                              ("setUp", "start", "wait"))

    def scenario_of(self, more):
        with open(self.scenario, "w") as file:
            file.write(test_scope.BENCH + more)

    def opened(self, more=""):
        self.scenario_of(more)
        self.drive, line = self.start("serve", self.scenario, "--quiet", "--port", "0")
        target = "tcp://" + line.split()[-1]
        self.process, line = self.start("scope", target, "--http", "0", "--no-browser")
        self.url = line.split()[-1]
        page = test_scope.Page(self.url)
        self.addCleanup(page.close)
        self.wait(lambda: page.hello and page.value("state") == page.value("state"), "values")
        return page

    def fault(self, page, name):
        numbers = {row["name"]: int(number) for number, row in page.hello["reasons"].items()}
        self.wait(lambda: page.value("fault_reason") == numbers[name], name)

    # ---- what the drive reports ----

    def test_a_start_on_a_latched_fault_is_refused_with_the_fault(self):
        page = self.opened('[[at]]\ntime = "0.3 s"\nplant.dc_voltage = "700 V"\n[[at]]\ntime = "0.5 s"\nplant.dc_voltage = "311 V"\n')
        self.fault(page, "dc_overvoltage")
        answer = page.ask("/set", "enable on")
        self.assertFalse(answer["ok"])
        self.assertRegex(answer["text"], "^refused: fault latched; reset first: .*DC link")
        self.wait(lambda: page.value("enable") == 0, "enable is off again")
        self.assertEqual(5, page.value("state"))

    def test_a_start_that_is_refused_says_why_and_nothing_starts_later(self):
        """The link voltage is too low at first, and is right again when the client has read the refusal."""
        page = self.opened('[plant]\ndc_voltage = "100 V"\n[[at]]\ntime = "15 s"\nplant.dc_voltage = "311 V"\n')
        self.wait(lambda: page.value("state") == 1 and page.value("u_dc") < 110, "ready")
        answer = page.ask("/set", "enable on")
        self.assertFalse(answer["ok"])
        self.assertRegex(answer["text"], "^refused: .*DC link")
        self.assertNotIn("latched", answer["text"])
        self.wait(lambda: page.value("u_dc") > 300, "the link", 60)
        time.sleep(0.5)
        self.assertEqual([0, 1], [page.value("enable"), page.value("state")])

    def test_a_stop_of_what_is_off_says_that_it_is_off(self):
        page = self.opened()
        self.wait(lambda: page.value("state") == 1, "ready")
        self.assertEqual({"ok": True, "text": "the bridge is off"}, page.ask("/stop"))
        page.ask("/set", "speed_request 300 r/min")
        self.assertTrue(page.ask("/set", "enable on")["ok"])
        self.wait(lambda: page.value("omega_m") > 10, "turning")
        self.assertEqual({"ok": True, "text": "it brakes to standstill, then the bridge is off"}, page.ask("/stop"))

    def test_a_stop_on_a_latched_fault_reports_it(self):
        page = self.opened('[[at]]\ntime = "0.3 s"\nplant.dc_voltage = "700 V"\n')
        self.fault(page, "dc_overvoltage")
        self.assertEqual({"ok": True, "text": "the bridge is off already: a fault is latched"}, page.ask("/stop"))

    def test_the_age_of_the_values_grows_while_the_link_is_lost(self):
        page = self.opened()
        self.wait(lambda: page.value("state") == 1 and page.state.get("link"), "ready")
        self.assertLess(page.state["age"], 1.0)
        self.drive.kill()
        self.wait(lambda: page.state["link"] is False, "the loss")
        self.wait(lambda: page.state["age"] > 2.0, "age")
        self.assertFalse(page.ask("/set", "enable on")["ok"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
