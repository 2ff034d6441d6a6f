// Runs the kernel, draws what it says, and listens to sliders and pointer. `window.stiction` is the page for a program.
import { scenes } from "./scenes.js";

const $ = (id) => document.getElementById(id);
const STEP = 2e-3; // s, of the kernel
const CHUNK = 8; // steps of a column of the strip
const COLUMNS = 375; // 6 s
const COLOURS = ["#9aa1ad", "#1f77b4", "#d95f02"];
const MODES = ["open", "sticks", "slips"];

const { instance } = await WebAssembly.instantiate(await (await fetch("web.wasm")).arrayBuffer());
const kernel = instance.exports;
const address = kernel.world();
kernel.trot(address, true); // makes the memory as large as it will be
const w = {}; // the world, as lib.rs lays it out
let at = address;
const layout = { controls: 9, numbers: 6, positions: 5, hand: 3, pull: 2, rows: 2, error: 1, solved: 1, contacts: 40 };
for (const [name, length] of Object.entries(layout)) {
  w[name] = new Float64Array(kernel.memory.buffer, at, length);
  at += 8 * length;
}

let scene, history, grip, running = !new URLSearchParams(location.search).has("paused"), micros = 0, taken = 0;

function begin() {
  w.controls[3] = 0;
  grip = null;
  history = [];
  micros = taken = 0;
  kernel.begin(address, scenes.indexOf(scene));
}

function choose(index) {
  scene = scenes[index];
  for (const [i, tab] of [...$("tabs").children].entries()) tab.ariaSelected = i === index;
  $("hint").textContent = scene.hint;
  $("sliders").replaceChildren(...scene.sliders.map(({ id, label, unit, value, ...range }, i) => {
    const row = document.createElement("label");
    row.innerHTML = `<span>${label}</span><output></output><input type="range" id="${id}">`;
    const [, output, input] = row.children;
    Object.assign(input, range).value = value;
    const read = () => {
      w.controls[i] = input.value;
      output.textContent = `${w.controls[i].toFixed(range.step < 0.1 ? 2 : 1)} ${unit}`;
    };
    read();
    input.oninput = () => { read(); draw(); };
    return row;
  }));
  begin();
  $("numbers").replaceChildren(...Object.entries(scene.numbers(w)).map(([id, [label]]) => {
    const row = document.createElement("tr");
    row.id = id;
    row.innerHTML = `<td>${label}</td><td></td><td></td>`;
    return row;
  }));
}

function advance(steps) {
  for (; steps > 0; steps -= CHUNK) {
    const count = Math.min(steps, CHUNK);
    const start = performance.now();
    kernel.step(address, count);
    micros += 1e3 * (performance.now() - start);
    taken += count;
    history.push(scene.strip.map(([key]) => w.contacts[5 * key + 4]));
    if (history.length > COLUMNS) history.shift();
  }
  if (taken > 1000) [micros, taken] = [micros / 2, taken / 2]; // the last seconds count
}

// A canvas as large as it is shown, in units of CSS pixels.
function paper(id) {
  const canvas = $(id);
  const [width, height, dots] = [canvas.clientWidth, canvas.clientHeight, devicePixelRatio || 1];
  const size = [Math.round(width * dots), Math.round(height * dots)];
  if (canvas.width !== size[0] || canvas.height !== size[1]) [canvas.width, canvas.height] = size;
  const ink = canvas.getContext("2d");
  ink.setTransform(dots, 0, 0, dots, 0, 0);
  ink.clearRect(0, 0, width, height);
  return { ink, width, height };
}

// From metres to pixels of the scene's canvas, and back.
function view() {
  const { clientWidth: width, clientHeight: height } = $("scene");
  const { x, y, wide, high, angle } = scene.camera(w);
  const scale = Math.min(width / wide, height / high);
  const [sine, cosine] = [Math.sin(angle), Math.cos(angle)];
  return {
    scale,
    pixels: ([a, b]) => [width / 2 + scale * (cosine * (a - x) - sine * b), height / 2 + scale * (y - sine * (a - x) - cosine * b)],
    metres([a, b]) {
      const [right, up] = [(a - width / 2) / scale, y - (b - height / 2) / scale];
      return [x + cosine * right + sine * up, cosine * up - sine * right];
    },
  };
}

