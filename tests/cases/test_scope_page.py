#!/usr/bin/env python3
"""This tests what the page of `lagless scope` shows when the drive does not follow a request, and when the link is lost.
The page is loaded in a headless Chromium.
usage: test_scope_page.py LAGLESS FOLDER    screenshots go to FOLDER

Ends with 0 done, 1 a check failed, 2 wrong use, 77 skipped: chromium, chromedriver or uPlot is missing."""
import pathlib
import re
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "report"), str(HERE.parent / "scope"), str(HERE.parent)]
from test_browser import Fault, expect  # noqa: E402
from test_page import Bench, main  # noqa: E402

FAILS = """schema = 1
title = "a motor whose link rises for a while, and stays too high after the second time"
[run]
duration = "60 min"
[params]
position_source = "encoder"
overspeed_trip = 100
[rig]
fidelity = "averaged"
[[at]]
time = "2 s"
plant.dc_voltage = "700 V"
[[at]]
time = "3 s"
plant.dc_voltage = "311 V"
"""
STAYS = FAILS.replace('[[at]]\ntime = "3 s"\nplant.dc_voltage = "311 V"\n', "")
STANDS = FAILS.partition("[[at]]")[0].replace("encoder", "sensorless")

# The share of the panel of theta_e that has a quarter of the colour of the trace.
BAND = """
const {plot} = scope.panels().find(panel => panel.traces.some(trace => trace.row.name === 'theta_e'));
const {left, top, width, height} = plot.bbox;
const copy = new OffscreenCanvas(width, height).getContext('2d', {willReadFrequently: true});
copy.drawImage(plot.ctx.canvas, -left, -top);
const data = copy.getImageData(0, 0, width, height).data;
let found = 0;
for (let i = 3; i < data.length; i += 4) {
    found += data[i] > 55 && data[i] < 75;
}
return found / (width * height);"""


