// Small helpers for text and DOM.

type Child = Node | string | null | undefined | false;

export function el<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  attributes: Record<string, string> = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  const e = document.createElement(tag);
  for (const [k, v] of Object.entries(attributes)) e.setAttribute(k, v);
  for (const c of children) if (c) e.append(c);
  return e;
}

/** Three significant digits, no exponent between 0.001 and 1e6; a real minus sign. */
export function num(x: number | null | undefined, digits = 3): string {
  if (x === null || x === undefined || !Number.isFinite(x)) return 'n/a';
  if (x === 0) return '0';
  const a = Math.abs(x);
  const s =
    a >= 1e6 || a < 1e-3
      ? x.toExponential(digits - 1)
      : x.toFixed(Math.max(0, Math.min(6, digits - 1 - Math.floor(Math.log10(a)))));
  return s.replace('-', '\u2212').replace(/e\u2212/, 'e\u2212');
}

/** Fixed number of decimals with a real minus sign; what rounds to zero has no sign. */
export function fixed(x: number, decimals: number): string {
  const s = x.toFixed(decimals);
  return Number(s) === 0 ? s.replace('-', '') : s.replace('-', '\u2212');
}

export const words = (name: string): string => name.replace(/_/g, ' ');

export const unitText = (unit: string): string =>
  ({ '1': '', 'N m': 'N\u00b7m', Nm: 'N\u00b7m', deg: '\u00b0', rad: 'rad', 'm/s^2': 'm/s\u00b2' })[unit] ?? unit;

const isNumber = (c: string | Node | undefined): boolean => c instanceof HTMLElement && c.className === 'number';

export function table(head: string[], rows: (string | Node)[][], className = ''): HTMLElement {
  const t = el('table', { class: className });
  t.append(el('thead', {}, el('tr', {}, ...head.map((h, k) => el('th', isNumber(rows[0]?.[k]) ? { class: 'right' } : {}, h)))));
  const body = el('tbody');
  for (const r of rows) body.append(el('tr', {}, ...r.map((c) => el('td', {}, c))));
  t.append(body);
  return el('div', { class: 'scroll' }, t);
}

export function details(title: string, ...content: Child[]): HTMLElement {
  return el('details', {}, el('summary', {}, title), ...content);
}

export function section(title: string, note: string, ...content: Child[]): HTMLElement {
  return el('section', {}, el('h2', {}, title), note ? el('p', { class: 'note' }, note) : null, ...content);
}

/** Value of a CSS variable of the page. */
export const css = (name: string): string => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
