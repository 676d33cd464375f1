// The arm in three dimensions: a small layer over WebGL.

const VERTEX = `
attribute vec3 position, normal, colour;
uniform mat4 view; uniform mat3 rotation; uniform vec3 origin;
varying vec3 shade;
void main() {
  gl_Position = view * vec4(rotation * position + origin, 1.0);
  vec3 n = rotation * normal;
  float light = dot(normal, normal) < 0.5
    ? 1.0 : 0.45 + 0.4 * abs(dot(n, vec3(0.36, -0.48, 0.8))) + 0.15 * n.z;
  shade = colour * light;
}`;
const FRAGMENT = `
precision mediump float;
varying vec3 shade; uniform float opacity;
void main() { gl_FragColor = vec4(shade * opacity, opacity); }`;

const rgb = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255);
const COLOURS = {
  link: rgb('#8fa3b8'), rest: rgb('#9aa0a6'), body: rgb('#e69f00'), tool: rgb('#5b6470'),
  floor: rgb('#9aa0a6'), resonance: rgb('#d62839'), uncertain: rgb('#e08e00'),
  clear: rgb('#009e73'), unknown: rgb('#888888'), here: rgb('#0072b2'),
};

// A surface around a line from a to b; a sphere with other radii along its axes where a equals b.
function surface(a, b, radii, frame, colour) {
  const along = add(b, a, -1), length = norm(along);
  const z = length > 0 ? along.map((v) => v / length) : [0, 0, 1];
  const x0 = cross(Math.abs(z[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0], z);
  const x = x0.map((v) => v / norm(x0)), y = cross(z, x);
  const rings = 16, sides = 20, grid = [];
  for (let i = 0; i <= rings; i++) {
    const polar = Math.PI * i / rings;
    for (let j = 0; j <= sides; j++) {
      const turn = 2 * Math.PI * j / sides;
      const u = [Math.sin(polar) * Math.cos(turn), Math.sin(polar) * Math.sin(turn), -Math.cos(polar)];
      let p = u.map((v, k) => v * radii[k]), n = u.map((v, k) => v / radii[k]);
      if (length > 0) {
        const middle = i > rings / 2 ? b : a;
        p = add(add(add(middle, x, p[0]), y, p[1]), z, p[2]);
        n = add(add(add([0, 0, 0], x, n[0]), y, n[1]), z, n[2]);
      } else if (frame) {
        p = add(frame.xyz_m, turned(frame.rotation, p));
        n = turned(frame.rotation, n);
      } else p = add(a, p);
      const size = norm(n);
      grid.push([...p, ...n.map((v) => v / size), ...colour]);
    }
  }
  const out = [];
  for (let i = 0; i < rings; i++) {
    for (let j = 0; j < sides; j++) {
      const k = i * (sides + 1) + j;
      for (const at of [k, k + 1, k + sides + 1, k + 1, k + sides + 2, k + sides + 1]) out.push(...grid[at]);
    }
  }
  return out;
}

// Points and triangles of a surface, unpacked once.
const unpacked = new Map();
function unpack(surface) {
  if (unpacked.has(surface)) return unpacked.get(surface);
  const triples = (text) => {
    const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0)), view = new DataView(bytes.buffer);
    const number = (i) => view.getUint16(2 * i, true);
    const triple = (_, i) => [0, 1, 2].map((k) => number(3 * i + k));
    return Array.from({ length: bytes.length / 6 }, triple);
  };
  const { low, size } = surface;
  const points = triples(surface.points).map((p) => p.map((v, k) => low[k] + size[k] * v / 65535));
  const found = { points, triangles: triples(surface.triangles) };
  unpacked.set(surface, found);
  return found;
}

// A mesh in its part: faces that meet at less than some 40 degrees share their normals.
function meshOf({ surface, frame, scale }, surfaces, colour) {
  const { points, triangles } = unpack(surfaces[surface]);
  const at = points.map((p) => add(frame.xyz_m, turned(frame.rotation, p.map((v, k) => v * scale[k]))));
  const faces = triangles.map(([a, b, c]) => {
    const n = cross(add(at[b], at[a], -1), add(at[c], at[a], -1)), size = norm(n);
    return size > 0 ? n.map((v) => v / size) : [0, 0, 1];
  });
  const around = points.map(() => []);
  triangles.forEach((triangle, i) => triangle.forEach((k) => around[k].push(i)));
  return triangles.flatMap((triangle, i) => triangle.flatMap((k) => {
    let n = [0, 0, 0];
    for (const other of around[k]) if (dot(faces[other], faces[i]) > 0.77) n = add(n, faces[other]);
    const size = norm(n) || 1;
    return [...at[k], ...n.map((v) => v / size), ...colour];
  }));
}

