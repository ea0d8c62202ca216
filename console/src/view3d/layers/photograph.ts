import {
  ClampToEdgeWrapping,
  LinearFilter,
  Mesh,
  PlaneGeometry,
  ShaderMaterial,
  Texture,
  Vector2,
  Vector4,
  type WebGLRenderer,
} from 'three';
import { fitted, type Pinhole } from '../place/pinhole';
import type { Layer } from '../stage';

/** An image of a calibrated camera. */
export interface Photograph extends Pinhole {
  readonly distortion: { readonly model: string; readonly coefficients: readonly number[] };
  readonly image: TexImageSource;
}

/** Numbers of the models of lenses in the shader. */
const MODELS: Readonly<Record<string, number>> = { brown_conrady: 1, kannala_brandt: 2 };

const VERTEX = /* glsl */ `
  varying vec2 at;
  void main() {
    at = position.xy;
    gl_Position = vec4(position.xy, 0.0, 1.0);
  }
`;

// The view is that of a pinhole; the lens bent the image, as src/playback/camera/projection.ts has it.
const FRAGMENT = /* glsl */ `
  uniform sampler2D image;
  uniform vec2 size;
  uniform vec4 pinhole;
  uniform vec4 place;
  uniform int model;
  uniform float k[8];
  varying vec2 at;
  void main() {
    vec2 p = (at * place.xy + place.zw - pinhole.zw) / pinhole.xy;
    float r2 = dot(p, p);
    if (model == 1) {
      float bend = (1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]))) / (1.0 + r2 * (k[5] + r2 * (k[6] + r2 * k[7])));
      p = p * bend + vec2(2.0 * k[2] * p.x * p.y + k[3] * (r2 + 2.0 * p.x * p.x),
        k[2] * (r2 + 2.0 * p.y * p.y) + 2.0 * k[3] * p.x * p.y);
    } else if (model == 2 && r2 > 1e-12) {
      float r = sqrt(r2);
      float a = atan(r);
      float a2 = a * a;
      p *= a * (1.0 + a2 * (k[0] + a2 * (k[1] + a2 * (k[2] + a2 * k[3])))) / r;
    }
    vec2 seen = (p * pinhole.xy + pinhole.zw + 0.5) / size;
    if (any(lessThan(seen, vec2(0.0))) || any(greaterThan(seen, vec2(1.0)))) discard;
    gl_FragColor = vec4(texture2D(image, seen).rgb, 1.0);
  }
`;

/** A photograph behind everything, seen from where its camera stood. */
export class PhotographLayer implements Layer {
  readonly object: Mesh<PlaneGeometry, ShaderMaterial>;
  readonly #texture: Texture;

  constructor({ image, size, intrinsics, distortion }: Photograph) {
    this.#texture = new Texture(image);
    this.#texture.wrapS = this.#texture.wrapT = ClampToEdgeWrapping;
    this.#texture.minFilter = this.#texture.magFilter = LinearFilter;
    this.#texture.generateMipmaps = false;
    this.#texture.flipY = false;
    this.#texture.needsUpdate = true;
    const { fx, fy, cx, cy } = intrinsics;
    const place = new Vector4();
    const uniforms = {
      image: { value: this.#texture },
      size: { value: new Vector2(...size) },
      pinhole: { value: new Vector4(fx, fy, cx, cy) },
      place: { value: place },
      model: { value: MODELS[distortion.model] ?? 0 },
      k: { value: Array.from({ length: 8 }, (_, i) => distortion.coefficients[i] ?? 0) },
    };
    const material = new ShaderMaterial({
      uniforms, vertexShader: VERTEX, fragmentShader: FRAGMENT, depthTest: false, depthWrite: false,
    });
    this.object = new Mesh(new PlaneGeometry(2, 2), material);
    this.object.frustumCulled = false;
    this.object.renderOrder = -1000;
    const pixels = new Vector2();
    this.object.onBeforeRender = (renderer: WebGLRenderer) => {
      const { x: width, y: height } = renderer.getSize(pixels);
      const { scale, left, top } = fitted(size, width, height);
      // From -1..1 across the canvas to pixels of the image, of which the first has its centre at 0.
      const [halfWidth, halfHeight] = [width / 2 / scale, height / 2 / scale];
      place.set(halfWidth, -halfHeight, halfWidth - left / scale - 0.5, halfHeight - top / scale - 0.5);
      material.uniformsNeedUpdate = true;
    };
  }

  dispose(): void {
    this.#texture.dispose();
    this.object.geometry.dispose();
    this.object.material.dispose();
  }
}
