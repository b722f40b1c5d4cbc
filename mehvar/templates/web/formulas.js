// SPDX-License-Identifier: Apache-2.0
// Laws in words: lines `name = expression`, read by a parser of its own. No text of a reader becomes a script.
"use strict";

const Formulas = (() => {
  const FUNCTIONS = new Map(Object.entries({
    sin: [Math.sin, 1, "sin"], cos: [Math.cos, 1, "cos"], tan: [Math.tan, 1, "tan"], tanh: [Math.tanh, 1, "tanh"],
    asin: [Math.asin, 1, "arcsin"], acos: [Math.acos, 1, "arccos"], atan: [Math.atan, 1, "arctan"], atan2: [Math.atan2, 2, "arctan2"],
    sqrt: [Math.sqrt, 1, "sqrt"], exp: [Math.exp, 1, "exp"], log: [Math.log, 1, "log"],
    abs: [Math.abs, 1, "abs"], sign: [Math.sign, 1, "sign"], min: [Math.min, 2, "minimum"], max: [Math.max, 2, "maximum"],
  }));
  const OPERATORS = { "+": (a, b) => a + b, "-": (a, b) => a - b, "*": (a, b) => a * b, "/": (a, b) => a / b, "^": (a, b) => a ** b };
  const TOKEN = /[ \t]*(?:((?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)|([A-Za-z_]\w*)|(\*\*|.))/g;
  const DEEPEST = 100, LONGEST = 4000; // brackets within brackets, letters of a law: far below what the stack of a browser holds

  /** A text that is no law; the message begins with the place. */
  class Mistake extends Error {}

  const joined = (operator, left, right) => (at) => operator(left(at), right(at));

  /** Letters to change, add or leave out to make one word of another. */
  const distance = (one, other) => {
    let row = Array.from({ length: other.length + 1 }, (_, k) => k);
    for (let i = 1; i <= one.length; i++) {
      const next = [i];
      for (let k = 1; k <= other.length; k++) next.push(Math.min(row[k] + 1, next[k - 1] + 1, row[k - 1] + (one[i - 1] !== other[k - 1])));
      row = next;
    }
    return row[other.length];
  };

  const hint = (word, words) => {
    const [near, letters] = Array.from(words, (other) => [other, distance(word, other)]).reduce((a, b) => (b[1] < a[1] ? b : a));
    return letters < 2 || (letters === 2 && near[0] === word[0]) ? `; did you mean ${near}?` : "";
  };

  /** One line `name = expression`: recursive descent, with the precedence of mathematics: -x^2 is -(x^2). */
  class Line {
    constructor(text, number, known) {
      Object.assign(this, { number, known, next: 0, depth: 0 });
      this.tokens = Array.from(text.matchAll(TOKEN), ([all, numeral, word, sign]) => ({ numeral, word, sign: sign === "**" ? "^" : sign, all }));
      let column = 1;
      for (const token of this.tokens) { column += token.all.length; token.column = column - token.all.trimStart().length; }
      this.end = { column, sign: null };
    }

    get token() { return this.tokens[this.next] ?? this.end; }

    fail(why, { column } = this.token) { throw new Mistake(`my law, line ${this.number}, column ${column}: ${why}`); }

    shown({ numeral, word, sign } = this.token) { return numeral ?? word ?? sign ?? "the end of the line"; }

    take(...signs) { return signs.includes(this.token.sign) ? this.tokens[this.next++].sign : null; }

    need(sign) { if (this.take(sign) === null) this.fail(`${sign} must stand here, not ${this.shown()}`); }

    chain(part, ...signs) {
      let left = part();
      for (let sign = this.take(...signs); sign !== null; sign = this.take(...signs)) left = joined(OPERATORS[sign], left, part());
      return left;
    }

    sum() {
      if (++this.depth > DEEPEST) this.fail(`more than ${DEEPEST} brackets within brackets`);
      const value = this.chain(() => this.chain(() => this.signed(), "*", "/"), "+", "-");
      this.depth--;
      return value;
    }

    signed() {
      const signs = [];
      for (let sign = this.take("+", "-"); sign !== null; sign = this.take("+", "-")) signs.push(sign);
      const value = this.power();
      return signs.filter((sign) => sign === "-").length % 2 ? (at) => -value(at) : value;
    }

    power() {
      const base = this.atom();
      if (this.take("^") === null) return base;
      if (++this.depth > DEEPEST) this.fail(`more than ${DEEPEST} powers of powers`);
      const value = joined(OPERATORS["^"], base, this.signed());
      this.depth--;
      return value;
    }

    atom() {
      const token = this.token;
      if (token.numeral !== undefined) {
        this.next++;
        const value = Number(token.numeral);
        if (!Number.isFinite(value)) this.fail(`${token.numeral} is too large a number`, token);
        return () => value;
      }
      if (token.word !== undefined) return this.named(token);
      if (this.take("(") === null) this.fail(`a number, a name or a bracket must stand here, not ${this.shown()}`);
      const value = this.sum();
      this.need(")");
      return value;
    }

    named(token) {
      this.next++;
      if (this.token.sign === "(") return this.called(token);
      const entry = this.known.get(token.word);
      if (!entry) this.fail(FUNCTIONS.has(token.word) ? `${token.word} is a function and needs brackets` : `${token.word} is no name of this run${hint(token.word, this.known.keys())}`, token);
      token.python = entry.python;
      return entry.value;
    }

    called(token) {
      const entry = FUNCTIONS.get(token.word);
      if (!entry) this.fail(`${token.word} is no function${hint(token.word, FUNCTIONS.keys())}`, token);
      const [value, count, python] = entry, given = [];
      token.python = `np.${python}`;
      this.need("(");
      do given.push(this.sum()); while (this.take(",") !== null);
      if (given.length !== count) this.fail(`${token.word} takes ${count === 1 ? "one number" : "two numbers"}, not ${given.length}`, token);
      this.need(")");
      return count === 1 ? (at) => value(given[0](at)) : joined(value, ...given);
    }

    /** The line in Python, whose precedence is the same. */
    python() {
      const spelled = ({ numeral, word, sign, python }) => python ?? (numeral === undefined ? (sign === "^" ? "**" : sign ?? word) : String(Number(numeral)).replace(/^\d+$/, "$&.0"));
      return this.tokens.map(spelled).join(" ").replace(/(\w) \(/g, "$1(").replace(/\( /g, "(").replace(/ ([),])/g, "$1");
    }

    /** Take the line: what it defines goes to the names that later ones know. */
    read(inputs, defined) {
      const target = this.token;
      if (target.word === undefined) this.fail(`a line begins with a name, as in ${inputs[0]} = 0, not with ${this.shown()}`);
      this.next++;
      this.need("=");
      const value = this.sum();
      if (this.next < this.tokens.length) this.fail(`an operator must stand here, not ${this.shown()}`);
      if (this.known.has(target.word)) this.fail(`${target.word} has a value already; choose another name`, target);
      if (FUNCTIONS.has(target.word)) this.fail(`${target.word} is a function; choose another name`, target);
      const place = defined.length;
      target.python = `${target.word}_`;
      this.known.set(target.word, { value: (at) => at.defined[place], python: target.python });
      defined.push({ name: target.word, value, python: this.python() });
    }
  }

  /**
   * Read a law. `names` has the lists inputs, states, references and values (parameters); t is the time, pi the number.
   * Its `inputs(at)` are the inputs at a sample { t, x, r, values }; `python` are its lines, of which values are constants.
   */
  const read = (text, names) => {
    if (text.length > LONGEST) throw new Mistake(`my law has ${text.length} letters; at most ${LONGEST} are read`);
    const known = new Map([["pi", { value: () => Math.PI, python: "np.pi" }], ["t", { value: (at) => at.t, python: "t" }]]);
    names.values.forEach((name) => known.set(name, { value: (at) => at.values[name], python: name }));
    names.references.forEach((name, k) => known.set(name, { value: (at) => at.r[k], python: `x.${name}` }));
    names.states.forEach((name, k) => known.set(name, { value: (at) => at.x[k], python: `x.${name}` }));
    names.inputs.forEach((name) => known.delete(name));
    const defined = [];
    text.split("\n").forEach((line, k) => {
      const plain = line.replace(/#.*/, "").trimEnd();
      if (plain) new Line(plain, k + 1, known).read(names.inputs, defined);
    });
    const places = names.inputs.map((name) => defined.findIndex((one) => one.name === name)), missing = places.indexOf(-1);
    if (missing >= 0) throw new Mistake(`my law: a line ${names.inputs[missing]} = ... is missing; every input needs one`);
    return {
      python: defined.map(({ python }) => python),
      inputs: (at) => {
        at.defined = [];
        for (const { value } of defined) at.defined.push(value(at));
        return places.map((place) => at.defined[place]);
      },
    };
  };

  return { read, Mistake, functions: Array.from(FUNCTIONS.keys()) };
})();
