// 3D view of the report's page: the installed three.js, and a script that decodes the data of motion.cpp and
// shows it.
#include <filesystem>

#include <fmt/format.h>

#include "turgor/io/files/file.hpp"
#include "turgor/io/files/shipped_file.hpp"
#include "turgor/pictures/motion.hpp"

namespace turgor {

namespace {

std::filesystem::path three_js() {
  return shipped_file("three.min.js", {"/usr/share/javascript/three/three.min.js"});
}
std::filesystem::path orbit_controls() {
  return shipped_file("OrbitControls.js",
                      {"/usr/share/javascript/three/examples/js/controls/OrbitControls.js"});
}

constexpr const char* kCanvas = R"(<h2>3D view</h2>
<style>
#motion { margin-bottom: 1.6rem; background: var(--card); border: 1px solid var(--line); border-radius: 10px; overflow: hidden; }
#motion canvas { display: block; width: 100%; height: min(62vh, 620px); background: #14181d; touch-action: none; cursor: grab; }
#motion canvas:active { cursor: grabbing; }
#motion .bar { display: flex; flex-wrap: wrap; gap: 0.5rem 0.9rem; align-items: center; padding: 0.6rem 0.9rem; font-size: 0.9rem; }
#motion .bar input[type=range] { flex: 1 1 160px; accent-color: var(--accent); }
#motion button, #motion select { font: inherit; color: inherit; background: var(--ground); border: 1px solid var(--line); border-radius: 6px; padding: 0.15rem 0.7rem; }
#motion output { min-width: 5.5em; font-variant-numeric: tabular-nums; }
#motion .legend { display: none; align-items: center; gap: 0.4rem; } #motion .legend canvas { width: 120px; height: 12px; border-radius: 3px; }
</style>
<div id="motion"><canvas id="motion-view" tabindex="0" aria-label="the bodies in 3D: drag to orbit, wheel to zoom"></canvas>
<div class="bar"><button id="motion-play" type="button">play</button><input id="motion-time" type="range" min="0" value="0" step="1" aria-label="time">
<output id="motion-now"></output><select id="motion-color" aria-label="colors"><option value="look">natural</option><option value="displacement">displacement</option></select>
<span class="legend" id="motion-legend">0 <canvas id="motion-bar" width="256" height="1"></canvas> <span id="motion-most"></span></span>
<button id="motion-home" type="button">whole</button><span class="soft" id="motion-said">drag to orbit, right button to pan, wheel to zoom</span></div></div>
)";

constexpr const char* kScript = R"js(
(async () => {
  const at = (id) => document.getElementById('motion-' + id);
  const canvas = at('view'), slider = at('time'), say = (text) => { at('said').textContent = text; };
  if (!window.THREE || !window.DecompressionStream) return say('this browser is too old for the 3D view; the pictures below show the run');
  let renderer;
  try { renderer = new THREE.WebGLRenderer({canvas, antialias: true, preserveDrawingBuffer: true}); }
  catch (error) { return say('this browser does not support WebGL; the pictures below show the run'); }

  const bytesOf = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const unpack = async (text, bytes) => {  // integers stored as all lowest bytes, then all second bytes
    const stream = new Blob([bytesOf(text)]).stream().pipeThrough(new DecompressionStream('deflate'));
    const raw = new Uint8Array(await new Response(stream).arrayBuffer()), count = raw.length / bytes, numbers = new Int32Array(count);
    for (let b = 0; b < bytes; b++) for (let i = 0; i < count; i++) numbers[i] |= raw[b * count + i] << (8 * b);
    if (bytes === 2) for (let i = 0; i < count; i++) numbers[i] = numbers[i] << 16 >> 16;
    return numbers;
  };
  const summed = (numbers, mask) => { for (let i = 1; i < numbers.length; i++) numbers[i] = (numbers[i] + numbers[i - 1]) & mask; return numbers; };
  const map = bytesOf(motion.map), looks = {flesh: 0x9e4438, skin: 0xe0ac91, cloth: 0x5c86b0, tool: 0xb0becc, obstacle: 0xbcb4a8, inside: 0xecd696, wall: 0xa63a32};

  renderer.setClearColor(0x252c34);
  const scene = new THREE.Scene(), camera = new THREE.PerspectiveCamera(32, 1, 0.001, 50);
  camera.up.set(0, 0, 1);
  scene.add(new THREE.HemisphereLight(0xe8eef6, 0x6a5a50, 0.75));
  const key = new THREE.DirectionalLight(0xffffff, 0.65);
  camera.add(key), key.position.set(0.6, 0.9, 1), scene.add(camera);
  const controls = new THREE.OrbitControls(camera, canvas);
  const whole = new THREE.Box3();

  for (const thing of motion.things) {
    const kind = thing.kind === 'body' ? thing.look : thing.kind, color = new THREE.Color(looks[kind]);
    thing.shapes = [];
    for (const surface of thing.surfaces) {
      if (!surface) { thing.shapes.push(null); continue; }
      const positions = await unpack(surface.positions, 2), count = surface.vertices, rest = new Float32Array(3 * count);
      summed(positions, 0xffff);
      for (let axis = 0; axis < 3; axis++)
        for (let v = 0; v < count; v++) rest[3 * v + axis] = surface.low[axis] + positions[axis * count + v] / 65535 * surface.size;
      const triangles = summed(await unpack(surface.triangles, 4), -1), geometry = new THREE.BufferGeometry();
      geometry.setAttribute('position', new THREE.BufferAttribute(rest.slice(), 3));
      geometry.setAttribute('color', new THREE.BufferAttribute(new Float32Array(3 * count).fill(1), 3));
      geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(triangles), 1));
      geometry.addGroup(0, 3 * surface.wall_begin, 0);
      geometry.addGroup(3 * surface.wall_begin, triangles.length - 3 * surface.wall_begin, 1);
      const side = THREE.DoubleSide, shape = {rest, geometry};
      shape.layers = surface.colors ? await unpack(surface.colors, 1) : null;  // of vertices, white on skin
      shape.firstOfWalls = triangles[3 * surface.wall_begin];  // vertices are numbered in the order of triangles
      shape.materials = [color, new THREE.Color(shape.layers ? 0xffffff : looks.wall)].map((c) =>
        new THREE.MeshStandardMaterial({color: c, roughness: 0.55, metalness: thing.kind === 'tool' ? 0.3 : 0, side, vertexColors: THREE.VertexColors}));
      if (thing.kind === 'inside')  // visible through the body
        for (const material of shape.materials) material.transparent = true, material.opacity = 0.5, material.depthTest = false, material.side = THREE.FrontSide;
      shape.mesh = new THREE.Mesh(geometry, shape.materials), shape.mesh.visible = false, shape.color = color, shape.mesh.frustumCulled = false;
      scene.add(shape.mesh), thing.shapes.push(shape);
      if (thing.kind === 'body') for (let v = 0; v < rest.length; v += 3) whole.expandByPoint(new THREE.Vector3(rest[v], rest[v + 1], rest[v + 2]));
    }
  }
  for (const [f, frame] of motion.frames.entries())
    for (const [t, thing] of frame.things.entries()) {
      const change = await unpack(thing[1], 2), before = f > 0 && motion.frames[f - 1].things[t][0] === thing[0] ? motion.frames[f - 1].things[t].moved : null;
      if (before) for (let i = 0; i < change.length; i++) change[i] += before[i];
      thing.moved = change;
    }

