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

  Report.players = {};
  for (const root of document.querySelectorAll("[data-scene]")) {
    const name = root.dataset.scene;
    Report.players[name] = new Report.Player(root, Report.data.scenes[name], Report.scenes[name]);
  }

  const filters = document.querySelectorAll("[data-filter]");
  const apply = () => {
    const wanted = Array.from(filters, (filter) => [filter.dataset.filter, filter.value]);
    let shown = 0;
    for (const row of document.querySelectorAll("tr[data-paper]")) {
      row.hidden = wanted.some(([key, value]) => value && row.dataset[key] !== value);
      shown += !row.hidden;
    }
    document.getElementById("shown").textContent = `${shown} claims`;
  };
  filters.forEach((filter) => filter.addEventListener("change", apply));

  addEventListener("beforeprint", () => document.querySelectorAll("details").forEach((details) => { details.open = true; }));
  document.documentElement.dataset.ready = "yes";
})();
