// The viewer of one run: draws the data of this page with three.js. Coordinates are those of the
// map (metres, z up); times are seconds after the first frame.
'use strict';
(function () {

const state = { time: 0, playing: false, spread: 0, follow: false, grow: false, byResidual: false,
                selected: null, errors: [] };
window.addEventListener('error', e => fail(e.message));

function fail(message) {
  state.errors.push(String(message));
  const box = document.getElementById('failure');
  box.textContent = 'This page cannot be shown: ' + message;
  box.hidden = false;
}

const $ = id => document.getElementById(id);
const data = JSON.parse($('data').textContent);

// ---- Data ------------------------------------------------------------------------------------

function bytes(text) {
  const raw = atob(text), out = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; ++i) out[i] = raw.charCodeAt(i);
  return out.buffer;
}
const floats = text => new Float32Array(bytes(text));

function cssColor(rgb) { return '#' + rgb.toString(16).padStart(6, '0'); }
function fixed(x, digits) { return x.toFixed(digits === undefined ? 2 : digits); }

/** Rows of [t x y z qx qy qz qw ...] in one array. */
function rowsOf(text, width) {
  const flat = floats(text), rows = [];
  for (let i = 0; i + width <= flat.length; i += width) rows.push(flat.subarray(i, i + width));
  return rows;
}

/** Index of the last row at or before a time; -1 before the first. */
function lastBefore(rows, time) {
  let low = 0, high = rows.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (rows[middle][0] <= time + 1e-4) low = middle + 1; else high = middle;
  }
  return low - 1;
}

function poseAt(rows, time, position, quaternion) {
  const i = Math.max(0, lastBefore(rows, time));
  const a = rows[i], b = rows[Math.min(i + 1, rows.length - 1)];
  const s = b[0] > a[0] ? Math.min(1, Math.max(0, (time - a[0]) / (b[0] - a[0]))) : 0;
  position.set(a[1] + s * (b[1] - a[1]), a[2] + s * (b[2] - a[2]), a[3] + s * (b[3] - a[3]));
  quaternion.set(a[4], a[5], a[6], a[7]);
  quaternion.slerp(new THREE.Quaternion(b[4], b[5], b[6], b[7]), s);
}

const frames = rowsOf(data.frames, 8);
const entities = data.entities.map(e => Object.assign({}, e, { track: rowsOf(e.track, 10) }));

// ---- Scene -----------------------------------------------------------------------------------

THREE.Object3D.DefaultUp.set(0, 0, 1);
let renderer;
try {
  renderer = new THREE.WebGLRenderer({ canvas: $('view'), antialias: true,
                                       preserveDrawingBuffer: true });
} catch (e) {
  fail('this browser has no WebGL');
  return;
}
renderer.setPixelRatio(window.devicePixelRatio || 1);
const scene = new THREE.Scene();
const camera = new THREE.PerspectiveCamera(45, 1, 0.05, 5000);
const controls = new THREE.OrbitControls(camera, renderer.domElement);
controls.enableDamping = true;
controls.dampingFactor = 0.12;
controls.screenSpacePanning = true;
scene.add(new THREE.HemisphereLight(0xffffff, 0xa0a8b4, 0.95));
const sun = new THREE.DirectionalLight(0xffffff, 0.45);
sun.position.set(2, -3, 5);
scene.add(sun);

/** How many steps of the spread each layer of the graph is lifted. */
const kLevel = { points: 0, keyframe: 1, plane: 2, entity: 2, floor: 3 };
const layers = [];

/** The colours that an object is drawn in, but for those that its vertices carry. */
function colorsOf(object) {
  const colors = new Set();
  object.traverse(o => {
    if (o.material && !o.material.vertexColors) colors.add(o.material.color.getHex());
  });
  return [...colors];
}

/** What stands for a layer in the list: its colours side by side, the first of them when there are many. */
function swatchOf(object) {
  const colors = colorsOf(object).slice(0, 4).map(cssColor);
  const stops = colors.map((c, i) => `${c} ${100 * i / colors.length}% ${100 * (i + 1) / colors.length}%`);
  return stops.length > 1 ? `linear-gradient(90deg, ${stops.join(', ')})` : colors[0] || 'none';
}

