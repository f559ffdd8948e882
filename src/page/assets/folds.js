// Paper shows what is folded; what there is to copy is copied by a button.
(() => {
  const folds = [...document.querySelectorAll("details.fold")];
  let closed = [];
  window.addEventListener("beforeprint", () => {
    closed = folds.filter((fold) => !fold.open);
    closed.forEach((fold) => (fold.open = true));
  });
  window.addEventListener("afterprint", () => closed.forEach((fold) => (fold.open = false)));
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
})();
