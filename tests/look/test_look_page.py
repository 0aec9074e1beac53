#!/usr/bin/env python3
"""Opens pages of runs in a headless Chromium without a network, at the widths of a desktop screen and of a phone: the pages of a run with a
fault, of two compared recordings, and of a fault matrix. tests/report proves on the report's page that such checks detect a fault.

usage: test_look_page.py LAGLESS FOLDER    pages and screenshots are written to FOLDER

Exit codes: 0 done, 1 a check failed, 2 wrong use, 77 skipped (matplotlib, uPlot, chromium or chromedriver is missing). Python 3.9,
standard library only."""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "report"))
from test_browser import (CANVASES, CUT, RGB, SKIPPED, Browser, Fault, browser_programs, console_is_clean, expect, only_asked_for,  # noqa: E402
                          page_fits)

WIDTHS = (1400, 390)

# For each panel of each layout: its kind, and its parts that were not visible.
PANELS = """
return [...document.querySelectorAll('.plots')].map(host => {
    const layout = JSON.parse(host.querySelector('script').textContent);
    return {figure: host.dataset.figure, state: host.dataset.state, plots: (host.plots || []).length,
            panels: layout.panels.map(panel => ({ylabel: panel.ylabel, kind: panel.kind, traces: panel.traces.map(t => t.label)})),
            legends: (host.plots || []).map(plot => [...plot.root.querySelectorAll('.u-legend th')].slice(1).map(e => e.textContent)),
            left: (host.plots || []).map(plot => Math.round(plot.bbox.left))};
})"""

# Texts of a legend or an axis that overlap others or are outside the window.
HIDDEN = """
const found = [];
for (const box of document.querySelectorAll('.u-legend')) {
    const rows = [...box.querySelectorAll('.u-series')].map(e => e.getBoundingClientRect());
    rows.forEach((a, k) => rows.slice(k + 1).forEach(b => {
        if (Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1 && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 1)
            found.push('legends overlap');
    }));
    if (rows.some(row => row.right > innerWidth || row.left < 0)) found.push('a legend is cut off');
}
for (const e of document.querySelectorAll('h1, h2, td, th, button, p, pre')) {
    const box = e.getBoundingClientRect();
    if (e.tagName === 'TD' && box.height > 200) found.push('a cell is ' + Math.round(box.height) + ' px high: ' + e.textContent.slice(0, 40));
    if (box.width && !e.closest('.wide, details') && box.right > innerWidth + 1) found.push(e.tagName + ' is cut off: ' + e.textContent.slice(0, 40));
}
return found"""


def drawn(browser, shot=None):
    """Scrolls to every layout, which is then drawn; returns {canvas: pixels in the colour of a trace}."""
    canvases = {}
    for host in range(browser.run("return document.querySelectorAll('.plots').length")):
        browser.run("document.querySelectorAll('.plots')[arguments[0]].scrollIntoView()", host)
        browser.wait(lambda: browser.run("return ['ready', 'failed'].includes(document.querySelectorAll('.plots')[arguments[0]].dataset.state)",
                                         host), "plots")
    top = 0
    while top < browser.run("return document.documentElement.scrollHeight"):
        browser.run("scrollTo({top: arguments[0], behavior: 'instant'});"
                    " return new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))", top)
        canvases.update((canvas["name"], canvas["found"]) for canvas in browser.run(CANVASES))
        top += 700
    if shot:
        height = browser.run("return document.documentElement.scrollHeight")
        width = browser.run("return innerWidth")
        browser.size(width, height)
        browser.run("scrollTo(0, 0); return new Promise(done => setTimeout(done, 200))")
        browser.screenshot(shot)
    return canvases


def open_page(browser, path, width):
    browser.size(width, 900)
    browser.do("url", {"url": "about:blank"})
    for kind in ("performance", "browser"):
        browser.records(kind)
    browser.do("url", {"url": path.resolve().as_uri()})
    browser.wait(lambda: browser.run("return document.readyState === 'complete'"), "the page")


def check_state(seen):
    for layout in seen.layouts:
        expect((layout["state"], layout["plots"]), ("ready", len(layout["panels"])), f"state and plots of {layout['figure']}")