function addLayer(group, name, object, options) {
  const layer = Object.assign({ group, name, object, visible: true, level: 0, swatch: swatchOf(object) }, options);
  layer.object.visible = layer.visible;
  scene.add(layer.object);
  layers.push(layer);
  return layer;
}

function pointCloud(cloud) {
  const packed = new Uint16Array(bytes(cloud.positions));
  const position = new Float32Array(packed.length);
  for (let i = 0; i < packed.length; ++i)
    position[i] = cloud.min[i % 3] + cloud.step[i % 3] * packed[i];
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(position, 3));
  const material = new THREE.PointsMaterial({ size: 1.6, sizeAttenuation: false });
  if (cloud.colors) {
    geometry.setAttribute('color', new THREE.BufferAttribute(new Uint8Array(bytes(cloud.colors)), 3, true));
    material.vertexColors = THREE.VertexColors;
  } else {
    material.color.set(cloud.color);
  }
  return new THREE.Points(geometry, material);
}

function lineStrip(points, color, opacity) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(points), 3));
  return new THREE.Line(geometry, new THREE.LineBasicMaterial(
      { color, transparent: opacity < 1, opacity }));
}

/** A tube through points with steps of some length, since WebGL draws lines one pixel wide. */
function tube(rows, radius, color) {
  const points = [];
  rows.forEach((row, i) => {
    const p = new THREE.Vector3(row[1], row[2], row[3]);
    const last = points[points.length - 1];
    if (!last || last.distanceTo(p) > 0.05 || (i + 1 === rows.length && last.distanceTo(p) > 1e-4))
      points.push(p);
  });
  if (points.length < 2) return new THREE.Group();
  const path = new THREE.CurvePath();
  for (let i = 1; i < points.length; ++i) path.add(new THREE.LineCurve3(points[i - 1], points[i]));
  const geometry = new THREE.TubeBufferGeometry(path, Math.min(8000, 3 * points.length), radius, 6);
  return new THREE.Mesh(geometry, new THREE.MeshLambertMaterial({ color }));
}

function axes(size) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(
      [0, 0, 0, size, 0, 0, 0, 0, 0, 0, size, 0, 0, 0, 0, 0, 0, size]), 3));
  geometry.setAttribute('color', new THREE.BufferAttribute(new Float32Array(
      [.84, .15, .16, .84, .15, .16, .17, .63, .17, .17, .63, .17, .12, .47, .71, .12, .47, .71]), 3));
  return new THREE.LineSegments(geometry,
                                new THREE.LineBasicMaterial({ vertexColors: THREE.VertexColors }));
}

// Map points.
const structure = pointCloud(data.points);
addLayer('Map', 'Points', structure, { swatch: '#8c96a3', count: data.points.count });

// Floors.
const floors = new THREE.Group();
data.floors.forEach(f => {
  const [x0, y0, x1, y1] = f.area;
  const size = Math.max(x1 - x0, y1 - y0);
  const plate = new THREE.Mesh(
      new THREE.PlaneBufferGeometry(x1 - x0, y1 - y0),
      new THREE.MeshBasicMaterial({ color: 0x9aa7b8, transparent: true, opacity: 0.13,
                                    side: THREE.DoubleSide, depthWrite: false }));
  plate.position.set((x0 + x1) / 2, (y0 + y1) / 2, f.level - 0.01);
  plate.userData.text = 'floor ' + f.id + '\nlevel ' + fixed(f.level, 3) + ' m';
  const grid = new THREE.GridHelper(size, Math.max(1, Math.round(size)), 0xb8c0cc, 0xd3d9e2);
  grid.rotation.x = Math.PI / 2;
  grid.position.copy(plate.position);
  floors.add(plate, grid);
});
addLayer('Graph', 'Floors', floors, { count: data.floors.length, level: kLevel.floor });

// Planes, where the graph has any.
const planes = new THREE.Group();
data.planes.filter(p => !p.ceiling).forEach(p => {
  const corners = floats(p.triangles);
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(corners, 3));
  const face = new THREE.Mesh(geometry, new THREE.MeshBasicMaterial(
      { color: p.color, transparent: true, opacity: 0.22, side: THREE.DoubleSide, depthWrite: false }));
  face.userData.text = p.title;
  planes.add(face);
});
if (planes.children.length)
  addLayer('Graph', 'Planes', planes, { count: planes.children.length, level: kLevel.plane });

