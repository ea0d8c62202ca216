import { BRUSHES, type Part } from './strokes';

/** Something that a key of the masks page does. */
export type Command = Part | 'undo' | 'redo' | 'larger' | 'smaller' | 'toggle' | 'back' | 'on';

const OTHERS: Readonly<Record<string, Command>> = {
  '+': 'larger',
  '-': 'smaller',
  ',': 'back',
  '.': 'on',
  ' ': 'toggle',
};

/** The command of a key, or null; `onControl` is true where a control takes keys itself, `onText` where it takes text. */
export function commandOf(
  event: Pick<KeyboardEvent, 'key' | 'ctrlKey' | 'metaKey' | 'altKey' | 'shiftKey'>,
  { onControl, onText }: { readonly onControl: boolean; readonly onText: boolean },
): Command | null {
  if (event.altKey || onText) return null;
  const key = event.key.toLowerCase();
  if (event.ctrlKey || event.metaKey) {
    if (key === 'z') return event.shiftKey ? 'redo' : 'undo';
    return key === 'y' ? 'redo' : null;
  }
  const brush = BRUSHES.find((own) => own.key === key);
  if (brush !== undefined) return brush.part;
  const other = OTHERS[key] ?? null;
  return other === 'toggle' && onControl ? null : other;
}

/** What has the focus, for `commandOf`. */
export function focusOf(target: EventTarget | null): { onControl: boolean; onText: boolean } {
  const element = target instanceof Element ? target : null;
  return {
    onControl: element?.closest('button, input, select, textarea, a, summary, dialog') != null,
    onText: element?.closest('input:not([type="range"], [type="checkbox"]), select, textarea, dialog') != null,
  };
}
