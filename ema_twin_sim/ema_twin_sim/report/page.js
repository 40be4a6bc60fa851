"use strict";
(() => {
  const PRINTED_WIDTH = 660; // pixels: an A4 page less its margins
  const charts = JSON.parse(document.getElementById("charts").textContent);
  const places = [...document.querySelectorAll("[data-chart]")];
  const root = document.documentElement;
  const choice = document.getElementById("recording");
  const coarse = matchMedia("(pointer: coarse)").matches;
  const hidden = new Set();

  // a colour is named "@before" in a chart; the style sheet knows it, on light ground and on dark
  const coloured = (part, style) => {
    if (typeof part === "string") return part[0] === "@" ? style.getPropertyValue("--" + part.slice(1)).trim() : part;
    if (Array.isArray(part)) return part.map((each) => coloured(each, style));
    if (part === null || typeof part !== "object") return part;
    return Object.fromEntries(Object.entries(part).map(([key, value]) => [key, coloured(value, style)]));
  };

  const axis = (own) => ({
    gridcolor: "@grid", zerolinecolor: "@rule", linecolor: "@rule", automargin: true, nticks: 7, ...own,
    title: { standoff: 6, font: { size: 12 }, ...(own && own.title) },
  });

  const layoutOf = (chart, chosen) => {
    const layout = {
      font: { family: "system-ui, sans-serif", size: 12, color: "@text" },
      paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", showlegend: false,
      hovermode: "closest", hoverlabel: { bgcolor: "@raised", bordercolor: "@rule", font: { color: "@text" } },
      dragmode: coarse ? false : "zoom", modebar: { bgcolor: "rgba(0,0,0,0)", color: "@faint", activecolor: "@text" },
      ...chart.layout, ...(chosen && chosen.layout),
      margin: { l: 56, r: 12, t: 28, b: 44, ...chart.layout.margin }, // at the top, room for the buttons
    };
    for (const name of ["xaxis", "yaxis", "yaxis2"]) {
      const own = { ...chart.layout[name], ...(chosen && chosen.layout && chosen.layout[name]) };
      if (Object.keys(own).length || name !== "yaxis2") layout[name] = axis(own);
    }
    return layout;
  };

  const draw = (place, width) => {
    const chart = charts[+place.dataset.chart];
    const chosen = chart.choices && chart.choices[choice.selectedIndex];
    const traces = (chosen ? chosen.traces : chart.traces).map((trace) => ({ ...trace, visible: !hidden.has(trace.meta) }));
    const style = getComputedStyle(root);
    const layout = { ...layoutOf(chart, chosen), ...(width ? { width } : {}) };
    return Plotly.react(place, coloured(traces, style), coloured(layout, style), {
      displaylogo: false, displayModeBar: coarse || width ? false : "hover", responsive: !width, modeBarButtons: [["toImage", "resetScale2d"]],
    });
  };
  const drawAll = (width) => Promise.all(places.map((place) => draw(place, width)));

  // what is zoomed in one chart is zoomed in all that are linked to it
  const link = (place) => {
    const group = charts[+place.dataset.chart].link;
    if (!group) return;
    place.on("plotly_relayout", (change) => {
      const keys = Object.keys(change).filter((key) => key.startsWith("xaxis."));
      if (!keys.length || change.linked) return;
      const same = Object.fromEntries(keys.map((key) => [key, change[key]]));
      for (const other of places) {
        if (other !== place && charts[+other.dataset.chart].link === group) Plotly.relayout(other, { ...same, linked: true });
      }
    });
  };

  for (const button of document.querySelectorAll("button[data-role]")) {
    button.addEventListener("click", () => {
      const role = button.dataset.role;
      const hide = !hidden.has(role);
      if (hide) hidden.add(role); else hidden.delete(role);
      button.setAttribute("aria-pressed", String(!hide));
      drawAll();
    });
  }
  choice?.addEventListener("change", () => drawAll());
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => drawAll());
  addEventListener("beforeprint", () => {
    root.classList.add("printed");
    document.querySelectorAll("details").forEach((each) => { each.open = true; });
    drawAll(PRINTED_WIDTH);
  });
  addEventListener("afterprint", () => {
    root.classList.remove("printed");
    drawAll();
  });

  drawAll().then(() => {
    places.forEach(link);
    root.dataset.drawn = String(places.length);
  });
})();
