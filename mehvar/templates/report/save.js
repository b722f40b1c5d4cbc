// SPDX-License-Identifier: Apache-2.0
// What charts show, as a table of numbers or as a drawing for a paper.
"use strict";

(() => {
  const GAP = 18, LINE = 16; // pixels below a panel, and of a line of text
  const EDGE = 8; // pixels around the drawing
  const KEY = 24, APART = 14; // pixels of a legend's line with its space, and between two entries
  const SPACE = new DOMParser().parseFromString("<svg>", "text/html").querySelector("svg").namespaceURI;
  const escaped = (text) => text.replace(/[&<>"]/g, (sign) => `&#${sign.charCodeAt(0)};`);
  const round = (value) => value.toFixed(2);

  /** A label with its subscripts and superscripts lowered and raised. */
  const label = (html) => {
    let shift = 0;
    const piece = (text, wanted) => {
      const [by, size] = [wanted - shift, wanted ? ' font-size="9"' : ""];
      shift = wanted;
      return `<tspan dy="${by}"${size}>${escaped(Report.words(text))}</tspan>`;
    };
    return html.split(/(<su[bp]>.*?<\/su[bp]>)/).filter(Boolean).map((part) =>
      piece(part, part.startsWith("<sub>") ? 3 : part.startsWith("<sup>") ? -4 : 0)).join("");
  };
  const text = (x, y, html, extra = "") => `<text x="${round(x)}" y="${round(y)}" ${extra}>${label(html)}</text>`;
  const heading = ({ title, label: axis }) => [title, axis].filter(Boolean).join(": ");

  /** A table: the instants of all charts, and a column for each line that is shown. */
  Report.csv = (charts) => {
    const names = charts.flatMap(({ panel, series }) => series.slice(1).map((one, k) =>
      Report.words([heading(panel), panel.lines[k].name].filter(Boolean).join(", "))));
    const [t, ...columns] = uPlot.join(charts.map((chart) => chart.data));
    const quoted = ["t [s]", ...names].map((name) => `"${name.replaceAll('"', '""')}"`);
    return [quoted, ...Array.from(t, (at, row) => [at, ...columns.map((column) => column[row] ?? "")])]
      .map((cells) => cells.join(",")).join("\n") + "\n";
  };

  const path = (chart, k) => {
    const [t, values] = [chart.data[0], chart.data[k]], stepped = chart.panel.lines[k - 1].step;
    let pen = "M", before = 0;
    return Array.from(t, (at, row) => {
      if (values[row] === null || values[row] === undefined) return "";
      const [x, y] = [round(chart.valToPos(at, "x")), round(chart.valToPos(values[row], "y"))];
      const corner = stepped && pen === "L" ? `L${x},${before}` : "", point = `${corner}${pen}${x},${y}`;
      [pen, before] = ["L", y];
      return point;
    }).join("");
  };

  /** The area between two lines of a chart. */
  const area = (chart, low, high) => {
    const back = Array.from(chart.data[0], (at, row) => [at, chart.data[high][row]]).filter(([, v]) => v !== null && v !== undefined).reverse();
    return `${path(chart, low)}${back.map(([at, v]) => `L${round(chart.valToPos(at, "x"))},${round(chart.valToPos(v, "y"))}`).join("")}Z`;
  };

  /** A colour as on paper, whatever the screen's scheme is: the palette's first rule has those. */
  const color = (name) => {
    const rules = Array.from(document.styleSheets).flatMap((sheet) => Array.from(sheet.cssRules));
    const printed = rules.find(({ selectorText, style }) => selectorText === ":root" && style.getPropertyValue(`--c-${name}`));
    return printed?.style.getPropertyValue(`--c-${name}`).trim() || name;
  };

  const ruler = document.createElement("canvas").getContext("2d");
  const measured = (html) => {
    ruler.font = "12px sans-serif";
    return ruler.measureText(Report.words(html)).width;
  };

  /** The entries of a legend with their places, in as many lines as they need. */
  const legend = (chart) => {
    const { panel, over, series } = chart, whole = over.clientWidth;
    let x = 0, row = 0;
    return panel.lines.map((line, k) => [line, k + 1]).filter(([{ name }, k]) => name && series[k].show).map(([line, k]) => {
      const needed = KEY + measured(line.name);
      if (x && x + needed > whole) [x, row] = [0, row + 1];
      const place = { k, name: line.name, x, y: row * LINE, row };
      x += needed + APART;
      return place;
    });
  };

  /** The attributes of a stroke, as `references` and `series` of charts.js draw it. */
  const stroke = ({ color: name, width: wide, dash = [] }, least = 1.25) =>
    `stroke="${color(name)}" stroke-width="${Math.max(least, wide || 1.5)}"${dash.length ? ` stroke-dasharray="${dash.join(" ")}"` : ""}`;

  const drawing = (chart, left, top, number) => {
    const { panel, over, axes, series } = chart, [width, height] = [over.clientWidth, over.clientHeight];
    const [x0, y0] = [over.offsetLeft, over.offsetTop + LINE], grid = color("grid");
    const ticks = (axis) => axis._splits.map((at, k) => [at, axis._values[k]]).filter(([at]) => at !== null);
    const across = ticks(axes[0]).map(([at, words]) => [chart.valToPos(at, "x"), words]).filter(([x]) => x >= 0 && x <= width);
    const up = ticks(axes[1]).map(([at, words]) => [chart.valToPos(at, "y"), words]).filter(([y]) => y >= 0 && y <= height);
    const shown = series.slice(1).map((one, k) => [one, k + 1]).filter(([one]) => one.show);
    const marks = [
      ...(panel.levels || []).map((line) => [`M0,${round(chart.valToPos(line.at, "y"))}H${width}`, line]),
      ...(panel.marks || []).map((line) => [`M${round(chart.valToPos(line.at, "x"))},0V${height}`, line]),
    ];
    const [low, high] = ["low", "high"].map((end) => panel.lines.findIndex((line) => line.band === end) + 1);
    const band = low && series[low].show ? `<path d="${area(chart, low, high)}" fill="${color(panel.lines[low - 1].color)}" fill-opacity="0.2"/>` : "";
    return `<g transform="translate(${left + x0},${top + y0})">${[
      text(-x0, -over.offsetTop - 2, heading(panel)),
      ...across.map(([x, words]) => `<path d="M${round(x)},0V${height}" stroke="${grid}"/>${text(x, height + 15, String(words), 'text-anchor="middle"')}`),
      ...up.map(([y, words]) => `<path d="M0,${round(y)}H${width}" stroke="${grid}"/>${text(-6, y + 4, String(words), 'text-anchor="end"')}`),
      text(width / 2, height + 32, "time t [s]", 'text-anchor="middle"'),
      `<clipPath id="clip${number}"><rect width="${width}" height="${height}"/></clipPath><g clip-path="url(#clip${number})" fill="none">`,
      band, ...marks.map(([d, line]) => `<path d="${d}" ${stroke(line, 0)}/>`),
      ...shown.map(([, k]) => `<path d="${path(chart, k)}" ${stroke(panel.lines[k - 1])}/>`), "</g>",
      ...legend(chart).map(({ k, name, x, y }) => `<path d="M${round(x)},${height + y + 46}h18" ${stroke(panel.lines[k - 1])}/>${text(x + KEY, height + y + 50, name)}`),
    ].join("")}</g>`;
  };

  /** A drawing of the charts as they stand on the page, with what is zoomed and hidden. */
  Report.svg = (charts) => {
    const boxes = charts.map(({ root }) => root.getBoundingClientRect());
    const left = Math.min(...boxes.map((box) => box.left)), rows = [...new Set(boxes.map((box) => Math.round(box.top)))];
    const lines = Math.max(1, ...charts.flatMap((chart) => legend(chart).map(({ row }) => row + 1)));
    const height = Math.max(...charts.map((chart) => chart.height)) + (1 + lines) * LINE + GAP;
    const size = [Math.max(...boxes.map((box) => box.right)) - left, rows.length * height];
    const panels = charts.map((chart, k) => drawing(chart, boxes[k].left - left, rows.indexOf(Math.round(boxes[k].top)) * height, k));
    const [wide, high] = [size[0] + 2 * EDGE, size[1] + EDGE].map(round);
    return `<svg xmlns="${SPACE}" xml:space="preserve" width="${wide}" height="${high}" viewBox="${-EDGE} ${-EDGE / 2} ${wide} ${high}" font-family="sans-serif" font-size="12" fill="${color("text")}">`
      + `<rect x="${-EDGE}" y="${-EDGE / 2}" width="100%" height="100%" fill="${color("card")}"/>${panels.join("")}</svg>`;
  };

  const offer = (name, type, content) => {
    const link = Report.element("a", { download: name, href: URL.createObjectURL(new Blob([content], { type })) });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  };

  /** Buttons that save charts; `charts` returns those that are there when one is pressed. */
  Report.savers = (name, charts) => [["CSV", "text/csv", Report.csv], ["SVG", "image/svg+xml", Report.svg]].map(([kind, type, made]) => {
    const button = Report.element("button", { type: "button", className: "tool", textContent: kind, title: `save as ${kind}` });
    button.setAttribute("aria-label", `save as ${kind}`);
    button.addEventListener("click", () => offer(`${name}.${kind.toLowerCase()}`, type, made(charts())));
    return button;
  });
})();
