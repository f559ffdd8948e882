// Tables sorted by a click on a column's header.
document.querySelectorAll("table.sortable").forEach((table) => {
  const headers = [...table.tHead.rows[0].cells];
  const body = table.tBodies[0];
  headers.forEach((header, column) => {
    header.querySelector("button").addEventListener("click", () => {
      const down = header.getAttribute("aria-sort") === "ascending";
      headers.forEach((other) => other.removeAttribute("aria-sort"));
      header.setAttribute("aria-sort", down ? "descending" : "ascending");
      const key = (row) => row.cells[column].dataset.sort ?? row.cells[column].textContent.trim();
      const compare = (a, b) => {
        // Empty cells stay last in either direction.
        if (a === b) return 0;
        if (a === "" || a === "\u2013") return 1;
        if (b === "" || b === "\u2013") return -1;
        const difference = Number(a) - Number(b);
        const order = Number.isNaN(difference) ? a.localeCompare(b, "en", { numeric: true }) : difference;
        return down ? -order : order;
      };
      const rows = [...body.rows].map((row) => [key(row), row]);
      rows.sort((a, b) => compare(a[0], b[0]));
      body.append(...rows.map(([, row]) => row));
    });
  });
});
