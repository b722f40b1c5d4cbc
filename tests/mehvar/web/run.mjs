// SPDX-License-Identifier: Apache-2.0
// Runs of a page in Node: node run.mjs PAGE '[{"case": 0, "own": {"k": 1}}, ...]' prints a JSON list of what came of each.
import fs from "node:fs";

const [page, requests] = process.argv.slice(2);
const text = fs.readFileSync(page, "utf8");
const data = JSON.parse(/<script type="application\/json" id="data">(.*?)<\/script>/s.exec(text)[1]);
const scripts = [...text.matchAll(/<script>\n(.*?)<\/script>/gs)].map((match) => match[1]);
const named = (name) => new Function(`${scripts.find((s) => s.includes(`const ${name} = `))}; return ${name};`)();
const simulator = await named("Simulator").open(data), judged = named("Metrics").judged;
const results = JSON.parse(requests || "null") || data.cases.map((_, k) => ({ case: k, own: {} }));
console.log(JSON.stringify(results.map(({ case: which, own }) => {
  const { law, scenario, checksum: host } = data.cases[which];
  const refusal = simulator.start(which, own);
  if (refusal) return { law, scenario, refusal };
  while (simulator.advance(64));
  const { metrics, truth } = judged(data, simulator);
  const texts = Object.fromEntries(Object.entries(metrics).map(([name, value]) => [name, String(value).replace("Infinity", "inf")]));
  return { law, scenario, host, checksum: simulator.checksum(), outcome: simulator.outcome(), metrics: texts, succeeds: truth };
})));
