// SPDX-License-Identifier: Apache-2.0
// The satellite in its orbit axes: x ahead, z to the Earth, which is down on the canvas.
"use strict";

(() => {
  const AXES = [["x", "blue", [1, 0, 0]], ["y", "vermillion", [0, 1, 0]], ["z", "green", [0, 0, 1]]];
  const HALF = [0.32, 0.32, 0.38], SPAN = [0.42, 1.25], WIDTH = 0.24;

  const corner = (k) => HALF.map((h, i) => (k & (1 << i) ? h : -h));
  const FACES = [[0, 2, 6, 4], [1, 3, 7, 5], [0, 1, 5, 4], [2, 3, 7, 6], [0, 1, 3, 2], [4, 5, 7, 6]];
  const EDGES = [[0, 1], [2, 3], [4, 5], [6, 7], [0, 2], [1, 3], [4, 6], [5, 7], [0, 4], [1, 5], [2, 6], [3, 7]];
  const PANELS = [1, -1].map((side) => [[-WIDTH, side * SPAN[0], 0], [WIDTH, side * SPAN[0], 0], [WIDTH, side * SPAN[1], 0], [-WIDTH, side * SPAN[1], 0]]);

  /** Orbit axes to the axes of the canvas, whose z is up. */
  const upright = ([x, y, z]) => [x, -y, -z];

  const turn = (values, prefix) => {
    const rotate = Report.turned(values[`${prefix}roll`], values[`${prefix}pitch`], values[`${prefix}yaw`]);
    return (point) => upright(rotate(point));
  };

  const solid = (painter, place) => {
    const [edge, metal] = [Report.color("text"), Report.color("metal")];
    for (const face of FACES) painter.face(face.map((k) => place(corner(k))), metal, edge, 0.96);
    for (const panel of PANELS) {
      painter.face(panel.map(place), Report.color("cells"), edge, 0.92);
      for (const share of [1 / 3, 2 / 3]) {
        const cut = [0, 1].map((k) => panel[k].map((v, i) => v + share * (panel[3 - k][i] - v)));
        painter.line(cut.map(place), metal, 0.8, { nearer: 0.03 });
      }
      const root = [[0, Math.sign(panel[0][1]) * HALF[1], 0], [0, panel[0][1], 0]];
      painter.line(root.map(place), edge, 2);
    }
    for (const [name, color, way] of AXES) {
      const from = way.map((v, k) => v * (k === 1 ? SPAN[1] : HALF[k])), to = way.map((v, k) => v * (k === 1 ? 1.55 : 0.95));
      painter.arrow(place(from), place(to), Report.color(color), 2.4, name, { nearer: 0.05 });
    }
  };

  const wires = (painter, place, color, dash) => {
    for (const [a, b] of EDGES) painter.line([place(corner(a)), place(corner(b))], color, 1.6, { dash, nearer: 2 });
    for (const panel of PANELS) painter.line(panel.map(place), color, 1.6, { dash, closed: true, nearer: 2 });
  };

  const shown = (angle) => (Math.abs(angle) < 0.05 ? "0.0" : angle.toFixed(1).replace("-", "−"));

  Report.scenes.satellite = {
    camera: { azimuth: -1.1, elevation: 0.42, distance: 8 },
    draw({ context, size, camera, now, other }) {
      const scale = Math.min(size.width / 3.2, size.height / 2.75);
      const painter = new Report.Painter(context, camera.project(size, scale));
      const soft = Report.color("grey");
      painter.arrow(upright([0, 0, 0]), upright([1.4, 0, 0]), soft, 1, "flight", { dash: [2, 5] });
      painter.arrow(upright([0, 0, 0]), upright([0, 0, 1.12]), soft, 1, "Earth", { dash: [2, 5] });
      solid(painter, turn(now, ""));
      wires(painter, turn(now, "ym_"), Report.color("purple"), []);
      if (other) wires(painter, turn(other, ""), Report.color("orange"), [4, 4]);
      painter.paint();
      const off = ["roll", "pitch", "yaw"].map((axis) => (180 / Math.PI) * (now[axis] - now[`ym_${axis}`]));
      const said = `error  roll ${shown(off[0])}°   pitch ${shown(off[1])}°   yaw ${shown(off[2])}°`;
      Report.write(context, said, 14, 18, Report.color("text"), { align: "left" });
      Report.write(context, "wire frame: reference model", 14, size.height - 16, Report.color("purple"), { align: "left", size: 12 });
    },
  };
})();
