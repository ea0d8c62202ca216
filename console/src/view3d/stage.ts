import {
  Box3,
  Color,
  DirectionalLight,
  HemisphereLight,
  MathUtils,
  PerspectiveCamera,
  Scene,
  Vector3,
  WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { h } from '../ui/dom';
import { CameraKeys } from './camera_keys';
import { projectionOf, standOf, type Pinhole } from './place/pinhole';
import { drawsInSoftware } from './renderer_kind';
import { Sharpness } from './sharpness';
import './view3d.css';

/** Direction from what is framed to the camera, and the share of the picture that it fills. */
const AWAY = new Vector3(0.35, -1, 0.55);
const FILL = 0.72;

/** A part of what a stage shows, which frees its memory at the GPU when it is disposed of. */
export interface Layer {
  readonly object: import('three').Object3D;
  dispose(): void;
}

export interface StageOptions {
  /** True if edges are smooth also while it moves on a slow machine: for small pictures that are looked at. */
  readonly isSmooth?: boolean;
}

/**
 * A picture in three dimensions, z up, in metres. It is drawn when something has changed, and with the
 * screen as long as a listener says that things move.
 */
export class Stage {
  /** The canvas, what is laid over it, and a description for those who do not see it. */
  readonly element: HTMLElement;
  readonly canvas: HTMLCanvasElement;
  /** Container of elements placed over the picture. */
  readonly overlay: HTMLElement;
  readonly scene = new Scene();
  readonly camera = new PerspectiveCamera(45, 1, 0.005, 200);
  readonly controls: OrbitControls;
  /** Frames that were drawn, and the time that the last one took on the CPU [ms]. */
  drawn = 0;
  drawMs = 0;

  readonly #renderer: WebGLRenderer;
  readonly #keys: CameraKeys;
  readonly #description = h('p', { class: 'visually-hidden' });
  readonly #resize: ResizeObserver;
  readonly #dark = matchMedia('(prefers-color-scheme: dark)');
  readonly #layers = new Set<Layer>();
  readonly #listeners = new Set<(now: number) => boolean>();
  readonly #sharpness: Sharpness;
  /** Points that the camera frames until the user moves it. */
  #framed: Vector3[] | null = null;
  /** The calibrated camera through which one looks until the view is moved, and the function called then. */
  #lens: { readonly pinhole: Pinhole; readonly left: () => void } | null = null;
  #request = 0;
  #disposed = false;

  /** `role` is `application` where the canvas handles keys. */
  constructor(label: string, role: 'img' | 'application' = 'img', { isSmooth = false }: StageOptions = {}) {
    this.canvas = h('canvas', { tabindex: 0, role, 'aria-label': label });
    this.overlay = h('div', { class: 'stage-overlay' });
    this.element = h('div', { class: 'stage' }, this.canvas, this.overlay, this.#description);
    this.#sharpness = new Sharpness(isSmooth);
    this.#renderer = rendererOf(this.canvas, isSmooth);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.addEventListener('change', this.invalidate);
    this.controls.addEventListener('start', () => this.unframe());
    this.controls.minDistance = 0.02;
    this.controls.maxDistance = 50;
    this.#keys = new CameraKeys(this, role === 'application');
    const sun = new DirectionalLight(0xffffff, 2);
    sun.position.set(0.5, -1, 2);
    this.scene.add(new HemisphereLight(0xffffff, 0x8a8f98, 1.6), sun);
    this.#resize = new ResizeObserver(this.#fit);
    this.#resize.observe(this.element);
    this.#dark.addEventListener('change', this.#paint);
    this.canvas.addEventListener('webglcontextrestored', this.invalidate);
    this.#paint();
  }

  /** True on a dark page. */
  get isDark(): boolean {
    return this.#dark.matches;
  }

  /** Shows a layer from now on; the stage disposes of it. */
  add<L extends Layer>(layer: L): L {
    this.#layers.add(layer);
    this.scene.add(layer.object);
    this.invalidate();
    return layer;
  }

  /** Shows a layer no more, and frees its memory. */
  remove(layer: Layer): void {
    if (!this.#layers.delete(layer)) return;
    this.scene.remove(layer.object);
    layer.dispose();
    this.invalidate();
  }

  /** Calls a listener before each frame; while one answers true, another frame follows. */
  beforeFrame(listener: (now: number) => boolean): void {
    this.#listeners.add(listener);
    this.invalidate();
  }

  /** Draws a frame soon. */
  readonly invalidate = (): void => {
    if (this.#request === 0 && !this.#disposed) this.#request = requestAnimationFrame(this.#frame);
  };

  /** Says what is seen. */
  describe(text: string): void {
    if (this.#description.textContent !== text) this.#description.textContent = text;
  }

  /** Frames points [M, 3] from the front and from above. */
  lookAt(points: Float32Array): void {
    const framed: Vector3[] = [];
    for (let i = 0; i + 2 < points.length; i += 3) {
      const point = new Vector3().fromArray(points, i);
      if (Number.isFinite(point.x + point.y + point.z)) framed.push(point);
    }
    if (framed.length === 0) return;
    this.unframe();
    this.#framed = framed;
    this.#look();
  }

  /**
   * Looks as a calibrated camera did, so that its image fits what is drawn, and calls `left` once the view is moved.
   * The camera then turns around the place on its axis that is nearest to `around`.
   */
  lookThrough(pinhole: Pinhole, around: Vector3, left: () => void): void {
    this.unframe();
    const { position, turn } = standOf(pinhole);
    this.camera.position.copy(position);
    this.camera.quaternion.copy(turn);
    const ahead = new Vector3(0, 0, -1).applyQuaternion(turn);
    const distance = Math.max(around.clone().sub(position).dot(ahead), 0.05);
    this.controls.target.copy(position).addScaledVector(ahead, distance);
    this.#lens = { pinhole, left };
    this.#project();
    this.invalidate();
  }

  /** Place and target of the camera, for an address. */
  get view(): string {
    const { position } = this.camera;
    return [...position.toArray(), ...this.controls.target.toArray()].map((x) => x.toFixed(4)).join(',');
  }

  /** Sets the place of the camera from a text; false if the text is invalid. */
  setView(text: string): boolean {
    const numbers = text.split(',').map(Number);
    if (numbers.length !== 6 || !numbers.every((x) => Number.isFinite(x) && Math.abs(x) < 1000)) return false;
    this.unframe();
    this.camera.position.fromArray(numbers);
    this.controls.target.fromArray(numbers, 3);
    this.controls.update();
    this.invalidate();
    return true;
  }

  /** Draws immediately, with all pixels. The canvas keeps that until the end of this task only. */
  drawNow(): void {
    this.#sharpness.restore();
    this.#resizeCanvas();
    this.#draw();
  }

  /** The current picture as a PNG. */
  picture(): Promise<Blob> {
    this.drawNow();
    return new Promise((resolve, reject) => {
      this.canvas.toBlob((blob) => (blob === null ? reject(new Error('no picture was made')) : resolve(blob)));
    });
  }

  /** Number of pixels of the page from the canvas's left and top at which a point is seen; null behind the camera. */
  project(point: Vector3): { x: number; y: number } | null {
    const seen = point.clone().project(this.camera);
    if (seen.z > 1) return null;
    const { clientWidth, clientHeight } = this.canvas;
    return { x: ((seen.x + 1) / 2) * clientWidth, y: ((1 - seen.y) / 2) * clientHeight };
  }

  /** Objects and textures in the GPU's memory, for tests of what is freed. */
  get memory(): { geometries: number; textures: number } {
    return this.#renderer.info.memory;
  }

  /** The camera is moved: it does not go back by itself. */
  unframe(): void {
    this.#framed = null;
    const lens = this.#lens;
    this.#lens = null;
    if (lens === null) return;
    this.#project();
    this.controls.update();
    lens.left();
  }

  /** Frees everything. */
  dispose(): void {
    this.#disposed = true;
    cancelAnimationFrame(this.#request);
    this.#resize.disconnect();
    this.#dark.removeEventListener('change', this.#paint);
    this.#keys.dispose();
    this.controls.dispose();
    this.#listeners.clear();
    for (const layer of this.#layers) {
      this.scene.remove(layer.object);
      layer.dispose();
    }
    this.#layers.clear();
    this.#renderer.dispose();
    this.#renderer.forceContextLoss();
  }

  /** Stands where all that is framed fills the picture, but for a margin in which it can move. */
  #look(): void {
    const points = this.#framed;
    if (points === null) return;
    const middle = new Box3().setFromPoints(points).getCenter(new Vector3());
    const away = AWAY.clone().normalize();
    const right = new Vector3().crossVectors(this.camera.up, away).normalize();
    const up = new Vector3().crossVectors(away, right);
    const high = FILL * Math.tan(MathUtils.degToRad(this.camera.fov / 2));
    const wide = high * this.camera.aspect;
    const distance = points.reduce((most, point) => {
      const p = point.clone().sub(middle);
      return Math.max(most, p.dot(away) + Math.max(Math.abs(p.dot(right)) / wide, Math.abs(p.dot(up)) / high));
    }, 0.08);
    this.controls.target.copy(middle);
    this.camera.position.copy(middle).addScaledVector(away, distance);
    this.controls.update();
    this.invalidate();
  }

  /** Projects as the shape of the picture and the camera that one looks through want it. */
  #project(): void {
    const { clientWidth: width, clientHeight: height } = this.element;
    if (width === 0 || height === 0) return;
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (this.#lens === null) return;
    this.camera.projectionMatrix.copy(projectionOf(this.#lens.pinhole, width, height, this.camera));
    this.camera.projectionMatrixInverse.copy(this.camera.projectionMatrix).invert();
  }

  readonly #frame = (now: number): void => {
    this.#request = 0;
    let moves = false;
    // Drawing would do this only after listeners have asked where points are seen.
    this.camera.updateMatrixWorld();
    for (const listener of this.#listeners) moves = listener(now) || moves;
    if (this.#sharpness.next(now, moves)) this.#resizeCanvas();
    this.#draw();
    if (moves || !this.#sharpness.isFull) this.invalidate();
  };

  #draw(): void {
    const begun = performance.now();
    this.#renderer.render(this.scene, this.camera);
    this.drawMs = performance.now() - begun;
    this.drawn += 1;
  }

  readonly #fit = (): void => {
    const { clientWidth: width, clientHeight: height } = this.element;
    if (width === 0 || height === 0) return;
    this.#project();
    this.#look();
    this.#resizeCanvas();
    // A canvas whose size has changed is empty until it is drawn; what lies over it follows with the next frame.
    this.#draw();
    this.invalidate();
  };

  #resizeCanvas(): void {
    const { clientWidth: width, clientHeight: height } = this.element;
    this.#renderer.setPixelRatio(this.#sharpness.ratio(devicePixelRatio));
    this.#renderer.setSize(width, height, false);
  }

  readonly #paint = (): void => {
    this.scene.background = new Color(this.isDark ? 0x262d35 : 0xeceff2);
    this.invalidate();
  };
}

/** Renderer of a canvas; throws, in words for people, if there is none. */
function rendererOf(canvas: HTMLCanvasElement, isSmooth: boolean): WebGLRenderer {
  try {
    return new WebGLRenderer({ canvas, antialias: isSmooth || !drawsInSoftware() });
  } catch {
    throw new Error('This browser cannot draw in three dimensions: WebGL 2 is missing or switched off in it.');
  }
}
