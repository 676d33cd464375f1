// Where the arm stands and how its modes move it, from the chain in the page's data.

const cross = (a, b) => [
  a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0],
];
const add = (a, b, k = 1) => [a[0] + k * b[0], a[1] + k * b[1], a[2] + k * b[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const norm = (a) => Math.hypot(...a);

// Rotation matrices row by row.
const turned = (r, v) => [dot(r.slice(0, 3), v), dot(r.slice(3, 6), v), dot(r.slice(6, 9), v)];
const times = (a, b) => {
  const out = [];
  for (let i = 0; i < 9; i += 3) {
    for (let j = 0; j < 3; j++) out.push(a[i] * b[j] + a[i + 1] * b[j + 3] + a[i + 2] * b[j + 6]);
  }
  return out;
};
const turn = ([x, y, z], angle) => {
  const c = Math.cos(angle), s = Math.sin(angle), v = 1 - c;
  return [
    c + x * x * v, x * y * v - z * s, x * z * v + y * s,
    y * x * v + z * s, c + y * y * v, y * z * v - x * s,
    z * x * v - y * s, z * y * v + x * s, c + z * z * v,
  ];
};

// Frames of all parts and the elastic axes in the base frame, at a pose and, where alpha is given,
// with the elastic coordinates there.
function placed(arm, q, alpha) {
  const frames = [], axes = [];
  for (const part of arm.parts) {
    let { rotation: r, xyz_m: o } = part.frame;
    if (part.parent !== null) {
      const parent = frames[part.parent];
      o = add(parent.o, turned(parent.r, o));
      r = times(parent.r, r);
    }
    if (part.joint) {
      const { index, slides, axis } = part.joint;
      if (slides) o = add(o, turned(r, axis), q[index]);
      else r = times(r, turn(axis, q[index]));
    }
    for (let i = part.axes[0]; i < part.axes[1]; i++) {
      const own = arm.axes[i];
      const direction = turned(r, own.axis), point = add(o, turned(r, own.origin_m));
      axes[i] = { direction, point };
      if (!alpha) continue;
      if (own.slides) o = add(o, direction, alpha[i]);
      else {
        r = times(r, turn(own.axis, alpha[i]));
        o = add(point, turned(r, own.origin_m), -1);
      }
    }
    frames.push({ r, o });
  }
  return { frames, axes };
}

// A point of the tip frame in the base frame.
function ofTip(arm, { frames }, point) {
  const { r, o } = frames[arm.tip_part];
  return add(o, turned(r, add(arm.tip.xyz_m, turned(arm.tip.rotation, point))));
}

// How a shape moves a point that a part carries, to first order.
function motion(arm, { axes }, part, point, shape) {
  let moved = [0, 0, 0];
  for (let at = part; at !== null; at = arm.parts[at].parent) {
    for (let i = arm.parts[at].axes[0]; i < arm.parts[at].axes[1]; i++) {
      const { direction, point: on } = axes[i];
      const along = arm.axes[i].slides ? direction : cross(direction, add(point, on, -1));
      moved = add(moved, along, shape[i]);
    }
  }
  return moved;
}

// J phi of every mode at the tool centre point of a place, m/(sqrt(kg) m).
function tipMotions(arm, place) {
  const at = placed(arm, place.joints_rad);
  const tcp = ofTip(arm, at, place.tool_m);
  return place.shapes.map((shape) => motion(arm, at, arm.tip_part, tcp, shape));
}

// What each mode alone moves the tool tip at resonance, um/N.
function tipResponses(arm, place) {
  return tipMotions(arm, place).map((moved, r) => {
    const omega = 2 * Math.PI * place.natural_frequencies_hz[r];
    return 1e6 * dot(moved, moved) / (2 * place.damping_ratios[r] * omega * omega);
  });
}

// |G| at the tool tip along a direction of the base frame, um/N.
function receptance(place, motions, direction, hz) {
  const omega = 2 * Math.PI * hz;
  let re = 0, im = 0;
  motions.forEach((moved, r) => {
    const own = 2 * Math.PI * place.natural_frequencies_hz[r];
    const a = own * own - omega * omega, b = 2 * place.damping_ratios[r] * own * omega;
    const share = dot(direction, moved) ** 2 / (a * a + b * b);
    re += share * a;
    im -= share * b;
  });
  return 1e6 * Math.hypot(re, im);
}

// A shape at a size that can be seen: its largest motion is this share of the arm's size.
function visible(arm, place, mode, size, share) {
  const at = placed(arm, place.joints_rad), shape = place.shapes[mode];
  const tcp = ofTip(arm, at, place.tool_m);
  const moved = at.frames.map(({ o }, part) => norm(motion(arm, at, part, o, shape)));
  moved.push(norm(motion(arm, at, arm.tip_part, tcp, shape)));
  const turns = shape.map((value, i) => (arm.axes[i].slides ? 0 : Math.abs(value)));
  const scale = Math.min(share * size / Math.max(...moved), 2.5 * share / Math.max(...turns, 1e-300));
  return shape.map((value) => value * (Number.isFinite(scale) ? scale : 0));
}
