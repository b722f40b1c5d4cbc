// SPDX-License-Identifier: Apache-2.0
// Play, pause, scrub: a stage with the picture of a system, charts beside it, and one time for both.
"use strict";

(() => {
  const still = matchMedia("(prefers-reduced-motion: reduce)");

  const decoded = (run) => ({
    t: Report.floats(run.t),
    columns: Object.fromEntries(Object.entries(run.columns).map(([name, text]) => [name, Report.floats(text)])),
  });

  /** The values of a run at a time, between its samples on straight lines. */
  Report.sample = (run, time) => {
    const { t, columns } = run, last = t.length - 1;
    let low = 0, high = last;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (t[middle] <= time) low = middle; else high = middle;
    }
    const share = Math.min(1, Math.max(0, (time - t[low]) / (t[high] - t[low] || 1)));
    const values = { t: time };
    for (const name in columns) values[name] = columns[name][low] + share * (columns[name][high] - columns[name][low]);
    return values;
  };

  const option = (text, value = text) => Report.element("option", { textContent: text, value });

  /** One stage: `root` is the element with the controls, `data` the runs. */
  class Player {
    constructor(root, data) {
      Object.assign(this, { root, data, time: 0, playing: false, seen: false, paused: false, charts: [] });
      this.runs = Object.fromEntries(Object.entries(data.runs).map(([title, run]) => [title, decoded(run)]));
      this.part = (name) => root.querySelector(`[data-part="${name}"]`);
      this.canvas = this.part("canvas");
      this.camera = Report.camera(Report.geometry.camera);
      this.fill();
      this.listen();
      this.resize();
      this.draw();
    }

    get run() { return this.runs[this.part("run").value]; }
    get other() { return this.runs[this.part("compare").value]; }
    get end() { return this.run.t[this.run.t.length - 1]; }

    fill() {
      const titles = Object.keys(this.runs);
      this.part("run").append(...titles.map((title) => option(title)));
      this.part("compare").append(option("nothing", ""), ...titles.map((title) => option(title)));
      this.part("speed").append(...[...this.data.speeds].sort((a, b) => a - b).map((s) => option(`${s}×`, s)));
      this.part("speed").value = this.data.speeds[0];
      this.part("scrub").max = this.end;
    }

    listen() {
      this.part("play").addEventListener("click", () => this.toggle());
      this.part("scrub").addEventListener("input", (event) => this.go(Number(event.target.value)));
      for (const name of ["run", "compare"]) this.part(name).addEventListener("change", () => this.choose());
      this.canvas.addEventListener("keydown", (event) => this.key(event));
      this.camera.follow(this.canvas, () => this.draw());
      this.camera.offer(this.part("view"), () => this.draw());
      new ResizeObserver(() => { this.resize(); this.draw(); }).observe(this.canvas.parentElement);
      const tracks = this.part("tracks");
      new ResizeObserver(() => this.charts.forEach(({ chart }) => {
        if (tracks.clientWidth && chart.width !== tracks.clientWidth) chart.setSize({ width: tracks.clientWidth, height: chart.height });
      })).observe(tracks);
      new IntersectionObserver(([entry]) => this.appear(entry.intersectionRatio > 0.5), { threshold: [0, 0.5, 0.6] })
        .observe(this.canvas);
      Report.onTheme(() => { this.build(); this.draw(); });
    }

    /** Start by itself when it comes into view, unless the reader has paused it or wants no motion. */
    appear(visible) {
      if (visible && !this.seen) { this.seen = true; this.build(); }
      if (!visible) this.stop();
      else if (!this.paused && !still.matches) this.start();
    }

    key(event) {
      const step = this.end / 100;
      const moves = { ArrowRight: step, ArrowLeft: -step, Home: -Infinity, End: Infinity };
      if (event.key === " ") this.toggle();
      else if (event.key in moves && !event.shiftKey) { this.stop(); this.paused = true; this.go(this.time + moves[event.key]); }
      else return;
      event.preventDefault();
    }

    choose() {
      this.part("scrub").max = this.end;
      this.build();
      this.go(Math.min(this.time, this.end));
    }

    toggle() {
      this.paused = this.playing;
      if (this.playing) this.stop(); else { if (this.time >= this.end) this.go(0); this.start(); }
    }

    start() {
      if (this.playing) return;
      this.playing = true;
      this.show();
      let before = null;
      const frame = (now) => {
        if (!this.playing) return;
        const passed = before === null ? 0 : Math.min(0.1, (now - before) / 1000);
        before = now;
        const next = this.time + passed * Number(this.part("speed").value);
        this.go(next > this.end ? 0 : next);
        requestAnimationFrame(frame);
      };
      requestAnimationFrame(frame);
    }

    stop() { this.playing = false; this.show(); }

    show() {
      const button = this.part("play");
      button.textContent = this.playing ? "❚❚" : "▶";
      button.setAttribute("aria-label", this.playing ? "Pause" : "Play");
      this.root.dataset.state = this.playing ? "playing" : "paused";
    }

    go(time) {
      this.time = Math.min(this.end, Math.max(0, time));
      this.part("scrub").value = this.time;
      this.draw();
    }

    resize() {
      const { clientWidth: width, clientHeight: height } = this.canvas, ratio = window.devicePixelRatio || 1;
      this.canvas.width = Math.round(width * ratio);
      this.canvas.height = Math.round(height * ratio);
    }

    draw() {
      const ratio = window.devicePixelRatio || 1, context = this.canvas.getContext("2d");
      const size = { width: this.canvas.width / ratio, height: this.canvas.height / ratio };
      context.setTransform(ratio, 0, 0, ratio, 0, 0);
      context.clearRect(0, 0, size.width, size.height);
      Report.geometry.draw({
        context, size, camera: this.camera, shapes: this.data.shapes,
        now: Report.sample(this.run, this.time), other: this.other && Report.sample(this.other, this.time), runs: Object.values(this.runs),
      });
      this.part("time").textContent = `${this.time.toFixed(1)} s`;
      this.part("scrub").setAttribute("aria-valuetext", `${this.time.toFixed(1)} seconds`);
      for (const { chart, head } of this.charts) {
        const at = chart.valToPos(this.time, "x");
        head.style.transform = `translateX(${at}px)`;
        head.hidden = !(at >= 0 && at <= chart.over.clientWidth);
      }
    }

    /** The series of a panel; those of another run are taken at this run's times. */
    lines(panel, other = null) {
      return panel.lines.map((line) => {
        const values = other ? this.run.t.map((t) => Report.sample(other, t)[line.column]) : this.run.columns[line.column];
        const look = other ? { name: `${line.name}, beside`, dash: [2, 3], width: 1 } : { dash: [] };
        return { ...line, ...look, y: values };
      });
    }

    /** Charts of the run beside the picture; a click on one goes to that time. */
    build() {
      if (!this.seen) return;
      const host = this.part("tracks"), group = Report.group(`scene:${this.root.dataset.scene}`);
      this.charts.forEach(({ chart }) => chart.destroy());
      host.replaceChildren();
      this.charts = this.data.panels.map((panel) => {
        const box = Report.element("div", { className: "panel" }, Report.element("div", { className: "label", innerHTML: panel.label }));
        host.append(box);
        const lines = [...this.lines(panel), ...(this.other ? this.lines(panel, this.other) : [])];
        const chart = Report.panel(box, { x: this.run.t, lines, label: panel.label, limits: [0, this.end] }, group, 132);
        const head = Report.element("div", { className: "playhead" });
        chart.over.append(head);
        chart.over.addEventListener("click", () => {
          if (chart.cursor.left >= 0) { this.stop(); this.paused = true; this.go(chart.posToVal(chart.cursor.left, "x")); }
        });
        return { chart, head };
      });
      queueMicrotask(() => this.draw()); // charts know their limits only now, and with them where the time is
    }
  }

  Report.Player = Player;
})();
