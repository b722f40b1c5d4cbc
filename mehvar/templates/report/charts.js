// SPDX-License-Identifier: Apache-2.0
// Charts of the figures: uPlot with the page's colours, one zoom for all panels over the same time.
"use strict";

(() => {
  const FONT = "12px system-ui, sans-serif";

  const finite = (values) => Array.from(values, (v) => (Number.isFinite(v) ? v : null));

  const axis = (extra) => ({
    stroke: Report.color("text"), font: FONT, grid: { stroke: Report.color("grid"), width: 1 },
    ticks: { stroke: Report.color("grid"), width: 1, size: 4 }, ...extra,
  });

  Report.tick = (value) => {
    if (value === null) return "";
    const size = Math.abs(value), short = Number(value.toPrecision(4));
    return (size && (size < 1e-3 || size >= 1e5) ? Report.power(short.toExponential()) : short.toLocaleString("en").replaceAll(",", "\u202f")).replaceAll("-", "−");
  };

  /** The largest of 1, 2, 5 times a power of ten that is not above a value. */
  const round = (value) => {
    const power = 10 ** Math.floor(Math.log10(value));
    return power * ([5, 2, 1].find((digit) => digit * power <= value * (1 + 1e-9)) || 1);
  };

  /** Ticks of which `most` have room, two at least: with half the range as a step there are two. */
  Report.ticks = (low, high, most) => {
    const step = round((high - low) / Math.max(2, Math.floor(most)));
    const first = Math.ceil(low / step - 1e-9), count = Math.floor(high / step + 1e-9) - first + 1;
    return Array.from({ length: count }, (_, k) => step * (first + k));
  };
  const splits = (u, _, low, high) => Report.ticks(low, high, u.bbox.height / devicePixelRatio / 40);

  /** The unit in the brackets of a panel's label, as it follows a number. */
  const unit = ({ label, title = "" }) => {
    const [, name = "1"] = Report.words(label || title).match(/\[([^\]]+)\]$/) || [];
    return name === "1" ? "" : name === "°" ? name : `\u202f${name}`;
  };

  /** The range of an axis with a margin; a series that does not change lies in the middle of one that its size sets. */
  const range = (u, low, high) => {
    if (low === null) return [0, 1];
    const margin = high > low ? 0.06 * (high - low) : Math.abs(low) / 10 || 1;
    return [low - margin, high + margin];
  };

  /** The look of a line as a background: its colour, in dashes where the line has them. */
  const swatch = ({ color, dash = [] }) => {
    const shown = Report.color(color), [on, off] = dash;
    return dash.length ? `repeating-linear-gradient(90deg, ${shown} 0 ${on}px, transparent ${on}px ${on + off}px)` : shown;
  };

  /** Tell if an angle jumps by a turn between two values; a line is interrupted there. */
  Report.turns = (panel, before, value) => {
    const turn = { "°": 360, "\u202f°": 360, "\u202fdeg": 360, "\u202frad": 2 * Math.PI }[unit(panel)];
    return turn !== undefined && typeof before === "number" && typeof value === "number" && Math.abs(value - before) > 0.9 * turn;
  };
  const gaps = (panel, spanned) => (u, k, first, last, empty) => {
    const [x, y] = [u.data[0], u.data[k]], at = (row) => Math.round(u.valToPos(x[row], "x", true));
    const turns = Array.from({ length: last - first }, (_, n) => first + n).filter((row) => Report.turns(panel, y[row], y[row + 1]));
    return [...(spanned ? [] : empty), ...turns.map((row) => [at(row), at(row + 1)])].sort(([a], [b]) => a - b);
  };

  const series = (panel) => (line) => ({
    label: line.name ? Report.element("span", { innerHTML: line.name }) : "value",
    stroke: Report.color(line.color), width: Math.max(1.25, line.width || 1.5), dash: line.dash || [],
    paths: line.step ? uPlot.paths.stepped({ align: 1 }) : undefined,
    points: { show: false }, spanGaps: false, gaps: gaps(panel, line.spanGaps ?? true), pxAlign: 0,
    value: (_, v) => `${Report.number(v)}${v === null ? "" : unit(panel)}`,
  });

  /** Entries of a legend for named levels and marks; several of one name have one, grey if their colours differ. */
  Report.named = (lines) => Array.from(lines.reduce((looks, line) => {
    if (!line.name) return looks;
    const { color, dash } = looks.get(line.name) ?? line;
    return looks.set(line.name, { ...line, color: color === line.color ? color : "grey", dash: String(dash) === String(line.dash) ? dash : [] });
  }, new Map()).values());
  const fixed = ({ levels = [], marks = [] }) => Report.named([...levels, ...marks]).map((line) => {
    const marker = Report.element("div", { className: "u-marker" }), name = Report.element("div", { className: "u-label", innerHTML: line.name });
    marker.style.background = swatch(line);
    return Report.element("tr", { className: "u-series fixed" }, Report.element("th", {}, marker, name));
  });

  /** Levels and marks of a panel, drawn under its series. */
  const references = (panel) => (u) => {
    const { ctx, bbox } = u;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    for (const [lines, scale] of [[panel.levels || [], "y"], [panel.marks || [], "x"]]) {
      for (const line of lines) {
        const at = Math.round(u.valToPos(line.at, scale, true)) + 0.5;
        ctx.beginPath();
        ctx.strokeStyle = Report.color(line.color);
        ctx.lineWidth = line.width * devicePixelRatio;
        ctx.setLineDash((line.dash || []).map((d) => d * devicePixelRatio));
        if (scale === "y") { ctx.moveTo(bbox.left, at); ctx.lineTo(bbox.left + bbox.width, at); }
        else { ctx.moveTo(at, bbox.top); ctx.lineTo(at, bbox.top + bbox.height); }
        ctx.stroke();
      }
    }
    ctx.restore();
  };

  const bands = (lines) => {
    const low = lines.findIndex((line) => line.band === "low");
    const high = lines.findIndex((line) => line.band === "high");
    return low < 0 ? [] : [{ series: [high + 1, low + 1], fill: Report.color(lines[low].color) + "33" }];
  };

  /** The words above a panel; one without a title has that of its column, which is not above it on a phone. */
  Report.heading = ({ title, column, label }) => [title || column, label].filter(Boolean).join(": ");

  /** A chart in words: what it shows, over which time, and the ends of each series. */
  const described = (panel, data) => {
    const lines = panel.lines.map((line, k) => {
      const values = Array.from(data[k + 1]).filter(Number.isFinite), name = Report.words(line.name || "value");
      const least = values.reduce((a, b) => Math.min(a, b), Infinity), most = values.reduce((a, b) => Math.max(a, b), -Infinity);
      return values.length ? `${name} from ${Report.number(least)} to ${Report.number(most)}` : `${name} without values`;
    });
    const words = Report.words(Report.heading(panel));
    return `${words || "Chart"} over time: ${lines.join("; ")}`;
  };

  /** One panel; `group` holds the panels that zoom together. */
  Report.panel = (host, panel, group, height = 190) => {
    const logarithmic = panel.log || [false, false];
    const fit = (u) => { u.whole = panel.limits; u.setScale("x", { min: panel.limits[0], max: panel.limits[1] }); };
    const options = {
      width: host.clientWidth || 300, height, series: [
        { label: "t", value: (_, v) => (v === null ? "–" : `${Report.number(v)} s`) }, ...panel.lines.map(series(panel))],
      scales: { x: { time: false, distr: logarithmic[0] ? 3 : 1 }, y: logarithmic[1] ? { distr: 3 } : { distr: 1, range } },
      axes: [axis({ label: "time t [s]", labelFont: FONT, labelSize: 20, size: 32, values: (_, at) => at.map(Report.tick) }), axis({ size: 58, space: 24, values: (_, at) => at.map(Report.tick), ...(logarithmic[1] ? {} : { splits }) })],
      cursor: { sync: { key: group.key, scales: ["x", null] }, drag: { x: true, y: false }, bind: {
        dblclick: (u) => () => group.charts.forEach((c) => c.reset()) } },
      legend: { show: [...panel.lines, ...(panel.levels || []), ...(panel.marks || [])].some((line) => line.name), live: true, markers: { width: 0, fill: (_, k) => swatch(panel.lines[k - 1]) } }, bands: bands(panel.lines),
      hooks: { setLegend: [(u) => u.root.classList.toggle("idle", u.legend.idx === null || u.legend.idx === undefined)], drawAxes: [references(panel)], setScale: [(u, key) => { if (key === "x") group.zoomed(u); }] },
    };
    const data = [finite(panel.x), ...panel.lines.map((line) => finite(line.y))];
    const chart = new uPlot(options, data, host);
    const canvas = chart.root.querySelector("canvas");
    chart.root.querySelector(".u-legend tbody")?.append(...fixed(panel));
    chart.root.classList.add("idle");
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", described(panel, data));
    Object.assign(chart, { panel, reset: () => fit(chart) });
    /** Other values: all of them, or over the time to which the reader has zoomed. */
    chart.put = (values) => {
      const { min, max } = chart.scales.x, [low, high] = chart.whole;
      chart.batch(() => {
        chart.setData(values);
        if (typeof min !== "number" || (min === low && max === high)) fit(chart); // a new chart has no limits in its first instant
        else chart.setScale("x", { min, max });
      });
      canvas.setAttribute("aria-label", described(panel, values));
    };
    fit(chart);
    group.charts.push(chart);
    return chart;
  };

  /** Panels over the same time: zooming one zooms all. */
  Report.groups = {};
  Report.group = (key) => {
    const group = Report.groups[key] = { key, charts: [], busy: false };
    group.zoomed = (from) => {
      if (group.busy) return;
      const { min, max } = from.scales.x;
      group.busy = true;
      for (const chart of group.charts) {
        if (chart !== from && (chart.scales.x.min !== min || chart.scales.x.max !== max)) chart.setScale("x", { min, max });
      }
      queueMicrotask(() => { group.busy = false; });
    };
    return group;
  };

  const decoded = (panel) => ({
    ...panel, x: Report.floats(panel.x), lines: panel.lines.map((line) => ({ ...line, y: Report.floats(line.y) })),
  });

  /** Buttons that show and hide the series of a name in all panels. */
  const chips = (figure, state) => {
    const looks = Report.named(figure.panels.flatMap(({ lines }) => lines));
    if (looks.length < 2) return [];
    return looks.map(({ name, ...look }) => {
      const chip = Report.element("button", { type: "button", className: "chip", innerHTML: `<i></i>${name}` });
      const paint = () => chip.firstChild.style.setProperty("background", swatch(look));
      paint();
      Report.onTheme(paint);
      chip.setAttribute("aria-pressed", "true");
      chip.addEventListener("click", () => {
        const shown = !state.hidden.delete(name);
        if (shown) state.hidden.add(name);
        chip.setAttribute("aria-pressed", String(!shown));
        state.apply();
      });
      return chip;
    });
  };

  const MOST = 10; // of the buttons, which are then two rows on a laptop
  /** Few buttons, or a fold of many. */
  const folded = (buttons) => buttons.length <= MOST ? buttons : [
    Report.element("details", {}, Report.element("summary", { textContent: `${buttons.length} lines` }), ...buttons)];

  const STEPS = [["−", "zoom out", 0, 1.6], ["+", "zoom in", 0, 1 / 1.6], ["‹", "earlier", -0.25, 1], ["›", "later", 0.25, 1]];

  /** Zoom and move for those without a mouse. */
  const tools = (name, state, look) => {
    const move = (shift, factor) => state.groups.forEach((group) => group.charts.slice(0, 1).forEach((chart) => {
      const { min, max } = chart.scales.x, half = ((max - min) / 2) * factor, middle = (min + max) / 2 + shift * (max - min);
      chart.setScale("x", { min: middle - half, max: middle + half });
    }));
    const buttons = STEPS.map(([sign, title, shift, factor]) => {
      const button = Report.element("button", { type: "button", className: "tool", textContent: sign, title });
      button.setAttribute("aria-label", title);
      button.addEventListener("click", () => move(shift, factor));
      return button;
    });
    const all = Report.element("button", { type: "button", className: "tool", textContent: "all", title: "show all" });
    all.addEventListener("click", () => state.groups.forEach((group) => group.charts.forEach((chart) => chart.reset())));
    const charts = () => Array.from(state.groups.values()).flatMap((group) => group.charts);
    return Report.element("span", { className: "tools" }, ...buttons, all, ...Report.savers(name, charts, look));
  };

  /** A part of a picture, such as a path in a plane, beside the charts. */
  const cut = (image, [left, top, width, height]) => {
    const part = Report.element("img", { src: image.src, alt: image.alt });
    const across = Number(image.getAttribute("width")), up = Number(image.getAttribute("height"));
    part.style.cssText = `width: ${100 / width}%; margin: ${(-100 * top * up) / (width * across)}% 0 0 ${(-100 * left) / width}%`;
    const box = Report.element("div", { className: "part" }, part);
    box.style.cssText = `aspect-ratio: ${width * across} / ${height * up}; max-width: ${width * across}px`;
    return box;
  };

  /** Put the chart of a figure into its place on the page. */
  Report.figure = (host) => {
    const name = host.dataset.chart, figure = Report.data.charts[name];
    const state = { groups: new Map(), hidden: new Set(), panels: null };
    state.apply = () => state.groups.forEach((group) => group.charts.forEach((chart) => chart.lines.forEach((line, k) => {
      chart.setSeries(k + 1, { show: !state.hidden.has(line.name) });
    })));
    const grid = Report.element("div", { className: "panels" });
    const image = host.closest("figure").querySelector(".picture img");
    const parts = figure.rest.map((part) => cut(image, part));
    const rest = parts.length ? [Report.element("div", { className: "rest" }, ...parts)] : [];
    const look = { columns: Math.min(3, figure.columns), parts: parts.map((part, k) => ({ image: part.firstChild, place: figure.rest[k] })) };
    grid.style.setProperty("--columns", look.columns + rest.length);
    grid.style.setProperty("--panels", figure.panels.length);
    const build = () => {
      state.panels = state.panels || figure.panels.map(decoded);
      state.groups.forEach((group) => group.charts.forEach((chart) => chart.destroy()));
      state.groups.clear();
      grid.replaceChildren();
      for (const panel of state.panels) {
        const box = Report.element("div", { className: "panel" }, Report.element("div", { className: "label", innerHTML: Report.heading(panel) }));
        grid.append(box);
        const key = `${name}:${panel.limits}`;
        if (!state.groups.has(key)) state.groups.set(key, Report.group(key));
        const chart = Report.panel(box, panel, state.groups.get(key));
        chart.lines = panel.lines;
      }
      grid.append(...rest);
      state.apply();
      host.dataset.built = "yes";
    };
    const bar = Report.element("div", { className: "bar" }, ...folded(chips(figure, state)), tools(name, state, look));
    host.append(bar, grid);
    new ResizeObserver(() => state.groups.forEach((group) => group.charts.forEach((chart) => {
      const width = chart.root.parentElement.clientWidth;
      if (width && width !== chart.width) chart.setSize({ width, height: chart.height });
    }))).observe(host);
    Report.onTheme(() => state.panels && build());
    return build;
  };
})();
