import {
  DataTexture,
  DynamicDrawUsage,
  FloatType,
  InstancedBufferAttribute,
  InstancedBufferGeometry,
  Float32BufferAttribute,
  Mesh,
  RGBAFormat,
  ShaderMaterial,
  Vector2,
  Vector3,
  type PerspectiveCamera,
} from 'three';
import type { Splats } from '../appearance';
import { Carrier } from '../splats/carry';
import { SplatOrder, byImportance } from '../splats/order';
import type { Layer } from '../stage';

/** Splats in a row of the texture, each with four texels: mean and opacity, covariance (two), colour. */
const ROW = 512;

// EWA projection (Zwicker et al. 2001): the covariance on the screen is J W S W^T J^T, 0.3 square pixels are added, and
// what that adds to the area is taken from the opacity. The quad reaches to where a splat is below 1/255.
const VERTEX = /* glsl */ `
  uniform highp sampler2D data;
  uniform vec2 pixels;
  attribute float index;
  varying vec2 at;
  varying vec4 look;
  vec4 texel(int splat, int part) {
    return texelFetch(data, ivec2(4 * (splat % ${ROW}) + part, splat / ${ROW}), 0);
  }
  void main() {
    int splat = int(index + 0.5);
    vec4 mean = texel(splat, 0);
    vec4 a = texel(splat, 1);
    vec4 b = texel(splat, 2);
    vec4 seen = modelViewMatrix * vec4(mean.xyz, 1.0);
    float depth = -seen.z;
    gl_Position = vec4(0.0, 0.0, 2.0, 1.0);
    at = vec2(0.0);
    look = vec4(0.0);
    if (depth < 0.01) return;
    vec2 focal = 0.5 * pixels * vec2(projectionMatrix[0][0], projectionMatrix[1][1]);
    vec2 limit = 1.3 / vec2(projectionMatrix[0][0], projectionMatrix[1][1]);
    vec2 way = clamp(seen.xy / depth, -limit, limit);
    mat3 turn = mat3(modelViewMatrix);
    mat3 covariance = turn * mat3(a.x, a.y, a.z, a.y, b.x, b.y, a.z, b.y, b.z) * transpose(turn);
    vec3 u = vec3(focal.x, 0.0, focal.x * way.x) / depth;
    vec3 v = vec3(0.0, focal.y, focal.y * way.y) / depth;
    float xx = dot(u, covariance * u);
    float yy = dot(v, covariance * v);
    float xy = dot(u, covariance * v);
    float area = max(xx * yy - xy * xy, 0.0);
    xx += 0.3;
    yy += 0.3;
    float opacity = mean.w * sqrt(area / (xx * yy - xy * xy));
    if (opacity < 1.0 / 255.0) return;
    float middle = 0.5 * (xx + yy);
    float spread = length(vec2(0.5 * (xx - yy), xy));
    vec2 large = abs(xy) > 1e-6 ? normalize(vec2(xy, middle + spread - xx)) : xx >= yy ? vec2(1.0, 0.0) : vec2(0.0, 1.0);
    vec2 small = vec2(-large.y, large.x);
    at = sqrt(2.0 * log(255.0 * opacity)) * position.xy;
    vec2 shift = at.x * sqrt(middle + spread) * large + at.y * sqrt(max(middle - spread, 0.0)) * small;
    gl_Position = projectionMatrix * seen;
    gl_Position.xy += 2.0 * shift / pixels * gl_Position.w;
    look = vec4(texel(splat, 3).rgb, opacity);
  }
`;

const FRAGMENT = /* glsl */ `
  varying vec2 at;
  varying vec4 look;
  void main() {
    float alpha = min(0.99, look.a * exp(-0.5 * dot(at, at)));
    if (alpha < 1.0 / 255.0) discard;
    gl_FragColor = vec4(clamp(look.rgb, 0.0, 1.0) * alpha, alpha);
  }
`;

/** Gaussians that nodes carry, drawn from the farthest to the nearest over what is opaque. */
export class SplatsLayer implements Layer {
  readonly object: Mesh<InstancedBufferGeometry, ShaderMaterial>;
  readonly #carrier: Carrier;
  readonly #means: Float32Array;
  readonly #turns: Float32Array;
  readonly #texture: DataTexture;
  readonly #index: InstancedBufferAttribute;
  readonly #order: SplatOrder;
  readonly #important: Uint32Array;
  readonly #away = new Vector3();
  readonly #size = new Vector2();
  #drawn: number;