  const size = whole.getSize(new THREE.Vector3()).length() || 0.1, middle = whole.getCenter(new THREE.Vector3());
  const arrows = (motion.frames[0].forces_N || []).map(() => {
    const arrow = new THREE.Group(), material = new THREE.MeshBasicMaterial({color: 0xfacc46, depthTest: false});  // also visible inside the body
    const shaft = new THREE.CylinderBufferGeometry(0.02, 0.02, 0.8, 16).translate(0, 0.4, 0), head = new THREE.CylinderBufferGeometry(0, 0.06, 0.22, 24).translate(0, 0.89, 0);
    for (const mesh of [shaft, head].map((geometry) => new THREE.Mesh(geometry, material))) mesh.renderOrder = 1, arrow.add(mesh);
    return scene.add(arrow), arrow;
  });
  const usual = Math.max(...motion.things.map((thing) => thing.kind === 'body' ? thing.usual_force_N : 0), 1e-9);
  const most = Math.max(...motion.things.map((thing) => thing.kind === 'body' ? thing.largest_m : 0), 1e-9);
  at('most').textContent = (1000 * most).toPrecision(3) + ' mm';
  const bar = at('bar').getContext('2d'), row = bar.createImageData(256, 1);
  for (let i = 0; i < 256; i++) row.data.set([map[3 * i], map[3 * i + 1], map[3 * i + 2], 255], 4 * i);
  bar.putImageData(row, 0, 0);