// Keyframes.
const keyframes = new THREE.Group();
const ball = new THREE.SphereBufferGeometry(0.06, 12, 8);
const keyframeMaterial = new THREE.MeshLambertMaterial({ color: 0x2b3a55 });
data.keyframes.forEach(k => {
  const mark = new THREE.Mesh(ball, keyframeMaterial);
  mark.position.set(k.pose[0], k.pose[1], k.pose[2]);
  mark.quaternion.set(k.pose[3], k.pose[4], k.pose[5], k.pose[6]);
  mark.add(axes(0.25));
  mark.userData = { time: k.t, text: 'keyframe ' + k.id + '\nat ' + fixed(k.t) + ' s\n' + k.reasons };
  keyframes.add(mark);
});
addLayer('Graph', 'Keyframes', keyframes, { count: data.keyframes.length, level: kLevel.keyframe });

// The robot's way.
addLayer('Robot', 'Trajectory', tube(frames, 0.025, 0x1a4fd6), { line: true, level: kLevel.keyframe });
const odometry = lineStrip(floats(data.odometry), 0x707b8c, 0.8);
addLayer('Robot', 'Odometry alone', odometry, { line: true, visible: false, level: kLevel.keyframe });
const robot = new THREE.Group();
const body = new THREE.Mesh(new THREE.BoxBufferGeometry(0.5, 0.4, 0.25),
                            new THREE.MeshLambertMaterial({ color: 0x1a4fd6 }));
const nose = new THREE.Mesh(new THREE.ConeBufferGeometry(0.14, 0.3, 16),
                            new THREE.MeshLambertMaterial({ color: 0xffc83d }));
nose.rotation.z = -Math.PI / 2;
nose.position.x = 0.35;
body.position.z = nose.position.z = 0.12;
robot.add(body, nose, axes(0.6));
addLayer('Robot', 'Robot', robot, { level: kLevel.keyframe });

// Entities.
const boxes = new THREE.Group(), tracks = new THREE.Group(), ghosts = new THREE.Group();
entities.forEach(e => {
  const size = [0, 1, 2].map(i => Math.max(0.02, e.max[i] - e.min[i]));
  const center = [0, 1, 2].map(i => (e.max[i] + e.min[i]) / 2);
  const shape = new THREE.BoxBufferGeometry(size[0], size[1], size[2]);
  shape.translate(center[0], center[1], center[2]);
  const outline = new THREE.EdgesGeometry(shape);
  e.node = new THREE.Group();
  e.box = new THREE.Mesh(shape, new THREE.MeshLambertMaterial(
      { color: e.color, transparent: true, opacity: 0.45, depthWrite: false }));
  e.frame = new THREE.LineSegments(outline, new THREE.LineBasicMaterial({ color: e.color }));
  e.cloud = e.points.count ? pointCloud(Object.assign({ color: e.color }, e.points)) : new THREE.Group();
  e.node.add(e.box, e.frame, e.cloud, axes(0.3));
  e.box.userData.entity = e;
  boxes.add(e.node);

  const agent = e.class === 'agent';
  if (agent) {
    e.way = tube(e.track, 0.02, e.color);
    e.way.userData.text = e.title + ': track';
    tracks.add(e.way);
  }
  e.ghosts = e.moves.map(m => {
    const group = new THREE.Group();
    const ghost = new THREE.Group();
    ghost.position.set(m.from[0], m.from[1], m.from[2]);
    ghost.quaternion.set(m.from[3], m.from[4], m.from[5], m.from[6]);
    const faces = new THREE.Mesh(shape, new THREE.MeshBasicMaterial(
        { color: e.color, transparent: true, opacity: 0.12, depthWrite: false }));
    faces.userData.text = e.title + ' was here\nuntil after ' + fixed(m.after) + ' s';
    ghost.add(faces, new THREE.LineSegments(outline, new THREE.LineBasicMaterial(
        { color: e.color, transparent: true, opacity: 0.6 })));
    const from = new THREE.Vector3(m.from[0], m.from[1], m.from[2] + e.max[2] + 0.05);
    const way = new THREE.Vector3(m.to[0], m.to[1], m.to[2] + e.max[2] + 0.05).sub(from);
    const length = way.length();
    group.add(ghost);
    if (length > 0.05)
      group.add(new THREE.ArrowHelper(way.normalize(), from, length, e.color, Math.min(0.35, 0.4 * length), 0.2));
    group.userData.after = m.after;
    ghosts.add(group);
    return group;
  });
});
addLayer('Graph', 'Entities', boxes, { count: entities.length, level: kLevel.entity });
addLayer('Graph', 'Tracks of agents', tracks, { line: true, level: kLevel.entity });
addLayer('Graph', 'Displaced objects', ghosts,
         { count: ghosts.children.length, level: kLevel.entity });

