// The light: soft boxes that the glaze mirrors, a key light with a shadow, and a ground that fades out.

import * as THREE from './three.module.min.js';

/** What shines on things from all around, made once from a small room of lamps. */
export function surroundings(renderer) {
  const room = new THREE.Scene();
  const shell = new THREE.SphereGeometry(10, 24, 12);
  const colours = new Float32Array(shell.attributes.position.count * 3);
  for (let v = 0; v < shell.attributes.position.count; v++) {
    const up = shell.attributes.position.getY(v) / 10;
    const level = up > 0 ? 0.5 + 0.45 * up : 0.3 + 0.12 * up;
    colours.set([level * 0.94, level * 0.98, level * 1.08], 3 * v);
  }
  shell.setAttribute('color', new THREE.BufferAttribute(colours, 3));
  room.add(new THREE.Mesh(shell, new THREE.MeshBasicMaterial({ vertexColors: true, side: THREE.BackSide })));
  const lamp = (width, height, light, place) => {
    const material = new THREE.MeshBasicMaterial({ side: THREE.DoubleSide });
    material.color.setScalar(light);
    const mesh = new THREE.Mesh(new THREE.PlaneGeometry(width, height), material);
    mesh.position.set(...place);
    mesh.lookAt(0, 0, 0);
    room.add(mesh);
  };
  lamp(4, 4, 9, [-6, 5, 3]);
  lamp(1.5, 6, 4, [7, 2, -2]);
  const generator = new THREE.PMREMGenerator(renderer);
  const { texture } = generator.fromScene(room, 0.03, 0.1, 100, { size: 64 });
  generator.dispose();
  return texture;
}

/** A sun with a shadow, to be put around what is seen. */
export function keyLight() {
  const light = new THREE.DirectionalLight(0xfff1de, 2.1);
  light.castShadow = true;
  light.shadow.mapSize.set(2048, 2048);
  light.shadow.radius = 5;
  light.shadow.normalBias = 0.02;
  return light;
}

/** Puts `light` to the left of the camera's first place, so that its shadow covers a ball around `middle`. */
export function aim(light, middle, radius, azimuth) {
  const angle = azimuth - 1.15;
  const direction = new THREE.Vector3(Math.sin(angle), 1.15, Math.cos(angle)).normalize();
  light.target.position.copy(middle);
  light.position.copy(middle).addScaledVector(direction, 4 * radius);
  light.target.updateMatrixWorld();
  const { camera } = light.shadow;
  Object.assign(camera, { left: -radius, right: radius, top: radius, bottom: -radius, near: radius, far: 8 * radius });
  camera.updateProjectionMatrix();
  light.shadow.normalBias = radius * 0.004;
  light.shadow.needsUpdate = true;
}

/** The ground: lines every `step`, fading out, and the shadow on it. */
export function ground() {
  const lines = new THREE.ShaderMaterial({
    transparent: true,
    depthWrite: false,
    side: THREE.DoubleSide,
    uniforms: { step: { value: 0.1 }, middle: { value: new THREE.Vector2() }, radius: { value: 1 } },
    vertexShader: `varying vec2 at;
      void main() {
        vec4 world = modelMatrix * vec4(position, 1.0);
        at = world.xz;
        gl_Position = projectionMatrix * viewMatrix * world;
      }`,
    fragmentShader: `varying vec2 at;
      uniform float step, radius;
      uniform vec2 middle;
      float grid(float size) {
        vec2 wide = fwidth(at / size);
        vec2 near = abs(fract(at / size - 0.5) - 0.5) / max(wide, vec2(1e-6));
        float calm = 1.0 - smoothstep(0.15, 0.6, max(wide.x, wide.y));
        return (1.0 - min(min(near.x, near.y), 1.0)) * calm;
      }
      void main() {
        float far = length(at - middle) / radius;
        float fade = 1.0 - smoothstep(0.1, 1.0, far);
        float line = max(0.09 * grid(step), 0.17 * grid(10.0 * step));
        float pool = 0.34 * exp(-6.0 * far * far);
        gl_FragColor = vec4(mix(vec3(0.24, 0.25, 0.27), vec3(0.75, 0.80, 0.88), line), (pool + line) * fade);
      }`,
  });
  const plane = new THREE.PlaneGeometry(1, 1).rotateX(-Math.PI / 2);
  const group = new THREE.Group();
  const floor = new THREE.Mesh(plane, lines);
  floor.renderOrder = -2;
  const shade = new THREE.Mesh(plane, new THREE.ShadowMaterial({ opacity: 0.55, depthWrite: false }));
  shade.receiveShadow = true;
  shade.renderOrder = -1;
  group.add(floor, shade);
  group.spread = (middle, radius, height) => {
    // round steps, of which a body's size has about five
    const ten = 10 ** Math.floor(Math.log10(radius));
    lines.uniforms.step.value = radius / ten > 3 ? ten : ten / 5;
    lines.uniforms.middle.value.set(middle.x, middle.z);
    lines.uniforms.radius.value = 9 * radius;
    group.position.set(middle.x, height, middle.z);
    group.scale.setScalar(18 * radius);
    return lines.uniforms.step.value;
  };
  return group;
}
