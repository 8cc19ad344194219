// The field on one canvas: draws what the stream tells, between two moments too, and lets a person
// look closer, choose things and drag them about.
import { openStream } from "./stream.js";

// As in markers.py.
export const STATE_COLORS = [
  "#3b82d6", "#2fa36b", "#e08a2c", "#a66bd4", "#d6568a", "#2aa5b8",
  "#8f8a2e", "#d65a4a", "#6b7bd6", "#4f9a8f", "#b87a4b", "#8a93a3",
];
const JUMP = 2.5; // m; nothing moves so far in a cycle: it was put there
const CALL_MS = 1400;
const TRAIL = 90;
const NAMED = 26; // things; with more, names are shown for chosen ones only
const MANY = 120; // things; with more, they are drawn smaller

class Field {
  constructor(canvas, session) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.roster = { names: [], kinds: [], radii: [], size: [20, 20], legend: [] };
    this.now = this.before = null;
    this.chosen = new Set();
    this.calls = [];
    this.orders = [];
    this.trails = null;
    this.view = { scale: 0, x: 0, y: 0, fitted: true };
    this.drag = null;
    this.hovered = -1;
    this.drawn = this.frames = 0;
    this.recolor();
    this.listen();
    openStream(session, (message) => this.take(message));
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    this.resize();
    setInterval(() => {
      if (this.view.fitted && this.fittedTo !== this.margins().join(" ")) this.fit();
    }, 300);
  }

  // -- what comes from the server

  take(message) {
    if (message.t === "frame") this.takeFrame(message);
    else if (message.t === "roster") this.takeRoster(message);
    else if (message.t === "say") this.takeCalls(message.said);
    else if (message.t === "order") this.orders.push({ ...message, until: performance.now() + 2200 });
    else if (message.t === "chosen") this.chosen = new Set(message.names);
    this.redraw();
  }

  takeRoster(roster) {
    const size = this.roster.size;
    if (roster.names.join() !== this.roster.names.join()) {
      this.cancelDrag(); // what is dragged is another thing by now, or none
      this.before = this.now = null;
      this.trails = this.trails && new Map();
    }
    this.roster = roster;
    this.looks = roster.kinds.map((kind) => roster.looks[kind]);
    // From the lowest layer to the highest, each in the order of the roster.
    this.order = [...roster.names.keys()].sort((a, b) => this.looks[a].layer - this.looks[b].layer);
    this.index = new Map(roster.names.map((name, i) => [name, i]));
    if (this.view.fitted || size[0] !== roster.size[0]) this.fit();
    document.getElementById("field-empty")?.setAttribute("hidden", "");
  }

  takeFrame(frame) {
    const at = performance.now();
    if (frame.n !== this.roster.names.length) return;
    this.frames += 1;
    const gap = this.now ? Math.min(Math.max(at - this.now.at, 20), 400) : 100;
    this.before = this.now;
    this.now = { ...frame, at, gap };
    if (this.trails) this.keepTrails();
  }

  takeCalls(said) {
    const until = performance.now() + CALL_MS;
    for (const [i, text] of said) {
      this.calls = this.calls.filter((call) => call.i !== i);
      this.calls.push({ i, text, until });
    }
  }

  keepTrails() {
    const { places, n } = this.now;
    for (let i = 0; i < n; i++) {
      if (n > MANY && !this.chosen.has(this.roster.names[i])) continue;
      let trail = this.trails.get(i);
      if (!trail) this.trails.set(i, (trail = []));
      const [x, y] = [places[3 * i], places[3 * i + 1]];
      const last = trail[trail.length - 1];
      if (last && Math.hypot(x - last[0], y - last[1]) > JUMP) trail.length = 0;
      trail.push([x, y]);
      if (trail.length > TRAIL) trail.shift();
    }
  }

  // -- where things are on the screen

  resize() {
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    const ratio = window.devicePixelRatio || 1;
    this.canvas.width = Math.max(1, clientWidth * ratio);
    this.canvas.height = Math.max(1, clientHeight * ratio);
    this.canvas.style.width = `${clientWidth}px`;
    this.canvas.style.height = `${clientHeight}px`;
    this.width = clientWidth;
    this.height = clientHeight;
    this.ratio = ratio;
    if (this.view.fitted) this.fit();
    this.redraw();
  }

  fit() {
    const [w, h] = this.roster.size;
    const [top, bottom] = this.margins();
    this.fittedTo = `${top} ${bottom}`;
    const scale = Math.min((this.width - 40) / w, (this.height - top - bottom) / h);
    this.view = { scale, x: this.width / 2, y: top + (this.height - top - bottom) / 2, fitted: true };
    this.redraw();
  }

  // What lies over the field at its top and bottom.
  margins() {
    const banner = document.querySelector(".banner");
    const deck = document.querySelector(".deck");
    return [
      (banner ? banner.offsetHeight + 10 : 44) + 32,
      (deck ? deck.offsetHeight + 12 : 0) + 24,
    ];
  }

  toScreen(x, y) {
    return [this.view.x + x * this.view.scale, this.view.y - y * this.view.scale];
  }

  toField(px, py) {
    return [(px - this.view.x) / this.view.scale, (this.view.y - py) / this.view.scale];
  }

  zoom(factor, px = this.width / 2, py = this.height / 2) {
    const scale = Math.min(Math.max(this.view.scale * factor, 0.5), 400);
    const ratio = scale / this.view.scale;
    this.view = {
      scale,
      x: px - (px - this.view.x) * ratio,
      y: py - (py - this.view.y) * ratio,
      fitted: false,
    };
    this.redraw();
  }

  place(i, at) {
    const { now, before } = this;
    const [x, y, heading] = now.places.subarray(3 * i, 3 * i + 3);
    const dragged = this.drag?.moved && this.drag.places.get(i);
    if (dragged) return [...dragged, heading];
    if (!before || before.n !== now.n || at >= 1) return [x, y, heading];
    const [x0, y0, heading0] = before.places.subarray(3 * i, 3 * i + 3);
    if (Math.abs(x - x0) > JUMP || Math.abs(y - y0) > JUMP) return [x, y, heading];
    const turn = Math.atan2(Math.sin(heading - heading0), Math.cos(heading - heading0));
    return [x0 + (x - x0) * at, y0 + (y - y0) * at, heading0 + turn * at];
  }

  radius(i) {
    const real = this.roster.radii[i] * this.view.scale;
    const n = this.roster.names.length;
    const least = n > MANY ? 2.2 : n > NAMED || this.looks[i].shape === "ball" ? 5 : 8;
    return Math.max(real, least);
  }

  thingAt(px, py) {
    if (!this.now) return -1;
    let best = -1;
    let nearest = Infinity;
    for (let i = 0; i < this.now.n; i++) {
      const [x, y] = this.toScreen(this.now.places[3 * i], this.now.places[3 * i + 1]);
      const away = Math.hypot(px - x, py - y) - this.radius(i);
      if (away < 6 && away < nearest) [best, nearest] = [i, away];
    }
    return best;
  }

  // -- drawing

  recolor() {
    const style = getComputedStyle(document.documentElement);
    const color = (name) => style.getPropertyValue(name).trim();
    this.font = style.getPropertyValue("--font");
    this.colors = {
      field: color("--field"), line: color("--field-line"), grid: color("--field-grid"),
      ink: color("--ink"), faint: color("--ink-3"), paper: color("--surface"),
      training: color("--training"), testing: color("--testing"), accent: color("--accent"),
    };
    this.redraw();
  }

  redraw() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.draw();
    });
  }

  draw() {
    const { context: c, now } = this;
    if (!this.width) return;
    const time = performance.now();
    this.drawn += 1;
    c.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    c.clearRect(0, 0, this.width, this.height);
    this.drawGround(c);
    if (!now) return;
    const at = (time - now.at) / now.gap;
    const screen = new Float32Array(3 * now.n);
    for (let i = 0; i < now.n; i++) {
      const [x, y, heading] = this.place(i, at);
      const [px, py] = this.toScreen(x, y);
      screen.set([px, py, heading], 3 * i);
    }
    if (this.trails) this.drawTrails(c);
    this.drawOrders(c, screen, time);
    this.drawThings(c, screen);
    this.drawCalls(c, screen, time);
    if (at < 1 || this.calls.length || this.orders.length) this.redraw();
  }

  drawGround(c) {
    const [w, h] = this.roster.size;
    const [left, top] = this.toScreen(-w / 2, h / 2);
    const [width, height] = [w * this.view.scale, h * this.view.scale];
    c.fillStyle = this.colors.field;
    c.fillRect(left, top, width, height);
    c.lineWidth = 1;
    c.strokeStyle = this.colors.grid;
    const step = [1, 2, 5, 10, 20, 50, 100, 200].find((s) => s * this.view.scale >= 42) || 500;
    c.beginPath();
    for (let x = Math.ceil(-w / 2 / step) * step; x <= w / 2; x += step) {
      const px = Math.round(this.toScreen(x, 0)[0]) + 0.5;
      c.moveTo(px, top);
      c.lineTo(px, top + height);
    }
    for (let y = Math.ceil(-h / 2 / step) * step; y <= h / 2; y += step) {
      const py = Math.round(this.toScreen(0, y)[1]) + 0.5;
      c.moveTo(left, py);
      c.lineTo(left + width, py);
    }
    c.stroke();
    c.strokeStyle = this.colors.line;
    c.lineWidth = 1.5;
    c.strokeRect(left, top, width, height);
    c.fillStyle = this.colors.faint;
    c.font = `11px ${this.font}`;
    c.textAlign = "right";
    c.textBaseline = "top";
    if (this.now) c.fillText(`${w.toFixed(0)} × ${h.toFixed(0)} m · grid ${step} m`, left + width, top + height + 4);
  }

  fill(i) {
    const color = this.now.colors[i];
    if (color !== 255) return STATE_COLORS[color];
    return this.looks[i].color;
  }

  drawThings(c, screen) {
    const { now } = this;
    const many = now.n > MANY;
    for (const i of this.order) {
      const [px, py, heading] = screen.subarray(3 * i, 3 * i + 3);
      if (px < -30 || py < -30 || px > this.width + 30 || py > this.height + 30) continue;
      const radius = this.radius(i);
      const look = this.looks[i];
      const mode = now.modes[i];
      if (mode === 3 || mode === 4) {
        c.strokeStyle = mode === 3 ? this.colors.training : this.colors.testing;
        c.lineWidth = 3;
        c.beginPath();
        c.arc(px, py, radius + 4.5, 0, 2 * Math.PI);
        c.stroke();
      }
      c.fillStyle = this.fill(i);
      c.globalAlpha = look.opacity;
      c.beginPath();
      if (look.shape === "square") c.rect(px - radius, py - radius, 2 * radius, 2 * radius);
      else c.arc(px, py, radius, 0, 2 * Math.PI);
      c.fill();
      c.globalAlpha = 1;
      if (look.shape === "ball") {
        c.strokeStyle = this.colors.ink;
        c.lineWidth = 1;
        c.stroke();
      }
      if (look.faces) {
        c.strokeStyle = many ? this.fill(i) : this.colors.ink;
        c.lineWidth = many ? 1.2 : 2;
        c.lineCap = "round";
        c.beginPath();
        const from = many ? 0 : 0.35 * radius;
        c.moveTo(px + from * Math.cos(heading), py - from * Math.sin(heading));
        c.lineTo(px + 1.65 * radius * Math.cos(heading), py - 1.65 * radius * Math.sin(heading));
        c.stroke();
      }
      const name = this.roster.names[i];
      const chosen = this.chosen.has(name);
      if (chosen || i === this.hovered) {
        c.strokeStyle = chosen ? this.colors.accent : this.colors.faint;
        c.lineWidth = 2;
        c.setLineDash(chosen ? [] : [3, 3]);
        c.beginPath();
        c.arc(px, py, radius + (mode > 2 ? 8.5 : 5), 0, 2 * Math.PI);
        c.stroke();
        c.setLineDash([]);
      }
      const named = now.n <= NAMED && look.labelled;
      if (named || chosen || i === this.hovered) {
        c.fillStyle = chosen ? this.colors.ink : this.colors.faint;
        c.font = `${chosen ? 600 : 400} 11px ${this.font}`;
        c.textAlign = "center";
        c.textBaseline = "top";
        c.fillText(name.replaceAll("_", " "), px, py + radius + 7);
      }
    }
  }

  drawTrails(c) {
    c.lineWidth = 1.5;
    for (const [i, trail] of this.trails) {
      if (i >= this.now.n) continue;
      c.strokeStyle = this.fill(i);
      c.globalAlpha = 0.45;
      c.beginPath();
      trail.forEach(([x, y], k) => c[k ? "lineTo" : "moveTo"](...this.toScreen(x, y)));
      c.stroke();
    }
    c.globalAlpha = 1;
  }

  drawOrders(c, screen, time) {
    this.orders = this.orders.filter((order) => order.until > time);
    for (const order of this.orders) {
      const ids = order.to.map((name) => this.index?.get(name)).filter((i) => i !== undefined);
      if (!ids.length) continue;
      const x = ids.reduce((sum, i) => sum + screen[3 * i], 0) / ids.length;
      const y = ids.reduce((sum, i) => sum + screen[3 * i + 1], 0) / ids.length;
      c.globalAlpha = Math.min(1, (order.until - time) / 900);
      c.strokeStyle = this.colors.accent;
      c.lineWidth = 1.2;
      c.beginPath();
      for (const i of ids) {
        c.moveTo(x, y);
        c.lineTo(screen[3 * i], screen[3 * i + 1]);
      }
      c.stroke();
      if (this.orders.length <= 6) {
        this.bubble(c, `${order.from}: ${order.order}`, x, y, this.colors.accent, this.colors.paper);
      }
      c.globalAlpha = 1;
    }
  }

  drawCalls(c, screen, time) {
    this.calls = this.calls.filter((call) => call.until > time && call.i < this.now.n);
    for (const { i, text, until } of this.calls) {
      c.globalAlpha = Math.min(1, (until - time) / 400);
      const [px, py] = [screen[3 * i], screen[3 * i + 1]];
      this.bubble(c, `“${text}”`, px, py - this.radius(i) - 16, this.colors.ink, this.colors.paper);
      c.globalAlpha = 1;
    }
  }

  bubble(c, text, x, y, back, front) {
    c.font = `600 11px ${this.font}`;
    const width = c.measureText(text).width + 14;
    c.fillStyle = back;
    c.beginPath();
    c.roundRect(x - width / 2, y - 10, width, 20, 10);
    c.fill();
    c.fillStyle = front;
    c.textAlign = "center";
    c.textBaseline = "middle";
    c.fillText(text, x, y);
  }

  // -- what a person does

  key(key) {
    if (key === "f") this.fit();
    else if (key === "l") this.toggleTrails();
    else if (key === "+" || key === "=") this.zoom(1.25);
    else if (key === "-") this.zoom(0.8);
  }

  toggleTrails() {
    this.trails = this.trails ? null : new Map();
    document.getElementById("trails")?.setAttribute("aria-pressed", String(!!this.trails));
    this.redraw();
  }

  listen() {
    const { canvas } = this;
    const pointers = new Map();
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoom(Math.exp(-event.deltaY * 0.0015), event.offsetX, event.offsetY);
    }, { passive: false });
    canvas.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return; // a menu opens, or the page scrolls
      canvas.setPointerCapture(event.pointerId);
      pointers.set(event.pointerId, [event.offsetX, event.offsetY]);
      if (pointers.size === 2) this.beginPinch(pointers);
      else this.beginDrag(event);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (pointers.has(event.pointerId)) pointers.set(event.pointerId, [event.offsetX, event.offsetY]);
      if (this.pinch) this.movePinch(pointers);
      else if (this.drag) this.moveDrag(event);
      else this.hover(event);
    });
    const end = (event) => {
      if (!pointers.delete(event.pointerId)) return;
      if (this.pinch) this.pinch = pointers.size ? this.pinch : null;
      else if (this.drag && event.type === "pointerup") this.endDrag(event);
      else this.cancelDrag();
    };
    // Only letting go puts a thing somewhere. The capture is lost after each of the others, too,
    // and alone when the page is left or something else takes the pointer.
    for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) {
      canvas.addEventListener(name, end);
    }
    window.addEventListener("blur", () => this.cancelDrag());
    canvas.addEventListener("dblclick", () => this.fit());
    document.addEventListener("click", (event) => {
      if (event.target.closest("#trails")) this.toggleTrails();
      else if (event.target.closest("#fit")) this.fit();
      else if (event.target.closest("#zoom-in")) this.zoom(1.25);
      else if (event.target.closest("#zoom-out")) this.zoom(0.8);
    });
  }

  hover(event) {
    const found = this.thingAt(event.offsetX, event.offsetY);
    if (found !== this.hovered) {
      this.hovered = found;
      this.canvas.style.cursor = found >= 0 ? "grab" : "default";
      this.redraw();
    }
  }

  beginDrag(event) {
    const i = this.thingAt(event.offsetX, event.offsetY);
    const from = [event.offsetX, event.offsetY];
    const starts = new Map();
    if (i >= 0) {
      const name = this.roster.names[i];
      const together = this.chosen.has(name) ? [...this.chosen] : [name];
      for (const other of together) {
        const k = this.index.get(other);
        if (k !== undefined) starts.set(k, [this.now.places[3 * k], this.now.places[3 * k + 1]]);
      }
    }
    const turning = i >= 0 && event.altKey;
    this.drag = { i, from, starts, places: new Map(), moved: false, view: { ...this.view }, turning };
  }

  moveDrag(event) {
    const { drag } = this;
    const [dx, dy] = [event.offsetX - drag.from[0], event.offsetY - drag.from[1]];
    if (!drag.moved && Math.hypot(dx, dy) < 4) return;
    drag.moved = true;
    this.canvas.style.cursor = "grabbing";
    if (drag.i < 0) {
      this.view = { ...drag.view, x: drag.view.x + dx, y: drag.view.y + dy, fitted: false };
    } else if (!drag.turning) {
      const [w, h] = this.roster.size;
      for (const [k, [x, y]] of drag.starts) {
        const to = [x + dx / this.view.scale, y - dy / this.view.scale];
        drag.places.set(k, [clamp(to[0], w / 2), clamp(to[1], h / 2)]);
      }
    }
    this.redraw();
  }

  endDrag(event) {
    const { drag } = this;
    this.drag = null;
    this.canvas.style.cursor = "default";
    if (drag.i < 0) {
      if (!drag.moved) window.studioTell("deselect");
    } else if (!drag.moved) {
      window.studioTell("choose", { name: this.roster.names[drag.i], more: event.shiftKey });
    } else if (drag.turning) {
      const [x, y] = this.toField(event.offsetX, event.offsetY);
      const turned = {};
      for (const [k, [x0, y0]] of drag.starts) {
        turned[this.roster.names[k]] = { heading: Math.atan2(y - y0, x - x0) };
      }
      window.studioTell("place", { things: turned });
    } else {
      const things = {};
      for (const [k, [x, y]] of drag.places) {
        things[this.roster.names[k]] = { x, y, vx: 0, vy: 0 };
        // Shown there at once; the world's answer follows.
        this.now.places.set([x, y], 3 * k);
        this.before?.places.set([x, y], 3 * k);
      }
      window.studioTell("place", { things });
    }
    this.redraw();
  }

  // Gives up a drag as if it had not begun; tells whether there was one.
  cancelDrag() {
    const { drag } = this;
    if (!drag) return false;
    this.drag = null;
    if (drag.i < 0 && drag.moved) this.view = drag.view;
    this.canvas.style.cursor = "default";
    this.redraw();
    return true;
  }

  beginPinch(pointers) {
    this.cancelDrag();
    this.pinch = { apart: apart(pointers) };
  }

  movePinch(pointers) {
    if (pointers.size < 2) return;
    const now = apart(pointers);
    const [[ax, ay], [bx, by]] = [...pointers.values()];
    this.zoom(now / this.pinch.apart, (ax + bx) / 2, (ay + by) / 2);
    this.pinch.apart = now;
  }
}

const clamp = (value, most) => Math.min(Math.max(value, -most), most);

function apart(pointers) {
  const [[ax, ay], [bx, by]] = [...pointers.values()];
  return Math.max(1, Math.hypot(ax - bx, ay - by));
}

function begin() {
  const canvas = document.getElementById("field");
  if (!canvas) return requestAnimationFrame(begin);
  window.studioField = new Field(canvas, window.STUDIO_SESSION);
}
begin();
