/** A canvas that was cleared, in pixels of the page; null while it has no size. */
export function begun(canvas: HTMLCanvasElement, height: number): { context: CanvasRenderingContext2D; width: number } | null {
  const context = canvas.getContext('2d');
  const width = canvas.clientWidth;
  if (context === null || width === 0) return null;
  canvas.width = Math.round(width * devicePixelRatio);
  canvas.height = Math.round(height * devicePixelRatio);
  context.scale(devicePixelRatio, devicePixelRatio);
  return { context, width };
}

/** Calls `point` with the place of a pressed pointer, as a share of an element's width from its left edge. */
export function onPressed(element: HTMLElement, point: (share: number) => void): void {
  const tell = (event: PointerEvent): void => {
    const { left, width } = element.getBoundingClientRect();
    point((event.clientX - left) / Math.max(width, 1));
  };
  element.addEventListener('pointerdown', (event) => {
    element.setPointerCapture(event.pointerId);
    tell(event);
  });
  element.addEventListener('pointermove', (event) => {
    if (element.hasPointerCapture(event.pointerId)) tell(event);
  });
}
