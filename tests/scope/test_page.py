#!/usr/bin/env python3
"""Operates the page of `lagless scope` in a headless Chromium as a user at a bench would. A motor of `lagless serve` is started, its
rotation is observed, it gets another gain, a load step triggers a capture, and it is stopped. Then the drive disappears and comes back.

usage: test_page.py LAGLESS FOLDER    screenshots are written to FOLDER

Exit codes: 0 done, 1 a check failed, 2 wrong use, 77 skipped (chromium, chromedriver or uPlot is missing). Python 3.9, standard library
only."""
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parent.parent / "report"), str(pathlib.Path(__file__).resolve().parent.parent)]
import stuck  # noqa: E402
from test_browser import RGB, SKIPPED, Browser, Fault, browser_programs, console_is_clean, expect, only_asked_for, page_fits  # noqa: E402

SCRIPTS_MAX = 0.5  # share of a processor with six signals; the other half is for the layout and painting of Chromium
RPM = 30 / 3.141592653589793
LEVEL = 3.0  # [A] between the currents for friction and for the load: 1.32 and 6.32 N m by 1.098 N m/A are 1.20 and 5.76 A
HEAD = """schema = 1
title = "a motor with an encoder that waits for a master; its load comes and goes"
[run]
duration = "60 min"
[params]
position_source = "encoder"
"""
STEP = """[[at]]
time = "%g s"
plant.load_torque = "%g N m"
"""

# Pixels in the colour of a trace, for each panel.
TRACES = RGB + """return scope.panels().map(({plot}) => {
    const colours = plot.series.slice(1).map((series, k) => rgb(series.stroke(plot, k + 1)));
    const {left, top, width, height} = plot.bbox;
    const copy = new OffscreenCanvas(width, height).getContext('2d', {willReadFrequently: true});
    copy.drawImage(plot.ctx.canvas, -left, -top);
    const data = copy.getImageData(0, 0, width, height).data;
    return colours.map(c => {
        let found = 0;
        for (let i = 0; i < data.length; i += 4) {
            found += data[i + 3] > 200 && [0, 1, 2].every(k => Math.abs(c[k] - data[i + k]) < 24);
        }
        return found;
    });
})"""

# The data of the drive's internal buffer that the page draws.
KEPT = """
const {kept} = scope.state, {picture} = kept, names = kept.signals.map(id => scope.rows.get(id).name);
const speed = picture.columns[names.indexOf('omega_m')], at = picture.zero - picture.begin;
const steps = new Set(Array.from(picture.stamps).slice(1).map((stamp, n) => stamp - picture.stamps[n]));
return {names, periods: picture.stamps.length, steps: [...steps], at, before: speed[at - 1], here: speed[at],
        first: speed[0], axis: [scope.panels()[0].plot.scales.x.min, scope.panels()[0].plot.scales.x.max]}"""

RECORD = """
const record = scope.trigger.record, source = scope.trigger.source;
if (!record) return null;
const at = record.stamps.findIndex(stamp => stamp >= record.zero);
const speed = record.columns[0];
return {begin: record.begin, end: record.end, zero: record.zero, first: record.stamps[0], last: record.stamps[record.stamps.length - 1],
        count: record.stamps.length, before: record.columns[source][at - 1], here: record.columns[source][at],
        speed_at_first: speed[0], speed_least: Math.min(...speed), held: scope.state.held}"""

# Gives the trigger a signal that was constant, falls slowly through the level, and rises again, with noise. Returns the sample at which a
# trigger for a rising edge fires, and that for a falling edge. No sample of the drive arrives meanwhile, because the script does not wait.
SLOW_EDGES = """
const {ring, trigger, state} = scope, kept = {...ring}, before = {...trigger}, held = state.held;
const fires = edge => {
    Object.assign(ring, {stamps: kept.stamps.map((_, k) => k), total: 0, last: -1, columns: [kept.stamps.map((_, k) =>
        Math.min(5, 1 + Math.abs(k - 800) / 100) + 0.055 * (k % 3 - 1))]});
    Object.assign(trigger, {mode: 'normal', source: 0, edge, level: 3});
    trigger.arm();
    ring.total = 1200;
    trigger.look(0);
    return trigger.at;
};
state.held = false;
const found = ['rise', 'fall'].map(fires);
Object.assign(ring, kept);
Object.assign(trigger, before);
state.held = held;
return found"""