  const paint = (shape, moved, quantum, colored) => {
    const count = moved.length / 3, position = shape.geometry.attributes.position, tint = shape.geometry.attributes.color;
    for (let v = 0; v < count; v++) {
      const x = moved[v] * quantum, y = moved[count + v] * quantum, z = moved[2 * count + v] * quantum;
      position.array[3 * v] = shape.rest[3 * v] + x, position.array[3 * v + 1] = shape.rest[3 * v + 1] + y, position.array[3 * v + 2] = shape.rest[3 * v + 2] + z;
      const c = colored ? 3 * Math.min(255, Math.round(255 * Math.hypot(x, y, z) / most)) : -1;
      const isWall = shape.layers && v >= shape.firstOfWalls;
      for (let k = 0; k < 3; k++) tint.array[3 * v + k] = isWall ? shape.layers[3 * v + k] / 255 : c < 0 ? 1 : Math.pow(map[c + k] / 255, 1.6);
    }
    shape.materials[0].color.set(colored ? 0xffffff : shape.color);
    position.needsUpdate = tint.needsUpdate = true, shape.geometry.computeVertexNormals();
  };
  let shown = 0, stale = true;
  const show = (f) => {
    const frame = motion.frames[shown = f], colored = at('color').value === 'displacement';
    motion.things.forEach((thing, t) => {
      const [surface] = frame.things[t];
      thing.shapes.forEach((shape, s) => { if (shape) shape.mesh.visible = s === surface && !(colored && thing.kind === 'inside'); });
      paint(thing.shapes[surface], frame.things[t].moved, thing.quantum, colored && thing.kind === 'body');
    });
    frame.forces_N.forEach(([position, force], n) => {
      const f3 = new THREE.Vector3(...force), newtons = f3.length(), arrow = arrows[n], length = size / 5 * Math.min(3, Math.max(0.25, newtons / usual));
      arrow.visible = newtons > 1e-3 * usual;
      if (arrow.visible) arrow.position.set(...position), arrow.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), f3.normalize()), arrow.scale.setScalar(length);
    });
    const measured = frame.forces_N.map(([, force]) => Math.hypot(...force)).filter((n) => n > 0).map((n) => n.toPrecision(3) + ' N').join(', ');
    at('now').textContent = frame.time_s.toFixed(2) + ' s' + (measured ? '  ' + measured : '');
    at('legend').style.display = colored ? 'flex' : 'none', slider.value = f, stale = true;
  };
  const pressed = motion.frames.map((frame) => Math.max(0, ...frame.forces_N.map(([, force]) => Math.hypot(...force))));
  const hardest = pressed.indexOf(Math.max(...pressed)), touch = pressed[hardest] > 0;
  const start = touch ? hardest : motion.frames.length - 1, visible = whole.clone();  // bodies at rest and in the start frame, and tools
  motion.things.forEach((thing, t) => {
    const now = motion.frames[start].things[t], {rest} = thing.shapes[now[0]], count = rest.length / 3;
    if (thing.kind === 'body' || thing.kind === 'tool')
      for (let v = 0; v < count; v++) visible.expandByPoint(new THREE.Vector3(...[0, 1, 2].map((axis) => rest[3 * v + axis] + now.moved[axis * count + v] * thing.quantum)));
  });
  const around = visible.getCenter(new THREE.Vector3()), extent = visible.getSize(new THREE.Vector3()).length() || 0.1;
  const outward = () => {  // direction of the tool, or the front
    if (!touch) return new THREE.Vector3(0, -1, 0);
    const forces = motion.frames[hardest].forces_N, [position] = forces.reduce((a, b) => Math.hypot(...a[1]) > Math.hypot(...b[1]) ? a : b);
    return new THREE.Vector3(...position).sub(middle).normalize();
  };
  const home = () => {
    const out = outward(), side = new THREE.Vector3(0, 0, 1).cross(out);
    if (side.length() < 0.5) side.set(0.3, -1, 0);  // seen from head or feet, turned towards the front
    const from = out.add(side.normalize().multiplyScalar(0.7)).add(new THREE.Vector3(0, 0, 0.35)).normalize();
    controls.target.copy(around), camera.position.copy(around).add(from.multiplyScalar(1.5 * extent));
    camera.near = extent / 200, camera.far = 20 * extent, camera.updateProjectionMatrix(), controls.update(), stale = true;
  };
  const fit = () => {
    renderer.setPixelRatio(Math.min(2, window.devicePixelRatio)), renderer.setSize(canvas.clientWidth, canvas.clientHeight, false);
    camera.aspect = canvas.clientWidth / Math.max(1, canvas.clientHeight), camera.updateProjectionMatrix(), stale = true;
  };
  slider.max = motion.frames.length - 1;
  slider.addEventListener('input', () => show(Number(slider.value)));
  at('color').addEventListener('change', () => show(shown));
  at('home').addEventListener('click', home);
  controls.addEventListener('change', () => { stale = true; });
  window.addEventListener('resize', fit);
  let since = null;
  const times = motion.frames.map((frame) => frame.time_s), last = times[times.length - 1];
  at('play').addEventListener('click', () => {
    since = since === null ? performance.now() - 1000 * (times[shown] < last ? times[shown] : 0) : null;
    at('play').textContent = since === null ? 'play' : 'stop';
  });
  const turn = (now) => {
    if (since !== null) {
      const time = (now - since) / 1000;
      let f = times.findIndex((t) => t > time) - 1;
      if (f < -1) f = times.length - 1, since = null, at('play').textContent = 'play';
      if (Math.max(0, f) !== shown) show(Math.max(0, f));
    }
    if (stale) stale = false, renderer.render(scene, camera);
    requestAnimationFrame(turn);
  };
  fit(), home(), show(start), requestAnimationFrame(turn);
  canvas.dataset.ready = 'yes';
})();
)js";

}  // namespace

bool has_motion_view() { return !three_js().empty() && !orbit_controls().empty(); }

std::string motion_html(const std::string& json) {
  if (json.empty()) return {};
  const Result<std::string> three = read_file(three_js()), controls = read_file(orbit_controls());
  if (!three || !controls) return {};
  return std::string(kCanvas) + "<script>" + *three + "</script>\n<script>" + *controls +
         "</script>\n<script>const motion = " + json + ";\n" + kScript + "</script>\n";
}

}  // namespace turgor
