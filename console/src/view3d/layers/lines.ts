import { BufferAttribute, BufferGeometry, Color, LineSegments, ShaderMaterial } from 'three';
import { SEQUENTIAL, type ColourMap, type Range } from '../colour';
import { ROW, type Endpoints } from '../endpoints';
import type { Layer } from '../stage';
import { mapTexture } from './map_texture';

/** Lines between endpoints: L of them. */
export interface Lines {
  /** Endpoints of each line, shape [L, 2]. */
  readonly ends: Uint32Array;
  /** Share of the way to its other end at which a line begins and stops. */
  readonly from: number;
  readonly to: number;
  /** Lengths at rest [m], shape [L], for their strain. */
  readonly restLengths?: Float32Array;
}

const VERTEX = /* glsl */ `
  uniform highp sampler2D endpoints;
  uniform vec2 range;
  uniform int mode;
  attribute vec2 ends;
  attribute float along;
  attribute float value;
  varying float share;
  varying float shown;
  vec4 endpoint(float index) {
    int i = int(index);
    return texelFetch(endpoints, ivec2(i % ${ROW}, i / ${ROW}), 0);
  }
  void main() {
    vec4 a = endpoint(ends.x);
    vec4 b = endpoint(ends.y);
    shown = min(a.w, b.w);
    float number = mode == 2 ? distance(a.xyz, b.xyz) / max(value, 1e-9) - 1.0 : value;
    share = (number - range.x) / max(range.y - range.x, 1e-12);
    gl_Position = projectionMatrix * modelViewMatrix * vec4(mix(a.xyz, b.xyz, along), 1.0);
  }
`;

const FRAGMENT = /* glsl */ `
  uniform vec3 colour;
  uniform float opacity;
  uniform int mode;
  uniform sampler2D map;
  varying float share;
  varying float shown;
  void main() {
    if (shown < 0.5) discard;
    bool coloured = mode != 0;
    vec3 base = coloured ? texture2D(map, vec2(clamp(share, 0.0, 1.0), 0.5)).rgb : colour;
    gl_FragColor = vec4(base, coloured ? 1.0 : opacity);
  }
`;

/** Lines between endpoints: springs, triplets, rods. */
export class LinesLayer implements Layer {
  readonly object: LineSegments<BufferGeometry, ShaderMaterial>;
  readonly #uniforms;
  readonly #lines: Lines;

  constructor(endpoints: Endpoints, lines: Lines, colour: number, opacity: number) {
    this.#lines = lines;
    this.#uniforms = {
      endpoints: { value: endpoints.texture },
      range: { value: [0, 1] },
      mode: { value: 0 },
      colour: { value: new Color(colour).convertLinearToSRGB() },
      opacity: { value: opacity },
      map: { value: mapTexture(SEQUENTIAL) },
    };
    const count = lines.ends.length / 2;
    const ends = new Float32Array(4 * count);
    const along = new Float32Array(2 * count);
    for (let line = 0; line < count; line += 1) {
      const pair = [lines.ends[2 * line]!, lines.ends[2 * line + 1]!];
      ends.set([...pair, ...pair], 4 * line);
      along.set([lines.from, lines.to], 2 * line);
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute('ends', new BufferAttribute(ends, 2));
    geometry.setAttribute('along', new BufferAttribute(along, 1));
    geometry.setDrawRange(0, 2 * count);
    const material = new ShaderMaterial({
      uniforms: this.#uniforms,
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      transparent: true,
      depthWrite: false,
    });
    this.object = new LineSegments(geometry, material);
    this.object.frustumCulled = false;
  }

  /** Gives all lines one colour again. */
  plain(): void {
    this.#uniforms.mode.value = 0;
  }

  /** Colours each line by a value, shape [L]. */
  colourBy(values: Float32Array, range: Range, map: ColourMap): void {
    this.#colour(1, values, range, map);
  }

  /** Colours lines by their strain, wherever their ends are; they need lengths at rest. */
  colourByStrain(range: Range, map: ColourMap): void {
    if (this.#lines.restLengths !== undefined) this.#colour(2, this.#lines.restLengths, range, map);
  }

  dispose(): void {
    this.#uniforms.map.value.dispose();
    this.object.geometry.dispose();
    this.object.material.dispose();
  }

  #colour(mode: number, values: Float32Array, range: Range, map: ColourMap): void {
    this.#uniforms.mode.value = mode;
    this.#uniforms.range.value = [range.low, range.high];
    this.#uniforms.map.value.dispose();
    this.#uniforms.map.value = mapTexture(map);
    const twice = new Float32Array(2 * values.length);
    values.forEach((value, line) => twice.fill(value, 2 * line, 2 * line + 2));
    this.object.geometry.setAttribute('value', new BufferAttribute(twice, 1));
  }
}