// Draws in metres.
function pen() {
  const { ink } = paper("scene");
  const { scale, pixels } = view();
  const path = (points) => {
    ink.beginPath();
    for (const point of points) ink.lineTo(...point);
  };
  const fill = (colour) => {
    ink.fillStyle = colour;
    ink.fill();
  };
  const stroke = (points, colour, thick, dashes = []) => {
    path(points);
    Object.assign(ink, { strokeStyle: colour, lineWidth: thick, lineCap: dashes.length ? "butt" : "round", lineJoin: "round" });
    ink.setLineDash(dashes);
    ink.stroke();
  };
  const line = (points, ...style) => stroke(points.map(pixels), ...style);
  return {
    line,
    shape(points, colour, edge) {
      path(points.map(pixels));
      fill(colour);
      if (edge) line([...points, points[0]], edge, 1.5);
    },
    dot(point, radius, colour) {
      ink.beginPath();
      ink.arc(...pixels(point), radius, 0, 7);
      fill(colour);
    },
    // From its point on, or towards it; the label is at the far end.
    arrow([a, b], force, newton, colour, { dashes = [], label, towards = false }) {
      const size = Math.hypot(...force);
      const far = towards ? -newton : newton;
      const ends = [pixels([a, b]), pixels([a + far * force[0], b + far * force[1]])];
      const [from, to] = towards ? ends.reverse() : ends;
      const long = Math.hypot(to[0] - from[0], to[1] - from[1]);
      const [c, s] = [(to[0] - from[0]) / long, (to[1] - from[1]) / long];
      const head = Math.min(12, long / 2);
      stroke([from, [to[0] - 0.8 * head * c, to[1] - 0.8 * head * s]], colour, 3.5, dashes);
      ink.beginPath();
      for (const side of [0, 0.45, -0.45]) ink.lineTo(to[0] - head * (side && c - side * s), to[1] - head * (side && s + side * c));
      fill(colour);
      const [x, y] = towards ? [from[0] - 24 * c, from[1] - 13 * s] : [to[0] + 24 * c, to[1] + 13 * s];
      Object.assign(ink, { font: "600 13px system-ui, sans-serif", textAlign: "center", textBaseline: "middle", strokeStyle: "#fffc", lineWidth: 4 });
      ink.setLineDash([]);
      for (const way of ["strokeText", "fillText"]) ink[way](label ?? `${size.toFixed(0)} N`, x, y);
    },
  };
}

// Bars of modes over time: full and plain where a contact sticks, lower and hatched where it slips, a line where it is open.
function bars(id, labels, columns, most) {
  const { ink, width, height } = paper(id);
  const tile = document.createElement("canvas");
  tile.width = tile.height = 6;
  const hatch = Object.assign(tile.getContext("2d"), { fillStyle: "#f7c49c", strokeStyle: COLOURS[2], lineWidth: 2.4 });
  hatch.fillRect(0, 0, 6, 6);
  for (const shift of [-6, 0, 6]) hatch.stroke(new Path2D(`M${shift} 6 l6 -6`));
  const fills = [COLOURS[0], COLOURS[1], ink.createPattern(tile, "repeat")];
  const [left, row] = [112, height / labels.length];
  const column = (width - left) / most;
  Object.assign(ink, { font: "12px system-ui, sans-serif", textBaseline: "middle" });
  labels.forEach((label, k) => {
    ink.fillStyle = "#5c6470";
    ink.fillText(label, 0, row * (k + 0.5));
    const bottom = row * (k + 1) - 2;
    for (let i = 0, end; i < columns.length; i = end) {
      for (end = i + 1; end < columns.length && columns[end][k] === columns[i][k]; end++);
      const mode = columns[i][k];
      if (mode === undefined) continue;
      const tall = [1, row - 4, 0.6 * (row - 4)][mode];
      ink.fillStyle = fills[mode];
      ink.fillRect(left + column * (most - columns.length + i), bottom - tall, column * (end - i), tall);
    }
  });
}

function draw() {
  const p = pen();
  scene.draw(p, w);
  const body = scene.body(w);
  const modes = [];
  for (let key = 0; key < 8; key++) {
    const [x, y, fx, fy, mode] = w.contacts.subarray(5 * key);
    modes.push(mode);
    if (!mode || Math.hypot(fx, fy) < 0.05) continue;
    const [nx, ny] = scene.normal(w, key);
    const tall = (scene.towards ? -1.1 : 1.1) * scene.newton * (fx * nx + fy * ny);
    const wide = tall * w.hand[1];
    const edge = (side) => [x + tall * nx - side * wide * ny, y + tall * ny + side * wide * nx];
    p.shape([[x, y], edge(1), edge(-1)], COLOURS[mode] + "28");
    p.arrow([x, y], [fx, fy], scene.newton, COLOURS[mode], { dashes: mode === 2 ? [7, 4] : [], towards: scene.towards });
  }
  if (grip) {
    const [c, s] = [Math.cos(body.angle), Math.sin(body.angle)];
    const [a, b] = w.controls.subarray(4);
    p.line([[body.x + c * a - s * b, body.y + s * a + c * b], [...w.controls.subarray(6, 8)]], "#2a9d5c", 2.5, [3, 4]);
  }
  bars("strip", scene.strip.map(([, label]) => label), history, COLUMNS);
  const numbers = scene.numbers(w);
  for (const [id, [, computed, paper, unit]] of Object.entries(numbers)) {
    const show = (x) => (x === null ? "" : Number.isFinite(x) ? `${x.toFixed(2).replace(/^-(0\.00)$/, "$1")} ${unit}` : "–");
    const [, first, second] = $(id).children;
    [first.textContent, second.textContent] = [show(computed), show(paper)];
  }
  const shown = [2, 1].filter((mode) => scene.strip.some(([key]) => modes[key] === mode)).map((mode) => MODES[mode]).join(", ");
  $("message").textContent = w.solved[0] ? shown || MODES[0] : "unsolved: begin again";
  $("time").textContent = taken ? (micros / taken).toFixed(1) : "–";
  $("error").textContent = w.error[0].toExponential(0);
  return { modes, positions: [...w.positions], numbers, solved: w.solved[0] === 1, error: w.error[0] };
}

