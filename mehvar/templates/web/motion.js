// SPDX-License-Identifier: Apache-2.0
// The system in motion: the geometry of its model at the places of the run that the simulator has, again and again.
"use strict";

(() => {
  const SHOWN = 15; // seconds in which a run is shown, as in the report
  const PLACES = 120; // of a run, from which the size of the picture is taken; the view has a margin of a third
  const still = matchMedia("(prefers-reduced-motion: reduce)");

  const named = (values) => Object.fromEntries(Array.from(values, (value, k) => [`point${k}`, value]));

  /** `then(time)` is called with every frame that is shown. */
  Report.Motion = class {
    constructor(root, simulator, shapes, then) {
      Object.assign(this, { simulator, shapes, then, time: 0, end: 0, rows: 0, playing: false, paused: still.matches });
      [this.canvas, this.button, this.scrub, this.told] = root.querySelectorAll("canvas, button, input, output");
      this.camera = Report.camera(Report.geometry.camera);
      this.camera.follow(this.canvas, () => this.draw());
      this.camera.offer(root.querySelector("select"), () => this.draw());
      this.button.addEventListener("click", () => this.toggle());
      this.scrub.addEventListener("input", () => { this.stop(); this.paused = true; this.go(Number(this.scrub.value)); });
      this.canvas.addEventListener("keydown", (event) => { if (event.key === " ") { this.toggle(); event.preventDefault(); } });
      new ResizeObserver(() => { this.resize(); this.draw(); }).observe(this.canvas.parentElement);
      new IntersectionObserver(([entry]) => { this.visible = entry.isIntersecting; this.wake(); }).observe(this.canvas);
      Report.onTheme(() => this.draw());
      this.resize();
    }

    /** Show a run that has ended, from where the one before was. */
    take() {
      const share = this.end ? this.time / this.end : 0, { t } = this.simulator.rows();
      this.t = t.slice();
      this.rows = t.length;
      this.end = t[this.rows - 1];
      this.scrub.max = this.end;
      const every = Math.max(1, Math.floor(this.rows / PLACES)), columns = {};
      for (let row = 0; row < this.rows; row += every) this.simulator.points(row).forEach((v, k) => (columns[`point${k}`] ??= []).push(v));
      this.reached = [{ columns }];
      this.go(share * this.end);
      this.wake();
    }

    /** While a run is computed there is nothing to play. */
    rest() { this.stop(); this.rows = 0; }

    wake() { if (this.visible && this.rows && !this.paused) this.start(); else this.stop(); }

    toggle() {
      this.paused = this.playing;
      this.wake();
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
        const next = this.time + (passed * this.end) / SHOWN;
        this.go(next > this.end ? 0 : next);
        requestAnimationFrame(frame);
      };
      requestAnimationFrame(frame);
    }

    stop() { this.playing = false; this.show(); }

    show() {
      this.button.textContent = this.playing ? "❚❚" : "▶";
      this.button.setAttribute("aria-label", this.playing ? "Pause" : "Play");
    }

    go(time) {
      this.time = Math.min(this.end, Math.max(0, time));
      this.scrub.value = this.time;
      this.told.textContent = `${this.time.toFixed(1)} s`;
      this.draw();
      this.then(this.time);
    }

    resize() {
      const { clientWidth: width, clientHeight: height } = this.canvas, ratio = devicePixelRatio || 1;
      Object.assign(this.canvas, { width: Math.round(width * ratio), height: Math.round(height * ratio) });
    }

    /** The points at this time, between two rows on straight lines. */
    now() {
      let low = 0, high = this.rows - 1;
      while (high - low > 1) { const middle = (low + high) >> 1; if (this.t[middle] <= this.time) low = middle; else high = middle; }
      const [from, to] = [this.simulator.points(low), this.simulator.points(high)];
      const share = Math.min(1, (this.time - this.t[low]) / (this.t[high] - this.t[low] || 1));
      return named(from.map((v, k) => v + share * (to[k] - v)));
    }

    draw() {
      if (!this.rows) return;
      const ratio = devicePixelRatio || 1, context = this.canvas.getContext("2d");
      const size = { width: this.canvas.width / ratio, height: this.canvas.height / ratio };
      context.setTransform(ratio, 0, 0, ratio, 0, 0);
      context.clearRect(0, 0, size.width, size.height);
      const { camera, shapes, reached: runs } = this;
      Report.geometry.draw({ context, size, camera, shapes, runs, now: this.now() });
    }
  };
})();
