// SPDX-License-Identifier: Apache-2.0
// The page around the simulator: sliders, plots, the checksum, and the command that repeats a run.
"use strict";

(async () => {
  const BUDGET = 4; // ms of a frame of 16.7 for the run; as many at most for one panel, the rest is the browser's
  const POINTS = 600; // of a line at most: one for each pixel of a panel
  const COLORS = ["blue", "vermillion", "green", "purple", "orange", "sky"];
  const { data } = Report;
  const at = (id) => document.getElementById(id);
  const { element } = Report;
  const pretty = (unit) => unit.replace("^2", "²").replace("^3", "³");
  const short = (value) => String(Number(value.toPrecision(4)));
  const simulator = await Simulator.open(data);
  const chosen = { which: 0, own: {} };
  let kept = null; // the end of the run whose curves stay beside the next ones

  const panels = (() => {
    const kinds = [["x", "states", data.states], ["u", "inputs", data.inputs], ["y", "outputs", data.outputs]];
    const made = [];
    for (const [series, kind, quantities] of kinds) for (const unit of new Set(quantities.map((q) => q.unit))) {
      const members = quantities.map((q, k) => [q, k]).filter(([q]) => q.unit === unit);
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
  const limits = () => [0, Math.max(data.cases[chosen.which].end, kept ?? 0)];

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

  const tell = (spent, frames) => {
    const here = simulator.checksum(), host = data.cases[chosen.which].checksum, plain = !Object.keys(chosen.own).length;
    at("here").textContent = here;
    at("host").textContent = plain ? host : "not run; the command below prints the same";
    at("verdict").textContent = plain ? (here === host ? "the same bits" : "other bits") : "";
    at("verdict").className = plain && here !== host ? "bad" : "good";
    at("outcome").textContent = simulator.outcome();
    const steps = simulator.steps();
    at("cost").textContent = `in ${steps} steps in ${spent.toFixed(0)} ms, ${short((1e3 * spent) / Math.max(1, steps))} µs each, in ${frames} frames`;
    document.documentElement.dataset.done = here;
  };

  /** The address holds the run, so that it can be sent: #law/scenario?name=value. */
  const save = () => {
    const { law, scenario } = data.cases[chosen.which], own = new URLSearchParams(chosen.own).toString();
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
    for (const id of ["here", "host", "verdict", "outcome", "cost"]) at(id).textContent = "";
    at("run").hidden = why !== null;
    at("command").textContent = why === null ? command() : "";
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

  const again = () => {
    const why = simulator.start(chosen.which, chosen.own);
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

  /** Take the run of the address; one that this page does not have is refused. */
  const restore = () => {
    const [path, values = ""] = location.hash.slice(1).split("?");
    const which = path ? data.cases.findIndex((c) => path === `${encodeURIComponent(c.law)}/${encodeURIComponent(c.scenario)}`) : 0;
    chosen.which = Math.max(which, 0);
    chosen.own = {};
    at("case").value = chosen.which;
    const lists = [data.laws[data.cases[chosen.which].law].parameters, data.scenario_parameters, data.parameters];
    const names = new Set(lists.flat().map((q) => q.name));
    let why = which < 0 ? `the address names ${path}, which is no run of this page` : null;
    for (const [name, text] of new URLSearchParams(values)) {
      if (names.has(name) && text && Number.isFinite(Number(text))) chosen.own[name] = Number(text);
      else why ??= `the address sets ${name} to ${text || "nothing"}: it takes numbers for parameters of the run`;
    }
    controls();
    if (why === null) again();
    else refuse(why);
  };

  const keep = () => {
    kept = kept === null ? data.cases[chosen.which].end : null;
    for (const panel of panels) panel.kept = kept === null ? null : panel.drawn;
    at("keep").textContent = kept === null ? "keep these curves" : "drop the kept curves";
    rebuild();
  };

  at("case").addEventListener("change", choose);
  at("reset").addEventListener("click", choose);
  at("keep").addEventListener("click", keep);
  at("save").append(...Report.savers(data.name, () => panels.map((panel) => panel.plot)));
  addEventListener("hashchange", restore);
  const rebuild = () => { build(); panels.forEach(draw); if (motion?.rows) point(motion.time); };
  Report.onTheme(rebuild);
  addEventListener("resize", rebuild);
  build();
  restore();
})();