// Edges: one object per kind, ascending in time, so that a draw range shows those of a time.
const edgeKinds = data.edges.map(kind => {
  const segments = floats(kind.segments);        // x y z, x y z per line
  const levels = new Uint8Array(bytes(kind.levels));  // layer of each end
  const info = rowsOf(kind.info, 4);             // per line: time, edge id, eᵀΩe, residuals
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(segments.slice(), 3));
  const colors = new Float32Array(segments.length), base = new THREE.Color(kind.color);
  geometry.setAttribute('color', new THREE.BufferAttribute(colors, 3));
  const object = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial(
      { vertexColors: THREE.VertexColors, transparent: true, opacity: 0.6 }));
  const edge = { kind, segments, levels, info, object, geometry, colors, base };
  object.userData.edges = edge;
  const quiet = /floor|plane/.test(kind.kind);
  addLayer('Edges', kind.kind.replace(/_/g, ' '), object,
           { swatch: cssColor(kind.color), line: true, count: kind.count, visible: !quiet });
  return edge;
});

function residualColor(ratio, out) {
  const s = Math.min(1, ratio / 3);
  const stops = [[0.17, 0.63, 0.17], [0.90, 0.76, 0.16], [0.84, 0.15, 0.16]];
  const k = s < 0.45 ? 0 : 1, f = k === 0 ? s / 0.45 : (s - 0.45) / 0.55;
  for (let i = 0; i < 3; ++i) out[i] = stops[k][i] + f * (stops[k + 1][i] - stops[k][i]);
}

function paintEdges() {
  const rgb = [0, 0, 0];
  edgeKinds.forEach(e => {
    for (let line = 0; line < e.info.length; ++line) {
      if (state.byResidual) {
        residualColor(Math.sqrt(e.info[line][2] / e.info[line][3]), rgb);
      } else {
        rgb[0] = e.base.r; rgb[1] = e.base.g; rgb[2] = e.base.b;
      }
      e.colors.set(rgb, 6 * line);
      e.colors.set(rgb, 6 * line + 3);
    }
    e.geometry.attributes.color.needsUpdate = true;
  });
}

function spreadLayers() {
  const step = state.spread;
  layers.forEach(l => { l.object.position.z = step * l.level; });
  edgeKinds.forEach(e => {
    const position = e.geometry.attributes.position;
    for (let end = 0; end < e.levels.length; ++end)
      position.array[3 * end + 2] = e.segments[3 * end + 2] + step * e.levels[end];
    position.needsUpdate = true;
    e.geometry.computeBoundingSphere();
  });
}

// ---- Time ------------------------------------------------------------------------------------

const kAgentMemory_s = 1.5;  // an agent fades out when it was not seen for longer

/** Where an entity is drawn: objects stay where they were last seen, agents walk between. */
function place(e, time) {
  const i = lastBefore(e.track, time);
  const row = e.track[Math.max(0, i)];
  const agent = e.class === 'agent';
  if (agent && i >= 0 && i + 1 < e.track.length && e.track[i + 1][0] - row[0] <= 2 * kAgentMemory_s) {
    poseAt(e.track, time, e.node.position, e.node.quaternion);
    return 1;
  }
  e.node.position.set(row[1], row[2], row[3]);
  e.node.quaternion.set(row[4], row[5], row[6], row[7]);
  if (i < 0) return agent ? 0 : 0.25;
  return agent ? Math.max(0, 1 - Math.max(0, time - row[0] - kAgentMemory_s) / kAgentMemory_s) : 1;
}

