/** What a key of the page does: play or pause, go one frame back or on, or show the camera of this number, from 0. */
export type KeyAction = 'toggle' | 'back' | 'on' | number;

/** The keys of a page with this number of cameras, in words. */
export function keysText(cameras: number): string {
  const choose = cameras > 1 ? `, 1 to ${Math.min(cameras, 9)} choose a camera` : '';
  return `Space plays, comma and full stop step${choose}`;
}

/** What a key does; null for those of controls, which stay theirs. */
export function keyOf(event: KeyboardEvent): KeyAction | null {
  if (event.ctrlKey || event.metaKey || event.altKey) return null;
  const target = event.target as HTMLElement | null;
  if (target?.closest('input:not([type="range"], [type="checkbox"]), select, textarea, dialog') != null) return null;
  if (event.key === ',') return 'back';
  if (event.key === '.') return 'on';
  if (/^[1-9]$/.test(event.key)) return Number(event.key) - 1;
  if (event.key === ' ' && target?.closest('button, input:not([type="range"]), a, summary') == null) return 'toggle';
  return null;
}
