import { BufferAttribute, BufferGeometry, Color, DynamicDrawUsage, Points, ShaderMaterial } from 'three';
import { SEQUENTIAL, type ColourMap, type Range } from '../colour';
import type { Layer } from '../stage';
import { mapTexture } from './map_texture';

/** Style of points. */
export interface PointStyle {
  /** Diameter [m]. */
  readonly size: number;
  readonly colour: number;
}

// Points are discs that are shaded as balls; they are 2 pixels wide at least.
const VERTEX = /* glsl */ `
  uniform float size;
  uniform float height;
  uniform vec2 range;
  attribute float value;
  attribute vec3 tint;
  varying float share;
  varying vec3 own;
  void main() {
    vec4 seen = modelViewMatrix * vec4(position, 1.0);
    gl_Position = projectionMatrix * seen;
    gl_PointSize = max(2.0, size * projectionMatrix[1][1] * 0.5 * height / max(gl_Position.w, 1e-6));
    share = (value - range.x) / max(range.y - range.x, 1e-12);
    own = tint;
  }
`;

const FRAGMENT = /* glsl */ `
  uniform vec3 colour;
  uniform int mode;
  uniform sampler2D map;
  varying float share;
  varying vec3 own;
  void main() {
    vec2 at = 2.0 * gl_PointCoord - 1.0;
    float square = dot(at, at);
    if (square > 1.0) discard;
    vec3 base = colour;
    if (mode == 1) base = texture2D(map, vec2(clamp(share, 0.0, 1.0), 0.5)).rgb;
    if (mode == 2) base = own;
    float light = 0.62 + 0.38 * sqrt(1.0 - square) - 0.14 * at.y;
    gl_FragColor = vec4(base * light, 1.0);
  }
`;

/** Points as small balls: of one colour, coloured by a value each, or in separate colours. */
export class PointsLayer implements Layer {
  readonly object: Points<BufferGeometry, ShaderMaterial>;
  readonly #uniforms;

  /** Shows points [m], shape [M, 3]; `positions` is kept, and may be written to before `moved`. */
  constructor(
    readonly positions: Float32Array,
    style: PointStyle,
  ) {
    this.#uniforms = {
      size: { value: style.size },
      height: { value: 1 },
      range: { value: [0, 1] },
      colour: { value: new Color(style.colour).convertLinearToSRGB() },
      mode: { value: 0 },
      map: { value: mapTexture(SEQUENTIAL) },
    };
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(positions, 3).setUsage(DynamicDrawUsage));
    const material = new ShaderMaterial({ uniforms: this.#uniforms, vertexShader: VERTEX, fragmentShader: FRAGMENT });
    this.object = new Points(geometry, material);
    this.object.frustumCulled = false;
    this.object.onBeforeRender = (renderer) => {
      this.#uniforms.height.value = renderer.domElement.height;
      material.uniformsNeedUpdate = true;
    };
  }

  /** Says that positions have changed; `count` points are shown, or all. */
  moved(count?: number): void {
    this.object.geometry.getAttribute('position').needsUpdate = true;
    if (count !== undefined) this.object.geometry.setDrawRange(0, count);
  }

  /** Gives all points one colour again. */
  plain(colour?: number): void {
    this.#uniforms.mode.value = 0;
    if (colour !== undefined) this.#uniforms.colour.value.set(colour).convertLinearToSRGB();
  }

  /** Colours each point by a value; may be called before every frame. */
  colourBy(values: Float32Array, range: Range, map: ColourMap): void {
    this.#uniforms.mode.value = 1;
    this.#uniforms.range.value = [range.low, range.high];
    if (this.object.userData['map'] !== map.name) {
      this.#uniforms.map.value.dispose();
      this.#uniforms.map.value = mapTexture(map);
      this.object.userData['map'] = map.name;
    }
    this.#set('value', values, 1);
  }

  /** Sets separate colours, red, green, blue as bytes, shape [M, 3]. */
  tint(colours: Uint8Array): void {
    this.#uniforms.mode.value = 2;
    this.#set('tint', colours, 3);
  }

  /** Diameter of the points [m]. */
  set size(metres: number) {
    this.#uniforms.size.value = metres;
  }

  dispose(): void {
    this.#uniforms.map.value.dispose();
    this.object.geometry.dispose();
    this.object.material.dispose();
  }

  #set(name: string, values: Float32Array | Uint8Array, width: number): void {
    const old = this.object.geometry.getAttribute(name) as BufferAttribute | undefined;
    if (old !== undefined && old.array.length === values.length) {
      if (old.array !== values) old.array.set(values);
      old.needsUpdate = true;
      return;
    }
    const attribute = new BufferAttribute(values, width, values instanceof Uint8Array);
    this.object.geometry.setAttribute(name, attribute.setUsage(DynamicDrawUsage));
  }
}