# Fields of parameters that clip a number.
CLIPPED = """
return [...document.querySelectorAll('.param .entry input')].filter(each => each.offsetWidth).filter(each => {
    const before = each.value;
    each.value = '0.04591683';
    const clips = each.scrollWidth > each.clientWidth;
    each.value = before;
    return clips;
}).map(each => each.closest('.param').dataset.name)"""

# Old values with less contrast than WCAG 2.1 requires of large text, 3 : 1, on the card behind them.
FAINT = """
const light = parts => parts.slice(0, 3).map(p => p / 255).map(p => p <= 0.04045 ? p / 12.92 : ((p + 0.055) / 1.055) ** 2.4)
    .reduce((sum, p, k) => sum + [0.2126, 0.7152, 0.0722][k] * p, 0);
const parts = text => text.match(/[\\d.]+/g).map(Number);
return [...document.querySelectorAll('.tile b, .legend b')].filter(each => each.offsetWidth).map(each => {
    let opacity = 1;
    for (let up = each; up; up = up.parentElement) opacity *= getComputedStyle(up).opacity;
    const back = parts(getComputedStyle(each.closest('.card')).backgroundColor);
    const ink = parts(getComputedStyle(each).color).map((p, k) => p * opacity + back[k] * (1 - opacity));
    const [a, b] = [light(ink), light(back)];
    return (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
}).filter(ratio => ratio < 3)"""


