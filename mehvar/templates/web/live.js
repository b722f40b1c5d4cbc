// SPDX-License-Identifier: Apache-2.0
// The page around the simulator: sliders, plots, the checksum, and the command that repeats a run.
"use strict";

(async () => {
  const BUDGET = 8; // ms of a frame of 16.7 for the run; the rest is for drawing
  const POINTS = 600; // of a line at most: one for each pixel of a panel; twice as many cost a third of the frames
  const COLORS = ["--c1", "--c2", "--c3", "--c4", "--c5", "--c6"];
  const data = JSON.parse(document.getElementById("data").textContent);
  const at = (id) => document.getElementById(id);
  const color = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const element = (tag, properties = {}, ...children) => {
    const made = Object.assign(document.createElement(tag), properties);
    made.append(...children);
    return made;
  };
  const pretty = (unit) => unit.replace("^2", "²").replace("^3", "³");
  const short = (value) => String(Number(value.toPrecision(4)));
  const simulator = await Simulator.open(data);
  const chosen = { which: 0, own: {} };

  const panels = (() => {
    const kinds = [["x", "states", data.states], ["u", "inputs", data.inputs], ["y", "outputs", data.outputs]];
    const made = [];
    for (const [series, kind, quantities] of kinds) for (const unit of new Set(quantities.map((q) => q.unit))) {
      const members = quantities.map((q, k) => [q, k]).filter(([q]) => q.unit === unit);
      made.push({ series, title: `${kind} [${pretty(unit)}]`, members, width: quantities.length });
    }
    return made;
  })();

  const line = ([q], k) => ({
    label: q.name, stroke: color(COLORS[k % COLORS.length]), dash: k < COLORS.length ? [] : [5, 3], width: 1.5,
    points: { show: false }, value: (_, v) => (v === null ? "–" : short(v)),
  });

  const plot = (panel, host) => {
    const axis = { stroke: color("--text"), grid: { stroke: color("--line"), width: 1 }, ticks: { stroke: color("--line") } };
    const made = new uPlot({
      width: host.clientWidth - 14, height: 170, scales: { x: { time: false } }, // less the figure's padding
      series: [{ label: "t", value: (_, v) => (v === null ? "–" : `${short(v)} s`) }, ...panel.members.map(line)],
      axes: [{ ...axis, size: 30 }, { ...axis, size: 62, values: (_, splits) => splits.map(short) }],
    }, [[], ...panel.members.map(() => [])], host);
    host.querySelector("canvas").setAttribute("aria-label", `${panel.title} over time`);
    return made;
  };

  const build = () => {
    const hosts = panels.map((panel) => element("figure", {}, element("figcaption", { textContent: panel.title })));
    at("plots").replaceChildren(...hosts);
    panels.forEach((panel, k) => { panel.plot = plot(panel, hosts[k]); });
  };

  const draw = () => {
    const series = simulator.rows(), n = series.t.length, every = Math.max(1, Math.ceil(n / POINTS));
    const picks = Array.from({ length: Math.ceil(n / every) }, (_, k) => k * every);
    if (n && picks[picks.length - 1] !== n - 1) picks.push(n - 1);
    const end = data.cases[chosen.which].end, t = picks.map((row) => series.t[row]);
    for (const panel of panels) {
      const lines = panel.members.map(([, k]) => picks.map((row) => {
        const value = series[panel.series][row * panel.width + k];
        return Number.isFinite(value) ? value : null;
      }));
      panel.plot.batch(() => {
        panel.plot.setData([t, ...lines], true);
        panel.plot.setScale("x", { min: 0, max: end });
      });
    }
  };

  const command = () => {
    const { law, scenario } = data.cases[chosen.which];
    const own = Object.entries(chosen.own).map(([name, value]) => ` --set ${name}=${value}`).join("");
    return `mehvar simulate ${data.name} --controller ${law} --scenario ${scenario}${own} --json`;
  };

  const tell = (spent, frames) => {
    const here = simulator.checksum(), host = data.cases[chosen.which].checksum, plain = !Object.keys(chosen.own).length;
    at("here").textContent = here;
    at("host").textContent = plain ? host : "run the command below: its checksum is to be this one";
    at("verdict").textContent = plain ? (here === host ? "the same bits" : "other bits") : "";
    at("verdict").className = plain && here !== host ? "bad" : "good";
    at("outcome").textContent = simulator.outcome();
    const steps = simulator.steps();
    at("cost").textContent = `${steps} steps in ${spent.toFixed(0)} ms, ${short((1e3 * spent) / Math.max(1, steps))} µs each, in ${frames} frames`;
    document.documentElement.dataset.done = here;
  };

  let run = null;
  const frame = () => {
    if (!run) return;
    const begin = performance.now();
    let more = true;
    while (more && performance.now() - begin < BUDGET) more = simulator.advance(run.chunk);
    run.spent += performance.now() - begin;
    run.frames++;
    draw();
    if (more) { requestAnimationFrame(frame); return; }
    tell(run.spent, run.frames);
    run = null;
  };

  const again = () => {
    delete document.documentElement.dataset.done;
    at("command").textContent = command();
    const why = simulator.start(chosen.which, chosen.own);
    at("refusal").textContent = why || "";
    if (why) { run = null; return; }
    const going = run !== null;
    run = { chunk: 16, spent: 0, frames: 0 };
    if (!going) requestAnimationFrame(frame);
  };

  /** From nothing to twice a number, or one to each side of zero, within its bounds. */
  const range = (q, value) => {
    const [low, high] = value ? [Math.min(0, 2 * value), Math.max(0, 2 * value)] : [-1, 1];
    return [Math.max(low, q.lower ?? -Infinity), Math.min(high, q.upper ?? Infinity)];
  };

  const slider = (q, value) => {
    const [low, high] = range(q, value);
    const bar = element("input", { type: "range", min: low, max: high, step: "any", value });
    const box = element("input", { type: "number", step: "any", value: short(value) });
    const set = (number) => { chosen.own[q.name] = number; again(); };
    bar.setAttribute("aria-label", q.description);
    box.setAttribute("aria-label", `${q.name}: ${q.description}`);
    bar.addEventListener("input", () => { box.value = short(Number(bar.value)); set(Number(box.value)); });
    box.addEventListener("change", () => { if (box.value !== "") { bar.value = box.value; set(Number(box.value)); } });
    const name = element("span", { textContent: q.unit === "1" ? q.name : `${q.name} [${pretty(q.unit)}]`, title: q.description });
    return element("div", { className: "slider" }, name, bar, box);
  };

  const controls = () => {
    const now = data.cases[chosen.which], law = data.laws[now.law];
    const lists = { c: ["law", law.parameters], s: ["start and target", data.scenario_parameters], p: ["plant", data.parameters] };
    at("controls").replaceChildren(...Object.entries(lists).map(([group, [title, list]]) => {
      const rows = list.map((q, k) => [q, now[group][k]]).filter(([q]) => !law.fixed.includes(q.name));
      const box = element("details", { open: group !== "p" }, element("summary", { textContent: title }));
      box.append(...rows.map(([q, value]) => slider(q, value)));
      return rows.length ? box : "";
    }));
  };

  const choose = () => {
    chosen.which = Number(at("case").value);
    chosen.own = {};
    controls();
    again();
  };

  at("case").append(...data.cases.map((c, k) => element("option", { value: k, textContent: `${c.law}, ${c.scenario}` })));
  at("case").addEventListener("change", choose);
  at("reset").addEventListener("click", choose);
  const rebuild = () => { build(); draw(); };
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", rebuild);
  addEventListener("resize", rebuild);
  build();
  choose();
})();
