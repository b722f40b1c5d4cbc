// SPDX-License-Identifier: Apache-2.0
// The numbers of the page, and its colours.
"use strict";

const Report = { data: JSON.parse(document.getElementById("data").textContent) };

/** Numbers from base64 of 32-bit little-endian floats. */
Report.floats = (text) => {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const view = new DataView(bytes.buffer);
  return Float32Array.from({ length: bytes.length / 4 }, (_, k) => view.getFloat32(4 * k, true));
};

/** The present colour of a name of the palette, which differs between light and dark; asking the style is slow. */
Report.colors = new Map();
Report.color = (name) => {
  if (!Report.colors.has(name)) {
    Report.colors.set(name, getComputedStyle(document.documentElement).getPropertyValue(`--c-${name}`).trim() || name);
  }
  return Report.colors.get(name);
};

/** The text of a power of ten, 1e-5 as 1×10⁻⁵. */
Report.power = (text) => text.replace(/e\+?(-?\d+)/, (_, n) => `×10${n.replace(/./g, (sign) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(sign)])}`);

/** A number for reading: four digits, a proper minus. */
Report.number = (value) => {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  const size = Math.abs(value);
  if (size === Infinity) return value > 0 ? "∞" : "−∞";
  const text = size && (size < 1e-3 || size >= 1e5) ? Report.power(value.toExponential(2)) : String(Number(value.toPrecision(4)));
  return text.replaceAll("-", "−");
};

/** The text of a label with markup. */
Report.words = (html) => new DOMParser().parseFromString(html, "text/html").body.textContent;

/** Call `then` whenever light turns to dark or back, also for paper. */
Report.onTheme = (then) => matchMedia("screen and (prefers-color-scheme: dark)").addEventListener("change", then);
Report.onTheme(() => Report.colors.clear()); // before those that draw

/** Call `then` once, as soon as an element comes near the window. */
Report.whenNear = (element, then) => {
  const observer = new IntersectionObserver((entries) => {
    if (!entries.some((entry) => entry.isIntersecting)) return;
    observer.disconnect();
    then();
  }, { rootMargin: "600px" });
  observer.observe(element);
};

/** An element with properties and children. */
Report.element = (tag, properties = {}, ...children) => {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
};