// What each part looks like: its meshes, else capsules to the parts that it carries; ellipsoids of
// its bodies.
function shapesOf(arm, size, surfaces) {
  const thick = (part) => {
    let depth = 0;
    for (let at = part; at !== null; at = arm.parts[at].parent) depth++;
    return size * 0.045 * Math.pow(0.84, Math.max(0, depth - 2));
  };
  return arm.parts.map((part, index) => {
    const links = [], r = thick(index), ball = [r, r, r];
    const ends = arm.parts.filter((other) => other.parent === index).map((other) => other.frame.xyz_m);
    if (index === arm.tip_part) ends.push(arm.tip.xyz_m);
    for (const end of ends) {
      links.push(...surface([0, 0, 0], norm(end) > 1e-9 ? end : [0, 0, 0], ball, null, COLOURS.link));
    }
    if (part.meshes.length > 0) {
      const meshes = part.meshes.map((mesh) => meshOf(mesh, surfaces, COLOURS.link));
      return { links: meshes.flat(), bodies: bodiesOf(part, size) };
    }
    if (ends.length === 0) links.push(...surface([0, 0, 0], [0, 0, 0], ball, null, COLOURS.link));
    return { links, bodies: bodiesOf(part, size) };
  });
}

function bodiesOf(part, size) {
  return part.bodies.flatMap(({ frame, semi_axes_m }) => {
    const radii = semi_axes_m.map((v) => Math.max(v, 0.004 * size));
    return surface([0, 0, 0], [0, 0, 0], radii, frame, COLOURS.body);
  });
}

const IDENTITY = [1, 0, 0, 0, 1, 0, 0, 0, 1];
const columns = (r) => [r[0], r[3], r[6], r[1], r[4], r[7], r[2], r[5], r[8]];

class ArmView {
  constructor(canvas, arm, size, target, surfaces) {
    this.canvas = canvas;
    this.arm = arm;
    this.target = target;
    this.distance = 1.75 * size;
    this.azimuth = -0.9;
    this.height = 0.42;
    const gl = canvas.getContext('webgl', { antialias: true, alpha: true, preserveDrawingBuffer: true });
    if (!gl) throw new Error('no WebGL');
    this.gl = gl;
    const program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    ['position', 'normal', 'colour'].forEach((name, i) => gl.bindAttribLocation(program, i, name));
    gl.linkProgram(program);
    gl.useProgram(program);
    this.uniform = {};
    for (const name of ['view', 'rotation', 'origin', 'opacity']) {
      this.uniform[name] = gl.getUniformLocation(program, name);
    }
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    this.parts = shapesOf(arm, size, surfaces).map((part) => ({
      links: this.buffer(part.links), bodies: this.buffer(part.bodies),
    }));
    this.floor = this.buffer(this.grid(size));
    const ball = Array(3).fill(0.014 * size), origin = [0, 0, 0];
    this.ball = this.buffer(surface(origin, origin, ball, null, COLOURS.here));
    this.dynamic = gl.createBuffer();
    this.listen();
  }

