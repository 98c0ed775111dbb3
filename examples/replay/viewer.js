// Shows a recording: the scene, its time, its numbers, and what is picked.
// SPDX-License-Identifier: BSD-3-Clause
import * as THREE from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { keyOf } from './colours.js';
import { Glb } from './glb.js';
import { Plots } from './plots.js';
import { TactileImage } from './tactile.js';
import { ContactView, PatchView, jointLine, manySensors } from './things.js';
import { Tracks, stateNames } from './tracks.js';

const element = (id) => document.getElementById(id);

function fail(error) {
  element('error').textContent = `The recording cannot be read: ${error.message ?? error}`;
  element('error').hidden = false;
}

/** The bytes of the .glb that stands in the page. */
async function recordedBytes() {
  let text;
  try {
    text = atob(element('recording').textContent.trim());
  } catch {
    throw new Error('its text is damaged, or the page is cut short');
  }
  const packed = Uint8Array.from(text, (c) => c.charCodeAt(0));
  try {
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('gzip'));
    return await new Response(stream).arrayBuffer();
  } catch {
    throw new Error('it ends too early, or is damaged');
  }
}

/** The arrows that other viewers show; the page draws its own. */
const isArrow = (node) => node.extras?.newton_per_metre !== undefined;

/** The sphere around the bodies that move, at 21 of their times. */
function sizeOf(root, moveTo, duration) {
  const box = new THREE.Box3();
  const moving = [];
  root.traverse((node) => {
    if (node.isMesh && node.material.transparent) moving.push(node);
  });
  for (let i = 0; i <= 20; ++i) {
    moveTo((duration * i) / 20);
    root.updateMatrixWorld(true);
    for (const node of moving) box.expandByObject(node);
  }
  if (box.isEmpty()) box.setFromObject(root);
  return box.getBoundingSphere(new THREE.Sphere());
}

const millimetres = (vector) => `(${vector.toArray().map((x) => (1000 * x).toFixed(2)).join(', ')}) mm`;

class Page {
  #time = 0;
  #frame = -1;
  #isPlaying = false;
  #last = 0;
  #picked = null;
  #isStale = true;