def check_left_ends(seen):
    for layout in seen.layouts:
        expect(len(set(layout["left"])), 1, "left ends of the panels of one layout")


def check_legends(seen):
    for layout in seen.layouts:
        expect(layout["legends"], [panel["traces"] for panel in layout["panels"]], "names in the legends")


def check_units(seen):
    bare = [panel["ylabel"] for layout in seen.layouts for panel in layout["panels"]
            if panel["kind"] != "bands" and not re.search(r"\[.*\]$", panel["ylabel"])]
    expect(bare, [], "axes without a unit")


def check_traces(seen):
    bands = {f"{layout['figure']} panel {k}" for layout in seen.layouts for k, panel in enumerate(layout["panels"])
             if panel["kind"] == "bands"}
    expect(sorted(seen.canvases), sorted(f"{layout['figure']} panel {k}" for layout in seen.layouts for k in range(layout["plots"])),
           "canvases")
    expect([name for name, found in seen.canvases.items() if found < 20 and name not in bands], [], "panels that show no trace")


# The panel of bands shows a state and its name: it has pixels of more than one colour, some of them those of letters.
BANDS = """
return [...document.querySelectorAll('.plots')].flatMap(host => (host.plots || []).filter((_, k) =>
    JSON.parse(host.querySelector('script').textContent).panels[k].kind === 'bands').map(plot => {
    const {left, top, width, height} = plot.bbox;
    const copy = new OffscreenCanvas(width, height).getContext('2d', {willReadFrequently: true});
    copy.drawImage(plot.ctx.canvas, -left, -top);
    const data = copy.getImageData(0, 0, width, height).data;
    let filled = 0, dark = 0;
    for (let i = 0; i < data.length; i += 4) {
        filled += data[i + 3] > 50 && data[i + 3] < 120;
        dark += data[i + 3] > 200 && data[i] + data[i + 1] + data[i + 2] < 250;
    }
    return {filled, dark};
}))"""


def check_bands(seen):
    bands = seen.browser.run(BANDS)
    if not bands or any(each["filled"] < 500 or each["dark"] < 150 for each in bands):
        raise Fault(f"bands without colours or names: {bands}")


def check_cursor(seen):
    """The legend shows the names of the bands and the values with their units at the cursor."""
    if seen.width != max(WIDTHS):
        return
    over = seen.browser.run("const host = document.querySelector('.plots'); host.scrollIntoView();"
                            "return host.plots[1].root.querySelector('.u-over')")
    seen.browser.pointer(over, (30, 3), (40, 3))
    texts = seen.browser.run("return document.querySelector('.plots').plots.slice(0, 2).map(plot =>"
                             "[...plot.root.querySelectorAll('.u-value')].map(e => e.textContent))")
    if not texts[0][1].replace("_", "").isalpha() or not all(text.split()[-1] in ("s", "r/min") for text in texts[1]):
        raise Fault(f"under the cursor: {texts}")


# For each tenth of a panel in which a trace has values within the axis: the pixels in the colour of such a trace, if they are few.
GAPS = RGB + """return [...document.querySelectorAll('.plots')].flatMap(host => (host.plots || []).flatMap((plot, index) => {
    if (JSON.parse(host.querySelector('script').textContent).panels[index].kind === 'bands') return [];
    const {left, top, width, height} = plot.bbox;
    const copy = new OffscreenCanvas(width, height).getContext('2d', {willReadFrequently: true});
    copy.drawImage(plot.ctx.canvas, -left, -top);
    const data = copy.getImageData(0, 0, width, height).data;
    const {min, max} = plot.scales.y;
    const found = [];
    for (let part = 0; part < 10; part++) {
        const [from, to] = [0, 1].map(k => Math.floor((part + k) * width / 10));
        const inside = x => x >= plot.posToVal(from / devicePixelRatio, 'x') && x < plot.posToVal(to / devicePixelRatio, 'x');
        const colours = plot.series.slice(1).filter((_, k) => plot.data[0].some((x, i) => plot.data[k + 1][i] != null && inside(x) &&
            plot.data[k + 1][i] >= min && plot.data[k + 1][i] <= max)).map((series, k) => rgb(series.stroke(plot, k + 1)));
        let count = 0;
        for (let y = 0; y < height; y++) for (let x = from; x < to; x++) {
            const i = 4 * (y * width + x);
            if (data[i + 3] > 100 && colours.some(c => [0, 1, 2].every(k => Math.abs(c[k] - data[i + k]) < 40))) count++;
        }
        if (colours.length && count < 4) found.push(`${host.dataset.figure} panel ${index}, tenth ${part}: ${count} pixels`);
    }
    return found;
}))"""


