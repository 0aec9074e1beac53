#!/usr/bin/env python3
"""Opens the page of a paper report in a headless Chromium without a network, and checks what a reader would
see; then it checks copies with faults, each of which must be detected.

usage: test_browser.py REPORT [--screenshots FOLDER]   checks REPORT/index.html

Exit codes: 0 done, 1 a check failed, 2 wrong use, 77 skipped (chromium, chromedriver, the page or its plots are missing).
Controls chromedriver by WebDriver over HTTP. Python 3.9, standard library only.
"""
import argparse
import base64
import contextlib
import json
import pathlib
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request

SKIPPED = 77
NO_PLOTS = ("fig16",)  # figures that are tables, like all content beyond the paper

# Plots near the viewport that are not drawn yet.
PENDING = """
return [...document.querySelectorAll('.plots')].filter(host => {
    const box = host.getBoundingClientRect();
    return box.bottom > 0 && box.top < innerHeight && !['ready', 'failed'].includes(host.dataset.state);
}).length"""

# A function of JavaScript: the red, green, blue and opacity of a colour that is given as CSS text.
RGB = """
const rgb = text => {
    const context = new OffscreenCanvas(1, 1).getContext('2d', {willReadFrequently: true});
    context.fillStyle = text;
    context.fillRect(0, 0, 1, 1);
    return [...context.getImageData(0, 0, 1, 1).data];
};
"""

# The canvases in the viewport, each with the number of its pixels in the colour of one of its traces.
CANVASES = RGB + """return [...document.querySelectorAll('.plots')].flatMap(host => (host.plots || []).map((plot, index) => {
    const canvas = plot.ctx.canvas, box = canvas.getBoundingClientRect();
    if (box.bottom <= 0 || box.top >= innerHeight) return null;
    const colours = plot.series.slice(1).map((series, k) => rgb(series.stroke(plot, k + 1)));
    const {left, top, width, height} = plot.bbox;
    const copy = new OffscreenCanvas(width, height).getContext('2d', {willReadFrequently: true});
    copy.drawImage(canvas, -left, -top);
    const data = copy.getImageData(0, 0, width, height).data;
    let found = 0;
    for (let i = 0; i < data.length; i += 4) {
        if (data[i + 3] > 200 && colours.some(c => [0, 1, 2].every(k => Math.abs(c[k] - data[i + k]) < 24))) found++;
    }
    return {name: host.dataset.figure + ' panel ' + index, found};
}).filter(each => each))"""

SCALES = """
const host = document.querySelectorAll('.plots')[arguments[0]];
return [...document.querySelectorAll(`.plots[data-figure="${host.dataset.figure}"]`)]
    .flatMap(each => (each.plots || []).map(plot => [plot.scales.x.min, plot.scales.x.max]))"""

# The points in view in the first plot of a layout, and the smallest distance of two of them [px].
POINTS = """
const plot = document.querySelectorAll('.plots')[arguments[0]].plots[0];
const {min, max} = plot.scales.x;
const x = Array.from(plot.data[0]).filter(value => value >= min && value <= max);
const gaps = x.slice(1).map((value, k) => plot.valToPos(value, 'x') - plot.valToPos(x[k], 'x'));
return {count: x.length, step: x.length > 1 ? x[1] - x[0] : 0, gap: Math.min(...gaps),
        marked: plot.series[1].points.show(plot, 1, plot.series[1].idxs ? plot.series[1].idxs[0] : 0, 0) !== false}"""

# Numbers of the x axis that end outside their canvas.
CUT = """
return [...document.querySelectorAll('.plots')].flatMap(host => (host.plots || []).flatMap((plot, index) => {
    const {_splits, _values, show} = plot.axes[0];
    if (!show || !_values) return [];
    const ctx = document.createElement('canvas').getContext('2d');
    ctx.font = '12px system-ui, sans-serif';
    const left = plot.bbox.left / devicePixelRatio;
    return _values.map((text, k) => text ? [text, left + plot.valToPos(_splits[k], 'x') + ctx.measureText(text).width / 2] : ['', 0])
        .filter(([_, end]) => end > plot.width).map(([text]) => `${host.dataset.figure} panel ${index}: ${text}`);
}))"""


class Fault(Exception):
    """A check that failed."""