  constructor(gltf, tracks, nodes) {
    this.gltf = gltf;
    this.tracks = tracks;
    this.nodes = nodes;
    // The last node of the file is the simulation's world, whose z is up.
    this.world = nodes[nodes.length - 1];
    const [clip] = gltf.animations;
    this.mixer = clip ? new THREE.AnimationMixer(gltf.scene) : null;
    this.action = this.mixer?.clipAction(clip).play();
    const { times } = tracks;
    this.duration = times.length > 0 ? times[times.length - 1] : (clip?.duration ?? 0);
    this.#makeScene();
    this.#addTracks();
    this.#listen();
    this.setTime(0);
    requestAnimationFrame((now) => this.#draw(now));
  }

  #makeScene() {
    const { gltf } = this;
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color(0xf4f5f7);
    this.scene.add(gltf.scene);
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x8d8d95, 2.2));
    const sun = new THREE.DirectionalLight(0xffffff, 1.6);
    this.scene.add(sun);
    const { center, radius } = sizeOf(gltf.scene, (t) => this.#moveBodies(t), this.duration);
    this.radius = radius;
    this.camera = new THREE.PerspectiveCamera(35, 1, radius / 100, radius * 100);
    // From as far as the sphere fills the height of the picture: nothing that moves is cut off.
    const away = radius / Math.sin(THREE.MathUtils.degToRad(this.camera.fov / 2));
    this.camera.position.copy(center).addScaledVector(new THREE.Vector3(0.45, 0.35, 1).normalize(), away);
    sun.position.copy(center).addScaledVector(new THREE.Vector3(0.3, 1, 0.6), 10 * radius);
    const canvas = element('canvas');
    // Smooth edges cost a renderer without a graphics card as much as all else.
    const antialias = this.tracks.patches.every(({ count }) => count <= manySensors);
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias, preserveDrawingBuffer: true });
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.target.copy(center);
    this.controls.update();
  }

  #addTracks() {
    const { tracks, nodes, radius } = this;
    this.patches = tracks.patches.map((track) => new PatchView(track, nodes[track.node], radius / 40));
    this.contacts = new ContactView(tracks.contacts, this.world);
    const axis = radius / (tracks.joints.length > 16 ? 32 : 8);
    this.joints = tracks.joints.map((joint) => jointLine(nodes[joint.node], axis, { joint }));
    const scaleOf = (largest) => (largest > 0 ? (0.22 * radius) / largest : 0);
    this.sensorScale = scaleOf(Math.max(0, ...tracks.patches.map(({ largest }) => largest)));
    this.contactScale = scaleOf(this.contacts.largest());
    element('key').innerHTML = keyOf({
      hasSensors: this.patches.length > 0,
      hasJoints: this.joints.length > 0,
      sensorScale: Number((1000 * this.sensorScale).toPrecision(3)),
      contactScale: Number((1000 * this.contactScale).toPrecision(3)),
    });
    this.plots = new Plots(tracks.curves(), tracks.times, {
      plots: element('plots'),
      list: element('curves'),
      onTime: (t) => {
        this.setPlaying(false);
        this.setTime(t);
      },
    });
    this.images = this.patches.map((view) => new TactileImage(view, element('images'), (patch, sensor) => this.#pick({ patch, sensor })));
    element('tactile').hidden = this.images.length === 0;
    element('numbers').hidden = this.plots.curves.length === 0 && this.images.length === 0;
  }

  #listen() {
    const time = element('time');
    time.max = String(this.duration);
    time.addEventListener('input', () => {
      this.setPlaying(false);
      this.setTime(Number(time.value));
    });
    element('play').addEventListener('click', () => this.setPlaying(!this.#isPlaying));
    element('channel').addEventListener('change', () => this.#redraw());
    for (const id of ['sensors', 'forces', 'contacts', 'joints']) element(`show-${id}`).addEventListener('change', () => this.#redraw());
    this.controls.addEventListener('change', () => (this.#isStale = true));
    const canvas = element('canvas');
    const pressed = new THREE.Vector2();
    canvas.addEventListener('pointerdown', (event) => pressed.set(event.offsetX, event.offsetY));
    canvas.addEventListener('click', (event) => {
      // A click ends a turn of the camera, too.
      if (pressed.distanceTo(new THREE.Vector2(event.offsetX, event.offsetY)) > 4) return;
      this.#pick(this.#thingAt(event.offsetX / canvas.clientWidth, event.offsetY / canvas.clientHeight));
    });
  }

  /** Moves the bodies to a time; the mixer's own clock stands still. */
  #moveBodies(t) {
    if (!this.action) return;
    this.action.paused = true;
    this.action.time = Math.min(t, this.action.getClip().duration);
    this.mixer.update(0);
  }

  /** What is drawn at a place of the canvas, from 0 to 1 across and down. */
  #thingAt(x, y) {
    const ray = new THREE.Raycaster();
    ray.params.Line.threshold = this.radius / 100;
    ray.setFromCamera(new THREE.Vector2(2 * x - 1, 1 - 2 * y), this.camera);
    const hits = ray.intersectObject(this.gltf.scene, true).filter(({ object }) => object.visible);
    // Sensors, contacts and joints lie in bodies that are seen through: they come first.
    const hit = hits.find(({ object }) => Object.keys(object.userData).some((key) => ['view', 'contacts', 'joint'].includes(key))) ?? hits[0];
    if (!hit) return null;
    const { view, contacts, joint } = hit.object.userData;
    if (view) return { patch: view, sensor: view.sensorAt(hit) };
    if (contacts) return { contact: contacts.arrows.ownerAt(hit.faceIndex), frame: this.#frame };
    if (joint) return { joint };
    const named = hit.object.name ? hit.object : hit.object.parent;
    return { body: named };
  }
  #pick(thing) {
    this.#picked = thing;
    this.#isStale = true;
  }
  /** Back from glTF's axes into those of the simulation. */
  #inWorld(point) {
    return this.world.worldToLocal(point);
  }
  #describe() {
    const thing = this.#picked;
    if (!thing) return '';
    if (thing.body) {
      const { body } = thing;
      return `${body.userData.name ?? body.name}: ${millimetres(this.#inWorld(body.getWorldPosition(new THREE.Vector3())))}`;
    }
    if (thing.joint) {
      const { name, kind, positions, motorForces } = thing.joint;
      if (positions.length === 0) return `${name}`;
      const [x, f] = [positions[this.#frame], motorForces[this.#frame]];
      return kind === 'turns' ? `${name}: ${x.toFixed(4)} rad, motor ${f.toFixed(4)} N m` : `${name}: ${(1000 * x).toFixed(3)} mm, motor ${f.toFixed(4)} N`;
    }
    if (thing.contact !== undefined) {
      if (thing.frame !== this.#frame) return '';
      const { points, forces, nodes } = this.tracks.contacts;
      const at = (numbers) => new THREE.Vector3().fromArray(numbers, 3 * thing.contact);
      const body = this.nodes[nodes[thing.contact]];
      return `contact on ${body.userData.name ?? body.name}: ${millimetres(at(points))}, ${at(forces).length().toFixed(4)} N`;
    }
    return this.#describeSensor(thing.patch, thing.sensor);
  }
  #describeSensor({ track, body }, i) {
    const point = this.#inWorld(body.localToWorld(new THREE.Vector3().fromArray(track.ends, 3 * i)));
    const sum = new THREE.Vector3();
    const states = [0, 0, 0];
    for (let k = 0; k < track.count; ++k) {
      ++states[track.state(k)];
      sum.add(new THREE.Vector3().fromArray(track.forceVector(k)));
    }
    const sensor = `${track.name} ${i}: ${millimetres(point)}, depth ${track.depth(i).toFixed(3)}, ${stateNames[track.state(i)]}, ${track.force(i).toFixed(4)} N`;
    const patch = `${track.name}: ${track.count} sensors, ${states[1] + states[2]} touching, ${states[2]} slipping, ${sum.length().toFixed(4)} N`;
    return `${sensor}\n${patch}`;
  }

  setTime(t) {
    this.#time = Math.min(Math.max(t, 0), this.duration);
    this.#moveBodies(this.#time);
    const { tracks } = this;
    const frame = tracks.times.length > 0 ? tracks.frameAt(this.#time) : 0;
    if (frame !== this.#frame) {
      this.#frame = frame;
      this.#redraw();
    }
    this.plots.moveTo(this.#time, frame);
    element('time').value = String(this.#time);
    element('clock').textContent = `${this.#time.toFixed(3)} s`;
    this.#isStale = true;
  }
  /** Brings what has frames to the one that is shown. */
  #redraw() {
    const isShown = (id) => element(`show-${id}`).checked;
    for (const view of this.patches) {
      view.update(this.#frame, this.sensorScale);
      view.dots.mesh.visible = isShown('sensors');
      view.arrows.mesh.visible = isShown('forces');
    }
    this.contacts.update(this.#frame, this.contactScale);
    this.contacts.arrows.mesh.visible = isShown('contacts');
    for (const line of this.joints) line.visible = isShown('joints');
    for (const image of this.images) image.draw(element('channel').value);
    this.#isStale = true;
  }
  setPlaying(value) {
    this.#isPlaying = value && this.duration > 0;
    if (this.#isPlaying && this.#time >= this.duration) this.setTime(0);
    element('play').textContent = this.#isPlaying ? 'Pause' : 'Play';
  }

  #draw(now) {
    const passed = Math.min((now - this.#last) / 1000, 0.1);
    this.#last = now;
    if (this.#isPlaying) {
      this.setTime(this.#time + passed * Number(element('speed').value));
      if (this.#time >= this.duration) this.setPlaying(false);
    }
    const canvas = element('canvas');
    const { clientWidth: width, clientHeight: height } = canvas;
    const ratio = window.devicePixelRatio;
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      this.renderer.setPixelRatio(ratio);
      this.renderer.setSize(width, height, false);
      this.camera.aspect = width / Math.max(height, 1);
      this.camera.updateProjectionMatrix();
      this.#isStale = true;
    }
    if (this.#isStale) {
      this.#isStale = false;
      element('picked').textContent = this.#describe();
      this.renderer.render(this.scene, this.camera);
    }
    requestAnimationFrame((next) => this.#draw(next));
  }
}

try {
  const glb = new Glb(await recordedBytes());
  const tracks = new Tracks(glb);
  const gltf = await new GLTFLoader().parseAsync(glb.without(isArrow), '');
  const nodes = await Promise.all(glb.json.nodes.map((node, i) => (isArrow(node) ? null : gltf.parser.getDependency('node', i))));
  new Page(gltf, tracks, nodes);
  document.body.dataset.ready = 'yes';
} catch (error) {
  fail(error);
}
