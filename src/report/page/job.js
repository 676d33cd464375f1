// One job: the slider along the path, and all that follows it.

const shown = (value, digits = 4) => {
  if (value === null || value === undefined) return '–';
  const text = Math.abs(value) >= 1e4 ? value.toFixed(0) : value.toPrecision(digits);
  return text.includes('.') && !text.includes('e') ? text.replace(/\.?0+$/, '') : text;
};

class JobView {
  constructor(section, job, surfaces) {
    this.job = job;
    this.arm = job.arm;
    const find = (name) => section.querySelector(`[data-is="${name}"]`);
    this.parts = Object.fromEntries(
      ['operation', 'place', 'here', 'view', 'modes', 'mode', 'animate', 'bodies', 'size', 'tip', 'shape']
        .map((name) => [name, find(name)]));
    this.figures = [...section.querySelectorAll('[data-operation]')];
    this.operation = 0;
    // The chosen place of each operation: where its margin is smallest.
    this.chosen = job.operations.map(({ places }) => {
      const at = (p) => p.margin_percent ?? Infinity;
      return places.reduce((worst, place, i) => (at(place) < at(places[worst]) ? i : worst), 0);
    });
    this.mode = 0;
    this.phase = 1;
    this.reach();
    this.controls();
    this.plots = this.figures.map((figure) => [...figure.querySelectorAll('.sense')].map((area) => {
      const plot = new Plot(area);
      this.listen(plot, Number(figure.dataset.operation));
      return plot;
    }));
    try {
      this.view = new ArmView(this.parts.view, this.arm, this.size, this.target, surfaces);
      this.parts.view.addEventListener('view', () => this.draw());
      new ResizeObserver(() => this.draw()).observe(this.parts.view);
    } catch {
      this.parts.view.replaceWith('This browser shows no WebGL, so the arm is not drawn.');
    }
    // Those that are not shown are printed.
    job.operations.forEach((_, operation) => this.mark(operation));
    this.choose(job.start);
  }

  get places() { return this.job.operations[this.operation].places; }
  get here() { return this.places[this.chosen[this.operation]]; }

  // A map has poses in place of a path.
  get isMap() { return this.job.poses !== undefined; }

  // Where a place stands in the plots along the path.
  abscissa(at) { return this.isMap ? at.abscissa : at.s; }

  // Size and middle of all that is shown.
  reach() {
    let low = [Infinity, Infinity, Infinity], high = low.map((v) => -v);
    const hold = (p) => {
      low = low.map((v, i) => Math.min(v, p[i]));
      high = high.map((v, i) => Math.max(v, p[i]));
    };
    for (const { places } of this.job.operations) {
      places.forEach((place, i) => {
        hold(place.tcp_m);
        if (i % 16 === 0) placed(this.arm, place.joints_rad).frames.forEach(({ o }) => hold(o));
      });
    }
    this.size = Math.max(norm(add(high, low, -1)), 1e-3);
    this.target = add(low, high).map((v) => 0.5 * v);
  }

  controls() {
    const { operation, place, animate, size, bodies } = this.parts;
    operation?.addEventListener('change', () => this.choose(Number(operation.value)));
    place.addEventListener('input', () => this.go(Number(place.value)));
    for (const input of [size, bodies]) input.addEventListener('input', () => this.shape());
    if (matchMedia('(prefers-reduced-motion: reduce)').matches) animate.checked = false;
    animate.addEventListener('change', () => this.run());
    document.addEventListener('visibilitychange', () => this.run());
  }

  choose(operation) {
    this.operation = operation;
    if (this.parts.operation) this.parts.operation.value = operation;
    this.parts.place.max = this.places.length - 1;
    this.figures.forEach((figure) => { figure.hidden = Number(figure.dataset.operation) !== operation; });
    const { margin } = this;
    this.path = this.isMap ? [] : this.places.slice(1).flatMap((place, i) => [
      [this.places[i].tcp_m, margin(this.places[i])], [place.tcp_m, margin(place)],
    ]);
    this.mode = this.job.operations[operation].mode - 1;
    this.go(this.chosen[operation]);
    this.run();
  }

