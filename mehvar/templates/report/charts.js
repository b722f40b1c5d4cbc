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

  const tick = (value) => {
    if (value === null) return "";
    const size = Math.abs(value), short = Number(value.toPrecision(4));
    return (size && (size < 1e-3 || size >= 1e5) ? Report.power(short.toExponential()) : short.toLocaleString("en").replaceAll(",", "\u202f")).replaceAll("-", "−");
  };

  /** The largest of 1, 2, 5 times a power of ten that is not above a value. */
  const round = (value) => {
    const power = 10 ** Math.floor(Math.log10(value));
    return power * ([5, 2, 1].find((digit) => digit * power <= value * (1 + 1e-9)) || 1);
  };

  /** Ticks so far apart that their words have room, two at least: with half the range as a step there are two. */
  const splits = (u, _, low, high) => {
    const step = round((high - low) / Math.max(2, Math.floor(u.bbox.height / devicePixelRatio / 40)));
    const first = Math.ceil(low / step - 1e-9), count = Math.floor(high / step + 1e-9) - first + 1;
    return Array.from({ length: count }, (_, k) => step * (first + k));
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

  /** The unit of a panel's values, which its label has in brackets. */
  const unit = ({ label, title }) => {
    const [, text = "1"] = /\[([^\]]+)\]\s*$/.exec(Report.words(label || title || "")) ?? [];
    return text === "1" ? "" : ` ${text}`;
  };

  const series = (line, unit) => ({
    label: line.name ? Report.element("span", { innerHTML: line.name }) : "value",
    stroke: Report.color(line.color), width: Math.max(1.25, line.width || 1.5), dash: line.dash || [],
    paths: line.step ? uPlot.paths.stepped({ align: 1 }) : undefined,
    points: { show: false }, spanGaps: line.spanGaps ?? true, pxAlign: 0, value: (_, v) => Report.number(v) + (v === null ? "" : unit),
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

  /** A chart in words: what it shows, over which time, and the ends of each series. */
  const described = (panel, data) => {
    const lines = panel.lines.map((line, k) => {
      const values = Array.from(data[k + 1]).filter(Number.isFinite), name = Report.words(line.name || "value");
      const least = values.reduce((a, b) => Math.min(a, b), Infinity), most = values.reduce((a, b) => Math.max(a, b), -Infinity);
      return values.length ? `${name} from ${Report.number(least)} to ${Report.number(most)}` : `${name} without values`;
    });
    const words = Report.words([panel.title, panel.label].filter(Boolean).join(": "));
    return `${words || "Chart"} over time: ${lines.join("; ")}`;
  };

  /** One panel; `group` holds the panels that zoom together. */
  Report.panel = (host, panel, group, height = 190) => {
    const logarithmic = panel.log || [false, false];
    const fit = (u) => { u.whole = panel.limits; u.setScale("x", { min: panel.limits[0], max: panel.limits[1] }); };
    const options = {
      width: host.clientWidth || 300, height, series: [
        { label: "t", value: (_, v) => (v === null ? "–" : `${Report.number(v)} s`) }, ...panel.lines.map((line) => series(line, unit(panel)))],
      scales: { x: { time: false, distr: logarithmic[0] ? 3 : 1 }, y: logarithmic[1] ? { distr: 3 } : { distr: 1, range } },
      axes: [axis({ label: "time t [s]", labelFont: FONT, labelSize: 20, size: 32, values: (_, at) => at.map(tick) }), axis({ size: 58, space: 24, values: (_, at) => at.map(tick), ...(logarithmic[1] ? {} : { splits }) })],
      cursor: { sync: { key: group.key, scales: ["x", null] }, drag: { x: true, y: false }, bind: {
        dblclick: (u) => () => group.charts.forEach((c) => c.reset()) } },
      legend: { show: panel.lines.some((line) => line.name), live: true, markers: { width: 0, fill: (_, k) => swatch(panel.lines[k - 1]) } }, bands: bands(panel.lines),
      hooks: { setLegend: [(u) => u.root.classList.toggle("idle", u.legend.idx === null || u.legend.idx === undefined)], drawAxes: [references(panel)], setScale: [(u, key) => { if (key === "x") group.zoomed(u); }] },
    };
    const data = [finite(panel.x), ...panel.lines.map((line) => finite(line.y))];
    const chart = new uPlot(options, data, host);
    const canvas = chart.root.querySelector("canvas");
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
    const names = new Map();
    for (const panel of figure.panels) for (const line of panel.lines) if (line.name) {
      const { color, dash } = names.get(line.name) ?? line;
      names.set(line.name, { color: color === line.color ? color : "grey", dash: String(dash) === String(line.dash) ? dash : [] });
    }
    if (names.size < 2) return [];
    return Array.from(names, ([name, look]) => {
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
  const tools = (name, state) => {
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
    return Report.element("span", { className: "tools" }, ...buttons, all, ...Report.savers(name, charts));
  };

  /** Put the chart of a figure into its place on the page. */
  Report.figure = (host) => {
    const name = host.dataset.chart, figure = Report.data.charts[name];
    const state = { groups: new Map(), hidden: new Set(), panels: null };
    state.apply = () => state.groups.forEach((group) => group.charts.forEach((chart) => chart.lines.forEach((line, k) => {
      chart.setSeries(k + 1, { show: !state.hidden.has(line.name) });
    })));
    const grid = Report.element("div", { className: "panels" });
    grid.style.setProperty("--columns", Math.min(3, figure.columns));
    const build = () => {
      state.panels = state.panels || figure.panels.map(decoded);
      state.groups.forEach((group) => group.charts.forEach((chart) => chart.destroy()));
      state.groups.clear();
      grid.replaceChildren();
      for (const panel of state.panels) {
        const title = [panel.title, panel.label].filter(Boolean).join(": ");
        const box = Report.element("div", { className: "panel" }, Report.element("div", { className: "label", innerHTML: title }));
        grid.append(box);
        const key = `${name}:${panel.limits}`;
        if (!state.groups.has(key)) state.groups.set(key, Report.group(key));
        const chart = Report.panel(box, panel, state.groups.get(key));
        chart.lines = panel.lines;
      }
      state.apply();
      host.dataset.built = "yes";
    };
    const bar = Report.element("div", { className: "bar" }, ...folded(chips(figure, state)), tools(name, state));
    host.append(bar, grid);
    new ResizeObserver(() => state.groups.forEach((group) => group.charts.forEach((chart) => {
      const width = chart.root.parentElement.clientWidth;
      if (width && width !== chart.width) chart.setSize({ width, height: chart.height });
    }))).observe(host);
    Report.onTheme(() => state.panels && build());
    return build;
  };
})();
