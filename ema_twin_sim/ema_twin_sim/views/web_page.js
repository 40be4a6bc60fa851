"use strict";
// Starts rerun's viewer on the page, with what this machine sends to the address in the page's head.

// The viewer reports to its makers and asks them for news; nothing leaves this machine.
const fetchHere = window.fetch;
window.fetch = (what, ...more) => {
  const { hostname, protocol } = new URL(what.url ?? what, location.href);
  const here = hostname === location.hostname || protocol === "data:" || protocol === "blob:";
  return here ? fetchHere(what, ...more) : Promise.resolve(new Response(null, { status: 204 }));
};

addEventListener("load", async () => {
  const words = document.querySelector("p");
  const canvas = document.querySelector("canvas");
  const say = (text) => {
    words.textContent = text;
    words.hidden = false;
    canvas.hidden = true;
  };
  try {
    await wasm_bindgen({ module_or_path: fetch("re_viewer_bg.wasm") });
    const viewer = new wasm_bindgen.WebHandle({
      url: [document.querySelector("meta[name=sink]").content],
      hide_welcome_screen: true,
      theme: "dark",
      notebook: false,
      persist: false,
    });
    canvas.hidden = false;
    await viewer.start(canvas);
    words.hidden = true;
    setInterval(() => {
      if (viewer.has_panicked()) say(`The viewer has crashed; reload the page. ${viewer.panic_message()}`);
    }, 1000);
  } catch (error) {
    say(`This browser cannot show the view (${error}). It needs WebAssembly and WebGL: give --rrd FILE instead.`);
    console.error(error);
  }
});
