// SPDX-License-Identifier: Apache-2.0
// Metrics of a run from its series, and the success condition on them, as mehvar/runtime/run/metrics.py and conditions.py define both.
"use strict";

const Metrics = (() => {
  const last = (values) => values[values.length - 1];
  const total = (values) => values.reduce((sum, value) => sum + value, 0);
  const steps = (values) => values.slice(1).map((value, k) => value - values[k]);

  /** The time at which a signal enters the band for good; infinite if it does not. */
  const settled = (t, values, band) => {
    const k = values.findLastIndex((value) => !(Math.abs(value) <= band));
    if (k < 0) return t[0];
    if (k === t.length - 1) return Infinity;
    const part = (values[k] - Math.sign(values[k]) * band) / (values[k] - values[k + 1]);
    return Number.isFinite(part) ? t[k] + part * (t[k + 1] - t[k]) : t[k + 1];
  };
  const flips = (values, band) => steps(values.filter((value) => Math.abs(value) > band).map(Math.sign)).filter(Boolean).length;

  /** Of the signals of a metric within its window. */
  const KINDS = {
    settling: (t, signals, band) => Math.max(...signals.map((values) => settled(t, values, band))),
    settling_about_end: (t, signals, band) => Math.max(...signals.map((values) => settled(t, values.map((v) => v - last(values)), band))),
    max: (t, signals) => signals.flat().reduce((a, b) => Math.max(a, b)),
    min: (t, signals) => signals.flat().reduce((a, b) => Math.min(a, b)),
    max_abs: (t, signals) => signals.flat().reduce((a, b) => Math.max(a, Math.abs(b)), 0),
    rms: (t, signals) => Math.sqrt(total(signals.flat().map((value) => value * value)) / signals.flat().length),
    travel: (t, signals) => total(signals.flatMap(steps).map(Math.abs)),
    sign_changes: (t, signals, band) => total(signals.map((values) => flips(values, band))),
    final: (t, [values]) => last(values),
  };
  const OF_THE_END = ["settling", "settling_about_end", "final"];

  /** A metric of a run; NaN where the run does not determine it. `series` returns a variable by name, or null. */
  const value = ({ kind, of, band = 0, since = 0, until }, t, series, cut) => {
    const end = until ?? Infinity, pairs = of.map((text) => text.split(" - ").map(series));
    if (!(kind in KINDS) || pairs.flat().includes(null)) return NaN;
    if (OF_THE_END.includes(kind) && cut < end && !(kind === "final" && end === Infinity)) return NaN;
    const rows = Array.from(t.keys()).filter((row) => since <= t[row] && t[row] <= end);
    if (!rows.length) return NaN;
    const signals = pairs.map(([one, less]) => rows.map((row) => one[row] - (less ? less[row] : 0)));
    return KINDS[kind](rows.map((row) => t[row]), signals, band);
  };

  const ARITHMETIC = { "+": (a, b) => a + b, "-": (a, b) => (b === undefined ? -a : a - b), "*": (a, b) => a * b, "/": (a, b) => a / b, abs: Math.abs };
  const COMPARISONS = { "<": (a, b) => a < b, "<=": (a, b) => a <= b, ">": (a, b) => a > b, ">=": (a, b) => a >= b, "==": (a, b) => a === b, "!=": (a, b) => a !== b };

  /** True, false, or null where a number is undetermined; a node is a list with its operator first. */
  const holds = ([sign, ...parts], number) => {
    const amount = (node) => (!Array.isArray(node) ? (typeof node === "string" ? number(node) : node) : ARITHMETIC[node[0]](...node.slice(1).map(amount)));
    if (sign in COMPARISONS) {
      const sides = parts.map(amount);
      return sides.some(Number.isNaN) ? null : COMPARISONS[sign](...sides);
    }
    const truths = parts.map((part) => holds(part, number));
    if (sign === "not") return truths[0] === null ? null : !truths[0];
    const decisive = sign === "or";
    return truths.includes(decisive) ? decisive : truths.includes(null) ? null : !decisive;
  };

  /** The metrics of the simulator's run, and whether it succeeds: true, false, or null where that is undetermined or nothing is asked. */
  const judged = ({ metrics, success }, simulator) => {
    const { t, variable } = simulator.series(), status = simulator.status(), cut = status === 0 ? Infinity : simulator.time();
    const values = Object.fromEntries(metrics.map((metric) => [metric.name, value(metric, t, variable, cut)]));
    const early = status !== 0 && !success?.text.includes("status");
    const truth = success && (early ? false : holds(success.condition, (name) => (name === "status" ? status : values[name])));
    return { metrics: values, truth };
  };

  return { judged };
})();
