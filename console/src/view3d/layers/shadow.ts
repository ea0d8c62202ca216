import {
  BufferAttribute,
  BufferGeometry,
  DataTexture,
  DoubleSide,
  DynamicDrawUsage,
  LinearFilter,
  Mesh,
  RedFormat,
  ShaderMaterial,
} from 'three';
import type { Plane } from '../shape';
import type { Layer } from '../stage';
import { Footprint, SIDE, type Caster } from '../surface/footprint';

const VERTEX = /* glsl */ `
  varying vec2 at;
  void main() {
    at = uv;
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  }
`;

const FRAGMENT = /* glsl */ `
  uniform sampler2D shade;
  varying vec2 at;
  void main() {
    gl_FragColor = vec4(0.06, 0.08, 0.11, 0.5 * texture2D(shade, at).r);
  }
`;

/** The soft shadow of an object on the ground, which shows its height. */
export class ShadowLayer implements Layer {
  readonly object: Mesh<BufferGeometry, ShaderMaterial>;
  readonly #texture = new DataTexture(new Uint8Array(SIDE * SIDE), SIDE, SIDE, RedFormat);
  #footprint: Footprint | null = null;

  /** `size` is that of the object [m]. */
  constructor(private readonly size: number) {
    this.#texture.magFilter = LinearFilter;
    this.#texture.minFilter = LinearFilter;
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(new Float32Array(12), 3).setUsage(DynamicDrawUsage));
    geometry.setAttribute('uv', new BufferAttribute(new Float32Array(8), 2).setUsage(DynamicDrawUsage));
    geometry.setIndex([0, 1, 2, 0, 2, 3]);
    const material = new ShaderMaterial({
      uniforms: { shade: { value: this.#texture } },
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      transparent: true,
      depthWrite: false,
      side: DoubleSide,
    });
    this.object = new Mesh(geometry, material);
    this.object.frustumCulled = false;
    this.object.renderOrder = -1;
  }

  /** Falls on a plane; hidden without one. */
  place(plane: Plane | null): void {
    this.#footprint = plane === null ? null : new Footprint(plane, this.size);
  }

  /** Casts the shadow of something. */
  cast(caster: Caster): void {
    const footprint = this.#footprint;
    if (footprint === null) return;
    footprint.cast(caster);
    (this.#texture.image.data as Uint8Array).set(footprint.cells);
    this.#texture.needsUpdate = true;
    const [columns, rows] = footprint.used;
    const { geometry } = this.object;
    const [positions, uvs] = [geometry.getAttribute('position'), geometry.getAttribute('uv')];
    const corners = [[0, 0], [columns, 0], [columns, rows], [0, rows]] as const;
    corners.forEach(([column, row], corner) => {
      positions.setXYZ(corner, ...footprint.point(column, row));
      uvs.setXY(corner, column / SIDE, row / SIDE);
    });
    positions.needsUpdate = true;
    uvs.needsUpdate = true;
  }

  dispose(): void {
    this.#texture.dispose();
    this.object.geometry.dispose();
    this.object.material.dispose();
  }
}