def check_gaps(seen):
    """A trace does not vanish in a part of its panel, for instance where an angle has more turns than there are pixels."""
    expect(seen.browser.run(GAPS), [], "parts of a panel that show no trace")


def check_numbers(seen):
    expect(seen.browser.run(CUT), [], "numbers that are cut off at the end of the axis")


def check_asked(seen):
    only_asked_for(seen.browser, seen.path.resolve().as_uri())


def check_console(seen):
    console_is_clean(seen.browser)


def check_room(seen):
    page_fits(seen.browser)


def check_hidden(seen):
    expect(seen.browser.run(HIDDEN), [], "text that cannot be read")


# The checks of a page without plots.
OF_TEXT = (check_room, check_hidden, check_asked, check_console)
CHECKS = (check_state, check_left_ends, check_legends, check_units, check_traces, check_bands, check_gaps, check_numbers, check_room,
          check_hidden, check_cursor, check_asked, check_console)


class Seen:
    """A page at one width, opened and drawn from top to bottom."""

    def __init__(self, browser, path, width, shot=None):
        self.browser, self.path, self.width = browser, path, width
        open_page(browser, path, width)
        self.canvases = drawn(browser, shot)
        self.layouts = browser.run(PANELS)

    def faults(self):
        """The results as {check: the faults that it found}."""
        found = {}
        for check in CHECKS if self.layouts else OF_TEXT:
            try:
                check(self)
            except Fault as fault:
                found[check] = str(fault)
        return found


def pages(lagless, folder):
    """The pages as {name: page}: of a run with a fault, of a start with many turns, of two compared runs, and of a fault matrix."""
    for name, more in (("run", ()), ("other", ("--set", "load_torque=2 N m"))):
        done = subprocess.run([lagless, "run", "stuck_sensor", *more, "--plot", "--out", folder / name, "--quiet"], stderr=subprocess.PIPE,
                              text=True, check=False)
        if "matplotlib is missing" in done.stderr or "tools/get-uplot" in (folder / name / "stuck_sensor.html").read_text(encoding="utf-8"):
            print("skipped: matplotlib, or uPlot, which tools/get-uplot brings, is missing")
            sys.exit(SKIPPED)
    subprocess.run([lagless, "compare", *(folder / name / "stuck_sensor.csv" for name in ("run", "other")), "--out", folder / "compare"],
                   stdout=subprocess.DEVNULL, check=False)
    subprocess.run([lagless, "run", "cold_start", "--plot", "--out", folder / "start", "--quiet"], check=False)
    subprocess.run([lagless, "matrix", "--share", "3", "--out", folder / "matrix"], stdout=subprocess.DEVNULL, check=False)
    return {"run": folder / "run" / "stuck_sensor.html", "start": folder / "start" / "cold_start.html",
            "compare": folder / "compare" / "compare.html", "matrix": folder / "matrix" / "matrix.html"}


def main():
    lagless, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    programs = browser_programs()
    if not programs:
        print("skipped: chromium or chromedriver (Debian: chromium-driver) is missing")
        return SKIPPED
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    made = pages(lagless, folder)
    work = pathlib.Path(tempfile.mkdtemp(prefix="lagless_look_"))
    failed, browser = 0, None
    try:
        browser = Browser(*programs, work)
        for name, page in made.items():
            for width in WIDTHS:
                seen = Seen(browser, page, width, folder / f"{name}_{width}.png")
                found = seen.faults()
                failed += len(found)
                print("FAILED" if found else "ok    ", name, width, "px:", sum(layout["plots"] for layout in seen.layouts), "panels",
                      *found.values())
    finally:
        if browser:
            browser.close()
        shutil.rmtree(work, ignore_errors=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
