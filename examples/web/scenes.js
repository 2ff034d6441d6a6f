// The three scenes: their sliders, what is drawn, and what stands on paper for a body at rest or sliding steadily. `w` is the world of the
// kernel (page.js).
const g = 9.81;
const degrees = 180 / Math.PI;
const slider = (id, label, unit, min, max, step, value) => ({ id, label, unit, min, max, step, value });
const friction = (value) => slider("mu", "friction mu", "", 0.05, 1.2, 0.01, value);
const sum = (w, keys, entry) => keys.reduce((total, key) => total + w.contacts[5 * key + entry], 0);
const turn = (angle, x, y) => [Math.cos(angle) * x - Math.sin(angle) * y, Math.sin(angle) * x + Math.cos(angle) * y];
const corners = (x, y, angle, a, b) =>
  [[-a, -b], [a, -b], [a, b], [-a, b]].map((p) => turn(angle, ...p)).map((p) => [x + p[0], y + p[1]]);
const ground = (pen, x, y) => {
  pen.shape([[x - 9, y], [x + 9, y], [x + 9, y - 9], [x - 9, y - 9]], "#dcd6ca");
  for (let k = Math.ceil((x - 4) / 0.2); k * 0.2 < x + 4; k++) pen.line([[k * 0.2, y], [k * 0.2 - 0.05, y - 0.07]], "#a59b88", 1.5);
  pen.line([[x - 9, y], [x + 9, y]], "#7d7464", 2);
};