class Browser:
    """A session of chromedriver."""

    def __init__(self, driver, chromium, folder, names="MAP * ~NOTFOUND"):
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        self.base = f"http://127.0.0.1:{port}"
        self.log = open(folder / "chromedriver.log", "w", encoding="utf-8")
        self.process = subprocess.Popen([driver, f"--port={port}"], stdout=self.log, stderr=subprocess.STDOUT)
        self.session = None
        # Connects to chromedriver directly, even if the environment names a proxy.
        self.opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
        self.wait(lambda: self.is_up(), "chromedriver")
        arguments = [
            "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
            "--disable-dev-shm-usage", "--disable-background-networking", "--disable-component-update",
            "--disable-sync", "--disable-default-apps", f"--host-resolver-rules={names}",
            "--proxy-server=127.0.0.1:9", f"--user-data-dir={folder / 'profile'}",
            "--window-size=1400,1000", "--force-device-scale-factor=1",
        ]
        self.session = self.call("POST", "/session", {"capabilities": {"alwaysMatch": {
            "browserName": "chrome", "goog:chromeOptions": {"binary": chromium, "args": arguments},
            "goog:loggingPrefs": {"browser": "ALL", "performance": "ALL"}}}})["sessionId"]

    def is_up(self):
        try:
            return self.call("GET", "/status")["ready"]
        except (OSError, ValueError):
            return False

    def call(self, method, path, body=None):
        request = urllib.request.Request(self.base + path, method=method, headers={"Content-Type": "application/json"},
                                         data=None if body is None else json.dumps(body).encode())
        try:
            with self.opener.open(request, timeout=120) as answer:
                return json.load(answer)["value"]
        except urllib.error.HTTPError as error:
            value = json.load(error)["value"]
            raise Fault(f"chromedriver: {path}: {value['error']}: {value['message'].splitlines()[0]}") from None

    def do(self, command, body=None):
        return self.call("POST", f"/session/{self.session}/{command}", body or {})

    def run(self, script, *arguments):
        return self.do("execute/sync", {"script": script, "args": list(arguments)})

    def records(self, kind):
        return self.do("se/log", {"type": kind})

    def size(self, width, height):
        self.cdp("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)

    def cdp(self, command, **parameters):
        return self.do("goog/cdp/execute", {"cmd": command, "params": parameters})

    def screenshot(self, path):
        answer = self.call("GET", f"/session/{self.session}/screenshot")
        path.write_bytes(base64.b64decode(answer))

    def pointer(self, element, *steps):
        """Moves the pointer by steps: (x, y) relative to the element's centre, "down", "up"."""
        actions = [{"type": f"pointer{step.capitalize()}", "button": 0} if isinstance(step, str) else
                   {"type": "pointerMove", "duration": 50, "origin": element, "x": step[0], "y": step[1]}
                   for step in steps]
        self.do("actions", {"actions": [{"type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"},
                                         "actions": actions}]})

    @staticmethod
    def wait(condition, what, seconds=60.0):
        end = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > end:
                raise Fault(f"{what}: nothing within {seconds:g} s")
            time.sleep(0.05)

    def close(self):
        with contextlib.suppress(Fault, OSError):
            if self.session:
                self.call("DELETE", f"/session/{self.session}")
        self.process.terminate()
        self.process.wait()
        self.log.close()


def expect(got, wanted, what):
    if got != wanted:
        def brief(value):
            return (str(value)[:300] + " ...") if len(str(value)) > 300 else str(value)
        raise Fault(f"{what}: {brief(got)}; expected {brief(wanted)}")


def only_asked_for(browser, url, below=False):
    """The page may load only itself, and with `below` files of its folder."""
    messages = [json.loads(record["message"])["message"] for record in browser.records("performance")]
    urls = [each["params"]["request"]["url"] for each in messages if each["method"] == "Network.requestWillBeSent"]
    asked = [each for each in urls if not each.startswith("data:") and not (below and each != url and each.startswith(url))]
    expect(asked, [url], "requests")


def console_is_clean(browser):
    said = [record["message"] for record in browser.records("browser") if record["level"] in ("SEVERE", "WARNING")]
    expect(said, [], "errors and warnings on the console")


def page_fits(browser):
    page, window = browser.run("const e = document.documentElement; return [e.scrollWidth, e.clientWidth]")
    if page > window:
        raise Fault(f"the page is {page} px wide in a window of {window} px")


def browser_programs():
    """The paths of chromedriver and of a Chromium; None where one is missing."""
    driver = shutil.which("chromedriver")
    chromium = next((path for path in map(shutil.which, ("chromium", "chromium-browser", "google-chrome")) if path), None)
    return (driver, chromium) if driver and chromium else None


