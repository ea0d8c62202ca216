import { BufferAttribute, BufferGeometry, Color, DynamicDrawUsage, Mesh, ShaderMaterial, Vector3 } from 'three';
import { colourAt, shareOf, type ColourMap, type Range } from '../colour';
import type { Layer } from '../stage';
import { SurfaceMesh } from '../surface/mesh';
import type { Surface } from '../surface/surface';

/** Direction to the light that makes a difference between sides. */
const SUN = new Vector3(0.45, -0.9, 1.7).normalize();

// Light is computed at the vertices, which are close to one another: without a GPU every pixel counts. Colours are sRGB,
// light adds up linearly. What strains too much has stripes, so that it is seen without colours too.
const VERTEX = /* glsl */ `
  uniform vec3 sun;
  uniform float evenness;
  attribute vec3 tint;
  attribute float excess;
  varying vec3 shade;
  varying float beyond;
  vec3 toLinear(vec3 c) {
    return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), step(0.04045, c));
  }
  vec3 toSrgb(vec3 c) {
    return mix(c * 12.92, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c));
  }
  void main() {
    vec4 seen = modelViewMatrix * vec4(position, 1.0);
    gl_Position = projectionMatrix * seen;
    vec3 n = normal / max(length(normal), 1e-20);
    float facing = abs(dot(normalize(mat3(modelViewMatrix) * n), normalize(seen.xyz)));
    float light = mix(0.42, 0.74, 0.5 + 0.5 * n.z) + 0.55 * max(dot(n, sun), 0.0);
    // Edges that turn away are darker: the shape is seen on a background of its own colour too.
    light *= mix(0.7, 1.0, smoothstep(0.0, 0.6, facing));
    light = mix(light, 1.0, evenness);
    shade = toSrgb(clamp(toLinear(tint) * light, 0.0, 1.0));
    beyond = excess;
  }
`;

const FRAGMENT = /* glsl */ `
  uniform vec3 warning;
  varying vec3 shade;
  varying float beyond;
  void main() {
    vec3 colour = shade;
    if (beyond > 0.02) {
      float stripe = step(0.5, fract((gl_FragCoord.x + gl_FragCoord.y) / 9.0));
      colour = mix(shade, warning, smoothstep(0.0, 0.3, beyond) * mix(0.4, 1.0, stripe));
    }
    gl_FragColor = vec4(colour, 1.0);
  }
`;

/** The surface of a twin: a lit mesh in its own colours, in one, or coloured by a value. */
export class SurfaceLayer implements Layer {
  readonly object: Mesh<BufferGeometry, ShaderMaterial>;
  readonly mesh: SurfaceMesh;
  readonly #tint: BufferAttribute;
  readonly #excess: BufferAttribute;
  readonly #uniforms = {
    sun: { value: SUN },
    evenness: { value: 0 },
    warning: { value: new Color(0xd6006c).convertLinearToSRGB() },
  };
  #exceeds = false;

  constructor(
    surface: Surface,
    private readonly colour: number,
  ) {
    this.mesh = new SurfaceMesh(surface);
    const { positions, normals, faces } = this.mesh;
    const count = positions.length / 3;
    this.#tint = new BufferAttribute(new Uint8Array(3 * count), 3, true);
    this.#excess = new BufferAttribute(new Float32Array(count), 1).setUsage(DynamicDrawUsage);
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(positions, 3).setUsage(DynamicDrawUsage));
    geometry.setAttribute('normal', new BufferAttribute(normals, 3).setUsage(DynamicDrawUsage));
    geometry.setAttribute('tint', this.#tint);
    geometry.setAttribute('excess', this.#excess);
    geometry.setIndex(new BufferAttribute(faces, 1));
    const material = new ShaderMaterial({ uniforms: this.#uniforms, vertexShader: VERTEX, fragmentShader: FRAGMENT });
    this.object = new Mesh(geometry, material);
    this.object.frustumCulled = false;
    this.plain();
  }

  /** Number of vertices V. */
  get count(): number {
    return this.#excess.count;
  }

  /** Moves the surface with nodes [m], shape [N, 3]. */
  place(nodes: Float32Array): void {
    this.mesh.place(nodes);
    for (const name of ['position', 'normal']) this.object.geometry.getAttribute(name).needsUpdate = true;
  }

  /** Gives all of it one colour. */
  plain(): void {
    const { r, g, b } = new Color(this.colour).convertLinearToSRGB();
    const bytes = [r, g, b].map((part) => Math.round(255 * part));
    this.tint(Uint8Array.from({ length: 3 * this.count }, (_, i) => bytes[i % 3]!));
  }

  /** Gives each vertex a colour, red, green, blue as in images, shape [V, 3]. */
  tint(colours: Uint8Array): void {
    this.#uniforms.evenness.value = 0;
    this.#tint.array.set(colours);
    this.#tint.needsUpdate = true;
  }

  /** Colours each vertex by a value, shape [V], with so little shade that the colours can be compared with a legend. */
  colourBy(values: Float32Array, range: Range, map: ColourMap): void {
    const colours = new Uint8Array(3 * values.length);
    values.forEach((value, v) => {
      colours.set(colourAt(map, shareOf(range, value)).map((part) => Math.round(255 * part)), 3 * v);
    });
    this.tint(colours);
    this.#uniforms.evenness.value = 0.6;
  }

  /** Stripes what exceeds a limit by values of nodes, 0 for nothing to 1, shape [N]; null for nothing at all. */
  warn(values: Float32Array | null): void {
    if (values === null && !this.#exceeds) return;
    this.#exceeds = values !== null;
    if (values === null) this.#excess.array.fill(0);
    else this.mesh.spread(values, this.#excess.array as Float32Array);
    this.#excess.needsUpdate = true;
  }

  dispose(): void {
    this.object.geometry.dispose();
    this.object.material.dispose();
  }
}