function showTime(time) {
  state.time = Math.min(data.duration, Math.max(0, time));
  if (frames.length) poseAt(frames, state.time, robot.position, robot.quaternion);
  robot.position.z += state.spread * kLevel.keyframe;
  entities.forEach(e => {
    e.presence = place(e, state.time);
    e.node.visible = e.presence > 0.02;
    e.box.material.opacity = 0.45 * e.presence;
    e.frame.material.transparent = e.presence < 1;
    e.frame.material.opacity = e.presence;
    e.ghosts.forEach(g => { g.visible = g.userData.after <= state.time; });
    if (e.row) e.row.classList.toggle('unseen', lastBefore(e.track, state.time) < 0);
  });
  const until = state.grow ? state.time : Infinity;
  keyframes.children.forEach(k => { k.visible = k.userData.time <= until + 1e-4; });
  edgeKinds.forEach(e => {
    const lines = state.grow ? lastBefore(e.info, until) + 1 : e.info.length;
    e.geometry.setDrawRange(0, 2 * lines);
    e.shown = lines;
  });
  $('slider').value = state.time;
  $('clock').textContent = fixed(state.time, 2) + ' / ' + fixed(data.duration, 2) + ' s';
  if (state.follow) controls.target.copy(robot.position);
  if (state.selected) showDetails(state.selected);
}

function togglePlay() {
  if (!state.playing && state.time >= data.duration - 1e-6) showTime(0);
  state.playing = !state.playing;
  $('play').innerHTML = state.playing ? '&#10074;&#10074;' : '&#9654;';
}

// ---- Camera ----------------------------------------------------------------------------------

const view = data.view;
function lookFrom(azimuth, elevation, distance) {
  const c = new THREE.Vector3(view.center[0], view.center[1], view.center[2]);
  camera.position.set(c.x + distance * Math.cos(elevation) * Math.cos(azimuth),
                      c.y + distance * Math.cos(elevation) * Math.sin(azimuth),
                      c.z + distance * Math.sin(elevation));
  controls.target.copy(c);
  controls.update();
}
function narrow() { return Math.max(1, 1.25 / camera.aspect); }
function home() { setFollow(false); lookFrom(view.yaw - 1.1, 0.9, 2.1 * view.radius * narrow()); }
function above() { setFollow(false); lookFrom(view.yaw - Math.PI / 2, Math.PI / 2 - 1e-3, 2.2 * view.radius * narrow()); }
function setFollow(on) {
  state.follow = on;
  $('follow').classList.toggle('on', on);
  if (!on || !frames.length) return;
  const back = new THREE.Vector3(-5, 0, 4).applyQuaternion(robot.quaternion);
  camera.position.copy(robot.position).add(back);
  controls.target.copy(robot.position);
}

function resize() {
  const width = window.innerWidth, height = window.innerHeight;
  renderer.setSize(width, height, false);
  camera.aspect = width / height;
  camera.updateProjectionMatrix();
}

// ---- Panels ----------------------------------------------------------------------------------

function element(tag, className, text) {
  const e = document.createElement(tag);
  if (className) e.className = className;
  if (text !== undefined) e.textContent = text;
  return e;
}

function listLayers() {
  const list = $('layer-list');
  ['Map', 'Robot', 'Graph', 'Edges'].forEach(group => {
    const members = layers.filter(l => l.group === group);
    if (!members.length) return;
    list.appendChild(element('div', 'group', group));
    members.forEach(layer => {
      const label = element('label'), box = element('input'), swatch = element('span', 'swatch');
      box.type = 'checkbox';
      box.checked = layer.visible;
      box.dataset.layer = layer.name;
      box.addEventListener('change', () => {
        layer.visible = layer.object.visible = box.checked;
      });
      if (layer.line) swatch.classList.add('line');
      swatch.style.background = layer.swatch;
      label.append(box, swatch, layer.name);
      if (layer.count !== undefined) label.append(element('span', 'count', String(layer.count)));
      list.appendChild(label);
    });
  });
  const label = element('label'), box = element('input');
  box.type = 'checkbox';
  box.checked = true;
  box.addEventListener('change', () => { $('labels').style.display = box.checked ? '' : 'none'; });
  label.append(box, element('span', 'swatch'), 'Labels');
  list.appendChild(label);
}

