// SPDX-License-Identifier: Apache-2.0
// What charts show, as a table of numbers or as a drawing for a paper.
"use strict";

(() => {
  /* A drawing is for a paper: it is as wide as a column or, with charts side by side, as a page, and in points. */
  const MM = 72 / 25.4, COLUMN = 88 * MM, SHEET = 180 * MM, GAP = 4 * MM;
  const FONT = 8, SMALL = 6, LINE = 10; // sizes of letters, of indices, and of a line of text
  const HEIGHT = 88, RIGHT = 8, TICK = 4, THIN = 0.65; // of a panel; beside it; from tick to number; of a line on the screen
  const KEY = 22, APART = 9; // of a legend's line with its space, and between two entries
  const SPACE = new DOMParser().parseFromString("<svg>", "text/html").querySelector("svg").namespaceURI;
  const escaped = (text) => text.replace(/[&<>"]/g, (sign) => `&#${sign.charCodeAt(0)};`);
  const round = (value) => value.toFixed(2);

  /** A label with its subscripts and superscripts lowered and raised. */
  const label = (html) => {
    let shift = 0;
    const piece = (text, wanted) => {
      const [by, size] = [wanted - shift, wanted ? ` font-size="${SMALL}"` : ""];
      shift = wanted;
      return `<tspan dy="${by}"${size}>${escaped(Report.words(text))}</tspan>`;
    };
    return html.split(/(<su[bp]>.*?<\/su[bp]>)/).filter(Boolean).map((part) =>
      piece(part, part.startsWith("<sub>") ? 2 : part.startsWith("<sup>") ? -3 : 0)).join("");
  };
  const text = (x, y, html, extra = "") => `<text x="${round(x)}" y="${round(y)}" ${extra}>${label(html)}</text>`;

  /** A table: the instants of all charts, and a column for each line that is shown. */
  Report.csv = (charts) => {
    const names = charts.flatMap(({ panel, series }) => series.slice(1).map((one, k) =>
      Report.words([Report.heading(panel), panel.lines[k].name].filter(Boolean).join(", "))));
    const [t, ...columns] = uPlot.join(charts.map((chart) => chart.data));
    const quoted = ["t [s]", ...names].map((name) => `"${name.replaceAll('"', '""')}"`);
    return [quoted, ...Array.from(t, (at, row) => [at, ...columns.map((column) => column[row] ?? "")])]
      .map((cells) => cells.join(",")).join("\n") + "\n";
  };

  /** A colour as on paper, whatever the screen's scheme is: the palette's first rule has those. */
  const color = (name) => {
    const rules = Array.from(document.styleSheets).flatMap((sheet) => Array.from(sheet.cssRules));
    const printed = rules.find(({ selectorText, style }) => selectorText === ":root" && style.getPropertyValue(`--c-${name}`));
    return printed?.style.getPropertyValue(`--c-${name}`).trim() || name;
  };

  const ruler = document.createElement("canvas").getContext("2d");
  const measured = (html) => {
    ruler.font = `${FONT}px Helvetica, Arial, sans-serif`;
    return ruler.measureText(Report.words(html)).width;
  };

  /** A text in lines that are no wider than some length, unless a word or a unit is. */
  const wrapped = (html, most) => html.replace(/\[[^\]]*\]/g, (unit) => unit.replaceAll(" ", "\u00a0")).split(" ").reduce((lines, word) => {
    const longer = lines.length ? `${lines.at(-1)} ${word}` : word;
    if (lines.length && measured(longer) > most) lines.push(word); else lines.splice(-1, 1, longer);
    return lines;
  }, []).filter(Boolean);

  const stroke = ({ color: name, width, dash = [] }, usual = 1.5) =>
    `stroke="${color(name)}" stroke-width="${round(THIN * (width || usual))}"${dash.length ? ` stroke-dasharray="${dash.map((d) => round(THIN * d)).join(" ")}"` : ""}`;

  /** The place of a value on an axis from 0 to `length`. */
  const scale = ({ min, max, distr }, length) => {
    const of = distr === 3 ? Math.log10 : Number;
    return (value) => (length * (of(value) - of(min))) / (of(max) - of(min));
  };
  const ticks = ({ min, max, distr }, most) => distr !== 3 ? Report.ticks(min, max, most)
    : Report.ticks(Math.log10(min), Math.log10(max), most).filter(Number.isInteger).map((power) => 10 ** power);

  const path = (chart, k, x, y) => {
    const [t, values] = [chart.data[0], chart.data[k]], stepped = chart.panel.lines[k - 1].step;
    let pen = "M", before = 0, last = null;
    return Array.from(t, (at, row) => {
      if (values[row] === null || values[row] === undefined) return "";
      if (Report.turns(chart.panel, last, values[row])) pen = "M";
      const across = round(x(at)), up = round(y(values[row]));
      const point = `${stepped && pen === "L" ? `L${across},${before}` : ""}${pen}${across},${up}`;
      [pen, before, last] = ["L", up, values[row]];
      return point;
    }).join("");
  };

  /** The area between two lines of a chart. */
  const area = (chart, low, high, x, y) => {
    const back = Array.from(chart.data[0], (at, row) => [at, chart.data[high][row]]).filter(([, v]) => v !== null && v !== undefined).reverse();
    return `${path(chart, low, x, y)}${back.map(([at, v]) => `L${round(x(at))},${round(y(v))}`).join("")}Z`;
  };

  const entries = ({ panel, series }) => [
    ...panel.lines.filter(({ name }, k) => name && series[k + 1].show), ...Report.named([...(panel.levels || []), ...(panel.marks || [])])];

  /** A legend in as many lines as it needs: its text and its height. */
  const legend = (lines, left, top, width) => {
    let x = 0, row = 0;
    const placed = lines.map((line) => {
      const needed = KEY + measured(line.name);
      if (x && x + needed > width) [x, row] = [0, row + 1];
      const [at, y] = [left + x, top + row * LINE];
      x += needed + APART;
      return `<path d="M${round(at)},${round(y - FONT / 3)}h${KEY - 5}" ${stroke(line)}/>${text(at + KEY, y, line.name)}`;
    });
    return [placed.join(""), lines.length ? (row + 1) * LINE : 0];
  };

  /** What a panel needs around its axes: lines of title and label, numbers of the vertical axis. */
  const frame = (chart, width, height) => {
    const { panel, scales } = chart, up = ticks(scales.y, height / 20).map((at) => [at, Report.tick(at)]);
    const label = wrapped(panel.label || panel.title || "", height), numbers = Math.max(...up.map(([, words]) => measured(words)));
    return { chart, up, label, title: wrapped((panel.label && panel.title) || "", width), left: label.length * LINE + numbers + TICK + 3 };
  };

  const drawing = ({ chart, up, label: axis, title }, left, edge, top, width, height, named, number) => {
    const { panel, scales, series } = chart, x = scale(scales.x, width), down = scale(scales.y, height), y = (value) => height - down(value);
    const across = ticks(scales.x, width / 34), grid = color("grid");
    const [low, high] = ["low", "high"].map((end) => panel.lines.findIndex((line) => line.band === end) + 1);
    const fixed = [
      ...(panel.levels || []).map((line) => [`M0,${round(y(line.at))}H${round(width)}`, line]),
      ...(panel.marks || []).map((line) => [`M${round(x(line.at))},0V${height}`, line]),
    ];
    const inside = (at, words) => Math.min(at, width + RIGHT - measured(words) / 2);
    return `<g transform="translate(${round(left)},${round(top)})">${[
      ...title.map((line, k) => text(0, (k - title.length + 1) * LINE - 4, line)),
      ...axis.map((line, k) => text(0, 0, line, `text-anchor="middle" transform="translate(${round(FONT - edge + k * LINE)},${height / 2}) rotate(-90)"`)),
      ...across.map((at) => `<path d="M${round(x(at))},0V${height}" stroke="${grid}" stroke-width="0.5"/>${named ? text(inside(x(at), Report.tick(at)), height + LINE, Report.tick(at), 'text-anchor="middle"') : ""}`),
      ...up.map(([at, words]) => `<path d="M0,${round(y(at))}H${round(width)}" stroke="${grid}" stroke-width="0.5"/>${text(-TICK, y(at) + FONT / 3, words, 'text-anchor="end"')}`),
      named ? text(width / 2, height + 2.1 * LINE, "time t [s]", 'text-anchor="middle"') : "",
      `<path d="M0,0V${height}H${round(width)}" fill="none" stroke="${color("grey")}" stroke-width="0.6"/>`,
      `<clipPath id="clip${number}"><rect width="${round(width)}" height="${height}"/></clipPath><g clip-path="url(#clip${number})" fill="none">`,
      low && series[low].show ? `<path d="${area(chart, low, high, x, y)}" fill="${color(panel.lines[low - 1].color)}" fill-opacity="0.2"/>` : "",
      ...fixed.map(([d, line]) => `<path d="${d}" ${stroke(line, 1)}/>`),
      ...panel.lines.map((line, k) => (series[k + 1].show ? `<path d="${path(chart, k + 1, x, y)}" ${stroke(line)}/>` : "")), "</g>",
    ].join("")}</g>`;
  };

  /** The part of a picture that lies beside the charts. */
  const cut = ({ image, place: [left, top, width, height] }, at, whole) => {
    const { naturalWidth, naturalHeight } = image, part = document.createElement("canvas");
    [part.width, part.height] = [width * naturalWidth, height * naturalHeight].map(Math.round);
    part.getContext("2d").drawImage(image, left * naturalWidth, top * naturalHeight, part.width, part.height, 0, 0, part.width, part.height);
    const up = (whole * part.height) / part.width;
    return [`<image x="0" y="${round(at)}" width="${round(whole)}" height="${round(up)}" href=${JSON.stringify(part.toDataURL())}/>`, up];
  };

  /** A drawing of the charts for a paper, with what is zoomed and hidden, `columns` side by side, above other parts. */
  Report.svg = (charts, { columns = 1, parts = [] } = {}) => {
    const whole = columns > 1 ? SHEET : COLUMN, cell = (whole - (columns - 1) * GAP) / columns;
    const frames = charts.map((chart) => frame(chart, cell - RIGHT, HEIGHT));
    const lefts = Array.from({ length: columns }, (_, column) => Math.max(0, ...frames.filter((_, k) => k % columns === column).map(({ left }) => left)));
    const keys = charts.map(entries), common = keys.every((lines) => JSON.stringify(lines) === JSON.stringify(keys[0]));
    const alike = (one, other) => other && one.scales.x.min === other.scales.x.min && one.scales.x.max === other.scales.x.max;
    let top = 2, drawn = [];
    for (let first = 0; first < frames.length; first += columns) {
      const row = frames.slice(first, first + columns), titles = Math.max(...row.map(({ title }) => title.length));
      const below = row.map((one, column) => {
        const k = first + column, left = column * (cell + GAP) + lefts[column], named = !alike(one.chart, charts[k + columns]);
        drawn.push(drawing(one, left, lefts[column], top + titles * LINE + 4, cell - lefts[column] - RIGHT, HEIGHT, named, k));
        const axis = named ? 2.4 * LINE : 0;
        const [key, height] = common ? ["", 0] : legend(keys[k], left, top + titles * LINE + 4 + HEIGHT + axis + LINE, cell - lefts[column] - RIGHT);
        drawn.push(key);
        return axis + height;
      });
      top += titles * LINE + 4 + HEIGHT + Math.max(...below) + LINE;
    }
    if (common) {
      const [key, height] = legend(keys[0], lefts[0], top, whole - lefts[0] - RIGHT);
      drawn.push(key);
      top += height;
    }
    for (const part of parts) {
      const [image, height] = cut(part, top, COLUMN);
      drawn.push(image);
      top += height;
    }
    return `<svg xmlns="${SPACE}" xml:space="preserve" width="${round(whole / MM)}mm" height="${round(top / MM)}mm" viewBox="0 0 ${round(whole)} ${round(top)}" font-family="Helvetica, Arial, sans-serif" font-size="${FONT}" fill="${color("text")}" style="white-space: pre">`
      + `<rect width="100%" height="100%" fill="${color("card")}"/>${drawn.join("")}</svg>`;
  };

  const offer = (name, type, content) => {
    const link = Report.element("a", { download: name, href: URL.createObjectURL(new Blob([content], { type })) });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  };

  /** Buttons that save charts; `charts` returns those that are there when one is pressed, `look` what else is drawn. */
  Report.savers = (name, charts, look) => [["CSV", "text/csv", Report.csv], ["SVG", "image/svg+xml", Report.svg]].map(([kind, type, made]) => {
    const button = Report.element("button", { type: "button", className: "tool", textContent: kind, title: `save as ${kind}` });
    button.setAttribute("aria-label", `save as ${kind}`);
    button.addEventListener("click", () => offer(`${name}.${kind.toLowerCase()}`, type, made(charts(), look)));
    return button;
  });
})();
