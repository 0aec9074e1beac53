#!/usr/bin/env python3
"""Commissions a motor from the page of `lagless scope` in a headless Chromium. A step is stopped, and its measured values are kept; then
all steps of another drive run, with their questions, their results and the file.

usage: test_commission_page.py LAGLESS FOLDER    screenshots are written to FOLDER

Exit codes: 0 done, 1 a check failed, 2 wrong use, 77 skipped (chromium, chromedriver or uPlot is missing)."""
import pathlib
import re
import sys
import tomllib

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "report"), str(HERE), str(HERE.parent)]
from test_browser import Fault, console_is_clean, expect, page_fits  # noqa: E402
from test_page import Bench, main  # noqa: E402

MOTOR = """schema = 1
title = "a motor without an encoder on a free shaft"
[run]
duration = "60 min"
[params]
position_source = "sensorless"
%s
[plant]
inertia = 0.003
friction_coulomb = "0.1 N m"
"""
TRUTH = {"R": 0.95, "L_d": 12.5, "L_q": 12.5, "psi_f": 183.0, "J": 3.0}  # parameters of the plant in the units of the page


class Page(Bench):
    """A drive, in real time or as fast as possible, a scope, and a browser."""

    def __init__(self, lagless, folder, work, *options):
        self.lagless, self.folder, self.processes, self.browser = lagless, folder, [], None
        self.scenario = work / "motor.toml"
        self.scenario.write_text(MOTOR % ("command_timeout = 0" if options else ""), encoding="utf-8")
        self.drive, line = self.start("serve", str(self.scenario), "--port", "0", "--quiet", *options)
        self.scope, line = self.start("scope", f"tcp://{line.split()[-1]}", "--http", "0", "--no-browser")
        self.url = line.split()[-1]

    def opens(self):
        self.browser.size(1400, 1000)
        self.browser.do("url", {"url": self.url})
        self.wait("document.body.dataset.link === 'up' && document.body.dataset.state === 'ready'", "the link")
        self.wait("document.getElementById('plate_speed').value", "the plate of the parameters")

    def fills(self):
        for name, text in (("pairs", "4"), ("current", "5"), ("speed", "1500")):
            self.write(f"#plate_{name}", text)
        if not self.run("return document.getElementById('plate_free').checked"):
            self.click("#plate_free")

    def data(self):
        return self.run("return scope.state.commission")

    def begins(self):
        self.run("document.getElementById('commission').scrollIntoView()")
        self.click("#commission_begin")
        self.wait("scope.state.commission.running", "the begin", 60)

    # ---- checks ----

    def a_plate_that_is_no_plate_is_refused(self):
        self.opens()
        self.fills()
        self.write("#plate_pairs", "2.5")
        self.click("#commission_begin")
        self.wait("/whole pole pairs/.test(document.getElementById('commission_said').textContent)", "the refusal")

    def in_the_inductance_step(self, action, what, seconds):
        """Does `action` within the script that detects the running step: on a slow machine the step could end between two scripts."""
        self.wait("(scope.state.commission.running && scope.state.commission.values.length > 0"
                  " && scope.state.commission.steps[scope.state.commission.step].name === 'inductance'"
                  f" && ({action}, true))", what, seconds)

    def a_step_says_what_it_does_and_takes_no_other_request(self):
        self.fills()
        self.begins()
        self.wait("/ At most [0-9]+ s are left/.test(document.getElementById('commission_now').innerText)", "what is done to the motor")
        answer = self.run("return fetch('set', {method: 'POST', body: 'speed_request 10', headers: {'X-Lagless': '1'}}).then(a => a.json())")
        expect(answer["text"], "commissioning is in progress; STOP ends it", "another request")
        self.shoot("commission_works")

    def stop_opens_the_bridge_in_a_step_and_keeps_what_was_measured(self):
        self.in_the_inductance_step("window.at_the_stop = document.getElementById('commission_now').innerText,"
                                    " document.getElementById('stop').click()", "R", 120)
        self.wait("scope.state.commission.done", "the end")
        expect(self.data()["reason"], "stopped_by_user", "the reason")
        self.wait("document.body.dataset.state === 'ready'", "the open bridge")
        if not re.search(r"constant current.* At most 1?[0-9] s are left", self.run("return window.at_the_stop")):
            raise Fault(f"what is done to the motor: {self.run('return window.at_the_stop')}")
        expect([each["name"] for each in self.data()["values"]][0], "R", "what is kept")
        expect(self.run("return document.querySelector('#commission_steps .failed').textContent"), "inductance", "the step that ended")

    def escape_does_the_same_and_earlier_results_are_taken(self):
        self.click("#plate_resume")
        self.begins()
        self.in_the_inductance_step("window.taken = scope.state.commission.steps[2].ended, document.activeElement.blur(),"
                                    " document.body.dispatchEvent(new KeyboardEvent('keydown', {key: 'Escape', bubbles: true}))",
                                    "the step after those that are known", 60)
        self.wait("scope.state.commission.done", "the end")
        expect(self.data()["reason"], "stopped_by_user", "the reason")
        expect(self.run("return window.taken"), True, "the wiring is known from the earlier begin")

    def all_steps_measure_the_motor(self):
        self.opens()
        # A drive that runs as fast as possible would wait for a page that draws its samples.
        self.run("return fetch('signals', {method: 'POST', body: '0', headers: {'X-Lagless': '1'}}).then(a => a.json())")
        self.fills()
        self.begins()
        for question, answer in (("direction", "as_said"), ("turn", "one")):
            self.wait(f"scope.state.commission.question === '{question}'", question, 200)
            self.wait("!document.getElementById('commission_question').hidden", "the question")
            if question == "turn":
                self.shoot("commission_question")
            self.click(f"#commission_question button[value={answer}]")
        self.wait("scope.state.commission.done", "the end", 200)
        data = self.data()
        expect((data["reason"], data["known"], data["turns"]), (None, True, 1), f"the end, {data['what']}")
        found = {each["name"]: each["value"] for each in data["values"]}
        for name, true in TRUTH.items():
            if abs(found[name] / true - 1) > 0.03:
                raise Fault(f"{name}: {found[name]}; the plant has {true}")
        self.wait("/^Commissioned in [0-9]+ s/.test(document.getElementById('commission_said').textContent)", "what is said")
        expect(self.run("return scope.named.has('motor_flux_linkage') && Math.abs(scope.value('motor_flux_linkage') / 0.183 - 1) < 0.02"), True,
               "the active parameters")

    def the_file_is_one_of_a_motor(self):
        text = self.run("return scope.state.commission.file")
        motor = tomllib.loads(text)
        expect(motor["pole_pairs"], 4, "of the plate")
        expect(self.run("return document.getElementById('commission_file').download"), "motor.toml", "its name")

    def it_fits_every_width_and_the_dark(self):
        for name, width, scheme in (("wide", 1400, "light"), ("dark", 1400, "dark"), ("narrow", 390, "light"), ("narrow_dark", 390, "dark")):
            self.browser.size(width, 1000)
            self.browser.cdp("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
            self.run("document.getElementById('commission').scrollIntoView()")
            page_fits(self.browser)
            self.shoot(f"commission_{name}")
        console_is_clean(self.browser)

    STOPS = (a_plate_that_is_no_plate_is_refused, a_step_says_what_it_does_and_takes_no_other_request,
             stop_opens_the_bridge_in_a_step_and_keeps_what_was_measured, escape_does_the_same_and_earlier_results_are_taken)
    WHOLE = (all_steps_measure_the_motor, the_file_is_one_of_a_motor, it_fits_every_width_and_the_dark)


if __name__ == "__main__":
    sys.exit(main(__doc__, [(lambda folder, work: Page(sys.argv[1], folder, work), Page.STOPS),
                            (lambda folder, work: Page(sys.argv[1], folder, work, "--free"), Page.WHOLE)],
                  "MAP * ~NOTFOUND, EXCLUDE 127.0.0.1"))
