// Tables sorted by a click on a column's header: all rows of the file, also those that are not on the page.
document.querySelectorAll("table.sortable").forEach((table) => {
  const headers = [...table.tHead.rows[0].cells];
  const body = table.tBodies[0];
  const script = table.parentElement.querySelector("script.ranking");
  const ranking = script ? JSON.parse(script.textContent) : null;
  // Rows that this page has.
  function sortOwn(column, down) {
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
  }
  // The first of all rows of the file in this order.
  function sortAll(column, down) {
    const first = (down ? ranking.largest : ranking.smallest)[column];
    const isNumber = headers.map((header) => header.classList.contains("number"));
    body.replaceChildren(...first.map((index) => {
      const row = document.createElement("tr");
      ranking.rows[index].forEach((text, cell) => {
        const own = row.insertCell();
        own.textContent = text;
        if (!isNumber[cell]) return;
        own.className = "number";
        own.dataset.sort = text.replaceAll("\u2212", "-");
      });
      return row;
    }));
    const shown = table.closest("article")?.querySelector(".shown");
    const name = headers[column].textContent.trim();
    if (shown) shown.textContent = "The " + first.length + " of " + ranking.total + " rows with the " + (down ? "largest " : "smallest ") + name + ".";
  }
  headers.forEach((header, column) => {
    header.querySelector("button").addEventListener("click", () => {
      // Of a file that is longer than its page, the largest numbers are what one looks for first.
      const before = header.getAttribute("aria-sort");
      const down = ranking ? before !== "descending" : before === "ascending";
      headers.forEach((other) => other.removeAttribute("aria-sort"));
      header.setAttribute("aria-sort", down ? "descending" : "ascending");
      if (ranking) sortAll(column, down);
      else sortOwn(column, down);
    });
  });
});
