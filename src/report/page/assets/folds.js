// Folded parts: what is drawn in one is drawn when it is first seen; a link into one opens it; paper shows all of them.
const Folds = (() => {
  const folds = [...document.querySelectorAll("details.fold")];
  function whenShown(element, draw) {
    const fold = element.closest("details.fold");
    if (!fold || fold.open) return draw();
    const once = () => {
      if (!fold.open) return;
      fold.removeEventListener("toggle", once);
      draw();
    };
    fold.addEventListener("toggle", once);
  }
  function open(id) {
    const element = id && document.getElementById(id);
    const fold = element && element.closest("details.fold");
    if (fold) fold.open = true;
  }
  let closed = [];
  window.addEventListener("beforeprint", () => {
    closed = folds.filter((fold) => !fold.open);
    closed.forEach((fold) => (fold.open = true));
  });
  window.addEventListener("afterprint", () => closed.forEach((fold) => (fold.open = false)));
  document.addEventListener("click", (event) => {
    const link = event.target.closest('a[href^="#"]');
    if (link) open(link.getAttribute("href").slice(1));
  });
  document.querySelectorAll(".copy").forEach((box) => {
    const button = box.querySelector("button");
    button.addEventListener("click", () => {
      const text = box.querySelector("pre").textContent;
      const done = () => {
        button.textContent = "Copied";
        setTimeout(() => (button.textContent = "Copy"), 1500);
      };
      // A page on disk may not be allowed the clipboard: what is selected can be copied by hand.
      const select = () => {
        const range = document.createRange();
        range.selectNodeContents(box.querySelector("pre"));
        const selection = window.getSelection();
        selection.removeAllRanges();
        selection.addRange(range);
        if (document.execCommand("copy")) done();
      };
      if (navigator.clipboard) navigator.clipboard.writeText(text).then(done, select);
      else select();
    });
  });
  return { whenShown, open };
})();
