/* Draws the plots with zoom. Each element .plots contains the JSON of one layout, written by page.py: panels over one axis, and the columns in
 * the format of pack() in page.py. Its panels are drawn when it comes near the viewport; all layouts of a figure
   share the zoom. If there are more points than pixels, uPlot draws the smallest and the largest value in each column of pixels. */
"use strict";
(() => {
    const LEAST_SPAN = 6; // [steps of the axis] zoomed in no further: single periods are then far apart
    const NEAR = 40; // [steps of the axis] a button for it
    const LIMIT_NEAR = 0.4; // of a limit: what comes so far brings it onto the axis
    const BAND = 22; // [px] a line of a panel of bands
    const LABEL = 58; // [px] room for the numbers of an axis, at least
    const TURN = 8; // [px] width of a turn whose wraps are gaps; a gap takes about 3 px
    const BUTTONS = 16; // events with a button, at most
    const TINTS = [[0, 114, 178], [213, 94, 0], [0, 158, 115], [204, 121, 167], [86, 180, 233], [230, 159, 0], [119, 119, 119]];
    const LIGHTER = {"#0072B2": "#4FA8E0", "#009E73": "#2FC49A", "#777777": "#9AA4AF", "#B3261E": "#FF938A"}; // on a dark page
    const dark = matchMedia("(prefers-color-scheme: dark)");
    const figures = new Map(); // id -> {plots, full, view, ...}: what its layouts share
    const colour = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

    async function unpack(layout) {
        const text = atob(layout.data);
        const octets = Uint8Array.from(text, letter => letter.charCodeAt(0));
        const stream = new Blob([octets]).stream().pipeThrough(new DecompressionStream("gzip"));
        const planes = new Uint8Array(await new Response(stream).arrayBuffer());
        const count = layout.x.count;
        const result = {};
        for (const [name, column] of Object.entries(layout.columns)) {
            const [low, mid, high, top] = [0, 1, 2, 3].map(k => (4 * column.index + k) * count);
            const scale = 10 ** Math.abs(column.exponent);
            const values = new Array(count);
            for (let i = 0, code = 0; i < count; i++) {
                const folded = planes[low + i] | planes[mid + i] << 8 | planes[high + i] << 16 | planes[top + i] << 24;
                code += folded >>> 1 ^ -(folded & 1);
                const multiple = column.base + code - 1;
                values[i] = code === 0 ? null : column.exponent < 0 ? multiple / scale : multiple * scale;
            }
            result[name] = values;
        }
        return result;
    }

    function axis(layout) {
        const {start, step, count, values} = layout.x;
        return values || Float64Array.from({length: count}, (_, i) => Number((start + i * step).toPrecision(12)));
    }

    function zoom(figure, min, max) {
        const [first, last] = figure.full;
        const least = figure.log ? 0 : Math.min(LEAST_SPAN * figure.step, last - first);
        if (max - min < least) {
            const middle = (min + max) / 2;
            [min, max] = [middle - least / 2, middle + least / 2];
        }
        const span = max - min;
        if (min < first) {
            [min, max] = [first, Math.min(first + span, last)];
        } else if (max > last) {
            [min, max] = [Math.max(last - span, first), last];
        }
        figure.view = [min, max];
        for (const plot of figure.plots) {
            if (plot.scales.x.min !== min || plot.scales.x.max !== max) {
                plot.setScale("x", {min, max});
            }
        }
    }

    function drawEvents(plot, layout, top) {
        const {ctx, bbox} = plot;
        const ratio = devicePixelRatio;
        ctx.save();
        ctx.font = `${11 * ratio}px ${getComputedStyle(document.body).fontFamily}`;
        ctx.strokeStyle = ctx.fillStyle = colour("--soft");
        ctx.lineWidth = ratio;
        ctx.setLineDash([2 * ratio, 3 * ratio]);
        ctx.textAlign = "left";
        ctx.textBaseline = "alphabetic";
        let free = bbox.left;
        for (const event of layout.events) {
            ctx.strokeStyle = ctx.fillStyle = colour(event.kind === "fault" ? "--bad" : "--soft");
            const x = Math.round(plot.valToPos(event.time, "x", true)) + 0.5;
            if (x < bbox.left || x > bbox.left + bbox.width) {
                continue;
            }
            ctx.beginPath();
            ctx.moveTo(x, bbox.top);
            ctx.lineTo(x, bbox.top + bbox.height);
            ctx.stroke();
            const end = x + 5 * ratio + ctx.measureText(event.text).width;
            if (top && event.kind !== "manoeuvre" && x >= free && end < bbox.left + bbox.width) {
                ctx.fillText(event.text, x + 4 * ratio, bbox.top - 4 * ratio);
                free = end + 4 * ratio;
            }
        }
        ctx.restore();
    }

    /* Begin, end (index behind the last) and value of each stretch of equal values. */
    function stretches(values) {
        const found = [];
        for (let i = 1, begin = 0; i <= values.length; i++) {
            if (i === values.length || values[i] !== values[begin]) {
                found.push([begin, i, values[begin]]);
                begin = i;
            }
        }
        return found;
    }

    function nameOf(trace, number) {
        const value = Math.round(number);
        if (!trace.names) {
            return String(value);
        }
        if (trace.names.bits) {
            const bits = Array.from({length: 32}, (_, bit) => bit).filter(bit => Math.floor(value / 2 ** bit) % 2);
            return bits.map(bit => trace.names.bits[bit] || `bit ${bit}`).join(", ") || "none";
        }
        return trace.names[value] || String(value);
    }

    /* `none` has no colour, a fault has the colour of faults. */
    function tint(trace, value) {
        const name = nameOf(trace, value);
        if (value === 0 || name === "none") {
            return null;
        }
        const wrong = /^(fault|warning)/.test(trace.column.replace(/^[AB]\./, "")) || name === "fault";
        return wrong ? "rgba(200, 30, 30, 0.38)" : `rgba(${TINTS[value % TINTS.length]}, 0.3)`;
    }

    function drawBands(plot, panel, found) {
        const {ctx, bbox} = plot;
        const ratio = devicePixelRatio;
        const high = bbox.height / panel.traces.length;
        const x = plot.data[0];
        const place = k => Math.min(Math.max(plot.valToPos(x[Math.min(k, x.length - 1)], "x", true), bbox.left), bbox.left + bbox.width);
        ctx.save();
        ctx.font = `${11 * ratio}px ${getComputedStyle(document.body).fontFamily}`;
        ctx.textAlign = "left";
        ctx.textBaseline = "middle";
        panel.traces.forEach((trace, row) => {
            const top = bbox.top + row * high;
            if (!plot.series[row + 1].show) {
                return;
            }
            for (const [begin, end, value] of found[row]) {
                const [from, to] = [place(begin), place(end)];
                if (value == null || to - from < 0.5 * ratio) {
                    continue;
                }
                const fill = tint(trace, value);
                if (fill) {
                    ctx.fillStyle = fill;
                    ctx.fillRect(from, top + ratio, to - from, high - 2 * ratio);
                }
                ctx.fillStyle = colour("--ink");
                if (begin > 0 && from > bbox.left) {
                    ctx.fillRect(from, top + ratio, ratio, high - 2 * ratio);
                }
                const text = nameOf(trace, value);
                ctx.fillStyle = colour(fill ? "--ink" : "--soft");
                if (ctx.measureText(text).width + 8 * ratio < to - from) {
                    ctx.fillText(text, from + 4 * ratio, top + high / 2);
                }
            }
        });
        ctx.restore();
    }

    /* Draws a text above the right corner of the panel. */
    function drawNote(plot, text) {
        const {ctx, bbox} = plot;
        const ratio = devicePixelRatio;
        ctx.save();
        ctx.font = `${11 * ratio}px ${getComputedStyle(document.body).fontFamily}`;
        ctx.textAlign = "right";
        ctx.textBaseline = "alphabetic";
        ctx.fillStyle = colour("--soft");
        ctx.fillText(text, bbox.left + bbox.width, bbox.top - 4 * ratio, bbox.width);
        ctx.restore();
    }

    /* The axis of a panel with limits, or with a fixed range while the whole time is shown. */
    function reach(panel, figure) {
        return (plot, min, max) => {
            const [first, last] = figure.full;
            if (panel.range && figure.view[0] === first && figure.view[1] === last) {
                return panel.range;
            }
            if (min == null) {
                return [0, 1];
            }
            const far = Math.max(Math.abs(min), Math.abs(max)) / LIMIT_NEAR;
            panel.traces.forEach((trace, k) => {
                const {show, idxs} = plot.series[k + 1];
                for (let i = idxs[0]; trace.limit && show && i <= idxs[1]; i++) {
                    const value = plot.data[k + 1][i];
                    if (value != null && Math.abs(value) <= far) {
                        [min, max] = [Math.min(min, value), Math.max(max, value)];
                    }
                }
            });
            return uPlot.rangeNum(min, max, 0.1, true);
        };
    }

    /* There is no line where an angle wraps. Turns of less than TURN pixels keep their lines, because gaps would hide them. */
    const turns = half => (plot, k, from, to, gaps) => {
        const values = plot.data[k];
        const wraps = [];
        for (let i = from + 1; i <= to; i++) {
            if (values[i] != null && values[i - 1] != null && Math.abs(values[i] - values[i - 1]) > half) {
                wraps.push([i - 1, i].map((at, end) => Math.round(plot.valToPos(plot.data[0][at], "x", true)) + 2 * end - 1));
            }
        }
        const near = (a, b) => a && b && Math.abs(a[0] - b[0]) < TURN * devicePixelRatio;
        gaps.push(...wraps.filter((wrap, n) => !near(wrap, wraps[n - 1]) && !near(wrap, wraps[n + 1])));
        return gaps.sort((a, b) => a[0] - b[0]);
    };

    function decimal(number, exponent) {
        return number.toFixed(Math.max(0, -exponent)).replace("-", "−");
    }

    function value(column) {
        const unit = column.unit === "-" ? "" : " " + column.unit;
        return (_, number) => number == null ? "–" : decimal(number, column.exponent) + unit;
    }

    /* The number of digits follows from the distance of the ticks at any zoom. */
    function ticks(_, splits, axis, space, distance) {
        let exponent = Math.floor(Math.log10(distance) + 1e-9);
        if (Math.abs(distance / 10 ** exponent - Math.round(distance / 10 ** exponent)) > 1e-6) {
            exponent -= 1; // 2.5
        }
        return splits.map(number => decimal(number, exponent));
    }

    function line(trace, layout) {
        const black = /^#000(000)?$/.test(trace.colour);
        return {
            label: trace.label, stroke: () => black ? colour("--ink") : dark.matches && LIGHTER[trace.colour] || trace.colour, width: trace.dashed ? 1.5 : 1.2,
            dash: trace.dashed ? [6, 4] : undefined, value: value(layout.columns[trace.column]), points: {size: 5},
            auto: !trace.limit, ...(trace.wraps ? {gaps: turns(trace.wraps)} : {}),
        };
    }

    /* A trace in a panel of bands is no line; the legend shows the name of the band at the cursor. */
    function band(trace) {
        return {
            label: trace.label, stroke: trace.colour, paths: () => null, points: {show: false},
            value: (_, number) => number == null ? "–" : nameOf(trace, number),
        };
    }

    function bandsOptions(layout, panel, found, options) {
        const count = panel.traces.length;
        const font = "11px system-ui, sans-serif";
        return {
            ...options, class: "bands", height: BAND * count + options.padding[0] + 6,
            scales: {...options.scales, y: {range: () => [0, count]}},
            axes: [{...options.axes[0], show: false, size: 0},
                   {...options.axes[1], label: undefined, labelSize: 0, size: layout.label + 18, font, gap: 4, grid: {show: false}, ticks: {show: false},
                    splits: () => panel.traces.map((_, k) => count - k - 0.5), values: () => panel.traces.map(trace => trace.label)}],
            series: [options.series[0], ...panel.traces.map(band)],
            hooks: {...options.hooks, draw: [plot => drawBands(plot, panel, found), ...options.hooks.draw]},
        };
    }

    /* Width for the longest name of a band, so that all panels have the same left edge. */
    function labelRoom(layout) {
        const ctx = document.createElement("canvas").getContext("2d");
        ctx.font = "11px system-ui, sans-serif";
        const names = layout.panels.filter(panel => panel.kind === "bands").flatMap(panel => panel.traces.map(trace => trace.label));
        return Math.max(LABEL, ...names.map(name => Math.ceil(ctx.measureText(name).width) + 8 - 18));
    }

    function panelOptions(host, layout, figure, index, data) {
        const panel = layout.panels[index];
        const last = index === layout.panels.length - 1;
        const linear = log => log ? {} : {values: ticks};
        const look = {
            stroke: () => colour("--ink"), grid: {stroke: () => colour("--grid"), width: 1},
            ticks: {stroke: () => colour("--grid"), width: 1}, font: "12px system-ui, sans-serif",
            labelFont: "12px system-ui, sans-serif",
        };
        const ranged = panel.range || panel.traces.some(trace => trace.limit);
        const options = {
            width: host.clientWidth - 2, height: Math.round((last ? 60 : 38) + 150 * panel.height),
            title: panel.title || undefined,
            padding: [panel.note || (layout.events.length && index === 0) ? 18 : 8, layout.log ? 26 : 14, 0, 0], // half of "10,000"
            scales: {x: {time: false, distr: layout.log ? 3 : 1, range: (_, min, max) => [min, max]},
                     y: {distr: panel.log_y ? 3 : 1, ...(ranged ? {range: reach(panel, figure)} : {})}},
            axes: [{...look, ...linear(layout.log), label: last ? layout.xlabel : undefined, labelSize: 20, size: 30},
                   {...look, ...linear(panel.log_y), label: panel.ylabel, labelSize: 18, size: layout.label}],
            series: [{label: layout.xlabel.replace(/ *\[.*/, ""),
                      value: value({unit: layout.x_unit, exponent: figure.exponent})},
                     ...panel.traces.map(trace => line(trace, layout))],
            cursor: {
                sync: {key: figure.id, filters: {pub: type => type === "mousemove" || type === "mouseleave"}},
                drag: {x: true, y: false, dist: 5, setScale: false}, // zoom() alone sets the axis, that of all panels
                bind: {dblclick: () => () => zoom(figure, ...figure.full)},
            },
            hooks: {
                setSelect: [plot => {
                    const {left, width} = plot.select;
                    if (width > 0) {
                        zoom(figure, plot.posToVal(left, "x"), plot.posToVal(left + width, "x"));
                        plot.setSelect({left: 0, width: 0}, false);
                    }
                }],
                drawClear: [plot => {
                    if (panel.kind === "error" && plot.scales.y.min < 0 && plot.scales.y.max > 0) {
                        const y = Math.round(plot.valToPos(0, "y", true)) + 0.5;
                        plot.ctx.fillStyle = colour("--soft");
                        plot.ctx.fillRect(plot.bbox.left, y - 0.5, plot.bbox.width, devicePixelRatio);
                    }
                }],
                draw: [plot => drawEvents(plot, layout, index === 0), ...(panel.note ? [plot => drawNote(plot, panel.note)] : [])],
            },
        };
        return panel.kind === "bands" ? bandsOptions(layout, panel, data.slice(1).map(stretches), options) : options;
    }

    function tools(layout, figure) {
        const bar = document.createElement("div");
        bar.className = "tools";
        const button = (text, title, action) => {
            const made = document.createElement("button");
            Object.assign(made, {type: "button", textContent: text, title, onclick: action});
            bar.append(made);
        };
        const towards = (shift, factor) => () => {
            const [min, max] = figure.view;
            const middle = (min + max) / 2 + shift * (max - min);
            const half = factor * (max - min) / 2;
            zoom(figure, middle - half, middle + half);
        };
        button("all", "show the whole axis", () => zoom(figure, ...figure.full));
        if (!figure.log) {
            button("+", "zoom in", towards(0, 0.5));
            button("−", "zoom out", towards(0, 2));
            button("◂", "to the left", towards(-0.5, 1));
            button("▸", "to the right", towards(0.5, 1));
            const length = figure.full[1] - figure.full[0];
            const manoeuvres = layout.events.length <= BUTTONS;
            for (const event of layout.events.filter(({kind}) => manoeuvres || kind !== "manoeuvre").slice(0, BUTTONS)) {
                button(`${event.time} s: ${event.text}`, "zoom to this event",
                       () => zoom(figure, event.time - 0.02 * length, event.time + 0.08 * length));
            }
            button(`zoom to ${NEAR} samples`, "zoom in until each line of the CSV is a visible point", () => {
                const middle = (figure.view[0] + figure.view[1]) / 2;
                zoom(figure, middle - NEAR / 2 * figure.step, middle + NEAR / 2 * figure.step);
            });
        }
        const hint = document.createElement("span");
        hint.className = "hint";
        hint.textContent = "Drag to zoom, double-click to show everything, click a name to hide its line.";
        bar.append(hint);
        return bar;
    }

    async function draw(host) {
        if (host.dataset.state) {
            return;
        }
        host.dataset.state = "drawing";
        try {
            const layout = JSON.parse(host.querySelector("script").textContent);
            const columns = await unpack(layout);
            layout.label = labelRoom(layout);
            const x = axis(layout);
            const step = layout.x.step || 0;
            const id = host.dataset.figure + layout.x_unit;
            const full = [x[0], x[x.length - 1]];
            if (!figures.has(id)) {
                figures.set(id, {id, plots: [], full, view: full, step, log: layout.log,
                                 exponent: step ? Math.floor(Math.log10(step) + 1e-9) : -3});
            }
            const figure = figures.get(id);
            host.querySelector(".draw").remove();
            if (layout.title) {
                host.append(Object.assign(document.createElement("h3"), {textContent: layout.title}));
            }
            host.append(tools(layout, figure));
            host.plots = layout.panels.map((panel, index) => {
                const data = [x, ...panel.traces.map(trace => columns[trace.column])];
                const plot = new uPlot(panelOptions(host, layout, figure, index, data), data, host);
                figure.plots.push(plot);
                return plot;
            });
            zoom(figure, ...figure.view);
            new ResizeObserver(() => requestAnimationFrame(() => {
                const width = host.clientWidth - 2;
                const stale = host.plots.filter(plot => plot.width !== width);
                stale.forEach(plot => plot.setSize({width, height: plot.height}));
            })).observe(host);
            host.dataset.state = "ready";
        } catch (error) {
            host.dataset.state = "failed";
            const text = document.createElement("p");
            text.className = "failed";
            text.textContent = `The plots cannot be drawn here (${error.message}); the picture above shows the same.`;
            host.append(text);
            console.error(error);
        }
    }

    const near = new IntersectionObserver(
        seen => seen.filter(each => each.isIntersecting).forEach(each => draw(each.target)), {rootMargin: "300px"});
    for (const host of document.querySelectorAll(".plots")) {
        near.observe(host);
        host.querySelector(".draw").onclick = () => draw(host);
    }
    dark.addEventListener("change", () =>
        figures.forEach(figure => figure.plots.forEach(plot => plot.redraw())));
    addEventListener("beforeprint", () => document.querySelectorAll("details").forEach(each => { each.open = true; }));
})();
