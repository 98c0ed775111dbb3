// Shows a recording: the scene, its time, and what is picked.
// SPDX-License-Identifier: BSD-3-Clause
import * as THREE from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

const element = (id) => document.getElementById(id);

function fail(message) {
  element('error').textContent = message;
  element('error').hidden = false;
}

/** The bytes of the .glb that stands in the page. */
function recordedBytes() {
  const text = atob(element('recording').textContent.trim());
  return Uint8Array.from(text, (c) => c.charCodeAt(0)).buffer;
}

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

function show(gltf) {
  const scene = new THREE.Scene();
  scene.background = new THREE.Color(0xf4f5f7);
  scene.add(gltf.scene);
  scene.add(new THREE.HemisphereLight(0xffffff, 0x8d8d95, 2.2));
  const sun = new THREE.DirectionalLight(0xffffff, 1.6);
  scene.add(sun);

  const clip = gltf.animations[0];
  const mixer = clip ? new THREE.AnimationMixer(gltf.scene) : null;
  const duration = clip ? clip.duration : 0;
  const action = mixer?.clipAction(clip).play();
  /** Moves the scene to a time; the mixer's own clock stands still. */
  function moveTo(t) {
    if (!action) return;
    action.paused = true;
    action.time = t;
    mixer.update(0);
  }

  const { center, radius } = sizeOf(gltf.scene, moveTo, duration);
  const camera = new THREE.PerspectiveCamera(35, 1, radius / 100, radius * 100);
  camera.position.copy(center).addScaledVector(new THREE.Vector3(0.45, 0.35, 1).normalize(), 3.2 * radius);
  sun.position.copy(center).addScaledVector(new THREE.Vector3(0.3, 1, 0.6), 10 * radius);
  const canvas = element('canvas');
  const renderer = new THREE.WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
  const controls = new OrbitControls(camera, canvas);
  controls.target.copy(center);
  controls.update();

  let time = 0;
  let isPlaying = false;
  let last = 0;
  let picked = null;
  let isStale = true;

  function describe() {
    if (!picked) return '';
    const node = picked.isMesh && !picked.name ? picked.parent : picked;
    // Back into the world of the simulation, whose z is up.
    const p = gltf.scene.worldToLocal(node.getWorldPosition(new THREE.Vector3()));
    const world = gltf.scene.children[0];
    world.worldToLocal(gltf.scene.localToWorld(p));
    const length = node.scale.z;
    const newton = node.userData.newton_per_metre;
    const force = newton === undefined ? '' : `, ${(newton * length).toFixed(4)} N`;
    return `${node.userData.name ?? node.name}: (${p.toArray().map((x) => (1000 * x).toFixed(2)).join(', ')}) mm${force}`;
  }

  function setTime(t) {
    time = Math.min(Math.max(t, 0), duration);
    moveTo(time);
    element('time').value = String(time);
    element('clock').textContent = `${time.toFixed(3)} s`;
    isStale = true;
  }
  function setPlaying(value) {
    isPlaying = value && duration > 0;
    if (isPlaying && time >= duration) setTime(0);
    element('play').textContent = isPlaying ? 'Pause' : 'Play';
  }

  function draw(now) {
    const passed = Math.min((now - last) / 1000, 0.1);
    last = now;
    if (isPlaying) {
      setTime(time + passed * Number(element('speed').value));
      if (time >= duration) setPlaying(false);
    }
    const { clientWidth: width, clientHeight: height } = canvas;
    const ratio = window.devicePixelRatio;
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      renderer.setPixelRatio(ratio);
      renderer.setSize(width, height, false);
      camera.aspect = width / Math.max(height, 1);
      camera.updateProjectionMatrix();
      isStale = true;
    }
    if (isStale) {
      isStale = false;
      element('picked').textContent = describe();
      renderer.render(scene, camera);
    }
    requestAnimationFrame(draw);
  }

  element('time').max = String(duration);
  element('time').addEventListener('input', (event) => {
    setPlaying(false);
    setTime(Number(event.target.value));
  });
  element('play').addEventListener('click', () => setPlaying(!isPlaying));
  controls.addEventListener('change', () => (isStale = true));
  const pressed = new THREE.Vector2();
  canvas.addEventListener('pointerdown', (event) => pressed.set(event.offsetX, event.offsetY));
  canvas.addEventListener('click', (event) => {
    // A click ends a turn of the camera, too.
    if (pressed.distanceTo(new THREE.Vector2(event.offsetX, event.offsetY)) > 4) return;
    const at = new THREE.Vector2(
      (2 * event.offsetX) / canvas.clientWidth - 1,
      1 - (2 * event.offsetY) / canvas.clientHeight,
    );
    const ray = new THREE.Raycaster();
    ray.setFromCamera(at, camera);
    // Arrows lie in bodies that are seen through: they come first.
    const hits = ray.intersectObject(gltf.scene, true);
    picked = (hits.find((hit) => hit.object.userData.newton_per_metre !== undefined) ?? hits[0])?.object ?? null;
    isStale = true;
  });
  setTime(0);
  requestAnimationFrame(draw);
  document.body.dataset.ready = 'yes';
}

try {
  new GLTFLoader().parse(recordedBytes(), '', show, (error) => fail(`The recording cannot be read: ${error.message ?? error}`));
} catch (error) {
  fail(`The recording cannot be read: ${error.message}`);
}
