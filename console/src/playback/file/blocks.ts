/** Things that are loaded in blocks of neighbours: each block once, and again if it failed. */
export class Blocks<T> {
  readonly #loaded = new Map<number, T>();
  readonly #loading = new Map<number, Promise<T>>();

  /** `size` neighbours are a block; at most `most` blocks are kept, the latest used. */
  constructor(
    readonly size: number,
    private readonly most: number,
    private readonly load: (block: number) => Promise<T>,
    private readonly release: (value: T) => void = () => undefined,
  ) {}

  /** The block of an index if it is here. */
  peek(index: number): T | undefined {
    const block = Math.floor(index / this.size);
    const value = this.#loaded.get(block);
    if (value === undefined) return undefined;
    // The latest used stand last.
    this.#loaded.delete(block);
    this.#loaded.set(block, value);
    return value;
  }

  /** The block of an index. */
  get(index: number): Promise<T> {
    const block = Math.floor(index / this.size);
    const known = this.peek(index);
    if (known !== undefined) return Promise.resolve(known);
    const under = this.#loading.get(block);
    if (under !== undefined) return under;
    const loading = this.load(block).then((value) => {
      this.#loaded.set(block, value);
      this.#makeRoom();
      return value;
    }).finally(() => this.#loading.delete(block));
    this.#loading.set(block, loading);
    return loading;
  }

  /** Forgets all. */
  clear(): void {
    for (const value of this.#loaded.values()) this.release(value);
    this.#loaded.clear();
  }

  #makeRoom(): void {
    for (const [block, value] of this.#loaded) {
      if (this.#loaded.size <= this.most) return;
      this.#loaded.delete(block);
      this.release(value);
    }
  }
}
