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

// On paper everything is light.
function watchPrint(redraw) {
  const style = document.documentElement.style;
  let wish = "";
  addEventListener("beforeprint", () => {
    wish = style.colorScheme;
    style.colorScheme = "light";
    redraw();
  });
  addEventListener("afterprint", () => {
    style.colorScheme = wish;
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
