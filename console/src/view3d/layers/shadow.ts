import { Points, ShaderMaterial, Vector3, type BufferGeometry } from 'three';
import type { Plane } from '../shape';
import type { Layer } from '../stage';

const VERTEX = /* glsl */ `
  uniform vec4 plane;
  uniform float size;
  uniform float height;
  varying float shade;
  void main() {
    float above = dot(plane.xyz, position) - plane.w;
    vec3 foot = position - (above - 0.001) * plane.xyz;
    shade = above < -0.01 ? 0.0 : 0.22 / (1.0 + 8.0 * max(above, 0.0));
    gl_Position = projectionMatrix * modelViewMatrix * vec4(foot, 1.0);
    gl_PointSize = max(2.0, size * projectionMatrix[1][1] * 0.5 * height / max(gl_Position.w, 1e-6));
  }
`;

const FRAGMENT = /* glsl */ `
  varying float shade;
  void main() {
    vec2 at = 2.0 * gl_PointCoord - 1.0;
    float square = dot(at, at);
    if (square > 1.0) discard;
    gl_FragColor = vec4(0.1, 0.12, 0.15, shade * (1.0 - square));
  }
`;

/** Spots below points on the ground, which show their height. They share the points' memory. */
export class ShadowLayer implements Layer {
  readonly object: Points<BufferGeometry, ShaderMaterial>;
  readonly #uniforms = { plane: { value: [0, 0, 1, 0] }, size: { value: 0.01 }, height: { value: 1 } };

  /** `geometry` stays its owner's. */
  constructor(geometry: BufferGeometry, sizeM: number) {
    this.#uniforms.size.value = sizeM;
    const material = new ShaderMaterial({
      uniforms: this.#uniforms,
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      transparent: true,
      depthWrite: false,
    });
    this.object = new Points(geometry, material);
    this.object.frustumCulled = false;
    this.object.renderOrder = -1;
    this.object.onBeforeRender = (renderer) => {
      this.#uniforms.height.value = renderer.domElement.height;
      material.uniformsNeedUpdate = true;
    };
  }

  /** Falls on a plane; hidden without one. */
  place(plane: Plane | null): void {
    this.object.visible = plane !== null;
    if (plane === null) return;
    const normal = new Vector3(...plane.normal).normalize();
    this.#uniforms.plane.value = [...normal.toArray(), plane.offset_m];
  }

  dispose(): void {
    this.object.material.dispose();
  }
}
