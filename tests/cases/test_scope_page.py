#!/usr/bin/env python3
"""The page of `lagless scope` in a headless Chromium when the drive does not do what was asked, when the link is lost, and when a page
of another origin tries to get at it. usage: test_scope_page.py LAGLESS FOLDER    screenshots go to FOLDER

Ends with 0 done, 1 a check failed, 2 wrong use, 77 skipped: chromium, chromedriver or uPlot is missing."""
import http.server
import pathlib
import re
import sys
import threading
import time

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "report"), str(HERE.parent / "scope"), str(HERE.parent)]
from test_browser import SKIPPED, Fault, expect  # noqa: E402
from test_page import Bench, browser_programs, go_through  # noqa: E402

FAILS = """schema = 1
title = "a motor whose link rises for a while, and stays too high after the second time"
[run]
duration = "60 min"
[params]
position_source = "encoder"
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
QUIET = FAILS.split("[[at]]")[0]

# All that a page can send to another origin without asking it first, and streams, more than there may be.
FOREIGN = """
const [scope, drive] = arguments, report = [];
const plain = path => fetch(scope + path, {mode: 'no-cors', cache: 'no-store'}).then(a => report.push(path + ' ' + a.type), e => report.push(path + ' no'));
const waits = [];
window.sources = [];
for (let n = 0; n < 4; n++) {
    waits.push(plain('events'));
    const source = new EventSource(scope + 'events');
    source.onopen = () => report.push('OPEN');
    window.sources.push(source);
    const image = new Image();
    image.src = scope + 'events';
    const frame = document.createElement('iframe');
    frame.src = scope;
    document.body.append(frame);
}
for (const path of ['stop', 'set', 'order']) {
    waits.push(fetch(scope + path, {method: 'POST', mode: 'no-cors', body: path === 'set' ? 'enable off' : ''}).catch(() => 0));
    waits.push(fetch(scope + path, {method: 'POST', headers: {'X-Lagless': '1'}, body: 'enable off'}).then(() => report.push('POST'), () => 0));
}
const on = (0x11111111 ^ Math.imul(1000, 0x9E3779B1)) >>> 0;
const octets = [2, 0, 0, 0, 0xFF, 0, 8, 0, 1, 0, 0xF6, 0, 0, 2, 0xA0, 0x0F, 0, 0, 6, 0, 2, 0, 0xF0, 4, on & 255, on >>> 8 & 255, on >>> 16 & 255, on >>> 24];
waits.push(fetch(drive, {method: 'POST', mode: 'no-cors', body: new Uint8Array(octets)}).catch(() => 0));
await Promise.race([Promise.all(waits), new Promise(done => setTimeout(done, 5000))]);
await new Promise(done => setTimeout(done, 1500));
return report"""


class Page(Bench):
    """A drive of a scenario of this file's, a scope, a browser."""

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
        time.sleep(2)  # until the link is well again: the fault stays
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

    def a_page_of_another_origin_gets_nothing(self):
        """The operator's page is open in a window of its own and has the motor on; the foreign one even knows its address."""
        self.opens()
        self.wait("document.body.dataset.state === 'ready'", "ready")
        self.write("#speed_value", "300")
        self.click("#run")
        self.says("^switched on$", "good")
        operator = self.browser.call("GET", f"/session/{self.browser.session}/window")
        self.run("window.told = []; scope.taken = 0")
        server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Foreign)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        other = self.browser.call("POST", f"/session/{self.browser.session}/window/new", {"type": "tab"})["handle"]
        self.browser.do("window", {"handle": other})
        for host in ("127.0.0.1", "localhost"):  # the same site, and another one
            self.browser.do("url", {"url": f"http://{host}:{server.server_port}/"})
            told = self.run(f"return (async () => {{ {FOREIGN.replace('arguments', '[' + repr(self.url) + ', ' + repr(f'http://127.0.0.1:{self.port}/') + ']')} }})()")
            expect([each for each in told if each in ("OPEN", "POST")], [], f"what a page of {host} got")
        self.browser.do("window", {"handle": operator})
        server.shutdown()
        expect(self.run("return [document.body.dataset.link, document.body.dataset.state, scope.value('enable')]"),
               ["up", "operation_enabled", 1], "the operator's page")
        before = self.run("return scope.ring.total")
        self.wait(f"scope.ring.total > {before} + 1000", "samples go on")


class Foreign(http.server.BaseHTTPRequestHandler):
    def do_GET(self):
        body = b"<!DOCTYPE html><title>foreign</title><body>"
        self.send_response(200)
        self.send_header("Content-Type", "text/html")
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *ignored):
        pass


RUNS = ((FAILS, ("run_on_a_latched_fault_is_told_as_refused", "a_reset_that_works_is_told_as_done_and_run_as_on",
                 "a_lost_link_greys_values_with_their_age_and_disables_commands", "a_link_that_is_back_brings_fresh_values_and_commands")),
        (STAYS, ("a_reset_whose_cause_is_there_is_told_as_none",)),
        (QUIET, ("a_page_of_another_origin_gets_nothing",)))


def main():
    if len(sys.argv) != 3:
        print(__doc__)
        return 2
    programs = browser_programs()
    if not programs:
        print("skipped: chromium or chromedriver is missing")
        return SKIPPED
    folder = pathlib.Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    for scenario, checks in RUNS:
        code = go_through(lambda work: Page(sys.argv[1], folder, work, scenario), [(check, getattr(Page, check)) for check in checks], programs,
                          "MAP * ~NOTFOUND, EXCLUDE 127.0.0.1, EXCLUDE localhost")
        if code != 0:
            return code
    return 0


if __name__ == "__main__":
    sys.exit(main())
