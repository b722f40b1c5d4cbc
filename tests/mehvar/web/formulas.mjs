// SPDX-License-Identifier: Apache-2.0
// Laws that a reader types, in Node: node formulas.mjs FILE '["u = k*x", ...]' prints what each gives, or its mistake.
import fs from "node:fs";

const [file, texts] = process.argv.slice(2);
const Formulas = new Function(`${fs.readFileSync(file, "utf8")}; return Formulas;`)();
const names = { inputs: ["u", "v"], states: ["rho", "phi"], references: ["wanted"], values: ["k"] };
const at = { t: 2, x: [0.5, 3], r: [1], values: { k: 4 } };
console.log(JSON.stringify(JSON.parse(texts).map((text) => {
  try {
    const law = Formulas.read(text, names);
    return { inputs: law.inputs(at), python: law.python };
  } catch (mistake) {
    if (!(mistake instanceof Formulas.Mistake)) throw mistake;
    return { mistake: mistake.message };
  }
})));