class Bench:
    """A drive, a scope, a browser."""

    def __init__(self, lagless, folder, work):
        self.lagless, self.folder = lagless, folder
        self.scenario = work / "bench.toml"
        self.scenario.write_text(HEAD + "".join(STEP % (5 + k, 5 if k % 2 == 0 else 0) for k in range(200)), encoding="utf-8")
        self.processes = []
        self.drive, line = self.start("serve", str(self.scenario), "--port", "0", "--quiet")
        self.port = line.rsplit(":", 1)[1].strip()
        self.scope, line = self.start("scope", f"tcp://127.0.0.1:{self.port}", "--http", "0", "--no-browser")
        self.url = line.split()[-1]
        self.browser = None

    def start(self, *arguments):
        process = subprocess.Popen([self.lagless, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.processes.append(process)
        line = process.stdout.readline()
        if not line:
            raise Fault(f"lagless {arguments[0]}: {process.stderr.read()}")
        return process, line

    def close(self):
        for process in self.processes:
            if process.poll() is None:
                process.kill()
            process.communicate()

    # ---- the page ----

    def run(self, script, *arguments):
        return self.browser.run(script, *arguments)

    def wait(self, script, what, seconds=20.0):
        self.browser.wait(lambda: self.run("return " + script), what, seconds)

    def find(self, selector):
        return next(iter(self.browser.call("POST", f"/session/{self.browser.session}/element",
                                           {"using": "css selector", "value": selector}).values()))

    def click(self, selector):
        self.browser.do(f"element/{self.find(selector)}/click")

    def write(self, selector, text):
        element = self.find(selector)
        self.run("const e = document.querySelector(arguments[0]); e.focus(); e.select()", selector)
        self.browser.do(f"element/{element}/value", {"text": text})

    def pick(self, selector, text):
        self.run("const e = document.querySelector(arguments[0]);"
                 "e.value = [...e.options].find(o => o.textContent === arguments[1]).value;"
                 "e.dispatchEvent(new Event('change'))", selector, text)

    def text(self, selector):
        return self.run("return document.querySelector(arguments[0]).innerText", selector)

    def shoot(self, name):
        self.browser.screenshot(self.folder / f"{name}.png")

    # ---- the checks, in this order ----

    def opens_and_is_linked(self):
        self.browser.size(1400, 1000)
        self.browser.do("url", {"url": "about:blank"})
        for kind in ("performance", "browser"):  # discards the entries of the browser's start
            self.browser.records(kind)
        self.browser.do("url", {"url": self.url})
        self.wait("document.body.dataset.link === 'up' && document.body.dataset.state === 'ready'", "the link")
        expect(self.run("return scope.state.choice.signals.map(id => scope.rows.get(id).name)"),
               ["omega_m", "omega_m_ref", "i_q", "i_d", "u_q", "u_d"], "signals at first")
        expect(self.run("return document.getElementById('dither').hidden"), False, "the i_d that learns L is explained")
        expect(self.run("return [...document.querySelectorAll('.param input')].filter(i => i.scrollWidth > i.clientWidth)"
                        ".map(i => i.dataset.name)"), [], "fields that are too narrow")

    def starts_the_motor_and_sees_it_turn(self):
        self.write("#speed_value", "500")
        self.click("#run")
        self.wait("document.body.dataset.state === 'operation_enabled'", "the bridge")
        self.wait(f"Math.abs(scope.value('omega_m') * {RPM} - 500) < 10", "500 r/min")
        self.wait("Math.abs(parseFloat(document.querySelector('#tile_omega_m b').textContent) - 500) < 10", "the tile")
        time.sleep(2)  # fills the window of the panels
        for panel in self.run(TRACES):
            if min(panel) < 50:
                raise Fault(f"traces with too few pixels: {panel}")
        self.shoot("turning")

    def draws_within_its_share_of_a_processor(self):
        """If the scripts were too slow, they would fill the thread, since the next picture begins when the last one is done. The processor
        time depends neither on other work of the machine nor on how Chromium paints without a graphics processor."""
        self.browser.cdp("Performance.enable", timeDomain="threadTicks")
        before, begin = self.work(), time.monotonic()
        time.sleep(4)
        after, seconds = self.work(), time.monotonic() - begin
        pictures, share = after[0] - before[0], (after[1] - before[1]) / seconds
        print(f"pictures: {pictures / seconds:.1f} 1/s, scripts take {100 * share:.0f} % of a processor")
        if pictures < 4 or not 0 < share < SCRIPTS_MAX:
            raise Fault(f"{pictures} pictures in {seconds:.1f} s, scripts take {share:.2f} of a processor, at most {SCRIPTS_MAX}")

    def work(self):
        """The number of pictures drawn so far, and the processor seconds of the page's scripts."""
        metrics = self.browser.cdp("Performance.getMetrics")["metrics"]
        return (self.run("return scope.state.frames"),
                next(metric["value"] for metric in metrics if metric["name"] == "ScriptDuration"))

    def changes_a_gain(self):
        self.write("#find_param", "current_bandwidth")
        field = "input[data-name=current_bandwidth]"
        before = self.run("return scope.value('current_bandwidth')")
        self.write(field, "99999\n")
        self.wait("document.querySelector('.param[data-name=current_bandwidth] .error').textContent.includes('3000')", "the refusal")
        expect(self.run("return scope.value('current_bandwidth')"), before, "value after a refusal")
        self.write(field, "800\n")
        self.wait("!document.querySelector('#staged').hidden", "staging")
        self.shoot("staged")
        self.click("#apply")
        self.wait("document.querySelector('#staged').hidden && !scope.state.line.staged", "applying")
        self.wait("scope.value('current_bandwidth') === 800", "the value")
        expect(self.text("#param_said"), "active", "what was said")

    def chooses_signals(self):
        self.write("#find_signal", "u_dc")
        self.click("#found button")
        self.wait("scope.state.choice.signals.length === 7 && scope.ring.total > 1000", "seven signals")
        self.click("#chosen li:last-child button")
        self.wait("scope.state.choice.signals.length === 6 && scope.ring.total > 1000", "six signals")
        self.wait("!document.getElementById('dither').hidden", "the hint that explains the alternating i_d")

    def no_trigger_by_noise_on_a_slow_edge(self):
        """The level is crossed at 597 and 995: 1 + 2.03 - 0.055 < 3, and 1 + 1.95 + 0.055 > 3."""
        expect(self.run(SLOW_EDGES), [995, 597], "samples of the trigger for rising and falling edges")

    def triggers_on_a_load_step(self):
        self.pick("#window", "500 ms")
        self.pick("#mode", "single")
        self.pick("#source", "i_q")
        self.write("#level", f"{LEVEL}\n")
        self.wait("scope.trigger.level === 3 && scope.trigger.mode === 'single'", "the trigger")
        self.wait("scope.state.held", "a load step")
        time.sleep(0.3)
        record = self.run(RECORD)
        if not record["before"] < LEVEL <= record["here"]:
            raise Fault(f"no edge at the trigger: {record}")
        expect([record["zero"] - record["begin"], record["end"] - record["zero"]], [1250, 3750], "periods before and after")
        if record["first"] > record["begin"] or record["last"] < record["end"] or record["count"] < 5000:
            raise Fault(f"the record is not whole: {record}")
        if not record["speed_least"] < record["speed_at_first"] - 5:
            raise Fault(f"no dip: {record}")
        drawn = self.run("return [scope.panels()[0].plot.scales.x.min, scope.panels()[0].plot.scales.x.max]")
        expect([round(x, 6) for x in drawn], [-0.125, 0.375], "axis")

    def reads_cursors(self):
        over = self.run("return document.querySelectorAll('.u-over')[1]")
        self.browser.pointer(over, (-200, 0), "down", "up")
        time.sleep(0.6)  # long enough that two clicks are no double click
        self.browser.pointer(over, (200, 10), "down", "up")
        self.wait("document.querySelectorAll('#cursors tbody tr:first-child td').length === 3", "the table of cursors")
        cells = self.run("return [...document.querySelectorAll('#cursors tbody tr')].map(r => [...r.children].map(c => c.textContent))")
        if not ("Hz" in cells[0][3] and cells[3][0] == "i_q" and cells[3][3].endswith("A")):
            raise Fault(f"cursors: {cells}")
        self.shoot("load_step")

    def zooms_and_comes_back(self):
        over = self.run("return document.querySelectorAll('.u-over')[0]")
        self.browser.pointer(over, (-100, 0), "down", (0, 5), (100, 5), "up")
        self.wait("scope.state.zoom && scope.panels().every(p => p.plot.scales.x.max - p.plot.scales.x.min < 0.3)", "zoom")
        self.browser.pointer(over, (0, 0), "down", "up", "down", "up")
        self.wait("!scope.state.zoom && scope.panels()[2].plot.scales.x.max > 0.37", "the whole window")

    def shows_what_the_drive_has_kept(self):
        """A ramp down crosses a trigger level: the page shows 512 periods of every chosen signal around the period of the crossing."""
        self.pick("#capture_on", "falls below")
        self.pick("#capture_source", "omega_m")
        self.write("#capture_level", "400")
        self.write("#capture_after", "20")
        self.click("#capture_arm")
        self.wait("document.getElementById('capture_state').textContent === 'armed'", "arming")
        self.write("#speed_value", "300\n")
        self.wait("document.getElementById('capture_state').textContent === 'held'", "the edge")
        self.click("#capture_show")
        self.wait("scope.state.kept && scope.panels()[0].plot.data[0].length > 100", "the drive's buffer")
        time.sleep(0.3)
        kept = self.run(KEPT)
        expect(kept["names"], self.run("return scope.state.choice.signals.map(id => scope.rows.get(id).name)"), "signals of the buffer")
        expect([kept["periods"], kept["steps"], kept["at"]], [512, [1], 512 - 1 - 200], "periods, their steps, the trigger's place")
        if not kept["here"] < 400 <= kept["before"]:
            raise Fault(f"no edge at the trigger: {kept}")
        expect([round(x, 6) for x in kept["axis"]], [-0.0311, 0.02], "axis")
        for panel in self.run(TRACES):
            if min(panel) < 50:
                raise Fault(f"traces of the buffer with too few pixels: {panel}")
        self.shoot("buffer")
        self.click("#live")
        self.wait("!scope.state.kept && document.getElementById('from_drive').hidden", "back to live")
        self.click("#capture_release")
        self.wait("document.getElementById('capture_state').textContent === 'idle'", "release")
        expect(self.run("return document.getElementById('capture_show').disabled"), True, "nothing to show")

    def stop_is_in_reach_and_nothing_overflows(self):
        for width, height in ((1400, 1000), (390, 844)):
            self.browser.size(width, height)
            for top in (0, 600, 100000):
                self.run("scrollTo({top: arguments[0], behavior: 'instant'}); return new Promise(d => setTimeout(d, 200))", top)
                hit = self.run("const b = document.getElementById('stop').getBoundingClientRect();"
                               "return document.elementFromPoint(b.x + b.width / 2, b.y + b.height / 2)?.closest('#stop') !== null")
                expect(hit, True, f"STOP in reach, {width} px wide, {top} px down")
                self.shoot(f"width_{width}_{top}")
            page_fits(self.browser)
            expect(self.run(CLIPPED), [], f"fields that clip a number of seven digits, {width} px wide")
        self.browser.size(1400, 1000)
        self.run("scrollTo({top: 0, behavior: 'instant'})")

    def stops_while_held(self):
        self.run("const on = performance.now(); window.stopped = null; const look = setInterval(() => {"
                 " if (document.body.dataset.state !== 'operation_enabled') { window.stopped = performance.now() - on;"
                 " clearInterval(look); } }, 20)")
        self.click("#stop")
        self.wait("Math.abs(scope.value('omega_m')) < 1 && document.body.dataset.state === 'ready'", "standstill")
        expect(self.run("return scope.value('enable')"), 2, "the request: quick_stop")
        self.click("#hold")  # continues the display
        self.wait("!scope.state.held", "going on")

    def says_that_the_drive_is_gone_and_takes_it_up_again(self):
        self.drive.send_signal(signal.SIGTERM)
        self.drive.wait(20)
        self.wait("document.body.dataset.link === 'lost'", "the loss of the link")
        expect(self.run("return [...document.querySelectorAll('#plate button, #plate input')].filter(each => !each.disabled).length"), 0,
               "controls of the commissioning that are enabled without a link")
        faint = self.run(FAINT)
        if faint:
            raise Fault(f"old values that cannot be read: {faint}")
        self.click("#stop")
        self.wait("document.getElementById('alarm').innerText.includes('did not reach')", "the alarm")
        self.shoot("lost")
        self.drive, _ = self.start("serve", str(self.scenario), "--port", self.port, "--quiet")
        self.wait("document.body.dataset.link === 'up' && document.getElementById('alarm').hidden", "the link, again")
        self.pick("#mode", "none (rolling)")
        self.wait("scope.ring.total > 1000", "samples, again")

    def asked_nobody_else(self):
        only_asked_for(self.browser, self.url, below=True)

    def console_is_clean(self):
        console_is_clean(self.browser)

    def ends_by_a_signal(self):
        self.scope.send_signal(signal.SIGINT)
        expect(self.scope.wait(20), 0, "exit code of the scope")

    CHECKS = (opens_and_is_linked, starts_the_motor_and_sees_it_turn, draws_within_its_share_of_a_processor, changes_a_gain,
              chooses_signals, no_trigger_by_noise_on_a_slow_edge, triggers_on_a_load_step, reads_cursors, zooms_and_comes_back,
              shows_what_the_drive_has_kept, stop_is_in_reach_and_nothing_overflows, stops_while_held, says_that_the_drive_is_gone_and_takes_it_up_again, console_is_clean, asked_nobody_else, ends_by_a_signal)


def go_through(make_bench, checks, programs, rules):
    """Opens a bench in a folder of its own and runs the checks, each given as a name and a function of the bench. Returns the exit code."""
    with tempfile.TemporaryDirectory() as work:
        work = pathlib.Path(work)
        bench = None
        try:
            bench = make_bench(work)
            bench.browser = Browser(*programs, work, rules)
            for name, check in checks:
                watching = stuck.watch(name)
                check(bench)
                watching.cancel()
                print(f"good: {name}", flush=True)
        except Fault as fault:
            if "uPlot" in str(fault):
                print(f"skipped: {fault}")
                return SKIPPED
            print(f"FAILED: {fault}")
            if bench and bench.browser:
                bench.shoot("failed")
            return 1
        finally:
            if bench:
                if bench.browser:
                    bench.browser.close()
                bench.close()
    return 0


def main(text, benches, rules):
    """benches: for each bench a function that makes it from its folders for screenshots and for working files, and its checks."""
    if len(sys.argv) != 3:
        print(text)
        return 2
    programs = browser_programs()
    if not programs:
        print("skipped: chromium or chromedriver is missing")
        return SKIPPED
    folder = pathlib.Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    for make, checks in benches:
        code = go_through(lambda work, make=make: make(folder, work), [(check.__name__, check) for check in checks], programs, rules)
        if code != 0:
            return code
    return 0


if __name__ == "__main__":
    sys.exit(main(__doc__, [(lambda folder, work: Bench(sys.argv[1], folder, work), Bench.CHECKS)], "MAP * ~NOTFOUND, EXCLUDE 127.0.0.1"))