function showDetails(e) {
  const i = lastBefore(e.track, state.time), row = e.track[Math.max(0, i)];
  const p = e.node.position;
  const lines = [e.title + ' (' + e.class + ', id ' + e.id + ')',
    'position ' + fixed(p.x) + ' ' + fixed(p.y) + ' ' + fixed(p.z) + ' m',
    'observations ' + e.track.length,
    i < 0 ? 'not seen yet' : 'last seen ' + fixed(row[0]) + ' s (' + fixed(state.time - row[0], 1) + ' s ago)'];
  if (row[8] >= 0) lines.push('sigma ' + fixed(1000 * row[8], 1) + ' mm');
  e.moves.forEach(m => lines.push('moved ' + fixed(m.distance) + ' m between ' + fixed(m.before, 1) +
                                  ' and ' + fixed(m.after, 1) + ' s'));
  $('details').textContent = lines.join('\n');
  $('details').hidden = false;
}

function select(e) {
  if (state.selected && state.selected.row) state.selected.row.classList.remove('on');
  state.selected = e;
  e.row.classList.add('on');
  setFollow(false);
  const offset = camera.position.clone().sub(controls.target);
  const target = e.node.position.clone();
  target.z += state.spread * kLevel.entity;
  controls.target.copy(target);
  camera.position.copy(target).add(offset.setLength(Math.min(offset.length(), 8)));
  showDetails(e);
}

function listEntities() {
  const list = $('entity-list');
  entities.forEach(e => {
    e.row = element('div');
    const swatch = element('span', 'swatch');
    swatch.style.background = cssColor(e.color);
    e.row.append(swatch, element('span', '', e.title));
    if (e.moves.length) e.row.append(element('span', 'moved', 'moved ' + fixed(e.moves.reduce((s, m) => s + m.distance, 0), 1) + ' m'));
    e.row.addEventListener('click', () => select(e));
    list.appendChild(e.row);
    e.label = element('span', '', e.title);
    e.label.style.borderColor = cssColor(e.color);
    $('labels').appendChild(e.label);
  });
  $('counts').textContent = frames.length + ' frames, ' + data.keyframes.length + ' keyframes, ' +
      entities.length + ' entities, ' + data.edge_count + ' edges';
}

/** When objects were moved, over the slider. */
function listMarks() {
  entities.forEach(e => e.moves.forEach(m => {
    const mark = element('i');
    mark.style.left = 100 * m.before / data.duration + '%';
    mark.style.width = 100 * Math.max(0, m.after - m.before) / data.duration + '%';
    mark.style.background = cssColor(e.color);
    mark.title = e.title + ' moved between ' + fixed(m.before, 1) + ' and ' + fixed(m.after, 1) + ' s';
    $('marks').appendChild(mark);
  }));
}

const corner = new THREE.Vector3();
function placeLabels() {
  if ($('labels').style.display === 'none') return;
  const width = window.innerWidth, height = window.innerHeight;
  entities.forEach(e => {
    corner.copy(e.node.position);
    corner.z += e.max[2] + 0.15 + state.spread * kLevel.entity;
    corner.project(camera);
    const inside = corner.z < 1 && Math.abs(corner.x) < 1.1 && Math.abs(corner.y) < 1.1;
    const shown = inside && e.node.visible && boxes.visible && e.presence > 0.2;
    e.label.style.display = shown ? '' : 'none';
    if (!shown) return;
    e.label.style.opacity = e.presence;
    e.label.style.transform = 'translate(-50%, -100%) translate(' +
        (0.5 + 0.5 * corner.x) * width + 'px,' + (0.5 - 0.5 * corner.y) * height + 'px)';
  });
}

// ---- What is under the pointer ----------------------------------------------------------------

const raycaster = new THREE.Raycaster();
let pointer = null;

function edgeText(edge, line) {
  const [time, id, squared, residuals] = edge.info[line];
  return edge.kind.kind.replace(/_/g, ' ') + ', edge ' + id + '\nat ' + fixed(time) + ' s' +
      '\nresidual ' + fixed(Math.sqrt(squared), 2) + ' (squared Mahalanobis ' + fixed(squared, 2) +
      ' of ' + residuals + ')';
}

function textAt(x, y) {
  raycaster.setFromCamera({ x: 2 * x / window.innerWidth - 1, y: 1 - 2 * y / window.innerHeight }, camera);
  raycaster.linePrecision = 0.006 * camera.position.distanceTo(controls.target);
  const solid = [boxes, keyframes, ghosts, tracks, planes].filter(g => g.visible);
  for (const hit of raycaster.intersectObjects(solid, true)) {
    const user = hit.object.userData;
    if (hit.object.parent && !hit.object.parent.visible) continue;
    if (user.entity && user.entity.node.visible) {
      const e = user.entity;
      return { text: e.title + ' (' + e.class + ')\n' + e.track.length + ' observations', entity: e };
    }
    if (user.text) return { text: user.text };
  }
  for (const hit of raycaster.intersectObjects(edgeKinds.map(e => e.object).filter(o => o.visible))) {
    const edge = hit.object.userData.edges, line = hit.index >> 1;
    if (line < edge.shown) return { text: edgeText(edge, line) };
  }
  return null;
}

