/* The plots to zoom into. Each .plots holds the JSON of one layout, written by page.py: panels over one axis, and the
   columns packed as pack() there says. Its panels are drawn when it comes near the viewport; all layouts of a figure
   share the zoom. uPlot draws least and largest of each pixel's column where there are more points than pixels. */
"use strict";
(() => {
    const LEAST_SPAN = 6; // [steps of the axis] zoomed in no further: single periods are then far apart
    const NEAR = 40; // [steps of the axis] a button for it
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
            const x = Math.round(plot.valToPos(event.time, "x", true)) + 0.5;
            if (x < bbox.left || x > bbox.left + bbox.width) {
                continue;
            }
            ctx.beginPath();
            ctx.moveTo(x, bbox.top);
            ctx.lineTo(x, bbox.top + bbox.height);
            ctx.stroke();
            const end = x + 5 * ratio + ctx.measureText(event.text).width;
            if (top && x >= free && end < bbox.left + bbox.width) {
                ctx.fillText(event.text, x + 4 * ratio, bbox.top - 4 * ratio);
                free = end + 4 * ratio;
            }
        }
        ctx.restore();
    }

    function decimal(number, exponent) {
        return number.toFixed(Math.max(0, -exponent)).replace("-", "−");
    }

    function value(column) {
        const unit = column.unit === "-" ? "" : " " + column.unit;
        return (_, number) => number == null ? "–" : decimal(number, column.exponent) + unit;
    }

    /* As many digits as the distance of the ticks asks for, however far one has zoomed in. */
    function ticks(_, splits, axis, space, distance) {
        let exponent = Math.floor(Math.log10(distance) + 1e-9);
        if (Math.abs(distance / 10 ** exponent - Math.round(distance / 10 ** exponent)) > 1e-6) {
            exponent -= 1; // 2.5
        }
        return splits.map(number => decimal(number, exponent));
    }

    function line(trace, layout) {
        const black = /^#000(000)?$/.test(trace.colour); // must stay visible on a dark page
        return {
            label: trace.label, stroke: () => black ? colour("--ink") : trace.colour, width: trace.dashed ? 1.5 : 1.2,
            dash: trace.dashed ? [6, 4] : undefined, value: value(layout.columns[trace.column]), points: {size: 5},
        };
    }

    function panelOptions(host, layout, figure, index) {
        const panel = layout.panels[index];
        const last = index === layout.panels.length - 1;
        const linear = log => log ? {} : {values: ticks};
        const look = {
            stroke: () => colour("--ink"), grid: {stroke: () => colour("--grid"), width: 1},
            ticks: {stroke: () => colour("--grid"), width: 1}, font: "12px system-ui, sans-serif",
            labelFont: "12px system-ui, sans-serif",
        };
        return {
            width: host.clientWidth - 2, height: Math.round((last ? 60 : 38) + 150 * panel.height),
            title: panel.title || undefined,
            padding: [layout.events.length && index === 0 ? 18 : 8, 14, 0, 0],
            scales: {x: {time: false, distr: layout.log ? 3 : 1, range: (_, min, max) => [min, max]},
                     y: {distr: panel.log_y ? 3 : 1}},
            axes: [{...look, ...linear(layout.log), label: last ? layout.xlabel : undefined, labelSize: 20, size: 30},
                   {...look, ...linear(panel.log_y), label: panel.ylabel, labelSize: 18, size: 58}],
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
                draw: [plot => drawEvents(plot, layout, index === 0)],
            },
        };
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
            for (const event of layout.events) {
                button(`${event.time} s: ${event.text}`, "zoom to this event",
                       () => zoom(figure, event.time - 0.02 * length, event.time + 0.08 * length));
            }
            button(`${NEAR} points`, "so near that each line of the CSV is a point", () => {
                const middle = (figure.view[0] + figure.view[1]) / 2;
                zoom(figure, middle - NEAR / 2 * figure.step, middle + NEAR / 2 * figure.step);
            });
        }
        const hint = document.createElement("span");
        hint.className = "hint";
        hint.textContent = "drag to zoom, double click to see all, click a name to hide it";
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
                const plot = new uPlot(panelOptions(host, layout, figure, index), data, host);
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
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () =>
        figures.forEach(figure => figure.plots.forEach(plot => plot.redraw())));
    addEventListener("beforeprint", () => document.querySelectorAll("details").forEach(each => { each.open = true; }));
})();
