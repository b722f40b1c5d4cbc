// SPDX-License-Identifier: Apache-2.0
// Three dimensions on a canvas: a camera that can be turned, and lines and faces sorted by their depth.
"use strict";

(() => {
  const TURN = 0.008, STEP = 0.1;

  /** A camera by azimuth and elevation (rad) around the upward z axis; `perspective` is its distance in scene units. */
  Report.camera = ({ azimuth, elevation, distance }) => {
    const camera = { azimuth, elevation };
    const views = { "oblique": [azimuth, elevation], "along x": [0, 0], "along y": [Math.PI / 2, 0], "from above": [-Math.PI / 2, Math.PI / 2] };
    const turn = (a, e, redraw) => {
      camera.azimuth += a;
      camera.elevation = Math.max(-1.5, Math.min(1.5, camera.elevation + e));
      redraw();
    };
    /** A function from a point to [x, y, depth] on the canvas. */
    camera.project = ({ width, height }, scale, middle = [0, 0, 0]) => {
      const ca = Math.cos(camera.azimuth), sa = Math.sin(camera.azimuth);
      const ce = Math.cos(camera.elevation), se = Math.sin(camera.elevation);
      return (point) => {
        const [x, y, z] = point.map((v, k) => v - middle[k]);
        const right = -sa * x + ca * y, up = -se * (ca * x + sa * y) + ce * z, near = ce * (ca * x + sa * y) + se * z;
        const size = (scale * distance) / (distance - near);
        return [width / 2 + size * right, height / 2 - size * up, near];
      };
    };
    /** Offer the views in a list of choices. */
    camera.offer = (list, redraw) => {
      list.append(...Object.keys(views).map((name) => Report.element("option", { textContent: name })));
      list.addEventListener("change", () => { [camera.azimuth, camera.elevation] = views[list.value]; redraw(); });
    };
    /** Turn by dragging, and with shift and the arrow keys. */
    camera.follow = (canvas, redraw) => {
      canvas.classList.add("turns");
      canvas.addEventListener("pointermove", (event) => {
        if (event.buttons & 1) turn(-TURN * event.movementX, TURN * event.movementY, redraw);
      });
      canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
      canvas.addEventListener("keydown", (event) => {
        const steps = { ArrowLeft: [STEP, 0], ArrowRight: [-STEP, 0], ArrowUp: [0, STEP], ArrowDown: [0, -STEP] };
        if (event.shiftKey && event.key in steps) { turn(...steps[event.key], redraw); event.preventDefault(); }
      });
    };
    return camera;
  };

  /** Things to draw, the farthest first. */
  Report.Painter = class {
    constructor(context, project) { Object.assign(this, { context, project, things: [] }); }

    add(points, paint, nearer = 0) {
      const flat = points.map(this.project);
      const depth = flat.reduce((sum, [, , near]) => sum + near, 0) / flat.length;
      this.things.push([depth + nearer, () => paint(flat)]);
    }

    path(flat, closed) {
      this.context.beginPath();
      flat.forEach(([x, y], k) => (k ? this.context.lineTo(x, y) : this.context.moveTo(x, y)));
      if (closed) this.context.closePath();
    }

    line(points, color, width, { dash = [], closed = false, alpha = 1, nearer = 0 } = {}) {
      this.add(points, (flat) => {
        const c = this.context;
        this.path(flat, closed);
        Object.assign(c, { strokeStyle: color, lineWidth: width, lineCap: "round", lineJoin: "round", globalAlpha: alpha });
        c.setLineDash(dash);
        c.stroke();
        c.setLineDash([]);
        c.globalAlpha = 1;
      }, nearer);
    }

    face(points, fill, edge, alpha = 1) {
      this.add(points, (flat) => {
        const c = this.context;
        this.path(flat, true);
        Object.assign(c, { fillStyle: fill, strokeStyle: edge, lineWidth: 1, globalAlpha: alpha, lineJoin: "round" });
        c.fill();
        c.globalAlpha = 1;
        c.stroke();
      });
    }

    dot(point, radius, fill, edge, { hollow = false, nearer = 0.02 } = {}) {
      this.add([point], ([[x, y]]) => {
        const c = this.context;
        c.beginPath();
        c.arc(x, y, radius, 0, 2 * Math.PI);
        Object.assign(c, { fillStyle: fill, strokeStyle: hollow ? fill : edge, lineWidth: hollow ? 2 : 1 });
        if (!hollow) c.fill();
        c.stroke();
      }, nearer);
    }

    arrow(tail, head, color, width, text = "", options = {}) {
      this.line([tail, head], color, width, options);
      this.add([tail, head], ([[x0, y0], [x1, y1]]) => {
        const c = this.context, length = Math.hypot(x1 - x0, y1 - y0);
        if (length < 4) return;
        const [ux, uy, size] = [(x1 - x0) / length, (y1 - y0) / length, 3 + 2.2 * width];
        c.beginPath();
        c.moveTo(x1 + ux * size, y1 + uy * size);
        c.lineTo(x1 - uy * size * 0.55, y1 + ux * size * 0.55);
        c.lineTo(x1 + uy * size * 0.55, y1 - ux * size * 0.55);
        c.fillStyle = color;
        c.fill();
        if (!text) return;
        c.font = "13px system-ui, sans-serif";
        const gap = size + 6 + Math.abs(ux) * (c.measureText(text).width / 2) + Math.abs(uy) * 6;
        Report.write(c, text, x1 + ux * gap, y1 + uy * gap, color);
      }, 0.01);
    }

    paint() { this.things.sort(([a], [b]) => a - b).forEach(([, paint]) => paint()); }
  };

  /** Text centred at a point of the canvas. */
  Report.write = (context, text, x, y, color) => {
    Object.assign(context, { fillStyle: color, font: "13px system-ui, sans-serif", textAlign: "center", textBaseline: "middle" });
    context.fillText(text, x, y);
  };
})();