class Page(Bench):
    """A drive that runs a scenario of this file, a scope, and a browser."""

    def __init__(self, lagless, folder, work, scenario):
        self.lagless, self.folder, self.processes, self.browser = lagless, folder, [], None
        path = work / "scenario.toml"
        path.write_text(scenario, encoding="utf-8")
        self.scenario = path
        self.drive, line = self.start("serve", str(path), "--port", "0", "--quiet")
        self.port = line.rsplit(":", 1)[1].strip()
        self.scope, line = self.start("scope", f"tcp://127.0.0.1:{self.port}", "--http", "0", "--no-browser")
        self.url = line.split()[-1]

    def opens(self):
        self.browser.size(1400, 1000)
        self.browser.do("url", {"url": self.url})
        self.wait("document.body.dataset.link === 'up' && document.body.dataset.state", "the link")

    def said(self):
        return self.run("const p = document.getElementById('said'); return [p.textContent, p.className]")

    def says(self, pattern, kind):
        self.browser.wait(lambda: re.search(pattern, self.said()[0]) is not None, f"{pattern}, but {self.said()}", 20)
        expect(self.said()[1], f"said {kind}", "how it is said")

    # ---- checks ----

    def run_on_a_latched_fault_is_told_as_refused(self):
        self.opens()
        self.wait("document.body.dataset.state === 'fault'", "the fault")
        expect(self.run("return document.getElementById('speed_value').value"), "300", "half of overspeed_trip / 1.4, 341 r/min, rounded down")
        time.sleep(2)  # until the link voltage is in its range again; the fault remains
        self.write("#speed_value", "500")
        self.click("#run")
        self.says("^refused: fault latched; reset first", "bad")
        self.wait("scope.value('enable') === 0", "enable is off")
        expect(self.text("#state"), "fault", "the state")
        self.shoot("refused")

    def a_reset_that_works_is_told_as_done_and_run_as_on(self):
        self.click("#reset")
        self.says("^reset$", "good")
        self.wait("document.body.dataset.state === 'ready'", "ready")
        self.click("#run")
        self.says("^switched on$", "good")
        expect(self.run("return document.body.dataset.state"), "operation_enabled", "the state")

    def a_lost_link_greys_values_with_their_age_and_disables_commands(self):
        self.wait("scope.value('omega_m') > 20", "turning")
        self.drive.kill()
        self.wait("document.body.dataset.link === 'lost'", "the loss")
        self.wait("!document.getElementById('age').hidden && /^values from [1-9][0-9]* s ago$/.test(document.getElementById('age').textContent)", "the age")
        first = int(re.search("[0-9]+", self.text("#age"))[0])
        self.browser.wait(lambda: int(re.search("[0-9]+", self.text("#age"))[0]) >= first + 2, "an age that grows", 20)
        faint = self.run("return getComputedStyle(document.querySelector('#tile_omega_m b')).opacity")
        if not float(faint) < 1:
            raise Fault("the speed is not greyed")
        for selector in ("#run", "#off", "#speed button[type=submit]", "#speed_value", "#capture_arm", "[data-order=save]", ".param input"):
            expect(self.run("return document.querySelector(arguments[0]).disabled", selector), True, f"{selector} is disabled")
        expect(self.run("return document.getElementById('stop').disabled"), False, "STOP stays")
        self.shoot("stale")

    def a_link_that_is_back_brings_fresh_values_and_commands(self):
        self.drive, _ = self.start("serve", str(self.scenario), "--port", self.port, "--quiet")
        self.wait("document.body.dataset.link === 'up' && document.body.dataset.stale === 'false' && document.getElementById('age').hidden", "the link")
        for selector in ("#run", "#off", "#speed_value", "[data-order=save]", ".param input"):
            expect(self.run("return document.querySelector(arguments[0]).disabled", selector), False, f"{selector} is enabled")
        self.wait("getComputedStyle(document.querySelector('#tile_omega_m b')).opacity === '1'", "values in full")

    def a_reset_whose_cause_is_there_is_told_as_none(self):
        self.opens()
        self.wait("document.body.dataset.state === 'fault'", "the fault")
        self.wait("!document.getElementById('reset').hidden", "the button")
        self.click("#reset")
        self.says("^not reset: ", "bad")
        self.click("#stop")
        self.says("^the bridge is off already: a fault is latched$", "good")

    def the_angle_has_a_band_of_its_uncertainty(self):
        self.opens()
        for count, name in ((7, "theta_e"), (8, "theta_sigma")):
            self.write("#find_signal", name)
            self.run("[...document.querySelectorAll('#found button')].find(b => b.textContent.split(/\\s/)[0] === arguments[0]).click()", name)
            self.wait(f"scope.state.choice.signals.length === {count} && scope.ring.total > 1000", name)
        time.sleep(6)  # the window of the panel
        share = self.run(BAND)  # the rotor stands still, and noise makes all angles equally probable
        if not share > 0.8:
            raise Fault(f"the band covers {share:.2f} of the panel")
        self.shoot("band")
        self.click("#chosen li:last-child button")
        self.wait("scope.state.choice.signals.length === 7 && scope.ring.total > 1000", "theta_e alone")
        expect(self.run(BAND) < 0.1, True, "no band without theta_sigma")


CHECKS = ((FAILS, (Page.run_on_a_latched_fault_is_told_as_refused, Page.a_reset_that_works_is_told_as_done_and_run_as_on,
                   Page.a_lost_link_greys_values_with_their_age_and_disables_commands, Page.a_link_that_is_back_brings_fresh_values_and_commands)),
          (STAYS, (Page.a_reset_whose_cause_is_there_is_told_as_none,)),
          (STANDS, (Page.the_angle_has_a_band_of_its_uncertainty,)))


def made(scenario):
    return lambda folder, work: Page(sys.argv[1], folder, work, scenario)


if __name__ == "__main__":
    sys.exit(main(__doc__, [(made(scenario), checks) for scenario, checks in CHECKS],
                  "MAP * ~NOTFOUND, EXCLUDE 127.0.0.1, EXCLUDE localhost"))
