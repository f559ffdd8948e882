// Numbers of the page, and what all views share.
const Data = (() => {
  const STEPS = 65534;
  const MISSING = 65535;
  // A column packed by the program; NaN where there is no number.
  function unpack(packed) {
    if (!packed) return null;
    if (packed.values) return packed.values;
    const bytes = Uint8Array.from(atob(packed.codes), (letter) => letter.charCodeAt(0));
    const view = new DataView(bytes.buffer);
    const size = packed.bits / 8;
    const step = (packed.high - packed.low) / STEPS;
    const values = new Float64Array(bytes.length / size);
    for (let i = 0; i < values.length; i++) {
      const code = size === 2 ? view.getUint16(2 * i, true) : view.getFloat32(4 * i, true);
      values[i] = size === 4 ? code : code === MISSING ? NaN : packed.low + code * step;
    }
    packed.values = values;
    packed.codes = null;
    return values;
  }
  // Four significant digits.
  function number(value) {
    if (!Number.isFinite(value)) return "\u2013";
    if (value === 0) return "0";
    const size = Math.abs(value);
    const text = size >= 1e6 || size < 1e-4 ? value.toExponential(3) : String(Number(value.toPrecision(4)));
    return text.replaceAll("-", "\u2212");
  }
  const withUnit = (value, unit) => number(value) + (unit && Number.isFinite(value) ? (unit === "\u00b0" ? "" : "\u00a0") + unit : "");
  const labelled = (label, unit) => (unit ? label + " [" + unit + "]" : label);
  // The round number up to `wanted` by which displacements are drawn larger; 1 where they need not be.
  function larger(wanted) {
    if (!Number.isFinite(wanted) || wanted <= 1) return 1;
    const power = 10 ** Math.floor(Math.log10(wanted));
    return power * [5, 2, 1].find((n) => n * power <= wanted);
  }
  return { unpack, number, withUnit, labelled, larger };
})();

// Controls of a view.
const Controls = {
  select(parent, label, options, act) {
    const select = document.createElement("select");
    options.forEach((text, index) => select.add(new Option(text, String(index))));
    select.addEventListener("change", () => act(Number(select.value)));
    Controls.labelled(parent, label, select);
    return select;
  },
  // Whether an option can be picked.
  offer(select, index, isThere) {
    select.options[index].hidden = !isThere;
    select.options[index].disabled = !isThere;
  },
  slider(parent, label, describe, act) {
    const slider = document.createElement("input");
    slider.type = "range";
    slider.min = "0";
    slider.step = "1";
    const output = document.createElement("output");
    const show = () => {
      output.textContent = describe(Number(slider.value));
      slider.setAttribute("aria-valuetext", output.textContent);
    };
    slider.addEventListener("input", () => {
      show();
      act(Number(slider.value));
    });
    const wrapper = Controls.labelled(parent, label, slider);
    wrapper.append(output);
    return {
      reset(text, count, value) {
        wrapper.hidden = count < 2;
        wrapper.style.display = count < 2 ? "none" : "";
        wrapper.firstChild.textContent = text;
        slider.max = String(count - 1);
        slider.value = String(value);
        show();
      },
    };
  },
  labelled(parent, label, control) {
    const wrapper = document.createElement("label");
    const text = document.createElement("span");
    text.textContent = label;
    wrapper.append(text, control);
    parent.append(wrapper);
    return wrapper;
  },
  button(parent, label, name, act) {
    const button = document.createElement("button");
    button.type = "button";
    button.className = "control";
    button.textContent = label;
    button.setAttribute("aria-label", name);
    button.addEventListener("click", act);
    parent.append(button);
  },
  chart(parent, title, className) {
    const box = document.createElement("div");
    box.className = "chart " + (className || "");
    const heading = document.createElement("h4");
    heading.textContent = title;
    const plot = document.createElement("div");
    plot.className = "plot";
    plot.setAttribute("role", "img");
    box.append(heading, plot);
    parent.append(box);
    return { box, heading, plot };
  },
};

// What all charts share.
const Chart = {
  layout(more) {
    const ink = Theme.colour("ink");
    return Object.assign(
      {
        paper_bgcolor: "rgba(0,0,0,0)",
        plot_bgcolor: "rgba(0,0,0,0)",
        font: { family: "system-ui, sans-serif", size: 13, color: ink },
        margin: { l: 62, r: 14, t: 10, b: 50 },
        hoverlabel: { bgcolor: Theme.colour("panel"), bordercolor: Theme.colour("zero"), font: { color: ink } },
        showlegend: false,
      },
      more,
    );
  },
  axis(title, more) {
    const line = { gridcolor: Theme.colour("grid"), zerolinecolor: Theme.colour("zero"), linecolor: Theme.colour("zero") };
    return Object.assign({ title: { text: title, standoff: 6 }, automargin: true, ticks: "outside", tickcolor: line.linecolor }, line, more);
  },
  bar(title) {
    return {
      title: { text: title, side: "bottom", font: { size: 13 } },
      orientation: "h", thickness: 14, len: 1, x: 0.5, yref: "container", y: 0, yanchor: "bottom", ypad: 2, outlinewidth: 0, nticks: 5,
    };
  },
  config: { responsive: true, displaylogo: false, displayModeBar: false, showTips: false },
  // Text of a user in a chart: plotly reads a few tags.
  text: (text) => text.replaceAll("&", "&amp;").replaceAll("<", "&lt;").replaceAll(">", "&gt;"),
  // A press without a drag picks what `find` returns for the points under the pointer, if it is not null.
  onPick(plot, find, act) {
    let [under, pressed] = [null, null];
    plot.on("plotly_hover", (event) => {
      under = find(event.points);
    });
    plot.on("plotly_unhover", () => {
      under = null;
    });
    plot.addEventListener("pointerdown", (event) => {
      pressed = [event.clientX, event.clientY];
    }, true);
    window.addEventListener("pointerup", (event) => {
      const isStill = pressed && Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) < 4;
      pressed = null;
      if (isStill && under !== null) act(under);
    }, true);
  },
  // The page scrolls under the wheel; with Ctrl the view comes nearer.
  scrollUnderWheel(plot) {
    plot.addEventListener("wheel", (event) => {
      if (!event.ctrlKey) event.stopImmediatePropagation();
    }, { capture: true, passive: true });
  },
  // Paper shows no WebGL: a copy of what is drawn lies over it.
  onPaper(plot, draw) {
    window.addEventListener("paper", () => {
      draw();
      const { glplot } = plot._fullLayout.scene._scene;
      // What is drawn can be read only right after it was drawn.
      glplot.redraw();
      const copy = plot.querySelector("canvas.paper") ?? document.createElement("canvas");
      copy.className = "paper";
      [copy.width, copy.height] = [glplot.canvas.width, glplot.canvas.height];
      copy.getContext("2d").drawImage(glplot.canvas, 0, 0);
      glplot.canvas.after(copy);
    });
    window.addEventListener("afterprint", () => plot.querySelector("canvas.paper")?.remove());
  },
  hasWebGl() {
    try {
      const canvas = document.createElement("canvas");
      return Boolean(canvas.getContext("webgl2") || canvas.getContext("webgl"));
    } catch (fault) {
      return false;
    }
  },
};