class Page:
    """The checks of a page; each of them raises Fault."""

    def __init__(self, browser, report, shots):
        self.browser, self.folder, self.shots = browser, report, shots
        self.manifest = json.loads((report / "report.json").read_text(encoding="utf-8"))
        self.canvases = None
        browser.size(1400, 1000)
        browser.do("url", {"url": "about:blank"})
        for kind in ("performance", "browser"):  # discards the log entries of the browser's start and of the page before
            browser.records(kind)
        browser.do("url", {"url": (report / "index.html").resolve().as_uri()})
        browser.wait(lambda: browser.run("return document.readyState === 'complete'"), "the page")

    def shoot(self, name):
        if self.shots:
            self.browser.screenshot(self.shots / f"{name}.png")

    def every(self, selector, what):
        """The value of `what`, an expression in e, for each element."""
        return self.browser.run(f"return [...document.querySelectorAll(arguments[0])].map(e => {what})", selector)

    def settle(self):
        self.browser.run("return new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
        self.browser.wait(lambda: not self.browser.run(PENDING), "plots")

    def scrolled(self):
        """{canvas: pixels in the colour of a trace}, after the whole page has been scrolled through."""
        if self.canvases is None:
            self.canvases, top = {}, 0
            while top < self.browser.run("return document.documentElement.scrollHeight"):
                self.browser.run("scrollTo({top: arguments[0], behavior: 'instant'})", top)
                self.settle()
                self.shoot(f"page_{top:05d}")
                self.canvases.update((canvas["name"], canvas["found"]) for canvas in self.browser.run(CANVASES))
                top += 800
        return self.canvases

    def all_rows_are_in_the_table(self):
        shown = self.every("#verdicts [data-row]", "e.dataset.row")
        expect(sorted(shown), sorted(row["id"] for row in self.manifest["rows"]), "rows of the verdict table")

    def verdicts_have_sign_and_word(self):
        words = self.every(".counts li", "e.querySelector('.verdict').innerText")
        names = {row["verdict"] for row in self.manifest["rows"]}
        expect({re.sub(r"^\W+", "", word) for word in words}, names, "verdicts that are counted")
        expect([word for word in words if not re.match(r"\W", word)], [], "verdicts without a sign")

    def anchors_lead_somewhere(self):
        dead = self.every("a[href^='#']", "document.getElementById(e.hash.slice(1)) ? '' : e.hash")
        expect([anchor for anchor in dead if anchor], [], "anchors that lead nowhere")

    def data_are_beside_it(self):
        links = self.every("a:not([href^='#'])", "e.getAttribute('href')")
        expect([link for link in links if not (self.folder / link).is_file()], [], "linked files that are not there")
        expect({figure["csv"] for figure in self.manifest["figures"]} - set(links), set(), "CSV files without a link")

    def pictures_are_decoded(self):
        self.browser.run("return Promise.all([...document.images].map(e => e.decode().catch(() => 0))).then(() => 0)")
        images = self.every("section.figure img", "[e.alt, e.complete && e.naturalWidth > 0]")
        expect([name for name, shown in images if not shown], [], "pictures that cannot be shown")
        expect(len(images), len(self.manifest["figures"]), "pictures")

    def every_canvas_shows_its_traces(self):
        expect([name for name, found in self.scrolled().items() if found < 20], [], "canvases without a trace")

    def as_many_plots_as_panels(self):
        self.scrolled()
        layouts = self.every(".plots", "[e.dataset.figure, e.dataset.state, (e.plots || []).length,"
                             " e.querySelectorAll('canvas').length,"
                             " JSON.parse(e.querySelector('script').textContent).panels.length]")
        for figure, state, plots, canvases, panels in layouts:
            expect((state, plots, canvases), ("ready", panels, panels), f"state, plots and canvases of {figure}")
        wanted = {each["id"] for each in self.manifest["figures"] if each["paper"] and each["id"] not in NO_PLOTS}
        expect({layout[0] for layout in layouts}, wanted, "figures with plots")

    def no_number_is_cut_off(self):
        self.scrolled()
        expect(self.browser.run(CUT), [], "numbers that are cut off at the end of the axis")

    def finest(self):
        """The index and the step [s] of the layout over time with the smallest distance between grid lines; scrolls to it so that it is
        drawn."""
        steps = self.every(".plots", "(({x, x_unit, log}) => x_unit === 's' && !log && x.step || 1e9)"
                           "(JSON.parse(e.querySelector('script').textContent))")
        index = steps.index(min(steps))
        for _ in range(2):  # plots that are drawn during the scrolling may move it
            self.browser.run("document.querySelectorAll('.plots')[arguments[0]].scrollIntoView()", index)
            self.settle()
        return index, steps[index]

    def over(self, index):
        """The first plot of a layout, to which the pointer moves."""
        return self.browser.run("return document.querySelectorAll('.plots')[arguments[0]].querySelector('.u-over')",
                                index)

    def drag_zooms_all_panels_and_double_click_resets(self):
        index, _ = self.finest()
        over = self.over(index)
        full = self.browser.run(SCALES, index)
        self.browser.pointer(over, (-100, 0), "down", (0, 5), (100, 5), "up")
        zoomed = self.browser.run(SCALES, index)
        self.shoot("zoomed")
        if not full[0][0] < zoomed[0][0] < zoomed[0][1] < full[0][1]:
            raise Fault(f"drag: the axis is {zoomed[0]}, and was {full[0]}")
        expect(zoomed, zoomed[:1] * len(full), "axes of all panels after a drag")
        self.browser.pointer(over, (0, 0), "down", "up", "down", "up")
        expect(self.browser.run(SCALES, index), full, "axes of all panels after a double click")

    def single_periods_can_be_seen(self):
        index, step = self.finest()
        over = self.over(index)
        for _ in range(6):  # each step is a 32nd of the axis
            self.browser.pointer(over, (-20, 0), "down", (0, 5), (20, 5), "up")
        points = self.browser.run(POINTS, index)
        self.shoot("periods")
        if not (3 <= points["count"] <= 20 and points["gap"] > 10 and points["marked"]):
            raise Fault(f"at full zoom: {points}")
        if abs(points["step"] - step) > 1e-3 * step:
            raise Fault(f"two neighbours at full zoom are {points['step']} s apart, not {step}")
        self.browser.pointer(over, (0, 0), "down", "up", "down", "up")

    def cursor_is_shared_and_has_units(self):
        index, _ = self.finest()
        self.browser.pointer(self.over(index), (30, 3), (40, 3))
        texts = self.browser.run("return document.querySelectorAll('.plots')[arguments[0]].plots.map(plot =>"
                                 " [...plot.root.querySelectorAll('.u-value')].map(e => e.textContent))", index)
        expect(len({text[0] for text in texts}), 1, "times of the cursor in the panels of a figure")
        bare = [text for panel in texts for text in panel
                if not re.fullmatch("−?[0-9.]+ (s|r/min|m?rad|A|1/A)", text)]
        expect(bare, [], "values without a unit")

    def nothing_overflows(self):
        for width in (1400, 400):
            self.browser.size(width, 900)
            for top in (0, 2500, 9000) if self.shots else (0,):
                self.browser.run("scrollTo({top: arguments[0], behavior: 'instant'});"
                                 " return new Promise(done => setTimeout(done, 300))", top)
                self.shoot(f"width_{width}_{top}")
            page_fits(self.browser)

    def asked_nobody(self):
        only_asked_for(self.browser, (self.folder / "index.html").resolve().as_uri())

    def console_is_clean(self):
        console_is_clean(self.browser)

    CHECKS = (all_rows_are_in_the_table, verdicts_have_sign_and_word, anchors_lead_somewhere, data_are_beside_it,
              pictures_are_decoded, every_canvas_shows_its_traces, as_many_plots_as_panels, no_number_is_cut_off,
              drag_zooms_all_panels_and_double_click_resets, single_periods_can_be_seen, cursor_is_shared_and_has_units,
              nothing_overflows, asked_nobody, console_is_clean)


def faults_of(page, checks):
    """The faults that the checks found, as {check: fault}."""
    found = {}
    for check in checks:
        try:
            check(page)
        except Fault as fault:
            found[check] = str(fault)
    return found


def replaced(*pairs):
    def seed(text):
        for old, new in pairs:
            if old not in text:
                raise Fault(f"self-test: the page has no `{old}`")
            text = text.replace(old, new, 1)
        return text
    return seed


REMOTE = ("</header>", '<img alt="" src="http://example.invalid/a.png"></header>')
# A change of the page, the check that must detect it, and the message of that check. Faults in the same copy do not influence each other.
SEEDED = (
    (("a picture from elsewhere", replaced(REMOTE), Page.console_is_clean, "example.invalid"),
     ("a zoom that ends early", replaced(("LEAST_SPAN = 6;", "LEAST_SPAN = 600;")), Page.single_periods_can_be_seen, "full zoom"),
     ("values without a unit", replaced(('" " + column.unit', '""')), Page.cursor_is_shared_and_has_units, "values without a unit"),
     ("a row that is missing", replaced((' data-row="', ' data-gone="')), Page.all_rows_are_in_the_table, "rows of the verdict"),
     ("a verdict without a sign", replaced(('<span class="sign">✓</span>', "")), Page.verdicts_have_sign_and_word, "without a sign"),
     ("a link to no file", replaced(('href="data/', 'href="gone/')), Page.data_are_beside_it, "not there"),
     ("an anchor that leads nowhere", replaced(('id="conditions"', 'id="gone"')), Page.anchors_lead_somewhere, "#conditions"),
     ("something too wide", replaced(("</header>", '<p style="width: 1000px">wide</p></header>')), Page.nothing_overflows, "px wide")),
    (("one that the page's policy allows", replaced(REMOTE, ("img-src data:", "img-src data: *")), Page.asked_nobody, "example.invalid"),
     ("an error that is thrown", replaced(("</body>", "<script>throw new Error('seeded')</script></body>")), Page.console_is_clean,
      "seeded"),
     ("empty canvases", replaced(("ctx.save();", "ctx.clearRect(0, 0, 1e4, 1e4); ctx.save();")), Page.every_canvas_shows_its_traces,
      "without a trace"),
     ("panels that do not zoom together", replaced(("of figure.plots)", "of figure.plots.slice(0, 1))")),
      Page.drag_zooms_all_panels_and_double_click_resets, "axes of all panels"),
     ("numbers that are cut off", replaced(("layout.log ? 26 : 14", "14")), Page.no_number_is_cut_off, "10,000"),
     ("a broken picture", replaced(("data:image/png;base64,iVBOR", "data:image/png;base64,AAAAA")), Page.pictures_are_decoded,
      "cannot be shown")),
    (("plots that fail", replaced(("new DecompressionStream", "new Decompression")), Page.as_many_plots_as_panels,
      "state, plots and canvases"),),
)


def missed(browser, report, work):
    """The number of planted faults that their checks did not find."""
    count = 0
    copy = work / "copy"
    copy.mkdir()
    for name in ("data", "pictures", "report.json"):
        (copy / name).symlink_to((report / name).resolve())
    for faults in SEEDED:
        text = (report / "index.html").read_text(encoding="utf-8")
        for _, seed, _, _ in faults:
            text = seed(text)
        (copy / "index.html").write_text(text, encoding="utf-8")
        page = Page(browser, copy, None)
        page.settle()
        checks = {check for _, _, check, _ in faults}
        found = faults_of(page, [check for check in Page.CHECKS if check in checks])
        for what, _, check, sign in faults:
            seen = sign in found.get(check, "")
            count += not seen
            print("found " if seen else "MISSED", what + ":", found.get(check, ""))
    unseen = set(Page.CHECKS) - {check for faults in SEEDED for _, _, check, _ in faults}
    expect(unseen, set(), "checks that never fail")
    return count


def main():
    parser = argparse.ArgumentParser(description="Opens the page of a paper report in a headless Chromium.")
    parser.add_argument("report", type=pathlib.Path)
    parser.add_argument("--screenshots", type=pathlib.Path, help="folder for PNG files of what was seen")
    options = parser.parse_args()
    programs = browser_programs()
    if not programs:
        print("skipped: chromium or chromedriver (Debian: chromium-driver) is missing")
        return SKIPPED
    index = options.report / "index.html"
    if not options.report.is_dir():
        parser.error(f"{options.report}: no such folder")
    if not index.is_file():
        print(f"skipped: there is no {index}: it takes matplotlib to make it")
        return SKIPPED
    if re.search('<p id="how">[^<]*tools/get-uplot', index.read_text(encoding="utf-8")):
        print(f"skipped: {index} was made without uPlot, which tools/get-uplot brings")
        return SKIPPED
    if options.screenshots:
        options.screenshots.mkdir(parents=True, exist_ok=True)
    work = pathlib.Path(tempfile.mkdtemp(prefix="lagless_page_"))
    browser = None
    try:
        browser = Browser(*programs, work)
        found = faults_of(Page(browser, options.report, options.screenshots), Page.CHECKS)
        unseen = missed(browser, options.report, work)
    finally:
        if browser:
            browser.close()
        shutil.rmtree(work, ignore_errors=True)
    for check in Page.CHECKS:
        print("FAILED" if check in found else "ok    ", check.__name__.replace("_", " "), found.get(check, ""))
    return 1 if found or unseen else 0


if __name__ == "__main__":
    sys.exit(main())
