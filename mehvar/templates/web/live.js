// SPDX-License-Identifier: Apache-2.0
// The page around the simulator: sliders, plots, the checksum, and the command that repeats a run.
"use strict";

(async () => {
  const BUDGET = 4; // ms of a frame of 16.7 for the run; as many at most for one panel, the rest is the browser's
  const PAUSE = 400; // ms after the last letter of a law until it runs
  const POINTS = 600; // of a line at most: one for each pixel of a panel
  const OWN = "my-law"; // in the address; no parameter has a name with a hyphen
  const COLORS = ["blue", "vermillion", "green", "purple", "orange", "sky"];
  const { data } = Report;
  const at = (id) => document.getElementById(id);
  const { element } = Report;
  const pretty = (unit) => unit.replace(/\^(\d)/g, (_, digit) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[digit]);
  const short = (value) => String(Number(value.toPrecision(4)));
  const amount = (value, unit) => `${Report.number(value)}${unit === "1" ? "" : ` ${pretty(unit)}`}`;
  const simulator = await Simulator.open(data);
  const chosen = { which: 0, own: {}, text: null }; // the text of the reader's law, null while a law of the model acts
  let kept = null; // the end and the metrics of the run whose curves stay beside the next ones
  let metrics = {}; // of the present run, by name

  const panels = (() => {
    const kinds = [["x", "states", data.states], ["u", "inputs", data.inputs], ["y", "outputs", data.outputs]];
    const made = [];
    const chart = ({ unit, chart: number = 0 }) => `${unit} ${number}`;
    for (const [series, kind, quantities] of kinds) for (const shared of new Set(quantities.map(chart))) {
      const members = quantities.map((q, k) => [q, k]).filter(([q]) => chart(q) === shared), [[{ unit }]] = members;
      const drawn = [[], ...members.map(() => [])];
      made.push({ series, title: unit === "1" ? kind : `${kind} [${pretty(unit)}]`, members, width: quantities.length, drawn, kept: null });
    }
    return made;
  })();

  /** Two runs have their own times, so each has gaps at the times of the other. */
  const line = (look) => ([q], k) => ({
    name: q.name, color: COLORS[k % COLORS.length], dash: k < COLORS.length ? [] : [5, 3], spanGaps: kept !== null, y: [], ...look(q),
  });
  const present = line(() => ({})), former = line((q) => ({ name: `${q.name}, kept`, dash: [2, 3], width: 1 }));

  const together = (panel) => (panel.kept ? uPlot.join([panel.drawn, panel.kept]) : panel.drawn);
  const limits = () => [0, Math.max(data.cases[chosen.which].end, kept?.end ?? 0)];

  const plot = (panel, host, group) => {
    panel.lines = [...panel.members.map(present), ...(panel.kept ? panel.members.map(former) : [])];
    panel.limits = limits();
    const made = Report.panel(host, { ...panel, x: [] }, group, 176);
    panel.head = element("div", { className: "playhead", hidden: true });
    made.over.append(panel.head);
    return made;
  };

  const build = () => {
    const hosts = panels.map((panel) => element("div", { className: "panel" }, element("div", { className: "label", textContent: panel.title })));
    const group = Report.group("run");
    at("plots").replaceChildren(...hosts.map((host) => element("figure", {}, host)));
    panels.forEach((panel, k) => { panel.plot = plot(panel, hosts[k], group); });
  };

  /** The rows of the run so far that a panel shows: t, and which rows. */
  const picked = (series) => {
    const n = series.t.length, every = Math.max(1, Math.ceil(n / POINTS));
    const rows = Array.from({ length: Math.ceil(n / every) }, (_, k) => k * every);
    if (n && rows[rows.length - 1] !== n - 1) rows.push(n - 1);
    return rows;
  };

  const draw = (panel) => {
    const series = simulator.rows(), rows = picked(series), numbers = series[panel.series];
    const lines = panel.members.map(([, k]) => rows.map((row) => {
      const value = numbers[row * panel.width + k];
      return Number.isFinite(value) ? value : null;
    }));
    panel.drawn = [rows.map((row) => series.t[row]), ...lines];
    panel.plot.panel.limits = limits();
    panel.plot.put(together(panel));
  };

  const point = (time) => panels.forEach(({ plot, head }) => {
    head.hidden = false;
    head.style.transform = `translateX(${plot.valToPos(time, "x")}px)`;
  });
  const motion = data.shapes.length ? new Report.Motion(at("motion"), simulator, data.shapes, point) : null;

  const command = () => {
    const { law, scenario } = data.cases[chosen.which];
    const own = Object.entries(chosen.own).map(([name, value]) => ` --set ${name}=${value}`).join("");
    return `mehvar simulate ${data.name} --controller ${law} --scenario ${scenario}${own} --json`;
  };

  /** The parameters that a law of the reader can name: all but those of instants. */
  const parameters = () => [...data.laws[data.cases[chosen.which].law].parameters, ...data.scenario_parameters, ...data.parameters];

  const formulas = () => Formulas.read(chosen.text, {
    inputs: data.inputs.map((q) => q.name), states: data.seen, references: data.references, values: parameters().map((q) => q.name),
  });

  /** The reader's law as a script for mehvar: sines differ in the last digit from one machine to another. */
  const script = (lines) => {
    const { law, scenario } = data.cases[chosen.which], values = simulator.values(), words = new Set(chosen.text.match(/\w+/g));
    const gains = new Set(data.laws[law].parameters.map((q) => q.name));
    const constants = parameters().filter((q) => words.has(q.name)).map((q) => `${q.name} = ${values[q.name]}`);
    const own = Object.entries(chosen.own).filter(([name]) => !gains.has(name)).map(([name, value]) => `, ${name}=${value}`).join("");
    return ["import mehvar", "import numpy as np", "", ...constants, "", "def law(t, x):", ...lines.map((line) => `    ${line}`),
      `    return [${data.inputs.map((q) => `${q.name}_`).join(", ")}]`, "",
      `run = mehvar.simulate("${data.name}", controller=law, scenario="${scenario}", period=${simulator.period(chosen.which)}${own})`, ""].join("\n");
  };

  const fails = () => data.failure && chosen.text === null && chosen.which === data.failure.case
    && JSON.stringify(chosen.own) === JSON.stringify({ [data.failure.name]: data.failure.value });

  /** The checksum of this run on the machine that made the page, if it did the run. */
  const host = () => {
    if (fails()) return data.failure.checksum;
    return chosen.text === null && !Object.keys(chosen.own).length ? data.cases[chosen.which].checksum : null;
  };

  const JUDGED = { true: ["good", "✓ success holds"], false: ["bad", "✗ success fails"], null: ["unsure", "? success undecided"] };
  /** The metrics of the finished run, and the success condition with the numbers that it names. */
  const judge = () => {
    const { metrics: values, truth } = Metrics.judged(data, simulator);
    metrics = values;
    tabulate();
    if (!data.success) return;
    const words = data.success.text.match(/\w+/g), [look, verdict] = JUDGED[truth];
    const numbers = data.metrics.filter(({ name }) => words.includes(name)).map(({ name, unit }) => `${name} = ${amount(metrics[name], unit)}`);
    at("success").className = look;
    at("success").textContent = `${verdict}: ${data.success.text}${numbers.length ? ` (${numbers.join(", ")})` : ""}`;
  };

  /** The metrics, beside those of the kept run. */
  const tabulate = () => at("metrics")?.querySelector("dl").replaceChildren(...data.metrics.map(({ name, unit, description }) => {
    const former = kept ? element("small", { textContent: `kept ${amount(kept.metrics[name], unit)}` }) : "";
    return element("div", {}, element("dt", {}, name, element("small", { textContent: description })), element("dd", {}, amount(metrics[name], unit), former));
  }));

  const tell = (spent, frames) => {
    const here = simulator.checksum(), there = host();
    const other = chosen.text === null ? "not run; the command below prints the same" : "not run; the script of my law agrees up to rounding";
    at("here").textContent = here;
    at("host").textContent = there ?? other;
    at("verdict").textContent = there === null ? "" : here === there ? "the same bits" : "other bits";
    at("verdict").className = there !== null && here !== there ? "bad" : "good";
    at("outcome").textContent = simulator.outcome();
    judge();
    const steps = simulator.steps();
    at("cost").textContent = `${steps} steps in ${spent.toFixed(0)} ms, ${short((1e3 * spent) / Math.max(1, steps))} µs each, in ${frames} frames`;
    document.documentElement.dataset.done = here;
  };

  /** The address holds the run, so that it can be sent: #law/scenario?name=value, and my-law=text. */
  const save = () => {
    const { law, scenario } = data.cases[chosen.which];
    const own = new URLSearchParams({ ...chosen.own, ...(chosen.text === null ? {} : { [OWN]: chosen.text }) }).toString();
    const address = `#${encodeURIComponent(law)}/${encodeURIComponent(scenario)}${own && `?${own}`}`;
    at("link").href = address;
    try { history.replaceState(null, "", address); } catch { /* frames may refuse, and browsers limit how often */ }
  };

  let run = null, turn = 0, left = 0;
  const soon = (then) => (document.hidden ? setTimeout(then) : requestAnimationFrame(then)); // a hidden page has no frames
  /** A share of the run and one panel: all of them in one frame take more than a frame has. */
  const frame = () => {
    if (run) {
      const begin = performance.now();
      let more = true;
      while (more && performance.now() - begin < BUDGET) more = simulator.advance(run.chunk);
      run.spent += performance.now() - begin;
      run.frames++;
      left = panels.length;
      if (!more) {
        tell(run.spent, run.frames);
        save();
        motion?.take();
        run = null;
      }
    }
    if (left) {
      draw(panels[turn++ % panels.length]);
      left--;
    }
    if (run || left) soon(frame);
  };

  /** What is said of a run goes before the next; what it drew stays, in grey, until the next one is drawn. */
  const forget = (why) => {
    delete document.documentElement.dataset.done;
    for (const id of ["here", "host", "verdict", "outcome", "success", "cost"]) if (at(id)) at(id).textContent = "";
    at("run").hidden = why !== null;
    at("command").textContent = why === null && chosen.text === null ? command() : "";
    at("refusal").textContent = why ?? "";
    at("views").classList.toggle("stale", why !== null);
    at("views").inert = why !== null;
    motion?.rest();
  };

  const refuse = (why) => {
    forget(why);
    run = null;
    left = 0;
  };

  /** Begin the run of what is chosen; returns why not, or null. */
  const begin = () => {
    if (chosen.text === null) return simulator.start(chosen.which, chosen.own);
    try {
      const law = formulas(), why = simulator.start(chosen.which, chosen.own, law);
      at("script").textContent = why === null ? script(law.python) : "";
      return why;
    } catch (mistake) {
      if (mistake instanceof Formulas.Mistake) return mistake.message;
      throw mistake;
    }
  };

  const again = () => {
    const why = begin();
    at("text").setAttribute("aria-invalid", String(why !== null && chosen.text !== null));
    if (why !== null) return refuse(why);
    forget(null);
    const going = run !== null || left > 0;
    run = { chunk: 16, spent: 0, frames: 0 };
    if (!going) soon(frame);
  };

  /** The nearest number with the four digits of a box that is not beyond another: below it with Math.floor. */
  const rounded = (value, toward) => {
    const unit = 10 ** (Math.floor(Math.log10(Math.abs(value) || 1)) - 3);
    return Number((toward(value / unit) * unit).toPrecision(4));
  };

  /** From nothing to twice a number, or one to each side of zero; where that is a bound or beyond, inside of it. */
  const range = (q, value) => {
    const [low, high] = value ? [Math.min(0, 2 * value), Math.max(0, 2 * value)] : [-1, 1];
    const lower = Math.max(low, q.lower ?? -Infinity), upper = Math.min(high, q.upper ?? Infinity);
    const margin = (upper - lower) / 1000; // what a finger can tell of a bar
    return [
      lower === q.lower ? rounded(lower + (q.lower_open ? margin : 0), Math.ceil) : lower,
      upper === q.upper ? rounded(upper - (q.upper_open ? margin : 0), Math.floor) : upper,
    ];
  };

  const slider = (q, value) => {
    const [low, high] = range(q, value), own = chosen.own[q.name];
    const bar = element("input", { type: "range", min: low, max: high, step: "any", value: own ?? value });
    const box = element("input", { type: "number", step: "any", value: own ?? short(value) });
    const set = (number) => { chosen.own[q.name] = number; again(); };
    bar.setAttribute("aria-label", q.description);
    box.setAttribute("aria-label", `${q.name}: ${q.description}`);
    bar.addEventListener("input", () => { box.value = short(Number(bar.value)); set(Number(box.value)); });
    box.addEventListener("change", () => { if (box.value !== "") { bar.value = box.value; set(Number(box.value)); } });
    const name = element("span", {}, `${q.name.replaceAll("_", "_\u200b")} `); // long names break at an underscore
    if (q.unit !== "1") name.append(element("small", { textContent: `[${pretty(q.unit)}]` }));
    return element("div", { className: "slider" }, name, bar, box, element("small", { textContent: q.description }));
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

  /** Show what is chosen in all controls, and run it. */
  const show = () => {
    at("case").value = chosen.which;
    at("own").hidden = chosen.text === null;
    if (chosen.text !== null) {
      at("panel").open = true;
      at("text").value = chosen.text;
      at("text").rows = chosen.text.split("\n").length + 2;
    }
    const names = [data.seen, data.references, parameters().map((q) => q.name)].flat();
    at("period").textContent = `Evaluated every ${simulator.period(chosen.which)} s and held in between. A line for each input: ${data.inputs.map((q) => q.name).join(", ")}; other lines name parts.`;
    at("names").textContent = `t, pi, ${names.join(", ")}. Functions: ${Formulas.functions.join(", ")}.`;
    controls();
    again();
  };

  const choose = () => {
    Object.assign(chosen, { which: Number(at("case").value), own: {} });
    show();
  };

  const presets = {
    first: () => ({ which: 0, own: {}, text: null }),
    fails: () => ({ which: data.failure.case, own: { [data.failure.name]: data.failure.value }, text: null }),
    own: () => ({ own: {}, text: at("text").value }),
  };

  /** Take the run of the address; one that this page does not have is refused. */
  const restore = () => {
    const [path, values = ""] = location.hash.slice(1).split("?");
    const which = path ? data.cases.findIndex((c) => path === `${encodeURIComponent(c.law)}/${encodeURIComponent(c.scenario)}`) : 0;
    Object.assign(chosen, { which: Math.max(which, 0), own: {}, text: null });
    const names = new Set(parameters().map((q) => q.name));
    let why = which < 0 ? `the address names ${path}, which is no run of this page` : null;
    for (const [name, text] of new URLSearchParams(values)) {
      if (name === OWN) chosen.text = text;
      else if (names.has(name) && text && Number.isFinite(Number(text))) chosen.own[name] = Number(text);
      else why ??= `the address sets ${name} to ${text || "nothing"}: it takes numbers for parameters of the run`;
    }
    show();
    if (why !== null) refuse(why);
  };

  const keep = () => {
    kept = kept === null ? { end: data.cases[chosen.which].end, metrics } : null;
    tabulate();
    for (const panel of panels) panel.kept = kept === null ? null : panel.drawn;
    at("keep").textContent = kept === null ? "keep these curves" : "drop the kept curves";
    rebuild();
  };

  at("case").addEventListener("change", choose);
  at("reset").addEventListener("click", choose);
  at("keep").addEventListener("click", keep);
  for (const button of document.querySelectorAll("[data-preset]")) button.addEventListener("click", () => {
    Object.assign(chosen, presets[button.dataset.preset]());
    show();
  });
  let typing = 0;
  at("text").addEventListener("input", () => {
    clearTimeout(typing);
    typing = setTimeout(() => { chosen.text = at("text").value; again(); }, PAUSE);
  });
  at("save").append(...Report.savers(data.name, () => panels.map((panel) => panel.plot)));
  addEventListener("hashchange", restore);
  const rebuild = () => { build(); panels.forEach(draw); if (motion?.rows) point(motion.time); };
  Report.onTheme(rebuild);
  addEventListener("resize", rebuild);
  build();
  tabulate();
  restore();
})();
