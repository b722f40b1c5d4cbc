// SPDX-License-Identifier: Apache-2.0
// The triangle in the plane, and its shape in the disc.
"use strict";

(() => {
  const RODS = ["blue", "vermillion", "green"];
  const TRAIL = 4; // seconds

  const corners = (values) => [1, 2, 3].map((k) => [values[`x${k}`], values[`y${k}`]]);

  const stroke = (c, points, color, width, { closed = false, dash = [], alpha = 1 } = {}) => {
    c.beginPath();
    points.forEach(([x, y], k) => (k ? c.lineTo(x, y) : c.moveTo(x, y)));
    if (closed) c.closePath();
    Object.assign(c, { strokeStyle: color, lineWidth: width, globalAlpha: alpha, lineCap: "round", lineJoin: "round" });
    c.setLineDash(dash);
    c.stroke();
    c.setLineDash([]);
    c.globalAlpha = 1;
  };

  const dot = (c, [x, y], radius, fill, edge) => {
    c.beginPath();
    c.arc(x, y, radius, 0, 2 * Math.PI);
    Object.assign(c, { fillStyle: fill, strokeStyle: edge, lineWidth: 1.5 });
    c.fill();
    c.stroke();
  };

  const body = (c, points, { width = 5, alpha = 1, mass = 9 }) => {
    RODS.forEach((name, k) => stroke(c, [points[(k + 1) % 3], points[(k + 2) % 3]], Report.color(name), width, { alpha }));
    c.globalAlpha = alpha;
    points.forEach((point) => dot(c, point, mass, Report.color("black"), Report.color("card")));
    c.globalAlpha = 1;
  };

  const plane = ({ context: c, constants, run, now, other, time }, place) => {
    const grey = Report.color("grey");
    stroke(c, constants.target.map(place), grey, 1.5, { closed: true, dash: [6, 5] });
    const trail = [0, 1, 2].map(() => []);
    for (let row = run.t.findIndex((t) => t > time - TRAIL); row >= 0 && run.t[row] < time; row++) {
      trail.forEach((points, k) => points.push(place([run.columns[`x${k + 1}`][row], run.columns[`y${k + 1}`][row]])));
    }
    trail.forEach((points) => points.length > 1 && stroke(c, points, grey, 1.5, { alpha: 0.5 }));
    if (other) body(c, corners(other).map(place), { width: 2, alpha: 0.45, mass: 5 });
    body(c, corners(now).map(place), {});
    const centre = place([0, 0]), reach = 0.36;
    const along = (angle) => place([reach * Math.cos(angle), reach * Math.sin(angle)]);
    stroke(c, [centre, along(0)], grey, 1.2);
    stroke(c, [centre, along(now.theta)], Report.color("purple"), 2);
    const [x, y] = along(now.theta);
    Report.write(c, "θ", x + 12 * Math.cos(now.theta), y - 12 * Math.sin(now.theta), Report.color("purple"), { size: 15 });
  };

  const disc = ({ context: c, constants, run, now, other, time }, middle, radius) => {
    const scale = radius / constants.rim, [text, grey] = [Report.color("text"), Report.color("grey")];
    const at = (x, y) => [middle[0] + scale * x, middle[1] - scale * y];
    const ring = (r, color, dash) => {
      c.beginPath();
      c.arc(...middle, scale * r, 0, 2 * Math.PI);
      Object.assign(c, { strokeStyle: color, lineWidth: 1.2 });
      c.setLineDash(dash);
      c.stroke();
      c.setLineDash([]);
    };
    ring(constants.rim, grey, [4, 4]);
    ring(constants.R, text, []);
    const path = [];
    for (let k = 0; k < run.t.length && run.t[k] <= time; k += 1) path.push(at(run.columns.shape_x[k], run.columns.shape_y[k]));
    if (path.length > 1) stroke(c, path, Report.color("blue"), 1.6);
    dot(c, at(...constants.shape), 5, Report.color("card"), Report.color("purple"));
    if (other) dot(c, at(other.shape_x, other.shape_y), 4, grey, Report.color("card"));
    dot(c, at(now.shape_x, now.shape_y), 5.5, Report.color("orange"), Report.color("card"));
    Report.write(c, "shape", middle[0], middle[1] - radius - 14, text);
    Report.write(c, "ρ = R", middle[0] - 0.62 * radius, middle[1] + 0.98 * radius, Report.color("soft"), { size: 11 });
  };

  Report.scenes.triangle = {
    draw(frame) {
      const { width, height } = frame.size, narrow = width < 520;
      const radius = narrow ? 52 : Math.min(105, width * 0.16);
      const scale = narrow ? Math.min(width / 0.86, (height - radius) / 0.72) : Math.min((width - 2 * radius) / 0.86, height / 0.78);
      const middle = narrow ? [0.46 * width, 0.42 * height] : [(width - 2.1 * radius) / 2, 0.52 * height];
      plane(frame, ([x, y]) => [middle[0] + scale * x, middle[1] - scale * y]);
      disc(frame, [width - radius - 14, narrow ? height - radius - 8 : radius + 28], radius);
    },
  };
})();