function trot() {
  const replay = () => { for (let i = 0; i < 25; i++) kernel.trot(address, false); };
  replay(); // until the browser has compiled it well
  const start = performance.now();
  replay();
  $("trot_time").textContent = ((1e3 * (performance.now() - start)) / 25 / 40).toFixed(0);
  kernel.trot(address, true);
  const text = new TextDecoder().decode(new Uint8Array(kernel.memory.buffer, kernel.text(address), kernel.text_length(address)));
  return text.trimEnd().split("\n").map((line) => /^ *\d+ (\S+) \S+ \S+(.*)$/.exec(line).slice(1));
}

// FNV-1a, 64 bits, over the words of a text.
function fingerprint(text) {
  let hash = 0xcbf29ce484222325n;
  for (const digits of text.match(/\b[0-9a-f]{8}\b/g).join("")) hash = BigInt.asUintN(64, (hash ^ BigInt(digits.charCodeAt(0))) * 0x100000001b3n);
  return hash.toString(16).padStart(16, "0");
}

function drag(event) {
  const corner = $("scene").getBoundingClientRect();
  grip = [event.clientX - corner.left, event.clientY - corner.top];
}
$("scene").onpointerdown = (event) => {
  drag(event);
  const { x, y, angle, half } = scene.body(w);
  const [a, b] = view().metres(grip);
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  const inside = [c * (a - x) + s * (b - y), c * (b - y) - s * (a - x)];
  if (inside.some((d, i) => Math.abs(d) > 1.3 * half[i])) return (grip = null);
  event.target.setPointerCapture(event.pointerId);
  w.controls.set([1, ...inside.map((d, i) => Math.max(-half[i], Math.min(half[i], d)))], 3);
};
$("scene").onpointermove = (event) => grip && drag(event);
$("scene").onpointerup = $("scene").onpointercancel = () => {
  grip = null;
  w.controls[3] = 0;
};
$("reset").onclick = () => { begin(); draw(); };
$("single").onchange = (event) => (w.controls[8] = event.target.checked ? 1 : 0);
const name_pause = () => ($("pause").textContent = running ? "Pause" : "Go on");
$("pause").onclick = () => { running = !running; name_pause(); };
name_pause();

$("tabs").append(...scenes.map(({ title }, index) => {
  const tab = Object.assign(document.createElement("button"), { role: "tab", textContent: title });
  tab.onclick = () => { choose(index); draw(); };
  return tab;
}));
choose(0);

const recorded = (await (await fetch("trot.txt")).text()).trimEnd().split("\n");
const steps = trot();
const impulses = recorded.map((line) => line.replace(/^ *\d+/, ""));
$("same").textContent = `${steps.filter(([, mine], i) => mine === impulses[i]).length} of ${impulses.length}`;
$("here").textContent = fingerprint(steps.map(([, mine]) => mine).join());
$("chip").textContent = fingerprint(impulses.join());
const keys_of = (text) => [...text.matchAll(/(\d+):/g)].map(([, key]) => +key);
const feet = [...new Set(steps.flatMap(([, mine]) => keys_of(mine)))].sort();
const columns = steps.map(([modes, mine]) => {
  const keys = keys_of(mine);
  return feet.map((key) => (keys.includes(key) ? "o=~".indexOf(modes[keys.indexOf(key)]) : undefined));
});
const trot_strip = () => bars("trot", feet.map((key) => `contact ${key}`), columns, columns.length);

let last = performance.now(), owed = 0;
function frame(now) {
  if (running) {
    if (grip) w.controls.set(view().metres(grip), 6);
    owed = Math.min(owed + (now - last) / 1e3, 0.1);
    const count = Math.floor(owed / STEP / CHUNK) * CHUNK;
    owed -= count * STEP;
    advance(count);
    draw();
  }
  last = now;
  requestAnimationFrame(frame);
}
window.stiction = {
  /** Takes steps of 2 ms and returns what the page shows then. */
  step(count) {
    if (grip) w.controls.set(view().metres(grip), 6);
    advance(count);
    return draw();
  },
};
window.onresize = () => { draw(); trot_strip(); };
window.onresize();
requestAnimationFrame(frame);
