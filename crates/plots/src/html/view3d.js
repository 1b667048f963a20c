// The boundary of a body in 3D: orbit, fields, increments and the pane under the pointer, drawn by WebGL 2; where there is
// none, the page shows its pictures. The arrays are those of view3d.rs; nothing is loaded from anywhere.
//
// The state stands in the address (#view3d?increment=3&field=zone; case=3 for a sweep) and in data-* attributes of the figure.
"use strict";
(async () => {
  const byId = (name) => document.getElementById("view3d-" + name);
  const figure = byId("figure"), body = byId("body"), marks = byId("marks");
  const inputs = Object.fromEntries(
    ["field", "increment", "scale", "pane", "only", "obstacle", "mesh"].map((name) => [name, byId(name)]));
  const GREY = [214, 214, 214], OBSTACLE = [228, 226, 218], NO_VALUE = [170, 170, 170];
  const HOME = { azimuth: -60, elevation: 25 };

  // ---- Arrays in single precision, as view3d.rs packs them ----

  async function inflated(base64) {
    const bytes = Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  }

  /** Gives each array its values by frame: the bits of the frame before with those that change. */
  function decode(arrays, bytes) {
    let at = 0;
    for (const array of arrays) {
      const count = array.rows * array.columns;
      array.values = [];
      for (let frame = 0, before = null; frame < array.frames; frame++) {
        const bits = new Uint32Array(count);
        for (let plane = 0; plane < 4; plane++) {
          for (let k = 0; k < count; k++) bits[k] |= bytes[at++] << (8 * plane);
        }
        if (before) for (let k = 0; k < count; k++) bits[k] ^= before[k];
        array.values.push(new Float32Array(bits.buffer));
        before = bits;
      }
    }
    if (at !== bytes.length) throw new Error("the arrays of the page are incomplete");
    return Object.fromEntries(arrays.map((array) => [array.key, array]));
  }

  /** A value, NaN where there is none. An array with fewer frames begins later or does not change. */
  function value(array, frame, row, column = 0) {
    const values = array.values[Math.min(frame - array.first, array.frames - 1)];
    return values ? values[row * array.columns + column] : NaN;
  }

  const vector = (array, frame, row) => [...Array(array.columns).keys()].map((column) => value(array, frame, row, column));
  const shown = (array, frame, row) =>
    array.columns === 1 ? value(array, frame, row) : Math.hypot(...vector(array, frame, row));

  /** Smallest and largest value over all frames. */
  function rangeOf(array) {
    if (!array.range) {
      array.range = [Infinity, -Infinity];
      for (let frame = array.first; frame < array.first + array.frames; frame++) {
        for (let row = 0; row < array.rows; row++) {
          const v = shown(array, frame, row);
          if (v < array.range[0]) array.range[0] = v;
          if (v > array.range[1]) array.range[1] = v;
        }
      }
    }
    return array.range;
  }

  /** A number with six digits. */
  function written(v) {
    if (Number.isNaN(v)) return "no value";
    const rounded = Number(v.toPrecision(6)), size = Math.abs(rounded);
    return v === 0 || (size >= 1e-4 && size < 1e5) ? String(rounded) : rounded.toExponential().replace("+", "");
  }

  // ---- What the page holds ----

  /** Pictures in place of the view. */
  function without(problem) {
    figure.hidden = true;
    byId("without").hidden = false;
    byId("without").textContent = `The view cannot be shown (${problem.message}); the rest of the page needs no script.`;
    document.querySelectorAll("details.picture").forEach((picture) => (picture.open = true));
  }

  const page = JSON.parse(byId("data").textContent);
  let arrays;
  try {
    arrays = decode(page.arrays, await inflated(byId("arrays").textContent.trim()));
  } catch (problem) {
    return without(problem);
  }
  const { points, triangles, displacement } = arrays;
  const corner = (triangle, k) => value(triangles, 0, triangle, k);
  const paneOf = (triangle) => (arrays.triangle_pane ? value(arrays.triangle_pane, 0, triangle) : NaN);
  const nFrames = page.frames.length, nTriangles = triangles.rows;
  const fields = page.arrays.filter((array) => array.map || array.classes);
  const onPanes = page.arrays.filter((array) => array.on === "pane");
  const nPanes = onPanes.length ? onPanes[0].rows : 0;
  const low = [Infinity, Infinity, Infinity], high = low.map((v) => -v);
  for (let row = 0; row < points.rows; row++) {
    vector(points, 0, row).forEach((v, c) => {
      low[c] = Math.min(low[c], v);
      high[c] = Math.max(high[c], v);
    });
  }
  const centre = low.map((v, c) => (v + high[c]) / 2);
  const radius = Math.hypot(...low.map((v, c) => high[c] - v)) / 2;

  /** A round factor that makes displacements visible. */
  const factor = (() => {
    const wanted = (0.3 * radius) / rangeOf(displacement)[1];
    if (!(wanted > 1) || !Number.isFinite(wanted)) return 1;
    const power = 10 ** Math.floor(Math.log10(wanted));
    return power * [5, 2, 1].find((digit) => digit * power <= wanted);
  })();

  /** Outward from the contact face: the side to look from at it. */
  const outward = (() => {
    const sum = [0, 0, 0];
    for (let t = 0; t < nTriangles; t++) {
      if (Number.isNaN(paneOf(t))) continue;
      const [a, b, c] = [0, 1, 2].map((k) => vector(points, 0, corner(t, k)));
      cross(minus(b, a), minus(c, a)).forEach((v, k) => (sum[k] += v));
    }
    const length = Math.hypot(...sum);
    return length > 0 ? sum.map((v) => v / length) : null;
  })();

  function minus(a, b) { return a.map((v, k) => v - b[k]); }
  function cross(a, b) {
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  }

  /** Edges of the body at rest where triangles meet at more than 30°. */
  const outline = (() => {
    const sides = new Map();
    for (let t = 0; t < nTriangles; t++) {
      const nodes = [0, 1, 2].map((k) => corner(t, k)), [a, b, c] = nodes.map((n) => vector(points, 0, n));
      const normal = cross(minus(b, a), minus(c, a)), length = Math.hypot(...normal);
      for (let k = 0; k < 3; k++) {
        const edge = [nodes[k], nodes[(k + 1) % 3]].sort((p, q) => p - q), name = edge.join();
        if (!sides.has(name)) sides.set(name, { edge, normals: [] });
        sides.get(name).normals.push(normal.map((v) => v / length));
      }
    }
    const isSharp = ([n, m]) => !m || n[0] * m[0] + n[1] * m[1] + n[2] * m[2] < 0.866;
    return [...sides.values()].filter((side) => isSharp(side.normals)).map((side) => side.edge);
  })();

  // ---- State ----

  const state = {};

  function readAddress() {
    const [name, query] = location.hash.slice(1).split("?");
    const given = new URLSearchParams(name === "view3d" ? query : "");
    const number = (key, otherwise, least, most) => {
      const v = given.has(key) ? Number(given.get(key)) : NaN;
      return Number.isFinite(v) ? Math.min(Math.max(v, least), most) : otherwise;
    };
    const frame = Math.round(number("increment", nFrames, 1, nFrames)) - 1;
    const angle = (key, most) => number(key, null, -most, most);
    Object.assign(state, {
      field: fields.find((field) => field.key === given.get("field")) ?? fields[0],
      frame,
      scale: number("scale", factor, 0, 1e9),
      azimuth: angle("azimuth", 360),
      elevation: angle("elevation", 90),
      zoom: number("zoom", 1, 0.2, 50),
      shift: [0, 0],
      pane: nPanes && given.has("pane") ? Math.round(number("pane", 0, 0, nPanes - 1)) : null,
      obstacle: given.get("obstacle") !== "off",
      mesh: given.get("mesh") !== "off",
      only: page.bodies.includes(given.get("only")) ? given.get("only") : null,
      hovered: null,
    });
    return query !== undefined && name === "view3d";
  }

  /** What the state says in words: the address, and the attributes of the figure. */
  function words() {
    const said = {
      increment: state.frame + 1,
      field: state.field.key,
      scale: Number(state.scale.toPrecision(4)),
      azimuth: state.azimuth === null ? null : Math.round(state.azimuth),
      elevation: state.elevation === null ? null : Math.round(state.elevation),
      zoom: state.zoom === 1 ? null : Number(state.zoom.toPrecision(3)),
      pane: state.pane,
      obstacle: state.obstacle ? null : "off",
      mesh: state.mesh ? null : "off",
      only: state.only,
    };
    return Object.entries(said);
  }

  let writing = 0;
  function change(changes) {
    Object.assign(state, changes);
    draw();
    clearTimeout(writing);
    writing = setTimeout(() => {
      const query = words().filter(([, v]) => v !== null).map(([key, v]) => `${key}=${encodeURIComponent(v)}`);
      try { history.replaceState(null, "", "#view3d?" + query.join("&")); } catch { /* a page without an address */ }
    }, 200);
  }

  // ---- The look at the body: right, up and towards the viewer ----

  function angles() {
    const own = state.azimuth !== null || state.elevation !== null;
    let { azimuth, elevation } = HOME;
    if (!own && state.field.on === "pane" && outward) {
      const [x, y, z] = outward;
      if (Math.hypot(x, y) > 0.1) azimuth = (Math.atan2(y, x) * 180) / Math.PI + 25;
      elevation = Math.min(Math.max((Math.asin(z) * 180) / Math.PI, -60), 60);
    }
    return [state.azimuth ?? azimuth, state.elevation ?? elevation];
  }

  function look() {
    const [a, e] = angles().map((degrees) => (degrees * Math.PI) / 180);
    const [width, height] = [body.width, body.height];
    const size = (0.46 * Math.min(width, 1.3 * height) * state.zoom) / radius;
    const axes = [
      [-Math.sin(a), Math.cos(a), 0],
      [-Math.sin(e) * Math.cos(a), -Math.sin(e) * Math.sin(a), Math.cos(e)],
      [Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e)],
    ];
    const dot = (axis, p) => axis[0] * p[0] + axis[1] * p[1] + axis[2] * p[2];
    const middle = [width * (0.5 + state.shift[0]), height * (0.5 + state.shift[1])];
    /** Pixels from the left, from the top, and towards the viewer. */
    const pixel = (p) => [middle[0] + size * dot(axes[0], p), middle[1] - size * dot(axes[1], p), size * dot(axes[2], p)];
    return { axes, size, middle, pixel };
  }

  // ---- What is drawn: places from the middle of the body, and colours of corners ----

  function placed(array, moves, scale, row) {
    const x = vector(array, 0, row), u = moves && scale > 0 ? vector(moves, state.frame, row) : [0, 0, 0];
    return x.map((v, c) => v - centre[c] + (Number.isNaN(u[c]) ? 0 : scale * u[c]));
  }

  function colour(field, row) {
    const v = shown(field, state.frame, row);
    if (Number.isNaN(v)) return NO_VALUE;
    if (field.classes) return rgb(field.classes[v].colour);
    const [from, to] = rangeOf(field), stops = page.maps[field.map];
    const at = (to > from ? (v - from) / (to - from) : 0.5) * (stops.length - 1);
    const below = Math.min(Math.floor(at), stops.length - 2), [p, q] = [rgb(stops[below]), rgb(stops[below + 1])];
    return p.map((channel, k) => channel + (at - below) * (q[k] - channel));
  }
  const rgb = (hex) => [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16));

  /** Whether a triangle is of another body than the only one shown. */
  const isHidden = (t) => state.only !== null && page.bodies[value(arrays.triangle_body, 0, t)] !== state.only;

  function scene() {
    const { field } = state, rows = [...Array(field.on === "triangle" ? 0 : field.rows).keys()];
    const colours = rows.map((row) => colour(field, row));
    const places = [...Array(points.rows).keys()].map((row) => placed(points, displacement, state.scale, row));
    const of = { point: (t, k) => colours[corner(t, k)], triangle: (t) => colour(field, t),
      pane: (t) => colours[paneOf(t)] ?? GREY }[field.on];
    const facets = [];
    for (let t = 0; t < nTriangles; t++) {
      if (isHidden(t)) continue;
      facets.push({ triangle: t, places: [0, 1, 2].map((k) => places[corner(t, k)]), colours: [0, 1, 2].map((k) => of(t, k)) });
    }
    const ground = [];
    if (arrays.obstacle_triangles && state.obstacle) {
      for (let t = 0; t < arrays.obstacle_triangles.rows; t++) {
        const nodes = vector(arrays.obstacle_triangles, 0, t);
        const isFar = (node) => shown(arrays.obstacle_gaps, state.frame, node) * state.scale > radius / 2;
        if (nodes.some(isFar)) continue; // Far gaps, enlarged as displacements are, would fill the picture.
        ground.push({ triangle: null, colours: [OBSTACLE, OBSTACLE, OBSTACLE],
          places: nodes.map((node) => placed(arrays.obstacle_points, arrays.obstacle_gaps, state.scale, node)) });
      }
    }
    return { places, facets, ground };
  }

  // ---- The painter ----

  const VERTEX = `#version 300 es
    in vec3 place; in vec3 tint; uniform mat3 axes; uniform vec3 size; uniform vec2 middle;
    out vec3 seen; out vec3 corner; out vec3 paint;
    void main() {
      seen = place * axes; paint = tint;
      corner = vec3(gl_VertexID % 3 == 0, gl_VertexID % 3 == 1, gl_VertexID % 3 == 2);
      gl_Position = vec4(seen * size + vec3(middle, 0.0), 1.0);
    }`;
  const FRAGMENT = `#version 300 es
    precision highp float;
    in vec3 seen; in vec3 corner; in vec3 paint; out vec4 colour; uniform float edges;
    void main() {
      vec3 normal = normalize(cross(dFdx(seen), dFdy(seen))), width = fwidth(corner);
      vec3 near = smoothstep(vec3(0.0), width, corner);
      // Triangles of a few pixels would be nothing but edges.
      float shown = edges * (1.0 - smoothstep(0.1, 0.5, max(width.x, max(width.y, width.z))));
      float line = 1.0 - shown * (1.0 - min(near.x, min(near.y, near.z)));
      colour = vec4(paint * line * (0.78 + 0.22 * abs(normal.z)), 1.0);
    }`;

  function webgl() {
    const gl = body.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
    if (!gl) throw new Error("it needs WebGL 2");
    const program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
    gl.useProgram(program);
    const uniform = (name) => gl.getUniformLocation(program, name);
    const buffers = ["place", "tint"].map((name) => {
      const buffer = gl.createBuffer(), at = gl.getAttribLocation(program, name);
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.enableVertexAttribArray(at);
      gl.vertexAttribPointer(at, 3, gl.FLOAT, false, 0, 0);
      return buffer;
    });
    body.addEventListener("webglcontextlost", () => without(new Error("the graphics context was lost")));
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.CULL_FACE);
    gl.clearColor(1, 1, 1, 1);
    let held = null;
    return ({ facets, ground }, seen) => {
      if (held !== facets) {
        const all = ground.concat(facets), fill = [(f) => f.places, (f) => f.colours];
        const units = [radius, 255];
        buffers.forEach((buffer, k) => {
          gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
          gl.bufferData(gl.ARRAY_BUFFER, Float32Array.from(all.flatMap(fill[k]).flat(), (v) => v / units[k]), gl.STATIC_DRAW);
        });
        held = facets;
      }
      const [width, height] = [body.width, body.height], size = seen.size * radius;
      gl.viewport(0, 0, width, height);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      gl.uniformMatrix3fv(uniform("axes"), false, seen.axes.flat());
      gl.uniform3f(uniform("size"), (2 * size) / width, (2 * size) / height, -0.2);
      gl.uniform2f(uniform("middle"), (2 * seen.middle[0]) / width - 1, 1 - (2 * seen.middle[1]) / height);
      // Where body and obstacle touch, the body is in front.
      gl.enable(gl.POLYGON_OFFSET_FILL);
      gl.polygonOffset(2, 8);
      gl.uniform1f(uniform("edges"), state.mesh ? 0.06 : 0);
      gl.drawArrays(gl.TRIANGLES, 0, 3 * ground.length);
      gl.disable(gl.POLYGON_OFFSET_FILL);
      gl.uniform1f(uniform("edges"), state.mesh ? 0.25 : 0);
      gl.drawArrays(gl.TRIANGLES, 3 * ground.length, 3 * facets.length);
    };
  }

  /** Outlines at rest and of the pane that is looked at, and the axes. */
  function drawMarks({ places }, seen) {
    const pen = marks.getContext("2d"), dots = window.devicePixelRatio || 1;
    pen.clearRect(0, 0, marks.width, marks.height);
    const line = (from, to) => { pen.beginPath(); pen.moveTo(from[0], from[1]); pen.lineTo(to[0], to[1]); pen.stroke(); };
    pen.strokeStyle = "rgba(40, 40, 40, 0.45)";
    pen.lineWidth = dots;
    pen.setLineDash([4 * dots, 4 * dots]);
    for (const edge of outline) line(...edge.map((node) => seen.pixel(placed(points, null, 0, node))));
    pen.setLineDash([]);
    const pane = state.hovered !== null ? paneOf(state.hovered) : state.pane;
    if (pane !== null && !Number.isNaN(pane)) {
      const count = new Map();
      for (let t = 0; t < nTriangles; t++) {
        if (paneOf(t) !== pane) continue;
        for (let k = 0; k < 3; k++) {
          const edge = [corner(t, k), corner(t, (k + 1) % 3)], name = edge.toSorted((p, q) => p - q).join();
          count.set(name, count.has(name) ? null : edge);
        }
      }
      for (const [tint, width] of [["#fff", 4], ["#c00", 2]]) {
        pen.strokeStyle = tint;
        pen.lineWidth = width * dots;
        for (const edge of count.values()) if (edge) line(...edge.map((node) => seen.pixel(places[node])));
      }
    }
    const origin = [46 * dots, marks.height - 46 * dots];
    pen.strokeStyle = pen.fillStyle = "#000";
    pen.lineWidth = 1.4 * dots;
    pen.font = `italic ${14 * dots}px serif`;
    ["x", "y", "z"].forEach((name, axis) => {
      const tip = [30, -30].map((length, k) => origin[k] + length * dots * seen.axes[k][axis]);
      line(origin, tip);
      pen.fillText(name, tip[0] + 3 * dots, tip[1] - 2 * dots);
    });
  }

  // ---- Words beside the picture ----

  function valuesOf(list, row) {
    return list.map((array) => {
      const text = array.classes
        ? array.classes[value(array, state.frame, row)]?.label ?? "no value"
        : vector(array, state.frame, row).map((v) => written(v)).join(", ");
      const several = array.columns > 1 ? `(${text})` : text;
      return `${array.label} ${several}${array.unit && !text.includes("no value") ? " " + array.unit : ""}`;
    });
  }

  /** The numbers of a pane, or of a triangle and its first corner; empty where nothing is looked at. */
  function numbers() {
    const t = state.hovered, pane = t !== null ? paneOf(t) : state.pane ?? NaN;
    if (!Number.isNaN(pane)) return [`pane ${pane}`, ...valuesOf(onPanes, pane)].join("; ");
    if (t === null) return "";
    const node = corner(t, 0), on = (kind) => page.arrays.filter((array) => array.on === kind && array.label);
    return [...valuesOf(on("triangle"), t), ...valuesOf(on("point"), node)].join("; ");
  }

  function drawKey() {
    const { field } = state, key = byId("key"), pen = key.getContext("2d"), [from, to] = rangeOf(field);
    byId("key-label").textContent = field.unit ? `${field.label} in ${field.unit}` : field.label;
    const colours = field.classes ? field.classes.map((one) => one.colour) : page.maps[field.map];
    colours.forEach((tint, k) => {
      pen.fillStyle = tint;
      pen.fillRect((k * key.width) / colours.length, 0, key.width / colours.length + 1, key.height);
    });
    const ends = from > to ? ["no value", ""] : [written(from), written(to)];
    byId("low").textContent = field.classes ? field.classes.map((one) => one.label).join(", ") : ends[0];
    byId("high").textContent = field.classes ? "" : ends[1];
    return ends;
  }

  let painter, drawn = null, drawnFor = "";
  function draw() {
    const same = [state.field.key, state.frame, state.scale, state.obstacle, state.only].join();
    if (same !== drawnFor) [drawn, drawnFor] = [scene(), same];
    const seen = look(), said = numbers(), [from, to] = drawKey();
    painter(drawn, seen);
    drawMarks(drawn, seen);
    inputs.field.value = state.field.key;
    inputs.increment.value = state.frame + 1;
    inputs.scale.value = state.scale;
    inputs.pane.value = state.pane ?? "";
    inputs.obstacle.checked = state.obstacle;
    inputs.mesh.checked = state.mesh;
    inputs.only.value = state.only ?? "";
    byId("increment-said").textContent = page.frames[state.frame];
    inputs.increment.setAttribute("aria-valuetext", page.frames[state.frame]);
    byId("scale-said").textContent = "× " + Number(state.scale.toPrecision(3));
    byId("values").textContent = said || (nPanes ? "Point at a pane, or choose one by its number." : "Point at the body.");
    body.setAttribute("aria-label", `${page.title}: ${state.field.label}, ${page.frames[state.frame]}`);
    for (const [key, v] of [...words(), ["values", said], ["low", from], ["high", to]]) {
      if (v === null) delete figure.dataset[key];
      else figure.dataset[key] = v;
    }
  }

  /** The triangle in front at a place of the picture in pixels. */
  function pick(x, y) {
    const seen = look(), pixels = drawn.places.map(seen.pixel);
    let found = null, front = -Infinity;
    for (let t = 0; t < nTriangles; t++) {
      const [a, b, c] = [0, 1, 2].map((k) => pixels[corner(t, k)]);
      const side = (p, q) => (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]);
      const [ab, bc, ca] = [side(a, b), side(b, c), side(c, a)], sum = ab + bc + ca;
      if (ab > 0 || bc > 0 || ca > 0 || sum === 0 || isHidden(t)) continue;
      const depth = (bc * a[2] + ca * b[2] + ab * c[2]) / sum;
      if (depth > front) [found, front] = [t, depth];
    }
    return found;
  }

  // ---- Hands: pointer, wheel, keys, inputs ----

  const turn = (da, de) => {
    const [azimuth, elevation] = angles();
    change({ azimuth: ((azimuth + da + 540) % 360) - 180, elevation: Math.min(Math.max(elevation + de, -90), 90) });
  };
  const move = (dx, dy) => change({ shift: [state.shift[0] + dx, state.shift[1] + dy] });
  const zoom = (by) => change({ zoom: Math.min(Math.max(state.zoom * by, 0.2), 50) });
  const home = () => change({ azimuth: null, elevation: null, zoom: 1, shift: [0, 0] });
  const atPixel = (event) => {
    const box = body.getBoundingClientRect();
    return pick(((event.clientX - box.left) * body.width) / box.width, ((event.clientY - box.top) * body.height) / box.height);
  };

  function listen() {
    let dragged = null;
    body.addEventListener("pointerdown", (event) => {
      dragged = { length: 0, at: [event.clientX, event.clientY] };
      if (event.isTrusted) body.setPointerCapture(event.pointerId);
    });
    body.addEventListener("pointermove", (event) => {
      if (!dragged) return change({ hovered: atPixel(event) });
      const [dx, dy] = [event.clientX - dragged.at[0], event.clientY - dragged.at[1]];
      dragged = { length: dragged.length + Math.hypot(dx, dy), at: [event.clientX, event.clientY] };
      if (event.shiftKey) move(dx / body.clientWidth, dy / body.clientHeight);
      else turn(-dx / 2, dy / 2);
    });
    body.addEventListener("pointerup", (event) => {
      const found = dragged && dragged.length < 4 ? atPixel(event) : null;
      dragged = null;
      if (found !== null) change({ pane: Number.isNaN(paneOf(found)) ? null : paneOf(found) });
    });
    body.addEventListener("pointerleave", () => change({ hovered: null }));
    body.addEventListener("wheel", (event) => {
      if (document.activeElement !== body) return; // The page scrolls until the view is chosen.
      event.preventDefault();
      zoom(Math.exp(-event.deltaY / 500));
    }, { passive: false });
    const keys = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    body.addEventListener("keydown", (event) => {
      const way = keys[event.key], others = { "+": () => zoom(1.2), "=": () => zoom(1.2), "-": () => zoom(1 / 1.2), Home: home };
      if (way) event.shiftKey ? move(0.03 * way[0], 0.03 * way[1]) : turn(-5 * way[0], 5 * way[1]);
      else if (others[event.key]) others[event.key]();
      else return;
      event.preventDefault();
    });
    inputs.field.addEventListener("change", () => change({ field: arrays[inputs.field.value] }));
    inputs.increment.addEventListener("input", () => change({ frame: Number(inputs.increment.value) - 1 }));
    inputs.scale.addEventListener("input", () => change({ scale: Number(inputs.scale.value) }));
    inputs.obstacle.addEventListener("change", () => change({ obstacle: inputs.obstacle.checked }));
    inputs.mesh.addEventListener("change", () => change({ mesh: inputs.mesh.checked }));
    inputs.only.addEventListener("change", () => change({ only: inputs.only.value || null }));
    inputs.pane.addEventListener("input", () => {
      const pane = inputs.pane.value === "" ? NaN : Math.round(Number(inputs.pane.value));
      change({ pane: pane >= 0 && pane < nPanes ? pane : null });
    });
    byId("home").addEventListener("click", home);
    window.addEventListener("hashchange", () => { if (readAddress()) draw(); });
    new ResizeObserver(() => { if (resize()) draw(); }).observe(body);
  }

  function resize() {
    const dots = window.devicePixelRatio || 1, size = [body.clientWidth * dots, body.clientHeight * dots].map(Math.round);
    if (body.width === size[0] && body.height === size[1]) return false;
    for (const canvas of [body, marks]) [canvas.width, canvas.height] = size;
    return true;
  }

  fields.forEach((field) => inputs.field.add(new Option(field.label, field.key)));
  Object.assign(inputs.increment, { max: nFrames });
  inputs.increment.closest("label").hidden = nFrames < 2;
  Object.assign(inputs.scale, { max: 3 * factor, step: factor / 20 });
  inputs.pane.max = nPanes - 1;
  inputs.pane.closest("label").hidden = !nPanes;
  page.bodies.forEach((name) => inputs.only.add(new Option(name, name)));
  inputs.only.closest("label").hidden = !page.bodies.length;
  inputs.obstacle.closest("label").hidden = !arrays.obstacle_triangles;
  figure.hidden = false;
  resize();
  const asked = readAddress();
  try {
    painter = webgl();
    draw();
  } catch (problem) {
    return without(problem);
  }
  listen();
  byId("without").hidden = true;
  document.querySelectorAll("details.picture").forEach((picture) => (picture.open = false));
  if (asked) byId("figure").scrollIntoView();
  figure.dataset.ready = "true";
})();
