"use strict";
// The table of results: a click on a heading sorts, words and a reduction filter.

// Rows without a value (a failed case) stay at the end, whichever way the column is sorted.
function compareCells(a, b, isText, sign) {
  if (isText) return sign * a.localeCompare(b, undefined, { numeric: true });
  const [x, y] = [parseFloat(a), parseFloat(b)];
  if (isNaN(x) || isNaN(y)) return isNaN(x) - isNaN(y);
  return sign * (x - y);
}

function sortTable(table, heading) {
  const column = [...heading.parentNode.children].indexOf(heading);
  const descending = heading.ariaSort === "ascending";
  for (const other of heading.parentNode.children) other.removeAttribute("aria-sort");
  heading.setAttribute("aria-sort", descending ? "descending" : "ascending");
  const value = (row) => row.children[column].dataset.value ?? row.children[column].textContent.trim();
  const isText = heading.dataset.kind === "text";
  const rows = [...table.tBodies[0].rows];
  rows.sort((a, b) => compareCells(value(a), value(b), isText, descending ? -1 : 1));
  table.tBodies[0].append(...rows);
}

// Every word must occur somewhere in the row.
function rowMatches(row, words, reduction) {
  const text = row.textContent.toLowerCase();
  return (!reduction || row.dataset.reduction === reduction) && words.every((word) => text.includes(word));
}

function filterTable(table) {
  const words = document.getElementById("filter").value.toLowerCase().split(/\s+/).filter(Boolean);
  const reduction = document.getElementById("filter-reduction").value;
  const rows = [...table.tBodies[0].rows];
  for (const row of rows) row.hidden = !rowMatches(row, words, reduction);
  const shown = rows.filter((row) => !row.hidden).length;
  document.getElementById("filter-count").textContent = shown < rows.length ? `${shown} of ${rows.length} rows` : "";
}

function startTable() {
  const table = document.getElementById("table");
  if (!table) return;
  for (const heading of table.tHead.rows[0].cells) {
    heading.firstElementChild.addEventListener("click", () => sortTable(table, heading));
  }
  for (const id of ["filter", "filter-reduction"]) {
    document.getElementById(id).addEventListener("input", () => filterTable(table));
  }
  document.getElementById("all-columns").addEventListener("change", (event) => {
    table.classList.toggle("all", event.target.checked);
  });
}
