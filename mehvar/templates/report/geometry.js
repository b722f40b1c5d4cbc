// SPDX-License-Identifier: Apache-2.0
// A system that declares its geometry: its shapes, from the coordinates of their points; z up.
"use strict";

(() => {
  /** The corners of a box, from its centre and the middles of three faces; corner k is on the far side of face i where bit i is set. */
  const corners = ([centre, ...middles]) => Array.from({ length: 8 }, (_, k) => centre.map((v, axis) =>
    middles.reduce((sum, middle, i) => sum + (k & (1 << i) ? -1 : 1) * (middle[axis] - centre[axis]), v)));
  const SIDES = [[0, 2, 6, 4], [1, 3, 7, 5], [0, 1, 5, 4], [2, 3, 7, 6], [0, 1, 3, 2], [4, 5, 7, 6]];

  const draw = {
    rod: (painter, points, color, ghost) => painter.line(points, color, ghost ? 2 : 4, ghost),
    arrow: (painter, [tail, head], color, ghost) => painter.arrow(tail, head, color, ghost ? 1.5 : 2.5, "", ghost || {}),
    ball: (painter, [centre], color, ghost) => painter.dot(centre, ghost ? 6 : 9, color, Report.color("card"), { hollow: Boolean(ghost) }),
    face: (painter, points, color, ghost, alpha = 0.85) => ghost ? painter.line(points, color, 1.5, { ...ghost, closed: true }) : painter.face(points, color, Report.color("text"), alpha),
    box: (painter, points, color, ghost) => {
      const eight = corners(points);
      for (const side of SIDES) draw.face(painter, side.map((k) => eight[k]), color, ghost, 0.35); // what is within is seen
    },
  };

  /** The points of each shape, where `value(name)` are their coordinates. */
  const placed = (shapes, value) => {
    let next = 0;
    return shapes.map((shape) => Array.from({ length: shape.points }, () => [0, 1, 2].map(() => value(`point${next++}`))));
  };

  const extents = new WeakMap();

  const LONGEST = 1.3; // of an arrow, in radii of what is no arrow: a torque of a failing run would make the rest a dot

  /** An arrow that is not too long. */
  const bounded = ([tail, head], size) => {
    const way = head.map((v, axis) => v - tail[axis]), share = Math.min(1, (LONGEST * size) / (Math.hypot(...way) || 1));
    return [tail, tail.map((v, axis) => v + share * way[axis])];
  };

  /** Middle and radius of places. */
  const around = (places) => {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (const place of places) place.forEach((v, axis) => { low[axis] = Math.min(low[axis], v); high[axis] = Math.max(high[axis], v); });
    const middle = low.map((v, axis) => (v + high[axis]) / 2);
    return { middle, size: places.reduce((size, place) => Math.max(size, Math.hypot(...place.map((v, axis) => v - middle[axis]))), 0) || 1 };
  };

  /** Middle and radius of all that is reached, and the radius without arrows. */
  const extent = (runs, shapes) => {
    if (!extents.has(runs[0])) extents.set(runs[0], measured(runs, shapes));
    return extents.get(runs[0]);
  };

  const measured = (runs, shapes) => {
    const rows = runs.flatMap(({ columns }) => Array.from(columns.point0, (_, row) => placed(shapes, (name) => columns[name][row])));
    const drawn = rows.flatMap((row) => row.map((points, k) => [points, shapes[k].kind === "arrow"])).filter(([points]) => points.flat().every(Number.isFinite));
    const solid = drawn.filter(([, arrow]) => !arrow).flatMap(([points]) => points);
    const body = solid.length ? around(solid).size : Infinity;
    return { ...around(drawn.flatMap(([points, arrow]) => (arrow ? bounded(points, body) : points))), body };
  };

  Report.geometry = {
    camera: { azimuth: -1.25, elevation: 0.2, distance: 8 },
    draw({ context, size, camera, shapes, runs, now, other }) {
      const reach = extent(runs, shapes), scale = 0.42 * Math.min(size.width, size.height);
      const painter = new Report.Painter(context, camera.project(size, scale));
      const near = (point) => point.map((v, axis) => (v - reach.middle[axis]) / reach.size);
      const grey = Report.color("grey"), origin = near([0, 0, 0]);
      ["x", "y", "z"].forEach((name, axis) => {
        const end = origin.map((v, k) => v + (k === axis ? 0.5 : 0));
        painter.arrow(origin, end, grey, 1, name, { dash: [2, 5] });
      });
      const show = (values, ghost) => placed(shapes, (name) => values[name]).forEach((points, k) => {
        if (!points.flat().every(Number.isFinite)) return;
        const { kind, color } = shapes[k], whole = kind === "arrow" ? bounded(points, reach.body) : points;
        draw[kind](painter, whole.map(near), Report.color(color), ghost);
      });
      show(now);
      if (other) show(other, { dash: [4, 4], alpha: 0.7 });
      painter.paint();
    },
  };
})();
