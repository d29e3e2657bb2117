// Particles as little balls: each a square that faces the camera, shaded as the ball it stands for.

import * as THREE from './three.module.min.js';

export function particleMaterial() {
  return new THREE.ShaderMaterial({
    uniforms: { height: { value: 1 } },
    vertexShader: `attribute float width;
      attribute vec3 color;
      uniform float height;
      varying vec3 tint;
      void main() {
        tint = color;
        vec4 place = modelViewMatrix * vec4(position, 1.0);
        gl_Position = projectionMatrix * place;
        gl_PointSize = max(1.5, 1.1 * width * projectionMatrix[1][1] * 0.5 * height / -place.z);
      }`,
    fragmentShader: `varying vec3 tint;
      void main() {
        vec2 at = vec2(2.0, -2.0) * (gl_PointCoord - 0.5);
        float inside = 1.0 - dot(at, at);
        if (inside < 0.0) discard;
        vec3 normal = vec3(at, sqrt(inside));
        float key = max(dot(normal, normalize(vec3(-0.6, 0.65, 0.5))), 0.0);
        float sky = 0.5 + 0.5 * normal.y;
        gl_FragColor = vec4(tint * (0.28 + 0.42 * sky + 0.75 * key), 1.0);
        #include <tonemapping_fragment>
        #include <colorspace_fragment>
      }`,
  });
}
