// SPDX-License-Identifier: Apache-2.0
// The spacecraft with two pendulums in its tank; x ahead, z up.
"use strict";

(() => {
  const BOBS = ["purple", "orange"];
  const RADIUS = 0.36, REAR = -0.52, FRONT = 1.2, SIDES = 24;

  const circle = (x, radius) => Array.from({ length: SIDES }, (_, k) => {
    const angle = (2 * Math.PI * k) / SIDES;
    return [x, radius * Math.sin(angle), radius * Math.cos(angle)];
  });

  const hull = (painter, turn) => {
    const grey = Report.color("grey"), fill = Report.color("metal");
    const [rear, front, nose] = [circle(REAR, RADIUS), circle(FRONT, RADIUS), circle(FRONT + 0.16, 0.6 * RADIUS)].map((ring) => ring.map(turn));
    for (let k = 0; k < SIDES; k += 1) {
      const next = (k + 1) % SIDES;
      painter.face([rear[k], rear[next], front[next], front[k]], fill, "transparent", 0.16);
      painter.face([front[k], front[next], nose[next], nose[k]], fill, "transparent", 0.3);
    }
    for (const ring of [rear, front, nose]) painter.line(ring, grey, 1, { closed: true, alpha: 0.9 });
    for (let k = 0; k < SIDES; k += 6) painter.line([rear[k], front[k], nose[k]], grey, 0.8, { alpha: 0.5 });
  };

  /** The direction in which a thrust pushes, in body axes. */
  const push = ({ delta1, delta2 }) => [
    Math.cos(delta1) * Math.cos(delta2), Math.sin(delta2), -Math.sin(delta1) * Math.cos(delta2),
  ];

  const along = (point, direction, length) => point.map((v, k) => v + length * direction[k]);

  const nozzle = (painter, turn, values, gimbal) => {
    const way = push(values), back = (length) => turn(along(gimbal, way, -length));
    painter.line([turn(gimbal), back(0.16)], Report.color("text"), 7, { alpha: 0.75 });
    painter.line([back(0.18), back(0.42)], Report.color("orange"), 9, { alpha: 0.28 });
    painter.line([back(0.18), back(0.5)], Report.color("vermillion"), 3, { alpha: 0.8 });
  };

  const pendulums = (painter, turn, values, constants, ghost) => {
    BOBS.forEach((name, k) => {
      const [phi, theta] = [values[`phi${k + 1}`], values[`theta${k + 1}`]];
      const [pivot, arm] = [constants[`h${k + 1}`], constants[`l${k + 1}`]];
      const bob = [pivot - arm * Math.cos(phi), arm * Math.sin(phi) * Math.sin(theta), arm * Math.sin(phi) * Math.cos(theta)];
      const color = Report.color(name), options = { nearer: 1, dash: ghost ? [3, 3] : [] };
      painter.line([[pivot, 0, 0], bob].map(turn), color, ghost ? 1.5 : 3, options);
      if (!ghost) painter.dot(turn([pivot, 0, 0]), 3, Report.color("text"), Report.color("card"), { nearer: 1.01 });
      painter.dot(turn(bob), k ? 7 : 11, color, Report.color("card"), { hollow: ghost, nearer: ghost ? 1.005 : 1.02 });
    });
  };

  Report.scenes.slosh = {
    camera: { azimuth: -1.95, elevation: 0.28, distance: 7 },
    draw({ context, size, camera, constants, now, other }) {
      const scale = Math.min(size.width / 2.6, size.height / 1.2);
      const painter = new Report.Painter(context, camera.project(size, scale, [0.24, 0, 0]));
      const turn = Report.turned(now.att1, now.att2, now.att3), grey = Report.color("grey");
      const gimbal = [-(constants.b + constants.d), 0, 0];
      painter.arrow([-0.95, 0, 0], [1.6, 0, 0], grey, 1, "x", { dash: [2, 5] });
      hull(painter, turn);
      nozzle(painter, turn, now, gimbal);
      pendulums(painter, turn, now, constants, false);
      if (other) pendulums(painter, turn, other, constants, true);
      const felt = [-now.ax, -now.ay, -now.az], strength = Math.hypot(...felt);
      painter.arrow(turn([0, 0, 0]), turn(along([0, 0, 0], felt.map((v) => v / strength), 0.34)), Report.color("green"), 1.8, "g",
        { dash: [5, 4], nearer: 1 });
      painter.paint();
      const degrees = (angle) => `${Report.number(Math.round((1800 / Math.PI) * angle) / 10)}°`;
      const said = `φ₁ ${degrees(now.phi1)}   φ₂ ${degrees(now.phi2)}`;
      Report.write(context, said, 14, 18, Report.color("text"), { align: "left" });
      Report.write(context, "g: apparent gravity", 14, size.height - 16, Report.color("green"), { align: "left", size: 12 });
    },
  };
})();
