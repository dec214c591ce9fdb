// How a page looks: light or dark, the panel open or folded, and the legend beside the robot where there is little room.
"use strict";

const SMALL = matchMedia("(max-width: 760px), (max-height: 500px)");
const MANY_LEGENDS = 12; // more do not fit over the picture

const look = {
  listeners: [],

  // "light" or "dark": the system's, until the button is pressed; a picture is light.
  get dark() { return document.documentElement.dataset.theme === "dark"; },

  set(dark) {
    document.documentElement.dataset.theme = dark ? "dark" : "light";
    for (const listener of this.listeners) listener(dark);
  },

  // Call `listener(dark)` now and whenever it changes.
  follow(listener) {
    this.listeners.push(listener);
    listener(this.dark);
  },

  start() {
    const system = matchMedia("(prefers-color-scheme: dark)");
    const picture = new URLSearchParams(location.hash.slice(1)).has("picture");
    this.set(system.matches && !picture);
    if (!picture) system.addEventListener("change", () => this.set(system.matches));
  },

  // The buttons over the picture: the other theme, and the panel away.
  makeTools(parent) {
    const root = document.documentElement;
    const theme = this.button(parent, "◐", () => this.set(!this.dark));
    this.follow((dark) => this.name(theme, dark ? "Light colours" : "Dark colours"));
    const fold = this.button(parent, "☰", () => {
      const folded = root.classList.toggle("folded");
      fold.setAttribute("aria-expanded", String(!folded));
      this.name(fold, folded ? "Show the panel" : "Hide the panel");
    });
    fold.setAttribute("aria-expanded", "true");
    this.name(fold, "Hide the panel");
  },

  button(parent, sign, pressed) {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = sign;
    button.addEventListener("click", pressed);
    parent.append(button);
    return button;
  },

  name(button, words) {
    button.title = words;
    button.setAttribute("aria-label", words);
  },

  // The legend lies over a corner of the picture where there is room, and in the panel where there is not.
  placeLegend(legend, scene, section) {
    const place = () => {
      const beside = SMALL.matches || legend.querySelectorAll("li").length > MANY_LEGENDS;
      (beside ? section : scene).append(legend);
      section.hidden = !beside;
    };
    SMALL.addEventListener("change", place);
    place();
  },
};

look.start();
