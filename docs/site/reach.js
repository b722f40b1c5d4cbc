// SPDX-License-Identifier: Apache-2.0
// What the theme's scripts leave out: bars of buttons are no landmarks, and what scrolls is reached with the keyboard.
"use strict";

(() => {
  const mend = () => {
    for (const bar of document.querySelectorAll("nav.md-code__nav:not([role])")) bar.setAttribute("role", "none");
    for (const box of document.querySelectorAll(".md-typeset__scrollwrap, pre > code")) {
      if (box.scrollWidth > box.clientWidth && box.tabIndex < 0) box.tabIndex = 0;
    }
  };
  new MutationObserver(mend).observe(document.body, { childList: true, subtree: true, attributeFilter: ["tabindex"] });
  addEventListener("resize", mend);
  mend();
})();