  buffer(values) {
    const { gl } = this, buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(values), gl.STATIC_DRAW);
    return { buffer, count: values.length / 9 };
  }

  grid(size) {
    const out = [], step = 0.25 * Math.pow(2, Math.round(Math.log2(size))), reach = 4 * step;
    const end = (x, y) => out.push(x, y, 0, 0, 0, 0, ...COLOURS.floor);
    for (let k = -4; k <= 4; k++) {
      end(k * step, -reach); end(k * step, reach);
      end(-reach, k * step); end(reach, k * step);
    }
    return out;
  }

  lines(points) {
    const values = points.flatMap(([p, colour]) => [...p, 0, 0, 0, ...colour]);
    const { gl } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.dynamic);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(values), gl.DYNAMIC_DRAW);
    return { buffer: this.dynamic, count: points.length };
  }

  put({ buffer, count }, kind, { r, o } = { r: IDENTITY, o: [0, 0, 0] }, opacity = 1) {
    const { gl, uniform } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    for (let i = 0; i < 3; i++) {
      gl.enableVertexAttribArray(i);
      gl.vertexAttribPointer(i, 3, gl.FLOAT, false, 36, 12 * i);
    }
    gl.uniformMatrix3fv(uniform.rotation, false, columns(r));
    gl.uniform3fv(uniform.origin, o);
    gl.uniform1f(uniform.opacity, opacity);
    gl.drawArrays(kind, 0, count);
  }

  camera() {
    const { canvas, target, distance, azimuth, height } = this;
    const level = Math.cos(height);
    const ahead = [Math.cos(azimuth) * level, Math.sin(azimuth) * level, Math.sin(height)];
    const right = [-Math.sin(azimuth), Math.cos(azimuth), 0], up = cross(ahead, right);
    const eye = add(target, ahead, distance);
    const f = 2.2, aspect = canvas.width / canvas.height, near = 0.02 * distance, far = 8 * distance;
    const a = (far + near) / (near - far), b = 2 * far * near / (near - far);
    const fit = Math.min(1, aspect);
    const rows = [
      [...right.map((v) => v * f * fit / aspect), -dot(right, eye) * f * fit / aspect],
      [...up.map((v) => v * f * fit), -dot(up, eye) * f * fit],
      [...ahead.map((v) => v * a), -dot(ahead, eye) * a + b],
      [...ahead.map((v) => -v), dot(ahead, eye)],
    ];
    return [0, 1, 2, 3].flatMap((j) => rows.map((row) => row[j]));
  }

  // The arm at a pose and displaced by alpha, the path with its colours, the place on it.
  draw({ place, alpha, path, bodies }) {
    const { gl, canvas, arm } = this;
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((v) => Math.round(v * ratio));
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.uniformMatrix4fv(this.uniform.view, false, this.camera());
    this.put(this.floor, gl.LINES, undefined, 0.35);
    this.put(this.lines(path), gl.LINES);
    const rest = placed(arm, place.joints_rad), moved = placed(arm, place.joints_rad, alpha);
    const skeleton = [];
    arm.parts.forEach((part, i) => {
      if (part.parent === null) return;
      skeleton.push([rest.frames[part.parent].o, COLOURS.rest], [rest.frames[i].o, COLOURS.rest]);
    });
    const tool = (at, colour) => [
      [ofTip(arm, at, [0, 0, 0]), colour], [ofTip(arm, at, place.tool_m), colour],
    ];
    skeleton.push(...tool(rest, COLOURS.rest), ...tool(moved, COLOURS.here));
    this.put(this.lines(skeleton), gl.LINES);
    this.put(this.ball, gl.TRIANGLES, { r: IDENTITY, o: ofTip(arm, moved, place.tool_m) });
    moved.frames.forEach((frame, i) => {
      if (bodies) this.put(this.parts[i].bodies, gl.TRIANGLES, frame);
    });
    gl.depthMask(!bodies);
    moved.frames.forEach((frame, i) => {
      this.put(this.parts[i].links, gl.TRIANGLES, frame, bodies ? 0.25 : 1);
    });
    gl.depthMask(true);
  }

  listen() {
    const { canvas } = this;
    const changed = () => canvas.dispatchEvent(new Event('view'));
    const orbit = (dx, dy) => {
      this.azimuth -= 0.008 * dx;
      this.height = Math.max(-0.3, Math.min(1.5, this.height + 0.008 * dy));
      changed();
    };
    const zoom = (by) => { this.distance *= by; changed(); };
    let last = null;
    canvas.addEventListener('pointerdown', (event) => {
      last = [event.clientX, event.clientY];
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener('pointermove', (event) => {
      if (!last) return;
      orbit(event.clientX - last[0], event.clientY - last[1]);
      last = [event.clientX, event.clientY];
    });
    for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, () => { last = null; });
    canvas.addEventListener('wheel', (event) => {
      if (!event.ctrlKey && document.activeElement !== canvas) return;
      event.preventDefault();
      zoom(Math.exp(0.001 * event.deltaY));
    }, { passive: false });
    canvas.addEventListener('keydown', (event) => {
      const keys = {
        ArrowLeft: () => orbit(-12, 0), ArrowRight: () => orbit(12, 0), ArrowUp: () => orbit(0, 12),
        ArrowDown: () => orbit(0, -12), '+': () => zoom(0.9), '-': () => zoom(1.1),
      };
      if (keys[event.key]) { keys[event.key](); event.preventDefault(); }
    });
  }
}
