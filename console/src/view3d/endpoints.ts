import { DataTexture, FloatType, NearestFilter, RGBAFormat } from 'three';

/** Texels of a row of the texture. */
export const ROW = 1024;

/**
 * Endpoints of springs and triplets, nodes and then control points, as a texture: lines between them
 * are drawn from it, so that nothing but their places is sent to the GPU when they move.
 */
export class Endpoints {
  readonly texture: DataTexture;
  readonly #texels: Float32Array<ArrayBuffer>;

  constructor(
    readonly nodes: number,
    readonly controls: number,
  ) {
    const rows = Math.max(1, Math.ceil((nodes + controls) / ROW));
    this.#texels = new Float32Array(4 * ROW * rows);
    this.texture = new DataTexture(this.#texels, ROW, rows, RGBAFormat, FloatType);
    this.texture.magFilter = NearestFilter;
    this.texture.minFilter = NearestFilter;
  }

  /** Places nodes [N, 3] and control points [C, 3]; those that hold nothing are not shown. */
  place(nodes: Float32Array, controls: Float32Array, holds: (control: number) => boolean): void {
    for (let i = 0; i < this.nodes; i += 1) this.#set(i, nodes, i, 1);
    for (let c = 0; c < this.controls; c += 1) this.#set(this.nodes + c, controls, c, holds(c) ? 1 : 0);
    this.texture.needsUpdate = true;
  }

  dispose(): void {
    this.texture.dispose();
  }

  #set(texel: number, points: Float32Array, point: number, shown: number): void {
    const [to, from] = [4 * texel, 3 * point];
    this.#texels[to] = points[from]!;
    this.#texels[to + 1] = points[from + 1]!;
    this.#texels[to + 2] = points[from + 2]!;
    this.#texels[to + 3] = shown;
  }
}
