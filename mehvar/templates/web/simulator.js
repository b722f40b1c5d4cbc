// SPDX-License-Identifier: Apache-2.0
// The simulator of a page: the module, the arrays in its memory, and runs. It knows no document; Node runs it too.
"use strict";

const Simulator = (() => {
  const ARRAYS = ["p", "c", "s", "ticks", "margins", "derived", "t", "x", "u", "u_cmd", "y", "z", "x_seen", "r_seen", "u_own"];
  const SERIES = ["t", "x", "u", "u_cmd", "y", "z"];

  /** Bytes from base64 of gzip. */
  const unpacked = async (text) => {
    const packed = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  };

  const TABLE = Uint32Array.from({ length: 256 }, (_, n) => {
    for (let k = 0; k < 8; k++) n = n & 1 ? 0xedb88320 ^ (n >>> 1) : n >>> 1;
    return n;
  });

  /** CRC-32 of numbers as little-endian doubles, going on from another; every NaN counts as the same one. */
  const crc = (numbers, before) => {
    const bytes = new Uint8Array(8), view = new DataView(bytes.buffer);
    let sum = ~before;
    for (const number of numbers) {
      if (Number.isNaN(number)) view.setBigUint64(0, 0x7ff8000000000000n, true);
      else view.setFloat64(0, number, true);
      for (const byte of bytes) sum = TABLE[(sum ^ byte) & 255] ^ (sum >>> 8);
    }
    return ~sum >>> 0;
  };

  const allows = (q, value) =>
    (q.lower === null || (q.lower_open ? value > q.lower : value >= q.lower)) &&
    (q.upper === null || (q.upper_open ? value < q.upper : value <= q.upper));

  const said = (message, values) =>
    message.replace(/\{(\w+)(?::[^}]*)?\}/g, (place, name) => (name in values ? Number(values[name].toPrecision(6)) : place));

  /** Return what runs the cases of a page; `data` is what mehvar wrote into it. */
  const open = async (data) => {
    const { instance } = await WebAssembly.instantiate(await unpacked(data.module));
    const module = instance.exports;
    module._initialize?.(); // only a module with a C library has it
    if (data.noise) module.web_draw(data.seed);
    const ticks = await Promise.all(data.ticks.map(async (text) => new Float64Array((await unpacked(text)).buffer)));
    const place = Object.fromEntries(ARRAYS.map((name, which) => [name, module.web_array(which)]));
    const array = (name, length) => new Float64Array(module.memory.buffer, place[name], length);
    let present = null, count = 0;

    const groups = (law) => ({ p: data.parameters, c: data.laws[law].parameters, s: data.scenario_parameters });

    /** Parameters that follow others take what their formulas give, in as many passes as they need. */
    const settle = (names) => {
      const list = data.laws[present.law].parameters, c = array("c", list.length);
      const derived = list.map((q, k) => [q, k]).filter(([q]) => q.formula !== null);
      const waiting = new Set(names);
      for (const [q, k] of derived) if (waiting.has(q.name)) c[k] = NaN;
      for (let pass = names.length; pass; pass--) {
        module.web_defaults(present.of);
        const result = array("derived", derived.length);
        derived.forEach(([q, k], place) => { if (waiting.has(q.name)) c[k] = result[place]; });
      }
    };

    /** Why a run cannot begin, in words; null if it can. */
    const refusal = (values) => {
      for (const [group, list] of Object.entries(groups(present.law))) {
        const numbers = array(group, list.length);
        for (const [k, q] of list.entries()) {
          if (!allows(q, numbers[k])) return `${q.name} = ${numbers[k]} must be in ${q.interval} ${q.unit}`;
        }
      }
      module.web_check(present.number);
      const messages = [...data.constraints, ...(present.own ? [] : data.laws[present.law].constraints), ...data.limits];
      const margins = array("margins", messages.length), broken = margins.findIndex((margin) => !(margin > 0));
      return broken < 0 ? null : said(messages[broken], values);
    };

    /** Begin a run of a case with some parameters of one's own, under its law or under what Formulas.read gave; returns why not, or null. */
    const start = (which, own = {}, formulas = null) => {
      const laws = Object.keys(data.laws);
      present = { ...data.cases[which], own: formulas, of: laws.indexOf(data.cases[which].law) };
      present.number = formulas ? laws.length : present.of; // the law of the page is the module's last
      count = 0;
      const values = present.values = {};
      for (const [group, list] of Object.entries(groups(present.law))) {
        const numbers = array(group, list.length);
        list.forEach((q, k) => { numbers[k] = q.name in own ? own[q.name] : present[group][k]; });
      }
      settle(present.formulas.filter((name) => !(name in own)));
      for (const [group, list] of Object.entries(groups(present.law))) {
        const numbers = array(group, list.length);
        list.forEach((q, k) => { values[q.name] = numbers[k]; });
      }
      const why = refusal(values);
      if (why) return why;
      const t = ticks[present.ticks];
      array("ticks", t.length).set(t);
      module.web_start(present.number, t.length, present.record_every, present.hold_every, data.max_steps, data.rtol, data.atol);
      return null;
    };

    /** The input that the page's own law gives at a sample. */
    const answer = () => {
      const seen = { t: ticks[present.ticks][count], x: array("x_seen", data.seen.length), r: array("r_seen", data.references.length), values: present.values };
      array("u_own", data.inputs.length).set(present.own.inputs(seen));
    };

    /** Go on for some ticks, from sample to sample under a law of the page; returns whether there are more. */
    const advance = (some) => {
      const end = ticks[present.ticks].length, until = Math.min(count + some, end), every = present.hold_every;
      while (count < until) {
        if (present.own && count % every === 0) answer();
        const next = present.own ? Math.min(until, count - (count % every) + every) : until;
        count = module.web_run(next) < 0 ? end : next;
      }
      return count < end;
    };

    const rows = () => {
      const n = module.web_records(), width = data.widths;
      const sizes = { ...width, t: 1, z: present.own ? 0 : data.laws[present.law].memory.length };
      return Object.fromEntries(SERIES.map((name) => [name, array(name, n * sizes[name])]));
    };

    /** The variables of the run so far by name, as result files name them; null for one that the page does not have. */
    const series = () => {
      const { t, ...lists } = rows(), memory = present.own ? [] : data.laws[present.law].memory;
      const places = [["x", "", data.states], ["u", "u_", data.inputs], ["u_cmd", "u_cmd_", data.inputs], ["y", "", data.outputs]];
      const of = Object.fromEntries([...places.map(([list, head, quantities]) => [list, quantities.map((q) => head + q.name)]), ["z", memory]]
        .flatMap(([list, names]) => names.map((name, k) => [name, [list, k, names.length]])));
      const variable = (name) => (name in of ? Array.from(t, (_, row) => lists[of[name][0]][row * of[name][2] + of[name][1]]) : null);
      return { t, variable };
    };

    const coordinates = 3 * data.shapes.reduce((sum, shape) => sum + shape.points, 0);

    /** The coordinates of the picture's points at a row. */
    const points = (row) => new Float64Array(module.memory.buffer, module.web_points(row), coordinates).slice();

    const checksum = () => {
      const series = rows();
      return SERIES.reduce((sum, name) => crc(series[name], sum), 0).toString(16).padStart(8, "0");
    };

    const outcome = () => {
      const status = module.web_status(), at = `at t = ${Number(module.web_time().toPrecision(6))} s`;
      if (status === 0) return "end time reached";
      if (status === 4) return `${said(data.limits[module.web_violated()], present.values)} (${at})`;
      return `${data.statuses[status]} ${at}`;
    };

    /** Seconds from one sample of a case to the next. */
    const period = (which) => ticks[data.cases[which].ticks][data.cases[which].hold_every];

    return { start, advance, rows, series, points, checksum, outcome, period, status: () => module.web_status(), time: () => module.web_time(), values: () => present.values, steps: () => module.web_steps() };
  };

  return { open };
})();