  /** `rest` and `springs` are those of the twin that carries them. */
  constructor(
    private readonly splats: Splats,
    rest: Float32Array,
    springs: Uint32Array,
  ) {
    const count = splats.opacities.length;
    this.#carrier = new Carrier(rest, springs, splats.carriers);
    this.#means = new Float32Array(3 * count);
    this.#turns = new Float32Array(4 * count);
    this.#order = new SplatOrder(count);
    this.#important = byImportance(splats.opacities, splats.scales);
    this.#drawn = count;
    const rows = Math.max(1, Math.ceil(count / ROW));
    const texels = new Float32Array(16 * ROW * rows);
    this.#texture = new DataTexture(texels, 4 * ROW, rows, RGBAFormat, FloatType);
    for (let g = 0; g < count; g += 1) {
      texels[16 * g + 3] = splats.opacities[g]!;
      texels.set(splats.colours.subarray(3 * g, 3 * g + 3), 16 * g + 12);
    }
    const geometry = new InstancedBufferGeometry();
    const corners = [-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0];
    geometry.setAttribute('position', new Float32BufferAttribute(corners, 3));
    geometry.setIndex([0, 1, 2, 0, 2, 3]);
    this.#index = new InstancedBufferAttribute(new Float32Array(count), 1).setUsage(DynamicDrawUsage);
    geometry.setAttribute('index', this.#index);
    const uniforms = { data: { value: this.#texture }, pixels: { value: this.#size } };
    const material = new ShaderMaterial({
      uniforms, vertexShader: VERTEX, fragmentShader: FRAGMENT,
      transparent: true, premultipliedAlpha: true, depthWrite: false,
    });
    this.object = new Mesh(geometry, material);
    this.object.frustumCulled = false;
    this.object.renderOrder = 1;
    this.object.onBeforeRender = (renderer) => {
      renderer.getDrawingBufferSize(this.#size);
      material.uniformsNeedUpdate = true;
    };
  }

  /** Number of splats, drawn or not. */
  get count(): number {
    return this.splats.opacities.length;
  }

  /** Number of splats that are drawn, those that are seen most. */
  get drawn(): number {
    return this.#drawn;
  }

  set drawn(count: number) {
    this.#drawn = Math.min(Math.max(Math.round(count), 0), this.count);
  }

  /** Moves the splats with nodes [m], shape [N, 3]. */
  place(nodes: Float32Array): void {
    this.#carrier.at(nodes, this.#means, this.#turns);
    const texels = this.#texture.image.data as Float32Array;
    for (let g = 0; g < this.count; g += 1) this.#write(g, texels);
    this.#texture.needsUpdate = true;
  }

  /** Orders the splats for a camera; called before each frame. */
  sort(camera: PerspectiveCamera): void {
    camera.getWorldDirection(this.#away);
    const chosen = this.#important.subarray(0, this.#drawn);
    this.#order.sort(this.#means, chosen, this.#away.toArray(), this.#index.array as Float32Array);
    this.#index.needsUpdate = true;
    this.object.geometry.instanceCount = this.#drawn;
  }

  dispose(): void {
    this.#texture.dispose();
    this.object.geometry.dispose();
    this.object.material.dispose();
  }

  /** Mean and covariance R S^2 R^T of a splat, where R turns it at rest and then with its nodes. */
  #write(g: number, texels: Float32Array): void {
    const [t, r] = [this.#turns, this.splats.rotations];
    const [ax, ay, az, aw] = [t[4 * g]!, t[4 * g + 1]!, t[4 * g + 2]!, t[4 * g + 3]!];
    const [bx, by, bz, bw] = [r[4 * g]!, r[4 * g + 1]!, r[4 * g + 2]!, r[4 * g + 3]!];
    const x = aw * bx + ax * bw + ay * bz - az * by;
    const y = aw * by - ax * bz + ay * bw + az * bx;
    const z = aw * bz + ax * by - ay * bx + az * bw;
    const w = aw * bw - ax * bx - ay * by - az * bz;
    const [s0, s1, s2] = [this.splats.scales[3 * g]!, this.splats.scales[3 * g + 1]!, this.splats.scales[3 * g + 2]!];
    const [m00, m10, m20] = [s0 * (1 - 2 * (y * y + z * z)), s0 * 2 * (x * y + w * z), s0 * 2 * (x * z - w * y)];
    const [m01, m11, m21] = [s1 * 2 * (x * y - w * z), s1 * (1 - 2 * (x * x + z * z)), s1 * 2 * (y * z + w * x)];
    const [m02, m12, m22] = [s2 * 2 * (x * z + w * y), s2 * 2 * (y * z - w * x), s2 * (1 - 2 * (x * x + y * y))];
    const at = 16 * g;
    texels[at] = this.#means[3 * g]!;
    texels[at + 1] = this.#means[3 * g + 1]!;
    texels[at + 2] = this.#means[3 * g + 2]!;
    texels[at + 4] = m00 * m00 + m01 * m01 + m02 * m02;
    texels[at + 5] = m00 * m10 + m01 * m11 + m02 * m12;
    texels[at + 6] = m00 * m20 + m01 * m21 + m02 * m22;
    texels[at + 8] = m10 * m10 + m11 * m11 + m12 * m12;
    texels[at + 9] = m10 * m20 + m11 * m21 + m12 * m22;
    texels[at + 10] = m20 * m20 + m21 * m21 + m22 * m22;
  }
}