  // The colour of a place: inside a band, inside one widened by the doubt, or clear.
  margin = ({ margin_percent: margin }) => {
    const { separation_percent: band, uncertainty_percent: doubt } = this.job.operations[this.operation];
    if (margin === null) return COLOURS.unknown;
    if (margin < band) return COLOURS.resonance;
    return margin < band + doubt ? COLOURS.uncertain : COLOURS.clear;
  };

  go(index) {
    this.chosen[this.operation] = index;
    const { place, here } = this.parts, at = this.here;
    place.value = index;
    const where = this.where(at).join(', ');
    place.setAttribute('aria-valuetext', where);
    here.textContent = where;
    this.mark(this.operation);
    this.table();
    this.shape();
  }

  // The chosen place in the plots of an operation.
  mark(operation) {
    const place = this.job.operations[operation].places[this.chosen[operation]];
    const plots = this.plots[operation] ?? [];
    const along = plots.filter((p) => p.area.dataset.along !== undefined);
    along.forEach((p) => p.moveCursor(this.abscissa(place)));
    plots.filter((p) => p.area.dataset.receptance !== undefined).forEach((p) => this.receptances(p, place));
  }

  where(at) {
    if (this.isMap) return this.pose(at);
    const { duration_s: duration } = this.job.operations[this.operation];
    const known = [`${shown(100 * at.s, 3)} % of the path`, `${shown(at.s * duration)} s`, `line ${at.line}`];
    if (at.beta2_rad !== null) known.push(`β2 ${shown(at.beta2_rad * 180 / Math.PI)}°`);
    known.push(`${shown(at.spindle_rpm)} rpm`);
    known.push(at.margin_percent === null ? 'no line counts' : `margin ${shown(at.margin_percent, 3)} %`);
    return known;
  }

  pose(at) {
    const joints = this.arm.joints.map((name, i) => {
      const slides = this.arm.parts.some((part) => part.joint?.index === i && part.joint.slides);
      const value = at.joints_rad[i];
      return slides ? `${name} ${shown(1000 * value)} mm` : `${name} ${shown(value * 180 / Math.PI)}°`;
    });
    if (at.beta2_rad !== null) joints.push(`β2 ${shown(at.beta2_rad * 180 / Math.PI)}°`);
    return [`pose ${at.line} of ${this.job.poses}`, ...joints];
  }

  table() {
    const at = this.here;
    const cell = (kind, text, value) => {
      const made = document.createElement(kind);
      if (text instanceof Node) made.append(text); else made.textContent = text;
      if (value !== undefined) made.dataset.value = value;
      return made;
    };
    const label = (input, text) => {
      const made = document.createElement('label');
      made.append(input, ` ${text}`);
      return made;
    };
    const rows = at.natural_frequencies_hz.map((hz, r) => {
      const row = document.createElement('tr'), [low, high] = at.natural_frequencies_ci95_hz[r];
      const pick = document.createElement('input');
      Object.assign(pick, { type: 'radio', name: this.parts.modes.id, checked: r === this.mode });
      pick.addEventListener('change', () => { this.mode = r; this.shape(); });
      row.append(
        cell('td', label(pick, r + 1), r + 1), cell('td', shown(hz), hz),
        low < high ? cell('td', `${shown(low)}–${shown(high)}`, `${low}–${high}`) : cell('td', '–'),
        cell('td', shown(100 * at.damping_ratios[r], 3), 100 * at.damping_ratios[r]),
        cell('td', shown(at.tip_response_um_per_n[r], 3), at.tip_response_um_per_n[r]));
      return row;
    });
    this.parts.modes.tBodies[0].replaceChildren(...rows);
  }

