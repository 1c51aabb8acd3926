"use strict";
// Light or dark: the system's wish, until the button says otherwise.

function isDark() {
  const wish = document.documentElement.style.colorScheme;
  return wish ? wish === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
}

// The colour that a CSS variable stands for now; plotly does not understand var() or light-dark().
function themeColour(name) {
  const probe = document.createElement("span");
  probe.style.color = `var(${name})`;
  document.body.append(probe);
  const colour = getComputedStyle(probe).color;
  probe.remove();
  return colour;
}

function onPaper() {
  return document.documentElement.classList.contains("paper");
}

// On paper everything is light, and as wide as the paper.
function watchPrint(redraw) {
  const { style, classList } = document.documentElement;
  let wish = "";
  addEventListener("beforeprint", () => {
    wish = style.colorScheme;
    style.colorScheme = "light";
    classList.add("paper");
    redraw();
  });
  addEventListener("afterprint", () => {
    style.colorScheme = wish;
    classList.remove("paper");
    redraw();
  });
}

function watchTheme(redraw) {
  document.getElementById("theme").addEventListener("click", () => {
    document.documentElement.style.colorScheme = isDark() ? "light" : "dark";
    redraw();
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
}
