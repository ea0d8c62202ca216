import { h } from '../../ui/dom';

/** Saves a file from the page. */
export function download(content: Blob, name: string): void {
  const address = URL.createObjectURL(content);
  h('a', { href: address, download: name }).click();
  // The browser has taken hold of it by then.
  setTimeout(() => URL.revokeObjectURL(address), 60_000);
}

/** A name of a file from one that people gave: letters, digits and hyphens. */
export function fileName(name: string, extension: string): string {
  const plain = name.normalize('NFKD').replace(/[^\p{L}\p{N}]+/gu, '-').replace(/^-+|-+$/g, '').slice(0, 60);
  return `${plain || 'twin'}.${extension}`;
}
