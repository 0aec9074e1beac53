/* The page of the scope. Samples arrive with the time stamps of the drive. This page stores them, searches for the trigger, and draws the
 * smallest and the largest value in each column of pixels. The drive answers every request, and
   the page shows its answer. Numbers of samples and time are periods until they are shown. */
"use strict";
const scope = (() => {
    const ROOM = 1 << 19; // [samples] kept of each signal
    const WINDOWS = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20]; // [s]
    const SAMPLING = [0, 1, 2, 5, 10, 20, 50, 100, 200]; // [periods] 0: as fast as the link allows
    const AUTO_AFTER = 1; // [s] time without a trigger, in addition to a window, after which the picture rolls
    const NOISE_SHARE = 0.05;
    const STOP_TRIES = 3;
    const STOP_WAIT = 1500; // [ms] for the answer of one
    const START_WAIT = 3000; // [ms] for the bridge to come on
    const RESET_WAIT = 1000; // [ms] for a fault to be gone
    const STALE = 2; // [s] older values no longer show the state of the drive
    const NAMED = {ohm: "Ω", degC: "°C", "N m": "N·m", "kg m^2": "kg·m²", "rad/s^2": "rad/s²", "N m s/rad": "N·m·s/rad", "-": ""};
    const PREFIXED = new Set(["A", "V", "s", "rad", "Wb", "H", "ohm", "W", "J", "N m"]);
    const LEAST_SPAN = {"r/min": 20, A: 1, V: 2, rad: 0.01, "rad/s": 5, degC: 2}; // [shown unit] of an axis
    const $ = id => document.getElementById(id);
    const css = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
    const make = (tag, properties, ...inside) => {
        const made = Object.assign(document.createElement(tag), properties);
        made.append(...inside);
        return made;
    };

    const rows = new Map(); // id -> row
    const named = new Map(); // name -> row
    const values = new Map(); // id -> number
    const state = {
        hello: null, link: false, choice: null, held: false, zoom: null, cursors: [], frames: 0, gaps: 0, armed: "roll",
        pictures: 0, dirty: true, undo: new Map(), started: performance.now(),
        kept: null, // signals and picture while the page shows the drive's own buffer
    };

    const signalsShown = () => state.kept ? state.kept.signals : state.choice.signals;

    /* ---- numbers ---- */

    function digits(number, count = 5) {
        if (number == null || !Number.isFinite(number)) {
            return "–";
        }
        const size = Math.abs(number);
        const text = size !== 0 && (size >= 1e6 || size < 1e-4) ? number.toExponential(count - 2)
            : number.toFixed(Math.min(6, Math.max(0, count - 1 - Math.floor(Math.log10(Math.max(size, 1e-3))))));
        return text.replace("-", "−").replace("e+", "e");
    }

    /* The fewest digits that distinguish a float from its neighbours. */
    function shortest(number) {
        if (!Number.isFinite(number)) {
            return "";
        }
        for (let count = 1; count < 10; count++) {
            const text = Number(number.toPrecision(count));
            if (Math.fround(text) === Math.fround(number)) {
                return String(text);
            }
        }
        return String(number);
    }

    function unitOf(row, prefix = "") {
        const unit = row.shown in NAMED ? NAMED[row.shown] : row.shown;
        return prefix + unit;
    }

    function prefixOf(row, size) {
        if (!PREFIXED.has(row.shown) || size === 0) {
            return ["", 1];
        }
        return size < 5e-4 ? ["µ", 1e6] : size < 0.5 ? ["m", 1e3] : size >= 5e3 ? ["k", 1e-3] : ["", 1];
    }

    function choiceName(row, number) {
        return (row.choices[number] || String(number)).replaceAll("_", " ");
    }

    /* The text of a value, which is in the unit of its row. */
    function shown(row, number) {
        if (number == null) {
            return "–";
        }
        if (row.kind === "enum") {
            return choiceName(row, Math.round(number));
        }
        if (row.kind !== "float") {
            return String(Math.round(number)).replace("-", "−") + (row.shown === "-" ? "" : " " + unitOf(row));
        }
        const scaled = number * row.factor;
        const [prefix, factor] = prefixOf(row, Math.abs(scaled));
        return `${digits(scaled * factor)} ${unitOf(row, prefix)}`.trim();
    }

    const value = name => named.has(name) ? values.get(named.get(name).id) : undefined;

    function time(seconds) {
        const size = Math.abs(seconds);
        return size >= 1 || size === 0 ? `${digits(seconds, 5)} s` : size >= 1e-3 ? `${digits(seconds * 1e3, 5)} ms`
            : `${digits(seconds * 1e6, 4)} µs`;
    }

    /* ---- samples: a ring buffer for each signal, and one for the time stamps ---- */

    const ring = {stamps: new Float64Array(ROOM), columns: [], total: 0, last: -1};

    function clearRing(count) {
        ring.columns = Array.from({length: count}, () => new Float64Array(ROOM));
        ring.total = 0;
        ring.last = -1;
    }

    const view = {stamps: null, columns: null, from: 0, to: 0, mask: ROOM - 1}; // the data that are drawn: the ring buffer, or a record

    function place(stamp, data) { // first sample at or after this stamp
        let low = data.from, high = data.to;
        while (low < high) {
            const middle = Math.floor((low + high) / 2);
            if (data.stamps[middle & data.mask] < stamp) {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        return low;
    }

    function wholeRing() {
        return {stamps: ring.stamps, columns: ring.columns, mask: ROOM - 1, from: Math.max(0, ring.total - ROOM), to: ring.total};
    }

    function take(event) {
        if (!state.choice || event.g !== state.choice.g || state.held) {
            return;
        }
        const octets = Uint8Array.from(atob(event.d), letter => letter.charCodeAt(0));
        const {n, c, p, e} = event;
        const slots = {
            float: new Float32Array(octets.buffer), uint: new Uint32Array(octets.buffer), int: new Int32Array(octets.buffer),
        };
        if (ring.last >= 0 && p !== ring.last + e) {
            state.gaps++;
            if (p <= ring.last) {
                clearRing(ring.columns.length); // the drive has restarted
                trigger.record = null;
            }
        }
        const begin = ring.total;
        for (let k = 0; k < n; k++) {
            ring.stamps[(begin + k) & (ROOM - 1)] = p + k * e;
        }
        for (let s = 0; s < c; s++) {
            const row = rows.get(state.choice.signals[s]);
            const from = slots[row.kind === "enum" ? "int" : row.kind];
            const to = ring.columns[s];
            for (let k = 0, at = s; k < n; k++, at += c) {
                to[(begin + k) & (ROOM - 1)] = from[at] * row.factor;
            }
        }
        ring.total += n;
        ring.last = p + (n - 1) * e;
        trigger.look(begin);
        state.dirty = true;
    }

    /* ---- trigger ---- */

    const trigger = {
        mode: "roll", source: 0, edge: "rise", level: 0, pre: 0.25, armedAt: 0, at: null, record: null, seen: 0,
        below: false, above: false, // the signal was away from the level by more than the noise, and has not reached it since then
        least: Infinity, most: -Infinity, // of the signal since arming; noise is a share of this range

        arm() {
            this.armedAt = ring.total;
            this.at = null;
            this.record = null;
            this.below = this.above = false;
            [this.least, this.most] = [Infinity, -Infinity];
            this.seen = performance.now();
            state.dirty = true;
        },

        /* Processes the new samples from `begin` on. Noise on a slow edge of the other direction does not trigger. The range includes each
           new sample, because the edge itself can be the first change of a signal that was constant. */
        look(begin) {
            if (this.mode === "roll" || state.held) {
                return;
            }
            const span = periods(windowSeconds());
            const column = ring.columns[ring.columns.length > this.source ? this.source : 0];
            for (let k = Math.max(begin, this.armedAt, 1); k < ring.total && this.at === null && column; k++) {
                const here = column[k & (ROOM - 1)];
                const rises = this.below && here >= this.level, falls = this.above && here <= this.level;
                if ((rises && this.edge !== "fall") || (falls && this.edge !== "rise")) {
                    this.at = ring.stamps[k & (ROOM - 1)];
                }
                [this.least, this.most] = [Math.min(this.least, here), Math.max(this.most, here)];
                const noise = NOISE_SHARE * (this.most - this.least);
                this.below = here < this.level - noise || (this.below && here < this.level);
                this.above = here > this.level + noise || (this.above && here > this.level);
            }
            if (this.at !== null && ring.last >= this.at + (1 - this.pre) * span) {
                this.keep(this.at - this.pre * span, this.at + (1 - this.pre) * span);
            }
        },

        /* Copies the triggered picture, because new samples overwrite the ring buffer. */
        keep(begin, end) {
            const all = wholeRing();
            const from = place(begin, all), to = Math.min(place(end, all) + 1, all.to);
            const pick = column => Float64Array.from({length: to - from}, (_, k) => column[(from + k) & all.mask]);
            this.record = {stamps: pick(all.stamps), columns: all.columns.map(pick), mask: -1, from: 0, to: to - from, begin, end,
                           zero: this.at};
            this.at = null;
            this.armedAt = to;
            this.seen = performance.now();
            state.pictures++;
            if (this.mode === "single") {
                hold(true);
            }
        },

        /* Selects the samples to draw, and computes [begin, end] and the zero of the axis [periods]. */
        picture() {
            if (state.kept) {
                return state.kept.picture;
            }
            const span = periods(windowSeconds());
            const stale = performance.now() - this.seen > 1000 * (AUTO_AFTER + windowSeconds());
            if (this.record && this.mode !== "roll" && !(this.mode === "auto" && stale && !state.held)) {
                return this.record;
            }
            const end = ring.last < 0 ? span : ring.last;
            return {...wholeRing(), begin: end - span, end, zero: end};
        },

        word() {
            if (state.held) {
                return this.record && this.mode === "single" ? ["triggered, held", "good"] : ["held", "kind"];
            }
            return this.at !== null ? ["triggered", "good"]
                : this.record && this.mode === "normal" ? ["waiting for the next", ""]
                : this.record && this.picture() === this.record ? ["triggered", "good"]
                : this.mode === "auto" ? ["none (rolling)", "kind"] : ["waiting", "kind"];
        },
    };

    const windowSeconds = () => Number($("window").value);
    const periods = seconds => seconds / (state.hello ? state.hello.period : 1e-4);
    const seconds = count => count * (state.hello ? state.hello.period : 1e-4);

    function hold(on) {
        if (!on && state.held && trigger.mode === "single") {
            trigger.arm();
        }
        if (!on && state.held) {
            ring.last = -1; // while the picture was held no samples were recorded, which does not count as a gap
            clearRing(ring.columns.length);
            trigger.arm();
            state.zoom = null;
            state.cursors = [];
        }
        state.held = on;
        $("hold").setAttribute("aria-pressed", on);
        $("hold").textContent = on ? "Continue" : "Hold";
        state.dirty = true;
    }

    /* ---- panels: one for each unit ---- */

    let panels = [];
    const traceColour = index => css(`--c${index % 8}`);
    const isReference = row => /_ref$/.test(row.name);

    function swatch(index, row) {
        const line = document.createElementNS("http://www.w3.org/2000/svg", "svg");
        line.setAttribute("width", 20);
        line.setAttribute("height", 8);
        line.innerHTML = `<line x1="1" x2="19" y1="4" y2="4" stroke="var(--c${index % 8})" stroke-width="3"` +
            `${isReference(row) ? " stroke-dasharray=\"5 3\"" : ""}/>`;
        return line;
    }

    function group() {
        const groups = new Map();
        signalsShown().forEach((id, index) => {
            const row = rows.get(id);
            const key = row.kind === "enum" ? `enum ${id}` : row.shown === "-" ? `number ${id}` : row.shown;
            if (!groups.has(key)) {
                groups.set(key, []);
            }
            groups.get(key).push({row, index});
        });
        return [...groups.values()];
    }

    function height(count) {
        const top = innerWidth > 1000 ? $("panels").getBoundingClientRect().top + scrollY : 0;
        const free = (innerWidth > 1000 ? innerHeight - top - 88 : 0.85 * innerHeight) - 31 * count;
        return Math.round(Math.min(320, Math.max(innerWidth > 600 ? 118 : 112, free / count)));
    }

    const showsLevel = panel => !state.kept && trigger.mode !== "roll" && panel.traces.some(trace => trace.index === trigger.source);

    function niceRange(panel) {
        let [low, high] = [Infinity, -Infinity];
        for (const trace of panel.traces) {
            const [least, most] = panel.extent[trace.index] || [];
            if (least <= most) {
                low = Math.min(low, least);
                high = Math.max(high, most);
            }
        }
        if (showsLevel(panel)) {
            low = Math.min(low, trigger.level);
            high = Math.max(high, trigger.level);
        }
        const row = panel.traces[0].row;
        if (row.kind === "enum") {
            return [-0.5, row.choices.length - 0.5];
        }
        if (!(low <= high)) {
            [low, high] = [0, 1];
        }
        const least = LEAST_SPAN[row.shown] || Math.max(1e-6, 0.02 * Math.max(Math.abs(low), Math.abs(high)));
        if (high - low < least) {
            const middle = (high + low) / 2;
            [low, high] = [middle - least / 2, middle + least / 2];
        }
        const raw = (high - low) / 5;
        const ten = 10 ** Math.floor(Math.log10(raw));
        const step = ten * [1, 2, 5, 10].find(each => each * ten >= raw);
        const margin = 0.04 * (high - low);
        return [Math.floor((low - margin) / step) * step, Math.ceil((high + margin) / step) * step];
    }

    function axisTicks(plot, splits, axis, space, distance) {
        let exponent = Math.floor(Math.log10(distance) + 1e-9);
        if (Math.abs(distance / 10 ** exponent - Math.round(distance / 10 ** exponent)) > 1e-6) {
            exponent -= 1; // 2.5
        }
        return splits.map(number => number == null ? "" : number.toFixed(Math.max(0, -exponent)).replace("-", "−"));
    }

    function scaledTicks(panel) {
        return (plot, splits, axis, space, distance) => {
            const row = panel.traces[0].row;
            if (row.kind === "enum") {
                return splits.map(number => Number.isInteger(number) ? choiceName(row, number) : "");
            }
            return axisTicks(plot, splits.map(number => number * panel.scale), axis, space, distance * panel.scale);
        };
    }

    function drawMarks(panel, first) {
        return plot => {
            const {ctx, bbox} = plot, ratio = devicePixelRatio;
            const upright = (x, colour, text, dash) => {
                const at = Math.round(plot.valToPos(x, "x", true)) + 0.5;
                if (at < bbox.left || at > bbox.left + bbox.width) {
                    return;
                }
                ctx.strokeStyle = ctx.fillStyle = colour;
                ctx.setLineDash(dash);
                ctx.beginPath();
                ctx.moveTo(at, bbox.top);
                ctx.lineTo(at, bbox.top + bbox.height);
                ctx.stroke();
                if (text && first) {
                    const left = text.length > 1; // part of the cursor line that the letter does not cover
                    ctx.setLineDash([]);
                    ctx.textAlign = left ? "right" : "left";
                    ctx.fillText(text, at + (left ? -4 : 4) * ratio, bbox.top + 11 * ratio);
                }
            };
            ctx.save();
            ctx.lineWidth = ratio;
            ctx.font = `600 ${11 * ratio}px system-ui, sans-serif`;
            ctx.textAlign = "left";
            ctx.textBaseline = "alphabetic";
            if (state.picture && (state.kept || state.picture === trigger.record)) {
                upright(0, css("--soft"), "trigger", [3 * ratio, 3 * ratio]);
            }
            if (showsLevel(panel)) {
                const at = Math.round(plot.valToPos(trigger.level, "y", true)) + 0.5;
                ctx.strokeStyle = traceColour(trigger.source);
                ctx.setLineDash([2 * ratio, 3 * ratio]);
                ctx.beginPath();
                ctx.moveTo(bbox.left, at);
                ctx.lineTo(bbox.left + bbox.width, at);
                ctx.stroke();
            }
            state.cursors.forEach((x, k) => upright(x, css("--ink"), "AB"[k], [6 * ratio, 3 * ratio]));
            ctx.restore();
        };
    }

    /* The uncertainty of the angle, if both are shown: three times theta_sigma on each side, below the traces. Each point is drawn as a separate
     * column, because the angle wraps. */
    function drawBand(panel) {
        return plot => {
            const trace = name => panel.traces.findIndex(each => each.row.name === name);
            const [angle, sigma] = [trace("theta_e"), trace("theta_sigma")];
            if (angle < 0 || sigma < 0) {
                return;
            }
            const {ctx, bbox} = plot, [x, ...ys] = plot.data;
            ctx.save();
            ctx.beginPath();
            ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
            ctx.clip();
            ctx.fillStyle = traceColour(panel.traces[angle].index);
            ctx.globalAlpha = 0.25;
            ctx.beginPath(); // one area, so that overlapping parts are not darker
            for (let k = 0; k < x.length; k++) {
                if (ys[angle][k] == null || ys[sigma][k] == null) {
                    continue;
                }
                const left = plot.valToPos(x[k], "x", true);
                const right = k + 1 < x.length ? plot.valToPos(x[k + 1], "x", true) : left + 1;
                const [top, bottom] = [3, -3].map(times => plot.valToPos(ys[angle][k] + times * ys[sigma][k], "y", true));
                ctx.rect(left, top, Math.max(1, right - left), Math.max(1, bottom - top));
            }
            ctx.fill();
            ctx.restore();
        };
    }

    function options(panel, first, last, count) {
        const look = {
            stroke: () => css("--soft"), grid: {stroke: () => css("--grid"), width: 1}, ticks: {stroke: () => css("--grid"), width: 1},
            font: "11px system-ui, sans-serif", labelFont: "12px system-ui, sans-serif",
        };
        const stepped = uPlot.paths.stepped({align: 1}), linear = uPlot.paths.linear();
        const isEnum = panel.traces[0].row.kind === "enum";
        return {
            width: panel.host.clientWidth, height: height(count) + (last ? 38 : 0), legend: {show: false}, padding: [6, 18, 0, 0],
            scales: {x: {time: false, range: () => panel.x}, y: {range: () => panel.y}},
            axes: [
                {...look, size: last ? 24 : 6, values: last ? axisTicks : plot => [], label: last ? "time [s]" : undefined, labelSize: 18, labelGap: 3,
                 space: 70},
                {...look, size: 58, values: scaledTicks(panel), label: panel.label, labelSize: 16, labelGap: 0, space: 26,
                 ...isEnum ? {splits: () => panel.traces[0].row.choices.map((_, k) => k), label: undefined, font: "10px system-ui, sans-serif"} : {}},
            ],
            series: [{}, ...panel.traces.map(({row, index}) => ({
                stroke: () => traceColour(index), width: isReference(row) ? 1.6 : 1.4, dash: isReference(row) ? [7, 5] : undefined,
                points: {show: false}, spanGaps: false,
                paths: (plot, series, from, to) => (state.sparse ? stepped : linear)(plot, series, from, to),
            }))],
            cursor: {
                sync: {key: "scope"}, y: false, points: {show: false},
                drag: {x: true, y: false, dist: 6, setScale: false},
                bind: {dblclick: () => () => { state.zoom = null; state.dirty = true; }},
            },
            hooks: {
                setSelect: [plot => {
                    const {left, width} = plot.select;
                    if (width > 0) {
                        state.zoom = [plot.posToVal(left, "x"), plot.posToVal(left + width, "x")];
                        if (trigger.mode === "roll" && !state.kept) {
                            hold(true);
                        }
                        plot.setSelect({left: 0, width: 0, top: 0, height: 0}, false);
                        state.dirty = true;
                    }
                }],
                drawAxes: [drawBand(panel)],
                draw: [drawMarks(panel, first)],
            },
        };
    }

    function buildPanels() {
        for (const panel of panels) {
            panel.plot.destroy();
        }
        $("panels").textContent = "";
        const groups = group();
        const enums = groups.some(traces => traces[0].row.kind === "enum");
        panels = groups.map((traces, at) => {
            const host = make("div", {className: "panel"});
            const legend = make("div", {className: "legend"});
            const panel = {traces, host, legend, extent: [], x: [-1, 0], y: [0, 1], scale: 1, label: unitOf(traces[0].row), numbers: []};
            for (const {row, index} of traces) {
                const number = make("b", {textContent: "–"});
                panel.numbers.push(number);
                legend.append(make("span", {title: row.text}, swatch(index, row), row.name, number));
            }
            host.append(legend);
            $("panels").append(host);
            const all = options(panel, at === 0, at === groups.length - 1, groups.length);
            all.axes[1].size = (enums ? 110 : 74) - (all.axes[1].label === undefined ? 0 : all.axes[1].labelSize); // aligned
            panel.plot = new uPlot(all, [[], ...traces.map(() => [])], host);
            let down = null;
            panel.plot.over.addEventListener("pointerdown", event => { down = [event.clientX, event.clientY]; });
            panel.plot.over.addEventListener("click", event => {
                if (down && Math.hypot(event.clientX - down[0], event.clientY - down[1]) < 5 && event.detail < 2) {
                    setCursor(panel.plot.posToVal(event.clientX - panel.plot.over.getBoundingClientRect().left, "x"));
                }
            });
            return panel;
        });
        state.dirty = true;
    }

    /* Fits all panels into the window if there is space: the tools above them may need another line. */
    function fit() {
        const width = $("panels").clientWidth, tall = height(panels.length);
        panels.forEach((panel, at) => {
            const own = tall + (at === panels.length - 1 ? 38 : 0);
            if (panel.plot.width !== width || Math.abs(panel.plot.height - own) > 3) {
                panel.plot.setSize({width, height: own});
                state.dirty = true;
            }
        });
    }

    function setCursor(x) {
        state.cursors = state.cursors.length === 1 ? [state.cursors[0], x] : [x];
        state.dirty = true;
    }

    /* Draws the smallest and the largest value in each column of pixels, or the samples themselves if they are few. */
    function columnsOf(picture, axis, width) {
        const [begin, end] = axis.map(x => picture.zero + periods(x));
        const from = Math.max(picture.from, place(begin, picture) - 1), to = Math.min(picture.to, place(end, picture) + 1);
        const count = to - from;
        const signals = picture.columns.length;
        state.sparse = count <= 2 * width;
        if (state.sparse) {
            const x = [], ys = Array.from({length: signals}, () => []);
            let last = null;
            for (let k = from; k < to; k++) {
                const stamp = picture.stamps[k & picture.mask];
                if (last !== null && stamp - last > 1.5 * (picture.every || state.choice.every || 1)) {
                    x.push(seconds((stamp + last) / 2 - picture.zero));
                    ys.forEach(y => y.push(null));
                }
                x.push(seconds(stamp - picture.zero));
                ys.forEach((y, s) => y.push(picture.columns[s][k & picture.mask]));
                last = stamp;
            }
            return [x, ys];
        }
        const per = (end - begin) / width; // [periods] width of a column; the borders of the columns do not move while the picture rolls
        const first = Math.floor(begin / per), number = Math.floor(end / per) - first + 1;
        const least = Array.from({length: signals}, () => new Float64Array(number).fill(Infinity));
        const most = Array.from({length: signals}, () => new Float64Array(number).fill(-Infinity));
        for (let k = from; k < to; k++) {
            const at = k & picture.mask;
            const column = Math.floor(picture.stamps[at] / per) - first;
            if (column < 0 || column >= number) {
                continue;
            }
            for (let s = 0; s < signals; s++) {
                const y = picture.columns[s][at];
                if (y < least[s][column]) {
                    least[s][column] = y;
                }
                if (y > most[s][column]) {
                    most[s][column] = y;
                }
            }
        }
        const x = [], ys = Array.from({length: signals}, () => []);
        for (let column = 0; column < number; column++) {
            const at = seconds((column + first + 0.5) * per - picture.zero);
            x.push(at, at);
            for (let s = 0; s < signals; s++) {
                const there = least[s][column] <= most[s][column];
                ys[s].push(there ? least[s][column] : null, there ? most[s][column] : null);
            }
        }
        return [x, ys];
    }

    function extents(ys) {
        return ys.map(y => {
            let low = Infinity, high = -Infinity;
            for (const number of y) {
                if (number !== null && number < low) {
                    low = number;
                }
                if (number !== null && number > high) {
                    high = number;
                }
            }
            return [low, high];
        });
    }

    function draw() {
        requestAnimationFrame(draw);
        if (!state.dirty || !panels.length || document.hidden) {
            return;
        }
        state.dirty = false;
        const picture = trigger.picture();
        state.picture = picture;
        const axis = state.zoom || [seconds(picture.begin - picture.zero), seconds(picture.end - picture.zero)];
        const width = Math.max(100, Math.round(panels[0].plot.bbox.width / devicePixelRatio));
        const [x, ys] = columnsOf(picture, axis, width);
        const extent = extents(ys);
        for (const panel of panels) {
            panel.extent = extent;
            panel.x = axis;
            panel.y = niceRange(panel);
            const row = panel.traces[0].row;
            const [prefix, scale] = prefixOf(row, Math.max(Math.abs(panel.y[0]), Math.abs(panel.y[1])));
            panel.scale = scale;
            if (row.kind !== "enum") {
                panel.plot.axes[1].label = unitOf(row, prefix);
            }
            panel.plot.setData([x, ...panel.traces.map(trace => ys[trace.index])], true);
        }
        state.frames++;
        state.extent = extent;
        state.drawn = [x, ys];
        const show = !state.cursors.length;
        $("clear").hidden = show;
        $("all").hidden = !state.zoom;
    }

    /* ---- numbers beside the plots ---- */

    function sampleAt(x) { // the values at x [s of the axis], in displayed units
        const picture = state.picture;
        if (!picture || picture.to <= picture.from) {
            return null;
        }
        const k = Math.max(picture.from, place(picture.zero + periods(x) + 1e-6, picture) - 1);
        return picture.columns.map(column => column[k & picture.mask]);
    }

    function inShown(row, number) {
        if (number == null || !Number.isFinite(number)) {
            return "–";
        }
        return row.kind === "float" ? shown(row, number / row.factor) : shown(row, number);
    }

    /* Writes a value with the prefix of the panel's axis, and with a resolution of a thousandth of the axis. */
    function inPanel(panel, row, number) {
        if (row.kind !== "float" || !Number.isFinite(number)) {
            return inShown(row, number);
        }
        const size = Math.max(Math.abs(panel.y[0]), Math.abs(panel.y[1]));
        const [prefix, scale] = prefixOf(row, size);
        const places = Math.min(6, Math.max(0, 3 - Math.floor(Math.log10((panel.y[1] - panel.y[0]) * scale) + 1e-9)));
        return `${(number * scale).toFixed(places)} ${unitOf(row, prefix)}`.replace(/^-(0\.?0*) /, "$1 ").replace("-", "−").trim();
    }

    function showNumbers() {
        const hovered = panels.find(panel => panel.plot.cursor.left >= 0);
        const at = hovered ? hovered.plot.posToVal(hovered.plot.cursor.left, "x") : Infinity;
        const now = ring.total || trigger.record || state.kept ? sampleAt(Number.isFinite(at) ? at : 1e9) : null;
        for (const panel of panels) {
            panel.traces.forEach(({row, index}, k) => {
                panel.numbers[k].textContent = now ? inPanel(panel, row, now[index]) : "–";
            });
        }
        showCursors();
        const [word, kind] = trigger.word();
        $("armed").textContent = word;
        $("armed").className = `pill trig ${kind}`;
    }

    function showCursors() {
        const box = $("cursors");
        box.hidden = !state.cursors.length;
        if (box.hidden) {
            return;
        }
        const [a, b] = state.cursors;
        const both = b !== undefined;
        const first = sampleAt(a), second = both ? sampleAt(b) : null;
        const cell = (text, tag = "td") => make(tag, {textContent: text});
        const head = make("tr", {}, cell("", "th"), cell("A", "th"), ...both ? [cell("B", "th"), cell("B − A", "th")] : []);
        const times = make("tr", {}, cell("time", "th"), cell(time(a)), ...both
            ? [cell(time(b)), cell(`${time(b - a)}  (${b === a ? "–" : digits(1 / Math.abs(b - a), 4)} Hz)`)] : []);
        const lines = signalsShown().map((id, index) => {
            const row = rows.get(id);
            return make("tr", {}, cell(row.name, "th"), cell(first ? inShown(row, first[index]) : "–"), ...both
                ? [cell(inShown(row, second[index])), cell(row.kind === "enum" ? "" : inShown(row, second[index] - first[index]))] : []);
        });
        box.replaceChildren(make("table", {}, make("thead", {}, head), make("tbody", {}, times, ...lines)));
    }

    const TILES = [["omega_m", "speed"], ["i_q", "current i_q"], ["u_dc", "DC link"],
                   ["motor_heat", "motor heat"]];

    function showTiles() {
        const box = $("tiles");
        if (!box.childElementCount) {
            for (const [name, label] of TILES.filter(([each]) => named.has(each))) {
                box.append(make("div", {className: "tile", id: `tile_${name}`}, make("small", {textContent: label}),
                                make("b", {textContent: "–"}), make("i")));
            }
        }
        for (const [name] of TILES) {
            const tile = $(`tile_${name}`);
            const row = named.get(name), number = value(name);
            if (!tile || number === undefined) {
                continue;
            }
            const share = name === "motor_heat";
            const scaled = number * (share ? 100 : row.factor);
            tile.children[1].textContent = (Math.abs(scaled) < 0.005 ? "0.00"
                : scaled.toFixed(Math.abs(scaled) >= 1000 ? 0 : Math.abs(scaled) >= 100 ? 1 : 2)).replace("-", "−");
            tile.children[2].textContent = share ? "%" : unitOf(row);
        }
    }

    /* ---- state and reasons ---- */

    function reason(kind, sign, number, what) {
        const row = state.hello.reasons[number] || {name: `reason ${number}`, text: "", remedy: ""};
        return make("div", {className: `reason ${kind}`}, make("b", {textContent: `${sign} ${what}: ${row.name.replaceAll("_", " ")}`}),
                    make("span", {textContent: `${row.text}; ${row.remedy}`}));
    }

    function warningsNow() {
        const found = [];
        ["warnings", "warnings_2"].forEach((name, word) => {
            const bits = value(name) || 0;
            for (let bit = 0; bit < 32; bit++) {
                if (Math.floor(bits / 2 ** bit) % 2 === 1) {
                    found.push(state.hello.warning_bits[32 * word + bit]);
                }
            }
        });
        return found;
    }

    let reasonsShown = "";
    function showState() {
        const number = value("state"), row = named.get("state");
        const fault = value("fault_reason") || 0, refusal = value("refusal") || 0, warnings = warningsNow();
        const words = state.link ? [fault, refusal, value("fault_present"), ...warnings].join() : "no link";
        const name = row && number !== undefined ? row.choices[number] : "";
        document.body.dataset.state = name;
        $("state").textContent = state.link && name ? name.replaceAll("_", " ") : "unknown";
        $("state").className = `pill strong ${!state.link || fault ? "bad" : name === "operation_enabled" ? "good" : ""}`;
        const manoeuvre = named.get("manoeuvre");
        $("manoeuvre").textContent = state.link && manoeuvre && value("manoeuvre") !== undefined
            ? choiceName(manoeuvre, value("manoeuvre")) : "–";
        $("reset").hidden = !fault;
        if (words !== reasonsShown) {
            reasonsShown = words;
            const list = [];
            if (!state.link) {
                list.push(make("div", {className: "reason bad"}, make("b", {textContent: "✕ no link to the drive"}),
                               make("span", {textContent: state.why || "the scope tries to connect again"})));
            } else {
                if (fault) {
                    list.push(reason("bad", "✕", fault, "fault"));
                }
                if (refusal && refusal !== fault) {
                    list.push(reason("kind", "!", refusal, "refused"));
                }
                list.push(...warnings.map(each => reason("kind", "!", each, "warning")));
            }
            $("reasons").replaceChildren(...list);
            $("well").hidden = list.length > 0;
        }
    }

    function showLink(link, why) {
        const before = state.link;
        state.link = link;
        state.why = why;
        document.body.dataset.link = link ? "up" : "lost";
        $("link").textContent = link ? "linked" : "link lost";
        $("link").className = `pill ${link ? "good" : "bad"}`;
        if (before !== link) {
            reasonsShown = "";
        }
        if (before !== link || !link) {
            document.querySelectorAll(COMMANDS).forEach(each => { each.disabled = !link; });
        }
        showAge();
        if (!link && before && state.ran) {
            alarm("The link was lost while the motor was on. The drive stops after command_timeout; if it does not, switch its power off.");
        } else if (link && !before) {
            alarm("");
        }
    }

    /* The controls that have no effect without a link. STOP is none of them, because it reports whether it reached the drive. */
    const COMMANDS = "#speed button, #speed input, #requests select, #requests input, #params select, #params input, #staged button, " +
        ".orders button, #buffer select, #buffer input, #chosen button, #every, #find_signal, #plate button, #plate input";

    /* Shows the age of the displayed values, and whether they still agree with the drive. */
    function showAge() {
        const age = (performance.now() - state.heard) / 1000;
        const stale = state.heard !== undefined && (state.link === false || age > STALE);
        document.body.dataset.stale = stale;
        $("age").hidden = !stale;
        $("age").textContent = stale ? `values from ${Math.max(0, age).toFixed(0)} s ago` : "";
    }

    function alarm(text) {
        $("alarm").hidden = !text;
        $("alarm").textContent = text;
    }

    /* ---- asking ---- */

    async function ask(path, body, wait = 40000) {
        const ended = new AbortController();
        const timer = setTimeout(() => ended.abort(), wait);
        try {
            const answer = await fetch(path, {method: "POST", body, headers: {"X-Lagless": "1"}, signal: ended.signal, keepalive: true});
            return await answer.json();
        } catch (error) {
            return {ok: false, text: error.name === "AbortError" ? "no answer" : "the scope does not answer: check that `lagless scope` is running"};
        } finally {
            clearTimeout(timer);
        }
    }

    const set = (name, text) => ask("set", `${name} ${text}`);

    function say(place, answer, good) {
        place.textContent = answer.ok ? good : answer.text;
        place.className = `said ${answer.ok ? "good" : "bad"}`;
        clearTimeout(place.timer);
        if (answer.ok) {
            place.timer = setTimeout(() => { place.textContent = ""; }, 4000);
        }
    }

    async function stop() {
        $("stop").classList.add("sent");
        let answer = {ok: false, text: ""};
        for (let n = 0; n < STOP_TRIES && !answer.ok; n++) {
            answer = await ask("stop", "", STOP_WAIT);
        }
        $("stop").classList.remove("sent");
        alarm(answer.ok ? "" : `STOP did not reach the drive: ${answer.text}. Switch its power off.`);
        say($("said"), answer, answer.text);
    }

    /* The text that the user entered, with the unit next to the field. */
    const withUnit = (row, text) => /[a-zµΩ°%]/i.test(text.replace(/[0-9.]e[-+0-9]/i, "")) ? text.trim()
        : row.factor !== 1 ? `${text.trim().replace("−", "-")} ${row.shown}` : text.trim().replace("−", "-");

    async function takeSpeed() {
        const answer = await set("speed_request", withUnit(named.get("speed_request"), $("speed_value").value));
        if (!answer.ok) {
            say($("said"), answer, "");
        }
        return answer;
    }

    /* Waits until the condition is met or the time is over. */
    async function until(met, milliseconds) {
        const end = performance.now() + milliseconds;
        while (!met() && performance.now() < end) {
            await new Promise(done => setTimeout(done, 50));
        }
        return met();
    }

    const nameOf = number => (state.hello.reasons[number] || {name: `reason ${number}`}).name.replaceAll("_", " ");
    const choiceNow = name => named.get(name).choices[value(name)];

    /* The message depends on the state of the drive, not on the arrival of the request. */
    async function run() {
        if (!(await takeSpeed()).ok) {
            return;
        }
        const answer = await set("enable", "on");
        if (!answer.ok) {
            say($("said"), answer, "");
            return;
        }
        say($("said"), answer, "switching on");
        await until(() => choiceNow("state") === "operation_enabled" || value("fault_reason") || value("refusal"), START_WAIT);
        const why = value("fault_reason") ? `fault: ${nameOf(value("fault_reason"))}` : value("refusal") ? `refused: ${nameOf(value("refusal"))}`
            : `not on: the drive is ${(choiceNow("state") || "unknown").replaceAll("_", " ")}`;
        say($("said"), {ok: choiceNow("state") === "operation_enabled", text: why}, "switched on");
    }

    async function resetFault() {
        await set("enable", "off"); // a request to run from before the fault does not start the motor after it
        await set("fault_reset", "no");
        const answer = await set("fault_reset", "yes");
        const gone = answer.ok && await until(() => !value("fault_reason"), RESET_WAIT);
        const left = value("refusal") || value("fault_reason");
        say($("said"), answer.ok ? {ok: gone, text: `not reset: ${nameOf(left)}`} : answer, "reset");
    }

    /* ---- requests and parameters ---- */

    function entry(row, onSet) {
        if (row.kind === "enum") {
            const list = make("select", {ariaLabel: row.name}, ...row.choices.map(choice => make("option", {value: choice,
                textContent: choice.replaceAll("_", " ")})));
            list.onchange = () => onSet(list.value);
            list.show = number => {
                if (document.activeElement !== list) {
                    list.value = row.choices[number];
                }
            };
            return [list, list];
        }
        const field = make("input", {inputMode: "decimal", autocomplete: "off", ariaLabel: row.name});
        field.dataset.name = row.name;
        let seen = "", given = ""; // values received from the drive; values sent to it
        const give = () => {
            if (field.value.trim() === "") {
                field.value = seen;
            } else if (field.value !== seen && field.value !== given) {
                given = field.value;
                onSet(withUnit(row, field.value));
            }
        };
        field.onkeydown = event => {
            if (event.key === "Enter") {
                give();
            } else if (event.key === "Escape") {
                field.value = seen;
            }
        };
        field.onblur = give;
        field.show = number => {
            if (document.activeElement !== field) {
                seen = row.kind === "float" ? shortest(number * row.factor) : String(number);
                if (row.factor !== 1) {
                    seen = String(Number((number * row.factor).toPrecision(6)));
                }
                field.value = seen;
                given = "";
            }
        };
        return [make("span", {className: "entry"}, field, make("i", {textContent: unitOf(row)})), field];
    }

    const fields = new Map(); // id -> {field, box}

    function buildRequests() {
        const box = $("requests");
        box.textContent = "";
        for (const row of rows.values()) {
            if (row.table === "requests" && !["enable", "speed_request", "fault_reset"].includes(row.name)) {
                const [whole, field] = entry(row, async text => say($("said"), await set(row.name, text), `${row.name} is ${text}`));
                box.append(make("label", {title: row.text}, row.name, whole));
                fields.set(row.id, {field, row});
            }
        }
    }

    function rangeText(row) {
        if (row.kind === "enum") {
            return "";
        }
        const ends = [row.min, row.max].map(each => {
            const [prefix, factor] = prefixOf(row, Math.abs(each * row.factor));
            return [String(Number((each * row.factor * factor).toPrecision(6))).replaceAll("-", "−"),
                row.shown === "-" ? "" : ` ${unitOf(row, prefix)}`];
        });
        const [[least, unit], [most, last]] = ends;
        return `${least}${unit === last || least === "0" ? "" : unit} to ${most}${last}`;
    }

    async function stage(row, text, error) {
        const before = values.get(row.id);
        const answer = await set(row.name, text);
        error.textContent = answer.ok ? "" : answer.text;
        if (answer.ok && !state.undo.has(row.id)) {
            state.undo.set(row.id, before);
        }
        fields.get(row.id).box.classList.toggle("pending", answer.ok && state.undo.has(row.id));
        if (answer.ok) {
            $("staged").hidden = false;
        }
    }

    function buildParams() {
        const box = $("params");
        box.textContent = "";
        for (const row of rows.values()) {
            if (row.table !== "params") {
                continue;
            }
            const error = make("small", {className: "error"});
            const [whole, field] = entry(row, text => stage(row, text, error));
            const facts = [row.text, rangeText(row), row.access === "off" ? "changes only while the bridge is off" : ""];
            const each = make("div", {className: "param"}, make("span", {className: "name", textContent: row.name}), whole,
                              make("small", {textContent: facts.filter(text => text).join(" · ")}), error);
            each.dataset.name = row.name;
            box.append(each);
            fields.set(row.id, {field, row, box: each});
        }
        filterParams();
    }

    function differs(row) {
        const number = values.get(row.id);
        return number !== undefined && Math.fround(number) !== Math.fround(row.initial);
    }

    function filterParams() {
        const words = $("find_param").value.toLowerCase().split(/\s+/);
        const changed = $("changed").checked;
        let count = 0, all = 0;
        for (const {row, box} of fields.values()) {
            if (row.table === "params") {
                const text = `${row.name} ${row.text} ${row.shown}`.toLowerCase();
                box.hidden = !words.every(word => text.includes(word)) || (changed && !differs(row));
                count += !box.hidden;
                all++;
            }
        }
        $("param_count").textContent = count === all ? `${all}` : `${count} of ${all}`;
    }

    function showFields() {
        for (const {field, row, box} of fields.values()) {
            if (values.has(row.id)) {
                field.show(values.get(row.id));
                if (box) {
                    box.classList.toggle("differs", differs(row));
                }
            }
        }
    }

    async function order(name) {
        const answer = await ask("order", name);
        say($("param_said"), answer, {apply: "active", save: "saved in flash", load: "loaded", defaults: "the defaults are staged"}[name]);
        if (answer.ok) {
            unstage();
        }
    }

    function unstage() {
        state.undo.clear();
        for (const {box} of fields.values()) {
            if (box) {
                box.classList.remove("pending");
            }
        }
        $("staged").hidden = true;
    }

    async function undo() {
        for (const [id, number] of state.undo) {
            const row = rows.get(id);
            await set(row.name, row.kind === "enum" ? row.choices[number] : String(number));
        }
        unstage();
    }

    /* ---- choice of signals ---- */

    function choose(signals, every = state.choice.given ? state.choice.every : 0) {
        return ask("signals", [every, ...signals].join(" "));
    }

    function showChosen() {
        $("count").textContent = `${state.choice.signals.length} of ${state.hello.most}`;
        $("chosen").replaceChildren(...state.choice.signals.map((id, index) => {
            const row = rows.get(id);
            const away = make("button", {type: "button", textContent: "✕", title: `take ${row.name} away`});
            away.setAttribute("aria-label", `take ${row.name} away`);
            away.onclick = () => choose(state.choice.signals.filter(each => each !== id));
            return make("li", {title: row.text}, swatch(index, row), make("b", {textContent: row.name}), make("small", {textContent: row.text}), away);
        }));
        const source = $("source").value;
        $("source").replaceChildren(...state.choice.signals.map((id, index) => make("option", {value: index, textContent: rows.get(id).name})));
        $("source").value = state.choice.signals[Number(source)] !== undefined ? source : "0";
        $("every").value = state.choice.given ? state.choice.every : 0;
        const auto = $("every").options[0];
        auto.textContent = `as fast as the link allows${state.choice.given ? "" : `: ${everyText(state.choice.every)}`}`;
        readTrigger();
        findSignals();
    }

    function everyText(every) {
        return `${digits(1e3 * seconds(every), 3).replace(/\.?0+$/, "")} ms`;
    }

    function findSignals() {
        const text = $("find_signal").value.toLowerCase().trim();
        const wide = document.activeElement === $("find_signal");
        const found = !text && !wide ? [] : [...rows.values()].filter(row => row.table === "signals" &&
            !state.choice.signals.includes(row.id) && `${row.name} ${row.text} ${row.unit}`.toLowerCase().includes(text));
        const full = state.choice.signals.length >= state.hello.most;
        $("found").replaceChildren(...found.map(row => {
            const add = make("button", {type: "button", disabled: full}, make("b", {textContent: row.name}), ` ${unitOf(row)}`,
                             make("small", {textContent: full ? "eight signals are selected: remove one first" : row.text}));
            add.onmousedown = event => event.preventDefault(); // the field keeps the focus
            add.onclick = () => {
                $("find_signal").value = "";
                choose([...state.choice.signals, row.id]);
            };
            return make("li", {}, add);
        }));
    }

    function takeChoice(choice) {
        const same = state.choice && panels.length && choice.signals.join() === state.choice.signals.join();
        state.choice = choice;
        clearRing(choice.signals.length);
        trigger.arm();
        if (!same && !state.kept) {
            state.zoom = null;
            state.cursors = [];
            buildPanels();
        }
        showChosen();
    }

    /* ---- the drive's own buffer ---- */

    const captureSource = () => rows.get(Number($("capture_source").value));
    const decimal = field => Number(field.value.trim().replace("−", "-") || NaN);

    function showCaptureSettings() {
        $("buffer").dataset.on = $("capture_on").value;
        const row = captureSource();
        $("capture_level").nextElementSibling.textContent = row ? unitOf(row) : "";
    }

    /* The values in the drive, which another client may have set. */
    function takeCaptureSettings() {
        const at = state.hello.values;
        const of = name => at[named.get(name).id];
        $("capture_source").replaceChildren(...[...rows.values()].filter(row => row.table === "signals")
            .map(row => make("option", {value: row.id, textContent: row.name})));
        if (of("capture_on") !== undefined) {
            $("capture_on").value = named.get("capture_on").choices[of("capture_on")];
        }
        if (of("capture_source") !== undefined) {
            $("capture_source").value = of("capture_source");
        }
        showCaptureSettings();
    }

    function showCaptureState() {
        const row = named.get("capture_state"), number = value("capture_state");
        const name = row && number !== undefined ? row.choices[number] : "";
        $("capture_state").textContent = name || "–";
        $("capture_state").className = `pill ${name === "held" ? "good" : name === "armed" || name === "triggered" ? "kind" : ""}`;
        $("capture_show").disabled = name !== "held" || !state.link;
        $("capture_trigger").disabled = name !== "armed" || !state.link;
        $("capture_release").disabled = name === "idle" || !state.link;
    }

    const sayCapture = (answer, good) => say($("capture_said"), answer, good);

    /* Sends each value in turn, up to the first one that is refused. */
    async function armCapture() {
        const source = captureSource(), level = decimal($("capture_level")), after = decimal($("capture_after"));
        const signals = state.choice.signals;
        if (!Number.isFinite(level) || !Number.isFinite(after)) {
            sayCapture({ok: false, text: `${Number.isFinite(level) ? "and then" : "level"}: a number is needed`});
            return;
        }
        const wishes = [...signals.map((id, index) => [`capture_${index + 1}`, id]), ["capture_signals", signals.length],
                        ["capture_source", source.id], ["capture_level", level / source.factor],
                        ["capture_after", Math.round(periods(after / 1000))], ["capture_on", $("capture_on").value]];
        for (const [name, wish] of wishes) {
            const answer = await set(name, String(wish));
            if (!answer.ok) {
                sayCapture(answer);
                return;
            }
        }
        sayCapture(await ask("order", "capture_arm"), `armed: ${signals.length} signals`);
    }

    async function askCapture() {
        state.wantsKept = true;
        const answer = await ask("capture", "");
        if (!answer.ok) {
            state.wantsKept = false;
            sayCapture(answer);
        }
    }

    function takeCapture(data) {
        if (!state.wantsKept) {
            return; // another page has made the request
        }
        state.wantsKept = false;
        if (data.why) {
            sayCapture({ok: false, text: data.why});
            return;
        }
        const octets = Uint8Array.from(atob(data.d), letter => letter.charCodeAt(0));
        const slots = {
            float: new Float32Array(octets.buffer), uint: new Uint32Array(octets.buffer), int: new Int32Array(octets.buffer),
        };
        const count = data.signals.length, oldest = data.at + data.after - (data.periods - 1);
        const columns = data.signals.map((id, s) => {
            const row = rows.get(id), from = slots[row.kind === "enum" ? "int" : row.kind];
            return Float64Array.from({length: data.periods}, (_, n) => from[n * count + s] * row.factor);
        });
        const stamps = Float64Array.from({length: data.periods}, (_, n) => oldest + n);
        const end = oldest + data.periods - 1;
        showKept({signals: data.signals, picture: {stamps, columns, mask: -1, from: 0, to: data.periods, begin: oldest, end, zero: data.at,
                                                   every: 1}});
        $("from_drive").firstElementChild.textContent = `From the drive's buffer: ${count} signals, ${data.periods} periods, ` +
            `triggered in period ${data.at}`;
    }

    function showKept(kept) {
        state.kept = kept;
        state.zoom = null;
        state.cursors = [];
        $("from_drive").hidden = !kept;
        $("tools").hidden = Boolean(kept);
        buildPanels();
    }

    function readTrigger() {
        trigger.mode = $("mode").value;
        trigger.source = Number($("source").value) || 0;
        trigger.edge = $("edge").value;
        trigger.pre = Number($("pre").value);
        const level = Number($("level").value.replace("−", "-"));
        $("level").setCustomValidity(Number.isFinite(level) ? "" : "a number");
        trigger.level = Number.isFinite(level) ? level : trigger.level;
        $("view").dataset.mode = trigger.mode;
        const row = state.choice && rows.get(state.choice.signals[trigger.source]);
        $("level_unit").textContent = row ? unitOf(row) : "";
        if (state.held) {
            hold(false);
        }
        trigger.arm();
    }

    /* ---- commissioning ---- */

    const ANSWERS = {direction: [["as_said", "Forward"], ["reversed", "Backward"]], turn: [["one", "One turn"]]};

    /* The data of the motor from the drive's parameters, until the user enters others. */
    function offerPlate() {
        const current = value("motor_current_continuous") || 0.5 * value("current_limit");
        const given = {plate_pairs: value("motor_pole_pairs"), plate_current: current,
            plate_speed: value("overspeed_trip") / 1.4 * 30 / Math.PI};
        for (const [id, number] of Object.entries(given)) {
            if ($(id).value === "" && Number.isFinite(number)) {
                $(id).value = String(Number(number.toPrecision(3)));
            }
        }
    }

    async function beginCommissioning(event) {
        event.preventDefault();
        const number = id => Number($(id).value.trim().replace(",", ".").replace("−", "-") || NaN);
        const link = $("plate_link").value.trim() === "" ? 0 : number("plate_link");
        const steps = state.commission.steps.map(each => each.name).join(",");
        const answer = await ask("commission", [number("plate_pairs"), number("plate_current"), number("plate_speed") * Math.PI / 30, link,
            $("plate_free").checked ? 1 : 0, $("plate_resume").checked ? 1 : 0, steps].join(" "));
        say($("commission_said"), answer, "");
    }

    async function answerQuestion(text) {
        const answer = await ask("answer", text);
        say($("commission_said"), answer, "");
    }

    function showQuestion(data) {
        const box = $("commission_question");
        if (box.dataset.question === (data.question || "")) {
            return;
        }
        box.dataset.question = data.question || "";
        box.hidden = !data.question;
        if (box.hidden) {
            return;
        }
        box.querySelector("b").textContent = data.question_text;
        const buttons = ANSWERS[data.question].map(([name, text]) => make("button", {type: "button", className: "go", textContent: text,
            value: name, onclick: () => answerQuestion(name)}));
        if (data.question === "turn") {
            const count = make("input", {inputMode: "decimal", placeholder: "2", ariaLabel: "number of turns", autocomplete: "off"});
            buttons.push(make("span", {className: "entry"}, count, make("i", {textContent: "turns"})),
                make("button", {type: "button", textContent: "Answer", onclick: () => answerQuestion(count.value.trim())}));
        }
        buttons.push(make("button", {type: "button", textContent: "Not known", value: "unknown", onclick: () => answerQuestion("unknown")}));
        box.querySelector(".orders").replaceChildren(...buttons);
        box.scrollIntoView({block: "nearest"});
    }

    function showMeasured(data) {
        const table = $("commission_values"), measured = data.values || [];
        table.hidden = !measured.length;
        table.tBodies[0].replaceChildren(...measured.map(each => make("tr", {}, make("th", {textContent: each.name}),
            make("td", {textContent: `${digits(each.value, 4)} ${each.unit}`.trim()}),
            make("td", {textContent: each.error == null ? "" : digits(each.error, 2)}))));
    }

    function showEnd(data) {
        const said = $("commission_said");
        const good = data.done && !data.reason;
        if (data.done) {
            const turned = data.reversed ? " The shaft turned backward: exchange two wires of the motor, or reverse the sign of the speeds." : "";
            said.textContent = good ? `Commissioned in ${Math.round(data.seconds)} s; largest current ${digits(data.largest, 3)} A.${data.known
                ? " The parameters that follow are active; Save stores them." : ""}${turned}` : `${data.reason}: ${data.what}`;
            said.className = `said ${good ? "good" : "bad"}`;
        }
        const file = $("commission_file");
        file.hidden = !data.done || !(data.values || []).length;
        if (!file.hidden) {
            URL.revokeObjectURL(file.href);
            file.href = URL.createObjectURL(new Blob([data.file], {type: "application/toml"}));
        }
    }

    function takeCommission(data) {
        const begun = data.running || data.done;
        const now = data.steps[data.step];
        state.commission = data;
        $("commission").dataset.running = data.running;
        $("commission_state").textContent = data.running ? "works" : data.done ? data.reason ? "ended" : "done" : "not begun";
        $("commission_state").className = `pill ${data.running ? "kind" : data.done ? data.reason ? "bad" : "good" : ""}`;
        $("commission_steps").replaceChildren(...(begun ? data.steps : []).map(each => make("li", {
            className: each.ended ? "ended" : each === now ? data.running ? "now" : "failed" : "", title: each.text,
        }, each.name.replaceAll("_", " "))));
        $("commission_now").hidden = !data.running;
        if (data.running) {
            const left = now ? Math.max(0, now.limit - data.elapsed) : 0;
            $("commission_now").textContent = now ? `${now.text} At most ${Math.ceil(left)} s are left${data.tries > 1
                ? ` of try ${data.tries}` : ""}.` : "The parameters are read.";
        }
        showQuestion(data);
        showMeasured(data);
        showEnd(data);
    }

    /* ---- events ---- */

    function hello(data) {
        state.hello = data;
        rows.clear();
        named.clear();
        values.clear();
        fields.clear();
        for (const row of data.rows) {
            rows.set(row.id, row);
            named.set(row.name, row);
        }
        $("target").textContent = data.target;
        $("epk").textContent = `tables ${data.epk}`;
        document.title = `lagless scope · ${data.target}`;
        buildRequests();
        buildParams();
        takeValues(data.values);
        takeChoice({g: data.g, every: data.every, given: data.given, signals: data.signals});
        takeCaptureSettings();
        takeCommission(data.commission);
        takeLine(data);
        offerSpeed();
        offerPlate();
    }

    /* A speed that this motor certainly reaches: half of the largest speed below its overspeed trip, rounded down, at most 500 r/min. */
    function offerSpeed() {
        const trip = value("overspeed_trip");
        if ($("speed_value").value === "" && trip !== undefined) {
            const half = Math.min(500, 0.5 * trip * named.get("overspeed_trip").factor / 1.4);
            const step = 10 ** Math.floor(Math.log10(half));
            $("speed_value").value = shortest(Math.floor(half / step) * step);
        }
    }

    function takeValues(news) {
        for (const [id, number] of Object.entries(news)) {
            values.set(Number(id), number);
        }
        state.ran = value("enable") === 1;
        if (state.hello) {
            offerSpeed();
            offerPlate();
        }
        $("dither").hidden = !(value("inductance_adaptation") && state.choice && state.choice.signals.some(id => rows.get(id).name.startsWith("i_d")));
        showFields();
    }

    function takeLine(data) {
        state.heard = performance.now() - 1000 * data.age;
        showLink(data.link, data.why);
        $("staged").hidden = !data.staged && !state.undo.size;
        state.line = data;
        showState();
        showCaptureState();
        showTiles();
    }

    let pace = {frames: 0, at: performance.now(), samples: 0};
    function showRate() {
        const now = performance.now();
        const rate = 1000 * (state.frames - pace.frames) / (now - pace.at);
        const line = state.line || {samples: 0, missing: 0};
        const samples = 1000 * (line.samples - pace.samples) / (now - pace.at);
        pace = {frames: state.frames, at: now, samples: line.samples};
        state.rate = rate;
        $("rate").textContent = `${rate.toFixed(0)} fps · ${Math.max(0, samples / 1000).toFixed(1)} k samples/s` +
            (line.missing ? ` · ${line.missing} missing` : "");
    }

    function listen() {
        const source = new EventSource("events");
        const on = (name, action) => source.addEventListener(name, event => action(JSON.parse(event.data)));
        on("hello", hello);
        on("samples", take);
        on("choice", takeChoice);
        on("capture", takeCapture);
        on("commission", takeCommission);
        on("state", data => {
            takeValues(data.values);
            takeLine(data);
        });
        source.addEventListener("taken", () => {
            source.close();
            showLink(false, "another window shows this drive now; reload this page to continue here");
            showState();
        });
        source.onerror = () => {
            if (state.hello) {
                showLink(false, "the program `lagless scope` has ended or does not answer; start it again");
                showState();
            }
        };
    }

    function begin() {
        $("window").append(...WINDOWS.map(each => make("option", {value: each, textContent: each < 1 ? `${each * 1000} ms` : `${each} s`})));
        $("window").value = "2";
        $("every").append(...SAMPLING.map(each => make("option", {value: each, textContent: each === 0 ? "as fast as the link allows" : everyText(each)})));
        $("stop").onclick = stop;
        $("run").onclick = run;
        $("off").onclick = async () => say($("said"), await set("enable", "off"), "off: the motor coasts");
        $("reset").onclick = resetFault;
        $("speed").onsubmit = async event => {
            event.preventDefault();
            const answer = await takeSpeed();
            say($("said"), answer, `speed request is ${$("speed_value").value} r/min`);
        };
        $("hold").onclick = () => hold(!state.held);
        $("all").onclick = () => { state.zoom = null; state.dirty = true; };
        $("clear").onclick = () => { state.cursors = []; state.dirty = true; };
        $("window").onchange = () => { state.zoom = null; state.cursors = []; trigger.arm(); };
        for (const id of ["mode", "source", "edge", "level", "pre"]) {
            $(id).onchange = readTrigger;
        }
        $("every").onchange = () => choose(state.choice.signals, Number($("every").value));
        $("find_signal").oninput = $("find_signal").onfocus = $("find_signal").onblur = findSignals;
        $("find_param").oninput = $("changed").onchange = filterParams;
        $("apply").onclick = () => order("apply");
        $("undo").onclick = undo;
        $("capture_on").onchange = $("capture_source").onchange = showCaptureSettings;
        $("capture_arm").onclick = armCapture;
        $("capture_trigger").onclick = async () => sayCapture(await ask("order", "capture_trigger"), "triggered");
        $("capture_release").onclick = async () => sayCapture(await ask("order", "capture_release"), "released");
        $("capture_show").onclick = askCapture;
        $("plate").onsubmit = beginCommissioning;
        $("live").onclick = () => showKept(null);
        document.querySelectorAll("[data-order]").forEach(each => { each.onclick = () => order(each.dataset.order); });
        addEventListener("keydown", event => {
            const typing = /INPUT|SELECT|TEXTAREA/.test(event.target.tagName);
            if (event.key === "Escape" && !typing) {
                stop();
            } else if (event.key === " " && !typing && event.target.tagName !== "BUTTON" && event.target.tagName !== "SUMMARY") {
                event.preventDefault();
                hold(!state.held);
            }
        });
        new ResizeObserver(() => requestAnimationFrame(fit)).observe($("panels"));
        addEventListener("resize", fit);
        matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { state.dirty = true; });
        setInterval(() => { showNumbers(); fit(); }, 100);
        setInterval(showRate, 1000);
        setInterval(showAge, 500);
        requestAnimationFrame(draw);
        listen();
    }

    begin();
    return {state, trigger, ring, rows, named, values, value, panels: () => panels};
})();
