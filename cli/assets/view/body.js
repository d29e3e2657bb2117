// What is drawn of one run: its surface, edges, particles and colliders.

import * as THREE from './three.module.min.js';
import { particleMaterial } from './points.js';

const array = (values, size) => new THREE.BufferAttribute(values, size);

/** How far each vertex moves when pieces are blown apart by `amount` around `middle`. */
function exploded(frame, amount, middle) {
  const { position } = frame.columns;
  if (amount === 0) return position;
  const { of, centres } = frame.pieces;
  const out = new Float32Array(position.length);
  for (let v = 0; v < of.length; v++) {
    for (let k = 0; k < 3; k++) {
      out[3 * v + k] = position[3 * v + k] + amount * (centres[3 * of[v] + k] - middle[k]);
    }
  }
  return out;
}

export class Body {
  scene = new THREE.Scene();
  #glazed = new THREE.MeshStandardMaterial({ vertexColors: true, roughness: 0.32, metalness: 0 });
  #raw = new THREE.MeshStandardMaterial({ vertexColors: true, roughness: 0.95, metalness: 0 });
  #edges = new THREE.MeshBasicMaterial({ wireframe: true, color: 0x0b0d10, transparent: true, opacity: 0.42 });
  #surface = new THREE.Mesh(new THREE.BufferGeometry(), [this.#glazed, this.#raw]);
  #wire = new THREE.Mesh(this.#surface.geometry, this.#edges);
  #points = new THREE.Points(new THREE.BufferGeometry(), particleMaterial());
  #colliders = new THREE.Mesh(
    new THREE.BufferGeometry(),
    new THREE.MeshStandardMaterial({ color: 0x7d8794, roughness: 0.5, metalness: 0.35 }),
  );
  #marker = new THREE.Mesh(
    new THREE.SphereGeometry(1, 16, 12),
    new THREE.MeshBasicMaterial({ color: 0xff7a45, depthTest: false, transparent: true, opacity: 0.9 }),
  );

  constructor() {
    this.#surface.castShadow = this.#surface.receiveShadow = true;
    this.#colliders.castShadow = this.#colliders.receiveShadow = true;
    const behindEdges = { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 };
    for (const material of [this.#glazed, this.#raw]) Object.assign(material, behindEdges);
    const viewport = new THREE.Vector4();
    this.#points.onBeforeRender = (renderer) => {
      this.#points.material.uniforms.height.value = renderer.getCurrentViewport(viewport).w;
    };
    this.#marker.renderOrder = 9;
    this.#marker.visible = false;
    for (const thing of [this.#surface, this.#wire, this.#points, this.#colliders, this.#marker]) {
      thing.frustumCulled = false;
      this.scene.add(thing);
    }
  }

  /** Shows the surface and colliders of `frame`. */
  surface(frame, colours, { explode, cracks, middle }) {
    const { columns, outer } = frame;
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', array(exploded(frame, explode, middle), 3));
    geometry.setAttribute('normal', array(columns.normal, 3));
    geometry.setAttribute('color', array(colours, 3));
    geometry.setIndex(array(columns.triangle, 1));
    geometry.addGroup(0, 3 * outer, 0);
    if (cracks) geometry.addGroup(3 * outer, columns.triangle.length - 3 * outer, 1);
    else geometry.setDrawRange(0, 3 * outer);
    this.#glazed.side = cracks ? THREE.FrontSide : THREE.DoubleSide;
    this.#surface.geometry.dispose();
    this.#surface.geometry = this.#wire.geometry = geometry;
    this.#rigid(columns);
  }

  #rigid(columns) {
    const geometry = new THREE.BufferGeometry();
    if (columns['collider.position']) {
      geometry.setAttribute('position', array(columns['collider.position'], 3));
      geometry.setAttribute('normal', array(columns['collider.normal'], 3));
      geometry.setIndex(array(columns['collider.triangle'], 1));
    }
    this.#colliders.geometry.dispose();
    this.#colliders.geometry = geometry;
  }

  /** Shows the particles of `frame`. */
  particles(frame, colours, { explode, middle }) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', array(exploded(frame, explode, middle), 3));
    geometry.setAttribute('color', array(colours, 3));
    geometry.setAttribute('width', array(frame.columns.width, 1));
    this.#points.geometry.dispose();
    this.#points.geometry = geometry;
  }

  /** Shows one of `surface`, `edges`, `particles`, and colliders or none. */
  choose(shape, colliders) {
    this.#surface.visible = shape !== 'particles';
    this.#wire.visible = shape === 'edges';
    this.#points.visible = shape === 'particles';
    this.#colliders.visible = colliders && this.#colliders.geometry.index !== null;
  }

  /** Marks a vertex of what is shown; none for a negative one. */
  mark(vertex, size) {
    const { position } = this.#shown.geometry.attributes;
    this.#marker.visible = vertex >= 0;
    if (vertex < 0) return;
    this.#marker.position.fromBufferAttribute(position, vertex);
    this.#marker.scale.setScalar(size);
  }

  get #shown() {
    return this.#points.visible ? this.#points : this.#surface;
  }

  /** The vertex under a ray, or -1. Particles count as hit within `reach`. */
  hit(raycaster, reach) {
    raycaster.params.Points.threshold = reach;
    const shown = this.#shown;
    if (!shown.geometry.attributes.position) return -1;
    const hits = raycaster.intersectObject(shown, false);
    if (hits.length === 0) return -1;
    if (shown === this.#points) return hits[0].index;
    const { face, point } = hits[0];
    const corner = new THREE.Vector3();
    const apart = (v) => corner.fromBufferAttribute(shown.geometry.attributes.position, v).distanceToSquared(point);
    return [face.a, face.b, face.c].reduce((best, v) => (apart(v) < apart(best) ? v : best));
  }
}