function showTip() {
  if (!pointer) return;
  const found = textAt(pointer.x, pointer.y);
  $('tip').hidden = !found;
  renderer.domElement.style.cursor = found && found.entity ? 'pointer' : '';
  if (found) {
    $('tip').textContent = found.text;
    $('tip').style.left = Math.min(pointer.x + 14, window.innerWidth - 330) + 'px';
    $('tip').style.top = Math.max(8, Math.min(pointer.y + 14, window.innerHeight - 110)) + 'px';
  }
  pointer = null;
}

// ---- Events ----------------------------------------------------------------------------------

function setDark(on) {
  document.documentElement.classList.toggle('dark', on);
  $('dark').classList.toggle('on', on);
  scene.background = new THREE.Color(on ? 0x14171c : 0xf6f7f9);
}

$('slider').max = data.duration || 1;
$('slider').addEventListener('input', () => showTime(Number($('slider').value)));
$('play').addEventListener('click', togglePlay);
$('spread').addEventListener('input', () => {
  state.spread = Number($('spread').value);
  spreadLayers();
  showTime(state.time);
});
$('point-size').addEventListener('input', () => {
  const size = Number($('point-size').value);
  structure.material.size = size;
  entities.forEach(e => { if (e.cloud.material) e.cloud.material.size = size + 1; });
});
$('by-residual').addEventListener('change', () => {
  state.byResidual = $('by-residual').checked;
  $('residual-scale').hidden = !state.byResidual;
  paintEdges();
});
$('grow').addEventListener('change', () => { state.grow = $('grow').checked; showTime(state.time); });
$('home').addEventListener('click', home);
$('above').addEventListener('click', above);
$('follow').addEventListener('click', () => setFollow(!state.follow));
$('dark').addEventListener('click', () => setDark(!document.documentElement.classList.contains('dark')));
window.addEventListener('resize', resize);
renderer.domElement.addEventListener('mousemove', e => { pointer = { x: e.clientX, y: e.clientY }; });
renderer.domElement.addEventListener('mouseleave', () => { $('tip').hidden = true; });
renderer.domElement.addEventListener('dblclick', e => {
  const found = textAt(e.clientX, e.clientY);
  if (found && found.entity) select(found.entity);
});
window.addEventListener('keydown', e => {
  const keys = { ' ': togglePlay, h: home, t: above, f: () => setFollow(!state.follow),
                 d: () => $('dark').click(),
                 ArrowRight: () => showTime(state.time + 0.2), ArrowLeft: () => showTime(state.time - 0.2) };
  if (e.target.tagName === 'SELECT' || !keys[e.key]) return;
  keys[e.key]();
  e.preventDefault();
});

let last = performance.now();
function tick(now) {
  const elapsed = Math.min(0.1, (now - last) / 1000);
  last = now;
  if (state.playing) {
    showTime(state.time + elapsed * Number($('speed').value));
    if (state.time >= data.duration) togglePlay();
  }
  controls.update();
  showTip();
  renderer.render(scene, camera);
  placeLabels();
  requestAnimationFrame(tick);
}

listLayers();
listEntities();
listMarks();
setDark(false);
resize();
home();
paintEdges();
spreadLayers();
showTime(data.duration);

/** For tests and for the console. */
window.dynemo = {
  errors: state.errors,
  setTime: showTime,
  time: () => state.time,
  duration: data.duration,
  entity: id => {
    const e = entities.find(x => x.id === id);
    return e && { position: e.node.position.toArray(), visible: e.node.visible, title: e.title, class: e.class };
  },
  entities: () => entities.map(e => e.id),
  layer: name => {
    const l = layers.find(x => x.name === name);
    return l && { swatch: l.swatch, colors: colorsOf(l.object).map(cssColor) };
  },
  robot: () => [body, nose].map(part => cssColor(part.material.color.getHex())),
  textAt
};
requestAnimationFrame(tick);

})();
