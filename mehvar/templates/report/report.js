// SPDX-License-Identifier: Apache-2.0
// Brings the page to life: charts, stages, filters, printing.
"use strict";

(() => {
  for (const box of document.querySelectorAll("figure[data-view]")) {
    const build = Report.figure(box.querySelector("[data-chart]"));
    const swap = box.querySelector("[data-part=swap]");
    let built = false;
    const show = (view) => {
      box.dataset.view = view;
      swap.textContent = view === "chart" ? "show the picture" : "show values, zoom";
      if (view === "chart" && !built) { built = true; Report.whenNear(box, build); }
    };
    swap.addEventListener("click", () => show(box.dataset.view === "chart" ? "picture" : "chart"));
    show(box.dataset.view);
  }

  for (const button of document.querySelectorAll("figure [data-part=save]")) button.addEventListener("click", () => {
    const figure = button.closest("figure");
    Report.element("a", { href: figure.querySelector("img").src, download: `${figure.id}.png` }).click();
  });

  for (const button of document.querySelectorAll("[data-part=enlarge]")) button.addEventListener("click", () => {
    button.setAttribute("aria-pressed", String(button.closest("figure").classList.toggle("large")));
  });

  Report.players = {};
  for (const root of document.querySelectorAll("[data-scene]")) {
    const name = root.dataset.scene;
    Report.players[name] = new Report.Player(root, Report.data.scenes[name]);
  }

  /** What is wider than its box is reached with the keyboard too, and has a shadow at the edge beyond which there is more. */
  const shade = (box) => box.toggleAttribute("data-more", box.scrollLeft + box.clientWidth < box.scrollWidth - 2);
  const wide = new ResizeObserver((entries) => entries.forEach(({ target }) => {
    if (target.scrollWidth > target.clientWidth) target.tabIndex = 0; else target.removeAttribute("tabindex");
    shade(target);
  }));
  document.querySelectorAll(".scroll, .formula, .edits, .picture").forEach((box) => {
    wide.observe(box);
    box.addEventListener("scroll", () => shade(box), { passive: true });
  });

  /** On a phone each row of some tables is a card: a cell then needs the name of its column. */
  for (const table of document.querySelectorAll(".wide")) {
    const names = Array.from(table.tHead?.rows[0].cells ?? [], (cell) => cell.textContent);
    for (const { cells } of table.rows) for (const cell of cells) {
      if (cell.colSpan === 1 && cell.textContent.trim() && names[cell.cellIndex]) cell.dataset.column = names[cell.cellIndex];
    }
  }

  const filters = Array.from(document.querySelectorAll("[data-filter]"));
  const apply = () => {
    const wanted = Array.from(filters, (filter) => filter.value.split(":"));
    const shown = Array.from(document.querySelectorAll("tbody[data-kind]"), (body) => {
      const rows = Array.from(body.querySelectorAll("tr[data-paper]"));
      for (const row of rows) row.hidden = wanted.some(([key, value]) => key && row.dataset[key] !== value);
      body.hidden = rows.every((row) => row.hidden);
      const count = rows.filter((row) => !row.hidden).length, { kind } = body.dataset;
      return `${count} ${count === 1 ? kind.replace(/s\b/, "") : kind}`;
    });
    document.getElementById("shown").textContent = shown.join(", ");
  };
  /** The address holds the filters, so that it can be sent: #claims?paper=slosh. */
  const save = () => {
    const chosen = new URLSearchParams(filters.filter(({ value }) => value).map(({ value }) => value.split(":")));
    try { history.replaceState(null, "", `#${filters[0].closest("section").id}?${chosen}`); } catch { /* frames may refuse */ }
  };
  const restore = () => {
    const [, values] = location.hash.split("?");
    if (!filters.length || values === undefined) return;
    const chosen = Array.from(new URLSearchParams(values), (pair) => pair.join(":"));
    for (const filter of filters) filter.value = chosen.find((value) => Array.from(filter.options).some((o) => o.value === value)) ?? "";
    apply();
  };
  filters.forEach((filter) => filter.addEventListener("change", () => { apply(); save(); }));
  addEventListener("hashchange", restore);
  restore();

  /** Paper has no folds: what was measured is printed. Nothing scrolls there: wide formulas are smaller. */
  const SHEET = 680, SMALLER = 0.75; // pixels between the margins of A4; its letters by those of the screen
  let folded = [];
  const fold = (open) => folded.forEach((part) => { part.open = open; });
  addEventListener("beforeprint", () => {
    folded = document.querySelectorAll("details.checks:not([open])");
    fold(true);
    const widths = Array.from(document.querySelectorAll("math"), (formula) => [formula, SMALLER * formula.getBoundingClientRect().width]);
    for (const [formula, width] of widths) if (width > SHEET) formula.style.fontSize = `${SHEET / width}em`;
  });
  addEventListener("afterprint", () => {
    fold(false);
    document.querySelectorAll("math[style]").forEach((formula) => formula.removeAttribute("style"));
  });

  /** Keep what a link leads to under its eye while charts above it are still being built; until the reader moves. */
  const land = () => {
    const target = document.getElementById(decodeURIComponent(location.hash.slice(1).split("?")[0]));
    if (!target) return;
    for (let part = target; part; part = part.parentElement) if (part.tagName === "DETAILS") part.open = true;
    target.querySelectorAll(":scope > details.checks").forEach((part) => { part.open = true; });
    const align = () => target.scrollIntoView({ block: "start", behavior: "instant" });
    const watch = new ResizeObserver(align), moves = ["wheel", "touchmove", "keydown", "pointerdown"];
    const leave = () => { watch.disconnect(); moves.forEach((name) => removeEventListener(name, leave)); };
    moves.forEach((name) => addEventListener(name, leave, { passive: true }));
    addEventListener("hashchange", leave, { once: true });
    watch.observe(document.querySelector("main"));
  };
  addEventListener("hashchange", land);
  land();
  document.documentElement.dataset.ready = "yes";
})();
