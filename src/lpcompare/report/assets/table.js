"use strict";
// The table of results: a click on a heading sorts, words and a reduction filter, a method opens its view.

// Rows without a value (a failed case) stay at the end, whichever way the column is sorted.
function compareCells(a, b, isText, sign) {
  if (isText) return sign * a.localeCompare(b, undefined, { numeric: true });
  const [x, y] = [parseFloat(a), parseFloat(b)];
  if (isNaN(x) || isNaN(y)) return isNaN(x) - isNaN(y);
  return sign * (x - y);
}

function cellText(cell) {
  return cell.dataset.value ?? cell.textContent.trim();
}

function sortTable(table, heading, order = heading.ariaSort === "ascending" ? "descending" : "ascending") {
  const column = [...heading.parentNode.children].indexOf(heading);
  for (const other of heading.parentNode.children) other.removeAttribute("aria-sort");
  heading.setAttribute("aria-sort", order);
  const sign = order === "descending" ? -1 : 1, isText = heading.dataset.kind === "text";
  const rows = [...table.tBodies[0].rows];
  rows.sort((a, b) => compareCells(cellText(a.children[column]), cellText(b.children[column]), isText, sign));
  table.tBodies[0].append(...rows);
}

// Every word must occur somewhere in the row.
function rowMatches(row, words, reduction) {
  const text = row.textContent.toLowerCase();
  return (!reduction || row.dataset.reduction === reduction) && words.every((word) => text.includes(word));
}

function filterTable(table) {
  const words = byId("filter").value.toLowerCase().split(/\s+/).filter(Boolean);
  const rows = [...table.tBodies[0].rows];
  for (const row of rows) row.hidden = !rowMatches(row, words, byId("filter-reduction").value);
  const shown = rows.filter((row) => !row.hidden).length;
  byId("filter-count").textContent = shown < rows.length ? `${shown} of ${rows.length} rows` : "";
}

function startTable() {
  const table = byId("table");
  if (!table) return;
  const show = () => { filterTable(table); table.classList.toggle("all", byId("all-columns").checked); };
  for (const heading of table.tHead.rows[0].cells) {
    heading.firstElementChild.addEventListener("click", () => { sortTable(table, heading); keepState(); });
  }
  for (const id of ["filter", "filter-reduction", "all-columns"]) byId(id).addEventListener("input", () => { show(); keepState(); });
  table.addEventListener("click", ({ target }) => {
    if (target.matches(".open")) openView(target.dataset.model, Number(target.dataset.reduction), target.textContent);
    if (target.matches(".cite")) saveText(`${target.dataset.method}.bib`, page.methods[target.dataset.method].bibtex);
  });
  byId("save-table").addEventListener("click", () => saveText("results.csv", tableText(table)));
  show();
}

// What the table shows, as CSV; a cell that a spreadsheet would take for a formula is quoted.
function tableText(table) {
  const quote = (text) => `"${(/^\s*[=+\-@]/.test(text) && isNaN(text) ? "'" : "") + text.replaceAll('"', '""')}"`;
  const rows = [table.tHead.rows[0], ...[...table.tBodies[0].rows].filter((row) => !row.hidden)];
  return rows.map((row) => [...row.cells].filter((cell) => cell.offsetParent).map((cell) => quote(cell.dataset.key ?? cellText(cell))).join(",")).join("\r\n");
}