  receptances(plot, place) {
    const motions = tipMotions(this.arm, place), directions = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1] };
    // Even in the logarithm, and every resonance itself.
    const even = Array.from({ length: 300 }, (_, i) => plot.x.value(i / 299));
    const inside = place.natural_frequencies_hz.filter((hz) => hz > even[0] && hz < even[299]);
    const all = [...even, ...inside].sort((a, b) => a - b);
    for (const [name, direction] of Object.entries(directions)) {
      plot.curve(name, all.map((hz) => [hz, receptance(place, motions, direction, hz)]));
    }
  }

  // The chosen mode at a size that can be seen, and what takes part in it.
  shape() {
    const share = Number(this.parts.size.value) / 100;
    this.mode = Math.min(this.mode, this.here.shapes.length - 1);
    this.alpha = visible(this.arm, this.here, this.mode, this.size, share);
    const shape = this.here.shapes[this.mode], largest = Math.max(...shape.map(Math.abs), 1e-300);
    const hz = this.here.natural_frequencies_hz[this.mode];
    this.parts.mode.textContent = `Mode ${this.mode + 1}, ${shown(hz)} Hz`;
    this.parts.shape.replaceChildren(...this.arm.axes.map((axis, i) => {
      const row = document.createElement('div'), name = document.createElement('span');
      const bar = document.createElement('meter'), number = document.createElement('span');
      const share = shape[i] / largest;
      name.textContent = axis.name;
      Object.assign(bar, { min: 0, max: 1, value: Math.abs(share) });
      bar.setAttribute('aria-label', `${axis.name} ${share.toFixed(2)}`);
      number.textContent = share.toFixed(2).replace('-', '−');
      row.append(name, bar, number);
      return row;
    }));
    this.draw();
  }

  draw() {
    if (!this.view || !this.alpha) return;
    this.view.draw({
      place: this.here, path: this.path, bodies: this.parts.bodies.checked,
      alpha: this.alpha.map((value) => value * this.phase),
    });
  }

  // The mode moves while it is asked to and somebody looks.
  run() {
    cancelAnimationFrame(this.frame);
    this.phase = 1;
    this.draw();
    if (!this.parts.animate.checked || document.hidden || !this.view) return;
    const start = performance.now();
    const step = (now) => {
      this.phase = Math.cos(2 * Math.PI * (now - start) / 1600);
      const box = this.parts.view.getBoundingClientRect();
      if (box.bottom > 0 && box.top < innerHeight) this.draw();
      this.frame = requestAnimationFrame(step);
    };
    this.frame = requestAnimationFrame(step);
  }

  listen(plot, operation) {
    const along = plot.area.dataset.along !== undefined;
    const nearest = (x) => {
      const apart = (i) => Math.abs(this.abscissa(this.places[i]) - x);
      return this.places.reduce((best, _, i) => (apart(i) < apart(best) ? i : best), 0);
    };
    plot.area.addEventListener('pointermove', (event) => {
      if (operation !== this.operation) return;
      const x = plot.under(event);
      if (!along) return showTip(event, this.readReceptance(x));
      const at = this.places[nearest(x)];
      const modes = at.natural_frequencies_hz.map((hz, r) => `mode ${r + 1}: ${shown(hz)} Hz`);
      showTip(event, [...this.where(at), ...modes]);
      if (event.buttons === 1) this.go(nearest(x));
    });
    plot.area.addEventListener('pointerleave', () => { tip.hidden = true; });
    plot.area.addEventListener('click', (event) => { if (along) this.go(nearest(plot.under(event))); });
  }

  readReceptance(hz) {
    const motions = tipMotions(this.arm, this.here);
    const one = (direction) => shown(receptance(this.here, motions, direction, hz), 3);
    const [x, y, z] = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map(one);
    return [`${shown(hz)} Hz`, `x: ${x} µm/N`, `y: ${y} µm/N`, `z: ${z} µm/N`];
  }
}