export const scenes = [
  {
    title: "Box on a slope",
    hint: "Tilt the slope until the box lets go. Push it, or pull it by a corner.",
    sliders: [slider("slope", "slope", "°", 0, 45, 0.05, 20), friction(0.5), slider("push", "push up the slope", "N", -60, 60, 0.5, 0)],
    strip: [[0, "lower corner"], [1, "upper corner"]],
    newton: 0.012, // m of an arrow for each N
    camera: (w) => ({ x: w.positions[0], y: 0.33, wide: 2.6, high: 1.9, angle: w.hand[0] / degrees }),
    body: (w) => ({ x: w.positions[0], y: w.positions[1], angle: w.positions[2], half: w.numbers.slice(1, 3) }),
    normal: () => [0, 1],
    draw(pen, w) {
      ground(pen, w.positions[0], 0);
      const { x, y, angle, half } = this.body(w);
      pen.shape(corners(x, y, angle, ...half), "#c3cad8", "#8790a3");
      if (w.hand[2]) pen.arrow([x, y], [w.hand[2], 0], this.newton, "#444", { label: "push" });
    },
    numbers(w) {
      const [slope, mu, push] = [w.hand[0] / degrees, w.hand[1], w.hand[2]];
      const weight = w.numbers[0] * g;
      const normal = Math.max(0, weight * Math.cos(slope) - w.pull[1]);
      const [needs, has] = [weight * Math.sin(slope) - push - w.pull[0], mu * normal];
      const angle = Math.atan(mu);
      const lets_go = angle + Math.asin((push * Math.cos(angle)) / weight);
      return {
        normal: ["normal force", sum(w, [0, 1, 2, 3], 3), normal, "N"],
        friction: ["friction, up the slope", sum(w, [0, 1, 2, 3], 2), Math.sign(needs) * Math.min(Math.abs(needs), has), "N"],
        most: ["most friction, mu N", null, has, "N"],
        angle: ["angle of friction atan(mu)", null, angle * degrees, "°"],
        lets_go: ["lets go downhill at", null, lets_go > 0 ? lets_go * degrees : NaN, "°"],
      };
    },
  },
  {
    title: "Leg that is pulled",
    hint: "Motors hold hip and knee, a guide keeps the body upright. Pull until the foot slips, or crouch and see the knee work.",
    sliders: [slider("pull", "pull", "N", 0, 100, 0.25, 0), friction(0.5), slider("height", "height of the hip", "m", 0.3, 0.66, 0.01, 0.5)],
    strip: [[2, "foot"], [1, "knee"], [0, "body"]],
    newton: 0.0035,
    camera: (w) => ({ x: w.positions[0] + 0.08, y: 0.34, wide: 1.4, high: 0.98, angle: 0 }),
    body: (w) => ({ x: w.positions[0], y: w.positions[1], angle: 0, half: [0.2, 0.08] }),
    normal: () => [0, 1],
    draw(pen, w) {
      const [x, y, hip, knee] = w.positions;
      const link = w.numbers[3];
      ground(pen, x, 0);
      pen.line([[x - 9, y + 0.05], [x + 9, y + 0.05]], "#c9ced8", 5);
      const at_knee = [x + link * Math.sin(hip), y - link * Math.cos(hip)];
      const foot = [at_knee[0] + link * Math.sin(hip + knee), at_knee[1] - link * Math.cos(hip + knee)];
      pen.shape(corners(x, y, 0, 0.2, w.numbers[4]), "#c3cad8", "#8790a3");
      pen.line([[x, y], at_knee, foot], "#6d7890", 13);
      for (const joint of [[x, y], at_knee]) pen.dot(joint, 8, "#3f475a");
      pen.dot(foot, 6, "#3f475a");
      if (w.hand[0]) pen.arrow([x + 0.2, y], [w.hand[0], 0], this.newton, "#444", { label: "pull" });
    },
    // Torques that hold the leg still: its weights, less the force of the floor at the foot.
    numbers(w) {
      const [, , hip, knee] = w.positions;
      const [body, knee_mass, foot_mass, link] = w.numbers;
      const weight = (body + knee_mass + foot_mass) * g;
      const [fx, fy] = [-w.hand[0] - w.pull[0], weight - w.pull[1]];
      const [tx, ty] = [link * Math.sin(hip), -link * Math.cos(hip)];
      const [sx, sy] = [link * Math.sin(hip + knee), -link * Math.cos(hip + knee)];
      const most = w.hand[1] * fy;
      const still = Math.abs(fx) <= most ? 1 : NaN;
      return {
        normal: ["force of the floor", sum(w, [0, 1, 2], 3), fy, "N"],
        friction: ["friction", sum(w, [0, 1, 2], 2), Math.sign(fx) * Math.min(Math.abs(fx), most), "N"],
        hip: ["torque of the hip", w.rows[0], still * (g * (knee_mass * tx + foot_mass * (tx + sx)) + fx * (ty + sy) - fy * (tx + sx)), "N·m"],
        knee: ["torque of the knee", w.rows[1], still * (g * foot_mass * sx + fx * sy - fy * sx), "N·m"],
        slips: ["slips at mu N", null, most, "N"],
      };
    },
  },
  {
    title: "Gripper",
    hint: "Lower the squeeze until the block slips out of the fingers, or pull it out.",
    sliders: [
      slider("squeeze", "squeeze of a finger", "N", 0, 30, 0.05, 12), friction(0.6), slider("mass", "mass of the block", "kg", 0.1, 2, 0.05, 1),
    ],
    strip: [[2, "left pad, top"], [0, "left, bottom"], [3, "right pad, top"], [1, "right, bottom"]],
    newton: 0.008,
    towards: true, // arrows end at the contact
    camera: () => ({ x: 0, y: -0.055, wide: 0.52, high: 0.44, angle: 0 }),
    body: (w) => ({ x: w.positions[0], y: w.positions[1], angle: w.positions[2], half: w.numbers.slice(0, 2) }),
    normal: (w, key) => (key < 4 ? turn(w.positions[2], key % 2 ? -1 : 1, 0) : [0, 1]),
    draw(pen, w) {
      const [, , pad, table] = w.numbers;
      const { x, y, angle, half } = this.body(w);
      pen.shape([[-1, -table], [1, -table], [1, -1], [-1, -1]], "#dcd6ca");
      pen.line([[-1, -table], [1, -table]], "#7d7464", 2);
      pen.shape(corners(x, y, angle, ...half), "#c3cad8", "#8790a3");
      pen.line([[-0.2, 0.13], [0.2, 0.13]], "#aab2c3", 12);
      for (const [side, q] of [[-1, w.positions[3]], [1, w.positions[4]]]) {
        const face = side * (half[0] - q);
        pen.line([[face + side * 0.009, 0.13], [face + side * 0.009, 0]], "#aab2c3", 12);
        pen.shape(corners(face + side * 0.009, 0, 0, 0.009, pad), "#6d7890");
      }
    },
    numbers(w) {
      const [squeeze, mu, mass] = w.hand;
      const load = Math.abs(mass * g - w.pull[1]);
      return {
        load: ["load of the pads", null, load, "N"],
        normal: ["force of the left pad", sum(w, [0, 2], 2), squeeze, "N"],
        friction: ["friction of both pads", sum(w, [0, 1, 2, 3], 3), Math.min(load, 2 * mu * squeeze), "N"],
        motor: ["motor of both fingers", w.rows[0], 2 * squeeze, "N"],
        needs: ["needs, load / (2 mu)", null, load / (2 * mu), "N"],
      };
    },
  },
];
