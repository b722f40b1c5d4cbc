// SPDX-License-Identifier: Apache-2.0
// What charts show, as a table of numbers or as a drawing for a paper.
"use strict";

(() => {
  const GAP = 34, LINE = 16; // pixels below a panel for its legend; height of a line of it
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

  const drawing = (chart, left, top, number) => {
    const { panel, over, axes, series } = chart, [width, height] = [over.clientWidth, over.clientHeight];
    const [x0, y0] = [over.offsetLeft, over.offsetTop + LINE], grid = Report.color("grid");
    const ticks = (axis) => axis._splits.map((at, k) => [at, axis._values[k]]).filter(([at]) => at !== null);
    const across = ticks(axes[0]).map(([at, words]) => [chart.valToPos(at, "x"), words]).filter(([x]) => x >= 0 && x <= width);
    const up = ticks(axes[1]).map(([at, words]) => [chart.valToPos(at, "y"), words]).filter(([y]) => y >= 0 && y <= height);
    const shown = series.slice(1).map((one, k) => [one, k + 1]).filter(([one]) => one.show);
    const stroke = (k) => {
      const line = panel.lines[k - 1], dash = (line.dash || []).length ? ` stroke-dasharray="${line.dash.join(" ")}"` : "";
      return `stroke="${Report.color(line.color)}" stroke-width="${Math.max(1.25, line.width || 1.5)}"${dash}`;
    };
    const levels = (panel.levels || []).map(({ at, color }) => [chart.valToPos(at, "y"), color]);
    const named = shown.filter(([, k]) => panel.lines[k - 1].name), room = width / Math.max(1, named.length);
    return `<g transform="translate(${left + x0},${top + y0})">${[
      text(-x0, -over.offsetTop - 2, heading(panel)),
      ...across.map(([x, words]) => `<path d="M${round(x)},0V${height}" stroke="${grid}"/>${text(x, height + 15, String(words), 'text-anchor="middle"')}`),
      ...up.map(([y, words]) => `<path d="M0,${round(y)}H${width}" stroke="${grid}"/>${text(-6, y + 4, String(words), 'text-anchor="end"')}`),
      text(width / 2, height + 32, "time t [s]", 'text-anchor="middle"'),
      `<clipPath id="clip${number}"><rect width="${width}" height="${height}"/></clipPath><g clip-path="url(#clip${number})" fill="none">`,
      ...levels.map(([y, color]) => `<path d="M0,${round(y)}H${width}" stroke="${Report.color(color)}"/>`),
      ...shown.map(([, k]) => `<path d="${path(chart, k)}" ${stroke(k)}/>`), "</g>",
      ...named.map(([, k], place) => `<path d="M${round(place * room)},${height + 46}h18" ${stroke(k)}/>${text(place * room + 24, height + 50, panel.lines[k - 1].name)}`),
    ].join("")}</g>`;
  };

  /** A drawing of the charts as they stand on the page, with what is zoomed and hidden. */
  Report.svg = (charts) => {
    const boxes = charts.map(({ root }) => root.getBoundingClientRect());
    const left = Math.min(...boxes.map((box) => box.left)), rows = [...new Set(boxes.map((box) => Math.round(box.top)))];
    const height = Math.max(...charts.map((chart) => chart.height)) + LINE + GAP;
    const size = [Math.max(...boxes.map((box) => box.right)) - left, rows.length * height];
    const panels = charts.map((chart, k) => drawing(chart, boxes[k].left - left, rows.indexOf(Math.round(boxes[k].top)) * height, k));
    return `<svg xmlns="${SPACE}" viewBox="0 0 ${size.map(round).join(" ")}" font-family="sans-serif" font-size="12" fill="${Report.color("text")}">`
      + `<rect width="100%" height="100%" fill="${Report.color("card")}"/>${panels.join("")}</svg>`;
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
