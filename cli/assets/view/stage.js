// The canvas: one camera, one light, and a viewport for each run, drawn when something has changed.

import * as THREE from './three.module.min.js';
import { OrbitControls } from './OrbitControls.js';
import { aim, ground, keyLight, surroundings } from './light.js';
import { Body } from './body.js';

/** Milliseconds for a picture above which shadows and fine pixels are given up. */
const SLOW = 90;

export class Stage {
  bodies = [];
  #canvas;
  #renderer;
  #camera = new THREE.PerspectiveCamera(28, 1, 0.01, 100);
  #controls;
  #light = keyLight();
  #ground = ground();
  /** Nothing is drawn before there is something to look at. */
  #dirty = false;
  #ready = false;
  #opening = 28;
  #height;
  /** When the last picture was begun, if that was the last turn, and how many in a row were slow. */
  #drew = 0;
  #slow = 0;

  constructor(canvas, looks) {
    this.#canvas = canvas;
    this.#renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.#renderer.toneMapping = THREE.ACESFilmicToneMapping;
    this.#renderer.toneMappingExposure = 0.95;
    this.#renderer.shadowMap.enabled = true;
    this.#renderer.shadowMap.autoUpdate = false;
    this.#renderer.setScissorTest(true);
    this.#renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.#controls = new OrbitControls(this.#camera, canvas);
    Object.assign(this.#controls, { enableDamping: true, dampingFactor: 0.12, zoomToCursor: true });
    this.#controls.addEventListener('change', () => this.redraw());
    const around = surroundings(this.#renderer);
    for (let k = 0; k < looks.length; k++) {
      const body = new Body();
      body.scene.environment = around;
      body.scene.environmentIntensity = 0.62;
      this.bodies.push(body);
    }
    this.#height = looks[0].ground;
    new ResizeObserver(() => this.#resize()).observe(canvas.parentElement);
    this.#resize();
    this.#loop();
  }

  /** Asks for a picture; `shadows` too where things have moved. */
  redraw(shadows = false) {
    this.#dirty = this.#ready;
    if (shadows) this.#renderer.shadowMap.needsUpdate = true;
  }

  set ground(shown) {
    this.#ground.visible = shown && this.#height !== null;
    this.redraw();
  }

  /** Looks at what lies between `low` and `high`, from where `given` says or a little from above; gives the lines' step. */
  look(low, high, given) {
    const [a, b] = [new THREE.Vector3(...low), new THREE.Vector3(...high)];
    const middle = a.clone().add(b).multiplyScalar(0.5);
    const radius = Math.max(a.distanceTo(b) / 2, 1e-9);
    this.#ready = true;
    this.#opening = given?.opening ?? 28;
    if (given) {
      this.#camera.position.set(...given.eye);
      this.#controls.target.set(...given.target);
    } else {
      const half = THREE.MathUtils.degToRad(this.#opening / 2);
      const [azimuth, elevation] = [0.56, 0.35];
      const back = new THREE.Vector3(
        Math.cos(elevation) * Math.sin(azimuth), Math.sin(elevation), Math.cos(elevation) * Math.cos(azimuth));
      this.#controls.target.copy(middle);
      this.#camera.position.copy(middle).addScaledVector(back, (1.35 * radius) / Math.sin(half));
    }
    this.#resize();
    const around = Math.max(radius, 0.3 * this.#camera.position.distanceTo(this.#controls.target));
    Object.assign(this.#camera, { near: around / 200, far: around * 200 });
    this.#camera.updateProjectionMatrix();
    this.#controls.minDistance = radius / 50;
    this.#controls.maxDistance = radius * 60;
    const from = this.#camera.position.clone().sub(this.#controls.target);
    aim(this.#light, middle, Math.max(2.2 * radius, 0.6 * around), Math.atan2(from.x, from.z));
    this.redraw(true);
    return this.#ground.spread(middle, around, this.#height ?? 0);
  }

  /** Turns to look at `low` to `high` from the side where the camera is now. */
  frame(low, high) {
    const [a, b] = [new THREE.Vector3(...low), new THREE.Vector3(...high)];
    const middle = a.clone().add(b).multiplyScalar(0.5);
    const back = this.#camera.position.clone().sub(this.#controls.target).normalize();
    const half = THREE.MathUtils.degToRad(this.#opening / 2);
    this.#controls.target.copy(middle);
    this.#camera.position.copy(middle).addScaledVector(back, (0.56 * Math.max(a.distanceTo(b), 1e-9)) / Math.sin(half));
    this.redraw();
  }

  /** Which run's viewport holds the point, and a ray from the camera through it. */
  ray(clientX, clientY) {
    const box = this.#canvas.getBoundingClientRect();
    const [x, y] = [clientX - box.left, clientY - box.top];
    const index = this.#views().findIndex((v) => x >= v.x && x < v.x + v.width && y >= v.top && y < v.top + v.height);
    if (index < 0) return undefined;
    const view = this.#views()[index];
    const at = new THREE.Vector2(((x - view.x) / view.width) * 2 - 1, 1 - ((y - view.top) / view.height) * 2);
    const raycaster = new THREE.Raycaster();
    raycaster.setFromCamera(at, this.#camera);
    return { index, raycaster };
  }

  /** Metres that a pixel is wide at the distance of the camera's target. */
  get pixel() {
    const distance = this.#camera.position.distanceTo(this.#controls.target);
    const [view] = this.#views();
    return (2 * distance * Math.tan(THREE.MathUtils.degToRad(this.#camera.fov / 2))) / view.height;
  }

  /** Where each run is drawn, in CSS pixels: side by side, or one over the other where it is narrow. */
  #views() {
    const { clientWidth: width, clientHeight: height } = this.#canvas.parentElement;
    if (this.bodies.length < 2) return [{ x: 0, top: 0, width, height }];
    if (width >= height) {
      return [0, 1].map((k) => ({ x: (k * width) / 2, top: 0, width: width / 2, height }));
    }
    return [0, 1].map((k) => ({ x: 0, top: (k * height) / 2, width, height: height / 2 }));
  }

  #resize() {
    const { clientWidth, clientHeight } = this.#canvas.parentElement;
    if (clientWidth === 0 || clientHeight === 0) return;
    this.#renderer.setSize(clientWidth, clientHeight, false);
    const [view] = this.#views();
    this.#camera.aspect = view.width / view.height;
    // a scene's camera is meant for a wide picture: a narrow one must see as much from left to right
    const half = THREE.MathUtils.degToRad(this.#opening / 2);
    const wider = Math.max(1, 1.25 / this.#camera.aspect);
    this.#camera.fov = THREE.MathUtils.radToDeg(2 * Math.atan(Math.tan(half) * wider));
    this.#camera.updateProjectionMatrix();
    this.redraw();
  }

  #loop = (now) => {
    requestAnimationFrame(this.#loop);
    this.#controls.update();
    if (this.#drew) this.#ease(now - this.#drew);
    this.#drew = 0;
    if (!this.#dirty || !now) return;
    this.#dirty = false;
    this.#drew = now;
    const { clientHeight } = this.#canvas.parentElement;
    const shadows = this.#renderer.shadowMap.needsUpdate;
    this.#views().forEach((view, k) => {
      const { scene } = this.bodies[k];
      scene.add(this.#light, this.#light.target, this.#ground);
      const bottom = clientHeight - view.top - view.height;
      this.#renderer.setViewport(view.x, bottom, view.width, view.height);
      this.#renderer.setScissor(view.x, bottom, view.width, view.height);
      // both runs share the light, and so its map of shadows
      this.#renderer.shadowMap.needsUpdate = shadows || this.bodies.length > 1;
      this.#renderer.render(scene, this.#camera);
    });
    this.#renderer.shadowMap.needsUpdate = false;
  };

  /** Gives up what costs most where pictures come slowly: nobody can turn a body at five pictures a second. */
  #ease(milliseconds) {
    this.#slow = milliseconds > SLOW ? this.#slow + 1 : 0;
    if (this.#slow < 8 || !this.#light.castShadow) return;
    this.#light.castShadow = false;
    this.#renderer.setPixelRatio(1);
    this.#resize();
  }
}
