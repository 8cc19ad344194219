// The stream from the server: names and sizes as JSON, positions as binary frames. It reconnects by
// itself after a restart of the server.
import { layer } from "./robots.js";

const THINGS = 1; // kind of a binary frame with the things in the field

export function openStream(page, take) {
  let socket;
  let wait = 250;
  function open() {
    const address = new URL(`field?page=${page}`, document.baseURI);
    address.protocol = address.protocol.replace("http", "ws");
    socket = new WebSocket(address);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => (wait = 250);
    socket.onmessage = ({ data }) => take(typeof data === "string" ? JSON.parse(data) : frame(data));
    socket.onclose = ({ code }) => {
      if (code === 4404) return; // the server no longer knows this page, which reloads
      setTimeout(open, wait);
      wait = Math.min(2 * wait, 4000);
    };
  }
  open();
}

function frame(data) {
  const view = new DataView(data);
  if (view.getUint32(0, true) !== THINGS) return layer(data);
  const n = view.getUint32(4, true);
  return {
    t: "frame",
    cycle: view.getFloat64(8, true),
    n,
    places: new Float32Array(data, 16, 3 * n),
    colors: new Uint8Array(data, 16 + 12 * n, n),
    modes: new Uint8Array(data, 16 + 13 * n, n),
  };
}
