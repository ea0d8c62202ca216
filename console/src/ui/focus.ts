/** Redraws something; the control that had the focus, known by its address or its text, gets it again. */
export function keepingFocus(content: HTMLElement, draw: () => void): void {
  const focused = document.activeElement;
  const wanted = focused instanceof HTMLElement && content.contains(focused) ? labelOf(focused) : null;
  draw();
  if (wanted === null) return;
  const controls = [...content.querySelectorAll<HTMLElement>('a, button, input, [tabindex]')];
  controls.find((control) => labelOf(control) === wanted)?.focus({ preventScroll: true });
}

/** Words by which a control is found again: marks that change, as that of an order, do not count. */
function labelOf(control: HTMLElement): string {
  const label = control.getAttribute('href') ?? control.getAttribute('aria-label');
  return `${control.tagName} ${label ?? control.firstChild?.textContent ?? ''}`;
}
